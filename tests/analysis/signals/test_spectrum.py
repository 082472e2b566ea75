"""Power spectra: a sine and noise of known size, what noise scatters by, lines of periodic motions."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.signals.spectrum import density

RATE = 50.0


def noise(count, size=1.0, seed=0):
    return size * np.random.default_rng(seed).standard_normal(count)


@pytest.mark.parametrize("window", ["hann", "boxcar", "flattop", "blackmanharris"])
def test_a_sine_and_white_noise(window):
    """The line holds half the amplitude squared; the floor is twice the variance over the sampling rate."""
    amplitude, frequency, size = 2.0, 5.0, 0.1
    time = np.arange(2**15) / RATE
    found = density(amplitude * np.sin(2 * math.pi * frequency * time) + noise(2**15, size), RATE, 31, window)
    f, values = found["frequency"], found["power_spectral_density"]
    near = np.abs(f - frequency) < 0.5
    width = f[1] - f[0]
    floor = 2 * size**2 / RATE
    assert values[near].sum() * width - floor * near.sum() * width == pytest.approx(
        amplitude**2 / 2, rel=5e-3
    )
    if window != "boxcar":  # whose line leaks everywhere
        assert values[f > 7][:-1].mean() == pytest.approx(floor, rel=0.05)


@pytest.mark.parametrize("count", [4096, 4097])
def test_parseval(count):
    """Without a window, the periodogram of the whole record holds its variance to the last digits."""
    found = density(noise(count), RATE, 1, "boxcar")
    assert found["parseval_residual"] < 1e-12
    assert len(found["frequency"]) == count // 2 + 1


@pytest.mark.parametrize(("segments", "window"), [(1, "boxcar"), (8, "hann"), (15, "boxcar"), (3, "hann")])
def test_interval_of_noise(segments, window):
    """Estimates of noise scatter as their degrees of freedom say, and 95 of 100 intervals hold the truth."""
    found = density(noise(2**16), RATE, segments, window)
    values, degrees, truth = found["power_spectral_density"][2:-2], found["degrees_of_freedom"], 2 / RATE
    assert values.mean() == pytest.approx(truth, rel=0.02)
    assert 2 * values.mean() ** 2 / values.var() == pytest.approx(degrees, rel=0.1)
    low, high = found["confidence_factor"]
    held = np.mean((values * low < truth) & (truth < values * high))
    assert held == pytest.approx(0.95, abs=0.01)


@pytest.mark.parametrize("segments", [1, 2, 8, 9])
@pytest.mark.parametrize("count", [1000, 1003, 1004, 1007])
def test_as_many_segments_as_asked_for(count, segments):
    """Degrees of freedom count them: one more or less would show in the length of the record used."""
    half = count // (segments + 1)
    values = noise(count)
    used = values[: (segments + 1) * half]
    parts = [used[i * half : (i + 2) * half] for i in range(segments)]
    powers = [np.abs(np.fft.rfft(part - part.mean())) ** 2 for part in parts]
    expected = 2 * np.mean(powers, axis=0) / (RATE * 2 * half)
    found = density(values, RATE, segments, "boxcar")
    assert found["power_spectral_density"][1:-1] == pytest.approx(expected[1:-1], rel=1e-10)


def test_a_linear_motion():
    """Within its backlash the gear pair has no stiffness: v'' = -2 zeta v + F W^2 cos W t, one line."""
    W, zeta, F = 1.6, 0.05, 0.05
    gears = catalog.gear_backlash(0.0, F, W, zeta)
    found = jp.spectrum(
        gears, quantity="v", turns=64, transient=100, initial=(0.0, 0.0), segments=1, rtol=1e-10
    )
    assert int(found.status) == 0
    line = np.abs(found.order - 1) < 0.1
    power = float(found.power_spectral_density[line].sum() * found.frequency[1])
    amplitude = F * W**2 / math.hypot(W, 2 * zeta)
    assert power == pytest.approx(amplitude**2 / 2, rel=1e-4)
    assert float(found.variance) == pytest.approx(amplitude**2 / 2, rel=1e-4)
    assert float(found.parseval_residual) < 0.01


def test_lines_of_a_periodic_motion_of_the_linkage():
    """All power at multiples of the crank's mean frequency, though the crank's speed varies in a turn."""
    mechanism = catalog.chunmei2002(2.9e-5, 3.0)
    found = jp.spectrum(mechanism, turns=40, transient=30, segments=1)
    order, values = found.order.values, found.power_spectral_density.values
    on_lines = np.abs(order - np.round(order)) < 0.1
    assert values[on_lines].sum() / values.sum() > 0.999
    exponents = jp.lyapunov(mechanism, turns=40, transient=30)
    assert float(found.turn_period) == pytest.approx(float(exponents.turn_period), rel=1e-6)
    assert abs(float(found.turn_period / found.turn_period_nominal) - 1) > 1e-7
    assert found.power_spectral_density.attrs["units"] == "N2 Hz-1"
    assert found.power_spectral_density.attrs["long_name"].endswith("normal contact force, B")


def test_chaos_fills_the_spectrum():
    """Between the lines lies what a periodic motion does not have."""
    wide = jp.spectrum(catalog.chunmei2002(2.9e-4, 3.0), turns=40, transient=30, segments=1)
    between = np.abs(wide.order % 1 - 0.5) < 0.3
    values = wide.power_spectral_density
    assert float(values[between].sum() / values.sum()) > 0.2


@pytest.mark.parametrize(("keywords", "status"), [({"max_steps": 30}, 2), ({"samples_per_turn": 2}, 0)])
def test_trouble_is_a_status(keywords, status):
    found = jp.spectrum(catalog.duffing(), turns=10, **keywords)
    assert int(found.status) == status
    assert np.all(np.isnan(found.power_spectral_density))
    assert math.isnan(float(found.variance))


def test_every_variable_says_what_it_is():
    found = jp.spectrum(catalog.chunmei2002(), turns=5, quantity="drive_torque")
    for name, variable in found.variables.items():
        assert "long_name" in variable.attrs, name
        assert ("units" in variable.attrs) == (name != "bound")


def test_every_mistake_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.spectrum(
            catalog.lorenz(), turns=3, duration=1, segments=0, samples_per_turn=1, window="haan", quantity="w"
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"turns", "segments", "samples_per_turn", "window", "quantity"}


def test_too_many_segments_are_why_nothing_is_known():
    system = catalog.duffing()
    found = jp.spectrum(system, turns=10, samples_per_turn=64, segments=5000)
    words = "the spectrum is not known: 641 samples in 5000 segments, at least 40009 are needed"
    assert jp.summary(found).lines == (words,)
    least = jp.spectrum(system, turns=10, samples_per_turn=64, segments=79)
    assert int(least.n_least) == 641
    assert "highest density" in str(jp.summary(least))


def test_orders_of_a_speed_that_swings_are_of_its_mean():
    """A run that ends within a period has turned by more than its mean speed gives."""
    drive = {"kind": "cycle", "link": "crank", "constant": 5.0, "frequency": 10.0}
    drive |= {"harmonics": [{"order": 1, "cosine": 30.0}]}
    found = jp.spectrum(
        catalog.chunmei2002(clearance=0.0, drive=drive), quantity="angle:rocker", duration=5.2
    )
    assert float(found.turn_period) == pytest.approx(math.tau / 5)
