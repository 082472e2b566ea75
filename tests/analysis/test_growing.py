"""A vibration that friction excites comes up, however long the steps might be."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jointplay import catalog
from jointplay.solver.codegen import cache, elimination
from jointplay.solver.equations import write
from jointplay.solver.equations.structure import Linkage
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import trajectory
from jointplay_lab.paper.fixed_steps import _jacobian
from jointplay_lab.stress.scenes import draw
from jointplay_page.script.solver import solver
from tests.script.in_node import needs_node, ran

STUDY = Path(__file__).parents[2] / "studies/stress/stress_others.toml"
SCENE = 1527  # of that study: a slider-crank with `lugre`


def radians(model, turns):
    """Of the vibration that grows fastest, how far a step goes, at up to 200 steps; 0 where none grows."""
    request = trajectory.Request(turns * model.period, 1e-8, steps=True, log_from=0.0, max_steps=5000)
    rows = trajectory.follow(model, request).steps[:, 2:]
    n_x, n_q, found = len(model.state), len(model.turning), []
    for i in np.unique(np.linspace(0, len(rows) - 2, 200).astype(int)):
        A = np.eye(n_x, k=n_x - n_q)
        A[:n_q] = np.eye(n_q, n_x, k=n_q)
        A[n_q:] = _jacobian(model, rows[i, : 1 + n_x], rows[i, 1 + n_x :][: len(model.touching)].astype(int))
        values = np.linalg.eigvals(A)
        fastest = values[np.argmax(values.real)]
        grows = fastest.real * model.period > 2.0
        found.append((rows[i + 1, 0] - rows[i, 0]) * abs(fastest) if grows else 0.0)
    return np.array(found)


@pytest.fixture(scope="module")
def case():
    """The scene, whose vibration comes up from rounding after 0.35 turns and is a limit cycle after 0.4."""
    variants = tomllib.loads(STUDY.read_text())["analysis"]["variants"]
    drawn = draw(catalog.chunmei2002(), SCENE, 0, tuple(variants))
    assert drawn.friction_law == "lugre"
    return drawn


RAN_UP, SPAN, SAMPLES = 0.4, 0.05, 2000  # turns; twenty samples in a vibration


def size_of(speeds):
    """Of the vibration: the largest second difference of a speed at even times."""
    return np.abs(np.diff(speeds, 2)).max()


def vibration(model):
    """Its size in a compiled run."""
    at = (RAN_UP + SPAN * np.arange(1, SAMPLES + 1) / SAMPLES) * model.period
    records = trajectory.follow(model, trajectory.Request(at[-1], 1e-8, at=at))
    return size_of(records.samples[:, 1 + len(model.turning)])


@pytest.fixture(scope="module")
def single(case):
    """Its size in a single run."""
    return vibration(assemble(case.mechanism, case.initial))


class Planned(Linkage):
    """The structure of a linkage by the sparse algebra, as if it had many unknowns."""


@pytest.fixture
def planned(case, monkeypatch):
    """The scene's model by the sparse algebra."""
    monkeypatch.setitem(write.WRITERS, Planned, write.WRITERS[Linkage])
    monkeypatch.setattr(elimination, "LARGEST_DENSE", 3)
    model = assemble(case.mechanism, case.initial)
    return replace(model, structure=Planned(**vars(model.structure)))


PROGRAM = f"""
const solver = makeSolver(data);
solver.run({RAN_UP});
return solver.run({SPAN}, {{ samples: {SAMPLES} }});
"""


@pytest.mark.nightly
def test_a_sparse_system_follows_what_grows(single, planned, monkeypatch):
    assert cache.structure_module(planned.structure).SIZES["planned"]
    assert vibration(planned) == pytest.approx(single, rel=0.1)
    monkeypatch.setattr(trajectory, "_excites", lambda *_: False)
    assert vibration(planned) < 1e-3 * single


@pytest.mark.nightly
@needs_node
def test_a_page_follows_what_grows(case, single, tmp_path):
    script = solver(case.mechanism, initial=case.initial, names=("angular_velocity",))
    found = ran(script.text, script.data, PROGRAM, tmp_path)
    assert found["status"] == "ok"
    assert size_of(found["angular_velocity"]["rod"]) == pytest.approx(single, rel=0.1)


@pytest.mark.long
def test_steps_follow_what_falling_friction_excites(case, monkeypatch):
    model = assemble(case.mechanism, case.initial)
    followed = radians(model, 0.45)
    monkeypatch.setattr(trajectory, "_excites", lambda *_: False)
    stepped_over = radians(model, 0.45)
    assert 2.0 < followed.max() < 9.0
    assert stepped_over.max() > 20.0
