"""Laws of the normal force, each against its closed form: a body dropped on the contact over speeds."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import FACTORS, LAWS
from tests.equations.drop import JOINT, MASS, arguments, drop
from tests.support.belt import NUMPY

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))
from pages import laws as page  # noqa: E402

SPEEDS = (1e-2, 1e-1, 1.0, 10.0)  # m/s, three decades
K = LAWS["hertz"].trial["stiffness"]
FURTHER = {"restitution": (1.0, 0.95, 0.3), "bearing_modulus": (1.1e11,), "bearing_poisson_ratio": (0.34,)}
EXPONENTS = {"exponent": (1.0, 2.2)}  # of laws of no restitution: the others are alike
CYLINDERS = [name for name, law in LAWS.items() if "R" in law.joint]


def cases():
    """Numbers of every law: those with which it is tried, then others of one of them at a time."""
    for name, law in LAWS.items():
        further = FURTHER if "restitution" in law.numbers else EXPONENTS
        others = ({key: x} for key in law.numbers for x in further.get(key, ()))
        for changed in ({}, *others) if not law.rigid else ():
            yield name, tuple((law.trial | changed).values())


CASES = [*cases()]
FIRST = dict(reversed(CASES))
POWER_LAWS = [(name, given) for name, given in CASES if LAWS[name].push]


def factor(name, given, v_0):
    """d = chi v_0 of a law whose force is that of a spring times 1 + chi v_n, by its push at v_n = v_0."""
    law = LAWS[name]
    return law.push(v_0, *arguments(law, given), *[v_0] * bool(law.floor)) - 1


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
    stored = law.force(NUMPY, found["u"], found["v"], *arguments(law, given), *remembered)[1]
    energy = MASS * found["v"] ** 2 / 2 + stored
    rounding = 1e-10 if name == "liu" else 1e-11  # its stored energy is a difference
    assert np.diff(energy).max() <= rounding * energy[0]
    lost = energy[0] - energy[-1]
    assert (lost < 1e-9 * energy[0]) == (law.push is not None and factor(name, given, v_0) == 0.0)


@pytest.mark.parametrize(("name", "given"), POWER_LAWS)
def test_the_force_of_a_power_law_is_continuous_at_entry_and_never_pulls(name, given):
    found = drop(LAWS[name], given, 1.0)
    largest = found["F"].max()
    assert abs(found["F"][0]) <= 1e-9 * largest
    assert abs(found["F"][-1]) <= 1e-9 * largest
    assert found["F"][:-1].min() >= -1e-9 * largest


@pytest.mark.parametrize("v_0", SPEEDS)
def test_kelvin_voigt_meets_both_its_closed_forms(v_0):
    stiffness, damping = FIRST["kelvin_voigt"]
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


def published(name, F):
    """Penetration over the force, once more, in the units of the publications: force a length."""
    (L, E_j, nu_j, E_b, nu_b, *_), (e, R) = FIRST[name], JOINT.values()
    h = (1 - nu_j**2) / (math.pi * E_j) + (1 - nu_b**2) / (math.pi * E_b)
    if name == "johnson":
        return F / L * h * (math.log(4 * e * L / (h * F)) - 1)
    if name == "dubowsky_freudenstein":
        return F * h / L * (math.log(L**3 * e / (F * (R + e) * R * h)) + 1)
    half = lambda u: 0.5 * u / h / math.pi * math.pi * math.sqrt(u / (2 * (e + u))) * L - F  # noqa: E731
    return brentq(half, 1e-12, 1.0, xtol=1e-22, rtol=1e-14)


@pytest.mark.parametrize("name", CYLINDERS)
@pytest.mark.parametrize("F", [1.0, 1e3, 1e5])
def test_cylinders_are_pressed_in_as_far_as_published(name, F):
    u = published(name, F)
    force, stored = LAWS[name].force(NUMPY, u, 0.0, *arguments(LAWS[name], FIRST[name]), 1.0)
    assert force == pytest.approx(F, rel=1e-11 if u > 1e-6 else 1e-7)
    work, _ = quad(lambda f: f * _slope(name, f), 0.0, F, epsrel=1e-10)  # integral of F du
    assert stored == pytest.approx(work, rel=1e-7, abs=5e-12)


def _slope(name, F):
    """d u / d F, by differences of the published form."""
    h = 1e-4 * F
    near, far = (published(name, F + n * h) - published(name, F - n * h) for n in (1, 2))
    return (8 * near - far) / (12 * h)


@pytest.mark.parametrize("name", ["johnson", "dubowsky_freudenstein"])
def test_a_law_of_the_force_ends_where_it_turns_back(name):
    law, given = LAWS[name], arguments(LAWS[name], FIRST[name])
    end = law.deepest(*given)
    force = [float(law.force(NUMPY, u, 0.0, *given, 1.0)[0]) for u in (end * (1 - 1e-9), end * (1 + 1e-9))]
    assert _slope(name, force[0]) == pytest.approx(0.0, abs=1e-3 * published(name, force[0]) / force[0])
    assert published(name, force[0]) == pytest.approx(end, rel=1e-8)
    assert math.isnan(force[1])


def test_slow_contacts_count_as_begun_with_the_smallest_speed():
    law, given = LAWS["flores"], (K, 0.5, 1.5, 1e-2)
    coefficients = law.coefficients(*given)
    held = drop(law, given, 1e-2)["restitution"]
    force = lambda m, u, v, *numbers: law.force(m, u, v, *numbers, 1e-2)  # noqa: E731

    class Floored:
        floor, joint, coefficients = "", (), staticmethod(lambda *numbers: coefficients)

    Floored.force = staticmethod(force)
    assert held == pytest.approx(page.restitution(FACTORS["flores"][0](0.5)), abs=1e-9)
    assert drop(Floored, given, 1e-3)["restitution"] == pytest.approx(page.restitution(0.16), abs=1e-9)


@pytest.mark.parametrize("name", FACTORS)
def test_a_factor_vanishes_with_the_loss_and_grows_with_it(name):
    factors = [FACTORS[name][0](e) for e in np.linspace(1.0, 0.02, 50)]
    assert factors[0] == 0
    assert np.all(np.diff(factors) > 0) or name in ("zhiying_qishao", "herbert_mcwhannell")


def test_every_law_has_its_row_on_the_page_that_is_written_of_them():
    rows = re.findall(r"^\| `(\w+)` \|", page.page(), re.MULTILINE)
    assert rows == [*LAWS, *FRICTIONS, *FACTORS]
