"""The elastic slider-crank of the IVP test set at t = 0.1 s, and its published state.

Source: Test set for IVP solvers, problem `crank` (B. Simeon, 1998), linear stiffness, no damping. Its rod is
that of `catalog.ivp_crank` but for two things, which are kept here to reach its digits: the axial mass matrix
is printed without the factor 1/15 of ∫ψ_a ψ_b dx, and π is 3.1415927. Its start is printed to nine digits,
which leave the joint at the slider open by 1.2e-8 m/s; an index-2 solver closes it in its first step as a
blow there would, v − M⁻¹Gᵀ(G M⁻¹Gᵀ)⁻¹ G v, and so does `_struck`. It also leaves x_3 too long by 2.03e-10 m,
which an index-2 solver never takes back: the difference in x_3 is that. Its multipliers are the force on the
slider, along y and against x, and the drive's torque, its sign turned.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.keywords import Progress
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_lab.benchmarks.answer import Answer

END, PI = 0.1, 3.1415927
CRANK, ROD, INERTIA, E, SIDE, DENSITY, SPEED = 0.15, 0.3, 0.0045339259, 2e11, 0.008, 7870.0, 150.0
SLIDER = 0.075552
MASS, BAR = DENSITY * SIDE**2 * ROD, E * SIDE**2 / ROD
START = np.array([0.0, 0.0, 1.03339863e-5, 1.69327969e-5])  # q, m
RATES = np.array([-74.9957670, -2.68938672e-6, 0.444896105, 4.63434311e-3, -1.78591076e-6, -2.68938672e-6])
PUBLISHED = {
    "rod angle": ("rad", -0.3311734988256260),
    "slider position": ("m", 0.1697373328427860),
    "q1": ("m", 0.1893192899613509e-3),
    "q2": ("m", 0.2375751249879174e-4),
    "q3": ("m", -0.5323896770569702e-5),
    "q4": ("m", -0.8363313279112129e-5),
    "rod speed": ("rad s-1", 60.25346755138369),
    "slider speed": ("m s-1", -8.753116326670527),
    "q1 rate": ("m s-1", -0.3005541400289738e-1),
    "q2 rate": ("m s-1", -0.5500431812571696e-2),
    "q3 rate": ("m s-1", 0.4974111734266989e-3),
    "q4 rate": ("m s-1", 0.1105560003626645e-2),
    "rod acceleration": ("rad s-2", 6488.737541276957),
    "multiplier 1": ("N", -62.32935833287916),
    "multiplier 2": ("N", -163.7920993367306),
    "multiplier 3": ("N m", 25.29857947066878),
}


@cache
def _matrices() -> dict[str, np.ndarray]:
    """Matrices and vectors of the rod's four coordinates, as printed."""
    M, K, B = np.diag([0.5, 0.5, 8.0, 2.0]), np.zeros((4, 4)), np.zeros((4, 4))
    M[2, 3] = M[3, 2] = 1.0
    K[2:, 2:] = np.array([[16.0, -8.0], [-8.0, 7.0]]) / 3
    K[0, 0], K[1, 1] = PI**4 / 24 * (SIDE / ROD) ** 2, PI**4 * 2 / 3 * (SIDE / ROD) ** 2
    B[0, 2:], B[1, 3] = (-16 / PI**3, 8 / PI**3 - 1 / PI), 0.5 / PI
    vectors = {
        "along": [0.0, 0.0, 2 / 3, 1 / 6],
        "S": [2 / PI, 0.0, 0.0, 0.0],
        "lever": [0.0, 0.0, ROD / 3, ROD / 6],
        "I": [ROD / PI, -ROD / (2 * PI), 0.0, 0.0],
    }
    found = {word: MASS * np.array(v) for word, v in vectors.items()}
    return found | {"M": MASS * M, "K": BAR * K, "B": MASS * (B - B.T)}


def _modes() -> tuple[np.ndarray, np.ndarray]:
    """Squares of the frequencies, two across and two along, and the modes in the four coordinates."""
    from scipy.linalg import eigh

    return eigh(_matrices()["K"], _matrices()["M"])


def _numbers(model: Model) -> np.ndarray:
    """Numbers of the mechanism's equations with the printed matrices."""
    printed, (squares, T) = _matrices(), _modes()
    values = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
    rows = {word: printed[word] @ T for word in ("along", "S", "lever", "I")}
    rows |= {"k": squares, "axial": squares, "stretch": T[3] / ROD}
    crossed = -(T.T @ printed["B"] @ T)
    for i in (0, 1):
        values |= {f"{word}_rod_{i}": rows[word][i] for word in ("S", "I", "k")}
        values |= {f"{word}_rod_{i}": rows[word][2 + i] for word in ("along", "lever", "axial", "stretch")}
        values |= {f"G_rod_{i}_{a}": crossed[i, 2 + a] for a in (0, 1)}
    return np.array(list(values.values()))


def _struck() -> np.ndarray:
    """Rates of the four coordinates after the blow that closes the joint at the slider."""
    printed, q = _matrices(), START
    M = np.zeros((6, 6))  # rod's angle, slider, q
    M[0, 0], M[1, 1] = INERTIA + q @ printed["M"] @ q + 2 * printed["lever"] @ q, SLIDER
    M[0, 2:] = M[2:, 0] = printed["I"] + q @ printed["B"]
    M[2:, 2:] = printed["M"]
    G = np.array([[ROD + q[3], 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, -1]])
    open_by = G @ RATES + np.array([CRANK * SPEED, 0.0])
    pushed = np.linalg.solve(M, G.T)
    return (RATES - pushed @ np.linalg.solve(G @ pushed, open_by))[2:]


def answer(mechanism: Mechanism, rtol: float, max_steps: int, progress: Progress = None) -> Answer:
    """Follow the published motion and give it with the published state."""
    model, (_, T) = assemble(mechanism), _modes()
    back = np.linalg.inv(T)
    state, half = model.state.copy(), len(model.state) // 2
    state[:4], state[half : half + 4] = back @ START, back @ _struck()
    model = dataclasses.replace(model, numbers=_numbers(model), state=state)
    records = follow(model, Request(END, rtol, at=np.array([END]), max_steps=max_steps), progress)
    if not len(records.samples):  # it stopped before
        return Answer(PUBLISHED, [math.nan] * len(PUBLISHED), records)
    words = ("angle", "angular_velocity", "angular_acceleration", "slide_position", "slide_velocity")
    names = (*words, "reaction_x", "reaction_y", "drive_torque")
    found = Quantities(model, records.samples, records.start).variables(names, "time")
    end = {name: np.atleast_1d(values[-1]) for name, (_, values, _) in found.items()}
    rod, B = model.links.index("rod"), model.pins.index("B")
    q, rates = (T @ records.samples[-1, 1 + at : 5 + at] for at in (0, half))
    forces = (end["reaction_y"][B], -end["reaction_x"][B], -end["drive_torque"][0])
    computed = [end["angle"][rod], end["slide_position"][0], *q]
    computed += [end["angular_velocity"][rod], end["slide_velocity"][0], *rates]
    computed += [end["angular_acceleration"][rod], *forces]
    return Answer(PUBLISHED, computed, records)
