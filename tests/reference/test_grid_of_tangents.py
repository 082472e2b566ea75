"""Tangents against twins, for every kind of event: flow and parameters, by itself and in lanes.

Each scene certainly meets its event. The derivative of the flow, and that by a parameter, are compared with
central differences of the motion itself at three steps, extrapolated by Richardson, whose last two columns'
distance is their error. In lanes the motion's differences are compared with the same tangents; what lanes
carry beside a motion, one tangent of a linkage, with the area that it spans with the motion's own direction.
What has no derivative, or does not go in lanes, says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.analysis.exponents.frame_growth import Stretch, frame, grown_together
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.tangents import Bundle
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops import ideal
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.eligibility import ROUTES, exclusion
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, follow
from tests.support import driven
from tests.support.driven_scenes import CORNER, FORCED, JUMP, LAMP, RESTING, RUBBED, own, pinned, written
from tests.support.tangent_map import tangent_map

STEPS = (1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of a scale, or of a parameter
BOUND, BOUND_IN_LANES, RTOL = 1e-6, 3e-5, 1e-13
LEAST = 1e-3  # length of a tangent in the scales, as a change begins with 1, below which errors count whole
LANES = 1e-8  # the sharpest tolerance that goes in lanes
SURE = 5.0  # differences whose own error is a fifth of the bound, or less, are compared
TORQUE = {"kind": "torque", "link": "crank", "constant": 0.5, "nominal_speed": 100.0}
HELD = {  # lands on a floor at once, and goes on along it against a wall that both masses feel
    **RESTING,
    "states": {"y": 0.06, "x": 0.0, "v": 0.0, "u": 0.8},
    "parameters": RESTING["parameters"] | {"weight": 5.0, "floor": 0.05, "wall": 0.2},
    "impacts": [
        {"name": "floor", "gap": "y - floor", "restitution": "0*r"},
        {"name": "side", "gap": "wall - x", "restitution": "r"},
    ],
}
RELAY = {  # pushed with a force that depends on the time to a line, along which it slides
    **FORCED,
    "states": {"x": 1.0, "v": 0.0},
    "parameters": {"w": 3.0, "line": 1.5, "force": 2.0, "load": 0.7},
    "rates": {"x": "v", "v": "load*cos(w*t) + force*(1 - 2*above)"},
    "switches": [{"name": "above", "on": "line*x + v", "slides": True}],
}
DRUM = {  # loses its grip where the driving force exceeds what static friction holds
    **RUBBED,
    "parameters": RUBBED["parameters"] | {"f": 0.9, "g": 1.0},
}


@dataclass(frozen=True)
class Scene:
    """A motion that meets an event.

    Parameters
    ----------
    make : callable
        The mechanism or system.
    start : Any
        As `initial`.
    duration : float
        Time that is followed, s.
    key : str
        The parameter.
    events : set of str
        Kinds that are met, among others.
    jumps : bool
        Whether tangents jump there.
    lanes : str
        What keeps it from lanes; empty: nothing does.
    leaves : bool
        Whether it leaves them on the way.
    """

    make: Callable[[], Any]
    start: Any
    duration: float
    key: str
    events: set[str]
    jumps: bool = True
    lanes: str = ""
    leaves: bool = False

    @property
    def model(self):
        """Assembled at its start."""
        return assemble(self.make(), self.start)


SOFT = partial(catalog.soft_impact_pair, 0.5, 50.0, 2.0)
RUB = partial(catalog.chunmei2002, clearance=2.9e-4, gear_ratio=3.0)
SCENES = {
    "contact begins": Scene(SOFT, (0.1, 0.3), 0.7, "gap", {"contact"}),
    "contact ends": Scene(SOFT, (0.1, 0.3), 4.0, "damping", {"contact", "separation"}),
    "force ends before the gap": Scene(
        *(partial(catalog.soft_impact_pair, 0.5, 50.0, 2.0, tension=False), (0.1, 0.3), 4.0, "stiffness"),
        {"contact", "separation", "reopening"},
    ),
    "stick begins and ends": Scene(lambda: own(**DRUM), None, 9.0, "f", {"stick_onset", "slip_onset"}),
    "slip reversal": Scene(lambda: own(**RUBBED), None, 8.0, "f", {"slip_reversal"}),
    "impact": Scene(partial(catalog.impact_pair, 0.5, 0.8), (0.1, 0.3), 4.0, "restitution", {"impact"}),
    "impact while another wall holds": Scene(lambda: own(**HELD), None, 2.0, "wall", {"impact"}, leaves=True),
    "rest begins": Scene(lambda: own(**RESTING), None, 5.0, "k", {"impact", "rest"}, leaves=True),
    "rest begins at once": Scene(
        lambda: own(**RESTING).replace(r=0.0), None, 5.0, "k", {"impact", "rest"}, leaves=True
    ),
    "rest ends": Scene(
        *(partial(catalog.bouncing_ball, 1.5, 0.0), (1.5, 0.0), 9.0, "acceleration"),
        {"rest", "separation"},
        jumps=False,  # of the start nothing is left
        leaves=True,
    ),
    "jump of the state": Scene(lambda: own(**JUMP), None, 4.0, "gain", {"impact"}),
    "line across which the rate jumps": Scene(lambda: own(**CORNER), None, 5.0, "more", {"contact"}),
    "switch": Scene(lambda: own(**LAMP), None, 6.0, "draw", {"impact"}),
    "mode": Scene(partial(written, "buck_discontinuous"), None, 5.7e-5, "load", {"impact"}),
    "sliding": Scene(lambda: own(**RELAY), None, 1.5, "load", {"stick_onset"}, lanes="sliding_switch"),
    "linkage rubs": Scene(
        *(partial(RUB, friction=0.3), None, 0.02, "friction"),
        {"contact", "separation", "stick_onset", "slip_onset"},
    ),
    "linkage touches": Scene(
        partial(RUB, tension=False), None, 0.01, "clearance", {"contact", "separation", "reopening"}
    ),
    "corners of a guide": Scene(
        lambda: catalog.slider_crank(clearance={"G": 6e-5}, gravity=9.81).replace(drive=TORQUE),
        *(None, 0.02, "joints.G.clearance", {"contact", "separation"}),
    ),
    "rigid bearing": Scene(
        partial(pinned, 0.8), None, 0.15, "links.coupler.mass", {"impact", "rest"}, lanes="rigid_impacts"
    ),
    "rough rigid bearing": Scene(
        *(partial(pinned, 0.0, 0.3), None, 0.1, "joints.B.friction.coefficient"),
        {"impact", "rest", "slip_onset"},
        lanes="rigid_impacts",
    ),
    "two rigid bearings": Scene(
        *(partial(pinned, 0.5, 0.0, 30.0, {"B": 1e-4, "C": 2e-4}), None, 0.02, "gravity"),
        {"impact"},
        lanes="rigid_impacts",
    ),
}
DEAREST = ("corners of a guide", "linkage touches", "linkage rubs", "rigid bearing", "rough rigid bearing")
DEAREST += ("two rigid bearings",)
QUICK = ("stick begins and ends", "impact while another wall holds", "sliding")


def marked(names, quick=QUICK):
    """Names of scenes as cases, all but the quick ones long, the dearest nightly."""
    marks = lambda name: pytest.mark.nightly if name in DEAREST else pytest.mark.long  # noqa: E731
    return [name if name in quick else pytest.param(name, marks=marks(name)) for name in names]


def reached(model, duration: float) -> tuple[np.ndarray, list]:
    """State at the end, in units of the scales; status, way and events."""
    request = Request(duration, RTOL, at=np.array([duration]), events=True, log_from=0.0)
    records = follow(model, request)
    state = records.end[1 : 1 + len(model.state)] / tangents.scales(model)
    return state, [records.status, records.route, *(tuple(row[:2].astype(int)) for row in records.events)]


def together(models: Callable, duration: float) -> Callable:
    """Images of the models at some places."""

    def image(places):
        ends, events = zip(*(reached(models(at), duration) for at in places), strict=True)
        return np.array(ends), events

    return image


def extrapolated(image: Callable, steps) -> tuple[np.ndarray, float]:
    """Derivative of `image` at 0 and its error, of the best of several steps at which all events are alike.

    `image` gives of some places what is there, a vector each, and the events on the way.
    """
    best = np.nan, math.inf
    for step in steps:
        places = np.array([1.0, -1.0, 0.5, -0.5, 0.25, -0.25]) * step
        ends, events = image(places)
        met = [sorted(each[2:]) for each in events]  # corners that touch together exchange their order
        if any(each[0] for each in events) or any(each != met[0] for each in met):
            continue
        wide, half, narrow = (np.subtract(*ends[i : i + 2]) / (2 * places[i]) for i in (0, 2, 4))
        first, second = (4 * half - wide) / 3, (4 * narrow - half) / 3
        found = (16 * second - first) / 15
        best = min(best, (found, apart(found, second)), key=lambda each: each[1])
    return best


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Their distance over the length of the other."""
    return float(np.linalg.norm(one - other) / max(np.linalg.norm(other), LEAST))


def directions(model) -> np.ndarray:
    """Changes of the start that are compared, in its scales: two at random, none of what only jumps."""
    free = np.isin(range(len(model.state)), _free(model))
    return np.random.default_rng(5).normal(size=(2, len(model.state))) * free * tangents.scales(model)


def _free(model) -> list[int]:
    from jointplay.analysis.starts import free_states, state_names

    return [state_names(model).index(name) for name in free_states(model)]


def of_start(model, along: np.ndarray) -> Callable:
    """Models over how far the start is moved along a direction."""
    return lambda at: replace(model, state=model.state + at * along)


def of_parameter(scene: Scene, value: float) -> Callable:
    """Models over the parameter's relative change."""
    return lambda at: assemble(scene.make().varied({scene.key: value * (1 + at)}), scene.start)


def in_lanes(models: Callable, duration: float) -> Callable:
    """The same, followed in lanes; how is among the events."""

    def image(places):
        made = [models(at) for at in places]
        request, scale = Request(duration, LANES, events=True, log_from=0.0), tangents.scales(made[0])
        found = follow_ensemble(made, [request] * len(made))
        ends = np.array([each.end[1 : 1 + len(scale)] for each in found]) / scale
        events = [[tuple(row[:2].astype(int)) for row in each.events] for each in found]
        return ends, [[each.status, each.route, *some] for each, some in zip(found, events, strict=True)]

    return image


def parameter_tangent(scene: Scene, value: float, scale: np.ndarray) -> np.ndarray:
    """Derivative of the end by the parameter's relative change, in units of the scales."""
    found = driven.by_tangents(scene.make(), {scene.key: value}, scene.duration, scene.start, rtol=RTOL)
    return found[0][: len(scale)] * value / scale


@pytest.mark.parametrize("name", marked(SCENES))
def test_tangents_are_those_of_twins(name):
    """Of the flow, along two directions; and by a parameter."""
    scene = SCENES[name]
    model, value = scene.model, Parameter(scene.make(), scene.key).value
    scale, compared = tangents.scales(model), 0
    status, _, *events = reached(model, scene.duration)[1]
    assert not status
    assert scene.events <= {EVENTS[kind] for _, kind in events}
    exact = tangent_map(model, scene.duration, RTOL)
    for along in directions(model):
        twin, error = extrapolated(together(of_start(model, along), scene.duration), STEPS)
        if SURE * error < BOUND:
            assert apart(exact @ along / scale, twin) < BOUND
            compared += 1
    assert compared
    twin, error = extrapolated(together(of_parameter(scene, value), scene.duration), STEPS)
    assert SURE * error < BOUND
    assert apart(parameter_tangent(scene, value, scale), twin) < BOUND


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_in_lanes_twins_have_the_same_tangents(name):
    """Of motions that differ in the start, and in the parameter; what does not go in lanes says why."""
    scene = SCENES[name]
    model, value = scene.model, Parameter(scene.make(), scene.key).value
    assert exclusion(model, Request(scene.duration, LANES)) == scene.lanes
    if scene.lanes:
        return
    scale, along = tangents.scales(model), directions(model)[0]
    exact = tangent_map(model, scene.duration, RTOL) @ along / scale
    pairs = [
        (exact, of_start(model, along)),
        (parameter_tangent(scene, value, scale), of_parameter(scene, value)),
    ]
    for tangent, models in pairs:
        image = in_lanes(models, scene.duration)
        assert {ROUTES[how] for _, how, *_ in image([0.0])[1]} == {
            "left_lanes" if scene.leaves else "in_lanes"
        }
        twin, error = extrapolated(image, STEPS)
        assert SURE * error < BOUND_IN_LANES
        assert apart(tangent, twin) < BOUND_IN_LANES


@pytest.mark.parametrize("name", marked(["impact", "linkage rubs", "corners of a guide"], ()))
def test_a_tangent_in_lanes_spans_the_area_of_twins(name):
    """With the motion's own direction; of what is forced lanes carry none, and the result says so."""
    scene = SCENES[name]
    model, section = scene.model, scene.make()
    if isinstance(section, jp.Mechanism):
        model = assemble(section, scene.start, section="angle:crank")
    (run,) = grown_together([model], [Stretch(Request(scene.duration, LANES), 1, 0.0)])
    if not isinstance(section, jp.Mechanism):
        assert ROUTES[run.route] == "exponents"
        return
    assert ROUTES[run.route] == "in_lanes"
    scale, own = tangents.scales(model), frame(2, tangents.scales(model))[1]
    rate = tangents.Bundle(model, Request(1e-12), np.zeros((0, len(scale)))).rate()
    starts = (of_start(scene.model, each) for each in (rate, own))
    ends = [extrapolated(together(each, scene.duration), STEPS)[0] for each in starts]
    grew = np.log(_area(*ends) / _area(rate / scale, own / scale))
    logs = run.rows[-1, run.logs] - run.rows[0, run.logs]
    assert logs.sum() == pytest.approx(grew, abs=1e-4)


def _area(one: np.ndarray, other: np.ndarray) -> float:
    return math.sqrt((one @ one) * (other @ other) - (one @ other) ** 2)


@pytest.mark.parametrize("name", marked([n for n, each in SCENES.items() if each.jumps]))
def test_without_their_jumps_tangents_are_not_those_of_twins(name):
    scene = SCENES[name]
    exact, without = (tangent_map(scene.model, scene.duration, 1e-11, each) for each in (True, False))
    scale = tangents.scales(scene.model)
    assert (
        max(apart(without @ along / scale, exact @ along / scale) for along in directions(scene.model)) > 1e-4
    )


TWO = {  # alike masses that meet two walls at one instant
    "states": {"x": 0.0, "y": 0.0, "v": 1.0, "w": 1.0},
    "parameters": {"k": 2.0, "j": 0.3, "r": 0.8},
    "rates": {"x": "v", "y": "w", "v": "-k*x", "w": "-k*y"},
    "mass": {"v": {"v": 1, "w": "j"}, "w": {"w": 1}},
    "impacts": [
        {"name": "one", "gap": "1/2 - x", "restitution": "r"},
        {"name": "other", "gap": "1/2 - y", "restitution": "r"},
    ],
}


def test_impacts_at_one_instant_have_no_derivative():
    """Neighbours meet the walls one after the other, and masses that are coupled part differently."""
    with pytest.warns(jp.ModelWarning, match="two contacts change at the same instant"):
        found = jp.gradient(own(**TWO), of=["end:state:x"], by=["k", "initial.v"])
    assert VERDICTS[int(found.derivative_status)] == "simultaneous_events"
    assert np.isnan(found.derivative.values).all()
    model = assemble(own(**TWO))
    with pytest.raises(ArithmeticError, match=str(STATUS.index("no_derivative"))):
        tangent_map(model, 1.0)


@pytest.mark.parametrize("vectors", [0, 1])
def test_a_run_that_carries_no_tangent_needs_no_derivative(vectors):
    """As the image of an orbit that is asked for alone; the walls are met at one instant on the way."""
    bundle = Bundle(assemble(own(**TWO)), Request(2.0, 1e-10), np.eye(4)[:vectors], held=True)
    assert bundle.advance() == (Status.NO_DERIVATIVE if vectors else Status.OK)
    if not vectors:
        end = follow(assemble(own(**TWO)), Request(2.0, 1e-10)).end[1:5]
        np.testing.assert_allclose(bundle.state, end, rtol=0, atol=1e-9)


def test_impacts_at_one_instant_are_those_of_one_trajectory_in_lanes():
    model, request = assemble(own(**TWO)), Request(2.0, LANES, events=True, log_from=0.0)
    (found,), alone = follow_ensemble([model], [request]), follow(model, request)
    assert ROUTES[found.route] == "in_lanes"
    assert sorted(found.events[:, :2].tolist()) == sorted(alone.events[:, :2].tolist())
    assert len(found.events) > 1
    assert np.allclose(found.end, alone.end, rtol=0, atol=1e-6)


@pytest.mark.long
def test_what_ends_at_a_dead_centre_has_no_derivative(monkeypatch):
    """A crank longer than its rod, let past its refusal."""
    monkeypatch.setattr(ideal, "cannot_turn", lambda *_: iter(()))
    drive = {"kind": "speed", "link": "crank", "speed": 20.0}
    mechanism = catalog.slider_crank(crank=0.2, rod=0.15, clearance=0, drive=drive)
    found = jp.gradient(mechanism, of=["end:angle:rod"], by=["speed"])
    assert STATUS[int(found.status)] == "not_converged"
    assert np.isnan(found.derivative.values).all()
