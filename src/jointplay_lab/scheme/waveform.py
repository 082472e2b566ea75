"""The paper's own scheme: waveform relaxation between a rigid mechanism and the modes of its elastic links.

Reference: Chunmei, Yang, Ling and Ling (2002), section 3. Turn by turn: (1) the rigid mechanism for one turn
by fixed steps of Runge and Kutta's fourth-order method, from the end of the turn before; (2) its motion and
its forces load the modes of each elastic link, whose response follows by mode superposition; (3) the modes'
accelerations, as given functions of time, go back into the rigid turn; (4) again; (5) until two passes over a
turn agree. What they agree on is, as the step shrinks, the motion with ``order="paper"``: of second order in
the step where nothing switches, of first where contacts come and go, which are not located.

The passes need not converge over a whole turn (see `scheme_comparison`): a turn may be cut into windows that
are relaxed one after another.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import RUN, attributes
from jointplay.analysis.keywords import Moving, Progress, Start, analysis
from jointplay.analysis.labels import Out
from jointplay.analysis.quantities import STATUS, recorded
from jointplay.analysis.simulate import SAMPLES_PER_TURN
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Natural, Positive
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_lab.paper.fixed_steps import accepted_step
from jointplay_lab.scheme.scheme import Pass, Scheme


@dataclass(frozen=True)
class Grid:
    """Steps of a window, and the number of steps from sample to sample."""

    h: float
    count: int
    every: int

    @property
    def kept(self) -> int:
        """Samples of a window, its start left out."""
        return self.count // self.every

    @classmethod
    def of(cls, model: Model, step: float, windows: int, samples: int = SAMPLES_PER_TURN) -> Grid:
        """The longest steps, at most `step`, that cut a window of a nominal turn into equal parts."""
        window, kept = model.period / windows, max(1, round(samples / windows))
        every = math.ceil(window / step / kept * (1.0 - 1e-12))
        return cls(window / (every * kept), every * kept, every)


def elastic_mechanism(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Yield the problem of a mechanism without elastic links."""
    if not isinstance(mechanism, Mechanism):
        yield Problem("mechanism", mechanism, "a Mechanism is accepted, such as catalog.chunmei2002()")
    elif not mechanism.elastic_links:
        names = ", ".join(link.name for link in mechanism.links)
        yield Problem("mechanism.elastic", [], f"at least one elastic link is accepted, of {names}")
    elif (mechanism.drive and mechanism.drive.transient) or any(load.timed for load in mechanism.loads):
        text = "a drive and loads that do not depend on time are accepted: a pass of the scheme begins at 0"
        yield Problem("mechanism", mechanism, text)


ONE = "in the turn, the largest of its windows"
OUTPUTS = Outputs(
    "waveform",
    {"time": Out("time", "time", "s")},
    {
        "QUANTITY": Out("time", "what is usually recorded, up to the last window within measure", ""),
        "passes": Out("turn", f"passes done {ONE}"),
        "mean_passes": Out("turn", "passes done in the turn, mean of its windows"),
        "last_change": Out("turn", f"relative change of the last pass {ONE}"),
        "converged": Out("turn", "whether the passes of the turn agree"),
        "change": Out(
            ("turn", "pass"),
            f"relative change from the pass before {ONE}",
            about="a window that has converged keeps its last",
        ),
        "step": Out((), "step of the rigid passes and of the mode superposition", "s"),
        **{name: RUN[name] for name in ("wall_time", "turn_period_nominal", "status")},
    },
)


@analysis(elastic_mechanism, "model", outputs=OUTPUTS)
def waveform(
    mechanism: Moving,
    *,
    turns: Natural = 1,
    step: Positive | None = None,
    passes: Natural = 20,
    tolerance: Positive = 1e-6,
    initial: Start | None = None,
    windows_per_turn: Natural = 1,
    progress: Progress = None,
) -> xr.Dataset:
    """Follow a motion by the paper's own scheme.

    ``status`` is not_converged where a turn did not converge, diverged where a pass grew beyond measure,
    which ends the run.

    Parameters
    ----------
    mechanism : Mechanism
        With at least one elastic link; its inertia terms are taken as with ``order="paper"``.
    turns : int
        Nominal turns of the crank.
    step : float, optional
        Longest step, s; at most the longest stable one, and half of it if left out.
    passes : int
        At most, over a window.
    tolerance : float
        Change at which two passes over a window agree: of the deflections relative to the largest so far, and
        of the speeds relative to the crank's nominal one.
    initial : mapping, optional
        As in `simulate`.
    windows_per_turn : int
        Windows of equal length that are relaxed one after another; 1 is the paper's.
    progress : callable, optional
        Called with the fraction done.

    Raises
    ------
    InputError
        If anything asked for makes no sense, or the step is too long.
    """
    model = assemble(mechanism, initial, relaxed=True)
    grid = Grid.of(model, accepted_step(model, step), windows_per_turn)
    scheme, began, windows = Scheme(model, grid.h), time.perf_counter(), turns * windows_per_turn
    parts, changes = [], [[] for _ in range(windows)]
    for visit in scheme.relax(scheme.start(), grid.count, windows, passes, tolerance):
        changes[visit.window].append(visit.change)
        if visit.last and visit.done.finite:
            parts.append(visit.done.thinned(grid.every, first=not parts))
        if visit.last and progress is not None:
            progress((visit.window + 1) / windows)
    wall_time, values = time.perf_counter() - began, _turns(changes, passes, windows_per_turn, tolerance)
    status = "ok" if np.all(values["converged"]) else "not_converged"
    values["status"] = STATUS.index(status if len(parts) == windows else "diverged")
    values |= {"step": grid.h, "wall_time": wall_time, "turn_period_nominal": model.period}
    values["time"], histories = _histories(mechanism, scheme, parts)
    groups, settings = {"QUANTITY": histories}, {"windows_per_turn": windows_per_turn, "tolerance": tolerance}
    return OUTPUTS.dataset(values, model=model, groups=groups, **settings)


def _turns(changes: list[list[float]], passes: int, windows: int, tolerance: float) -> dict[str, Any]:
    """Passes and changes of each turn, from the changes of every window's passes (none where not reached)."""
    done = np.array([len(each) for each in changes]).reshape(-1, windows)
    last = [each[-1] if each else math.inf for each in changes]
    missing = [passes - max(len(each), 1) for each in changes]
    held = [[math.nan, *c[1:]] + [end] * n for c, end, n in zip(changes, last, missing, strict=True)]
    settled = np.array(last).reshape(-1, windows).max(axis=1)
    change, converged = np.array(held).reshape(-1, windows, passes).max(axis=1), settled <= tolerance
    found = {"passes": done.max(axis=1), "mean_passes": done.mean(axis=1), "last_change": settled}
    return found | {"converged": converged.astype(np.int8), "change": change}


def _histories(mechanism: Mechanism, scheme: Scheme, parts: list[Pass]) -> tuple[np.ndarray, dict[str, Any]]:
    """Times, and quantities over time."""
    model = scheme.model
    rows, loads, bent = (
        np.concatenate([getattr(part, name) for part in parts]) if parts else np.zeros((0, width))
        for name, width in (
            ("rows", 1 + len(model.state) + len(model.joints)),
            ("loads", len(scheme.loaded)),
            ("deflection", len(model.links)),
        )
    )
    names = [name for name in recorded(None, mechanism) if name != "deflection"]
    found = scheme.quantities(rows, loads).variables(names, "time")
    found["deflection"] = (("time", "link"), bent, attributes("deflection"))
    return rows[:, 0], found
