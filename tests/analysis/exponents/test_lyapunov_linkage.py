"""Exponents of the linkage, and what a result says of itself."""

import math
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.records import ConstantSpeed
from tests.analysis.test_imposed_impacts import four_bar
from tests.support.wrong import problems_of

CASES = {
    "A": ({}, 400),
    "B": ({"gear_ratio": 3.0}, 100),
    "C": ({"clearance": 2.9e-4, "gear_ratio": 3.0}, 100),
}


@pytest.mark.nightly
@pytest.mark.parametrize("case", CASES)
def test_one_exponent_is_zero(case):
    """The motor does not know the time: exactly one."""
    changes, turns = CASES[case]
    found = jp.lyapunov(catalog.chunmei2002(**changes), exponents="all", turns=turns, transient=20)
    assert int(found.status) == 0
    zero = np.abs(found.lyapunov_exponent) < 3 * found.lyapunov_standard_error + 0.01
    assert int(zero.sum()) == 1
    assert (float(found.lyapunov_exponent[0]) > 5) == (case == "C")
    if np.all(np.isfinite(found.lyapunov_exponent)):  # in C, a rare episode of sticking loses a dimension
        assert float(found.sum_residual) < 1e-6 * abs(float(found.mean_divergence))
    turn = 2 * math.pi / catalog.chunmei2002(**changes).drive.no_load_speed
    assert float(found.turn_period) == pytest.approx(turn, rel=1e-3)


def test_leading_exponents_are_those_of_the_spectrum():
    mechanism = catalog.chunmei2002(2.9e-4, gear_ratio=3.0)
    some, all_of_them = (jp.lyapunov(mechanism, exponents=k, turns=2) for k in (2, "all"))
    assert some.lyapunov_exponent.values == pytest.approx(all_of_them.lyapunov_exponent[:2].values, rel=1e-4)
    assert math.isnan(float(some.sum_residual))


def test_what_a_contact_that_lasts_remembers_is_no_exponent():
    """The orbit's multipliers are 1, by which the law remembers, and those of the motion."""
    given = catalog.chunmei2002(drive=ConstantSpeed(link="crank", speed=8.0))
    contact = jp.Contact(law="flores", stiffness=7.15e6, parameters={"restitution": 0.5})
    joints = [
        each.model_copy(update={"contact": contact}) if each.clearance else each for each in given.joints
    ]
    mechanism = given.model_copy(update={"joints": tuple(joints)})
    orbit = jp.periodic_orbit(mechanism, transient=20)
    remembered, own = np.hypot(*orbit.floquet_multiplier.transpose("part", "multiplier").values)[:2]
    assert remembered == pytest.approx(1.0, abs=1e-6)
    found = jp.lyapunov(mechanism, turns=30, transient=20)
    assert float(found.section_exponent_per_turn[0]) == pytest.approx(math.log(own), abs=1e-2)


def test_sticking_loses_a_dimension():
    mechanism = catalog.chunmei2002(2.9e-4, gear_ratio=3.0, friction=0.3)
    found = jp.lyapunov(mechanism, exponents="all", turns=20)
    values = found.lyapunov_exponent.values
    assert np.isneginf(values[5])
    assert np.all(np.isfinite(values[:5]))
    assert np.all(np.isfinite(found.lyapunov_standard_error[:5]))


@pytest.mark.long
def test_a_stable_orbit_on_which_a_bearing_rests_for_ever_is_stable():
    """Gap and rate neither grow nor shrink while it rests: of rounding, they would outlive what shrinks."""
    mechanism = four_bar(ConstantSpeed(link="crank", speed=50.0), 0.3, 0.1)
    found = jp.lyapunov(mechanism, transient=20, turns=60, twin_turns=20)
    twins = float(found.growth)
    assert twins < -2
    assert float(found.section_exponent_per_turn[0]) == pytest.approx(twins, abs=1e-3)


def test_constant_speed():
    """A prescribed crank: guards depend on time, no exponent has to be zero."""
    mechanism = catalog.chunmei2002(2.9e-4, speed=80.0, friction=0)
    found = jp.lyapunov(mechanism, exponents="all", turns=30, transient=5)
    assert found.sizes["exponent"] == 4
    assert float(found.sum_residual) < 1e-6 * abs(float(found.mean_divergence))


def test_it_stops_at_a_target_error():
    system, keywords = catalog.duffing(), {"turns": 4000, "transient": 10}
    whole, short = (jp.lyapunov(system, error=error, **keywords) for error in (None, 0.02))
    assert float(short.lyapunov_standard_error[0]) <= 0.02
    assert int(short.n_steps) < 0.7 * int(whole.n_steps)
    assert short.lyapunov_trace.values == pytest.approx(
        whole.lyapunov_trace.values[: short.sizes["block"]], rel=1e-12
    )
    assert float(whole.lyapunov_trace[-1, 0]) == float(whole.lyapunov_exponent[0])
    assert float(whole.lyapunov_exponent_per_turn[0]) == pytest.approx(
        2 * math.pi * float(whole.lyapunov_exponent[0])
    )


def test_it_stops_at_a_target_error_beside_the_motions_own_direction_too():
    """Lorenz' system, which nothing outside times; along the motion itself there is no error to wait for."""
    found = jp.lyapunov(catalog.lorenz(), duration=3000, error=0.03)
    assert float(found.lyapunov_standard_error[0]) <= 0.03
    assert float(found.block_time[-1]) < 2000


def test_trouble_is_a_status():
    found = jp.lyapunov(catalog.lorenz(), duration=100, transient=1, max_steps=5)
    assert int(found.status) == 2
    assert math.isnan(float(found.lyapunov_exponent[0]))


@pytest.mark.parametrize(
    ("keywords", "key"),
    [
        ({"exponents": 0}, "exponents"),
        ({"exponents": 4}, "exponents"),
        ({"exponents": "some"}, "exponents"),
        ({"exponents": True}, "exponents"),
        ({"error": 0.0}, "error"),
        ({"saltation": 1}, "saltation"),
        ({"rtol": 1.0}, "rtol"),
    ],
)
def test_wrong_keywords(keywords, key):
    assert list(problems_of(jp.lyapunov, catalog.lorenz(), duration=1, **keywords)) == [key]


def test_every_variable_says_what_it_is():
    found = jp.lyapunov(catalog.lorenz(), duration=5)
    assert all({"units", "long_name"} <= variable.attrs.keys() for variable in found.variables.values())


COURSES = {
    "cycle": jp.SpeedCycle(
        link="crank", constant=60.0, frequency=60.0, harmonics=[{"order": 1, "cosine": 5.0}]
    ),
    "servo": jp.Servo(link="crank", speed=60.0, stiffness=1000.0, damping=5.0, nominal_speed=60.0),
}


@pytest.mark.nightly
@pytest.mark.parametrize("kind", COURSES)
def test_of_a_course_over_time_there_are_no_exponents_but_what_one_long_run_tells(kind):
    """As the page of study files says."""
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-5).replace(drive=COURSES[kind])
    for analysis in (jp.lyapunov, jp.covariant):
        with pytest.raises(InputError) as caught:
            analysis(mechanism, turns=10)
        (problem,) = caught.value.problems
        assert (problem.key, problem.given) == ("mechanism.drive.kind", kind)
        assert problem.expected.startswith("exponents are given of")
        assert kind in problem.expected
    assert int(jp.chaos_test(mechanism, turns=2).status) == 0
    assert int(jp.spectrum(mechanism, turns=1).status) == 0
    text = " ".join(Path("docs/study-files.md").read_text(encoding="utf-8").split())
    assert "No exponents are given of them (`lyapunov`, `covariant`)" in text
