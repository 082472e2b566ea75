"""Rules that analyses share: which length, section, record and start fit together and fit a mechanism.

What an analysis does where nobody says: how long it lasts, and what it goes over, as the mechanism has it.

A mechanism alone then runs, from a file as from Python. Ranges are half and twice the present value; planes
and regions of starts are the whole disc of the clearance, or most of it. Where a mechanism has none of these,
as a system of equations, what is needed stays needed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.quantities import BALANCE, EVENTS, STATUS, WORDS, owners, recorded
from jointplay.display.errors import NOTHING, InputError, Problem, join, raise_any, strangers, unknown, warn
from jointplay.solver.codegen.cache import structure_module
from jointplay.solver.mechanism.assemble import assemble, check_section, linkage, nominal_speed
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.loops.ideal import cannot_turn
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import (
    ContactSection,
    CrankAngle,
    Mechanism,
    Plane,
    Section,
    SeparationSection,
    TestSystem,
)
from jointplay.solver.motion.trajectory import MAX_STEPS, Records, Request, follow

SLACK = 4  # nominal periods that a turn may take before the run gives up
MOST = 20_000_000  # samples of a run, in memory
_HERE = "accepted here, where each turn starts anew from the state at the end of the one before"

REACH = 2.0  # of a parameter, to either side
INSIDE = 0.7  # of the clearance: starts that are not yet in contact
ACROSS = 13  # starts along each side of a plane
DISC = ("eccentricity_ratio_x", "eccentricity_ratio_y")
LENGTHS = ("turns", "duration", "windows", "at")


def length_fits(turns: float | None, duration: float | None) -> Iterator[Problem]:
    """Yield a problem where a run has no length, or two."""
    if turns is None and duration is None:
        yield Problem("turns", NOTHING, "the length of the run is needed: turns, or duration in s")
    if turns is not None and duration is not None:
        yield Problem("turns", turns, "either turns or duration is accepted, not both")


def section_fits(mechanism: Mechanism | TestSystem, section: Section | None) -> None:
    """Refuse a section that the mechanism cannot have."""
    watched = quantity(section, mechanism)
    if isinstance(section, Plane) and isinstance(mechanism, TestSystem):
        structure_module(mechanism.structure(watched))  # its equations know its quantities


def names_of(mechanism: Mechanism | TestSystem, record: tuple[str, ...] | None) -> tuple[str, ...]:
    """Names of the quantities that an analysis shares with its rules: those to record (`recorded`)."""
    return recorded(record, mechanism)


def turns_alike(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Yield the problems of a mechanism whose turns follow no map, for analyses that are built on one."""
    return unlike_turns(mechanism) if isinstance(mechanism, Mechanism) else iter(())


def each_alike(mechanism: Mechanism | TestSystem, over: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problems of unlike turns at each value of a variation; wrong values are left out."""
    for key, values in over.items() if isinstance(mechanism, Mechanism) else ():
        for value in values if isinstance(values, list | tuple) else ():
            try:
                cell = mechanism.varied({key: value})
            except InputError:
                continue  # said elsewhere
            yield from unlike_turns(cell)


def alike_beside(mechanism: Any, place: str, keys: Iterable[str], values: Any = ()) -> Iterator[Problem]:
    """Yield the problems of unlike turns as parameters of a keyword take values, or change a little."""
    for key in keys if isinstance(mechanism, Mechanism) and not any(unlike_turns(mechanism)) else ():
        value = Parameter(mechanism, key).value
        there = values or ([1.00318 * value] if is_number(value) else [])  # an odd place stands for all
        for problem in [*each_alike(mechanism, {key: there})][:1]:
            yield Problem(place, key, f"what leaves turns alike as it varies is accepted: {problem.expected}")


def usual_alike(mechanism: Mechanism, keys: Sequence[str]) -> tuple[tuple[str, ...], dict[str, str]]:
    """Usual parameters beside whose values turns stay alike; of others tells a warning, an attribute too."""
    others = [problem.given for problem in alike_beside(mechanism, "", keys)]
    text = f"{' and '.join(others)} is left out: at other values a load over time differs from turn to turn"
    return tuple(key for key in keys if key not in others), warn(text) if others else {}


def varied(mechanism: Mechanism | TestSystem, changes: Mapping[str, float]) -> Mechanism | TestSystem:
    """The mechanism with changes, for whole turns; refused where its crank cannot turn as it is driven."""
    here = mechanism.varied(changes)
    if getattr(getattr(here, "drive", None), "imposed_speed", None) is not None:
        raise_any(cannot_turn(here, 0.0, math.tau))
    return here


def samples_fit(
    mechanism: Mechanism | TestSystem, turns: float | None, duration: float | None, samples_per_turn: int
) -> Iterator[Problem]:
    """Yield a problem where evenly spaced samples are more than a run can keep."""
    lengths = {"turns": turns, "duration": duration, "samples_per_turn": samples_per_turn}
    yield from too_many(lengths, nominal_period(mechanism))


def nominal_period(mechanism: Mechanism | TestSystem) -> float:
    """Nominal period of a mechanism from its default start on, s."""
    if isinstance(mechanism, TestSystem):
        return mechanism.time_scale
    return math.tau / nominal_speed(mechanism)


def started(mechanism: Mechanism | TestSystem, initial: Any) -> Model:
    """The model that an analysis shares with its rules: the mechanism, assembled at the start."""
    return assembled_at(mechanism, initial)


def section_of(mechanism: Mechanism | TestSystem) -> str | None:
    """The quantity that cuts a motion once a turn (or forcing period); None where nothing turns."""
    if isinstance(mechanism, TestSystem) and mechanism.period is None:
        return None
    return quantity(CrankAngle(), mechanism)


def on_section(mechanism: Mechanism | TestSystem, initial: Any) -> Model:
    """The model of a mechanism on the section that cuts it once a turn, if anything turns."""
    return assembled_at(mechanism, initial, section=section_of(mechanism))


def _watched(mechanism: Mechanism | TestSystem, initial: Any, section: Section | None, powers: bool) -> Model:
    return assemble(mechanism, initial, quantity(section, mechanism), powers)


def recorded_from(
    mechanism: Mechanism | TestSystem,
    initial: Any,
    section: Section | None,
    names: tuple[str, ...],
    assembled: Callable[..., Model] = _watched,
) -> Model:
    """The model with its section and record; where the section is wrong, as another rule tells, without."""
    try:
        return model_for(mechanism, initial, section, names, assembled)
    except InputError:
        return model_for(mechanism, initial, assembled=assembled)


def model_for(
    mechanism: Mechanism | TestSystem,
    initial: Any,
    section: Section | None = None,
    record: Container[str] = (),
    assembled: Callable[..., Model] = _watched,
) -> Model:
    """Assemble a mechanism for a run: at its start, with its section, and with the integrals to record."""
    powers = any(name in record for name in BALANCE)
    return assembled_at(mechanism, initial, "initial", assembled, section=section, powers=powers)


def assembled_at(
    mechanism: Mechanism | TestSystem,
    initial: Any,
    key: str = "initial",
    assembled: Callable[..., Model] = assemble,
    **how: Any,
) -> Model:
    """Assemble a mechanism at a start.

    Raises
    ------
    InputError
        If the mechanism cannot start there, with keys below that of the start.
    """
    try:
        return assembled(mechanism, initial, **how)
    except InputError as error:
        raise InputError(_below(key, problem) for problem in error.problems) from None


def _below(key: str, problem: Problem) -> Problem:
    own = problem.key.startswith(("mechanism", "parameters", "section"))
    return problem if own else replace(problem, key=join(key, problem.key.removeprefix("initial")))


def too_many(given: Mapping[str, float | None], period: float = 1.0, root: str = "") -> Iterator[Problem]:
    """Yield a problem where the product of some keywords is more samples than a run can keep.

    Parameters
    ----------
    given : mapping of str to float or None
        Their values; a ``duration`` is in s, all else a number.
    period : float
        Length of a nominal turn, s.
    root : str
        How the keys of errors begin.
    """
    factors = {key: value for key, value in given.items() if value is not None}
    count = math.prod(value / period if key == "duration" else value for key, value in factors.items())
    if count > MOST:
        first, *others = factors
        together = f"together with {', '.join(others)} " if others else ""
        expected = f"{together}at most {MOST:,} samples are accepted, not {count:,.0f}"
        yield Problem(join(root, first), factors[first], expected)


def span(model: Model, motion: Mapping[str, Any]) -> tuple[float, float]:
    """Ends of the transient and of the whole of a motion of any length (`keywords.Lasting`), s."""
    begin, turns = motion["transient"] * model.period, motion["turns"]
    return begin, begin + (motion["duration"] if turns is None else turns * model.period)


def steps(max_steps: int | None) -> int:
    """The number of attempts after which a run stops."""
    return MAX_STEPS if max_steps is None else max_steps


def to_the_section(model: Model, request: Request) -> Records:
    """`follow`, not converged where the crank stops before it has passed the section as often as asked."""
    records = follow(model, request)
    short = not records.status and len(records.sections) < request.stop_after - request.skip
    return replace(records, status=STATUS.index("not_converged")) if short else records


def quantity(section: Section | None, mechanism: Mechanism | TestSystem) -> str | None:
    """The quantity (as word:label) whose level makes the section; None if events make it, or nothing does.

    Raises
    ------
    InputError
        If the mechanism has no such quantity.
    """
    if section is None:
        return None
    linkage = isinstance(mechanism, Mechanism)
    if linkage:
        if isinstance(section, Plane):  # first: a quantity that makes no section has no right joint
            words = [name for name in WORDS if name not in _NOT_SECTIONS]
            raise_any(strangers([("section.quantity", section.quantity)], words, "quantity"), "section")
        check_section(section, mechanism)
    elif isinstance(section, ContactSection | SeparationSection):
        own = structure_module(mechanism.structure())
        _contacts(section, own.CONTACTS, own.RESETS)
    if isinstance(section, CrankAngle):
        return f"angle:{mechanism.crank}" if linkage else _phase(mechanism)
    if isinstance(section, Plane):
        return _plane(section, mechanism) if linkage else section.quantity
    return None


def _phase(system: TestSystem) -> str:
    if system.period is None:
        expected = "a plane section is accepted for a system that nothing forces"
        raise InputError([Problem("section.kind", "crank_angle", expected)], "section")
    return "phase"


def _plane(section: Plane, mechanism: Mechanism) -> str:
    follower = section.link not in (None, mechanism.crank)
    if section.quantity == "angle" and follower and section.link in linkage(mechanism).dependent:
        expected = f"the crank, {mechanism.crank}, is accepted: this link's angle follows others"
        raise InputError([Problem("section.link", section.link, expected)], "section")
    of, names = WORDS[section.quantity].of, owners(mechanism)
    given = section.link if of in ("link", "bending") else section.joint
    if of is None:
        return section.quantity
    if not names[of] or given not in (None, *names[of]):
        whose = {"bending": "an elastic link", "guide": "a prismatic joint"}.get(of, f"a {of}")
        accepted = f"a quantity of {whose} is accepted: {', '.join(names[of]) or 'none here'}"
        raise InputError([Problem("section.quantity", section.quantity, accepted)], "section")
    if given is None and len(names[of]) > 1:
        expected = f"one of {', '.join(names[of])} is needed for {section.quantity}"
        raise InputError([Problem(f"section.{of}", NOTHING, expected)], "section")
    return f"{section.quantity}:{given or names[of][0]}"


def _contacts(section: Any, joints: Iterable[str], walls: Collection[str]) -> tuple[tuple[str, ...], str]:
    """Names of the joints (or walls) that can make such a section, and the kind of event that does."""
    kind, names = section.kind, dict.fromkeys((*joints, *(walls if section.kind == "contact" else ())))
    if kind == "contact" and (section.joint in walls or (section.joint is None and len(walls) == len(names))):
        kind = "impact"
    if not names or section.joint not in (None, *names):
        problem = unknown("section.joint", section.joint, section.joint, names, "contact")
        raise InputError([problem], "section")
    return (*names,), kind


_NOT_SECTIONS = ("mode", "reaction_x", "reaction_y", "reaction", "energy", "state_value", *BALANCE)


_NOT_SECTIONS += ("contact_angle", "eccentricity_ratio", "reaction_moment")


def section_fields(section: Section | None, model: Model, skip: int) -> dict[str, Any]:
    """The fields of a run's request that describe a section."""
    if section is None:
        return {}
    if isinstance(section, CrankAngle):
        forward = model.forward
        turns = (section.angle - model.crank_angle) * forward / math.tau
        first = model.crank_angle + forward * math.tau * (turns - math.ceil(turns) + 1)
        return {"level": first, "period": math.tau, "direction": forward, "skip": skip}
    if isinstance(section, Plane):
        return {"level": section.value, "direction": 1 if section.direction == "up" else -1, "skip": skip}
    names, kind = _contacts(section, model.joints, model.walls)
    joint = -1 if section.joint is None else names.index(section.joint)
    return {"event": EVENTS.index(kind), "joint": joint, "skip": skip}


def unlike_turns(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield a problem for each part that makes one turn differ from the next."""
    drive = mechanism.drive
    if drive and drive.transient:
        text = "a drive that does the same in each turn is"
        yield Problem("mechanism.drive.kind", drive.kind, f"{text} {_HERE}")
    # without clearance in a loop the crank's angle is a state, and another section would begin at time 0 too
    held = not mechanism.clearance_joints and Forest.of(mechanism).cuts
    speed = drive.imposed_speed if drive and not held else None
    for i, load in enumerate(mechanism.loads):
        ratio = load.frequency / abs(speed) if load.timed and speed else 0.5
        if load.timed and not math.isclose(ratio, round(ratio), rel_tol=1e-9):
            text = "a load over the crank's angle, or over time where a joint has clearance and the frequency"
            multiple = "is a whole multiple of a constant speed of the crank, is"
            yield Problem(f"mechanism.loads[{i}].frequency", load.frequency, f"{text} {multiple} {_HERE}")
    for i, spring in enumerate(mechanism.springs):
        if spring.twists and mechanism.crank in spring.links:
            text = f"a torsion spring between links other than the turning {mechanism.crank} is {_HERE}"
            yield Problem(f"mechanism.springs[{i}]", spring.name, text)


@dataclass(frozen=True)
class LeftOut:
    """Keywords of an analysis that follow where they are left out.

    Parameters
    ----------
    names : tuple of str
        Which.
    of : callable
        Gives them for the keywords that are given, as far as they follow.
    """

    names: tuple[str, ...]
    of: Callable[[Mapping[str, Any]], dict[str, Any]]

    def completed(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Keywords, with those that are left out."""
        if all(given.get(name) is not None for name in self.names):
            return dict(given)
        return {**given, **{key: x for key, x in self.of(given).items() if given.get(key) is None}}


NONE = LeftOut((), lambda given: {})


def lasting(transient: float, turns: int) -> LeftOut:
    """So many turns after a transient, where no length is given."""
    own = {"transient": transient, "turns": turns}
    return LeftOut(
        ("turns",), lambda given: {} if any(given.get(key) is not None for key in LENGTHS) else own
    )


def over(number: int) -> LeftOut:
    """So many clearances about the present one."""

    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        pair = _around(given.get("mechanism"), "clearance")
        return {"over": {"clearance": np.geomspace(*pair, number).tolist()}} if pair else {}

    return LeftOut(("over",), found)


def both(*several: LeftOut) -> LeftOut:
    """All of several."""

    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value for each in several for key, value in each.of(given).items()}

    return LeftOut(sum((each.names for each in several), ()), found)


def _range(given: Mapping[str, Any]) -> dict[str, Any]:
    pair = _around(given.get("mechanism"), given.get("parameter", "clearance"))
    return {"range": pair} if pair else {}


def _two_ranges(given: Mapping[str, Any]) -> dict[str, Any]:
    pairs = {key: _around(given.get("mechanism"), key) for key in ("clearance", "gear_ratio", "speed")}
    ranges = {key: pair for key, pair in pairs.items() if pair}
    return {"plane": ranges} if len(ranges) == 2 else {}


def _disc(key: str, value: Any) -> LeftOut:
    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        mechanism = given.get("mechanism")
        loose = isinstance(mechanism, Mechanism) and mechanism.clearance_joints
        return {key: dict.fromkeys(DISC, value)} if loose else {}

    return LeftOut((key,), found)


RANGE = LeftOut(("range",), _range)


TWO_RANGES = LeftOut(("plane",), _two_ranges)


WHOLE_DISC = _disc("plane", {"start": -1.0, "stop": 1.0, "num": ACROSS})


INNER_DISC = _disc("region", (-INSIDE, INSIDE))


def _around(mechanism: Any, key: Any) -> tuple[float, float] | None:
    """Half and twice the present value of a parameter; None where it has none above 0."""
    try:
        value = Parameter.named(mechanism, key).value if isinstance(mechanism, Mechanism) else None
    except InputError:
        return None
    return (value / REACH, value * REACH) if is_number(value) and value > 0 else None
