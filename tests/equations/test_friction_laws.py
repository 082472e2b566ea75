"""Laws of friction keep to their formulas, in generated text too; their records; one more is one object."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from jointplay import catalog
from jointplay.analysis.vary import axes
from jointplay.display.errors import InputError
from jointplay.solver.equations.friction import FRICTIONS, FrictionLaw, parameter_letters
from jointplay.solver.equations.laws import LAWS as NORMAL
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.method.modes import STICKS
from tests.support.belt import LAWS, REGULARISED, STICKING, belt, ratio
from tests.support.friction_claims import rows
from tests.support.linkages import jointed
from tests.support.multibody_laws import ratio as published
from tests.support.plain import Point, plain
from tests.support.wrong import listed, only, problems_of

SPEEDS = np.concatenate([[0.0], np.geomspace(1e-9, 30.0, 400)])
STEP = 1e-30
PAGE = Path(__file__).parents[2] / "docs" / "friction-laws.md"


def test_no_two_numbers_of_a_joint_share_a_letter():
    for normal, (name, law) in itertools.product(NORMAL.values(), FRICTIONS.items()):
        own = [each.letter for key, each in law.numbers.items() if key != "velocity"]
        words = ["e", "R", "rx0", "ry0", "D", *normal.letters, "f", "v", "Ct", *own]
        assert len(set(words)) == len(words), (normal, name)
        assert {*law.letters, "f", "v", "Ct"} == set(parameter_letters(name))
        assert law.numbers.get("velocity", Quantity("v", "m/s")).letter == "v"


@pytest.mark.parametrize("name", LAWS)
def test_the_formula_is_the_published_one_on_both_sides(name):
    for v in (*SPEEDS, *-SPEEDS, -0.0):
        assert ratio(LAWS[name], v) == pytest.approx(published(LAWS[name], v), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("name", LAWS)
def test_symmetry_and_dissipation(name):
    mu = ratio(LAWS[name], SPEEDS) + 0 * SPEEDS
    if name in REGULARISED:
        assert mu[0] == 0.0
        assert np.array_equal(ratio(LAWS[name], -SPEEDS), -mu)
        assert (mu * SPEEDS >= 0).all()
    else:
        assert np.array_equal(ratio(LAWS[name], -SPEEDS) + 0 * SPEEDS, mu)
        assert (mu > 0).all()
        assert mu[0] == getattr(LAWS[name], FRICTIONS[name].limit)


@pytest.mark.parametrize("name", LAWS)
def test_generated_rates_and_jacobian(name):
    """Text against the formula, its slopes against complex steps, on both sides of rest and of kinks."""
    friction = LAWS[name]
    modes = ["slip+", "slip-"] if name in STICKING else ["contact"]
    for v, mode in itertools.product((-0.9, -0.05, -0.01, 0.01, 0.03, 0.05, 0.11, 0.9), modes):
        model = belt(friction, (0.02, v), V=0.0)
        here = Point(plain(model.structure), model.numbers, model.state, [mode])
        sign = {"slip+": 1.0, "slip-": -1.0, "contact": 1.0}[mode]
        force = sign * published(friction, v) * 20.0
        assert here.contacts()[0, 4] == pytest.approx(force, rel=1e-13)
        assert here.rate()[0, 0] == pytest.approx((-50.0 * 0.02 - force) / 2.0, rel=1e-13)
        state = model.state + 1j * STEP * np.array([0.0, 1.0])
        slope = Point(plain(model.structure), model.numbers, state, [mode], complex).rate()[0, 0].imag / STEP
        assert here.jacobian()[0, 1] == pytest.approx(slope, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_slopes_are_finite_at_rest(name):
    mode = "slip+" if name in STICKING else "contact"
    for exponent in (1.0, 1.5, 2.0) if hasattr(LAWS[name], "exponent") else (None,):
        friction = Friction(**LAWS[name].model_dump() | ({"exponent": exponent} if exponent else {}))
        model = belt(friction, (0.0, 0.0), V=0.0)
        here = Point(plain(model.structure), model.numbers, model.state, [mode])
        assert np.isfinite(here.jacobian()).all()
        assert np.isfinite(here.rate()).all()


@pytest.mark.parametrize("name", LAWS)
def test_what_sticks(name):
    model = belt(LAWS[name], (0.02, 0.1))
    functions = plain(model.structure)
    assert bool(functions.CONTACTS["block"] & STICKS) == (name in STICKING)
    if name in STICKING:
        here = Point(functions, model.numbers, model.state, ["stick"])
        limit = getattr(LAWS[name], FRICTIONS[name].limit) * 20.0
        assert np.allclose(here.rate(), 0.0, atol=1e-15)
        assert here.watched()[3, 0] == pytest.approx(limit**2 - (50.0 * 0.02) ** 2)
        assert here.contacts()[0, 4] == pytest.approx(-50.0 * 0.02)


def test_the_page_says_what_laws_give():
    page = PAGE.read_text(encoding="utf-8")
    assert [line for line in page.splitlines() if line.endswith(" of it |")] == rows()


# One more law is one object.

CUBIC = FrictionLaw(
    lambda m, v, f, v_0, c: f * m.tanh(v / v_0) * (1 + m.power(v * m.side(v) / c, 3)),
    numbers={"velocity": Quantity("v", "m/s"), "cubic_velocity": Quantity("vc", "m/s", usual=5.0)},
)


@pytest.fixture
def added(monkeypatch):
    monkeypatch.setitem(FRICTIONS, "test_cubic", CUBIC)


def linkage(friction):
    """The paper's linkage with another friction in its joints."""
    return jointed(catalog.chunmei2002(gear_ratio=3.0), friction=friction)


def test_an_added_law_is_one_object(added):
    friction = Friction(law="test_cubic", coefficient=0.2, velocity=0.01)
    assert friction.cubic_velocity == 5.0
    model = belt(friction, (0.0, -0.3), V=0.0)
    here = Point(plain(model.structure), model.numbers, model.state, ["contact"])
    assert here.contacts()[0, 4] == pytest.approx(-0.2 * 20 * math.tanh(30.0) * (1 + 0.06**3), rel=1e-13)
    mechanism = linkage(friction).varied({"joints.B.friction.cubic_velocity": 4.0})
    assert mechanism.joint("B").friction.cubic_velocity == 4.0
    (axis,) = axes(mechanism, {"joints.B.friction.cubic_velocity": [3.0, 4.0]})
    assert (axis.units, axis.long_name) == ("m s-1", "cubic velocity of joint B")
    with pytest.raises(InputError, match="a cubic velocity greater than 0 m/s of law test_cubic"):
        Friction(law="test_cubic", coefficient=0.2, velocity=0.01, cubic_velocity=0.0)


# The record.


def test_all_problems_of_a_law_at_once():
    given = {"law": "stribeck", "coefficient": 0.3, "static_coefficient": 0.2, "stribek_velocity": 1.0}
    found = problems_of(Friction, **given, exponent=20, velocity=0.1, viscous=-1)
    keys = "static_coefficient stribek_velocity stribeck_velocity exponent velocity viscous"
    assert set(found) == {f"friction.{key}" for key in keys.split()}
    told = {key.removeprefix("friction."): str(problem) for key, problem in found.items()}
    assert "not below the coefficient (0.3)" in told["static_coefficient"]
    assert "did you mean 'stribeck_velocity'?" in told["stribek_velocity"]
    assert "got nothing; a stribeck velocity greater than 0 m/s" in told["stribeck_velocity"]
    assert "at least 1 and at most 10" in told["exponent"]
    assert "law = 'tanh' or 'ramp'" in told["velocity"]


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        ({"law": "than", "coefficient": 0.1}, "law", "did you mean 'tanh'?"),
        ({"law": "tanh", "coefficient": 0.1}, "velocity", "got nothing; a velocity greater than 0 m/s"),
        ({"coefficient": 0.1, "velocity": 0.1}, "velocity", "accepted only with law = 'tanh'"),
        ({"law": "tanh", "coefficient": 0.1, "velocity": True}, "velocity", "greater than 0 m/s"),
        ({"law": "tanh", "coefficient": 0.1, "velocity": math.inf}, "velocity", "greater than 0 m/s"),
        (
            {"law": "ambrosio", "coefficient": 0.1, "velocity": 0.2, "full_velocity": 0.2},
            "full_velocity",
            "above the velocity (0.2 m/s)",
        ),
    ],
)
def test_wrong_friction(given, key, words):
    assert words in str(only(problems_of(Friction, **given), f"friction.{key}"))


def test_problems_inside_a_mechanism_are_told_once():
    table = listed(linkage(LAWS["stribeck"]).model_dump())
    rubbing = table["joints"][2]["friction"]
    del rubbing["stribeck_velocity"]
    rubbing |= {"static_coefficient": 0.1, "viscous": -1.0, "velocity": 2.0}
    found = problems_of(Mechanism, **table)
    keys = ("stribeck_velocity", "static_coefficient", "viscous", "velocity")
    assert set(found) == {f"mechanism.joints[2].friction.{key}" for key in keys}


def test_records_of_friction():
    assert Friction(coefficient=0.1) == Friction(coefficient=0.1, velocity=None)
    for name, friction in LAWS.items():
        assert Friction(**friction.model_dump()) == friction
        assert TypeAdapter(Friction).validate_python(friction) is friction
        assert name == "coulomb" or name in linkage(friction).joint("B").description
    assert LAWS["stribeck"].exponent == 2.0
    assert (
        linkage(LAWS["stribeck"])
        .joint("B")
        .description.endswith(
            "friction 0.3 (stribeck, static coefficient 0.5, stribeck velocity 100 mm/s, exponent 2)"
        )
    )


def test_a_changed_coefficient_keeps_the_law():
    mechanism = linkage(LAWS["stribeck"])
    kept = mechanism.replace(friction=0.4).joint("B").friction
    assert kept == Friction(**LAWS["stribeck"].model_dump() | {"coefficient": 0.4})
    assert mechanism.replace(friction=0).joint("B").friction is None
    with pytest.raises(InputError, match=r"friction: got 0\.6; .*joint B.*not below the coefficient"):
        mechanism.replace(friction=0.6)


def test_without_a_kinetic_coefficient_the_static_one_acts():
    friction = Friction(**LAWS["stribeck"].model_dump() | {"coefficient": 0.0})
    assert friction.rubs
    assert not Friction(**LAWS["tanh"].model_dump() | {"coefficient": 0.0}).rubs


def test_the_schema_names_every_number():
    schema = Friction.model_json_schema()
    assert schema["properties"]["law"]["enum"] == [*FRICTIONS]
    assert schema["properties"]["stribeck_velocity"]["units"] == "m/s"
    assert {n for law in FRICTIONS.values() for n in law.numbers} < set(schema["properties"])
    assert schema["additionalProperties"] is False
