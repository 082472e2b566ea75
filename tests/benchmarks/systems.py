"""The four-bar with play at B, as fast as peers can be given it: numba functions of three angles.

State: angles of crank, coupler, rocker, then their speeds. Modes: 0 free, 1 and -1 slip, 2 stick.
``par`` holds (a, b, e, f) of a case; everything else is Table 1.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit

from tests.reference.bodies import Bodies, Parameters

P = Parameters()
FREE, SLIP_UP, SLIP_DOWN, STICK = 0, 1, -1, 2
H33, H13, H11, J2 = P.J_O + P.m1 * P.l3**2, P.m1 * P.l1 / 2 * P.l3, P.J_A, P.J_C
G3, G1, G2 = (P.gravity * k for k in (P.m1 * P.l3 + P.m3 * P.l3 / 2, P.m1 * P.l1 / 2, P.m2 * P.l2 / 2))
L1, L2, L3, L4, R, K, C_N = P.l1, P.l2, P.l3, P.l4, P.R, P.K, P.C_n


@njit(error_model="numpy")
def geometry(y):
    """Directions, |r|, r/|r|, normal and slip speed; no use where the journal is centred."""
    c3, s3, c1, s1, c2, s2 = (
        np.cos(y[0]),
        np.sin(y[0]),
        np.cos(y[1]),
        np.sin(y[1]),
        np.cos(y[2]),
        np.sin(y[2]),
    )
    rx, ry = L3 * c3 + L1 * c1 - L2 * c2 - L4, L3 * s3 + L1 * s1 - L2 * s2
    vx = -L3 * s3 * y[3] - L1 * s1 * y[4] + L2 * s2 * y[5]
    vy = L3 * c3 * y[3] + L1 * c1 * y[4] - L2 * c2 * y[5]
    rho = np.sqrt(rx * rx + ry * ry + 1e-200)  # complex division by 0 raises even where nothing uses it
    nx, ny = rx / rho, ry / rho
    return (
        c3,
        s3,
        c1,
        s1,
        c2,
        s2,
        rho,
        nx,
        ny,
        vx * nx + vy * ny,
        vy * nx - vx * ny + R * y[4] - (R + rho) * y[5],
    )


@njit(error_model="numpy")
def solve(c, q3, q1, q2):
    """Accelerations under generalised forces; c = cos(crank - coupler)."""
    m = H13 * c
    det = H33 * H11 - m * m
    return (H11 * q3 - m * q1) / det, (H33 * q1 - m * q3) / det, q2 / J2


@njit(error_model="numpy")
def accelerations(y, mode, par):
    """Accelerations, friction force on the bearing (found where sticking) and normal force."""
    c3, s3, c1, s1, c2, s2, rho, nx, ny, v_n, v_t = geometry(y)
    c, s = c3 * c1 + s3 * s1, s3 * c1 - c3 * s1
    q3 = par[0] - par[1] * y[3] - H13 * s * y[4] ** 2 - G3 * c3
    q1 = H13 * s * y[3] ** 2 - G1 * c1
    q2 = -G2 * c2
    if mode == FREE:
        a3, a1, a2 = solve(c, q3, q1, q2)
        return a3, a1, a2, 0.0 * q3, 0.0 * q3
    # unit directions of F_n and F_t in the generalised forces
    n3, n1, n2 = -L3 * (ny * c3 - nx * s3), -L1 * (ny * c1 - nx * s1), L2 * (ny * c2 - nx * s2)
    t3, t1, t2 = -L3 * (nx * c3 + ny * s3), -L1 * (nx * c1 + ny * s1) - R, L2 * (nx * c2 + ny * s2) + R + rho
    normal = K * (rho - par[2]) + C_N * v_n
    q3, q1, q2 = q3 + normal * n3, q1 + normal * n1, q2 + normal * n2
    if mode == STICK:
        turn = (v_t - R * y[4] + (R + rho) * y[5]) / rho
        bias = -turn * v_n - y[5] * v_n
        bias += L3 * y[3] ** 2 * (ny * c3 - nx * s3) + L1 * y[4] ** 2 * (ny * c1 - nx * s1)
        bias -= L2 * y[5] ** 2 * (ny * c2 - nx * s2)
        a3, a1, a2 = solve(c, q3, q1, q2)
        b3, b1, b2 = solve(c, t3, t1, t2)
        # v_t' = bias - (t . acceleration): the rows of F_t are minus those of v_t
        friction = (bias - t3 * a3 - t1 * a1 - t2 * a2) / (t3 * b3 + t1 * b1 + t2 * b2)
    else:
        friction = mode * par[3] * normal
    a3, a1, a2 = solve(c, q3 + friction * t3, q1 + friction * t1, q2 + friction * t2)
    return a3, a1, a2, friction, normal


@njit(error_model="numpy")
def rate(y, mode, par, out):
    """Right-hand side, written into ``out`` (6,)."""
    a3, a1, a2, _, _ = accelerations(y, mode, par)
    out[0], out[1], out[2], out[3], out[4], out[5] = y[3], y[4], y[5], a3, a1, a2


@njit(error_model="numpy")
def jacobian(y, mode, par, out):
    """Exact Jacobian by complex steps, written into ``out`` (6, 6)."""
    z, f = y.astype(np.complex128), np.empty(6, np.complex128)
    for k in range(6):
        z[k] += 1e-100j
        rate(z, mode, par, f)
        for j in range(6):
            out[j, k] = f[j].imag * 1e100
        z[k] = y[k]


@njit(error_model="numpy")
def guards(y, mode, par, out):
    """Two guards, positive inside the mode: leaving or entering contact, and end of slip or stick."""
    c = geometry(y)
    out[0], out[1] = c[6] - par[2], 1.0
    if mode == FREE:
        out[0] = -out[0]
    elif mode == STICK:
        _, _, _, friction, normal = accelerations(y, mode, par)
        out[1] = par[3] * normal - abs(friction)
    else:
        out[1] = mode * c[10]


@njit(error_model="numpy")
def slip_rate(y, mode, par):
    """v_t' under friction of a mode, by an exact derivative along the motion."""
    z, f = y.astype(np.complex128), np.empty(6, np.complex128)
    rate(z, mode, par, f)
    return geometry(z + 1e-100j * f)[10].imag * 1e100


@njit(error_model="numpy")
def at_rest(y, par):
    """Mode at v_t = 0: stick where both one-sided v_t' push back, else the way both push."""
    up, down = slip_rate(y, SLIP_UP, par), slip_rate(y, SLIP_DOWN, par)
    if up < 0.0 < down:
        return STICK
    return SLIP_UP if up + down > 0.0 else SLIP_DOWN


@njit(error_model="numpy")
def switch(y, mode, guard, par):
    """Mode after guard 0 or 1 fired."""
    if guard == 0:
        if mode != FREE:
            return FREE
        return SLIP_UP if geometry(y)[10] > 0.0 else SLIP_DOWN
    if mode == STICK:
        return SLIP_UP if accelerations(y, mode, par)[3] > 0.0 else SLIP_DOWN
    return at_rest(y, par)


KINDS = {
    (FREE, 0): "contact",
    (SLIP_UP, 0): "separation",
    (SLIP_DOWN, 0): "separation",
    (STICK, 0): "separation",
}


def kind(mode, guard, new):
    """Name of an event as truth.json has it."""
    if guard == 0:
        return KINDS[mode, guard]
    if mode == STICK:
        return "slip_onset"
    return "stick_onset" if new == STICK else "slip_reversal"


@dataclass(frozen=True)
class Case:
    """One stored motion: parameters, start, end time, and the truth to compare with."""

    name: str
    i: float
    e: float
    par: np.ndarray
    start: np.ndarray
    t_end: float
    truth: np.ndarray
    scale: np.ndarray
    events: tuple


def load(name):
    """Case A, B or C, or one that sticks (B_sticking, C_sticking), from truth.json."""
    path = Path(__file__).parent.parent / "reference" / "truth.json"
    stored = json.loads(path.read_text())[name]
    p = Parameters(**stored["parameters"])
    truth = np.array([*stored["angles"].values(), *stored["speeds"].values()])
    events = tuple(event[2] for event in stored["events"])
    start, par = Bodies(p, {"B": p.e}).start(), np.array([p.a, p.b, p.e, p.f])
    scale = np.repeat([1.0, p.a / p.b], 3)
    return Case(name, p.i, p.e, par, start, 2 * math.pi / p.w0, truth, scale, events)
