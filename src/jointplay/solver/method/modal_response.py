"""Mode superposition: the response of damped oscillators to loads that are linear between grid points.

eta'' + 2 xi omega eta' + omega^2 eta = f(t), solved exactly from one grid point to the next (Nigam and
Jennings, Bull. Seism. Soc. Am. 59 (1969) 909-922), so that no omega h is too large. With tau = omega h, x
from 0 to 1 over a step, and the answers to a unit speed, h g(x), and to loads of 1 and rising from 0 to 1,
h^2 P and h^2 Q,

    g(x) = exp(-xi tau x) sin(tau_d x)/tau_d,  tau_d = tau sqrt(1 - xi^2),
    P = int_0^1 g(x) dx,  Q = int_0^1 g(x) (1 - x) dx,

    eta_1    = A eta_0           + g(1) h eta'_0               + h^2 (P f_0    + Q (f_1 - f_0))
    h eta'_1 = -tau^2 g(1) eta_0 + (A - 2 xi tau g(1)) h eta'_0 + h^2 (g(1) f_0 + P (f_1 - f_0)),
    A = exp(-xi tau) (cos tau_d + xi tau sin(tau_d)/tau_d).

Damping ratios from 0 to 1.
"""

import numpy as np

from .interface import Array, inner, void

_SHORT = 2.0  # tau below which P and Q are integrated: their closed forms cancel there
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_PLACES = 0.5 * (1.0 + _NODES)


def recurrence(omega: np.ndarray, damping_ratio: np.ndarray | float, h: float) -> np.ndarray:
    """Coefficients that take modes over a step.

    Parameters
    ----------
    omega : ndarray, shape (modes,)
        Natural frequencies, rad/s; greater than 0.
    damping_ratio : ndarray or float
        Of every mode, 0 to 1.
    h : float
        Step, s.

    Returns
    -------
    ndarray, shape (modes, 2, 4)
        Rows eta_1 and eta'_1; columns eta_0, eta'_0, f_0, f_1 - f_0.
    """
    omega = np.asarray(omega, dtype=float)
    xi, tau = np.broadcast_to(np.asarray(damping_ratio, dtype=float), omega.shape), omega * h
    turn = tau * np.sqrt(1.0 - xi**2)
    g, A = _answer(xi, tau, turn, 1.0), np.exp(-xi * tau) * np.cos(turn)
    A = A + xi * tau * g
    P, Q = _loaded(xi, tau, turn, A, g)
    eta = [A, h * g, h**2 * P, h**2 * Q]
    rate = [-(tau**2) * g / h, A - 2.0 * xi * tau * g, h * g, h * P]
    return np.stack([np.stack(eta, -1), np.stack(rate, -1)], 1)


def _answer(xi, tau, turn, x):
    """The answer g(x) to a unit speed."""
    return np.exp(-xi * tau * x) * x * np.sinc(turn * x / np.pi)


def _loaded(xi, tau, turn, A, g):
    """P and Q: in closed form, by Gauss's rule where tau is small."""
    P = (1.0 - A) / tau**2
    Q = (1.0 - g) / tau**2 - 2.0 * xi * P / tau
    g = _answer(*(each[:, None] for each in (xi, tau, turn)), _PLACES)
    short = tau < _SHORT
    return (
        np.where(short, g @ (0.5 * _WEIGHTS), P),
        np.where(short, (g * (1.0 - _PLACES)) @ (0.5 * _WEIGHTS), Q),
    )


@inner
def respond(step, load, eta, rate):
    """Fill modal coordinates and their rates, shape (grid points, modes), from the first row on."""
    for i in range(1, len(load)):
        for k in range(len(step)):
            c, a, b = step[k], load[i - 1, k], load[i, k] - load[i - 1, k]
            x, v = eta[i - 1, k], rate[i - 1, k]
            eta[i, k] = c[0, 0] * x + c[0, 1] * v + c[0, 2] * a + c[0, 3] * b
            rate[i, k] = c[1, 0] * x + c[1, 1] * v + c[1, 2] * a + c[1, 3] * b


def accelerations(omega, damping_ratio, load, eta, rate) -> np.ndarray:
    """eta'' = f - 2 xi omega eta' - omega^2 eta of every grid point and mode."""
    return load - 2.0 * damping_ratio * omega * rate - omega**2 * eta


UNIT = {"respond": void(Array(axes=3), Array(axes=2), Array(axes=2), Array(axes=2))}
