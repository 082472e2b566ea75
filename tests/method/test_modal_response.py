"""Mode superposition against closed forms, at any step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from jointplay.solver.method.modal_response import accelerations, recurrence, respond

OMEGA = np.array([30.0, 4.9e3, 1e5])


def response(omega, xi, h, load, eta=0.0, rate=0.0):
    """Coordinates and rates of one mode at every grid point."""
    load = np.ascontiguousarray(load, dtype=float)[:, None]
    x, v = np.zeros_like(load), np.zeros_like(load)
    x[0], v[0] = eta, rate
    respond(recurrence(np.array([omega]), xi, h), load, x, v)
    return x[:, 0], v[:, 0]


def by_exponential(omega, xi, h):
    """The coefficients by the exponential of the system with its load, in units that balance it."""
    tau = omega * h
    unit = max(1.0, tau)
    Z = np.zeros((4, 4))
    Z[0, 1], Z[1, 0], Z[1, 1], Z[1, 2], Z[2, 3] = unit, -(tau**2) / unit, -2 * xi * tau, 1 / unit, 1
    E, scale = expm(Z)[:2], h / unit
    return np.array(
        [
            [E[0, 0], E[0, 1] * scale, E[0, 2] * h * h, E[0, 3] * h * h],
            [E[1, 0] / scale, E[1, 1], E[1, 2] * h * unit, E[1, 3] * h * unit],
        ]
    )


@pytest.mark.parametrize("xi", [0.0, 0.01, 0.7, 1 - 1e-9, 1.0])
@pytest.mark.parametrize("tau", [1e-6, 1e-3, 0.5, 1.999, 2.001, 30.0, 500.0])
def test_coefficients_at_any_step(xi, tau):
    h = 1e-4
    found = recurrence(np.array([tau / h]), xi, h)[0]
    unit = max(1.0, tau)
    size = np.array([[1, h / unit, (h / unit) ** 2, (h / unit) ** 2], [tau**2 / h, 1, h / unit, h / unit]])
    assert np.abs(found - by_exponential(tau / h, xi, h)) / size == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("h", [1e-6, 1e-3, 0.3])
def test_a_constant_load_without_damping(h):
    omega, t = 30.0, h * np.arange(400)
    x, v = response(omega, 0.0, h, np.full(400, 5.0))
    assert x == pytest.approx(5.0 / omega**2 * (1 - np.cos(omega * t)), abs=1e-13)
    assert v == pytest.approx(5.0 / omega * np.sin(omega * t), abs=1e-11)


@pytest.mark.parametrize("h", [1e-5, 1e-2, 2.0])
def test_a_rising_load_with_critical_damping(h):
    omega, t = 40.0, h * np.arange(300)
    x, v = response(omega, 1.0, h, 7.0 * t)
    decay = np.exp(-omega * t)
    assert x == pytest.approx(
        7.0 * (t - 2 / omega + decay * (t + 2 / omega)) / omega**2, rel=1e-11, abs=1e-15
    )
    assert v == pytest.approx(7.0 * (1 - decay * (1 + omega * t)) / omega**2, rel=1e-11, abs=1e-15)


def test_free_decay_by_damping_ratio():
    omega, xi, t = 4.9e3, 0.01, 1e-4 * np.arange(500)
    x, _ = response(omega, xi, 1e-4, np.zeros(500), eta=1.0)
    turn = omega * np.sqrt(1 - xi**2)
    exact = np.exp(-xi * omega * t) * (np.cos(turn * t) + xi * omega / turn * np.sin(turn * t))
    assert x == pytest.approx(exact, abs=1e-12)


@pytest.mark.nightly
@pytest.mark.parametrize("tau", [0.1, 3.0, 77.0, 1e4])
def test_an_undamped_mode_neither_grows_nor_decays(tau):
    omega, h = tau / 1e-3, 1e-3
    x, v = response(omega, 0.0, h, np.zeros(200_001), eta=1.0)
    energy = x**2 + (v / omega) ** 2
    assert np.abs(energy - 1.0).max() < 1e-9


@pytest.mark.parametrize("xi", [0.0, 0.01, 1.0])
def test_a_sine_load_is_met_to_second_order(xi):
    omega, drive, duration = 50.0, 9.0, 2.0
    gain = omega**2 - drive**2 + 2j * xi * omega * drive

    def steady(t):
        return (np.exp(1j * drive * t) / gain).imag, (1j * drive * np.exp(1j * drive * t) / gain).imag

    errors = []
    for count in (100, 200, 400):
        t = np.linspace(0.0, duration, count + 1)
        x, _ = response(omega, xi, duration / count, np.sin(drive * t), *steady(0.0))
        errors.append(np.abs(x - steady(t)[0]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.15)


def test_modes_are_apart_and_obey_their_equation():
    h, xi = 1e-6, np.array([0.0, 0.01, 0.3])
    load = np.random.default_rng(1).standard_normal((2000, 3)).cumsum(axis=0)
    x, v = np.zeros_like(load), np.zeros_like(load)
    respond(recurrence(OMEGA, xi, h), load, x, v)
    for k in range(3):
        alone, _ = response(OMEGA[k], xi[k], h, load[:, k])
        assert np.abs(x[:, k] - alone).max() < 1e-11 * np.abs(alone).max()
    a = accelerations(OMEGA, xi, load, x, v)
    # the trapezium rule on both sides of a step: v_1 - v_0 is the integral of a to (omega h)^2
    assert np.diff(v, axis=0) == pytest.approx(h * (a[1:] + a[:-1]) / 2, abs=2e-3 * h * np.abs(a).max())
