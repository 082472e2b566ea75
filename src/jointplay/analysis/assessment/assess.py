"""The assessment of a linkage with clearance: how hard its joints are worked, and how near other motions are.

The present motion's forces are held against those of the same linkage with ideal joints (`forces`); from its
present value outward, each clearance and the drive's speed is followed to where contact is first lost or
kept, the motion first leaves or reaches period 1, and chaos begins or ends (`edges`).
Validity: of the one motion that is followed, from the start given; where others coexist, each has its own.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.assessment import assess_dataset
from jointplay.analysis.assessment.edges import SIDES, Search, edges
from jointplay.analysis.assessment.forces import WORK, forces
from jointplay.analysis.assessment.settled import LASTING, plan
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import Moving, Names, Progress, Rtol, Small, Start, analysis
from jointplay.analysis.labels import labelled, outcome
from jointplay.analysis.orbits.orbit_request import present
from jointplay.analysis.starts import placed
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import axes, units_of
from jointplay.display.errors import NOTHING, Problem
from jointplay.solver.mechanism.base import Count, Natural, Number, is_number, unit
from jointplay.solver.mechanism.records import Mechanism, TestSystem

if TYPE_CHECKING:
    import xarray as xr

TURNS, TRANSIENT, LYAPUNOV_TURNS, RTOL = 20, 100, 200, 1e-7
REACH, STEP, ACCURACY, LASTS = 2.0, 0.0025, 1e-3, 0.01
LOOKED_AT = 32  # turns in which a settled motion must repeat
SPEEDS = {"motor": "gear_ratio", "speed": "speed"}  # by the kind of drive


def _assessable(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    if not isinstance(mechanism, Mechanism):
        yield Problem("mechanism", mechanism.name, "a linkage is accepted, no test system")
        return
    if not mechanism.clearance_joints:
        yield Problem("mechanism.joints", "no clearance", "clearance in at least one joint is needed")
    for joint in mechanism.clearance_joints:
        if joint.kind == "prismatic":
            where = f"mechanism.joints.{joint.name}.clearance"
            yield Problem(where, joint.clearance, "0 is accepted of a guide: clearance in others is assessed")
    if mechanism.drive is None:
        yield Problem("mechanism.drive", NOTHING, "a drive that turns the crank is needed")


def _along_fits(mechanism: Mechanism | TestSystem, along: Sequence[str] | None) -> Iterator[Problem]:
    if along == () or len({*(along or ())}) < len(along or ()):
        yield Problem("along", along, "one parameter or several, each once, are accepted")
    several = isinstance(mechanism, Mechanism) and len(mechanism.clearance_joints) > 1
    for i, key in enumerate(along or ()):
        place = f"along[{i}]"
        if units_of(mechanism, key) is None:
            axes(mechanism, {key: [0.0]}, "along")  # says which there are
        elif not is_number(value := present(mechanism, key)) or value == 0:
            yield Problem(place, key, "what has a value here, and not 0, is accepted")
        elif key == "clearance" and several:
            yield Problem(
                place, key, "one of several clearances is accepted by its path, joints.NAME.clearance"
            )


@analysis(_assessable, _along_fits, rules.start_fits, rules.turns_alike)
def assess(
    mechanism: Moving,
    *,
    along: Names | None = None,
    reach: Annotated[Number, Field(gt=1, le=100), unit("factor", "1")] = REACH,
    step: Annotated[Small, unit("relative step", "1")] = STEP,
    accuracy: Annotated[Small, unit("relative width", "1")] = ACCURACY,
    lasting: Annotated[Small, unit("relative width", "1")] = LASTS,
    turns: Annotated[Natural, Field(ge=2)] = TURNS,
    transient: Count = TRANSIENT,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    rtol: Rtol = RTOL,
    initial: Start | None = None,
    max_steps: Natural | None = None,
    n_jobs: Natural | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Assess a linkage with clearance: forces, losses, and how far it is from other motions.

    Parameters
    ----------
    mechanism : Mechanism
        With clearance in a joint, and a drive.
    along : sequence of str, optional
        What is varied, each alone, as in `bifurcation`; every clearance, and the motor's gear ratio or the
        constant speed, if left out.
    reach : float
        Each is followed from its present value down to this fraction, and up to this multiple, of it.
    step : float
        Relative distance of the values looked at first; ten times that where the present motion is chaotic,
        twice that beyond the end of period 1. What begins and ends within it may be missed.
    accuracy : float
        Relative distance of the two values that enclose a change in the end; in chaos not below `step`.
    lasting : float
        Share of the parameter over which a change of a chaotic motion has to last. One that does not is a
        window in chaos.
    turns, transient : int
        Turns over which forces are recorded, and turns dropped before the motion is looked at.
    lyapunov_turns : int
        Turns over which the present motion's exponent is averaged; 0.3 of them at other values.
    rtol, initial, max_steps
        As in `bifurcation`.
    n_jobs : int, optional
        Worker processes, 2 if left out.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        Over ``joint``: ``peak_force`` and ``ideal_peak_force`` (N) with errors, ``force_ratio``; of joints
        with clearance ``separations`` and ``impacts`` a turn, ``contact_fraction``, ``impact_speed``,
        ``impact_loss``, ``friction_loss`` and ``sliding_work`` (J per turn) with errors; ``joint_force`` and
        ``ideal_joint_force`` over a turn. ``joint_loss``, the sum of the losses, against ``joint_work``
        and ``drive_work`` (J per turn), equal where nothing else takes energy. Over ``parameter``, ``side``
        and ``change`` (contact_loss, doubling, chaos): ``edge_ratio``, where the trait first differs from the
        ``present`` one, over the parameter's ``present_value``; its error and ``bracket_low`` to
        ``bracket_high``; ``return_ratio``, the first value beyond, of those looked at, where the trait is the
        present one again (NaN: not met); ``found_by`` says how; ``edge_speed`` is the drive's there.
        ``window_low`` to ``window_high`` over the present value, and ``window_period``, are of windows in
        chaos that were met, over ``window``, NaN where there are fewer.
        ``limit_ratio`` is how far was looked, ``values_looked_at`` at how many values, ``side_status`` why no
        further. ``period``, ``section_exponent_per_turn`` with its error; ``preparation`` is the time that
        compiling or loading took, ``step`` the keyword, ``lasting_turns`` how long chaos was followed further
        at each value beside a chaotic motion; ``status``.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    how = plan(transient, LOOKED_AT, lyapunov_turns, rtol, max_steps)
    ideal = mechanism.replace(clearance=0.0)
    model = placed(mechanism, initial)
    warm([model, rules.model_for(mechanism, initial, None, WORK), placed(ideal, None)])
    warm_tangents(model)
    ready = time.perf_counter()
    keys = parameters_of(mechanism) if along is None else along
    work = {"mechanism": mechanism, "start": initial, "turns": turns}
    sides = {"mechanism": mechanism, "start": initial, "search": Search(reach, step, accuracy, lasting)}
    cells = [work, work | {"mechanism": ideal, "start": None}]
    cells += [sides | {"key": key, "side": side} for key in keys for side in SIDES]
    answers = handed_out(answered, [each | {"how": how} for each in cells], progress, n_jobs)
    result = assess_dataset.assembled(mechanism, keys, answers)
    told = {
        "preparation": (ready - began, "s", "time to compile or load functions"),
        "step": (step, "1", "relative distance of the values looked at first"),
        "lasting_share": (lasting, "1", "share of the parameter over which a change of chaos lasts"),
        "lasting_turns": (LASTING[0] * transient, "1", "turns that chaos lasted, beside a chaotic motion"),
    }
    return result.assign(labelled(told) | outcome(assess_dataset.status(answers), began, "how it ended"))


def answered(**keywords: Any) -> dict[str, Any]:
    """Answer of a cell: forces of a motion, or the edges on one side."""
    return edges(**keywords) if "key" in keywords else forces(**keywords)


def parameters_of(mechanism: Mechanism) -> tuple[str, ...]:
    """What is varied unless it is said: every clearance, and what the drive's speed depends on."""
    loose = tuple(f"joints.{joint.name}.clearance" for joint in mechanism.joints if joint.clearance > 0)
    own = SPEEDS.get(mechanism.drive.kind)
    return (*loose, own) if own else loose
