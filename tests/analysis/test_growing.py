"""A vibration that friction excites comes up, however long the steps might be."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis import trajectory
from jointplay.lab.paper.fixed_steps import _jacobian
from jointplay.lab.stress.scenes import draw
from jointplay.mechanism.assemble import assemble

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


@pytest.mark.long
def test_steps_follow_what_falling_friction_excites(monkeypatch):
    variants = tomllib.loads(STUDY.read_text())["analysis"]["variants"]
    case = draw(catalog.chunmei2002(), SCENE, 0, tuple(variants))
    assert case.friction_law == "lugre"
    model = assemble(case.mechanism, case.initial)
    followed = radians(model, 0.45)
    monkeypatch.setattr(trajectory, "_excites", lambda *_: False)
    stepped_over = radians(model, 0.45)
    assert 2.0 < followed.max() < 9.0
    assert stepped_over.max() > 20.0
