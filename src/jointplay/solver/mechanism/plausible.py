"""Plausibility of numbers: impossible mechanisms are refused, rare ones are doubted.

Each names the likely unit. Whether a number can stand in a field at all is said by the field's own type; here
numbers are judged beside each other, and by the size that linkages, motors and materials have. `Mechanism`
asks for `nonsense` when it is built, each analysis for `doubts`, and for `turning`, whether a crank can go
where it is driven. A mechanism with ``as_meant`` is doubted in nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from jointplay.display.accepted import bounds_of, units_of
from jointplay.display.errors import Problem, join
from jointplay.display.number_text import typed
from jointplay.solver.equations.own.grammar import number, parse
from jointplay.solver.mechanism.base import GROUND, LONG, Record, in_degrees, in_millimetres
from jointplay.solver.mechanism.measures import SMALLEST

RPM = math.tau / 60  # rad/s
WIDE = 0.1  # of the shortest link: a wider clearance is seldom meant
MAINS = 400.0  # rad/s: no motor on mains of 60 Hz turns faster than 377 rad/s, 3600 rpm
FAST = 1000.0  # rad/s, 9549 rpm: few cranks turn faster
BRISK, ROUND = 250.0, 10.0  # rad/s: from here on whole tens are seldom meant but as rpm
HURRY = 5.0  # times the drive's own speed: below the 9.55 that rpm are of rad/s
SUNK = 1.0  # clearances: a journal seldom starts deeper in its bearing
AIR, SLENDER = 1.2, 20  # kg/m³; lengths over thickness of the thinnest rod that is seldom doubted
LEAD, BULK = 11340.0, 3  # kg/m³; lengths of a link, up to the longest, in the largest block that it may be
ASIDE, APART = 2.5, 100.0  # lengths from a link's middle to its mass centre: seldom more; never
ROUNDABOUT = 5.0  # lengths: a radius of gyration is seldom more, and never APART
UNLIKE, OFF = 0.3, 0.1  # of what a shape gives; of the length: a weighed link is seldom as far from its shape
SOFT = 10.0  # times softer than the softest that pin and bush give, or stiffer than the stiffest: seldom
BALLAST = 100.0  # times a link's own mass: a point mass is seldom more
OUTSIDE = 10.0  # clearances: no journal is as far from its bearing's centre
# least, most and likely units of what elastic links are made of
MATERIALS = {"modulus": (1e7, 2e12, {"GPa": 1e9, "MPa": 1e6}), "density": (50.0, 25e3, {"g/cm³": 1e3})}
EARTH, HEAVY = 9.81, 100.0  # m/s²
GRIP = 2.0  # coefficient of friction: rubber on dry concrete has some 1
YIELDING = 0.1  # of a journal's radius: a bearing into which weight presses it deeper is seldom meant
STARRY = 1e6  # times as heavy as doubted: no matter is
_MOMENTS = {"kg cm²": 1e-4, "kg mm²": 1e-6, "g cm²": 1e-7, "g mm²": 1e-9}  # in kg m²
_LENGTHS = {"cm": 0.01, "mm": 1e-3}
_MASSES = {"g": 1e-3, "mg": 1e-6}


def nonsense(mechanism: Any) -> Iterator[Problem]:
    """Yield the problems of a linkage that cannot be, with keys of the mechanism; its parts are valid."""
    if sizes := [*_sizes(mechanism)]:
        yield from sizes
        return
    yield from (problem for certain, problem in _links(mechanism) if certain)
    for i, joint in enumerate(mechanism.joints):
        if joint.friction and joint.friction.law == "lugre" and not joint.friction.coefficient:
            text = "a coefficient greater than 0 is accepted with lugre: bristles without load do not bend"
            yield Problem(f"joints[{i}].friction.coefficient", 0.0, text)
    drive = mechanism.drive
    if getattr(drive, "kind", "") == "servo" and drive.speed * drive.nominal_speed < 0:
        text = f"a speed of the sign of the mean wanted one ({drive.speed:g} rad/s) is accepted"
        yield Problem("drive.nominal_speed", drive.nominal_speed, text)


def _sizes(mechanism: Any) -> Iterator[Problem]:
    """Numbers whose products overflow or, where they cannot be 0, underflow."""
    for key, value, units, positive in _numbers(mechanism, ""):
        least = SMALLEST if positive else 0.0
        if not least <= abs(value) <= 1 / SMALLEST:
            unit = "" if units in (None, "1") else f" {units}"
            size = f"between {typed(SMALLEST)} and {typed(1 / SMALLEST)}{unit} in size"
            yield Problem(key, value, f"a number {size} is accepted")


def too_wide(clearance: float, links: Sequence[Any]) -> str:
    """Message on a clearance no shorter than a link; empty where it is shorter."""
    shortest = min(links, key=lambda link: link.length, default=None)
    if shortest is None or clearance < shortest.length:
        return ""
    meant = in_millimetres(clearance) if clearance / 1000 < shortest.length else ""
    return f"a clearance less than {shortest.length:g} m is accepted, the length of {shortest.name}{meant}"


def doubts(
    mechanism: Any,
    initial: Any = None,
    section: Any = None,
    apart: Mapping[str, float] | None = None,
    wound: Mapping[str, float] | None = None,
) -> Iterator[Problem]:
    """Yield doubts about a valid mechanism, start and section, with keys of an analysis.

    Of a system of equations, which may be dimensionless, only states that grow for ever are doubted.

    Parameters
    ----------
    mechanism, initial, section
        As of an analysis.
    apart : mapping of str to float, optional
        Distances of journals from their bearings' centres at the start, m, by joint.
    wound : mapping of str to float, optional
        Angles by which torsion springs are wound at the start, rad, by key.
    """
    if mechanism is None or mechanism.as_meant:
        return
    if not hasattr(mechanism, "links"):
        yield from _endless(mechanism)
        return
    found = [problem for certain, problem in _links(mechanism) if not certain]
    own = (_lengths, _turned, _pulled_or_rubbed, _unlike_its_shape, _unlike_its_parts, _played, _fast)
    for doubted in own:
        found += doubted(mechanism)
    found += [_wound(key, angle) for key, angle in (wound or {}).items() if abs(angle) > math.pi]
    yield from (replace(problem, key=join("mechanism", problem.key)) for problem in found)
    if isinstance(initial, Mapping):
        yield from _start(mechanism, initial, apart or {})
    if getattr(section, "kind", "") == "plane" and section.quantity == "angle":
        yield from _over_a_turn([("section.value", section.value)])
    most = OUTSIDE * max((joint.clearance for joint in mechanism.clearance_joints), default=math.inf)
    if getattr(section, "quantity", "") == "eccentricity" and section.value > most:
        meant = _meant(section.value, {"µm": 1e-6, "mm": 1e-3}, 0.0, most)
        yield Problem("section.value", section.value, f"no journal is {OUTSIDE:g} clearances out{meant}")


@cache
def _fields(kind: type[Record]) -> list[tuple[str, str, str | None, bool]]:
    """Name, key, units of every field of a kind of record, and whether it takes positive numbers alone."""
    fields = kind.model_fields.items()
    return [(n, each.alias or n, units_of(each), bounds_of(each).get("gt") == 0) for n, each in fields]


def _numbers(record: Any, root: str) -> Iterator[tuple[str, float, str | None, bool]]:
    """Key, value, units of every number of a record and its parts, and whether it must be above 0."""
    for name, word, units, positive in _fields(type(record)):
        value, key = getattr(record, name), root if name == "parts" else join(root, word)  # as files have it
        rows = [(key, value)]
        if isinstance(value, float):
            yield key, value, units, positive
            continue
        if isinstance(value, tuple):
            rows = [(join(key, f"[{i}]"), each) for i, each in enumerate(value)]
        if isinstance(value, dict):
            rows = [(join(key, str(inner)), each) for inner, each in value.items()]
        for place, each in rows:
            if isinstance(each, Record):
                yield from _numbers(each, place)
            elif isinstance(each, float):
                yield place, each, units, positive


def _in(mechanism: Any, unit: str, root: str = "") -> Iterator[tuple[str, float]]:
    """Key and value of every number of a record that is in this unit."""
    return ((key, value) for key, value, units, _ in _numbers(mechanism, root) if units == unit)


def _links(mechanism: Any) -> Iterator[tuple[bool, Problem]]:
    """Problems of masses, centres and moments of inertia; whether they are certain."""
    longest = max(link.length for link in mechanism.links)
    sliding = {
        pin.link for joint in mechanism.joints if joint.prismatic for pin in (joint.journal, joint.bearing)
    }
    for i, link in enumerate(mechanism.links):
        size = longest if link.name in sliding else link.length  # what slides has a length in name only
        yield from _mass(f"links[{i}]", link, size, math.inf if link.name in sliding else longest)
        yield from _aside(f"links[{i}].centre", link, link.centre, size)
        for j, point in enumerate(link.masses):
            yield from _aside(f"links[{i}].masses[{j}].at", link, point.at, size)
        yield from ((False, problem) for problem in _made_of(f"links[{i}]", link))
        yield from _inertia(f"links[{i}]", link, size)


def _mass(key: str, link: Any, size: float, longest: float) -> Iterator[tuple[bool, Problem]]:
    light = AIR * math.pi / 4 * link.length**3 / SLENDER**2
    heavy = LEAD * min(BULK * size, longest) ** 3
    if link.mass < light:
        text = f"that is lighter than the air in a rod {link.length:g} m long and a {SLENDER}th as thick"
        long = link.length > LONG
        meant = in_millimetres(link.length) if long else _meant(link.mass, {"kg": 1.0}, light, heavy)
        place = f"{key}.{'length' if long else 'mass'}"
        yield long, Problem(place, link.length if long else link.mass, text + meant)
    if link.mass > heavy:
        edge = f"{BULK} times as long, wide and high as {link.name}"
        edge = edge if BULK * size < longest else f"as long, wide and high as the longest link, {longest:g} m"
        text = f"that is heavier than a block of lead {edge}"
        meant = _meant(link.mass, _MASSES, light, heavy)
        yield link.mass > STARRY * heavy, Problem(f"{key}.mass", link.mass, text + meant)


def _aside(key: str, link: Any, at: float, size: float) -> Iterator[tuple[bool, Problem]]:
    off = abs(at - link.length / 2)
    if off > ASIDE * size:
        text = f"that is {off / size:.3g} lengths from the middle of {link.name}"
        meant = _meant(at, _LENGTHS, -0.5 * size, 1.5 * size)
        yield off > APART * size, Problem(key, at, text + meant)


def _inertia(key: str, link: Any, size: float) -> Iterator[tuple[bool, Problem]]:
    own = link.inertia_centre
    about, given = ("inertia", link.inertia) if own is None else ("inertia_centre", own)
    gyration = math.sqrt(max(0.0, given - (link.mass * link.centre**2 if own is None else 0.0)) / link.mass)
    if gyration > ROUNDABOUT * size:
        lengths = f"{gyration / size:.3g} times the length of {link.name}"
        text = f"that is a radius of gyration of {gyration:.3g} m, {lengths}"
        most = link.mass * size**2
        meant = _meant(given, _MOMENTS, 1e-3 * most, 2 * most)
        yield gyration > APART * size, Problem(f"{key}.{about}", given, text + meant)


def _made_of(key: str, link: Any) -> Iterator[Problem]:
    """Materials of a link with a shape or an elastic one, and point masses beside its own, that few have."""
    if link.shape:
        yield from _material(f"{key}.shape.material", link.shape.material)
    elif link.elastic:
        yield from _material(f"{key}.beam", link.beam)
    for j, point in enumerate(link.masses):
        yield from _unusual(f"{key}.masses[{j}].mass", point.mass, 0.0, BALLAST * link.mass, _MASSES)


def _material(key: str, of: Any) -> Iterator[Problem]:
    for name, row in MATERIALS.items():
        yield from _unusual(f"{key}.{name}", getattr(of, name), *row)


def _unusual(
    key: str, value: float, least: float, most: float, units: Mapping[str, float]
) -> Iterator[Problem]:
    if not least <= value <= most:
        text = f"hardly any part has that: {least:g} to {most:g} is usual here"
        yield Problem(key, value, text + _meant(value, units, least, most))


def _unlike_its_shape(mechanism: Any) -> Iterator[Problem]:
    """Masses, centres and moments of inertia given by hand that are far from those of the link's shape."""
    for i, link in enumerate(mechanism.links):
        if link.shape is None:
            continue
        numbers = link.shape.numbers(link.length)
        own = numbers["inertia_centre"] * link.mass / numbers["mass"]
        numbers |= {"inertia_centre": own, "inertia": own + link.mass * link.centre**2}
        for key, value in numbers.items():
            given, near = getattr(link, key), OFF * link.length if key == "centre" else UNLIKE * value
            if given is not None and abs(given - value) > near:
                text = f"the shape of {link.name} gives {typed(value, 4)}; the number given beside it is used"
                yield Problem(f"links[{i}].{key}", given, text)


def _unlike_its_parts(mechanism: Any) -> Iterator[Problem]:
    """Stiffnesses given by hand that are far beyond those of any pin and bush."""
    for i, joint in enumerate(mechanism.joints):
        if joint.data is None or joint.contact.stiffness is None:
            continue
        value, low, high, *_ = joint.data.secant
        k = joint.data.numbers(joint.contact.law, joint.contact.given)["stiffness"]
        share = joint.contact.stiffness / k
        if not low / value / SOFT <= share <= high / value * SOFT:
            text = f"pin and bush of {joint.name} give {typed(k, 4)}; the number given beside them is used"
            yield Problem(f"joints[{i}].contact.stiffness", joint.contact.stiffness, text)


def _meant(given: float, units: Mapping[str, float], least: float, most: float) -> str:
    """Ask for the unit in which a number would be usual; empty where there is none."""
    for unit, factor in units.items():
        if least <= given * factor <= most and factor != 1:
            return f"; did you mean {given:g} {unit}? Then write '{given:g} {unit}' or {given * factor:.6g}"
    return ""


def _lengths(mechanism: Any) -> Iterator[Problem]:
    for key, value in _in(mechanism, "m"):
        if abs(value) > LONG and not key.endswith((".clearance", ".radius", ".centre")):
            text = f"that is more than most linkages have ({LONG:g} m){in_millimetres(value)}"
            yield Problem(key, value, text)


def _turned(mechanism: Any) -> Iterator[Problem]:
    names = {link.name for link in mechanism.links}
    guessed = ((f"guess.{name}", angle) for name, angle in mechanism.guess.items() if name in names)
    yield from _over_a_turn((*_in(mechanism, "rad"), *guessed))
    still = {GROUND}
    guides = [{joint.journal.link, joint.bearing.link} for joint in mechanism.joints if joint.prismatic]
    for _ in guides:  # what slides on what does not turn
        still = still.union(*(ends for ends in guides if ends & still))
    for i, load in enumerate(mechanism.loads):
        if load.angle in still:
            text = f"{load.angle} slides and does not turn, so that the load does not vary"
            yield Problem(f"loads[{i}].angle", load.angle, text)


def _over_a_turn(angles: Iterable[tuple[str, float]]) -> Iterator[Problem]:
    return (Problem(key, each, in_degrees(each)) for key, each in angles if abs(each) > math.tau)


def _pulled_or_rubbed(mechanism: Any) -> Iterator[Problem]:
    """Gravity and coefficients of friction that no place and no pair of materials has."""
    if abs(gravity := mechanism.gravity) > HEAVY:
        text = f"that is {abs(gravity) / EARTH:.4g} times that of the Earth, {EARTH} m/s²"
        yield Problem("gravity", gravity, text + _meant(gravity, {"mm/s²": 1e-3}, -HEAVY, HEAVY))
    for key, value in _in(mechanism, "1"):
        if key.endswith(".friction.coefficient") and value > GRIP:
            text = f"that is more than most pairs of materials have ({GRIP:g})"
            yield Problem(key, value, text + _meant(value, {"%": 0.01}, 0, GRIP))


def _played(mechanism: Any) -> Iterator[Problem]:
    """Sizes and contacts of joints that do not suit the links, or the data beside them."""
    lengths = [link.length for link in mechanism.links]
    length, longest = min(lengths), max(lengths)
    weight = min(abs(mechanism.gravity), HEAVY) * sum(link.mass for link in mechanism.links)
    for i, joint in enumerate(mechanism.joints):
        if (joint.radius or 0.0) > longest:
            text = f"that is longer than every link, {longest:g} m at most{in_millimetres(joint.radius)}"
            yield Problem(f"joints[{i}].radius", joint.radius, text)
        if joint.clearance > WIDE * length or joint.clearance > (joint.radius or math.inf):
            pin = f" and {joint.clearance / joint.radius:.2g} of the journal's radius" if joint.radius else ""
            text = f"that is {joint.clearance / length:.2g} of the shortest link{pin}"
            text += in_millimetres(joint.clearance)
            yield Problem(f"joints[{i}].clearance", joint.clearance, text)
        for end in ("pin", "bush") if joint.data else ():
            yield from _material(f"joints[{i}].contact.{end}", getattr(joint.contact.parts, end))
        if joint.data and joint.data.crushed and joint.contact.parts.load:
            yield Problem(f"joints[{i}].contact.load", joint.data.load, joint.data.crushed)
        if not joint.ideal and joint.contact.stiffness:
            yield from _soft(f"joints[{i}].contact.stiffness", joint, weight)
        if joint.fit and joint.limits.least < 0:
            text = f"{joint.limits}: some pins have no clearance; {joint.clearance:g} m is the mean of all"
            yield Problem(f"joints[{i}].fit", joint.fit, text)


def _soft(key: str, joint: Any, weight: float) -> Iterator[Problem]:
    """A contact into which the mere weight of the links sinks; of most laws F = K u^n."""
    K, n = joint.contact.stiffness, joint.contact.parameters.get("exponent", 1.0)
    depth, size = (weight / K) ** (1 / n), joint.radius or joint.half_height
    if depth > YIELDING * size:
        text = f"the weight of the links, {weight:.3g} N, presses so soft a contact in by {depth:.3g} m"
        units = {"N/µm": 1e6, "N/mm": 1e3} if n == 1 else {}
        yield Problem(key, K, text + _meant(K, units, weight / (YIELDING * size), math.inf))


def _fast(mechanism: Any) -> Iterator[Problem]:
    if (drive := mechanism.drive) is None:
        return
    if drive.kind == "motor":
        if drive.synchronous_speed > MAINS:
            why = "faster than any motor on the mains (3600 rpm)"
            yield _in_rpm("drive.synchronous_speed", drive.synchronous_speed, why)
        return
    for key, value in _in(drive, "rad/s", "drive"):
        rounded = abs(value) >= BRISK and value % ROUND == 0
        if (abs(value) > FAST or rounded) and not key.endswith("frequency"):
            why = "faster than most cranks turn" if abs(value) > FAST else "a brisk speed"
            yield _in_rpm(key, value, why)


def _in_rpm(key: str, speed: float, why: str) -> Problem:
    meant = f"if {speed:g} rpm are meant, write '{speed:g} rpm' or {speed * RPM:.6g}"
    return Problem(key, speed, f"{speed:g} rad/s are {speed / RPM:.5g} rpm, {why}; {meant}")


def _wound(key: str, angle: float) -> Problem:
    turns = "angles of links are counted from the start, where they lie within half a turn of 0"
    text = f"the spring starts wound by {math.degrees(angle):.4g} deg, more than half a turn: {turns}"
    return Problem(key, f"{angle:.4g} rad", f"{text}; is a turn to be added or taken off?")


def _start(mechanism: Any, initial: Mapping[str, Any], apart: Mapping[str, float]) -> Iterator[Problem]:
    own = abs(mechanism.drive.nominal_speed) if mechanism.drive else math.inf
    speed = initial.get("crank_speed")
    if speed is not None and abs(speed) > HURRY * own:
        yield _in_rpm("initial.crank_speed", speed, f"{abs(speed) / own:.3g} times what the drive turns at")
    angles = (initial.get("angle") or {}).items()
    yield from _over_a_turn((f"initial.angle.{name}", angle) for name, angle in angles)
    clearances = {joint.name: joint.clearance for joint in mechanism.clearance_joints}
    for name, distance in apart.items():
        depth = distance / clearances[name] - 1
        if depth > SUNK:
            text = f"the journal of {name} starts {depth:.3g} clearances deep in its bearing"
            yield Problem("initial.angle", dict(initial["angle"]), f"{text}: has a digit been lost?")


def _endless(system: Any) -> Iterator[Problem]:
    """States that nothing but time moves, and nothing sets back: they grow for ever."""
    flat, (positions, speeds) = system.flat(), system.order
    touched = {state for part in (*flat.jumps, *flat.impacts) for state in part.jump} | system.mass.keys()
    touched |= {name for each in flat.friction for name in parse(each.speed).names}
    if flat.contacts or flat.impacts:
        touched |= {*speeds[: len(positions)]}
    for name in flat.rates.keys() - touched - {*system.kept}:
        text = flat.rates[name]
        if parse(text).names <= system.numbers.keys() and number(text, system.numbers):
            rate = f"({text})" if parse(text).parts else text
            instead = f"if it is a phase, write {rate}*t for it, and its period as forcing = '2*pi/{rate}'"
            yield Problem(f"mechanism.rates.{name}", text, f"the state {name} grows without bound; {instead}")
