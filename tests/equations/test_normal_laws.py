"""Laws of the normal force, each against its closed form: a body dropped on the contact over speeds."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from jointplay.equations.laws import FACTORS, LAWS
from tests.equations.drop import MASS, drop

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))
import laws as page  # noqa: E402

SPEEDS = (1e-2, 1e-1, 1.0, 10.0)  # m/s, three decades
K, WANTED = 2e9, (0.95, 0.7, 0.3)
NUMBERS = {"kelvin_voigt": [(1e7, 200.0)], "hertz": [(K, 1.5), (K, 1.0), (K, 2.2)]}
NUMBERS["hunt_crossley"] = [(K, 1.5, 0.05), (1e7, 1.0, 0.05)]
NUMBERS |= {name: [(K, e, 1.5, 1e-3) for e in WANTED] for name in FACTORS}
CASES = [(name, given) for name, several in NUMBERS.items() for given in several]
POWER_LAWS = [(name, given) for name, given in CASES if name != "kelvin_voigt"]


def factor(name, given, v_0):
    """d = chi v_0 of a power law."""
    if name == "hertz":
        return 0.0
    return given[2] * v_0 if name == "hunt_crossley" else FACTORS[name][0](given[1])


def test_every_law_is_dropped():
    assert set(NUMBERS) == {name for name, law in LAWS.items() if not law.rigid}


@pytest.mark.parametrize(("name", "given"), POWER_LAWS)
@pytest.mark.parametrize("v_0", SPEEDS)
def test_the_restitution_of_a_power_law_follows_from_its_factor_alone(name, given, v_0):
    found, d = drop(LAWS[name], given, v_0), factor(name, given, v_0)
    e = found["restitution"]
    assert e == pytest.approx(page.restitution(d), abs=1e-9)
    assert d * (1 + e) == pytest.approx(math.log((1 + d) / (1 - d * e)), abs=4e-9)


@pytest.mark.parametrize(("name", "given"), CASES)
def test_energy_is_never_created(name, given):
    law, v_0 = LAWS[name], 1.0
    found, remembered = drop(law, given, v_0), [v_0] if law.floor else []
    stored = law.force(found["u"], found["v"], *law.coefficients(*given), *remembered)[1]
    energy = MASS * found["v"] ** 2 / 2 + stored
    assert np.diff(energy).max() <= 1e-11 * energy[0]
    lost = energy[0] - energy[-1]
    assert (lost < 1e-9 * energy[0]) == (name == "hertz")


@pytest.mark.parametrize(("name", "given"), POWER_LAWS)
def test_the_force_of_a_power_law_is_continuous_at_entry_and_never_pulls(name, given):
    found = drop(LAWS[name], given, 1.0)
    largest = found["F"].max()
    assert abs(found["F"][0]) <= 1e-9 * largest
    assert abs(found["F"][-1]) <= 1e-9 * largest
    assert found["F"][:-1].min() >= -1e-9 * largest


@pytest.mark.parametrize("v_0", SPEEDS)
def test_kelvin_voigt_meets_both_its_closed_forms(v_0):
    stiffness, damping = NUMBERS["kelvin_voigt"][0]
    zeta = damping / (2 * math.sqrt(stiffness * MASS))
    root = math.sqrt(1 - zeta**2)
    pulling = drop(LAWS["kelvin_voigt"], (stiffness, damping), v_0)
    released = drop(LAWS["kelvin_voigt"], (stiffness, damping), v_0, tension=False)
    assert pulling["restitution"] == pytest.approx(math.exp(-math.pi * zeta / root), abs=1e-9)
    assert released["restitution"] == pytest.approx(math.exp(-2 * zeta * math.acos(zeta) / root), abs=1e-9)
    assert pulling["F"][0] == damping * v_0  # it jumps


@pytest.mark.parametrize("v_0", SPEEDS)
def test_hertz_meets_its_depth_and_contact_time(v_0):
    found = drop(LAWS["hertz"], (K, 1.5), v_0)
    assert found["depth"] == pytest.approx((5 * MASS * v_0**2 / (4 * K)) ** 0.4, rel=1e-9)
    lasting = 4 * math.sqrt(math.pi) / 5 * math.gamma(0.4) / math.gamma(0.9)  # 2.94328
    assert found["time"] == pytest.approx(lasting * found["depth"] / v_0, rel=1e-9)


def test_slow_contacts_count_as_begun_with_the_smallest_speed():
    law, given = LAWS["flores"], (K, 0.5, 1.5, 1e-2)
    coefficients = law.coefficients(*given)
    held = drop(law, given, 1e-2)["restitution"]
    force = lambda u, v, *numbers: law.force(u, v, *numbers, 1e-2)  # noqa: E731

    class Floored:
        floor, coefficients = "", staticmethod(lambda *numbers: coefficients)

    Floored.force = staticmethod(force)
    assert held == pytest.approx(page.restitution(FACTORS["flores"][0](0.5)), abs=1e-9)
    assert drop(Floored, given, 1e-3)["restitution"] == pytest.approx(page.restitution(0.16), abs=1e-9)


@pytest.mark.parametrize("name", FACTORS)
def test_a_factor_vanishes_with_the_loss_and_grows_with_it(name):
    factors = [FACTORS[name][0](e) for e in np.linspace(1.0, 0.02, 50)]
    assert factors[0] == 0
    assert np.all(np.diff(factors) > 0) or name in ("zhiying_qishao", "herbert_mcwhannell")


def test_the_page_shows_what_laws_give():
    assert page.PAGE.read_text(encoding="utf-8") == page.written(page.PAGE.read_text(encoding="utf-8"))
