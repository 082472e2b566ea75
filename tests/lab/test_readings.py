"""Readings of the paper: what each changes, and what a motion is said to be."""

import math

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import STATUS
from jointplay.display.errors import InputError, Problem
from jointplay_lab.paper import readings as module
from jointplay_lab.paper.character import MOTIONS, character, motion
from jointplay_lab.paper.reading_list import PANELS, READINGS, Reading, coarse
from jointplay_lab.paper.readings import readings

SHORT = {"turns": 24, "transient": 30, "growth_turns": 40, "n_jobs": 1}
PRINTED = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)


@pytest.fixture(scope="module")
def table():
    return readings(panels=("b", "c"), readings=("as_printed", "no_tension", "diametral_clearance"), **SHORT)


@pytest.mark.nightly
def test_every_variable_says_what_it_is(table):
    assert table.sizes == {"panel": 2, "reading": 3, "point": 200}
    assert table.clearance.values.tolist() == [2.9e-5, 2.9e-4]
    assert table.gear_ratio.values.tolist() == [3.0, 3.0]
    for name, variable in table.variables.items():
        assert variable.attrs["long_name"], name
        assert "units" in variable.attrs or variable.dtype.kind in "iU", name
    assert STATUS[int(table.status)] == "ok"


@pytest.mark.long
def test_what_is_found_of_the_panels(table):
    b, c = (table.sel(panel=panel, reading="as_printed") for panel in "bc")
    assert (int(b.period), MOTIONS[int(b.motion)], float(b.separations)) == (1, "periodic", 1.0)
    assert float(b.growth) == pytest.approx(-1.477, abs=5e-3)
    assert (int(c.period), MOTIONS[int(c.motion)]) == (0, "chaotic")
    assert 2 < float(c.separations) < 6
    assert float(c.growth) > 3 * float(c.growth_standard_error)


@pytest.mark.nightly
def test_the_points_are_the_last_of_the_section(table):
    one = table.sel(panel="b", reading="as_printed")
    cut = jp.poincare(PRINTED, turns=1, transient=53, rtol=1e-10)
    assert np.isnan(one.section_x.values[:-24]).all()
    ends = [float(one.section_x[-1]), float(one.section_y[-1])]
    assert ends == pytest.approx(
        [float(cut.journal_x[-1, 0]) / 2.9e-5, float(cut.journal_y[-1, 0]) / 2.9e-5], abs=1e-6
    )


def test_no_more_points_are_kept_than_a_picture_takes(monkeypatch):
    monkeypatch.setattr(module, "POINTS", 3)
    points = np.arange(10.0).reshape(5, 2)
    assert module._last_points({"points": points}).tolist() == points[2:].tolist()


@pytest.mark.long
def test_points_are_over_the_clearance_that_is_read(table):
    """The contact carries about the same force: about the same penetration, whatever the clearance."""
    inside = [
        (math.hypot(one.section_x[-1], one.section_y[-1]) - 1) * clearance
        for name, clearance in (("as_printed", 2.9e-5), ("diametral_clearance", 1.45e-5))
        for one in [table.sel(panel="b", reading=name)]
    ]
    assert inside[1] == pytest.approx(inside[0], rel=0.25)


def changed(name, panel="b"):
    return READINGS[name].change(catalog.chunmei2002(*PANELS[panel]))


def test_what_each_reading_changes():
    assert changed("as_printed") == PRINTED
    assert changed("efficiency_in_slope").drive.no_load_speed == pytest.approx(104.72, abs=1e-2)
    assert changed("rated_torque_in_newton_metres").drive.rated_torque == pytest.approx(2.2)
    assert not changed("no_tension").joint("B").contact.tension
    assert changed("frictionless").joint("B").friction is None
    assert changed("diametral_clearance").joint("B").clearance == 1.45e-5
    assert changed("lower_branch").branch == "lower"
    friction = changed("friction_tanh").joint("B").friction
    assert (friction.law, friction.coefficient, friction.velocity) == ("tanh", 0.01, 0.01)
    assert READINGS["start_up"].settings == {"transient": 0}


def test_the_mass_models_of_the_coupler():
    """Uniform bar and point mass at B, bar and two bosses: mass, centre and inertia as in Table 1."""
    length, mass, inertia = 0.181, 0.1743, 2.7e-3
    point = 1.5 * (inertia / length**2 - mass / 3)
    bar = mass - point
    link = changed("point_mass_at_B").link("coupler")
    assert (link.mass, link.inertia) == (mass, inertia)
    assert link.centre == pytest.approx((bar / 2 + point) * length / mass, rel=1e-3)
    assert changed("uniform_coupler").link("coupler").inertia == pytest.approx(
        mass * length**2 / 3, rel=1e-12
    )
    boss = 3 * (inertia / length**2 - mass / 3)
    assert (
        0 < 2 * boss < mass
    )  # equal bosses can carry it, about a centre halfway: rigid, the printed coupler
    assert changed("end_bosses") == PRINTED


def test_start_up_drops_nothing():
    found = readings(panels=("a",), readings=("start_up", "as_printed"), **SHORT)
    first, later = (found.sel(panel="a", reading=name) for name in ("start_up", "as_printed"))
    assert float(first.impacts) > 0
    assert float(later.impacts) == 0
    assert float(later.contact_fraction) == 1


@pytest.mark.nightly
def test_coarse_steps_smear_a_point_and_nothing_more():
    found = coarse(PRINTED, turns=12, transient=12, tolerance=1e-4, growth_turns=40)
    spread = np.ptp(found["points"], axis=0).max()
    assert 1e-5 < spread < 1e-2
    assert found["period"] == 0
    assert coarse(PRINTED, turns=12, transient=12, tolerance=1e-2)["period"] == 1
    assert MOTIONS[found["motion"]] == "undecided"
    assert found["separations"] == 1.0


def fails(error):
    def change(mechanism):
        raise error

    return Reading("fails", change)


@pytest.mark.parametrize(
    ("error", "status"),
    [(InputError([Problem("x", 1, "none")]), "bad_parameters"), (ZeroDivisionError("oh"), "crashed")],
)
def test_a_cell_that_fails_is_named_and_the_others_go_on(monkeypatch, error, status):
    monkeypatch.setitem(module.READINGS, "broken", fails(error))
    monkeypatch.setattr(module, "_scenes", lambda cells: [])
    found = readings(panels=("b",), readings=("broken", "as_printed"), **SHORT)
    broken, good = (found.sel(panel="b", reading=name) for name in ("broken", "as_printed"))
    assert STATUS[int(broken.cell_status)] == STATUS[int(found.status)] == status
    assert math.isnan(broken.growth)
    assert int(broken.period) == -1
    assert str(broken.trouble.values)
    assert (STATUS[int(good.cell_status)], int(good.period)) == ("ok", 1)


def test_out_of_steps_is_a_status():
    found = readings(panels=("b",), readings=("as_printed",), max_steps=50, **SHORT)
    assert STATUS[int(found.cell_status[0, 0])] == "step_limit"


@pytest.mark.long
def test_one_worker_or_two():
    """Bit for bit."""
    one, two = (
        readings(panels=("b",), readings=("as_printed", "no_tension"), **SHORT | {"n_jobs": n})
        for n in (1, 2)
    )
    xr.testing.assert_identical(one, two)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"panels": ("d",)}, r"panels\[0\].*accepted: a, b, c"),
        ({"readings": ("as_printed", "no_tensoin")}, r"readings\[1\].*did you mean 'no_tension'"),
        ({"readings": ()}, "readings: .*at least one"),
        ({"mechanism": catalog.duffing()}, "mechanism.*motor-driven"),
        ({"mechanism": catalog.chunmei2002(speed=80.0)}, "mechanism.*motor-driven"),
    ],
)
def test_wrong_input(options, word):
    with pytest.raises(InputError, match=word):
        readings(**options)


@pytest.mark.parametrize(
    ("period", "growth", "error", "word"),
    [
        (1, -0.5, 0.1, "periodic"),
        (1, -0.2, 0.1, "undecided"),
        (1, 0.5, 0.1, "undecided"),
        (0, 0.5, 0.1, "chaotic"),
        (0, 0.2, 0.1, "undecided"),
        (0, -0.5, 0.1, "undecided"),
        (0, 0.5, math.nan, "undecided"),
        (2, math.nan, 0.1, "undecided"),
    ],
)
def test_the_rule(period, growth, error, word):
    assert MOTIONS[motion(period, growth, error)] == word


@pytest.mark.parametrize(("panel", "turns"), [("b", 10), ("c", 8)])
@pytest.mark.parametrize("transient", [0, 5])
def test_contact_is_counted_as_a_response_counts_it(panel, turns, transient):
    """Separations, impacts and contact fraction, from events here and from samples of the mode there."""
    mechanism = catalog.chunmei2002(*PANELS[panel])
    found = character(mechanism, turns=turns, transient=transient, growth_turns=0, rtol=1e-12)
    section = jp.poincare(mechanism, turns=turns + transient, rtol=1e-12).time.values
    start, end = section[transient - 1] if transient else 0.0, section[-1]
    samples = np.linspace(start, end, 40_001)
    response = jp.simulate(mechanism, duration=end, at=samples, rtol=1e-12, record=["mode"])
    touching = response["mode"].values[:, 0] > 1
    assert found["contact_fraction"] == pytest.approx(touching.mean(), abs=2e-3)
    changes = np.diff(touching.astype(int))
    assert found["separations"] * turns == pytest.approx(np.sum(changes < 0), abs=1e-9)
    assert found["impacts"] * turns == pytest.approx(np.sum(changes > 0), abs=1e-9)
