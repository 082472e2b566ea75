"""What changes nothing in a motion but its description: of each, what becomes of inputs and of outputs.

A transformation takes a mechanism and its start to those of the same motion seen otherwise: in a mirror,
turned, in other units of length, time and mass, under other names in another order, a turn of the crank
before. What is scaled follows from the units that records declare: a new number or law joins by itself.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pint

import jointplay as jp
from jointplay.analysis.quantities import WORDS
from jointplay.display.accepted import units_of
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.start import start

Start = dict[str, Any]
UNITS = pint.UnitRegistry()


@dataclass(frozen=True)
class Transformation:
    """Another view of a motion.

    Parameters
    ----------
    inputs : callable
        Of a mechanism and its start, those of the other view.
    seen : callable
        Of a word, the values over (time, label) of all words and the labels, its values in the other view.
    time : float
        By what times are multiplied.
    states : callable
        Of a state's name, the factor that its differences have in the other view; none where they mix.
    names : callable
        The other view's name of a part.
    """

    inputs: Callable[[jp.Mechanism, Start], tuple[jp.Mechanism, Start]]
    seen: Callable[..., np.ndarray] = lambda word, values, labels=(): values[word]
    time: float = 1.0
    names: Callable[[str], str] = lambda name: name
    states: Callable[[str], float] | None = None


STATES = {  # units of states by how their names begin
    "theta": "rad",
    "w": "rad/s",
    "x": "m",
    "y": "m",
    "vx": "m/s",
    "vy": "m/s",
    "slide": "m",
    "vslide": "m/s",
    "eta": "m kg**0.5",
    "deta": "m kg**0.5 / s",
    "zeta": "m kg**0.5",
    "dzeta": "m kg**0.5 / s",
    "approach": "m/s",
    "bristle": "m",
    "guess": "rad",
}


# Scales: every number by its unit


@cache
def exponents(unit: str) -> tuple[float, float, float]:
    """Of length, time and mass."""
    text = re.sub(r"([A-Za-z])(-?\d)", r"\1**\2", unit.replace("²", "2").replace("³", "3"))
    text = text.replace(" / ", "/")
    dimension = UNITS.parse_expression(text.replace(" ", "*")).dimensionality if unit != "1" else {}
    return tuple(float(dimension.get(f"[{name}]", 0)) for name in ("length", "time", "mass"))


def factor(unit: str, scale: tuple[float, float, float], power: float = 1.0) -> float:
    """By what a number of this unit is multiplied."""
    return math.prod(s ** (power * k) for s, k in zip(scale, exponents(unit), strict=True))


def rescaled(record: Record, scale: tuple[float, float, float], units: str = "") -> Record:
    """A record with all numbers in other units; `units` are those of the course that it is a part of."""
    units, law = getattr(type(record), "units", units), None
    if isinstance(record, jp.Contact):
        law = LAWS[record.law].numbers
    changed: dict[str, Any] = {}
    for name, field in type(record).model_fields.items():
        value = getattr(record, name)
        unit = units_of(field)
        if isinstance(value, Record):
            changed[name] = rescaled(value, scale, units)
        elif isinstance(value, tuple) and value and isinstance(value[0], Record):
            changed[name] = tuple(rescaled(each, scale, units) for each in value)
        elif name == "stiffness" and law and name in law and law[name].units == "1":  # N/m^n
            n = record.numbers["exponent"]
            changed[name] = value * factor("N", scale) / scale[0] ** n
        elif name == "parameters" and law:
            own = {key: x for key, x in record.numbers.items() if key not in ("stiffness", "damping")}
            changed[name] = {key: x * factor(law[key].units, scale) for key, x in own.items()}  # all of them
        elif value is not None and any(exponents(unit := units if unit == "N or N m" else unit or "1")):
            many = tuple(x * factor(unit, scale) for x in value) if isinstance(value, tuple) else None
            changed[name] = value * factor(unit, scale) if many is None else many
        else:
            changed[name] = value
    if isinstance(record, jp.Friction):
        own = FRICTIONS[record.law].numbers
        changed |= {key: getattr(record, key) * factor(each.units, scale) for key, each in own.items()}
    if isinstance(record, jp.Servo):
        changed |= _fed(record, _in_units(scale), factor("N m", scale))
    return type(record)(**changed)


def _in_units(scale) -> dict[str, str]:
    T = scale[1]
    rates = {"angular_velocity": T, "wanted_velocity": T, "wanted_acceleration": T**2}
    return {"t": f"(t/{T!r})"} | {word: f"({word}*{by!r})" for word, by in rates.items()}


def _fed(servo, words: Mapping[str, str], times: float) -> dict[str, Any]:
    """What a servo feeds forward with other words for its own, times a factor."""
    pattern = re.compile(r"\b(" + "|".join(words) + r")\b")
    other = lambda text: pattern.sub(lambda found: words[found[0]], text)  # noqa: E731
    where = {name: other(text) for name, text in servo.where.items()}
    return {
        "where": where,
        "feedforward": f"{times!r}*({other(servo.feedforward)})" if servo.feedforward else None,
    }


def scaled(length: float = 1.0, time: float = 1.0, mass: float = 1.0) -> Transformation:
    """Other units of length, time and mass."""
    scale = (length, time, mass)

    def inputs(mechanism, initial):
        speeds = {key: initial[key] / time for key in ("crank_speed",) if key in initial}
        if "angular_velocity" in initial:
            speeds["angular_velocity"] = {k: w / time for k, w in initial["angular_velocity"].items()}
        return rescaled(mechanism, scale), initial | speeds

    def states(name):
        return factor(STATES[name.partition("_")[0]], scale)

    return Transformation(
        inputs,
        lambda word, values, labels=(): values[word] * factor(WORDS[word].units, scale),
        time,
        states=states,
    )


# Mirror and turn: y to -y; everything turned by an angle

FLIPPED = {  # of what is turned over in a mirror
    *("angle", "angular_velocity", "angular_acceleration", "journal_y", "contact_angle"),
    *(
        "tangential_velocity",
        "tangential_force",
        "reaction_y",
        "reaction_moment",
        "deflection",
        "drive_torque",
    ),
}
VECTORS = {"journal_x": "journal_y", "reaction_x": "reaction_y"}
TURNED = ("angle", "contact_angle")


def _plain(mechanism) -> dict[str, Any]:
    return mechanism.model_dump()


def _pins(table) -> list[dict]:
    found = [joint[side] for joint in table["joints"] for side in ("journal", "bearing")]
    springs = [s for s in table["springs"] if s["kind"] == "extension"]
    found += [spring[side] for spring in springs for side in ("from", "to")]
    return found + [load["on"] for load in table["loads"] if load["kind"] == "force"]


def _waves(course, cosine, sine, shift: float = 0.0) -> None:
    """Multiply harmonics by signs, after their phase was shifted: f(φ − shift)."""
    for h in course["harmonics"]:
        a, b, n = h["cosine"], h["sine"], h["order"] * shift
        a, b = a * math.cos(n) - b * math.sin(n), a * math.sin(n) + b * math.cos(n)
        h["cosine"], h["sine"] = cosine * a, sine * b


def mirrored_inputs(mechanism, initial):
    """All in a mirror along x."""
    table = _plain(mechanism)
    for pin in _pins(table):
        pin["point"] = pin["point"] and (pin["point"][0], -pin["point"][1])
        pin["direction"] = -pin["direction"]
    table["gravity_direction"] = -table["gravity_direction"]
    table["branch"] = {"upper": "lower", "lower": "upper"}[table["branch"]]
    table["guess"] = {name: -angle for name, angle in table["guess"].items()}
    for spring in table["springs"]:
        if spring["kind"] == "torsion":
            spring["angle"] = -spring["angle"]
    for load in table["loads"]:
        sign, over = (1, load["angle"] is not None)
        if load["kind"] == "force":
            load["direction"] = -load["direction"]
        else:
            sign = -1
            load["constant"] = -load["constant"]
        _waves(load, sign, -sign if over else sign)
    drive = table["drive"]
    if drive:
        for key in ("speed", "nominal_speed", "start", "end", "constant"):
            if drive.get(key) is not None:
                drive[key] = -drive[key]
        if drive["kind"] == "torque":
            _waves(drive, -1, 1)
        if drive["kind"] in ("cycle", "servo"):
            _waves(drive, -1, -1)
        if drive["kind"] == "servo":
            own = ("angle", "angular_velocity", "wanted_angle", "wanted_velocity", "wanted_acceleration")
            drive |= _fed(mechanism.drive, {word: f"(-{word})" for word in own}, -1.0)
    return jp.Mechanism(**table), _started(initial, lambda x: -x, lambda w: -w)


def _started(initial: Start, angle, speed) -> Start:
    changes = {"crank_angle": angle, "crank_speed": speed, "angle": angle, "angular_velocity": speed}
    over = lambda f, x: {k: f(v) for k, v in x.items()} if isinstance(x, dict) else f(x)  # noqa: E731
    return {key: over(changes[key], value) for key, value in initial.items()}


CORNERS = {"upper": "lower", "lower": "upper"}


def _mirrored_name(name: str) -> str:
    head, _, tail = name.partition("_")
    side, _, end = tail.partition("_")
    return f"{head}_{CORNERS[side]}_{end}" if side in CORNERS else name


def _mirrored(word, values, labels=()):
    sign = -1.0 if word in FLIPPED else 1.0
    if word in ("tangential_velocity", "tangential_force"):  # of corners along the guide's line
        return values[word] * [1.0 if _mirrored_name(name) != name else sign for name in labels]
    return sign * values[word]


FLIPPED_STATES = ("theta", "w", "y", "vy", "eta", "deta", "bristle", "guess")


def _flipped(name: str) -> float:
    return -1.0 if name.partition("_")[0] in FLIPPED_STATES else 1.0


MIRROR = Transformation(mirrored_inputs, _mirrored, 1.0, _mirrored_name, _flipped)


def turned(by: float) -> Transformation:
    """All turned by an angle about the origin."""
    c, s = math.cos(by), math.sin(by)

    def inputs(mechanism, initial):
        table = _plain(mechanism)
        initial = {"crank_angle": 0.0} | initial if "angle" not in initial else initial
        begun = _started(initial, lambda x: x + by, lambda w: w)
        for pin in _pins(table):
            if pin["point"]:
                x, y = pin["point"]
                pin["point"], pin["direction"] = (c * x - s * y, s * x + c * y), pin["direction"] + by
        for joint in table["joints"]:
            if joint["kind"] == "revolute":
                joint["journal"]["direction"] = joint["bearing"]["direction"] = 0.0
        for each in (x for x in table["springs"] if x["kind"] == "extension"):
            each["from"]["direction"] = each["to"]["direction"] = 0.0
        table["gravity_direction"] += by
        table["guess"] = {name: angle + by for name, angle in _guessed(mechanism).items()}
        for spring in table["springs"]:
            if spring["kind"] == "torsion":
                spring["angle"] += by * ((spring["to"] == "ground") - (spring["from"] == "ground"))
        for load in table["loads"]:
            if load["kind"] == "force" and load["fixed"] == "ground":
                load["direction"] += by
            if load["angle"] is not None:
                _waves(load, 1, 1, by)
        drive = table["drive"]
        if drive and drive["kind"] == "torque":
            _waves(drive, 1, 1, by)
        if drive and drive["kind"] == "servo":
            drive["constant"] += by
            own = {"angle": f"(angle - {by!r})", "wanted_angle": f"(wanted_angle - {by!r})"}
            drive |= _fed(mechanism.drive, own, 1.0)
        return jp.Mechanism(**table), begun

    def seen(word, values, labels=()):
        if word in TURNED:
            return values[word] + by
        if word in VECTORS:
            return c * values[word] - s * values[VECTORS[word]]
        if word in VECTORS.values():
            x = next(x for x, y in VECTORS.items() if y == word)
            return s * values[x] + c * values[word]
        return values[word]

    return Transformation(inputs, seen)


def _guessed(mechanism) -> dict[str, float]:
    """Rough angles of all links where the mechanism has any: those left out are 0."""
    if not mechanism.guess:
        return {}
    return {name: float(angle) for name, angle in start(mechanism, None).angles.items()}


# Names, order, whole turns


def _other(name: str) -> str:
    return name if name == "ground" else f"q{name[::-1]}"


def renamed_inputs(mechanism, initial):
    """Other names of links, joints, springs and loads, all in another order."""

    def walk(value, key=""):
        if isinstance(value, dict):
            named = key in ("guess", "angle", "angular_velocity")
            return {_other(k) if named else k: walk(v, "number" if named else k) for k, v in value.items()}
        if isinstance(value, list | tuple):
            return type(value)(walk(each, key) for each in value)
        return _other(value) if isinstance(value, str) and key in _NAMED else value

    table = walk(_plain(mechanism))
    rest = [link for link in table["links"] if link["name"] != _other(mechanism.crank)]
    table["links"] = (*rest[::-1], *(x for x in table["links"] if x["name"] == _other(mechanism.crank)))
    for key in ("joints", "springs", "loads"):
        table[key] = table[key][::-1]
    if mechanism.drive is None:  # the first link that is pinned to the ground counts as the crank
        table["links"], table["joints"] = table["links"][::-1], table["joints"][::-1]
    return jp.Mechanism(**table), walk(initial)


_NAMED = {"name", "link", "from", "to", "angle"}


def _renamed(name: str) -> str:
    head, _, corner = name.partition("_")
    return f"{_other(head)}_{corner}" if corner.startswith(("upper", "lower")) else _other(name)


RENAMED = Transformation(renamed_inputs, names=_renamed)


def before_inputs(mechanism, initial):
    """Begun at a crank angle of a whole turn less: what counts turns is told of it."""
    table, crank = _plain(mechanism), mechanism.crank
    for spring in table["springs"]:
        if spring["kind"] == "torsion":
            spring["angle"] -= math.tau * ((spring["from"] == crank) - (spring["to"] == crank))
    if table["drive"] and table["drive"]["kind"] == "servo":
        table["drive"]["constant"] -= math.tau
        own = {"angle": f"(angle + {math.tau!r})", "wanted_angle": f"(wanted_angle + {math.tau!r})"}
        table["drive"] |= _fed(mechanism.drive, own, 1.0)
    if "angle" in initial:
        begun = initial | {"angle": initial["angle"] | {crank: initial["angle"][crank] - math.tau}}
    else:
        begun = initial | {"crank_angle": initial.get("crank_angle", 0.0) - math.tau}
    return jp.Mechanism(**table), begun


BEFORE = Transformation(before_inputs)  # the crank's angle is a turn less, which comparisons leave out
OTHER = (0.21, 3.7, 0.013)
TABLE = {
    "mirrored": MIRROR,
    "turned": turned(0.7),
    "longer": scaled(length=31.7, mass=1e3),  # no lighter than air
    "slower": scaled(time=0.053),
    "heavier": scaled(mass=78.0),
    "in other units": scaled(*OTHER),
    "renamed": RENAMED,
    "a turn before": BEFORE,
}
NEW_TEXT = {"renamed"}  # equations of other names are compiled anew
