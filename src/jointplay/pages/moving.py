"""The mechanism in motion, for a page: links in every frame, the journal in each bearing, the force on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from xarray import Dataset

from jointplay.figures.drawing import select
from jointplay.mechanism import positions
from jointplay.mechanism.base import GROUND
from jointplay.mechanism.records import Mechanism
from jointplay.pages import packed

FRAMES = 1200  # of a page
CLOSED = 1e-3  # of all links together: a wider gap in a joint means angles of another mechanism
NEEDS = "angle"


def moving(dataset: Dataset, mechanism: Mechanism | None) -> tuple[dict[str, Any] | None, str]:
    """Return the motion of a response, ready for `packed.text`, or None and why there is none.

    Parameters
    ----------
    dataset : Dataset
        A result.
    mechanism : Mechanism, optional
        What moved.
    """
    if "time" not in dataset.dims or not dataset.sizes["time"] or "link" not in dataset.dims:
        return None, ""
    if mechanism is None:
        return None, "The mechanism is not shown in motion: the result does not hold it."
    names = [link.name for link in mechanism.links]
    if NEEDS not in dataset or not set(names) <= set(select.labels(dataset, "link")):
        return (
            None,
            "The mechanism is not shown in motion: record its angles for that (record = ['angle', ...]).",
        )
    step = -(-dataset.sizes["time"] // FRAMES)
    part = dataset.isel(time=slice(None, None, step))
    angles = {name: part["angle"].sel(link=name).values for name in names}
    played = loose(part)
    slides = {name: values(part, "slide_position", name) for name in sliding(part, mechanism)}
    places = positions.origins(mechanism, angles, {name: xy for name, (xy, _) in played.items()}, slides)
    if gap(mechanism, angles, places, played) > CLOSED * sum(link.length for link in mechanism.links):
        return None, "The mechanism is not shown in motion: its joints do not close at the recorded angles."
    thinned = f"every {step}th recorded sample" if step > 1 else "every recorded sample"
    return {
        "time": packed.array(part["time"].values),
        "period": float(part.get("turn_period_nominal", np.nan)),
        "links": [link_of(mechanism, name, angles[name], places[name]) for name in names],
        "pins": [pin_of(joint) for joint in mechanism.joints],
        "bearings": [bearing(part, mechanism, name, *each) for name, each in played.items()],
        "note": f"{part.sizes['time']} frames, {thinned}.",
    }, ""


def sliding(part: Dataset, mechanism: Mechanism) -> list[str]:
    """Return the prismatic joints whose slides are recorded."""
    names = [joint.name for joint in mechanism.joints if joint.prismatic]
    return [name for name in names if "slide_position" in part and name in select.labels(part, "joint")]


def values(part: Dataset, name: str, joint: str) -> np.ndarray:
    """Return a variable of one joint over time."""
    return part[name].sel(joint=joint).values


def loose(part: Dataset) -> dict[str, tuple[np.ndarray, np.ndarray | None]]:
    """Return of each joint with recorded play the eccentricity, m, and the force, N."""
    if not {"journal_x", "journal_y"} <= set(part.data_vars):
        return {}
    found = {}
    for joint in select.labels(part, "joint"):
        xy = np.stack([values(part, name, joint) for name in ("journal_x", "journal_y")], -1)
        force = values(part, "normal_force", joint) if "normal_force" in part else None
        if np.isfinite(xy).all():
            found[joint] = xy, force
    return found


def gap(mechanism: Mechanism, angles: dict, places: dict, played: dict) -> float:
    """Return the widest gap in any revolute joint beyond its recorded or possible play, m."""
    widest = 0.0
    for joint in mechanism.joints:
        if not joint.prismatic:
            ends = (positions.pin_positions(pin, angles, places) for pin in (joint.journal, joint.bearing))
            apart = np.subtract(*ends) - (played[joint.name][0] if joint.name in played else 0.0)
            widest = max(widest, float(np.hypot(*apart.T).max()) - joint.clearance)
    return widest


def link_of(mechanism: Mechanism, name: str, angle: np.ndarray, place: np.ndarray) -> dict[str, Any]:
    """Return a link: where its ends are along it, and where it is in every frame (x, y, angle)."""
    pins = (pin for joint in mechanism.joints for pin in (joint.journal, joint.bearing))
    length = next(link.length for link in mechanism.links if link.name == name)
    along = sorted({0.0, length, *(pin.at for pin in pins if pin.link == name)})
    turned = np.column_stack([place, np.remainder(angle, 2 * np.pi)])  # whole turns would cost digits
    return {"name": name, "along": along, "frames": packed.array(turned)}


def pin_of(joint: Any) -> dict[str, Any]:
    """Return where a joint is drawn: at its bearing."""
    pin = joint.bearing
    on = {"point": list(pin.point)} if pin.link == GROUND else {"link": pin.link, "at": pin.at}
    guide = {"direction": pin.direction} if joint.prismatic else {}
    return {"name": joint.name, "clearance": joint.clearance} | on | guide


def bearing(part: Dataset, mechanism: Mechanism, name: str, xy: np.ndarray, force: Any) -> dict[str, Any]:
    """Return a bearing: the journal in it in clearances, and the force on it in every frame."""
    clearance = mechanism.joint(name).clearance
    found = {"name": name, "clearance": clearance, "journal": packed.array(xy / clearance)}
    return found | ({} if force is None else {"force": packed.array(force)})
