"""Branches of periodic orbits: closed forms, doubled orbits, grazing, the linkage's instability."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.orbits import periodic_orbit as periodic_orbit_module
from jointplay.analysis.orbits.branch import ENDS
from jointplay.analysis.orbits.branch_dataset import Passages, point_row
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import Search, search
from jointplay.analysis.period import period
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.starts import placed
from tests.analysis.exact_maps import Symmetric, symmetry_lost


def specials(found, kind, branch=0):
    """Parameters of special points of one kind on one branch."""
    chosen = (found.special_kind.values == KINDS.index(kind)) & (found.special_branch.values == branch)
    return found.special_parameter.values[chosen]


def along(found, branch, name):
    """A variable's values along a branch."""
    return found[name].values[branch, : int(found.n_points[branch])]


def stable(found, branch=0):
    return along(found, branch, "stable") == 1


@pytest.fixture(scope="module", params=[0.8, pytest.param(0.6, marks=pytest.mark.nightly)])
def impacts(request):
    """The symmetric motion from below its loss of symmetry to beyond its fold, for a restitution."""
    r = request.param
    motion = Symmetric(0.3 * Symmetric(1.0, r).fold, r)
    keywords = {"initial": list(motion.at_zero), "transient": 0, "step": 0.06, "max_points": 90}
    limits = (0.9 * symmetry_lost(r), 1.05 * motion.fold)
    system = catalog.impact_pair(motion.gap, r)
    return r, jp.continuation(system, parameter="gap", range=limits, max_branches=2, **keywords)


@pytest.mark.nightly
def test_limits_of_the_symmetric_motion(impacts):
    r, found = impacts
    assert int(found.status) == 0
    assert specials(found, "branch_point") == pytest.approx([symmetry_lost(r)], rel=1e-9)
    assert specials(found, "fold") == pytest.approx([Symmetric(1.0, r).fold], rel=1e-10)
    assert len(specials(found, "period_doubling")) == len(specials(found, "grazing")) == 0
    assert np.all(found.special_accuracy < 1e-8)
    gaps = along(found, 0, "gap")
    assert gaps[0] == pytest.approx(0.9 * symmetry_lost(r))
    top = int(np.argmax(gaps))
    inside = (gaps[:top] > 1.0001 * symmetry_lost(r)) & (gaps[:top] < 0.9999 * gaps[top])
    assert np.array_equal(stable(found)[:top], inside | (stable(found)[:top] & ~inside))
    assert np.all(stable(found)[:top][inside])
    assert not np.any(stable(found)[top + 2 :])
    assert not np.any(stable(found)[gaps < 0.9999 * symmetry_lost(r)])


@pytest.mark.nightly
def test_where_an_impact_passes_the_section(impacts):
    """At the phase 0 the lower wall is met at the gap pi k: there, and nowhere else, the state jumps."""
    r, found = impacts
    gaps, states = along(found, 0, "gap"), along(found, 0, "orbit_state")
    (jump,) = np.flatnonzero(along(found, 0, "section_jump"))
    passed = math.pi * (1 + r) / (1 - r)
    assert min(gaps[jump - 1 : jump + 1]) < passed < max(gaps[jump - 1 : jump + 1])
    assert states[jump - 1, 1] * states[jump, 1] < 0
    assert np.abs(np.diff(states[:jump, 1])).max() < 1


@pytest.mark.nightly
def test_multipliers_along_the_branch(impacts):
    """At every point, stable or not, by the half-period map."""
    r, found = impacts
    gaps = along(found, 0, "gap")
    top = int(np.argmax(gaps))
    values = along(found, 0, "floquet_multiplier") @ [1, 1j]
    for gap, pair in list(zip(gaps, values, strict=True))[: top - 1]:
        trace, determinant = Symmetric(gap, r).half_map
        assert pair.sum() == pytest.approx(trace**2 - 2 * determinant, rel=1e-8)
        assert pair.prod() == pytest.approx(determinant**2, rel=1e-8)
    assert np.all(along(found, 0, "residual") < 1e-8)


@pytest.mark.long
def test_the_branch_that_breaks_the_symmetry(impacts):
    """It leaves both ways; its two sides are each other's mirror images, half a period apart."""
    r, found = impacts
    assert int(found.branch_parent[1]) == 0
    gaps = along(found, 1, "gap")
    crest = int(np.argmax(gaps))
    assert gaps[crest] == pytest.approx(symmetry_lost(r), rel=1e-7)
    assert np.all(np.diff(gaps[: crest + 1]) > 0)
    assert np.all(np.diff(gaps[crest:]) < 0)
    assert np.all(stable(found, 1)[[crest - 2, crest + 2]])
    speeds = along(found, 1, "smallest_impact_speed")
    both = [np.interp(0.97 * symmetry_lost(r), *side) for side in _sides(gaps, speeds, crest)]
    assert both[0] == pytest.approx(both[1], rel=1e-3)
    symmetric = Symmetric(0.97 * symmetry_lost(r), r).speed
    assert abs(both[0] - symmetric) > 3e-3 * symmetric


def _sides(x, y, crest):
    return (x[: crest + 1], y[: crest + 1]), (x[crest:][::-1], y[crest:][::-1])


@pytest.mark.nightly
def test_the_bouncing_ball_doubles_its_period():
    a = 0.5
    fold = math.pi * (1 - a) / (1 + a)
    doubling = math.hypot(fold, 2 * (1 + a**2) / (1 + a) ** 2)
    found = jp.continuation(
        catalog.bouncing_ball(1.3, a),
        parameter="acceleration",
        range=(1.02, 1.6),
        step=0.1,
        max_branches=2,
        max_points=120,
    )
    assert specials(found, "fold") == pytest.approx([fold], rel=1e-10)
    assert specials(found, "period_doubling") == pytest.approx([doubling], rel=1e-10)
    assert ENDS[int(found.branch_end[1, 0])] == "origin"
    gamma = along(found, 1, "acceleration")
    assert gamma[0] == pytest.approx(doubling, rel=1e-9)
    assert gamma[-1] == 1.6
    assert np.all(along(found, 1, "period") == 2)
    assert np.all(stable(found, 1)[1:])
    assert not np.any(stable(found)[along(found, 0, "acceleration") > doubling + 1e-6])
    # the doubled orbit is where a run settles to
    settled = jp.poincare(catalog.bouncing_ball(1.6, a), turns=2, transient=400)
    points = found.state_value.values[1, len(gamma) - 1]
    away = [[np.abs(one - other).max() for other in settled.state_value.values] for one in points]
    assert np.all(np.min(away, axis=1) < 1e-7)
    assert points[0] != pytest.approx(points[1], abs=0.1)


def test_turns_of_an_orbit_keep_their_order():
    """Each row begins with the turn that continues the row before."""
    system, section = catalog.gear_backlash(0.1, 0.2, 0.8, 0.05), jp.CrankAngle()
    requested = section_map(placed(system, None, section), section, 2)
    orbit = search(requested, Search(200))
    point = Point(orbit, 0.5, 1.0, np.array([0.0, 0.0, 1.0]))
    passages = Passages(0.0, False, Family(lambda value: requested, 0.0, 1.0, 1e-8))
    first = point_row(point, passages, ["state_value"], None)
    assert first["orbit_state"] == pytest.approx(orbit.state, abs=1e-9)
    other = first["quantities"]["state_value"][1][1]
    assert np.abs(other - orbit.state).max() > 0.1
    second = point_row(point, passages, ["state_value"], first | {"rows": first["rows"][::-1]})
    assert second["orbit_state"] == pytest.approx(other, abs=1e-9)


@pytest.mark.nightly
def test_grazing_of_the_gears():
    """The steady oscillation on one flank loses contact where its amplitude reaches the mean deflection."""
    W, zeta, load = 1.6, 0.05, 0.1
    limit = load * abs(1 - W**2 + 2j * zeta * W) / W**2
    system = catalog.gear_backlash(load, 0.9 * limit, W, zeta)
    found = jp.continuation(
        system,
        parameter="amplitude",
        range=(0.5 * limit, 1.1 * limit),
        initial=[1 + load, 0.0],
        transient=200,
        branch_switching=False,
        max_points=60,
    )
    assert int(found.status) == 0
    assert specials(found, "grazing")[:1] == pytest.approx([limit], rel=1e-6)
    event = found.special_event_kind.values[0]
    assert EVENTS[int(event)] in ("contact", "separation")
    amplitudes, gaps = along(found, 0, "amplitude"), along(found, 0, "closest_approach")
    before = amplitudes < limit * (1 - 1e-6)
    assert gaps[before] == pytest.approx(load * (1 - amplitudes[before] / limit), abs=1e-8)
    assert np.all(along(found, 0, "impacts")[amplitudes > limit * (1 + 1e-5)] == 1)


@pytest.mark.nightly
def test_a_branch_ends_where_a_rigid_impact_appears():
    """A period-3 motion of the rattling mass, from the gap 3.6 to where its flight grazes a wall."""
    found = jp.continuation(
        catalog.impact_pair(3.6, 0.8),
        parameter="gap",
        range=(2.3, 3.65),
        period=3,
        initial=[-0.7248467710645374, -0.18472721301220763],
        transient=0,
        step=0.2,
        max_branches=1,
        max_points=160,
    )
    assert ENDS[int(found.branch_end[0, 0])] == "grazing"
    (limit,) = specials(found, "grazing")
    gaps, missed = along(found, 0, "gap"), along(found, 0, "closest_approach")
    assert limit == gaps[0]
    assert missed[0] < 1e-5
    (met,) = found.special_event_kind.values[found.special_kind.values == KINDS.index("grazing")]
    assert EVENTS[met] == "impact"
    assert np.all(missed[1:] > missed[0])


@pytest.mark.nightly
def test_the_linkage_loses_stability_by_doubling():
    """At gear ratio 3 the period-1 motion doubles first near 0.0421 mm: runs on either side agree."""
    found = jp.continuation(
        catalog.chunmei2002(4.195e-5, gear_ratio=3.0),
        range=(4.19e-5, 4.215e-5),
        branch_switching=False,
        step=0.4,
        record=["eccentricity"],
    )
    (doubling,) = specials(found, "period_doubling")
    first = found.isel(special=int(np.flatnonzero(found.special_kind == 2)[0]))
    assert first.special_multiplier.values == pytest.approx([-1, 0], abs=1e-6)
    clearances = along(found, 0, "clearance")
    assert np.all(stable(found)[clearances < 0.9999 * doubling])
    assert not np.any(stable(found)[clearances > 1.0001 * doubling])
    for clearance, known in ((doubling - 6e-8, 1), (doubling + 6e-8, 2)):
        run = jp.poincare(
            catalog.chunmei2002(clearance, gear_ratio=3.0), turns=16, transient=250, record=["journal_x"]
        )
        assert period(run.journal_x.values / clearance, 1e-3) == known


@pytest.mark.nightly
def test_the_linkage_over_the_speed_of_its_drive():
    """The units of the states, which go with the nominal speed, stay those of the first orbit."""
    linkage = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)
    keywords = {"transient": 60, "step": 0.5, "max_points": 30, "branch_switching": False, "record": ()}
    found = jp.continuation(linkage, parameter="gear_ratio", range=(2.95, 3.05), rtol=1e-10, **keywords)
    assert [ENDS[code] for code in found["branch_end"].values[0]] == ["range", "range"]
    last = along(found, 0, "floquet_multiplier")[-1]
    alone = jp.periodic_orbit(linkage.replace(gear_ratio=3.05), transient=60, rtol=1e-10)
    assert last[0] == pytest.approx(alone["floquet_multiplier"].values[0], abs=1e-7)


def test_a_branch_that_begins_nowhere():
    found = jp.continuation(catalog.chunmei2002(), range=(2e-5, 4e-5), max_steps=3)
    assert int(found.status) == 2
    assert found.sizes["special"] == 0
    assert np.all(np.isnan(found.floquet_multiplier))


@pytest.mark.parametrize(
    ("keywords", "keys"),
    [
        ({"range": (2.0, 1.0)}, ["range"]),
        ({"range": (2.0,), "step": 0.0}, ["range[1]", "step"]),
        ({"range": (1.0, 2.0)}, ["start"]),
        ({"range": (1.0, 9.0), "parameter": "gsp"}, ["range.gsp"]),
        ({"range": (-1.0, 9.0)}, ["range.gap[0]"]),
        ({"range": (1.0, 9.0), "max_points": 0, "branch_switching": 1}, ["max_points", "branch_switching"]),
    ],
)
def test_wrong_keywords(keywords, keys):
    with pytest.raises(jp.InputError) as caught:
        jp.continuation(catalog.impact_pair(5.0, 0.8), **({"parameter": "gap"} | keywords))
    assert [problem.key for problem in caught.value.problems] == keys


def test_every_variable_says_what_it_is(impacts):
    _, found = impacts
    lacking = [name for name, v in found.variables.items() if not {"units", "long_name"} <= v.attrs.keys()]
    assert set(lacking) <= {"state"}


@pytest.mark.nightly
def test_an_orbit_is_continued_from_its_own_answer():
    """An unstable orbit, whose motion leaves it for the doubled one; and that, with its period."""
    mechanism = catalog.chunmei2002(4.65e-5, gear_ratio=3.0)
    how = {"parameter": "clearance", "range": (4.6e-5, 4.7e-5), "max_points": 3, "branch_switching": False}
    for asked in (1, 2):
        orbit = jp.periodic_orbit(mechanism, period=asked)
        again = jp.periodic_orbit(mechanism, initial=orbit)
        assert (int(again.period), int(again.stable)) == (asked, asked - 1)
        assert int(again.n_iterations) <= 2
        branch = jp.continuation(mechanism, initial=orbit, **how)
        here = np.flatnonzero(np.abs(branch.clearance.values[0] - 4.65e-5) < 1e-12)
        assert branch.period.values[0, here].tolist() == [asked]
        if asked == 1:  # a doubled orbit may begin with either of its points
            own = branch.orbit_state.values[0, here[0]]
            np.testing.assert_allclose(own, orbit.orbit_state.values, rtol=1e-7, atol=1e-9)
            np.testing.assert_allclose(again.orbit_state, orbit.orbit_state, rtol=1e-9, atol=1e-11)


def test_an_orbit_s_period_and_transient_give_way_to_those_asked_for(monkeypatch):
    pair, seen = catalog.impact_pair(3.6, 0.8), []
    orbit = jp.periodic_orbit(pair, initial=(0.0, 0.5), transient=50)
    monkeypatch.setattr(periodic_orbit_module, "search", lambda section, how, *_: seen.append((section, how)))
    for given, expected in (({}, (1, 0)), ({"period": 3}, (3, 0)), ({"transient": 7}, (1, 7))):
        with pytest.raises(AttributeError):
            jp.periodic_orbit(pair, initial=orbit, **given)
        section, how = seen.pop()
        assert (section.turns, how.transient) == expected
    motion = jp.simulate(pair, turns=1, initial=orbit)
    np.testing.assert_array_equal(motion.state_value[0], orbit.orbit_state)
