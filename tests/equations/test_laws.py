"""Laws of the normal force keep to what `Law` asks of them; one more is one object, used everywhere."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.vary import axes
from jointplay.display.errors import InputError
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS, Law
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.joints import Contact, Friction
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.eligibility import exclusion
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, follow
from tests.equations.drop import arguments
from tests.support.belt import LAWS as RUBBING
from tests.support.belt import NUMPY, contact
from tests.support.linkages import jointed

SPEED = 0.3  # m/s, with which a contact began
ROUND = 1e-10  # m, where the power of a penetration is rounded off
FRICTION = {
    "none": None,
    "coulomb": Friction(coefficient=0.2),
    "viscous": Friction(coefficient=0.1, viscous=5.0),
}
FRICTION["tanh"] = Friction(law="tanh", coefficient=0.2, velocity=0.01)
FRICTION = RUBBING | FRICTION


def _hunt_crossley(_, u, v_n, K, C, n):
    """F_n = K |u|^(n - 1) u (1 + C v_n), rounded off at u = 0; it stores K |u|^(n + 1) / (n + 1)."""
    square = u**2 + ROUND**2
    return K * square ** ((n - 1) / 2) * u * (1 + C * v_n), K * square ** ((n + 1) / 2) / (n + 1)


HUNT_CROSSLEY = Law(
    force=_hunt_crossley,
    slopes=lambda depth, K, C, n: (K * (depth**2 + ROUND**2) ** ((n - 1) / 2) * n, 0.0),
    numbers={
        "stiffness": Quantity("K", "1", trial=2.3e9),
        "damping": Quantity("C", "s/m", least=0.0, trial=0.5),
        "power": Quantity("n", "1", trial=1.5),
    },
)
TRIED = [*(name for name, law in LAWS.items() if not law.rigid), "test_hunt_crossley"]


@pytest.fixture
def added(monkeypatch):
    monkeypatch.setitem(LAWS, "test_hunt_crossley", HUNT_CROSSLEY)


def linkage(law="kelvin_voigt", friction=None, **changes):
    """The paper's linkage with another law in its joints."""
    plain, made = catalog.chunmei2002(gear_ratio=3.0, **changes), contact(law)
    return jointed(plain, contact=made, friction=friction)


def _at(name, depth=None):
    """A law's force and numbers; of one that remembers with a speed, or its slopes up to a depth."""
    law = LAWS[name]
    given = arguments(law, law.trial.values())
    if depth is not None:
        return law.slopes(depth, *given)
    return lambda u, v: law.force(NUMPY, u, v, *given, *([SPEED] if law.floor else []))


def test_every_law_says_numbers_with_which_it_is_tried():
    for law in (*LAWS.values(), *FRICTIONS.values()):
        assert None not in law.trial.values()
        assert law.formula


@pytest.mark.parametrize("name", TRIED)
def test_a_law_is_defined_beyond_the_surface_and_bounded_near_it(added, name):
    force_of = _at(name)
    u, v = np.meshgrid(np.linspace(-1e-3, 1e-3, 41), np.linspace(-2.0, 2.0, 41))
    force, stored = force_of(u, v)
    assert np.isfinite(force).all()
    assert np.isfinite(stored).all()
    assert force_of(0.0, 0.0)[0] == 0.0
    assert (force_of(u[u > 0], 0.0)[0] > 0).all()
    for depth in (1e-16, 1e-4):
        per_u, per_v = _at(name, depth)
        for u, v in ((depth, 0.0), (-depth, 0.0), (0.0, 1e-12), (depth, -1e-12)):
            assert abs(force_of(u, v)[0]) <= (per_u * abs(u) + per_v * abs(v)) * (1 + 1e-9)
        steps = np.linspace(-depth, depth, 101)
        assert np.abs(np.diff(force_of(steps, 0.0)[0]) / np.diff(steps)).max() <= per_u * (1 + 1e-9)


@pytest.mark.parametrize("name", TRIED)
def test_at_rest_the_force_is_the_slope_of_what_is_stored(added, name):
    force_of, u, h = _at(name), np.linspace(-1e-4, 1e-4, 9), 1e-9
    slope = (force_of(u + h, 0.0)[1] - force_of(u - h, 0.0)[1]) / (2 * h)
    assert np.allclose(slope, force_of(u, 0.0)[0], rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("name", TRIED)
def test_what_has_the_sign_of_a_force_has_it(added, name):
    law = LAWS[name]
    given = arguments(law, law.trial.values())
    u, v = np.meshgrid(np.linspace(1e-6, 1e-3, 11), np.linspace(-5.0, 5.0, 40))
    if law.push is not None:
        push = law.push(v, *given, *([SPEED] if law.floor else [])) + 0 * v
        assert np.array_equal(np.sign(push), np.sign(_at(name)(u, v)[0]))
        assert (push > 0).all() == (not law.pulls)


def test_a_motion_has_the_forces_of_its_law_and_balances_its_energy():
    record = ["normal_force", "penetration", "normal_velocity", "mode", "energy_residual", "energy"]
    found = jp.simulate(linkage("flores"), turns=1, rtol=1e-9, record=record).sel(joint="B")
    touching = found.mode.values > 0
    time, u, v = (found[name].values[touching] for name in ("time", "penetration", "normal_velocity"))
    begun = found.event_kind.values == Event.CONTACT
    last = np.searchsorted(found.event_time.values[begun], time) - 1
    v_0 = found.event_normal_velocity.values[begun][last]
    assert int(found.status) == 0
    assert touching.sum() > 30
    assert not touching.all()
    assert np.ptp(v_0) > 0.05
    force = LAWS["flores"].force(NUMPY, u, v, *contact("flores").coefficients.values(), v_0)[0]
    assert np.allclose(found.normal_force.values[touching], force, rtol=1e-9)
    assert np.abs(found.energy_residual.values).max() < 1e-9 * np.abs(found.energy.values).max()


def test_wrong_numbers_of_a_law_are_refused_together(added):
    with pytest.raises(InputError) as caught:
        Contact(law="test_hunt_crossley", stiffness=-1.0, damping=0.0, parameters={"powr": 1.5})
    told = str(caught.value)
    assert "contact.stiffness: got -1.0" in told
    assert "did you mean 'parameters.power'?" in told
    assert "contact.parameters.power: got nothing" in told
    with pytest.raises(InputError) as caught:
        Contact(law="lankarani_nikravech", stiffness=1.0, damping=-1.0)
    told = str(caught.value)
    assert "did you mean 'lankarani_nikravesh'?" in told
    assert "contact.damping: got -1.0" in told
    with pytest.raises(InputError) as caught:
        Contact(law="flores", stiffness=1.0, damping=1.0, parameters={"restitution": 0.0, "slowest": 0.0})
    told = str(caught.value)
    assert "contact.damping: got 1.0; accepted only with law = 'kelvin_voigt' or " in told
    assert "flores has stiffness, parameters.restitution, parameters.exponent, parameters.slowest\n" in told
    wanted = "a restitution greater than 0 and at most 1 of law flores is accepted"
    assert f"contact.parameters.restitution: got 0.0; {wanted}" in told
    assert "contact.parameters.slowest: got 0.0" in told
    with pytest.raises(InputError, match=r"damping: got nothing; a damping of at least 0 N s/m of law"):
        Contact(stiffness=1.0)


def test_numbers_of_a_law_that_are_left_out_take_their_usual_values():
    found = Contact(law="lee_wang", stiffness=1.0, parameters={"restitution": 0.5})
    assert found.numbers == {"stiffness": 1.0, "restitution": 0.5, "exponent": 1.5, "slowest": 1e-3}
    assert found.coefficients == {"K": 1.0, "dr": 0.375, "n": 1.5, "vmin": 1e-3}


def test_numbers_of_an_added_law_vary(added):
    mechanism, key = linkage("test_hunt_crossley"), "joints.B.contact.parameters.power"
    found = jp.bifurcation(mechanism, over={key: [1.4, 1.5]}, transient=0, turns=1, rtol=1e-6)
    assert found.power.values.tolist() == [1.4, 1.5]
    assert (found.power.units, found.power.long_name) == ("1", "power of joint B")
    (stiffness,) = axes(mechanism, {"joints.B.contact.stiffness": [1e9]})
    assert stiffness.units == "1"
    assert float(np.ptp(found["angular_velocity"].values)) > 0


IN_LANES = [
    pytest.param(
        "kelvin_voigt", each, marks=[pytest.mark.nightly] if each in {*RUBBING} - {"coulomb", "tanh"} else ()
    )
    for each in FRICTION
]


@pytest.mark.nightly
@pytest.mark.parametrize(("law", "friction"), [*IN_LANES, ("test_hunt_crossley", "none")])
def test_lanes_know_a_law(added, law, friction):
    mechanism = linkage(law, FRICTION[friction], clearance=5e-5)
    model = assemble(mechanism, section="angle:crank")
    request = Request(0.15 * model.period, 1e-6, events=True, log_from=-1.0)
    if model.structure.joints[0].falls:  # with the sliding speed: it may excite what lanes do not look for
        assert exclusion(model, request) == "falling_friction"
        return
    assert not exclusion(model, request)
    (found,), alone = follow_ensemble([model], [request]), follow(model, request)
    assert found.events[:, 1].tolist() == alone.events[:, 1].tolist()
    assert np.allclose(found.events[:, 2], alone.events[:, 2], rtol=1e-4, atol=1e-6 * model.period)
    assert found.route == 1


def test_every_friction_is_tried_in_lanes():
    assert {name for name, law in FRICTIONS.items() if law.rises} < set(FRICTION)


@pytest.mark.nightly
def test_a_start_beyond_where_a_law_ends_is_refused_and_a_motion_near_it_warned_of():
    soft = {"length": 0.02, "journal_modulus": 1e7}
    plain = linkage("johnson", clearance=2.9e-4)
    mechanism = jointed(plain, contact=Contact(law="johnson", parameters=soft))
    end = 4 * 2.9e-4 / np.exp(2)
    assert mechanism.joint("B").deepest == pytest.approx(end)
    with pytest.warns(jp.ModelWarning, match=r"whose law ends at 0\.541"):
        found = jp.simulate(mechanism, turns=1, rtol=1e-6, record=["penetration"])
    assert jp.words(found).status == "not_converged"
    assert 0.5 * end < found.penetration.max() <= end
    angle = {"crank": 0.0, "coupler": 0.3, "rocker": 1.2}
    with pytest.raises(InputError, match=r"at most 1\.541 clearances"):
        assemble(mechanism, {"angle": angle, "angular_velocity": dict.fromkeys(angle, 0.0)})
