"""Motions of linkages made of closed forms: no equation is solved for them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from jointplay import catalog
from jointplay.mechanism.pose import start_pose
from jointplay.mechanism.records import Mechanism

PERIOD = 0.1  # s


def four_bar(samples: int = 41) -> tuple[Mechanism, xr.Dataset]:
    """The paper's four-bar, its links at angles that nobody coupled; the journal at B is where that leads."""
    mechanism = catalog.chunmei2002(clearance={"B": 2.9e-2})
    crank, coupler, rocker = (mechanism.link(name).length for name in ("crank", "coupler", "rocker"))
    ground = mechanism.joint("C").bearing.point[0]
    turn = np.linspace(0, 2 * np.pi, samples)
    angles = {"crank": turn, "coupler": 0.7 + 0.1 * np.sin(turn), "rocker": 1.8 + 0.2 * np.cos(turn)}

    def unit(name: str) -> np.ndarray:
        return np.stack([np.cos(angles[name]), np.sin(angles[name])], -1)

    A = crank * unit("crank")
    C = np.broadcast_to([ground, 0.0], A.shape)
    r = A + coupler * unit("coupler") - C - rocker * unit("rocker")
    origins = {"crank": np.zeros(A.shape), "coupler": A, "rocker": C}
    data = {f"journal_{axis}": (("time", "joint"), r[:, [k]]) for k, axis in enumerate("xy")}
    data["normal_force"] = (("time", "joint"), 100 * np.abs(np.sin(turn))[:, None])
    return mechanism, _dataset(mechanism, turn, angles, origins, data, ["B"])


def slides(mechanism: Mechanism, samples: int = 13) -> xr.Dataset:
    """An ideal mechanism led through its poses."""
    turn = np.linspace(0, 2 * np.pi, samples)
    poses = [start_pose(mechanism, {"crank_angle": angle}) for angle in turn]
    links = [link.name for link in mechanism.links]
    angles = {name: np.array([pose.angles[name] for pose in poses]) for name in links}
    origins = {name: np.array([pose.origins[name] for pose in poses]) for name in links}
    guides = [joint for joint in mechanism.joints if joint.prismatic]
    ways = [
        [
            (pose.point(joint.journal) - pose.point(joint.bearing))
            @ [np.cos(angle := pose.direction(joint.bearing)), np.sin(angle)]
            for joint in guides
        ]
        for pose in poses
    ]
    data = {"slide_position": (("time", "joint"), np.array(ways))}
    return _dataset(mechanism, turn, angles, origins, data, [joint.name for joint in guides])


def _dataset(mechanism, turn, angles, origins, data, joints) -> xr.Dataset:
    links = [link.name for link in mechanism.links]
    data |= {"angle": (("time", "link"), np.stack([angles[name] for name in links], -1))}
    data |= {
        f"true_{axis}": (("time", "link"), np.stack([origins[name][:, k] for name in links], -1))
        for k, axis in enumerate("xy")
    }
    data |= {"status": ((), 0), "turn_period_nominal": ((), PERIOD)}
    coords = {"time": PERIOD * turn / (2 * np.pi), "link": links, "joint": joints}
    attrs = {"kind": "response", "mechanism": mechanism.model_dump_json()}
    return xr.Dataset(data, coords, attrs)
