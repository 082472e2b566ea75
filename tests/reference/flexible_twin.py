"""The slow twin of linkages that bend: integration of ``flexible.py``, with play or with ideal pins only.

With play the mode machine and the integrators of ``twin.py`` are used as they are. Without, the loop is
closed exactly in every evaluation, so nothing can drift: the crank angle and the nodal coordinates are
integrated, the other angles and speeds are those of the closed loop, and the accelerations come from the
free bodies and their reactions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from .bodies import LINKS, Parameters
from .flexible import Flexible
from .twin import advance, guards, march, tolerances

__all__ = ["Loop", "Motion", "Scene", "build", "follow", "sample"]


@dataclass(frozen=True)
class Scene:
    """One motion: parameters, clearance (joint -> e, m), beams (link -> Beam) and nominal turns to keep."""

    parameters: Parameters
    clearance: dict
    beams: dict = field(default_factory=dict)
    order: str = "consistent"
    turns: tuple = (1.0,)

    @property
    def times(self):
        """Times to keep, s."""
        return [turn * 2 * math.pi / self.parameters.w0 for turn in self.turns]


@dataclass
class Motion:
    """A followed scene: its system, states at its times, and events."""

    system: object
    states: list
    events: list


class Loop:
    """The closed loop of a `Flexible` system without play: state (crank angle, nodal; their rates)."""

    def __init__(self, flexible):
        self.inner, self.p, self.clearance = flexible, flexible.p, {}
        self.n = 1 + flexible.size - 9

    def motion(self, z):
        """None: no joint has play, so no guard asks for it."""

    def start(self):
        """Crank at 0 with the no-load speed, links straight and at rest in their frames."""
        z = np.zeros(2 * self.n)
        z[self.n] = self.p.w0
        return z

    def expand(self, z):
        """State of the free bodies."""
        n = self.n
        angles, speeds = loop(self.p, float(z[0]), float(z[n]))
        return np.concatenate([angles, z[1:n], speeds, z[n + 1 :]])

    def rate(self, z, modes):
        """Time derivative of the state (2 n,)."""
        full = self.inner.rate(self.expand(z), modes)
        half = self.inner.n
        return np.concatenate([full[:1], full[3:half], full[half : half + 1], full[half + 3 :]])

    def forces(self, z, modes):
        """As `Flexible.forces`."""
        return self.inner.forces(self.expand(z), modes)


def loop(p, angle, speed):
    """Angles and speeds (crank, coupler, rocker) of the closed loop, rocker above the line from A to C."""
    ax, ay = p.l3 * math.cos(angle), p.l3 * math.sin(angle)
    dx, dy = p.l4 - ax, -ay
    gap = math.hypot(dx, dy)
    foot = (gap**2 + p.l1**2 - p.l2**2) / (2 * gap)
    height = math.sqrt(p.l1**2 - foot**2)
    bx, by = (foot * dx - height * dy) / gap, (foot * dy + height * dx) / gap  # from A to B
    cx, cy = bx - dx, by - dy  # from C to B
    # velocity of B from both sides: (-speed ay, speed ax) + coupler (-by, bx) = rocker (-cy, cx)
    area = by * cx - bx * cy
    coupler = speed * (ax * cy - ay * cx) / area
    rocker = speed * (ax * by - ay * bx) / area
    return [angle, math.atan2(by, bx), math.atan2(cy, cx)], [speed, coupler, rocker]


def build(scene):
    """The scene's system."""
    system = Flexible(scene.parameters, scene.clearance, scene.beams, scene.order)
    return system if scene.clearance else Loop(system)


def bdf(system, modes, t, y, t_stop, rtol):
    """Advance function through CVODE, which refuses to look for no events."""
    from sksundae.cvode import CVODE

    from . import cvode

    if guards(system, modes):
        return cvode.advance(system, modes, t, y, t_stop, rtol)

    def rate(_, state, out):
        out[:] = system.rate(state, modes)

    found = CVODE(rate, rtol=rtol, atol=tolerances(system, rtol), max_num_steps=10**8).solve([t, t_stop], y)
    if not found.success:
        raise RuntimeError(f"CVODE at t = {found.t[-1]}: {found.message}")
    return t_stop, np.array(found.y[-1]), None, None


def follow(scene, method="DOP853", rtol=1e-13, start=None):
    """Motion of a scene, by an advance function or scipy method of ``twin.py``."""
    system = build(scene)
    step = method if callable(method) else partial(advance, method=method)
    y = system.start() if start is None else start
    states, events, _ = march(system, y, scene.times, rtol, step)
    return Motion(system, states, events)


def modes_at(system, events, time, y):
    """Modes at a kept state: the last event's, the sense of sliding from v_t."""
    last = {event.joint: event.kind for event in events if event.time < time}
    modes = {}
    for joint in system.clearance:
        kind = last.get(joint, "separation")
        sense = "slip-" if system.contact(joint, y).v_t < 0.0 else "slip+"
        modes[joint] = {"separation": "free", "release": "released", "stick_onset": "stick"}.get(kind, sense)
    return modes


def bearing_force(free, y, joint, mode, held):
    """(x, y) of the force on the bearing of a joint with play."""
    c = free.contact(joint, y)
    if mode in ("free", "released"):
        return [0.0, 0.0]
    friction = float(held[joint][0]) if mode == "stick" else free.friction(c, mode)
    (x, z), force = c.normal, c.force
    return [force * x - friction * z, force * z + friction * x]


def sample(motion, time, y):
    """What is compared at one time, as a dict of lists: links in the order crank, coupler, rocker."""
    system, play = motion.system, motion.system.clearance
    modes = modes_at(system, motion.events, time, y)
    a, held, _ = system.forces(y, modes)
    free, full = (system, y) if play else (system.inner, system.expand(y))
    forces = {joint: bearing_force(free, full, joint, mode, held) for joint, mode in modes.items()}
    return {
        "angle": full[:3].tolist(),
        "angular_velocity": full[free.n : free.n + 3].tolist(),
        "angular_acceleration": a[2:9:3].tolist(),
        "deflection": [free.deflections(full).get(name, 0.0) for name in LINKS],
        "journal": {joint: list(free.contact(joint, full).r) for joint in play},
        "reaction": {joint: held[joint].tolist() for joint in free.ideal} | forces,
        "energy": free.energy(full),
    }
