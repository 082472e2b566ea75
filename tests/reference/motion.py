"""Motions of the stored scenes, by scipy's solvers or others, and what is compared of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from tests.support.multibody import Now
from tests.support.multibody_run import State, followed

from .four_bar import ANGLES, LINKS, FourBar

FIRST = 1e-7  # s
BENDING = 3e-6, 3e-4  # of mode coordinates and rates: as much as a radian and a/b, a hundred times rounding


def tolerances(system: FourBar, rtol: float, free: bool = False) -> np.ndarray:
    """Absolute tolerances of all coordinates, or of the free ones: rtol/100, speeds in units of a/b."""
    rigid, n = (system.rigid, system.half) if free else (9, system.n)
    units = [np.r_[np.ones(rigid), np.full(n - rigid, unit)] for unit in BENDING]
    return rtol / 100 * np.r_[units[0], units[1] * system.p.w0]


@dataclass
class Motion:
    """A followed scene: states at its times, and events as (time, joint, kind, v_n, v_t)."""

    system: FourBar
    states: list[State]
    events: list[tuple[float, str, str, float, float]]

    @property
    def kinds(self) -> list[list[str]]:
        """Joint and kind of every event."""
        return [[joint, kind] for _, joint, kind, _, _ in self.events]

    @property
    def end(self) -> np.ndarray:
        """The last state, of the free coordinates."""
        return self.system.reduced(self.states[-1].y)

    def samples(self) -> list[dict]:
        """What is compared at each time."""
        return [sample(self.system, state) for state in self.states]


def follow(scene, method=DOP853, rtol: float = 1e-13, start: np.ndarray | None = None) -> Motion:
    """Follow a scene from the ideal mechanism at crank angle 0, or a start of the free coordinates."""
    system = scene.system
    # the motor rests at no load: a first step chosen from the rate alone would be far too long
    options = {"atol": tolerances(system, rtol), "first_step": FIRST} if isinstance(method, type) else {}
    y = system.full(system.start() if start is None else start)
    states, events = followed(system, y, scene.times, rtol, method, **options)
    rows = []
    for event in events:
        name, touch = system.touches(Now(system, event.time, event.y))[event.touch]
        rows.append((float(event.time), name, event.kind, touch.v_n, touch.v_t))
    return Motion(system, states, rows)


def sample(system: FourBar, state: State) -> dict:
    """What is compared at one time, as lists: links in the order crank, coupler, rocker."""
    solved = system.solve(state.t, state.y, state.modes)
    bent, held = system.deflections(state.y), solved.reactions
    touches = {name: (touch, F_n, F_t) for name, touch, F_n, F_t in solved.touches}
    forces = {name: list(held[name][:2]) for name in "OABC" if name in held}
    forces |= {name: list(F_n * x.normal + F_t * x.tangent) for name, (x, F_n, F_t) in touches.items()}
    return {
        "angle": solved.now.q[ANGLES].tolist(),
        "angular_velocity": solved.now.v[ANGLES].tolist(),
        "angular_acceleration": solved.acceleration[ANGLES].tolist(),
        "deflection": [bent.get(name, 0.0) for name in LINKS],
        "journal": {k: list((x.u + x.play.clearance) * x.normal) for k, (x, _, _) in touches.items()},
        "reaction": forces,
        "energy": system.energy(state.t, state.y, state.modes),
    }
