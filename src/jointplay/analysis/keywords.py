"""Keywords of analyses: the decorator that checks them by a function's signature, and their shared types.

`analysis` makes a function an analysis: its annotations check each call (`mechanism.signature`), and its
`progress` is called as it advances. Study files are checked by the same annotations and rules.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial, wraps
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, ParamSpec, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    PlainSerializer,
    PlainValidator,
    Tag,
    ValidationInfo,
    field_validator,
)
from typing_extensions import TypedDict  # that of `typing` forgets its bases before Python 3.12

from jointplay.analysis.own_units import in_own_units
from jointplay.analysis.period import REPEATS
from jointplay.analysis.rules import NONE, LeftOut, names_of, started
from jointplay.display.accepted import with_returns
from jointplay.display.errors import Problem, refuse, warn
from jointplay.jobs.origin import version
from jointplay.solver.mechanism import plausible
from jointplay.solver.mechanism.assemble import journal_distances, windings
from jointplay.solver.mechanism.base import (
    Angle,
    Branch,
    Count,
    Flag,
    Name,
    Natural,
    NonNegative,
    Number,
    Positive,
    Record,
    Turn,
    accepts,
    measured,
    unit,
)
from jointplay.solver.mechanism.loops import ideal
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section, TestSystem
from jointplay.solver.mechanism.signature import Rule, Usual, checked, unpack
from jointplay.solver.motion.progress import reported

P = ParamSpec("P")
T = TypeVar("T")
RTOL = (1e-14, 1e-4)
MOST = 100_000  # values along an axis
SETTLING = 100  # turns
LENGTHS = ("initial", "transient", "turns", "duration", "windows", "at")  # by which a crank's way is known
HANDED: Any = None  # in a signature, default of what an analysis is handed and no call gives

_MOVING = "a Mechanism or TestSystem, such as catalog.chunmei2002(),"
_START = "a table of crank_angle, crank_speed, or a list of numbers (the state),"
_PLANE = "a table of two coordinates, each a rising list of numbers or a table of start, stop and num,"


def analysis(
    *rules: Rule | str,
    usual: Mapping[str, Any] | None = None,
    outputs: Any = None,
    left_out: LeftOut = NONE,
    **more: Any,
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Make a function an analysis: its signature checks each call, its `progress` is called as time passes.

    Parameters
    ----------
    *rules, **more
        As in `checked`: rules of which keywords fit together, and what these and the function share. That are
        always `model`, the mechanism assembled at its start, and `names`, the quantities to record.
    usual : mapping of str to object, optional
        Defaults of shared settings (`Motion`) that are this analysis' own.
    outputs : declared.Outputs, optional
        What it gives.
    left_out : LeftOut
        Keywords that follow from the others where they are left out.
    """

    def decorated(function: Callable[P, T]) -> Callable[P, T]:
        unpack(function, usual or {})
        if outputs is not None:
            function.outputs, function.__doc__ = outputs, with_returns(function.__doc__, str(outputs))
        closes = "period" in signature(function).parameters

        def before(given: dict[str, Any]) -> dict[str, Any]:
            return left_out.completed(_as_meant(closes, given))

        checks, shared = (*rules, _turns_as_driven(function)), {"model": started, "names": names_of} | more
        made = checked(*checks, before=before, after=_warned, **shared)(_signed(reported(function)))
        made.left_out = left_out
        return made

    return decorated


def _signed(function: Callable[P, T]) -> Callable[P, T]:
    """Write the mechanism, the tolerance and the program's version into an analysis's dataset."""

    @wraps(function)
    def call(*values: P.args, **keywords: P.kwargs) -> T:
        made, mechanism = function(*values, **keywords), keywords.get("mechanism")
        # into the dataset itself, since a copy takes as long as a tenth of a short call
        made.attrs["source"] = f"jointplay {version('jointplay')}"
        made.attrs |= {"mechanism": mechanism.model_dump_json()} if mechanism is not None else {}
        made.attrs |= {"rtol": keywords["rtol"]} if "rtol" in keywords else {}
        return made

    return call


def _as_meant(closes: bool, given: dict[str, Any]) -> dict[str, Any]:
    """Arguments with numbers in the system's own units, and an orbit's state in place of the orbit.

    Where motions that close are sought (`closes`), the orbit brings its period, and no turns are dropped.
    """
    orbit = given.get("initial")
    if hasattr(orbit, "data_vars") and "orbit_state" in orbit.data_vars and orbit["orbit_state"].ndim == 1:
        found = np.isfinite(orbit["period"].item())
        own = {"period": int(orbit["period"]), "transient": 0} if closes and found else {}
        given = own | given | {"initial": orbit["orbit_state"].values.tolist()}
    return in_own_units(given.get("mechanism"), given)


def _turns_as_driven(function: Callable[..., Any]) -> Rule:
    """The rule that a crank whose speed is imposed can turn as far as an analysis follows it."""
    known = ["mechanism", *(name for name in LENGTHS if name in signature(function).parameters)]
    rule = partial(turns_as_driven)
    rule.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in known])  # type: ignore[attr-defined]
    return rule


def turns_as_driven(mechanism: Any, initial: Any = None, **given: Any) -> Iterator[Problem]:
    """Yield the problem of a crank whose speed is imposed and that cannot turn so far; by `LENGTHS`."""
    drive = getattr(mechanism, "drive", None)
    if getattr(drive, "imposed_speed", None) is not None:
        start = initial if isinstance(initial, Mapping) else {}
        angle = start.get("crank_angle") or (start.get("angle") or {}).get(drive.link) or 0.0
        yield from ideal.cannot_turn(mechanism, angle, _travel(drive, **given))


def _travel(
    drive: Any,
    transient: Any = 0,
    turns: Any = None,
    duration: Any = None,
    windows: Any = None,
    at: Any = None,
) -> float:
    """Angle that a crank of imposed speed turns through in such a run, rad; a turn without a length."""
    turn = math.tau / abs(drive.nominal_speed)  # s
    ends = [max(at)] if at else [windows[-1][1] * turn] if windows else []
    ends += [turns * turn] if turns is not None else [duration] if duration is not None else []
    time = (transient or 0) * turn + max(ends, default=turn)
    if drive.kind == "profile":
        return drive.travel(time)
    return drive.nominal_speed * time


def doubts(mechanism: Any, initial: Any = None, section: Any = None) -> Iterator[Problem]:
    """Yield doubts about keywords that are right by themselves (`mechanism.plausible`)."""
    linkage = isinstance(mechanism, Mechanism)
    placed = linkage and isinstance(initial, Mapping) and "angle" in initial
    apart = journal_distances(mechanism, initial) if placed else None
    wound = (
        windings(mechanism, initial) if linkage and any(each.twists for each in mechanism.springs) else None
    )
    yield from plausible.doubts(mechanism, initial, section, apart, wound)
    if linkage and not mechanism.as_meant:
        yield from ideal.doubts(mechanism)


def _warned(arguments: dict[str, Any]) -> None:
    for doubt in doubts(*map(arguments.get, ("mechanism", "initial", "section"))):
        warn(str(doubt))


class Initial(Record):
    """Start of a linkage: the ideal mechanism's position and speeds at a crank angle, or as written out.

    Parameters
    ----------
    crank_angle : float, optional
        rad; 0 if left out.
    crank_speed : float, optional
        rad/s; the drive's no-load speed if left out.
    branch : {'upper', 'lower'}, optional
        Of the ideal mechanism; its own if left out.
    angle, angular_velocity : dict of str to float, optional
        Of every link, by name, rad and rad/s, instead of the crank's.
    """

    crank_angle: Turn | None = measured("crank angle", "rad", None)
    crank_speed: Number | None = measured("crank speed", "rad/s", None)
    branch: Branch | None = None
    angle: dict[str, Angle] | None = measured("angle of each link, by name", "rad", None)
    angular_velocity: dict[str, Number] | None = measured(
        "angular velocity of each link, by name", "rad/s", None
    )

    @field_validator("angle", "angular_velocity")
    @classmethod
    def _instead_of_the_crank(cls, given: Any, info: ValidationInfo) -> Any:
        crank = [key for key in ("crank_angle", "crank_speed", "branch") if info.data.get(key) is not None]
        if given is not None and crank:
            raise refuse(given, f"either {' and '.join(crank)}, or angle and angular_velocity, are accepted")
        return given


class Span(Record):
    """Evenly spaced values.

    Parameters
    ----------
    start, stop : float
        First and last.
    num : int
        How many.
    """

    start: Number
    stop: Number
    num: Annotated[int, Field(strict=True, ge=2, le=MOST)]


def _moving(given: Any) -> Any:
    if not isinstance(given, Mechanism | TestSystem):
        raise refuse(given, f"{_MOVING} is accepted")
    return given


def as_list(given: Any) -> Any:
    """Arrays and ranges as lists."""
    if hasattr(given, "__array__") and hasattr(given, "dtype"):  # which a whole dataset has not
        return given.__array__().tolist()
    return list(given) if isinstance(given, range) else given


def as_several(given: Any) -> Any:
    """One value as a list of one."""
    given = as_list(given)
    return given if isinstance(given, Sequence) and not isinstance(given, str) else (given,)


def _form(given: Any) -> str:
    return "table" if isinstance(given, Mapping | Record) else "list"


def _plain(given: Any) -> Any:
    """A record as a table of the fields that it sets."""
    return given.model_dump(exclude_none=True) if isinstance(given, Record) else given


def _table_or_list(table: type[Record], numbers: Any, words: str) -> Any:
    """Type of a value that is given either as a table or as a list of numbers."""
    return Annotated[
        Annotated[table, Tag("table")] | Annotated[numbers, Tag("list")],
        Discriminator(_form),
        BeforeValidator(as_list),
        AfterValidator(_plain),
        PlainSerializer(_plain),
        accepts(words),
    ]


def several(item: Any, words: str) -> Any:
    """Type of a list; one value alone counts as a list of one."""
    return Annotated[tuple[item, ...], BeforeValidator(as_several), accepts(words)]


def listed(item: Any, words: str, **more: str) -> Any:
    """Type of a list, or an array; `more` as of `accepts`."""
    return Annotated[tuple[item, ...], BeforeValidator(as_list), accepts(words, **more)]


Moving = Annotated[Mechanism | TestSystem, PlainValidator(_moving), accepts(_MOVING)]
Length = Annotated[Positive, Field(le=1e9)]  # turns, or s
Duration = Annotated[Length, unit("duration", "s")]
Before = Annotated[NonNegative, Field(le=1e9)]
Rtol = Annotated[Number, Field(ge=RTOL[0], le=RTOL[1])]
Share = Annotated[NonNegative, Field(lt=1), unit("number", "1")]
Small = Annotated[Positive, Field(lt=1), unit("number", "1")]
Names = listed(str, "a list of names")
Text = Annotated[str, Field(min_length=1)]
JointName = Annotated[Name, Field(description="joint name", json_schema_extra={"noun": True})]
Quantity = Annotated[Text, accepts("the name of a quantity")]
Quantities = listed(str, "a list of names of quantities")
Start = _table_or_list(Initial, tuple[Number, ...], _START)
Starts = Annotated[tuple[Start, ...], accepts("a list of starts, each as initial,")]
Plane = Annotated[dict[str, _table_or_list(Span, list[Number], _PLANE)], accepts(_PLANE)]
Progress = Annotated[
    Flag | Callable[[float], None] | None, accepts("true, false, or a function of the fraction done")
]


class Integration(TypedDict, total=False):
    """Settings of the integration of the equations of motion.

    Parameters
    ----------
    rtol : float
        Tolerated error of a step, relative to 1 rad, to the longest link and to the speeds.
    max_steps : int, optional
        Number of attempted steps after which a run stops with status ``step_limit``; no limit if left out.
    progress : bool or callable, optional
        A function is called with the fraction done. True shows a bar, or lines in a log; False does not. Left
        out: a bar on a terminal or in a notebook, of a call that lasts over 3 s.
    """

    rtol: Annotated[Rtol, Usual(1e-8)]
    max_steps: Annotated[Natural | None, Usual(None)]
    progress: Annotated[Progress, Usual(None)]


class Motion(Integration, total=False):
    """A motion from a start.

    Parameters
    ----------
    initial : mapping or sequence, optional
        Where the motion starts: ``crank_angle`` (rad), ``crank_speed`` (rad/s) and ``branch`` of the ideal
        mechanism, or ``angle`` and ``angular_velocity`` by link; of a test system, its state. The ideal
        mechanism at crank angle 0 if left out. `simulate`, `spectrum`, sweeps, orbits and gradients take a
        whole state too, as an ``end_state``.
    """

    initial: Annotated[Start | None, Usual(None)]


class Lasting(Motion, total=False):
    """A motion of any length.

    Parameters
    ----------
    turns : float
        Length after the transient, in nominal turns of the crank or periods of the forcing; instead of
        `duration`. Where neither is given, as many turns after a transient as the analysis usually takes.
    duration : float
        Length after the transient, s; instead of `turns`.
    transient : float
        Number of turns of the crank, or periods of the forcing, that are followed first and left out.
    """

    turns: Annotated[Length | None, Usual(None)]
    duration: Annotated[Duration | None, Usual(None)]
    transient: Annotated[Before, Usual(0)]


class Cut(Motion, total=False):
    """A motion of which section points are taken.

    Parameters
    ----------
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    turns : int
        Number of section points.
    transient : float
        Number of turns that are followed first and left out.
    """

    section: Annotated[Section, Usual(ONCE_A_TURN)]
    turns: Annotated[Natural, Usual(2000)]
    transient: Annotated[Before, Usual(0)]


class Settling(Motion, total=False):
    """A motion that is left to settle.

    Parameters
    ----------
    transient : int
        Number of turns of the crank, or periods of the forcing, that the motion is given to settle.
    """

    transient: Annotated[Count, Usual(SETTLING)]


class Divided(Settling, total=False):
    """Many motions that are left to settle, side by side.

    Parameters
    ----------
    n_jobs : int, optional
        Worker processes, 2 if left out. The result does not depend on it.
    """

    n_jobs: Annotated[Natural | None, Usual(None)]


class Batched(Divided, total=False):
    """Many motions that are left to settle, side by side and eight at once.

    Parameters
    ----------
    ensemble : bool, optional
        Whether eight motions are followed at once; if left out, wherever that is possible (see
        `bifurcation`).
    """

    ensemble: Annotated[Flag | None, Usual(None)]


class Recognising(Batched, total=False):
    """Motions from many starts that are left to settle, and recognised by their section points.

    Parameters
    ----------
    joint : str, optional
        Joint whose journal the starts are placed by; the only one with clearance if left out.
    turns : int
        Number of turns, or periods of the forcing, after the transient by which a motion is recognised;
        periods up to a quarter of them are found.
    patience : int
        How many times a motion in which no period is found is followed for another `turns`, before it counts
        as having none.
    tolerance : float
        Distance within which section points of periodic motions are the same: as a fraction of the clearance
        and of the nominal speed, or in a test system's own units. A period is found at a tenth of it.
    """

    joint: Annotated[JointName | None, Usual(None)]
    turns: Annotated[Natural, Field(ge=REPEATS), Usual(64)]
    patience: Annotated[Count, Usual(4)]
    tolerance: Annotated[Positive, unit("tolerance", "1"), Usual(1e-3)]
