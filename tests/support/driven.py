"""Derivatives of motions in parameters: by tangents, and by central differences of fourth order.

Run as a program, it prints the errors of its scenes as JSON; with NUMBA_DISABLE_JIT=1 nothing is compiled.
"""

from __future__ import annotations

import cmath
import json
import warnings
from dataclasses import replace
from functools import partial

import numpy as np

from jointplay import catalog
from jointplay.analysis.gradients import gradient as gradients
from jointplay.analysis.gradients.gradient import gradient
from jointplay.analysis.orbits.family import map_derivative
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.starts import placed, state_names
from jointplay.analysis.tangents import Bundle, scales
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.directions import along, of_start, stacked
from jointplay.solver.mechanism.records import CrankAngle, Plane
from jointplay.solver.motion.trajectory import Request, follow
from tests.support.closed_pieces import derivatives, impacts, one_entry

RTOL = 1e-13


def models(system, key, start=None, powers=False):
    """The model over a parameter, from a fixed start where one is given."""
    return lambda value: assemble(system.varied({key: value}), start, powers=powers)


def by_tangents(system, values, duration, start=None, powers=False, rtol=1e-12, states=()):
    """Derivatives of state and works, a row a parameter, then a row each of these states' initial values."""
    bundle = bundle_along(system, values, duration, start, powers, rtol, states)
    assert bundle.advance() == 0
    return np.hstack([bundle.vectors, bundle.works])


def bundle_along(system, values, duration, start=None, powers=False, rtol=1e-12, states=()) -> Bundle:
    """A motion at its start, with tangents along parameters, then along these states' initial values."""
    model = assemble(system, start, powers=powers)
    parts = [along(models(system, key, start, powers), value, key) for key, value in values.items()]
    parts += [of_start(model, state_names(model).index(name)) for name in states]
    none = np.zeros((0, len(model.state)))
    return Bundle(model, Request(duration, rtol), none, held=True, directions=stacked(parts))


def end(model, duration):
    """State and works at the end, and the events on the way."""
    request = Request(duration, RTOL, at=np.array([duration]), events=True, log_from=0.0)
    records = follow(model, request)
    assert records.status == 0
    row, n_w = records.samples[-1], cache.structure_module(model.structure).SIZES["powers"]
    return np.append(row[1 : 1 + len(model.state)], row[len(row) - n_w :]), records.events[:, :2].tolist()


def quotient(function, value, step):
    """Central difference of fourth order of a function of one number."""
    one, less, two, least = (function(value + i * step) for i in (1, -1, 2, -2))
    return (8 * (one - less) - (two - least)) / (12 * step)


def by_differences(system, key, value, duration, share, start=None, powers=False):
    """The same by differences; None where the shifted runs have other events."""
    kinds, made = [], models(system, key, start, powers)

    def state(at):
        found, events = end(made(at), duration)
        kinds.append(events)
        return found

    found = quotient(state, value, share * abs(value))
    return found if all(each == kinds[0] for each in kinds) else None


def distance(found, expected, model):
    """Relative difference, states in units of their scales, works in that of the largest."""
    n_x = len(model.state)
    unit = np.append(scales(model), np.full(len(expected) - n_x, np.abs(expected[n_x:]).max(initial=1e-300)))
    return float(np.linalg.norm((found - expected) / unit) / np.linalg.norm(expected / unit))


SCENES = {  # system, parameters, start, duration
    "walls": (catalog.impact_pair(0.5, 0.8), ("gap", "restitution"), (0.1, 0.3), 4.0),
    "table": (catalog.bouncing_ball(1.3, 0.5), ("acceleration", "restitution"), (1.3, -1.0), 9.0),
    "soft": (catalog.soft_impact_pair(0.5, 50.0, 2.0), ("gap", "stiffness", "damping"), (0.1, 0.3), 4.0),
    "no_tension": (
        *(catalog.soft_impact_pair(0.5, 50.0, 2.0, tension=False), ("gap", "stiffness", "damping")),
        *((0.1, 0.3), 4.0),
    ),
    "backlash": (
        *(catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), ("mean_load", "amplitude", "frequency", "damping")),
        *((0.5, 0.1), 6.0),
    ),
}
MAPS = {  # system, section, parameters, state
    "phase": (
        *(catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), CrankAngle(angle=1.0), ("mean_load", "frequency")),
        (0.5, 0.1),
    ),
    "plane": (
        *(catalog.rossler(), Plane(quantity="y", value=0.0, direction="up"), ("a", "b", "c")),
        (-5.0, 0.0, 0.02),
    ),
}


def scene(name):
    """Largest error of a scene, and how many events it has."""
    system, keys, start, duration = SCENES[name]
    model, values = assemble(system, start), {key: system.parameters[key] for key in keys}
    exact = by_tangents(system, values, duration, start)
    pairs = [(key, by_differences(system, key, values[key], duration, 1e-4, start)) for key in keys]
    errors = [distance(row, expected, model) for row, (_, expected) in zip(exact, pairs, strict=True)]
    return max(errors), len(end(model, duration)[1])


def mapped(name):
    """Largest error of the derivatives of a section map's image and duration."""
    system, section, keys, state = MAPS[name]
    state, errors = np.array(state), []

    def maps(key):
        return lambda value: section_map(
            placed(system.varied({key: value}), None, section), section, 1, 1e-12
        )

    for key in keys:
        made, value = maps(key), system.parameters[key]
        found = map_derivative(made, value, state, key=key)
        own = made(value)

        def image(at, made=made, own=own):
            reached = replace(made(at), units=own.scale).image(state, False)
            return np.append(own.unknowns(reached.state), reached.time)

        expected = quotient(image, value, 1e-4 * abs(value))
        got = np.append(found.along[:, 0], found.times)
        errors.append(float(np.max(np.abs(got - expected)) / np.max(np.abs(expected))))
    return max(errors)


def bounces(until):
    """State of the ball after its first bounce, over acceleration, restitution, start (y, v).

    y + v t - t^2 / (2 Gamma) meets sin t; after the bounce the ball's speed is -a v + (1 + a) cos t.
    """

    def state(acceleration, restitution, y, v):
        g, t = 1 / acceleration, 1.0 + 0j
        for _ in range(60):
            t -= (y + v * t - g * t * t / 2 - cmath.sin(t)) / (v - g * t - cmath.cos(t))
        v, left = -restitution * (v - g * t) + (1 + restitution) * cmath.cos(t), until - t
        return np.array([cmath.sin(t) + v * left - g * left**2 / 2, v - g * left])

    return state


EXACT = {  # system, its state by its numbers and its start, numbers, start, time, which has so many events
    "ball": (catalog.bouncing_ball(1.3, 0.5), bounces, ("acceleration", "restitution"), (1.3, -1.0), 2.0, 1),
    "pair": (catalog.impact_pair(0.5, 0.8), impacts, ("gap", "restitution"), (0.1, 0.3), 4.0, 4),
    "two_phases": (
        *(catalog.soft_impact_pair(0.5, 50.0, 2.0), one_entry, ("gap", "stiffness", "damping")),
        *((0.1, 0.3), 0.6, 1),
    ),
}


def exact(name):
    """Largest error against a closed form's derivatives, relative to the largest of each row."""
    system, closed, keys, start, duration, events = EXACT[name]
    values = {key: system.parameters[key] for key in keys}
    assert len(end(assemble(system, start), duration)[1]) == events
    found = by_tangents(system, values, duration, start, rtol=1e-13, states=("y", "v"))
    expected = derivatives(closed(duration), *values.values(), *start)
    return float(np.max(np.abs(found - expected) / np.max(np.abs(expected), axis=1, keepdims=True)))


ASKED = {  # system, quantities, parameters, start
    "largest": (
        *(catalog.impact_pair(0.5, 0.8), ("largest:state:v", "smallest:state:v", "end:state:y")),
        *(("gap", "restitution"), (0.1, 0.3)),
    ),
    "within": (
        *(catalog.soft_impact_pair(0.5, 50.0, 2.0), ("largest:state:y", "smallest:state:v")),
        *(("gap", "damping"), (0.1, 0.3)),
    ),
    "time": (
        *(catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), ("time", "end:state:v")),
        *(("frequency",), (0.5, 0.1)),
    ),
}


def asked(name):
    """Largest relative error of what `gradient` gives, against differences of its values."""
    system, of, by, start = ASKED[name]
    given, errors = {"of": of, "initial": list(start), "turns": 1}, []
    found = gradient(system, by=by, rtol=1e-11, **given)

    def values(key, at):
        return gradient(system.varied({key: at}), by=by[:1], rtol=1e-12, **given)["value"].values

    for j, key in enumerate(by):
        expected = quotient(partial(values, key), system.parameters[key], 1e-4 * system.parameters[key])
        errors.append(np.abs(found["derivative"].values[:, j] - expected).max() / np.abs(expected).max())
    return float(max(errors)), int(found["derivative_status"]), float(found["error"].max())


def touching():
    """Verdicts on a motion that turns back 1e-9 before a wall, and on one that does so well before it."""
    system, verdicts = catalog.soft_impact_pair(0.5, 50.0, 2.0), []
    wide = system.varied({"gap": 100.0})
    free = gradient(wide, of=("largest:state:y",), by=("gap",), initial=[0.0, -1.0], rtol=1e-12)
    reach = float(free["value"][0])
    for gap in (2 * reach + 2e-9, 2 * reach + 0.1):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            near = gradient(system.varied({"gap": gap}), by=("gap",), initial=[0.0, -1.0], rtol=1e-12)
        verdicts.append(int(near["derivative_status"]))
    return verdicts


if __name__ == "__main__":
    gradients.SAMPLES = 256  # plain Python is slow
    found = {name: scene(name) for name in SCENES} | {name: mapped(name) for name in MAPS}
    found |= {name: exact(name) for name in EXACT} | {name: asked(name) for name in ASKED}
    print(json.dumps(found | {"touching": touching()}))
