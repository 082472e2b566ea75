"""Ideal loops and slides in motion: energy kept, balanced in contact; clearance that vanishes."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from tests.equations.test_groups import BAR, GUESS, PLATE, SCENES, beside_a_group, newton
from tests.equations.test_ideal_loops import linkage

pytestmark = pytest.mark.long
DRIVE = {"kind": "speed", "link": "crank", "speed": 30.0}
EXAMPLES = ("slider_crank", "watt", "stephenson", "quick_return")


@pytest.mark.parametrize("name", EXAMPLES)
def test_energy_is_kept_without_a_drive(name):
    """Over five turns of the crank, gravity and all."""
    free = getattr(jp.catalog, name)(clearance={}, gravity=9.8, drive=None)
    run = {"initial": {"crank_angle": 0.3, "crank_speed": 50.0}, "rtol": 1e-12}
    motion = jp.simulate(free, duration=1.0, record=["energy", "kinetic_energy", "angle"], **run)
    assert abs(float(motion.angle.sel(link="crank")[-1])) > 10 * np.pi
    drift = np.abs(motion.energy - motion.energy[0]).max() / motion.kinetic_energy.max()
    assert float(drift) < 1e-9


@pytest.mark.parametrize(
    ("name", "loose"), [*(("slider_crank", k) for k in "OAB"), ("stephenson", "B"), ("quick_return", "E")]
)
def test_energy_is_balanced_in_contact(name, loose):
    """Work of the drive, work taken in by the joint and energy: nothing is left over."""
    mechanism = getattr(jp.catalog, name)(clearance={loose: 1e-4}, gravity=9.8)
    motion = jp.simulate(
        mechanism, turns=1, rtol=1e-10, record=["energy_residual", "drive_work", "joint_work"]
    )
    assert int(motion.status) == 0
    assert motion.sizes["event"] > 3
    assert float(motion.joint_work.max()) > 1e-4
    assert float(np.abs(motion.energy_residual).max()) < 1e-7 * float(np.abs(motion.drive_work).max())


@pytest.mark.parametrize("joint", "OAB")
def test_clearance_that_vanishes_leaves_the_ideal_slider_crank(joint):
    """The slider is off by the clearance and what it goes in: half of both, half as far."""
    run = {"turns": 0.5, "rtol": 1e-9, "samples_per_turn": 360}
    words = ["slide_position"]
    off = []
    firm = jp.simulate(jp.catalog.slider_crank(clearance=0), record=words, **run)
    for e in (2e-5, 1e-5):
        loose = jp.catalog.slider_crank(clearance={joint: e}, stiffness=1e9, damping=1e4)
        found = jp.simulate(loose, record=words, **run)
        off.append(
            float(np.abs(found.slide_position.sel(joint="G") - firm.slide_position.sel(joint="G")).max())
        )
    assert off[0] < 1.4 * 2e-5
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.2)


@pytest.mark.nightly
def test_a_plate_on_three_bars_keeps_its_energy():
    """Five turns: what closes by four links at a time drifts no more than the rest."""
    start = {"crank_angle": 0.3, "crank_speed": 20.0}
    free, words = SCENES["bars"]().replace(drive=None), ["energy", "kinetic_energy", "angle"]
    motion = jp.simulate(free, turns=5, rtol=1e-11, initial=start, record=words)
    drift = np.abs(motion.energy - motion.energy[0]).max() / motion.kinetic_energy.max()
    assert float(drift) < 1e-9
    names = ["crank", "rod", "plate", "left", "right"]
    for row in motion.angle.sel(link=names).values[::40]:
        np.testing.assert_allclose(np.exp(1j * row[1:]), np.exp(1j * newton(row[0])), atol=1e-12)
    assert abs(motion.angle.sel(link="crank")[-1]) > 9 * np.pi


@pytest.mark.nightly
def test_clearance_beyond_a_plate_on_three_bars():
    """Exponents are those of what moves: memories add none."""
    found = jp.lyapunov(beside_a_group(DRIVE), transient=5, turns=20, exponents="all")
    assert int(found.status) == 0
    assert found.sizes["exponent"] == 4
    settling = 5 * 30.0
    assert np.all(np.abs(found.lyapunov_exponent + settling) > 1.0)


def bars(elastic=None, **loose):
    """The plate on three bars, its rod rigid or elastic; play at a joint that is named."""
    joints = [
        each
        | ({"journal": each["journal"] | {"at": 1.0}} if each["name"] == "B" else {})
        | loose.get(each["name"], {})
        for each in PLATE + BAR
    ]
    made = linkage(joints, GUESS, DRIVE | {"speed": 10.0})
    beam = {} if elastic is None else {"elastic": True, "beam": elastic}
    links = [
        jp.Link(**dict(link) | {"mass": 1.0, "centre": 0.5, "inertia": 0.4} | beam)
        if link.name == "rod"
        else link
        for link in made.links
    ]
    return jp.Mechanism(**dict(made) | {"links": tuple(links)})


@pytest.mark.nightly
def test_an_elastic_link_within_a_group_nears_a_rigid_one():
    """Its energy is balanced; damped, its drive's torque nears that of the rigid one as 1/E."""
    run = {"turns": 1, "rtol": 1e-10, "record": ["energy_residual", "drive_work", "drive_torque", "angle"]}
    firm, off = jp.simulate(bars(), **run), []
    assert assemble(bars()).guesses == 8
    for modulus in (1e9, 4e9):
        beam = jp.Beam(modulus=modulus, density=1000.0, shapes="sine", modes=1, damping_ratio=0.3)
        bent = jp.simulate(bars(beam), **run)
        assert int(bent.status) == 0
        assert np.abs(bent.energy_residual).max() < 1e-9 * np.abs(bent.drive_work).max()
        late = slice(len(bent.time) // 2, None)  # the start is straight, and rings
        off.append(float(np.abs((bent.drive_torque - firm.drive_torque)[late]).max()))
    assert off[0] < 0.02 * float(np.abs(firm.drive_torque).max())
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["B", "C"])
def test_play_within_a_group_opens_it(name):
    """What is left closes by two links at a time, and the energy is balanced."""
    contact = jp.Contact(stiffness=1e6, damping=500.0)
    loose = {"clearance": 1e-3, "radius": 0.02, "contact": contact, "friction": {"coefficient": 0.1}}
    made = bars(**{name: loose})
    assert assemble(made).guesses == 0
    motion = jp.simulate(made, turns=1, rtol=1e-10, record=["energy_residual", "drive_work"])
    assert int(motion.status) == 0
    assert motion.sizes["event"] > 5
    assert float(np.abs(motion.energy_residual).max()) < 1e-7 * float(np.abs(motion.drive_work).max())
