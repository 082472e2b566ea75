"""What an optimum is held against: the motion from the usual start, and the designs beside it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.gradients.gradient import gradient, start_section
from jointplay.analysis.gradients.multipliers import MULTIPLIERS
from jointplay.analysis.labels import number
from jointplay.analysis.optima.trials import Aim, Trial, Trials
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.simulate import simulate
from jointplay.display.errors import ModelWarning
from jointplay.solver.mechanism.records import Mechanism, TestSystem

if TYPE_CHECKING:
    import xarray as xr

TIGHT, SHOWN = 1e-10, 20  # tolerance of the runs; turns of them
DRAWN, SAMPLES = 2, 720  # turns that are drawn; samples of each
EXTREMES = ("largest", "smallest")


def beside(trials: Trials, aim: Aim, found: Trial, share: float, tolerance: float) -> dict[str, Any]:
    """The optimum's neighbours: each variable changed by a share of its value, within its bounds."""
    value, allowed = np.full((len(trials.by), 2), np.nan), np.zeros((len(trials.by), 2), dtype=bool)
    at = trials.low + trials.width * found.x
    for i in range(len(at)) if not found.status else ():
        for side, sign in enumerate((-1, 1)):
            x = found.x.copy()
            x[i] = np.clip(x[i] + sign * share * (abs(at[i]) or trials.width[i]) / trials.width[i], 0, 1)
            other = trials.tried(x) if x[i] != found.x[i] else found
            if other is not found and not other.status:
                value[i, side] = aim.shown(other)
                allowed[i, side] = aim.missed(other) <= max(tolerance, aim.missed(found))
    best = aim.shown(found) if not found.status else np.nan
    gain = np.where(allowed, aim.sign * (best - value), np.nan)
    most = np.max(gain, initial=-np.inf, where=np.isfinite(gain)) if np.isfinite(gain).any() else 0.0
    both = ("parameter", "side")
    return {
        "neighbour_objective": number(both, value, "1", "objective beside the optimum"),
        "neighbour_allowed": number(both, allowed, "1", "whether the constraints are kept there"),
        "neighbour_gain": number((), max(most, 0.0), "1", "by how much the best allowed neighbour is better"),
    }


def followed(
    mechanism: Mechanism | TestSystem,
    names: Sequence[str],
    by: Mapping[str, Any],
    settings: Mapping[str, Any],
) -> tuple[np.ndarray, xr.Dataset | None]:
    """Quantities of a motion from its start, after the transient, at rtol 1e-10; its course, if any.

    Extreme values are those of 20 turns, all else is of as many turns as asked for. Multipliers are NaN: an
    orbit alone has them.
    """
    run = {"initial": settings["initial"], "max_steps": settings["max_steps"], "rtol": TIGHT}
    values, words = np.full(len(names), np.nan), [name.partition(":")[0] for name in names]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        state = _settled(mechanism, settings["transient"], run) if settings["orbit"] else run["initial"]
        if settings["orbit"] and state is None:
            return values, None
        for extreme in (True, False):
            places = [
                i for i, word in enumerate(words) if (word in EXTREMES) == extreme and word not in MULTIPLIERS
            ]
            turns = SHOWN if extreme and settings["orbit"] else settings["turns"]
            if places:
                asked = {"of": [names[i] for i in places], "by": list(by), "turns": turns}
                values[places] = gradient(mechanism, **asked, **run | {"initial": state})["value"].values
        return values, _course(mechanism, names, settings, run)


def _settled(mechanism: Mechanism | TestSystem, transient: int, run: Mapping[str, Any]) -> list[float] | None:
    """The state after the transient, None where the motion does not get there."""
    cut = start_section(mechanism, run["initial"], 1, run["rtol"], run["max_steps"])
    image = cut.image(cut.model.state, False, max(transient, 1))
    return None if image.status else [float(each) for each in image.state]


def _course(
    mechanism: Mechanism | TestSystem,
    names: Sequence[str],
    settings: Mapping[str, Any],
    run: Mapping[str, Any],
) -> xr.Dataset | None:
    """The first recorded quantity among those named, over the turns."""
    keys = [name.partition(":")[2] for name in names]
    linkage = isinstance(mechanism, Mechanism)
    known = [key for key in keys if key.partition(":")[0] in (WORDS if linkage else ("state",))]
    whole = linkage and run["initial"] is not None and not isinstance(run["initial"], dict)
    if not known or whole:  # of a state written out there are no time histories
        return None
    word, _, label = known[0].partition(":")
    word = word if linkage else "state_value"
    turns = {"turns": max(settings["turns"], DRAWN), "transient": settings["transient"]}
    turns = turns if settings["orbit"] else {"turns": settings["turns"]}
    found = simulate(mechanism, **turns, samples_per_turn=SAMPLES, record=[word], **run)[word]
    dims = [dim for dim in found.dims if dim != "time"]
    return found.sel({dims[0]: label}) if dims else found
