"""Datasets as the analyses return them, of a point that goes about in a circular clearance."""

from functools import lru_cache

import numpy as np
import xarray as xr

from jointplay.analysis.quantities import EVENTS, MODES, STATUS
from jointplay.solver.method.codes import Mode

PERIOD, CLEARANCE, STIFFNESS, DAMPING = 0.075, 2.9e-5, 1e8, 3000.0
WORDS = {
    "angle": ("rad", "link angle"),
    "angular_velocity": ("rad s-1", "link angular velocity"),
    "angular_acceleration": ("rad s-2", "link angular acceleration"),
    "journal_x": ("m", "journal centre, x from the bearing centre"),
    "journal_y": ("m", "journal centre, y from the bearing centre"),
    "eccentricity": ("m", "eccentricity"),
    "eccentricity_ratio": ("1", "eccentricity over clearance"),
    "penetration": ("m", "penetration depth"),
    "normal_velocity": ("m s-1", "normal velocity"),
    "tangential_velocity": ("m s-1", "tangential velocity"),
    "contact_angle": ("rad", "contact angle"),
    "normal_force": ("N", "normal contact force"),
    "tangential_force": ("N", "friction force"),
    "drive_torque": ("N m", "drive torque"),
    "time": ("s", "time"),
}
LINKS = ("crank", "coupler", "rocker")


@lru_cache
def motion(turns: int = 6, samples: int = 720) -> tuple[np.ndarray, ...]:
    """Positions and velocities of the journal centre in the bearing, along a curve that flies now and then.

    In closed form, and so on all processors alike, as a motion that is computed step by step would not be.
    """
    time = PERIOD * np.arange(turns * samples + 1) / samples
    phase = 2 * np.pi * time / PERIOD
    slow = np.sin(0.618 * phase)
    direction = 0.4 + 1.9 * np.sin(phase) + 0.6 * slow
    ratio = 1.0005 - 0.0012 * np.cos(3 * phase + slow) - 6 * np.maximum(np.cos(phase - 0.4 * slow) - 0.9, 0)
    x, y = CLEARANCE * ratio * np.cos(direction), CLEARANCE * ratio * np.sin(direction)
    return time, x, y, np.gradient(x, time), np.gradient(y, time)


def over_joint(time, x, y, vx, vy) -> dict[str, np.ndarray]:
    """What is recorded of a clearance joint."""
    distance = np.hypot(x, y)
    along = np.where(distance > 0, distance, 1.0)
    depth = distance - CLEARANCE
    speed = (x * vx + y * vy) / along
    touching = depth >= 0
    force = np.where(touching, STIFFNESS * depth + DAMPING * speed, 0.0)
    return {
        "journal_x": x,
        "journal_y": y,
        "eccentricity": distance,
        "eccentricity_ratio": distance / CLEARANCE,
        "penetration": depth,
        "normal_velocity": speed,
        "tangential_velocity": (x * vy - y * vx) / along,
        "contact_angle": np.arctan2(y, x),
        "normal_force": force,
        "tangential_force": 0.01 * force,
        "mode": np.where(touching, Mode.CONTACT, Mode.FREE).astype(np.int8),
    }


def over_link(time) -> dict[str, np.ndarray]:
    """What is recorded of the links: a crank that nearly runs evenly, and two others."""
    omega = 2 * np.pi / PERIOD
    swing = 0.02 * np.sin(omega * time)
    angle = np.stack(
        [omega * time + swing, 0.5 + 0.2 * np.cos(omega * time), 1.3 + 0.4 * np.sin(omega * time)], 1
    )
    speed = np.gradient(angle, time, axis=0) if time.size > 2 else np.zeros_like(angle)
    acceleration = np.gradient(speed, time, axis=0) if time.size > 2 else np.zeros_like(angle)
    return {"angle": angle, "angular_velocity": speed, "angular_acceleration": acceleration}


def worded(name: str, dims: tuple[str, ...], values) -> tuple:
    """A variable with its units and long name; a mode with its flags."""
    if name == "mode":
        return dims, values, flag_words(MODES, "contact mode")
    units, words = WORDS[name]
    return dims, values, {"units": units, "long_name": words}


def flag_words(meanings: tuple[str, ...], words: str) -> dict:
    values = np.arange(len(meanings), dtype=np.int8)
    return {"units": "1", "long_name": words, "flag_values": values, "flag_meanings": " ".join(meanings)}


def events(time, mode) -> dict[str, tuple]:
    """Contacts and separations, where the mode changes."""
    changes = np.flatnonzero(np.diff((mode > 0).astype(int)))
    zero = np.zeros(changes.size)
    speeds = {"units": "m s-1", "long_name": "speed at the event"}
    return {
        "event_time": ("event", time[changes + 1], {"units": "s", "long_name": "time of the event"}),
        "event_joint": ("event", zero.astype(int), {"units": "1", "long_name": "joint index"}),
        "event_kind": (
            "event",
            np.where(mode[changes + 1] > 0, 0, 1).astype(np.int8),
            flag_words(EVENTS, "kind"),
        ),
        "event_normal_velocity": ("event", zero, speeds),
        "event_tangential_velocity": ("event", zero, speeds),
    }


def common(status: str, joints: tuple[str, ...]) -> dict[str, tuple]:
    return {
        "status": ((), np.int8(STATUS.index(status)), flag_words(STATUS, "outcome")),
        "turn_period_nominal": ((), PERIOD, {"units": "s", "long_name": "nominal period of a turn"}),
        "clearance": ("joint", np.full(len(joints), CLEARANCE), {"units": "m", "long_name": "clearance"}),
    }


def response(status="ok", joints=("B",), turns=6, section=True) -> xr.Dataset:
    """A response: joints after the first are smaller copies of it."""
    time, x, y, vx, vy = (part[: turns * 720 + 1] for part in motion())
    shrink = 0.97 ** np.arange(len(joints))
    one = over_joint(time, x, y, vx, vy)
    data = {
        name: worded(
            name,
            ("time", "joint"),
            values[:, None] * (shrink if name != "mode" else np.int8(1) * np.ones(len(joints), np.int8)),
        )
        for name, values in one.items()
    }
    data |= {name: worded(name, ("time", "link"), values) for name, values in over_link(time).items()}
    data["drive_torque"] = worded("drive_torque", ("time",), 20 + np.sin(2 * np.pi * time / PERIOD))
    data |= events(time, one["mode"]) | common(status, joints)
    if section:
        points = {name: array for name, array in data.items() if array[0] == ("time", "joint")}
        data |= {f"section_{name}": (("turn", "joint"), a[1][720::720], a[2]) for name, a in points.items()}
        data["section_time"] = ("turn", time[720::720], {"units": "s", "long_name": "time"})
    coords = {"time": worded("time", ("time",), time), "link": list(LINKS), "joint": list(joints)}
    return xr.Dataset(data, coords, {"kind": "response", "title": "synthetic"})


def section(count=2000, status="ok", joints=("B",), spread=1.0) -> xr.Dataset:
    """A Poincaré section: points on a bent band near the clearance circle."""
    rng = np.random.default_rng(1)
    angle = 0.4 + spread * 0.9 * np.sin(2.7 * np.arange(count)) + spread * 0.05 * rng.standard_normal(count)
    ratio = 1.02 - spread * 0.35 * np.cos(2 * angle) ** 2 * rng.uniform(0.9, 1.0, count)
    x, y = CLEARANCE * ratio * np.cos(angle), CLEARANCE * ratio * np.sin(angle)
    vx, vy = 0.02 * np.sin(3 * angle), 0.03 * np.cos(2 * angle)
    time = PERIOD * np.arange(count)
    data = {
        name: worded(name, ("turn", "joint"), np.repeat(values[:, None], len(joints), 1))
        for name, values in over_joint(time, x, y, vx, vy).items()
    }
    data |= {name: worded(name, ("turn", "link"), values) for name, values in over_link(time).items()}
    data["time"] = worded("time", ("turn",), time)
    data |= common(status, joints)
    coords = {"turn": np.arange(count), "link": list(LINKS), "joint": list(joints)}
    return xr.Dataset(data, coords, {"kind": "section"})


def oscillator(period=2 * np.pi, count=4001) -> xr.Dataset:
    """A response of a test system with the states x and v."""
    time = np.linspace(0, 8 * 2 * np.pi, count)
    state = np.stack([np.sin(time) + 0.3 * np.sin(2.1 * time), np.cos(time) + 0.63 * np.cos(2.1 * time)], 1)
    data = {
        "state_value": (("time", "state"), state, {"units": "1", "long_name": "state"}),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
        "turn_period_nominal": ((), period, {"units": "s", "long_name": "forcing period"}),
    }
    coords = {"time": ("time", time, {"units": "1", "long_name": "time"}), "state": ["x", "v"]}
    return xr.Dataset(data, coords, {"kind": "response"})
