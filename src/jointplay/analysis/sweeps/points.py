"""Variables of a point of a bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.exponents import batch_means, section_exponents
from jointplay.analysis.labels import Out, units
from jointplay.jobs.columns import Plain, shared
from jointplay.jobs.job import Entry
from jointplay.solver.motion.eligibility import ROUTES

if TYPE_CHECKING:
    import xarray as xr

NOT_KNOWN = -1  # of whole numbers, as a period
LABELLED = {"link": "link", "joint": "joint with clearance", "pin": "ideal joint", "guide": "prismatic joint"}
LABELLED |= {"state": "state"}
EXPONENTS = {name: out for name, out in batch_means.ESTIMATES.items() if name.startswith("lyapunov")}
EXPONENTS |= {name: out for name, out in section_exponents.OUTS.items() if out.units == "1"}  # per turn
OUTS = {  # of a test system those along joints are of all its contacts
    "period": Out(
        (),
        "period in section points",
        comment="turns, where the section is a crank angle; 0: none within period_tolerance; -1: not known",
    ),
    "turn_period": Out((), "mean period of a turn", "s"),
    "impacts": Out("joint", "contacts begun per turn"),
    "separations": Out("joint", "contacts lost per turn"),
    "contact_fraction": Out("joint", "fraction of time in contact"),
    "smallest_impact_speed": Out("joint", "smallest speed at which a contact began", "{speed}"),
    "smallest_missed_gap": Out("joint", "smallest gap of an approach that missed contact", "{length}"),
    "mode_word": Out(
        "joint",
        "contact modes of the turn, one after another",
        comment="f free, r released, + - slip, s stick, c contact; of a test system the walls met",
    ),
    "followed": Out((), "how the motion was followed", flags=ROUTES),
    "exponents_followed": Out((), "how the motion was followed while exponents were measured", flags=ROUTES),
    "n_steps": Out((), "accepted steps"),
    "end_state": Out(
        "state", "positions and speeds at the end", comment="rad, m, rad/s, m/s; accepted as a start"
    ),
    **EXPONENTS,
}
NUMBERS = {
    "point": Out("point", "section point"),
    "exponent": Out("exponent", "number of the exponent"),
    "multiplier": Out("multiplier", section_exponents.NUMBER),
}


def counted(found: xr.Dataset) -> xr.Dataset:
    """The dataset of all points, with `NUMBERS`: section points from 0 on, exponents from 1."""
    found.attrs.pop("swept")  # its dimensions are no study's `[vary]`
    own = {dim: out for dim, out in NUMBERS.items() if dim in found.dims}
    numbers = {dim: np.arange(found.sizes[dim]) + (dim != "point") for dim in own}
    return found.assign_coords({dim: out.variable(numbers[dim]) for dim, out in own.items()})


def labelled(motion: Entry, keep: int) -> Entry:
    """Answer of a cell from a result of `attractor.settle`, with `keep` section points.

    A motion that failed has the number of its steps alone.
    """
    names = motion.get("labels", {}) | ({"state": motion["end"].names} if "end" in motion else {})
    values = motion.get("values", {}) | {"n_steps": ((), motion.get("n_steps", 0))}
    if "end" in motion:
        values["end_state"] = (("state",), motion["end"].state)
    rows = motion.get("points", {}).items()
    of = units(bool(names.get("link")))
    parts = {name: (dims, _padded(dims, each, keep), own) for name, (dims, each, own) in rows}
    parts |= {name: (*pair, OUTS[name].attributes(of)) for name, pair in values.items()}
    used = {dim for dims, *_ in parts.values() for dim in dims}
    labels = {
        dim: ((dim,), np.array(names[dim], dtype=str), {"long_name": text})
        for dim, text in LABELLED.items()
        if dim in used
    }
    fields = [
        (part, name, dims, own)
        for part, each in (("variables", parts), ("coords", labels))
        for name, (dims, _, own) in each.items()
    ]
    arrays = [np.asarray(each) for _, each, _ in (*parts.values(), *labels.values())]
    kept = {key: motion[key] for key in ("status", "trouble", "end") if key in motion}
    return kept | {"dataset": Plain(shared(fields, {}), arrays)}


def _padded(dims: tuple[str, ...], values: Any, keep: int) -> np.ndarray:
    """Values of section points, filled up to `keep` points."""
    values = np.asarray(values)
    missing = [(0, keep - n if dim == "point" else 0) for dim, n in zip(dims, values.shape, strict=True)]
    none = NOT_KNOWN if values.dtype.kind == "i" else np.nan
    return np.pad(values, missing, constant_values=none) if np.any(missing) else values
