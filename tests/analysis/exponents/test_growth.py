"""Growth of a small difference, against published exponents and multipliers found otherwise."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.exponents.growth import ALIGN, BATCHES, Turn, growth, standard_error
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import quantity
from jointplay.display.errors import InputError
from jointplay.display.number_text import plain
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import CrankAngle
from tests.analysis.exact_maps import TAU, Walls

GEAR = {"mean_load": 0.1, "amplitude": 0.2, "damping": 0.05}
# system, its period, published largest exponent and its error (0: an exact event map's, known far better)
CHAOTIC = {
    "impact pair 0.4": (catalog.impact_pair(0.4, 0.8), TAU, 0.23792, 1.2e-4),
    "impact pair 0.6": (catalog.impact_pair(0.6, 0.6), TAU, 0.11341, 6e-5),
    "duffing": (catalog.duffing(), TAU, 0.1589, 1e-4),
    "gear pair": (catalog.gear_backlash(frequency=1.6, **GEAR), TAU / 1.6, 0.110, 1e-3),
}
PERIODIC = {
    "impact pair 0.6": (catalog.impact_pair(0.6, 0.8), -0.02902),
    "impact pair 1.4": (catalog.impact_pair(1.4, 0.8), -0.01137),
    "symmetric motion": (catalog.impact_pair(3.6, 0.8).replace(initial=(0.0, 0.5)), math.log(0.8) / math.pi),
}


def agrees(system, period, exponent, error, **options):
    found = growth(system, **options)
    own = float(found.growth_standard_error)
    assert STATUS[int(found.status)] == "ok"
    assert own < 0.07
    assert float(found.growth) == pytest.approx(exponent * period, abs=3 * math.hypot(own, error * period))
    assert float(found.growth) > 3 * own
    assert float(found.growth_rate) == pytest.approx(float(found.growth) / period, rel=1e-9)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CHAOTIC)
def test_chaotic_motions(name):
    agrees(*CHAOTIC[name], turns=500, transient=100)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CHAOTIC)
def test_chaotic_motions_to_a_percent(name):
    agrees(*CHAOTIC[name], turns=20_000, transient=100)


@pytest.mark.nightly
@pytest.mark.parametrize("name", PERIODIC)
def test_periodic_motions(name):
    """Neighbours approach a limit: what is left is the first and the last length over the number of turns."""
    system, exponent = PERIODIC[name]
    found = growth(system, turns=500, transient=200)
    assert float(found.growth) == pytest.approx(exponent * TAU, abs=3e-3)
    assert float(found.growth) < -3 * float(found.growth_standard_error)


@pytest.mark.long
@pytest.mark.parametrize(("frequency", "turns"), [(0.8, 2), (1.0, 4)])
def test_multiplier_of_a_periodic_motion_of_the_gear_pair(frequency, turns):
    """Against differences of the exact motion, linear between the edges of the backlash."""
    period, system = TAU / frequency, catalog.gear_backlash(frequency=frequency, **GEAR)
    walls = Walls(1.0, 1.0, 0.0, W=frequency, cos=0.2 * frequency**2, mean=0.1, drag=0.1)

    def after(state, count):
        return walls.run(*state, count * period + 1e-9, at=[count * period], step=0.1)[1][-1]

    h, turn = 1e-5, Turn(assemble(system, None, quantity(CrankAngle(), system)))
    place = turn(turn.model.state, 1000)[0]
    assert after(place, turns) == pytest.approx(place, abs=1e-8)
    columns = [(after(place + d, turns) - after(place - d, turns)) / (2 * h) for d in h * np.eye(2)]
    largest = math.log(np.abs(np.linalg.eigvals(np.transpose(columns))).max()) / turns
    found = growth(system, turns=400, transient=400)
    assert float(found.growth) == pytest.approx(largest, abs=3e-3)


def linkage(initial=None, **changes):
    mechanism = catalog.chunmei2002(**{"clearance": 2.9e-5, "gear_ratio": 3.0} | changes)
    return mechanism, Turn(assemble(mechanism, initial, quantity(CrankAngle(), mechanism)))


def multiplier(turn, state):
    """Largest multiplier of the section's map, by central differences of all states but the crank's angle."""
    free = [i for i in range(len(state)) if i != turn.crank]
    steps = 1e-7 * np.diag(turn.scale)
    rows = [(turn(state + steps[i])[0] - turn(state - steps[i])[0])[free] / 2e-7 for i in free]
    table = np.transpose(rows) / turn.scale[free][:, None]
    return float(np.abs(np.linalg.eigvals(table)).max())


def test_a_periodic_motion_of_the_linkage():
    mechanism, turn = linkage()
    state, _, _ = turn(turn.model.state, 30)
    found = growth(mechanism, turns=60, transient=30)
    assert float(found.growth) == pytest.approx(math.log(multiplier(turn, state)), abs=1e-3)
    assert float(found.growth) < -1


def test_events_are_kept_where_they_are_asked_for():
    system = catalog.impact_pair(0.6, 0.8)
    turn = Turn(assemble(system, None, quantity(CrankAngle(), system)))
    one, other = (turn.records(turn.model.state, 3, **how) for how in ({}, {"events": True}))
    assert (one.status, other.status) == (0, 0)
    assert len(one.events) == 0 < len(other.events)


@pytest.mark.long
def test_a_prescribed_speed_has_no_crank_in_its_state():
    mechanism, turn = linkage(gear_ratio=15.0)
    mechanism = mechanism.replace(speed=80.0)
    held = Turn(assemble(mechanism, None, quantity(CrankAngle(), mechanism)))
    assert (turn.crank, held.crank) == (0, None)
    state, _, _ = held(held.model.state, 40)
    found = growth(mechanism, turns=60, transient=40)
    assert float(found.growth) == pytest.approx(math.log(multiplier(held, state)), abs=0.05)


def test_a_turn_ends_where_it_began():
    """The section is the angle of the start, and a turn of the map is a turn of the crank."""
    _, turn = linkage({"crank_angle": 1.0})
    one, first, _ = turn(turn.model.state)
    two, second, _ = turn(one)
    both, time, status = turn(turn.model.state, 2)
    assert (one[0], two[0], status) == (1.0, 1.0, 0)
    assert both == pytest.approx(two, abs=1e-8)
    assert time == pytest.approx(first + second, rel=1e-12)


@pytest.mark.long
def test_a_backward_crank():
    mechanism, _ = linkage()
    found = growth(mechanism.replace(speed=-80.0), turns=40, transient=20)
    assert STATUS[int(found.status)] == "ok"


@pytest.mark.nightly
def test_the_distance_does_not_matter():
    mechanism, _ = linkage()
    values = [float(growth(mechanism, turns=40, transient=30, distance=d).growth) for d in (1e-6, 1e-7, 1e-8)]
    assert values == pytest.approx([values[1]] * 3, abs=1e-3)


def test_one_run_is_like_the_next():
    first, again = (growth(catalog.duffing(), turns=20, transient=0) for _ in range(2))
    assert first.growth_of_turn.values.tolist() == again.growth_of_turn.values.tolist()


def test_progress_is_the_share_of_turns_that_are_done():
    told, turns = [], ALIGN + 5
    growth(catalog.duffing(), turns=5, transient=0, progress=told.append)
    assert sorted({*told} - {0.0}) == [(done + 1) / turns for done in range(turns)]


@pytest.mark.parametrize("transient", [0, 5])
def test_trouble_is_a_status(transient):
    mechanism, _ = linkage()
    found = growth(mechanism, turns=10, transient=transient, max_steps=20)
    assert STATUS[int(found.status)] == "step_limit"
    assert math.isnan(found.growth)
    assert found.sizes["turn"] == 0


def test_a_system_that_nothing_forces_is_refused():
    with pytest.raises(InputError, match="forces"):
        growth(catalog.lorenz())


@pytest.mark.parametrize(
    ("options", "key"), [({"turns": 0}, "turns"), ({"distance": 0.0}, "distance"), ({"rtol": 1.0}, "rtol")]
)
def test_wrong_input(options, key):
    with pytest.raises(InputError, match=key):
        growth(catalog.duffing(), **options)


def test_standard_error_of_independent_values():
    values = np.random.default_rng(3).standard_normal((200, 1000))
    errors = [standard_error(row) for row in values]
    assert np.mean(errors) == pytest.approx(1000**-0.5, rel=0.05)
    assert np.mean(np.abs(values.mean(axis=1)) < 3 * np.array(errors)) > 0.97


def test_standard_error_of_correlated_values():
    """Blocks of equal values: as many independent ones as there are blocks."""
    blocks = np.random.default_rng(4).standard_normal((200, 100))
    errors = [standard_error(np.repeat(row, 10)) for row in blocks]
    assert np.mean(errors) == pytest.approx(100**-0.5, rel=0.1)


def test_standard_error_of_too_few_values():
    assert math.isnan(standard_error(np.zeros(2 * BATCHES - 1)))
    assert standard_error(np.ones(2 * BATCHES)) == 0.0


def test_the_answer_is_the_mean_growth():
    found = jp.growth(catalog.duffing(), turns=60)
    told = f"mean ln of the growth of a small difference in a turn: {plain(float(found.growth))}"
    assert str(jp.summary(found)) == told
