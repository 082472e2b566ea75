"""Guides with clearance in motion: corners against the second program, energy, limits, tangents."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.solver.equations.structure import CORNERS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import trajectory
from tests.method.test_tangent import differences, distance, scaled
from tests.support.linkages import jointed
from tests.support.multibody_records import from_mechanism
from tests.support.multibody_run import assemble as put_together
from tests.support.multibody_run import closed, follow

pytestmark = pytest.mark.nightly
TOUCH = ["penetration", "normal_velocity", "tangential_velocity", "normal_force", "tangential_force"]
GENTLE = jp.Friction(law="tanh", coefficient=0.2, velocity=0.5)
ROUGH = {
    "slider_crank": {"rod": 0.0, "slider": 0.0},
    "quick_return": {"block": 1.2, "arm": 1.2, "rod": 0.0, "ram": 0.0},
}


@pytest.mark.parametrize(
    ("name", "loose", "tension", "turns", "corners"),
    [
        ("slider_crank", "G", True, 0.6, 4),
        ("slider_crank", "G", False, 0.4, 4),
        ("quick_return", "S", True, 0.1, 2),
    ],
)
def test_the_second_program_moves_alike(name, loose, tension, turns, corners):
    """Angles, forces at corners and ideal joints, and events through many impacts of corners."""
    plain = getattr(jp.catalog, name)(clearance={loose: 1e-4}, gravity=9.8, tension=tension)
    mechanism, angle = jointed(plain, friction=GENTLE), 0.3
    found = jp.simulate(
        mechanism,
        turns=turns,
        rtol=1e-12,
        record=["angle", "angular_velocity", "reaction_x", "reaction_y", "slide_position", *TOUCH],
        samples_per_turn=round(60 / turns),
        initial={"crank_angle": angle},
    )
    system, times = from_mechanism(mechanism, angle), found.time.values
    ideal = from_mechanism(mechanism.replace(clearance=0), angle)
    y = put_together(ideal, {"crank": angle} | ROUGH[name])
    states, modes, events = follow(system, y, times, rtol=1e-13)
    n = len(mechanism.links)
    for word, mine in (("angle", states[:, 2 : 3 * n : 3]), ("angular_velocity", states[:, 3 * n + 2 :: 3])):
        assert np.abs(found[word].values - mine).max() < 1e-8 * np.abs(mine).max(), word
    rows = zip(times, states, modes, strict=True)
    solved = [system.solve(t, state, closed(mode)) for t, state, mode in rows]
    names = [f"{loose}_{corner}" for corner in CORNERS]
    mine = np.array([[[x.u, x.v_n, x.v_t, F_n, F_t] for _, x, F_n, F_t in row.touches] for row in solved])
    for k, word in enumerate(TOUCH):
        values = found[word].sel(joint=names).values
        assert np.abs(values - mine[:, :, k]).max() < 1e-7 * np.abs(mine[:, :, k]).max(), word
    for k, word in enumerate(("reaction_x", "reaction_y")):
        mine = np.array([[row.reactions[pin][k] for pin in found.pin.values] for row in solved])
        assert np.abs(found[word].values - mine).max() < 1e-7 * np.abs(mine).max(), word
    assert len(events) > 8
    assert {event.touch for event in events} == {*range(corners)}
    assert found.event_joint.values.tolist() == [event.touch for event in events]
    assert found.event_time.values == pytest.approx([event.time for event in events], abs=1e-8 * times[-1])


@pytest.mark.parametrize(("name", "loose"), [("slider_crank", "G"), ("quick_return", "S")])
def test_energy_is_kept_without_a_drive(name, loose):
    """Corners without damping and friction, over five turns of the crank."""
    free = getattr(jp.catalog, name)(clearance={loose: 1e-4}, gravity=9.8, drive=None)
    free = jointed(free, friction=None, contact=jp.Contact(stiffness=1e7, damping=0.0))
    run = {"initial": {"crank_angle": 0.3, "crank_speed": 50.0}, "rtol": 1e-12}
    motion = jp.simulate(free, duration=1.0, record=["energy", "kinetic_energy", "angle", "mode"], **run)
    assert motion.status == 0
    assert abs(float(motion.angle.sel(link="crank")[-1])) > 10 * np.pi
    assert np.all(np.any(motion["mode"].values != 0, axis=0))
    drift = np.abs(motion.energy - motion.energy[0]).max() / motion.kinetic_energy.max()
    assert float(drift) < 1e-9


@pytest.mark.parametrize(("name", "loose"), [("slider_crank", "G"), ("quick_return", "S")])
def test_energy_is_balanced_with_friction_that_sticks(name, loose):
    mechanism = getattr(jp.catalog, name)(clearance={loose: 1e-4}, gravity=9.8).replace(friction=0.2)
    words = ["energy_residual", "drive_work", "joint_work", "mode"]
    motion = jp.simulate(mechanism, turns=2, rtol=1e-10, record=words)
    assert motion.status == 0
    assert motion.sizes["event"] > 30
    assert float(motion.joint_work.max()) > 1e-4
    assert float(np.abs(motion.energy_residual).max()) < 1e-7 * float(np.abs(motion.drive_work).max())


def test_clearance_that_vanishes_leaves_the_ideal_slider_crank():
    """Angles are off by the clearance over lengths: half of it, half as far."""
    run = {"turns": 0.5, "rtol": 1e-9, "samples_per_turn": 360}
    firm = jp.simulate(jp.catalog.slider_crank(clearance=0), record=["angle"], **run)
    off = []
    for e in (2e-5, 1e-5):
        loose = jp.catalog.slider_crank(clearance={"G": e}, stiffness=1e9, damping=1e4)
        found = jp.simulate(loose, record=["angle"], **run)
        off.append(float(np.abs(found.angle.sel(link="rod") - firm.angle.sel(link="rod")).max()))
        tilt = float(np.abs(found.angle.sel(link="slider")).max())
        assert tilt < 1.2 * e / 0.02
    assert off[0] < 1.2 * 2e-5 / 0.12
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.2)


def test_the_mirrored_mechanism_moves_in_the_mirror():
    """Upside down, upper corners are lower ones."""
    run = {"turns": 0.4, "rtol": 1e-11, "record": ["angle", *TOUCH]}
    up = jp.simulate(
        jp.catalog.slider_crank(clearance={"G": 1e-4}, offset=0.02, gravity=9.8, speed=200.0),
        initial={"crank_angle": 0.5},
        **run,
    )
    down = jp.simulate(
        jp.catalog.slider_crank(clearance={"G": 1e-4}, offset=-0.02, gravity=-9.8, speed=-200.0),
        initial={"crank_angle": -0.5},
        **run,
    )
    order = [2, 3, 0, 1]
    assert np.abs(up.angle.values + down.angle.values).max() < 1e-9
    for word in TOUCH:
        mirrored = down[word].values[:, order]
        assert np.abs(up[word].values - mirrored).max() < 1e-7 * np.abs(up[word].values).max(), word
    assert up.event_joint.values.tolist() == [order[j] for j in down.event_joint.values]


@pytest.mark.parametrize(("name", "loose"), [("slider_crank", "G"), ("quick_return", "S")])
def test_tangents_through_impacts_of_corners(name, loose):
    mechanism, errors, met = getattr(jp.catalog, name)(clearance={loose: 1e-4}), [], set()
    model = assemble(mechanism)
    at = np.linspace(0.1, 1.5, 10) * model.period
    rows = trajectory.follow(model, trajectory.Request(at[-1] * 1.001, 1e-10, at=at)).samples
    for row in rows:
        begin = replace(model, state=row[1 : 1 + len(model.state)])
        turned = model.numbers.copy()
        turned[-1] += turned[-2] * row[0]  # where the prescribed crank is by then
        begin = replace(begin, numbers=turned)
        for duration in (0.02, 0.05):
            exact, apart = scaled(begin, duration * model.period), []
            for size in (1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4):  # rounding, and what is not linear
                found, events, same = differences(begin, duration * model.period, size, exact)
                apart += [distance(found, exact)] if same and len(events) else []
            if apart:
                met |= {EVENTS[int(kind)] for _, kind in events}
                errors.append(min(apart))
    assert len(errors) > 5
    assert max(errors) < 2e-5
    assert np.median(errors) < 1e-6
    assert {"contact", "separation"} <= met


FIRST = 0.00269250275202121  # s: the first impact, by two independent programs
NEWTON = {"initial": {"crank_speed": 150.0}, "duration": 0.2, "steps": True}
CLOSED = ["energy", "energy_residual", "joint_work", "penetration", "normal_velocity", "normal_force", "mode"]


def jumps(found, word):
    """Values before and after every event, as the steps have them."""
    twice = np.flatnonzero(np.diff(found.time.values) == 0.0)
    return found[word].values[twice], found[word].values[twice + 1]


def test_flores_slider_meets_the_upper_face_with_both_corners():
    """The first impact's time and both rates after it; then rebounds, rest, release, for five turns."""
    record = [*CLOSED, "tangential_force"]
    found = jp.simulate(jp.catalog.flores2010(), rtol=1e-11, record=record, **NEWTON)
    assert found.status == 0
    assert found.event_time.values[:2] == pytest.approx([FIRST, FIRST], rel=1e-11)
    assert sorted(found.event_joint.values[:2]) == [0, 1]
    before, after = jumps(found, "normal_velocity")
    assert before[0] == pytest.approx([0.841612322032869] * 2 + [-0.841612322032869] * 2, rel=1e-9)
    assert after[0] == pytest.approx(-0.4 * before[0], rel=1e-9)
    kinds = [EVENTS[kind] for kind in found.event_kind.values]
    assert {"impact", "rest", "separation"} <= {*kinds}
    assert found.penetration.max() < 1e-12
    modes, load, friction = (found[word].values for word in ("mode", "normal_force", "tangential_force"))
    slips = (modes == 2) | (modes == 3)
    assert slips.sum() > 100
    assert load[slips].min() > -1e-6
    sense = np.where(modes == 2, 1.0, -1.0)
    assert friction[slips] == pytest.approx((0.01 * load * sense)[slips], abs=1e-9)
    assert not friction[modes == 0].any()


@pytest.mark.parametrize("restitution", [0.0, 0.4, 0.8, 1.0])
@pytest.mark.parametrize(("tilt", "friction"), [(0.0, 0.0), (1e-6, 0.3), (0.005, 0.0), (0.005, 0.3)])
def test_impacts_of_corners_create_no_energy(restitution, tilt, friction):
    """Started in line or tilted: corners one by one, handing the impulse to each other, or at once."""
    start = {"angle": {"crank": 0.0, "rod": 0.0, "slider": tilt}}
    start["angular_velocity"] = {"crank": 150.0, "rod": -75.0, "slider": 0.0}
    mechanism = jp.catalog.flores2010(restitution=restitution, friction=friction)
    found = jp.simulate(mechanism, rtol=1e-11, record=CLOSED, **NEWTON | {"initial": start})
    assert found.status == 0
    assert found.sizes["event"] > 20
    assert found.penetration.max() < 1e-12
    before, after = jumps(found, "energy")
    assert np.max(after - before) < 1e-12
    energy = found.energy.values
    assert np.abs(found.energy_residual).max() < 1e-7 * energy[0]
    assert energy.max() < energy[0] * (1 + 1e-8)
    assert (restitution == 1.0 and not friction) or energy[0] - energy[-1] > 0.01


def test_ideal_rebounds_of_corners_keep_the_energy():
    """Restitution 1: hundreds of impacts, one corner after the other."""
    start = {"angle": {"crank": 0.0, "rod": 0.0, "slider": 0.003}}
    start["angular_velocity"] = {"crank": 150.0, "rod": -75.0, "slider": 1.0}
    run = NEWTON | {"initial": start}
    smooth = jp.catalog.flores2010(restitution=1.0, friction=0.0)
    found = jp.simulate(smooth, rtol=1e-11, record=CLOSED, **run)
    assert found.status == 0
    assert found.sizes["event"] > 300
    assert found.energy.values == pytest.approx(float(found.energy[0]), rel=1e-9)


def test_tangents_end_where_two_corners_hit_at_once():
    found = jp.lyapunov(jp.catalog.flores2010(drive=jp.ConstantSpeed(link="crank", speed=150.0)), turns=5)
    assert STATUS[int(found.status)] == "no_derivative"
