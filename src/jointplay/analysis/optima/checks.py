"""Checks of an optimisation: variables with bounds, an aim, constraints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from jointplay.analysis.coexisting.region import Region
from jointplay.analysis.gradients import selection
from jointplay.analysis.rules import turns_alike
from jointplay.analysis.vary import axes, repeated
from jointplay.display.errors import InputError, Problem
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.paths import parts_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem

FORCE = "normal_force:"


def bounds_fit(mechanism: Mechanism | TestSystem, by: Region, ideal: bool) -> Iterator[Problem]:
    """Yield the problems of variables and their bounds."""
    if not by:
        yield Problem("by", by, "at least one parameter with its lowest and highest value is accepted")
    wrong = [*selection.parameters_fit(mechanism, tuple(by), ()), *repeated(by, "by")]
    yield from (replace(each, key="by") for each in wrong)
    for key, (low, high) in by.items() if not wrong else ():
        value = Parameter(mechanism, key).value
        if not low < high:
            yield Problem(f"by.{key}", [low, high], "a lowest value below the highest is accepted")
        elif not low <= value <= high:
            yield Problem(
                f"by.{key}", [low, high], f"bounds that hold the present value, {value:g}, are accepted"
            )
        elif ideal and any(part.rpartition(".")[2] == "clearance" for part in parts_of(key)):
            yield Problem("by", key, "no clearance is accepted with ideal = true, which begins without")
        else:
            yield from _ends_fit(mechanism, key, low, high)


def _ends_fit(mechanism: Mechanism | TestSystem, key: str, low: float, high: float) -> Iterator[Problem]:
    try:
        axes(mechanism, {key: [low, high]}, "by")
    except InputError as error:
        yield from (Problem(f"by.{key}", each.given, each.expected) for each in error.problems)


def aim_fits(
    mechanism: Mechanism | TestSystem,
    least: str | None,
    most: str | None,
    keep: str | None,
    margin: float,
    subject: Any,
    orbit: bool,
) -> Iterator[Problem]:
    """Yield the problems of the aim and of constraints."""
    if least and most:
        yield Problem("most", most, "one of least and most is accepted")
    if not (least or most or keep or subject):
        yield Problem(
            "least", least, 'a quantity, or keep = "contact", or constraints in subject, are accepted'
        )
    named = tuple(name for name in (least, most, *(subject or ())) if name)
    yield from (
        replace(each, key="subject" if each.given in (subject or ()) else "least" if least else "most")
        for each in selection.quantities_fit(mechanism, named, orbit)
    )
    for name, (low, high) in (subject or {}).items():
        if not low < high:
            yield Problem(f"subject.{name}", [low, high], "a lowest value below the highest is accepted")
    if keep and not contacts(mechanism):
        yield Problem(
            "keep", keep, "accepted only of a mechanism whose joints have clearance and no rigid faces"
        )
    if margin and not keep:
        yield Problem("margin", margin, 'accepted only beside keep = "contact"')


def ideal_fits(mechanism: Mechanism | TestSystem, ideal: bool, orbit: bool) -> Iterator[Problem]:
    """Yield the problems of beginning without play, and of periodic orbits."""
    if ideal and (isinstance(mechanism, TestSystem) or not mechanism.clearance_joints):
        yield Problem("ideal", ideal, "accepted only of a mechanism whose joints have clearance")
    elif ideal and any(joint.prismatic for joint in mechanism.clearance_joints):
        yield Problem("ideal", ideal, "accepted only where no slider has clearance")
    if orbit and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("orbit", orbit, "false is accepted for a system that nothing forces")
    elif orbit:
        yield from turns_alike(mechanism)


def contacts(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the contacts whose force can be kept above a margin."""
    if isinstance(mechanism, TestSystem):
        return ()
    usual = selection.usual_quantities(mechanism)
    return tuple(name.removeprefix("largest:") for name in usual if name.startswith(f"largest:{FORCE}"))
