"""A body dropped on a contact, nothing else acting on it: followed to where the gap opens again."""

import numpy as np
from scipy.integrate import solve_ivp

from tests.support.belt import NUMPY

MASS = 0.3  # kg
JOINT = {"e": 4e-3, "R": 1e-2}  # m, of laws that depend on them


def drop(law, numbers, v_0, tension=True):
    """Follow a body that meets the contact with v_0: depth, time, restitution, force and energies on the way.

    Without `tension`, to where the force ends.
    """
    coefficients = arguments(law, numbers)
    remembered = [v_0] if law.floor else []

    def pull(y):
        return law.force(NUMPY, y[0], y[1], *coefficients, *remembered)[0]

    def opens(t, y):
        return y[0] if tension or t == 0 else pull(y)

    def rests(t, y):
        return y[1]

    opens.terminal, opens.direction = True, -1
    rests.direction = -1
    longest = 100 * _time(law, coefficients, v_0)
    found = solve_ivp(
        lambda t, y: [y[1], -pull(y) / MASS],
        [0, longest],
        [0.0, v_0],
        method="DOP853",
        events=[opens, rests],
        rtol=3e-14,
        atol=1e-18,
    )
    assert found.status == 1, found.message
    (end,), ((_, v),) = found.t_events[0], found.y_events[0]
    depth, force = found.y_events[1][0][0], np.array([pull(y) for y in found.y.T])
    return {
        "depth": depth,
        "time": end,
        "restitution": -v / v_0,
        "u": found.y[0],
        "v": found.y[1],
        "F": force,
    }


def arguments(law, numbers):
    """What a law takes, of its numbers and the joint's."""
    return (*law.coefficients(*numbers), *(JOINT[letter] for letter in law.joint))


def _time(law, coefficients, v_0):
    """Time scale: that in which the spring at the depth of an undamped impact stops the body."""
    depth, energy = 1e-12, MASS * v_0**2 / 2
    while law.force(NUMPY, depth, 0.0, *coefficients, *([v_0] if law.floor else []))[1] < energy:
        depth *= 1.1
    return depth / v_0
