"""Places of the links over a recorded motion: input of `mechanism.loops.positions`, read from a result."""

from __future__ import annotations

import numpy as np

from jointplay.analysis.labels import xr
from jointplay.display.errors import NOTHING, InputError, Problem, refuse
from jointplay.solver.mechanism.loops.positions import gap, origins
from jointplay.solver.mechanism.records import Mechanism

APART = 1e-3  # of the longest link: where joints miss by more, the motion is another mechanism's


def places(mechanism: Mechanism, motion: xr.Dataset) -> xr.Dataset:
    """Give a motion with the origins of its links.

    Parameters
    ----------
    mechanism : Mechanism
        What moved.
    motion : Dataset
        A response with ``angle`` and, of bearings with clearance, ``journal_x`` and ``journal_y``; of guides
        also ``slide_position``, if it is there.

    Returns
    -------
    Dataset
        The same with ``origin_x`` and ``origin_y`` (time, link), m.

    Raises
    ------
    InputError
        If one of these was not recorded, if there are several motions, or if the joints do not close with
        this mechanism's lengths.
    """
    loose = [joint.name for joint in mechanism.clearance_joints if not joint.prismatic]
    _recorded(mechanism, motion, ["angle"] + ["journal_x", "journal_y"] * bool(loose))
    names = [link.name for link in mechanism.links]
    angles = {name: motion["angle"].sel(link=name).values for name in names}
    apart = {name: np.stack([_of(motion, f"journal_{axis}", name) for axis in "xy"], -1) for name in loose}
    slides = {
        joint.name: _of(motion, "slide_position", label)
        for joint in mechanism.joints
        for label in ((*joint.contacts, joint.name)[:1] if joint.prismatic else ())
        if "slide_position" in motion and label in motion["joint"].values
    }
    found = origins(mechanism, angles, apart, slides)
    missed, longest = gap(mechanism, angles, found, apart), max(link.length for link in mechanism.links)
    if not missed <= APART * longest:
        that = f"joints of this one are {missed:.3g} m apart"
        raise refuse(mechanism.name, f"the mechanism that moved like this is accepted; {that}", "mechanism")
    variables = {}
    for k, axis in enumerate("xy"):
        values = np.stack([found[name][:, k] for name in names], 1)
        attrs = {"units": "m", "long_name": f"origin of a link, {axis}"}
        variables[f"origin_{axis}"] = (("time", "link"), values, attrs)
    return motion.sel(link=names).assign(variables)


def _of(motion: xr.Dataset, name: str, joint: str) -> np.ndarray:
    """A variable of one joint, or of one contact, over time."""
    return motion[name].sel(joint=joint).values


def _recorded(mechanism: Mechanism, motion: xr.Dataset, needed: list[str]) -> None:
    missing = [name for name in needed if name not in motion]
    if "time" not in motion.dims or missing:
        expected = f"a response that records {', '.join(needed)} is accepted"
        raise InputError([Problem("motion", f"no {', '.join(missing) or 'times'}", expected)])
    if more := [dim for dim in motion["angle"].dims if dim not in ("time", "link")]:
        raise refuse(f"motions over {', '.join(more)}", "one motion is accepted: select it", "motion")
    if absent := {link.name for link in mechanism.links} - {*motion["link"].values.tolist()}:
        raise refuse(NOTHING, f"angles of {', '.join(sorted(absent))} are needed", "motion")
