"""What tips motions: knocks by the laws of impulse, known boundaries, edge states on saddle orbits."""

import math
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.coexisting.knocks import (
    ABOVE,
    AT,
    BELOW,
    Impulse,
    Knock,
    Knocked,
    Place,
    knocks,
    smallest,
    speeds_by_moment,
)
from jointplay.analysis.coexisting.lasting import FAILED, FromAfar, Lasting, Motions
from jointplay.analysis.coexisting.tipping import returned
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.rules import section_of
from jointplay.analysis.starts import Journals
from jointplay.analysis.states.ends import Observation
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.assemble import assemble

WELLS, DAMPING = catalog.duffing(amplitude=0.05, damping=0.2), 0.2
LINKAGE = catalog.chunmei2002(2.5e-4, gear_ratio=3.0)


@pytest.fixture(scope="module")
def wells():
    region = {"y": (-1.5, 1.5), "v": (-1.0, 1.0)}
    keywords = {"starts": 12, "largest": 1.5, "steps": 12, "phases": 4, "transient": 40, "turns": 16}
    return jp.tipping(WELLS, region=region, n_jobs=1, **keywords)


def state_of(model, rows, names):
    found = Quantities(model, rows, rows[0]).variables(names, "row")
    return {name: found[name][1] for name in names}


@pytest.mark.parametrize("link", ["crank", "coupler", "rocker"])
def test_an_impulsive_moment_does_the_work_of_its_mean_angular_velocity(link):
    """An impulse J on a link changes the kinetic energy by J (w before + w after) / 2."""
    model = assemble(LINKAGE, None, section_of(LINKAGE))
    (knock,) = [each for each in knocks(model, LINKAGE) if each.name == f"impulse:{link}"]
    after = knock.applied(model, 0.0, 0.3)
    width, n = len(model.state) + 1 + len(model.joints), model.links.index(link)
    rows = np.zeros((2, width))
    rows[0, 1 : 1 + len(model.state)], rows[1, 1 : 1 + len(model.state)] = model.state, after.state
    said = Quantities(model, rows, rows[0])
    speed = said.variables(["angular_velocity"], "row")["angular_velocity"][1][:, n]
    gained = np.diff(said._mechanical(rows))[0]
    assert gained == pytest.approx(0.3 * knock.unit * speed.mean(), rel=1e-9)
    assert speed[1] - speed[0] == pytest.approx(0.3 * math.tau / model.period, rel=1e-9)
    back = knock.applied(after, math.pi, 0.3)
    assert back.state == pytest.approx(model.state, rel=1e-12)
    assert not np.array_equal(speeds_by_moment(model, link), np.zeros(3))


RODS = {
    "hammer": {"on": {"link": "rocker", "at": 0.1}, "direction": 0.3},
    "own": {"on": {"link": "crank", "at": 0.03}, "direction": 1.5, "fixed": "link"},
    "any": {"on": {"link": "coupler", "at": 0.05}},
}


@pytest.mark.parametrize("name", RODS)
def test_an_impulse_on_a_point_does_the_work_of_its_mean_velocity(name):
    """J d.(v before + v after) / 2, v of the point as its links' angles and speeds have it."""
    model = assemble(LINKAGE, None, section_of(LINKAGE))
    impulse = Impulse(name=name, **RODS[name])
    (knock,) = [each for each in knocks(model, LINKAGE, [impulse]) if each.kind == "blow"]
    n, rows = len(model.turning), np.zeros((2, len(model.state) + 1 + len(model.joints)))
    after = knock.applied(model, 0.4 if knock.plane else 0.0, 0.3)
    rows[:, 1 : 1 + len(model.state)] = model.state, after.state
    angle, speed = rows[0, 1 : 1 + n], rows[:, 1 + n : 1 + 2 * n]
    across = dict(zip(model.links, np.stack([-np.sin(angle), np.cos(angle)], -1), strict=True))
    speeds = dict(zip(model.links, speed.T, strict=True))
    link, at = impulse.on.link, impulse.on.at
    velocity = at * speeds[link][:, None] * across[link]
    if link == "coupler":
        velocity += LINKAGE.joint("A").journal.at * speeds["crank"][:, None] * across["crank"]
    way = (impulse.direction or 0.4) + (angle[model.links.index(link)] if impulse.fixed == "link" else 0.0)
    gained = np.diff(Quantities(model, rows, rows[0])._mechanical(rows))[0]
    work = 0.3 * knock.unit * velocity.mean(axis=0) @ [math.cos(way), math.sin(way)]
    assert gained == pytest.approx(work, rel=1e-9)
    back = knock.applied(after, math.pi + 0.4 if knock.plane else math.pi, 0.3)
    assert back.state == pytest.approx(model.state, rel=1e-9)


@pytest.mark.nightly
def test_impulses_that_cannot_be_are_refused_all_at_once():
    wrong = [{"name": "a", "on": {"link": "rod"}}, {"name": "a", "on": {"link": "rocker"}}]
    with pytest.raises(InputError) as caught:
        jp.tipping(LINKAGE, region={"eccentricity_ratio_x": (-0.5, 0.5)}, impulses=wrong)
    assert {each.key for each in caught.value.problems} == {"impulses[0].on.link", "impulses[1].name"}
    with pytest.raises(InputError, match="moving link"):
        jp.tipping(
            LINKAGE,
            region={"eccentricity_ratio_x": (-0.5, 0.5)},
            impulses=[{"name": "a", "on": {"link": "ground", "point": [0, 0]}}],
        )
    with pytest.raises(InputError, match="does not bend"):
        jp.tipping(
            catalog.chunmei2002(elastic=["rocker"]),
            region={"eccentricity_ratio_x": (-0.5, 0.5)},
            impulses=[{"name": "a", "on": {"link": "rocker"}}],
        )


def test_a_shift_moves_the_journal_alone_and_no_farther_than_its_bearing():
    model = assemble(LINKAGE, None, section_of(LINKAGE))
    (shift,) = [each for each in knocks(model, LINKAGE) if each.kind == "shift"]
    moved, journals = shift.applied(model, 0.7, 0.25), Journals(model)
    before, after = (journals.positions(each.state[None])[0] for each in (model, moved))
    assert (after - before) / model.clearances[0] == pytest.approx(
        [0.25 * math.cos(0.7), 0.25 * math.sin(0.7)], abs=1e-9
    )
    speeds = [journals.velocities(each.state[None]) for each in (model, moved)]
    assert speeds[1] == pytest.approx(speeds[0], abs=1e-9)
    assert moved.state[0] == model.state[0]
    assert shift.applied(model, 0.7, 2.5) is None


def test_a_state_is_not_knocked_through_a_wall():
    pair = assemble(catalog.impact_pair(3.6, 0.8), None, "phase")
    up = next(each for each in knocks(pair, catalog.impact_pair(3.6, 0.8)) if each.name == "state:y")
    assert up.applied(pair, 0.0, 10.0) is None
    assert up.applied(pair, math.pi, 0.5).state[0] == pair.state[0] - 0.5


class Told(Knocked):
    """Knocks whose ends are told by a threshold, a function of their place."""

    def ends(self, tried):
        return np.array([self.threshold(place, size) for place, size in tried])


def told(threshold, plane=True):
    base = assemble(WELLS, None, section_of(WELLS))
    motions = Motions(base, Observation(0, 8, 0, 1e-3, 1e-7))
    case = Told(motions, 0, np.zeros((2, 2)), base, Knock("shift:B" if plane else "state:y", 1.0))
    case.threshold = threshold
    return case


def test_the_search_finds_the_smallest_of_a_known_boundary():
    def over(place, size):
        edge = 1.0 - 0.3 * math.cos(place.direction - 1.0) - 0.2 * math.cos(place.phase - 2.5)
        return int(size > edge + 0.1 * place.point)

    found = smallest(told(over), 8, 8, np.arange(1, 17) / 10)
    assert found.high == pytest.approx(0.5, rel=0.02)
    assert found.low < found.high
    assert (found.place.point, found.ends[BELOW], found.ends[ABOVE]) == (0, 0, 1)
    assert found.safe == found.low
    assert math.cos(found.place.direction - 1.0) > 0.95
    assert smallest(told(over), 8, 8, np.array([0.2, 0.4])) is None


def test_failed_knocks_tip_nothing_and_an_island_is_not_confirmed():
    assert smallest(told(lambda place, size: FAILED), 4, 4, np.array([0.5, 1.0])) is None
    island = smallest(told(lambda place, size: int(0.5 < size < 0.502), False), 1, 2, np.array([0.501, 1.0]))
    assert np.flatnonzero(island.ends).tolist() == [AT]
    assert math.isnan(island.confirmed)


def test_the_search_goes_on_below_an_island_of_smaller_knocks():
    found = smallest(
        told(lambda place, size: int(0.55 < size < 0.6 or size > 0.8), False), 1, 2, np.array([0.4, 0.8, 1.2])
    )
    assert found.high == pytest.approx(0.55, rel=1e-3)
    assert (found.ends[BELOW], found.ends[ABOVE], found.ends[-1]) == (0, 1, 0)


def test_what_is_safe_below_bands_that_go_on_is_told():
    """Bands of both at every size from 0.5 on, each a hundredth of the size; below all return."""
    bands = smallest(
        told(lambda place, size: int(size > 0.5 and math.log(size) % 0.01 < 0.005), False),
        1,
        2,
        np.array([1.0]),
    )
    assert 0.5 <= bands.high <= 1.0
    assert bands.safe <= bands.high
    assert bands.ends[AT] == 1
    if bands.ends[BELOW]:
        assert bands.safe < 0.98 * bands.high


def bands(*edges):
    """Knocks that tip from the first edge to the second, from the third to the fourth, and so on."""
    case = told(lambda place, size: int(np.searchsorted(edges, size, side="left") % 2), False)
    return smallest(case, 1, 2, np.array([1.003]))


def test_beyond_a_narrow_band_the_smallest_knock_that_is_confirmed_is_told():
    """Two bands are 0.4 % wide, the third 3 %; beyond 1.2 times the first none is looked for."""
    found = bands(1.0005, 1.0045, 1.0545, 1.0585, 1.1, 1.13)
    assert (found.high, found.safe) == pytest.approx((1.0005, 1.0005), rel=1e-3)
    assert (found.ends[BELOW], found.ends[AT], found.ends[ABOVE]) == (0, 1, 0)
    assert found.confirmed == pytest.approx(1.1, rel=1e-4)
    assert found.share == pytest.approx(0.038 / 0.2, abs=0.04)
    assert math.isnan(bands(1.0005, 1.0045, 1.25, 1.5).confirmed)
    wide = bands(1.0005, 1.5)
    assert wide.confirmed == wide.high
    assert math.isnan(wide.share)


def test_a_motion_with_a_period_is_known_by_its_states_of_one_period():
    base = assemble(WELLS, None, section_of(WELLS))
    motions = Motions(base, Observation(60, 16, 0, 1e-3, 1e-9))
    assert motions.sort([base]).tolist() == [0]
    (motion,) = motions.known
    assert motion.period == len(motion.states) == len(motion.points) == 1
    assert motion.states[0] == pytest.approx(jp.periodic_orbit(WELLS)["orbit_state"].values, abs=1e-6)
    labels, motions.turns = np.full(1, -1), np.full(1, -1)
    motions._sort({0: replace(base, state=motion.states[0])}, labels, FromAfar([motion], 1e-3))
    assert (labels[0], motions.turns[0] > 0) == (0, True)  # in the transient, whatever is seen from afar


def test_there_is_no_return_to_what_has_no_period_nor_from_a_knock_that_cannot_be():
    case = told(lambda place, size: 0, False)
    case.motions.known = [Lasting(0, np.zeros((4, 2)), np.zeros((4, 2)))]
    assert case.start(Place(0, 0.0, 0.0), 0.1) is not None
    assert returned(case, Place(0, 0.0, 0.0), 0.1) == -1
    pair, wall = catalog.impact_pair(3.6, 0.8), Place(0, 0.0, 0.0)
    base = assemble(pair, None, "phase")
    motions = Motions(
        base, Observation(0, 8, 0, 1e-3, 1e-7), [Lasting(1, base.state[None], base.state[None])]
    )
    (up,) = [each for each in knocks(base, pair) if each.name == "state:y"]
    assert returned(Knocked(motions, 0, base.state[None], None, up), wall, 10.0) == -1


@pytest.mark.nightly
def test_both_wells_are_left_by_mirrored_knocks_as_their_symmetry_says(wells):
    """(y, v) at a phase and (-y, -v) half a period later mirror each other."""
    assert wells["period"].values.tolist() == [1, 1]
    size = wells["knock_size"].values
    assert size[0] == pytest.approx(size[1], rel=2e-3)
    assert wells["knock_confirmed"].values.tolist() == [[1, 1], [1, 1]]
    assert wells["above_reaches"].values.tolist() == [[2, 2], [1, 1]]
    assert (wells["knock_point"] == 0).all()  # of one a turn
    turned = np.diff(wells["knock_phase"].values, axis=0)[0]
    assert np.cos(turned) == pytest.approx(-1.0, abs=1e-6)
    assert (np.diff(wells["return_turns"].values, axis=-1) >= 0).all()
    assert (wells["fraction_reached"].values[:, -1] == wells["fraction"].values).all()


@pytest.mark.nightly
def test_the_edge_state_is_the_saddle_orbit_between_the_wells(wells):
    """The orbit that periodic_orbit finds by itself; the product of its multipliers is known."""
    saddle = jp.periodic_orbit(WELLS, initial=[-0.02, 0.0], transient=0)
    exact = saddle["orbit_state"].values
    assert (wells["edge_period"] == 1).all()
    assert np.abs(wells["edge_state"].values - exact).max() < 1e-8
    assert wells["edge_multiplier"].values[..., 0] == pytest.approx(
        np.broadcast_to(saddle["floquet_multiplier"].values[:, 0], (2, 2, 2)), rel=1e-8
    )
    product = wells["edge_multiplier"].values[..., 0].prod(axis=-1)
    assert product == pytest.approx(math.exp(-DAMPING * math.tau), rel=1e-8)


@pytest.mark.nightly
def test_the_edge_state_of_what_nothing_forces_is_its_saddle():
    """x'' + c x' = x - x^3: at 0 the exponents are -c/2 + sqrt(1 + c^2/4) and the same with -."""
    rates = {"x": "v", "v": "x - x**3 - c*v"}
    hills = jp.System(states={"x": 0.5, "v": 0.0}, parameters={"c": 0.4}, rates=rates)
    region = {"x": (-1.5, 1.5), "v": (-0.5, 0.5)}
    found = jp.tipping(hills, region=region, starts=16, largest=2.0, transient=60, turns=16, n_jobs=1)
    assert found["period"].values.tolist() == [1, 1]
    assert (found["knock_confirmed"] == 1).all()
    assert (found["edge_period"] == 1).all()
    assert np.abs(found["edge_state"].values).max() < 1e-8
    exponents = -0.2 + np.array([1.0, -1.0]) * math.sqrt(1.04)
    assert found["edge_multiplier"].values[..., 0] == pytest.approx(
        np.broadcast_to(np.exp(exponents), (2, 2, 2)), rel=1e-8
    )


@pytest.mark.nightly
def test_the_edge_state_of_what_nothing_forces_may_be_a_cycle_of_its_own_period():
    """r' = -r (1 - r^2) (1 - r^2/4), phi' = w: rest at 0 and a cycle at 2, between them the cycle at 1."""
    w, g = 5.0, "(1 - x**2 - y**2)*(1 - (x**2 + y**2)/4)"
    rates = {"x": f"-x*{g} - w*y", "y": f"-y*{g} + w*x"}
    hopf = jp.System(states={"x": 0.5, "y": 0.0}, parameters={"w": w}, rates=rates)
    region = {"x": (-2.5, 2.5), "y": (-2.5, 2.5)}
    found = jp.tipping(hopf, region=region, starts=16, largest=4.0, transient=60, turns=16, n_jobs=1)
    assert found["period"].values.tolist() == [1, 0]
    assert found["knock_size"].values[0] == pytest.approx(1.0, rel=1e-3)
    tips = np.isfinite(found["knock_size"].values)  # outside, a line along x or y may miss the cycle
    assert tips[0].all()
    assert tips[1].any()
    assert ((found["edge_period"].values == 1) == tips).all()
    assert np.hypot(*found["edge_state"].values[tips].T) == pytest.approx(1.0, abs=1e-8)
    assert found["edge_period_time"].values[tips] == pytest.approx(math.tau / w, rel=1e-8)
    multiplier = found["edge_multiplier"].sel(part="real").values[tips]  # exp(f'(1) T), f'(1) = 3/2
    assert multiplier == pytest.approx(math.exp(1.5 * math.tau / w), rel=1e-7)


def test_one_motion_alone_has_no_other_to_go_to():
    region = {"y": (-1.0, 1.0), "v": (-1.0, 1.0)}
    found = jp.tipping(
        catalog.impact_pair(3.0, 0.8), region=region, starts=3, turns=16, transient=60, n_jobs=1
    )
    assert found.sizes["number"] == 1
    assert np.isnan(found["knock_size"].values).all()
    assert int(found["status"]) == 0


def test_what_is_wrong_is_said_by_its_key():
    with pytest.raises(InputError) as caught:
        jp.tipping(WELLS, region={"x": (0, 1)}, largest=-1.0, directions=1)
    assert {each.key for each in caught.value.problems} == {"region.x", "largest", "directions"}


@pytest.mark.nightly
def test_the_edge_of_the_impact_pair_is_the_other_branch_of_its_period_3():
    """The saddle that meets the motion of period 3 at its fold; six impacts, each r^2 in the product."""
    pair, region = catalog.impact_pair(3.8, 0.8), {"y": (-1.6, 1.6), "v": (-3.0, 3.0)}
    found = jp.tipping(pair, region=region, starts=40, largest=2.0, phases=4)
    assert found["period"].values.tolist() == [1, 3]
    assert (found["edge_period"] == 3).all()
    assert found["edge_multiplier"].values[..., 0].prod(axis=-1) == pytest.approx(0.8**12, rel=1e-9)
    state = found["edge_state"].values[0, 0]
    orbit = jp.periodic_orbit(pair, period=3, initial=state, transient=0)
    assert np.abs(orbit["orbit_state"].values - state).max() < 1e-8
    assert (found["edge_multiplier"].values[..., 0, 0] > 1).all()
