"""The mechanism in motion, for a page: links in every frame, journals, sliders in guides, forces."""

from __future__ import annotations

from typing import Any

import numpy as np
from xarray import Dataset

from jointplay.display.errors import InputError
from jointplay.figures.drawing import select
from jointplay.solver.equations.structure import CORNERS
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism
from jointplay.study.results.places import places
from jointplay_page import packed

FRAMES = 1200  # of a page


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
    if "swept" in dataset.attrs:
        return None, "The mechanism is not shown in motion: one motion is shown, not those of a sweep."
    if mechanism is None:
        return None, "The mechanism is not shown in motion: the result does not hold it."
    step, loose = -(-dataset.sizes["time"] // FRAMES), mechanism.clearance_joints
    try:
        part = places(mechanism, dataset.isel(time=slice(None, None, step)))
    except InputError as error:
        reasons = "; ".join(problem.expected for problem in error.problems)
        return None, f"The mechanism is not shown in motion: {reasons}."
    thinned = f"one in {step} recorded samples" if step > 1 else "every recorded sample"
    return {
        "time": packed.array(part["time"].values),
        "period": float(part.get("turn_period_nominal", np.nan)),
        "pins": (still := scene(mechanism))["pins"],
        "links": [link | {"frames": frames_of(part.sel(link=link["name"]))} for link in still["links"]],
        "bearings": [bearing(part.sel(joint=each.name), each) for each in loose if not each.prismatic],
        "guides": [guide(part, each) for each in loose if each.prismatic],
        "note": f"{part.sizes['time']} frames, {thinned}.",
    }, ""


def scene(mechanism: Mechanism) -> dict[str, Any]:
    """Return the fixed part of a scene: places of ends and joints on each link, and the joints."""
    pins = [pin for joint in mechanism.joints for pin in (joint.journal, joint.bearing)]
    sliding = {joint.journal.link for joint in mechanism.joints if joint.prismatic}  # drawn as blocks
    along = {
        link.name: sorted(
            {0.0, *(pin.at for pin in pins if pin.link == link.name)}
            | ({link.length} if link.name not in sliding else set())
        )
        for link in mechanism.links
    }
    links = [{"name": name, "along": places} for name, places in along.items()]
    return {"links": links, "pins": [pin_of(joint) for joint in mechanism.joints]}


def frames_of(part: Dataset) -> dict[str, Any]:
    """Return where a link is in every frame: x, y, angle."""
    angle = np.remainder(part["angle"].values, 2 * np.pi)  # whole turns would cost digits
    return packed.array(np.column_stack([part["origin_x"].values, part["origin_y"].values, angle]))


def pin_of(joint: Joint) -> dict[str, Any]:
    """Return where a joint is drawn: at its bearing; of a prismatic one the block and its half sizes too."""
    drawn = {"name": joint.name, "clearance": joint.clearance} | on_link(joint.bearing)
    if not joint.prismatic:
        return drawn
    sizes = None if joint.ideal else [joint.half_length, joint.half_height]
    lines = {"direction": joint.bearing.direction, "sizes": sizes}
    return drawn | lines | {"block": on_link(joint.journal) | {"direction": joint.journal.direction}}


def on_link(pin: Pin) -> dict[str, Any]:
    """Return where a pin is: a point of the ground, or a place along a link."""
    return {"point": list(pin.point)} if pin.link == GROUND else {"link": pin.link, "at": pin.at}


def bearing(part: Dataset, joint: Joint) -> dict[str, Any]:
    """Return a bearing: the journal in it in clearances, and the force on it in every frame."""
    xy = np.stack([part["journal_x"].values, part["journal_y"].values], -1)
    found = {"name": joint.name, "clearance": joint.clearance}
    found["journal"] = packed.array(xy / joint.clearance)
    return found | ({"force": packed.array(part["normal_force"].values)} if "normal_force" in part else {})


def guide(part: Dataset, joint: Joint) -> dict[str, Any]:
    """Return a guide: corners' progress to their faces in clearances, and as recorded contact and forces."""
    pin, corners = joint.bearing, part.sel(joint=list(joint.contacts))
    angle = 0.0 if pin.link == GROUND else part["angle"].sel(link=pin.link).values[:, None]
    sides = np.array([side for _, side in CORNERS.values()])
    x, y = (corners[f"journal_{axis}"].transpose("time", "joint").values for axis in "xy")
    shifts = sides * (y * np.cos(pin.direction + angle) - x * np.sin(pin.direction + angle)) / joint.clearance
    found = {"name": joint.name, "clearance": joint.clearance, "ways": packed.array(shifts)}
    if "mode" in corners:
        touch = [select.in_contact(corners, name) for name in joint.contacts]
        found["touch"] = packed.array(np.stack(touch, -1).astype(float))
    if "normal_force" in corners:
        found["force"] = packed.array(corners["normal_force"].transpose("time", "joint").values)
    return found
