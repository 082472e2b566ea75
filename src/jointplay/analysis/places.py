"""Places of the links over a motion: their origins, from recorded angles and journals, as all joints close.

With the angles known, the origins P of the links follow linearly: at every joint

    P_j + a_j e_j - (P_b + a_b e_b) = r,     r = (journal_x, journal_y), of an ideal joint 0,
    of a prismatic joint r = slide d, d along the guide,

e the directions of the links, a the pins' distances from the origins. Loops give more equations than are
needed; they agree, but for the bending of elastic links (second order in the deflection). Units: m, rad.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from jointplay.errors import NOTHING, InputError, Problem, refuse
from jointplay.mechanism.base import GROUND
from jointplay.mechanism.joints import Joint, Pin
from jointplay.mechanism.records import Mechanism

APART = 1e-3  # of the longest link: where joints miss by more, the motion is another mechanism's


def places(mechanism: Mechanism, motion: xr.Dataset) -> xr.Dataset:
    """Give a motion with the origins of its links.

    Parameters
    ----------
    mechanism : Mechanism
        What moved.
    motion : Dataset
        A response with ``angle`` and, of joints with clearance, ``journal_x`` and ``journal_y``; of prismatic
        ones ``slide_position``.

    Returns
    -------
    Dataset
        The same with ``origin_x`` and ``origin_y`` (time, link), m.

    Raises
    ------
    InputError
        If one of these was not recorded, or the joints do not close with this mechanism's lengths.
    """
    _recorded(mechanism, motion)
    names = [link.name for link in mechanism.links]
    angle = motion["angle"].sel(link=names).transpose("time", "link").values
    A, right = np.zeros((len(mechanism.joints), len(names))), []
    for row, joint in zip(A, mechanism.joints, strict=True):
        r = _apart(joint, motion, angle, names)
        for pin, sign in ((joint.journal, 1.0), (joint.bearing, -1.0)):
            r = r - sign * _arm(pin, angle, names)
            if pin.link != GROUND:
                row[names.index(pin.link)] = sign
        right.append(r)
    b = np.stack(right)  # joint, time, axis
    origins = np.einsum("lj,jta->tla", np.linalg.pinv(A), b)
    missed = np.abs(np.einsum("jl,tla->jta", A, origins) - b).max(initial=0.0)
    longest = max(link.length for link in mechanism.links)
    if not missed <= APART * longest:
        raise refuse(
            mechanism.name, f"the mechanism that moved so: joints miss by {missed:.3g} m", "mechanism"
        )
    variables = {
        f"origin_{axis}": (
            ("time", "link"),
            origins[..., k],
            {"units": "m", "long_name": f"origin of a link, {axis}"},
        )
        for k, axis in enumerate("xy")
    }
    return motion.sel(link=names).assign(variables)


def _recorded(mechanism: Mechanism, motion: xr.Dataset) -> None:
    needed = ["angle"]
    needed += ["journal_x", "journal_y"] * any(not joint.prismatic for joint in mechanism.clearance_joints)
    needed += ["slide_position"] * any(joint.prismatic for joint in mechanism.joints)
    missing = [name for name in needed if name not in motion]
    if "time" not in motion.dims or missing:
        expected = f"a response that records {', '.join(needed)} is accepted"
        raise InputError([Problem("motion", f"no {', '.join(missing) or 'times'}", expected)])
    if absent := {link.name for link in mechanism.links} - {*motion["link"].values.tolist()}:
        raise refuse(NOTHING, f"angles of {', '.join(sorted(absent))} are needed", "motion")


def _arm(pin: Pin, angle: np.ndarray, names: list[str]) -> np.ndarray:
    """A pin's place from its link's origin, shape (time, 2), m."""
    if pin.link == GROUND:
        return np.broadcast_to(np.array(pin.point), (len(angle), 2))
    return pin.at * _unit(angle[:, names.index(pin.link)])


def _apart(joint: Joint, motion: xr.Dataset, angle: np.ndarray, names: list[str]) -> np.ndarray:
    """The journal's place from the bearing's, shape (time, 2), m."""
    if joint.prismatic:
        pin = joint.bearing
        turned = 0.0 if pin.link == GROUND else angle[:, names.index(pin.link)]
        along = _unit(np.broadcast_to(turned + pin.direction, len(angle)))
        return motion["slide_position"].sel(joint=joint.name).values[:, None] * along
    if joint.ideal:
        return np.zeros((len(angle), 2))
    return np.stack([motion[f"journal_{axis}"].sel(joint=joint.name).values for axis in "xy"], -1)


def _unit(angle: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angle), np.sin(angle)], -1)
