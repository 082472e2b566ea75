"""Each mechanism is assembled once on its way from a call, or a study file, to its motion."""

from __future__ import annotations

import pytest

import jointplay as jp
from jointplay.cli import main
from jointplay.solver.mechanism import assemble
from jointplay.solver.mechanism.own import oscillators

LOOSE = jp.catalog.chunmei2002(clearance=2.9e-4)
PAIR = jp.catalog.impact_pair(3.6, 0.8)
ATTRACTOR = jp.catalog.lorenz()
START = {"y": [0.1, 0.2], "v": [0.1, 0.2]}
HIGH = jp.Plane(quantity="z", value=27.0)


@pytest.fixture
def made(monkeypatch):
    """The structures of the models that are assembled."""
    found = []
    for module in (assemble, oscillators):
        model = module.Model
        monkeypatch.setattr(
            module, "Model", lambda _make=model, **given: found.append(given["structure"]) or _make(**given)
        )
    return found


CALLS = {
    "turns": lambda: jp.simulate(LOOSE, turns=0.1),
    "duration": lambda: jp.simulate(LOOSE, duration=0.01),
    "times": lambda: jp.simulate(LOOSE, duration=0.01, at=[0.005]),
    "a section": lambda: jp.simulate(LOOSE, turns=0.1, section=jp.CrankAngle()),
    "work": lambda: jp.simulate(LOOSE, turns=0.1, record=["energy_residual"]),
    "a start": lambda: jp.simulate(LOOSE, turns=0.1, initial={"crank_angle": 0.5}),
    "a system": lambda: jp.simulate(PAIR, turns=1),
    "contacts": lambda: jp.poincare(PAIR, jp.ContactSection(), turns=1),
    "a plane": lambda: jp.poincare(ATTRACTOR, HIGH, duration=1.0),
    "a spectrum": lambda: jp.spectrum(LOOSE, turns=2),
    "exponents": lambda: jp.lyapunov(PAIR, turns=80, exponents=2),
    "a difference": lambda: jp.sensitivity(PAIR, turns=2),
    "a plane of starts": lambda: jp.basins(PAIR, plane=START, turns=20, patience=2, n_jobs=1),
    "vectors": lambda: jp.covariant(jp.catalog.duffing(), turns=2, transient=1, settling=1),
    "an orbit": lambda: jp.periodic_orbit(jp.catalog.duffing(), transient=0, initial=[1.0, 0.0]),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_call_assembles_its_mechanism_once(made, name):
    CALLS[name]()
    assert len(made) == 1


@pytest.mark.parametrize("way", ["up", "reset"])
@pytest.mark.parametrize(
    ("mechanism", "over"), [(LOOSE, {"clearance": [1e-4, 2e-4]}), (PAIR, {"gap": [3.5, 3.6]})]
)
def test_a_sweep_is_checked_once_and_assembled_at_each_point(made, mechanism, over, way):
    jp.bifurcation(mechanism, over=over, direction=way, turns=1, transient=1, n_jobs=1)
    assert len(made) == 1 + 2


VARIED = "[vary]\ngear_ratio = [3.0, 15.0]\n"
LINKAGE = '[mechanism]\ncatalog = "chunmei2002"\nclearance = 2.9e-4\n'
STUDIES = {
    "one": (1, f'kind = "response"\n{LINKAGE}[analysis]\nduration = 0.01'),
    "cut": (
        1,
        'kind = "section"\n[mechanism]\ncatalog = "lorenz"\n[analysis]\nduration = 1.0\n'
        'section = { kind = "plane", quantity = "z", value = 27.0 }',
    ),
    "sweep": (
        1 + 2,
        f'kind = "bifurcation"\n{LINKAGE}{VARIED}[analysis]\nturns = 1\ntransient = 1',
    ),
    "several": (1 + 2, f'kind = "response"\n{LINKAGE}{VARIED}[analysis]\nturns = 0.1'),
}


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_assembles_each_mechanism_once_beside_the_check_of_a_sweep(made, name, tmp_path):
    expected, text = STUDIES[name]
    path = tmp_path / f"{name}.toml"
    path.write_text(text)
    assert main(["run", str(path), "--out", str(tmp_path), "--jobs", "1", "--no-figure"]) == 0
    assert len(made) == expected
