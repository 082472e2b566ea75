"""Tangent maps through events against central differences of the motion itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.tangents import tangent
from jointplay.solver.motion import trajectory
from tests.support.linkages import jointed
from tests.support.tangent_map import agreed, tangent_map

RTOL = 1e-13
LOOSE, RUBBING = ({"clearance": 2.9e-4, "gear_ratio": 3.0, "friction": f} for f in (0.01, 0.3))
ENTRY = {"contact", "separation"}
FAR, NEAR = (3e-6, 3e-5, 3e-4), (3e-7, 1e-6, 3e-6, 1e-5)  # sizes of the differences


def moved(model, state, duration):
    """State at the end, and the events on the way."""
    request = trajectory.Request(duration, RTOL, at=np.array([duration]), events=True, log_from=0.0)
    records = trajectory.follow(replace(model, state=state), request)
    assert records.status == 0
    kinds = [tuple(row[:2].astype(int)) for row in records.events]
    return records.samples[-1, 1 : 1 + len(state)], kinds


def differences(model, duration, size, exact):
    """Central differences of fourth order, in units of the scales; events; whether all runs had the same.

    Each start is shifted so far that the end moves by about `size`, as `exact` has it: rounding would drown
    the image of a direction that shrinks.
    """
    scale, (_, kinds), columns = tangents.scales(model), moved(model, model.state, duration), []
    same = True
    for j, shift in enumerate(size / np.maximum(np.linalg.norm(exact, axis=0), 1e-4)):
        step = np.where(np.arange(len(scale)) == j, shift * scale, 0.0)
        ends = [moved(model, model.state + i * step, duration) for i in (1, -1, 2, -2)]
        same &= all(each == kinds for _, each in ends)
        near, far = ends[0][0] - ends[1][0], ends[2][0] - ends[3][0]
        columns.append((8 * near - far) / (12 * shift) / scale)
    return np.array(columns).T, kinds, same


def scaled(model, duration, **options):
    """The tangent map in units of the scales."""
    scale = tangents.scales(model)
    return tangent_map(model, duration, RTOL, **options) * scale / scale[:, None]


def distance(one, other):
    """Largest relative difference of two maps' columns."""
    return float(np.max(np.linalg.norm(one - other, axis=0) / np.linalg.norm(other, axis=0)))


def starts(mechanism, count, seed=1):
    """Scenes that start at states of the motion (a linkage) or near rest (a test system)."""
    model, random = assemble(mechanism), np.random.default_rng(seed)
    if not model.links:
        states = random.uniform((-0.15, -1.5), (0.15, 1.5), size=(count, 2))
        return [replace(model, state=state) for state in states]
    at = np.sort(random.uniform(0.0, 8.0, count)) * model.period
    rows = trajectory.follow(model, trajectory.Request(at[-1] * 1.001, 1e-9, at=at)).samples
    return [replace(model, state=row[1 : 1 + len(model.state)]) for row in rows]


CASES = {  # system, periods, sizes, events that must be met, whether saltation matters
    "kelvin_voigt": (catalog.soft_impact_pair(0.5, 50.0, 2.0), 0.7, FAR, ENTRY, True),
    "no_tension": (
        catalog.soft_impact_pair(0.5, 50.0, 2.0, tension=False),
        *(0.7, FAR, ENTRY | {"reopening"}, True),
    ),
    "impact_pair": (catalog.impact_pair(0.5, 0.8), 0.5, FAR, {"impact"}, True),
    "gear_backlash": (catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), 2.0, FAR, ENTRY, False),
    "linkage": (catalog.chunmei2002(**LOOSE), 1.0, NEAR, ENTRY | {"slip_reversal"}, True),
    "sticking": (
        catalog.chunmei2002(**RUBBING),
        *(0.4, NEAR, {"stick_onset", "slip_onset"}, True),
    ),
    "linkage_no_tension": (
        catalog.chunmei2002(tension=False, **LOOSE),
        *(1.0, NEAR, ENTRY | {"reopening"}, True),
    ),
}


def quotients(model, duration, sizes, exact, tolerance=1e-6):
    """The best of the difference quotients, or None where they do not agree among themselves; the events.

    Where a neighbour meets other events there is no derivative; near a grazing one there is hardly any.
    """
    found = [differences(model, duration, size, exact) for size in sizes]
    return agreed(found, distance, 0.5 * tolerance), found[0][1]


def smoothed():
    """The paper's mechanism with friction that follows the sliding speed: no slip reversal is an event."""
    plain = catalog.chunmei2002(**LOOSE)
    friction = jp.Friction(law="tanh", coefficient=0.1, velocity=0.05)
    return jointed(plain, friction=friction)


@pytest.mark.nightly
def test_tangent_map_with_smoothed_friction():
    compare(smoothed(), 1.0, NEAR, ENTRY, True)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CASES)
def test_tangent_map(name):
    compare(*CASES[name])


def compare(system, periods, sizes, needed, matters):
    """Twenty starts."""
    met, compared, wrong = set(), 0, 0
    for model in starts(system, 20):
        duration = periods * model.period
        exact = scaled(model, duration)
        estimate, kinds = quotients(model, duration, sizes, exact)
        if estimate is not None:
            assert distance(exact, estimate) < 1e-6
            met |= {EVENTS[kind] for _, kind in kinds}
            compared += 1
            wrong += distance(scaled(model, duration, saltation=False), exact) > 1e-3
    assert compared >= 10
    assert needed <= met
    assert wrong >= 0.5 * compared if matters else wrong == 0


@pytest.mark.nightly
def test_elastic_coupler():
    """Many unknowns: the algebra by plan. Below 4e-6 the quotients see rounding in stiff modes."""
    mechanism, compared = catalog.chunmei2002(elastic=("coupler",), **LOOSE), 0
    for model in starts(mechanism, 4):
        duration = 0.15 * model.period
        exact = scaled(model, duration)
        estimate, kinds = quotients(model, duration, (1e-5, 2e-5, 4e-5), exact, 4e-6)
        if estimate is not None:
            assert distance(exact, estimate) < 4e-6
            compared += len(kinds) > 0
    assert compared >= 1


def test_bouncing_ball():
    """The table moves: guard and reset depend on time."""
    model = assemble(catalog.bouncing_ball(1.2, 0.5))
    exact = scaled(model, 3 * model.period)
    estimate, kinds, same = differences(model, 3 * model.period, 1e-4, exact)
    assert same
    assert len(kinds) >= 3
    assert distance(exact, estimate) < 1e-6


def test_tangents_leave_the_motion_alone():
    """Where they tolerate every step, the motion is the same to the last bit, with any number of tangents."""
    model = assemble(catalog.chunmei2002(**RUBBING))
    request = trajectory.Request(3 * model.period, 1e-8)
    work, motion, options = trajectory.memory(model, request)
    cache.method("flow").flow(trajectory.functions(model.structure), work, motion, options, None, None)
    for count in (1, 6):
        bundle = tangents.Bundle(model, request, np.eye(6)[:count])
        bundle.tangents.real[tangent.LIMIT] = np.inf
        while bundle.advance() == bundle.full:
            bundle.taken()
        assert np.array_equal(bundle.motion.s, motion.s)
        assert np.array_equal(bundle.motion.count, motion.count)


def test_a_stop_and_go_changes_no_bit():
    model, ends = assemble(catalog.chunmei2002(**LOOSE)), []
    for block in (math.inf, 0.01 * model.period):
        bundle = tangents.Bundle(model, trajectory.Request(2 * model.period), np.eye(6)[:3])
        bundle.record(block)
        while bundle.advance() == bundle.full:
            assert len(bundle.taken()) == 1
        ends.append((bundle.vectors, bundle.tangents.logs.copy()))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert np.array_equal(ends[0][1], ends[1][1])
