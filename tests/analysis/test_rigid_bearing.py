"""Rigid bearings: impacts with restitution, rebounds that end, lasting contact, tangents through them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.starts import Journals, end_of, placed
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import trajectory
from jointplay_lab.stress.scenes import draw
from tests.method.test_tangent import differences, distance, scaled
from tests.support.linkages import jointed
from tests.support.multibody_records import from_mechanism

E = 2.9e-4
SLIDE = "tangential_velocity"
DOWN = {"direction": "down", "transient": 2, "turns": 4, "keep": 2, "n_jobs": 1}
BALANCE = ["energy", "energy_residual", "joint_work", "drive_work"]
TOUCH = ["penetration", "normal_velocity", "normal_force", "tangential_force", "mode"]


def rigid(restitution, clearance=E, friction=0.0, **changes):
    """The paper's mechanism with rigid bearings."""
    return hardened(
        jp.catalog.chunmei2002(clearance=clearance, gear_ratio=3.0).replace(**changes), restitution, friction
    )


def hardened(plain, restitution, friction=0.0):
    """A mechanism with rigid bearings and guides."""
    law = jp.Contact(law="restitution", parameters={"restitution": restitution})
    return jointed(plain, contact=law, friction=jp.Friction(coefficient=friction) if friction else None)


GUIDED = hardened(jp.catalog.slider_crank(clearance={"G": 1e-4}, gravity=9.8), 0.3)


def kinds(found):
    return [EVENTS[kind] for kind in found.event_kind.values]


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.8])
def test_energy_is_lost_by_impacts_alone(restitution):
    """The balance closes; rebounds end in lasting contact, which pushes and keeps the journal inside."""
    found = jp.simulate(rigid(restitution), turns=3, rtol=1e-9, record=BALANCE + TOUCH)
    assert found.status == 0
    assert found.joint_work[-1] > 5e-3
    assert np.abs(found.energy_residual).max() < 1e-7 * float(found.joint_work[-1])
    assert {"impact", "rest", "separation"} == {*kinds(found)}
    assert found.penetration.max() < 1e-11
    held = found.normal_force.values[found["mode"].values == 6]
    assert len(held) > 100
    assert held.min() >= -1e-9
    assert held.max() > 50
    assert not np.any(found.normal_force.values[found["mode"].values == 0])
    assert not np.any(found.tangential_force)


@pytest.mark.nightly
def test_a_rough_bearing_slips_and_sticks_by_coulombs_law():
    """Friction in lasting contact, in impacts, and in the balance of energy."""
    found = jp.simulate(rigid(0.3, friction=0.3), turns=3, rtol=1e-9, record=[*BALANCE, *TOUCH, SLIDE])
    assert found.status == 0
    assert {"impact", "rest"} <= {*kinds(found)}
    assert {"stick_onset", "slip_onset", "slip_reversal"} & {*kinds(found)}
    assert np.abs(found.energy_residual).max() < 1e-7 * float(found.joint_work[-1])
    assert found.penetration.max() < 1e-11
    modes, load, friction = (found[word].values for word in ("mode", "normal_force", "tangential_force"))
    slips = (modes == 2) | (modes == 3)
    assert slips.sum() > 100
    assert load[slips].min() >= -1e-9
    sense = np.where(modes == 2, 1.0, -1.0)
    assert friction[slips] == pytest.approx((0.3 * load * sense)[slips], rel=1e-7)  # the gap's tolerance
    assert (found[SLIDE].values * sense)[slips].min() > -1e-6
    assert (np.abs(friction) - 0.3 * load)[modes == 4].max(initial=-1.0) < 1e-6


@pytest.mark.long
@pytest.mark.parametrize("number", [102, 103])
def test_much_friction_holds_where_one_sense_of_slip_would_need_a_pull(number):
    """At a dead centre the journal stops, and sticks, pressed and within the cone; it does not chatter."""
    case = draw(jp.catalog.chunmei2002(), number, 7, ("restitution",))
    words = [*TOUCH, SLIDE, *BALANCE]
    found = jp.simulate(case.mechanism, turns=0.02, rtol=1e-9, initial=case.initial, record=words, steps=True)
    assert found.status == 0
    stuck, f = found["mode"].values == 4, case.mechanism.joint("B").friction.coefficient
    load, friction = found.normal_force.values[stuck], found.tangential_force.values[stuck]
    assert len(load) > 10
    assert load.min() > 0.0
    assert (np.abs(friction) - f * load).max() < 1e-6 * load.max()
    assert np.abs(found[SLIDE].values[stuck]).max() < 1e-7
    assert np.abs(found.energy_residual).max() < 1e-6 * np.abs(found.energy).max()


@pytest.mark.long
def test_a_drive_that_imposes_a_speed_answers_impacts_by_work():
    """Its impulse is the moment of the crank pin's, which the momenta of rod and slider give."""
    plain = jp.catalog.slider_crank(clearance={"B": 1e-4}, speed=100.0, gravity=9.8)
    law = jp.Contact(law="restitution", parameters={"restitution": 0.6})
    mechanism = jointed(plain, loose=True, contact=law, friction=None)
    words = [*BALANCE, "angle", "angular_velocity", "slide_velocity"]
    found = jp.simulate(mechanism, turns=1, rtol=1e-10, steps=True, record=words)
    assert found.status == 0
    crank, rod, slider = mechanism.links
    hits = found.event_time.values[[kind == "impact" for kind in kinds(found)]]
    worked = []
    for hit in hits[:20]:
        before, after = np.flatnonzero(found.time.values == hit)[[0, -1]]
        jump = found.isel(time=after) - found.isel(time=before)
        along = [np.exp(1j * float(found.angle.sel(link=k)[before])) for k in ("crank", "rod")]
        turned = float(jump.angular_velocity.sel(link="rod"))
        lever, far = rod.centre * along[1], (rod.length - rod.centre) * along[1]
        moved = rod.mass * 1j * lever * turned
        push = -slider.mass * float(jump.slide_velocity.sel(joint="G"))  # on the rod at B, along x
        own = rod.inertia - rod.mass * rod.centre**2
        # own turned = -lever x (moved - P) + far x P, with P = push + 1j up
        up = (own * turned + cross(lever, moved - push) - cross(far, push)) / cross(lever + far, 1j)
        pin = moved - push - 1j * up  # on the rod at A
        worked.append((float(jump.drive_work), 100.0 * cross(crank.length * along[0], pin)))
    given_off, wanted = np.array(worked).T
    assert len(hits) > 3
    assert np.abs(wanted).max() > 1e-5
    assert given_off == pytest.approx(wanted, rel=1e-6, abs=1e-9)


def cross(a: complex, b: complex) -> float:
    return (np.conj(a) * b).imag


def test_an_impact_is_that_of_rigid_bodies():
    """Speeds of all links after it, by multipliers in full coordinates."""
    mechanism = rigid(0.6)
    found = jp.simulate(mechanism, turns=1, steps=True, rtol=1e-10, record=["angle", "angular_velocity"])
    soft = jp.catalog.chunmei2002(clearance=E, gear_ratio=3.0, friction=0.0)
    system, times = from_mechanism(soft), found.time.values
    hits = found.event_time.values[[kind == "impact" for kind in kinds(found)]][:4]
    for hit in hits:
        before, after = np.flatnonzero(times == hit)
        angles, speeds = found.angle.values[before], found.angular_velocity.values
        y = _full(soft, angles, speeds[before])
        now = system.solve(hit, y, [False]).now
        G, W = system.constraints(now, system.ideal)[1], system.touches(now)[0][1].W_n
        n, m = now.n, len(G)
        matrix = np.zeros((n + m + 1, n + m + 1))
        matrix[range(n), range(n)] = system.mass
        matrix[:n, n:-1], matrix[n:-1, :n] = G.T, G
        matrix[:n, -1] = matrix[-1, :n] = W
        jump = np.linalg.solve(matrix, np.r_[np.zeros(n + m), -1.6 * W @ now.v])[:n]
        wanted = speeds[before] + jump[2::3]
        assert np.abs(jump[2::3]).max() > 1e-3
        assert speeds[after] == pytest.approx(wanted, rel=1e-7, abs=1e-7)
    assert len(hits) == 4


def _full(mechanism, angles, speeds):
    """Positions and speeds of all bodies' mass centres and angles; the coupler hangs on the crank."""
    (crank, coupler, rocker), place, moving = mechanism.links, [], []
    origins = {"crank": (0, 0j), "coupler": (0, 0j), "rocker": (mechanism.joint("C").bearing.point[0], 0j)}
    for link, angle, speed in zip((crank, coupler, rocker), angles, speeds, strict=True):
        along = np.exp(1j * angle)
        origin, moves = origins[link.name]
        if link is crank:
            origins["coupler"] = (link.length * along, 1j * speed * link.length * along)
        centre, rate = origin + link.centre * along, moves + 1j * speed * link.centre * along
        place += [centre.real, centre.imag, angle]
        moving += [rate.real, rate.imag, speed]
    return np.array(place + moving)


def test_restitution_is_asked_for_within_its_bounds_and_with_coulomb_friction():
    with pytest.raises(InputError, match="of at least 0 and at most 1"):
        jp.Contact(law="restitution", parameters={"restitution": 1.2})
    with pytest.raises(InputError, match=r"accepted only with law = .*; restitution has param"):
        jp.Contact(law="restitution", stiffness=1.0, parameters={"restitution": 0.5})
    rubbing = jp.Friction(law="tanh", coefficient=0.1, velocity=0.1, viscous=1.0)
    with pytest.raises(InputError, match=r"joints\[2\].friction.law: .*'tanh'.*Coulomb's") as raised:
        jointed(rigid(0.5), friction=rubbing)
    assert "friction.viscous: got 1" in str(raised.value)


def test_a_section_at_contact_is_one_at_impacts():
    found = jp.poincare(
        rigid(0.5), jp.ContactSection(joint="B"), turns=3, record=["penetration", "normal_velocity"]
    )
    assert found.status == 0
    assert found.sizes["turn"] > 9
    assert np.abs(found.penetration.values).max() < 1e-11
    assert found.normal_velocity.values.min() < -0.1
    assert found.normal_velocity.values.max() < 1e-6  # after the impact


def test_a_start_outside_a_rigid_bearing_is_refused():
    ideal = jp.simulate(rigid(0.5, clearance=0), turns=0.01, at=[0.0], record=["angle", "angular_velocity"])
    words = {name: ideal[name].isel(time=0) for name in ("angle", "angular_velocity")}
    start = {
        name: dict(zip(row.link.values.tolist(), row.values.tolist(), strict=True))
        for name, row in words.items()
    }
    start["angle"]["coupler"] += 2 * E / 0.181
    with pytest.raises(InputError, match=r"at most 1 clearances .* journal of B, here .* away"):
        jp.simulate(rigid(0.5), turns=0.1, initial=start)


@pytest.mark.long
@pytest.mark.parametrize("joints", ["B", "BC"])
def test_ideal_rebounds_keep_the_energy(joints):
    """Restitution 1, nothing driving: 1e-9 over dozens of impacts."""
    mechanism = rigid(1.0, dict.fromkeys(joints, E), drive=None, gravity=0.0)
    start = {"crank_angle": 0.0, "crank_speed": 20.0}
    found = jp.simulate(mechanism, duration=0.6, rtol=1e-11, initial=start, record=["energy"])
    assert found.status == 0
    assert kinds(found).count("impact") > 30
    assert found.energy.values == pytest.approx(float(found.energy[0]), rel=1e-9)


@pytest.mark.nightly
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tangents_through_impacts(friction):
    """Flights and impacts, against central differences of the motion itself."""
    mechanism, compared = rigid(0.95, friction=friction), 0
    model = assemble(mechanism)
    at = np.linspace(0.05, 0.6, 12) * model.period
    rows = trajectory.follow(model, trajectory.Request(at[-1] * 1.001, 1e-10, at=at)).samples
    for row in rows:
        if row[1 + len(model.state)] != 0:  # held: neighbours would begin outside
            continue
        begin = replace(model, state=row[1 : 1 + len(model.state)])
        for duration in (0.01, 0.05):
            exact, apart = scaled(begin, duration * model.period), []
            for size in (3e-8, 3e-7, 3e-6):  # rounding on one side, what is not linear on the other
                found, met, same = differences(begin, duration * model.period, size, exact)
                ended = any(EVENTS[int(kind)] == "rest" for _, kind in met)
                apart += [distance(found, exact)] if same and len(met) and not ended else []
            if apart:
                compared += 1
                assert min(apart) < 1e-6
    assert compared > (3 if friction else 5)  # friction leaves fewer flights


@pytest.mark.parametrize(
    "plain", [rigid(0.5), pytest.param(GUIDED, marks=pytest.mark.long)], ids=["bearing", "guide"]
)
def test_in_a_smaller_one_a_motion_goes_on_from_the_face(plain):
    """All is as where the other motion ended, but for the journals beyond the face, which lie on it."""
    found = jp.simulate(plain, turns=1, rtol=1e-9)
    old = placed(plain, found.end_state.values)
    ratios = Journals(old).eccentricity_ratios(old.state[None, :])[0]
    smaller = plain.replace(clearance={joint.name: 0.4 * joint.clearance for joint in plain.clearance_joints})
    new = placed(smaller, end_of(old, old.state))
    assert np.any(ratios > 0.4)
    assert Journals(new).eccentricity_ratios(new.state[None, :])[0] == pytest.approx(
        np.minimum(ratios / 0.4, 1.0), rel=1e-9
    )
    before, after = (Journals(each).velocities(each.state[None, :]) for each in (old, new))
    assert after == pytest.approx(before, abs=1e-9 * np.abs(before).max() + 1e-12)
    assert jp.simulate(smaller, initial=new.state, turns=1).status == 0


def test_a_sweep_down_the_clearance_of_a_rigid_bearing_is_carried_on():
    sweep = jp.bifurcation(rigid(0.3), over={"clearance": np.linspace(2e-4, 2.9e-4, 4)}, **DOWN)
    assert not sweep["cell_status"].any()
