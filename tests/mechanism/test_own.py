"""Systems of somebody's own equations: what is refused, all of it at once, with its place and reason."""

from __future__ import annotations

import itertools
import json
import math
import pickle
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from sympy import cos, symbols

import jointplay as jp
from jointplay.analysis.coexisting.knocks import knocks
from jointplay.analysis.exponents.growth import DISTANCE, measure
from jointplay.analysis.vary import axes
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import System
from jointplay.study.models import build_mechanism
from tests.support.wrong import only, problems_of

VALVE = {
    "name": "valve",
    "states": {"x": 0.2, "p": 10, "v": "release"},
    "parameters": {"kappa": 1.25, "flow": 5.0, "restitution": 0.8, "release": 0.5},
    "rates": {"x": "v", "v": "-kappa*v - (x + 10) + p", "p": "20*(flow - x*sqrt(p))"},
    "impacts": [{"name": "seat", "gap": "x", "restitution": "restitution"}],
}
FORCED = {
    "states": {"y": 1, "v": 0},
    "parameters": {"omega": 2.0},
    "rates": {"y": "v", "v": "cos(omega*t) - y"},
    "forcing": "2*pi/omega",
}
STOP = {"name": "stop", "depth": "x - 1", "force": "100*depth"}
KICK = {"name": "kick", "guard": "cos(2*pi*t)", "jump": {"v": "v + 1"}}


def test_order_start_and_period():
    valve = System(**VALVE)
    assert valve.order == (("x",), ("v", "p"))
    assert valve.initial == (0.2, 0.5, 10.0)
    assert valve.replace(release=0.7).initial == (0.2, 0.7, 10.0)
    assert valve.replace(initial=[1, 2, 3]).initial == (1, 2, 3)
    assert valve.period is None
    assert System(**FORCED).replace(omega=4).period == math.pi / 2
    assert "flow = 5" in valve.summary()
    assert pickle.loads(pickle.dumps(valve)) == valve == System(**json.loads(valve.model_dump_json()))
    assert hash(valve) == hash(System(**VALVE)) != hash(valve.replace(flow=6))


def test_expressions_of_sympy():
    y, omega, t = symbols("y omega t")
    found = System(**FORCED | {"rates": {"y": "v", "v": cos(omega * t) - y}})
    assert found.rates["v"] == "cos(omega*t) - y" or found.rates["v"] == "-y + cos(omega*t)"


def test_values_with_units():
    valve = System(
        **VALVE | {"parameters": VALVE["parameters"] | {"kappa": "2 kN s/m", "release": "0.3 mm/s"}}
    )
    assert valve.parameters["kappa"] == 2000
    assert valve.units == {"kappa": "kg/s", "release": "m/s"}
    assert valve.replace(release="2 mm/s").initial[1] == 0.002
    assert Parameter.named(valve, "release").units == "m/s"
    assert axes(valve, {"release": [0.1, 0.2]})[0].units == "m s-1"
    found = problems_of(System, **VALVE | {"parameters": VALVE["parameters"] | {"kappa": "2 widgets"}})
    assert "not a known unit" in only(found, "system.parameters.kappa").expected
    assert "kg does not convert to" in str(problems_of(valve.replace, release="2 kg"))


def changed(**tables):
    """The valve, with entries of its tables replaced; None takes one away."""
    data = {key: dict(value) if isinstance(value, dict) else value for key, value in VALVE.items()}
    for key, value in tables.items():
        whole = data[key] | value if isinstance(value, dict) and isinstance(data.get(key), dict) else value
        data[key] = {k: v for k, v in whole.items() if v is not None} if isinstance(whole, dict) else whole
    return data


@pytest.mark.parametrize(
    ("tables", "key", "said"),
    [
        ({"rates": {"p": None}}, "rates.p", "rate of this state is needed"),
        ({"rates": {"q": "1"}}, "rates.q", "no such state"),
        ({"rates": {"v": "-kapa*v"}}, "rates.v", "did you mean 'kappa'"),
        ({"rates": {"v": "-kappa*(v"}}, "rates.v", "column 10"),
        ({"rates": {"v": "cos(t)"}}, "forcing", "the period is needed, since rates.v depends on t"),
        ({"forcing": "2*pi"}, "forcing", "no equation depends on t"),
        ({"rates": {"v": "1/(x - 0.2)"}}, "rates.v", "at the initial state"),
        ({"states": {"v": "x"}}, "states.v", "no such name as 'x'"),
        ({"states": {"v": "log(0)"}}, "states.v", "finite real values"),
        ({"states": {"v": "5 frogs"}}, "states.v", "not a known unit"),
        ({"states": {"v": 10**400}}, "states.v", "an expression"),
        ({"states": {"sin": 0}, "rates": {"sin": "1"}}, "states.sin", "a function already"),
        ({"parameters": {"p": 1.0}}, "parameters.p", "a state already"),
        ({"parameters": {"t": 1.0}}, "parameters.t", "the time already"),
        ({"parameters": {"a b": 1.0}}, "parameters.a b", "a letter first"),
        ({"outputs": {"flow": "x"}}, "outputs.flow", "a parameter already"),
        ({"scales": {"z": 1.0}}, "scales.z", "no such state"),
        ({"scales": 5}, "scales", "a table { name = "),
        ({"scales": [{"x": 1.0}]}, "scales", "a table { name = "),
        (
            {"impacts": [{"name": "seat", "gap": "kappa", "restitution": 1}]},
            "impacts[0].gap",
            "this one does not",
        ),
        ({"impacts": [{"name": "seat", "gap": "x - p", "restitution": 1}]}, "impacts[0].gap", "not of p"),
        ({"impacts": [{"name": "seat", "gap": "x"}]}, "impacts[0]", "either restitution or jump"),
        ({"impacts": [{"name": "seat", "gap": "x", "restitution": 2}]}, "impacts[0].restitution", "0 to 1"),
        (
            {"impacts": [{"name": "seat", "gap": "x", "jump": {"x": "1"}}]},
            "impacts[0].jump.x",
            "no such a speed",
        ),
        ({"switches": [{"name": "open", "on": "kappa - 1"}]}, "switches[0].on", "this one does not"),
        ({"switches": [{"name": "open", "on": "x", "off": "1"}]}, "switches[0].off", "this one does not"),
        ({"switches": [{"name": "p", "on": "x"}]}, "switches[0].name", "a state already"),
        (
            {"contacts": [{"name": "stop", "depth": "p", "force": "depth"}]},
            "contacts[0].depth",
            "depends on a position (x) is accepted: this one does not",
        ),
        (
            {"contacts": [{"name": "seat", "depth": "x", "force": "depth"}]},
            "impacts[0].name",
            "this one is contacts[0]'s",
        ),
        (
            {"contacts": [{"name": "stop", "depth": "x", "force": "depth", "tension": "pulls"}]},
            "contacts[0].tension",
            "no such name",
        ),
        (
            {"friction": [{"name": "rub", "speed": "x", "normal": "1", "coefficient": "1"}]},
            "friction[0].speed",
            "this one does not",
        ),
        (
            {"jumps": [{"name": "j", "guard": "x - 1", "jump": {"p": "0"}}]},
            "jumps[0].jump",
            "guard is above zero",
        ),
        (
            {"jumps": [{"name": "j", "guard": "p", "jump": {"v": "0"}}]},
            "jumps[0].jump",
            "guard is above zero",
        ),
        ({"jumps": [{"name": "j", "guard": "p", "jump": {}}]}, "jumps[0].jump", "at least one state"),
        ({"jumps": [KICK], "forcing": "1"}, "jumps[0].guard", "from one of two `modes` to the other"),
        ({"mass": {"v": {"v": 1, "p": 1}}}, "mass", "positive definite"),
        ({"parameters": {"depth": 1.0}, "contacts": [STOP]}, "parameters.depth", "a contact's already"),
        ({"mass": {"x": {"x": 1}}}, "mass.x", "no such state"),
        ({"mass": {"v": {"p": 0.1}, "p": {"v": 0.1, "p": 1}}}, "mass.p.v", "one of them is accepted"),
    ],
)
def test_badly_posed(tables, key, said):
    found = problems_of(System, **changed(**tables))
    places = {place.removeprefix("system."): problem for place, problem in found.items()}
    assert key in places, places
    assert said in str(places[key].expected)
    assert "np." not in str(found)


PUMP = {  # fills, waits, and empties
    "states": {"x": 0.5, "clock": 0},
    "parameters": {"pause": 1.0},
    "rates": {"x": "fills - 2*empties", "clock": "waits"},
    "modes": {
        "fills": [{"to": "waits", "guard": "1 - x", "jump": {"clock": "0"}}],
        "waits": [{"to": "empties", "guard": "pause - clock"}],
        "empties": [{"to": "fills", "guard": "x - 0.1"}],
    },
}


def pump(**changes):
    return PUMP | {"modes": {**PUMP["modes"], **changes}}


def test_modes_are_states_of_which_one_is_1():
    found = System(**PUMP)
    assert found.order == ((), ("x", "clock", "fills", "waits", "empties"))
    assert found.initial == (0.5, 0, 1, 0, 0)
    later = found.replace(initial=[0.5, 0, 0, 0, 1])
    assert later.initial == (0.5, 0, 0, 0, 1)
    assert later == System(**json.loads(later.model_dump_json()))
    assert "one of fills, waits, empties is 1" in str(
        problems_of(found.replace, initial=[0.5, 0, 1, 0, 1]).popitem()[1].expected
    )
    with pytest.raises(jp.InputError, match="a start in one mode"):
        jp.simulate(found, duration=1.0, initial=[0.5, 0, 0.5, 0.5, 0])


def test_modes_follow_each_other():
    """Full at 0.5, then a pause of 1, empty 0.45 later, full again after 0.9."""
    found = jp.simulate(System(**PUMP), duration=4.0, rtol=1e-11)
    expected = [0.5, 1.5, 1.95, 2.85, 3.85]
    assert found.event_time.values == pytest.approx(expected, abs=1e-12)


def test_nothing_near_a_motion_has_another_mode():
    """Neighbours differ in x and the clock alone, which move evenly up to 0.5: so far they keep apart."""
    system = System(**PUMP)
    found = jp.sensitivity(system, neighbours=3, turns=4, samples_per_turn=5, distance=1e-7, compare="time")
    assert found.distance.values[..., :3] == pytest.approx(np.full((1, 3, 3), 1e-7), rel=1e-6)
    assert found.distance.values.max() < 1e-6
    assert [each.name for each in knocks(assemble(system), system)] == ["state:x", "state:clock"]
    with pytest.raises(jp.InputError, match="no such state"):
        jp.gradient(system, by=["initial.fills"])
    with pytest.raises(jp.InputError, match="no such coordinate"):
        jp.basins(system, plane={"x": [0.2, 0.8], "fills": [0, 1]})


@pytest.mark.parametrize(("shrinks", "growth"), [((0.5, 0.9), 0.9), ((0.0, 0.0), 1e-12 / DISTANCE)])
def test_a_difference_in_modes_does_not_grow(shrinks, growth):
    """Of a map that leaves a neighbour in another mode, of which the next neighbour has nothing."""

    class Turned:
        model, scale, rtol = assemble(System(**PUMP)), np.ones(5), 1e-12
        sides = itertools.cycle(([0, 1, 0], [1, 0, 0]))  # of the neighbour, of the motion

        def __call__(self, state):
            assert list(state[2:]) == [1, 0, 0]
            return np.array([*(shrinks * state[:2]), *next(self.sides)]), 1.0, 0

    logs, _, status = measure(Turned(), np.array([0.5, 0.2, 1, 0, 0]), 30)
    assert not status
    assert np.exp(logs.mean()) == pytest.approx(growth, rel=1e-4)


def test_what_moves_while_a_mode_lasts_is_no_position():
    """Else a wall would turn the mode round, as the speed of what it meets."""
    tables = PUMP | {"states": {**PUMP["states"], "worn": 0}, "rates": {**PUMP["rates"], "worn": "(waits)"}}
    assert System(**tables).order == ((), ("x", "clock", "worn", "fills", "waits", "empties"))
    wall = {"impacts": [{"name": "limit", "gap": "3 - worn", "restitution": 0}]}
    (problem,) = problems_of(System, **tables, **wall).values()
    assert "of positions alone" in problem.expected


@pytest.mark.parametrize(
    ("modes", "key", "said"),
    [
        ({"waits": []}, "modes.waits", "at least one way out"),
        ({"waits": [{"to": "emptys", "guard": "1 - clock"}]}, "modes.waits[0].to", "did you mean 'empties'"),
        ({"waits": [{"to": "waits", "guard": "1 - clock"}]}, "modes.waits[0].to", "or a jump beside it"),
        ({"waits": [{"to": "fills", "guard": "pause"}]}, "modes.waits[0].guard", "this one does not"),
        ({"waits": [{"to": "fills", "guard": "pauze - x"}]}, "modes.waits[0].guard", "did you mean 'pause'"),
        (
            {"waits": [{"to": "empties", "guard": "x", "jump": {"y": 1}}]},
            "modes.waits[0].jump.y",
            "no such state",
        ),
        (
            {"waits": [{"to": "empties", "guard": "x", "jump": {"fills": 1}}]},
            "modes.waits[0].jump.fills",
            "the way to it",
        ),
        (
            {"waits": [{"to": "waits", "guard": "x - 1", "jump": {"x": "1"}}, *PUMP["modes"]["waits"]]},
            "modes.waits[0].jump",
            "guard is above zero",
        ),
        ({"rests": [{"to": "fills", "guard": "x"}]}, "modes.rests", "to which some way leads"),
        ({"x": [{"to": "fills", "guard": "x"}]}, "modes.x", "a state already"),
        ({"pause": [{"to": "fills", "guard": "x"}]}, "parameters.pause", "a state already"),
        (
            {
                "fills": [*PUMP["modes"]["fills"], {"to": "sin", "guard": "x + 9"}],
                "sin": [{"to": "fills", "guard": "x"}],
            },
            "modes.sin",
            "a function already",
        ),
    ],
)
def test_badly_posed_modes(modes, key, said):
    places = {
        place.removeprefix("system."): each for place, each in problems_of(System, **pump(**modes)).items()
    }
    assert key in places, places
    assert said in str(places[key].expected)


RELAY = {
    "states": {"x": 1.0, "y": 0.0},
    "rates": {"x": "1 - 2*s", "y": "-y"},
    "switches": [{"name": "s", "on": "x", "slides": True}],
}


@pytest.mark.parametrize(
    ("tables", "key", "said"),
    [
        ({"rates": {"x": "1 - 2*s", "y": "s**2"}}, "rates.y", "straight in all that slides"),
        ({"rates": {"x": "-x", "y": "s"}}, "switches[0].on", "nothing could keep it at 0"),
        (
            {"switches": [{"name": "s", "on": "x", "off": "-1 - x", "slides": True}]},
            "switches[0].off",
            "beside slides",
        ),
        ({"rates": {"x": "y", "y": "-s"}}, "switches[0].on", "depends on one of y"),
        ({"jumps": [{"name": "j", "guard": "y + s", "jump": {"y": "3"}}]}, "jumps[0].guard", "no such name"),
        (
            {"friction": [{"name": "f", "speed": "y", "normal": "s", "coefficient": 1}]},
            "friction[0].normal",
            "no such name",
        ),
    ],
)
def test_badly_posed_sliding(tables, key, said):
    places = {
        place.removeprefix("system."): each for place, each in problems_of(System, **RELAY | tables).items()
    }
    assert key in places, places
    assert said in str(places[key].expected)


def test_numbers_are_looked_at_also_where_the_equations_are_known():
    valve = System(**VALVE)
    found = problems_of(valve.replace, restitution=1.5)
    assert "a restitution of 0 to 1" in str(only(found, "system.impacts[0].restitution").expected)
    found = problems_of(System(**FORCED).replace, omega=1e-320)
    assert "finite" in str(only(found, "system.forcing").expected)


def test_a_contact_pulls_unless_it_is_told_not_to():
    plain, pulling = (System(**changed(contacts=[STOP | more])) for more in ({}, {"tension": True}))
    assert plain.structure() == pulling.structure()
    assert plain.structure() != System(**changed(contacts=[STOP | {"tension": False}])).structure()


def test_the_phase_runs_with_the_forcing():
    """A step spans 0.7 rad of it at most."""
    model = assemble(System(**FORCED))
    assert (model.crank_speed, model.forward) == (2.0, 1)
    assert model.h_max == pytest.approx(0.35)
    assert assemble(System(**FORCED | {"forcing": "-2*pi/omega"})).forward == -1


def test_everything_at_once():
    found = problems_of(
        System,
        **changed(
            rates={"v": "-kapa*v", "p": "1 +"}, impacts=[{"name": "seat", "gap": "z", "restitution": "r"}]
        ),
    )
    assert set(found) == {
        f"system.{key}" for key in ("rates.v", "rates.p", "impacts[0].gap", "impacts[0].restitution")
    }


def test_rates_that_do_not_repeat():
    found = problems_of(System, **FORCED | {"rates": {"y": "v", "v": "t - y"}})
    assert "repeats after the period" in only(found, "system.rates.v").expected


def test_names_of_what_there_is():
    found = jp.InputError
    with pytest.raises(found, match="did you mean 'flow'"):
        System(**VALVE).replace(flwo=3)


def test_the_page_on_own_equations_has_the_valve_of_the_catalog():
    page = (Path(__file__).parents[2] / "docs" / "own-equations.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    ours = build_mechanism(tomllib.loads(table)["mechanism"])
    catalog = jp.catalog.relief_valve(flow=5.0)
    assert ours.structure().rates == catalog.structure().rates
    assert (ours.parameters, ours.initial) == (catalog.parameters, catalog.initial)
    one, other = (jp.simulate(each, duration=5.0, record=["state_value"]) for each in (ours, catalog))
    assert int(one.status) == 0
    np.testing.assert_array_equal(one.state_value, other.state_value)
