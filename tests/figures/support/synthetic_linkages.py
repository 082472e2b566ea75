"""Motions of linkages made of closed forms: no equation is solved for them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from jointplay import catalog
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import start_pose

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


def loose_guide(samples: int = 41) -> tuple[Mechanism, xr.Dataset]:
    """A slider-crank with play at B and G, led by hand: the slider tilts, rises and falls."""
    play = 1e-3
    mechanism = catalog.slider_crank(clearance={"B": play, "G": play}, gravity=9.81)
    crank, rod = (mechanism.link(name).length for name in ("crank", "rod"))
    guide = mechanism.joint("G")
    turn = np.linspace(0, 2 * np.pi, samples)
    lean = np.arcsin(-crank / rod * np.sin(turn))
    angles = {"crank": turn, "rod": lean, "slider": 0.4 * play / guide.half_length * np.sin(2 * turn)}
    end = np.stack([crank * np.cos(turn) + rod * np.cos(lean), np.zeros(samples)], -1)
    place = end + np.stack([np.zeros(samples), 0.75 * play * np.cos(turn)], -1)
    A = crank * np.stack([np.cos(turn), np.sin(turn)], -1)
    origins = {"crank": np.zeros(A.shape), "rod": A, "slider": place}
    ways, forces = corners_led(mechanism, angles["slider"], place)
    names = ["B", *guide.contacts]
    across = np.concatenate([(end - place)[:, 1:], ways * np.array([1, 1, -1, -1])], 1)
    data = {
        "journal_x": (("time", "joint"), np.zeros(across.shape)),
        "journal_y": (("time", "joint"), across),
    }
    strength = np.concatenate([np.full((samples, 1), 5.0), forces], 1)
    data |= {"normal_force": (("time", "joint"), strength)}
    meaning = {"flag_values": [0, 1], "flag_meanings": "free slip_positive"}
    data |= {"mode": (("time", "joint"), (strength > 0).astype(np.int8), meaning)}
    data |= {"slide_position": (("time", "joint"), np.repeat(place[:, :1], len(names), 1))}
    return mechanism, _dataset(mechanism, turn, angles, origins, data, names)


def corners_led(mechanism: Mechanism, tilt: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ways of the corners towards their faces, m, of a slider so tilted and placed; a force from 0.9 e on."""
    guide = mechanism.joint("G")
    a, b, e = guide.half_length, guide.half_height, guide.clearance
    sides = [(1, 1), (-1, 1), (1, -1), (-1, -1)]  # along, across
    rise = [place[:, 1] + p * a * np.sin(tilt) + s * b * np.cos(tilt) for p, s in sides]
    ways = np.stack([s * height - b for (_, s), height in zip(sides, rise, strict=True)], -1)
    return ways, 100 * np.maximum(ways / e - 0.9, 0.0)
