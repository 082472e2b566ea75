"""Many trajectories at once, each in a lane of its own: no lane's numbers depend on its neighbours'."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Event
from jointplay.solver.method.lanes import radau as r
from jointplay.solver.motion.eligibility import ROUTES
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, follow

TURNS = 1.2


def model(clearance, gear=3.0, friction=0.3):
    """The linkage whose crank's angle is watched."""
    changes = {"clearance": clearance, "gear_ratio": gear, "friction": friction}
    return assemble(catalog.chunmei2002(**changes), section="angle:crank")


def asked(model, rtol=1e-5, turns=TURNS, **fields):
    """A run with events, cut a radian from the start and each turn on."""
    cut = {"level": model.crank_angle + 1.0, "period": math.tau, "direction": 1}
    return Request(turns * model.period, rtol, events=True, **cut | {"log_from": -1.0} | fields)


def same(a, b):
    """Whether two runs are equal to the last bit."""
    names = ("samples", "events", "sections", "start")
    arrays = all(getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in names)
    return arrays and a.counts == b.counts and a.status == b.status


@pytest.fixture(scope="module")
def company():
    """Twenty trajectories that stick, slip and fly, of different lengths and tolerances."""
    rng = np.random.default_rng(3)
    scenes = [
        model(10 ** rng.uniform(-4.6, -3.5), rng.uniform(2, 15), rng.choice([0.01, 0.1, 0.3]))
        for _ in range(20)
    ]
    requests = [asked(s, 10 ** rng.uniform(-6, -4), rng.uniform(0.3, 1.5)) for s in scenes]
    return scenes, requests, follow_ensemble(scenes, requests)


def test_order_does_not_matter(company):
    scenes, requests, records = company
    order = np.random.default_rng(4).permutation(len(scenes))
    shuffled = follow_ensemble([scenes[n] for n in order], [requests[n] for n in order])
    assert all(same(records[n], other) for n, other in zip(order, shuffled, strict=True))


def test_company_does_not_matter(company):
    scenes, requests, records = company
    assert any(4.0 in each.events[:, -1] for each in records), "some stick"
    for n in range(0, 20, 3):
        assert same(follow_ensemble([scenes[n]], [requests[n]])[0], records[n])


@pytest.mark.parametrize("others", range(1, 8))
def test_lane_does_not_matter(company, others):
    scenes, requests, records = company
    found = follow_ensemble([scenes[1]] * others + [scenes[4]], [requests[1]] * others + [requests[4]])
    assert same(found[-1], records[4])
    assert all(same(each, records[1]) for each in found[:-1])


def test_finished_lanes_are_refilled(company):
    scenes, requests, records = company
    short = [replace(requests[0], duration=requests[0].duration * f) for f in np.linspace(0.01, 0.3, 30)]
    found = follow_ensemble([scenes[0]] * 30 + [scenes[2]], [*short, requests[2]])
    assert [each.samples[0, 0] for each in found[:-1]] == [each.duration for each in short]
    assert same(found[-1], records[2])


def test_sections_at_events_and_late_records_are_those_of_one_trajectory():
    scenes = [model(clearance) for clearance in (2.9e-5, 5e-5, 1e-4)]
    ask = {"event": int(Event.CONTACT), "skip": 1, "stop_after": 4, "direction": 0}
    requests = [asked(each, 1e-7, log_from=0.016 * each.period, misses=True, **ask) for each in scenes]
    for each, request, found in zip(scenes, requests, follow_ensemble(scenes, requests), strict=True):
        alone = follow(each, request)
        assert ROUTES[found.route] == "in_lanes"
        for name in ("sections", "events", "misses"):
            ours, theirs = getattr(found, name), getattr(alone, name)
            assert ours[:, 0].tolist() == theirs[:, 0].tolist()
            assert np.allclose(ours[:, 2], theirs[:, 2], rtol=0, atol=1e-6 * each.period)
        assert 0 < len(found.sections) <= 3
        assert found.events[0, 2] >= request.log_from


SCRIPT = """
import json, math
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
scenes = [assemble(catalog.chunmei2002(clearance=e, gear_ratio=3.0, friction=0.3)) for e in (2.9e-5, 5e-5)]
asked = {"events": True, "misses": True, "log_from": -1.0, "level": 0.1, "period": math.tau, "direction": 1}
found = follow_ensemble(scenes, [Request(0.02 * each.period, 1e-5, **asked) for each in scenes])
rows = [[*part.ravel()] for each in found for part in (each.samples, each.events, each.sections)]
print(json.dumps([rows, [each.counts for each in found]]))
"""


@pytest.mark.nightly
def test_uncompiled_python_gives_the_same_motions():
    found = []
    for off in ("0", "1"):
        own = os.environ | {"NUMBA_DISABLE_JIT": off, "PYTHONWARNINGS": "ignore"}
        done = subprocess.run([sys.executable, "-c", SCRIPT], env=own, check=True, capture_output=True)
        found.append(json.loads(done.stdout))
    (compiled, counts), (plain, same_counts) = found
    assert [len(row) for row in compiled] == [len(row) for row in plain]
    assert all(np.allclose(a, b, rtol=1e-9, atol=1e-9) for a, b in zip(compiled, plain, strict=True))
    assert counts == same_counts
    assert min(each["n_events"] for each in counts) >= 3


def test_collocation_constants():
    k = np.arange(1, 6)
    assert np.allclose(r.A @ r.NODES[:, None] ** (k - 1), r.NODES[:, None] ** k / k, atol=1e-15)
    product = np.diag(np.zeros(5))
    product[0, 0] = r.EIGEN[0][0]
    for n, (re, im) in enumerate(r.EIGEN[1:]):
        a = 1 + 2 * n
        product[a : a + 2, a : a + 2] = [[re, -im], [im, re]]
    assert np.allclose(r.TO_STAGE @ product @ r.TO_EIGEN, np.linalg.inv(r.A), atol=1e-12)
    assert np.allclose(r.TO_STAGE @ r.TO_EIGEN, np.eye(5), atol=1e-14)
    # the estimate h f(0) + sum e_i Z_i vanishes for f = t^n, n = 1 … 4 (Z_i = c_i^(n+1)/(n+1)), not for f = 1
    assert np.allclose([r.ERROR @ r.NODES**n for n in (2, 3, 4)], 0, atol=1e-14)
    assert abs(r.ERROR @ r.NODES + 1) < 1e-14
    assert np.allclose(r.MONOMIAL @ r.NODES**3, np.eye(5)[2], atol=1e-12)
    assert np.allclose(r.TO_BERNSTEIN @ np.append(0.0, r.NODES), np.arange(6) / 5, atol=1e-13)
