"""Variables of a point of a bifurcation diagram, with their names and units."""

from __future__ import annotations

from typing import Any

import numpy as np

from jointplay.analysis.exponents import batch_means, section_exponents
from jointplay.analysis.labels import flags
from jointplay.jobs.columns import Plain, shared
from jointplay.jobs.job import Entry
from jointplay.solver.motion.eligibility import ROUTES

NOT_KNOWN = -1  # of whole numbers, as a period
LABELLED = {"link": "link", "joint": "joint with clearance", "pin": "ideal joint", "guide": "prismatic joint"}
LABELLED |= {"state": "state"}
ATTRIBUTES = {
    "period": ("1", "period in section points"),
    "turn_period": ("s", "mean period of a turn"),
    "impacts": ("1", "contacts begun per turn"),
    "separations": ("1", "contacts lost per turn"),
    "contact_fraction": ("1", "fraction of time in contact"),
    "smallest_impact_speed": ("m s-1", "smallest speed at which a contact began"),
    "smallest_missed_gap": ("m", "smallest gap of an approach that missed contact"),
    "mode_word": ("1", "contact modes of the turn, one after another"),
    "end_state": ("1", "positions and speeds at the end"),
    "n_steps": ("1", "accepted steps"),
    "followed": ("1", "how the motion was followed"),
    "exponents_followed": ("1", "how the motion was followed while exponents were measured"),
}
OUTS = batch_means.ESTIMATES | section_exponents.OUTS
ATTRIBUTES |= {name: (out.units, out.long_name) for name, out in OUTS.items()}
COMMENTS = {
    "period": "turns, where the section is a crank angle; 0: none within period_tolerance; -1: not known",
    "mode_word": "f free, r released, + - slip, s stick, c contact; of a test system the walls met",
    "end_state": "rad, m, rad/s, m/s; accepted as a start",
}
LENGTHS = ("smallest_impact_speed", "smallest_missed_gap")  # a test system's have no units


def labelled(motion: Entry, keep: int) -> Entry:
    """Answer of a cell from a result of `attractor.settle`, with `keep` section points.

    A motion that failed has the number of its steps alone.
    """
    names = motion.get("labels", {}) | ({"state": motion["end"].names} if "end" in motion else {})
    values = motion.get("values", {}) | {"n_steps": ((), motion.get("n_steps", 0))}
    if "end" in motion:
        values["end_state"] = (("state",), motion["end"].state)
    rows = motion.get("points", {}).items()
    si = bool(names.get("link"))
    parts = {name: (dims, _padded(dims, each, keep), own) for name, (dims, each, own) in rows}
    parts |= {name: (*pair, attributes(name, si or name not in LENGTHS)) for name, pair in values.items()}
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


def attributes(name: str, si: bool = True) -> dict[str, str]:
    """Attributes of a variable of a sweep; without units, as a test system's lengths, unless `si`."""
    units, text = ATTRIBUTES[name]
    more = {"comment": COMMENTS[name]} if name in COMMENTS else {}
    more |= flags(ROUTES) if name.endswith("followed") else {}
    return {"units": units if si else "1", "long_name": text} | more
