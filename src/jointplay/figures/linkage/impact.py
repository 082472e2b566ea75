"""The hardest impact of a motion, and the stretch of time around it that a film or a sheet shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from jointplay.display import codes
from jointplay.display.units import measure
from jointplay.figures.drawing import select, window_panels
from jointplay.solver.mechanism.parts.joints import Joint

if TYPE_CHECKING:
    from xarray import Dataset

NEAR = 0.125  # turns to either side of an impact beyond which a sheet shows nothing
EDGES = ("contact", "separation", "impact", "rest")  # events between which a journal flies or touches


@dataclass(frozen=True)
class Hit:
    """The hardest impact of a motion: when it begins, s, at which contact, and what it is in words."""

    time: float
    contact: str
    words: str


def hardest(motion: Dataset, joints: Sequence[Joint]) -> Hit | None:
    """The impact of the largest speed at some joints; without recorded speeds, the largest normal force."""
    named = {contact: joint.name for joint in joints for contact in joint.contacts}
    contacts = list(named)
    if not contacts:
        return None
    hits = events(motion, contacts, ("contact", "impact"))
    if hits.size and "event_normal_velocity" in motion:
        speeds = np.nan_to_num(np.abs(motion["event_normal_velocity"].values[hits]))
        hit, speed = hits[np.argmax(speeds)], measure(speeds.max(), "m s-1", 3)
        contact = select.labels(motion, "joint")[int(motion["event_joint"][hit])]
        return Hit(float(motion["event_time"][hit]), contact, f"{named[contact]} hits at {speed}")
    if "normal_force" not in motion:
        return None
    force = motion["normal_force"].sel(joint=contacts).transpose("time", "joint").values
    i, k = np.unravel_index(np.argmax(np.nan_to_num(force)), force.shape)
    return Hit(float(motion["time"][i]), contacts[k], f"largest force at {named[contacts[k]]}")


def events(motion: Dataset, contacts: Sequence[str], kinds: Sequence[str]) -> np.ndarray:
    """Numbers of the recorded events of some kinds at some contacts."""
    if not {"event_kind", "event_joint"} <= set(motion):
        return np.zeros(0, dtype=int)
    labels, known = select.labels(motion, "joint"), codes.flags(motion["event_kind"])
    there = np.isin(motion["event_joint"], [labels.index(each) for each in contacts])
    return np.flatnonzero(
        there & np.isin(motion["event_kind"], [c for c, kind in known.items() if kind in kinds])
    )


def turn(motion: Dataset) -> float:
    """A nominal turn, s; of a motion without one, its length."""
    period = float(motion.get("turn_period_nominal", np.inf))
    return period if period < np.inf else float(np.ptp(motion["time"]))


def turn_around(motion: Dataset, time: float) -> Dataset:
    """The turn around a time, of a motion recorded in windows within one; all of what is shorter."""
    panes = [each.samples for each in window_panels.panes(motion)]
    pane = next((each for each in panes if time <= each["time"][-1]), panes[-1])
    times, length = pane["time"].values, turn(motion)
    begin = max(min(time - length / 2, times[-1] - length), times[0])
    slack = 1e-9 * length
    return pane.isel(time=np.flatnonzero((times >= begin - slack) & (times <= begin + length + slack)))


def phases(motion: Dataset, hit: Hit, peak: float) -> tuple[float, float]:
    """Begin of the flight before an impact, s, and end of that after it: the second edge after its peak."""
    begin, end = hit.time - NEAR * turn(motion), hit.time + NEAR * turn(motion)
    found = events(motion, [hit.contact], EDGES)
    edges = motion["event_time"].values[found] if found.size else np.zeros(0)
    before, after = edges[edges < hit.time], edges[edges > peak]
    return max([begin, *before[-1:]]), min([end, *after[1:2]])
