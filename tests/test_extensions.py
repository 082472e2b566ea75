"""What another package publishes by entry points is used as ours is; what cannot be loaded is named."""

import os
import subprocess
import sys

import pytest

MODULE = """
from typing import Any

import jointplay as jp
from jointplay.cli.verb import Verb, option, say
from jointplay.figures.registry import picture
from jointplay.kinds import Kind
from jointplay.solver.equations.friction import FrictionLaw
from jointplay.solver.equations.laws import Law
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism.signature import preset

MEADOW = Law(
    force=lambda m, u, v_n, K, C: (K * u + C * v_n, K * u**2 / 2),
    slopes=lambda depth, K, C: (K, C),
    numbers={"stiffness": Quantity("K", "N/m"), "damping": Quantity("C", "N s/m", least=0.0)},
    references=("A. Stranger, Soft ground, 2026",),
)
NAP = Quantity("c", "m/s", usual=0.1)
VELVET = FrictionLaw(lambda m, v_t, f, c: f * m.tanh(v_t / c), numbers={"nap": NAP})


@preset()
def seesaw(clearance: float = 1e-4, **changes: Any) -> jp.Mechanism:
    plain = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=clearance)
    laws = {"contact": jp.Contact(law="meadow", stiffness=1e7, damping=200.0)}
    laws |= {"friction": jp.Friction(law="velvet", coefficient=0.1)}
    joints = [joint.model_copy(update=laws) for joint in plain.joints]
    return jp.Mechanism(**dict(plain) | {"name": "seesaw", "joints": joints}).replace(**changes)


ECHOES = Kind("echoes", "jointplay.analysis.poincare:poincare", ("portrait",))


def greet(arguments):
    'Greet somebody.'
    say(f"hello {arguments.name}")
    return 0


GREET = Verb("greet", greet, (option("name"),), "you")


def echoed(word):
    return word


@picture()
def portrait(dataset):
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().plot(dataset["angle"].values.ravel())
    return figure
"""
POINTS = """
[jointplay.laws]
meadow = stranger:MEADOW
[jointplay.frictions]
velvet = stranger:VELVET
[jointplay.mechanisms]
seesaw = stranger:seesaw
[jointplay.kinds]
echoes = stranger:ECHOES
[jointplay.figures]
portrait = stranger:portrait
[jointplay.verbs]
greet = stranger:GREET
[jointplay.names]
echo = stranger:echoed
"""
BROKEN = """
[jointplay.laws]
bog = missing_module:BOG
heath = stranger:ECHOES
hertz = stranger:MEADOW
"""
STUDY = """
kind = "echoes"
[mechanism]
catalog = "seesaw"
clearance = 2e-4
joints = { B = { friction = { law = "velvet", coefficient = 0.2, nap = "2 cm/s" } } }
[analysis]
turns = 1
"""
PAIR = "gap = 3.6\nrestitution = 0.8"
CHECK = """
import jointplay as jp
found = jp.simulate(jp.catalog.seesaw(), turns=0.1, record=["normal_force", "penetration", "normal_velocity"])
assert int(found.status) == 0
touching = found.penetration.values > 1e-9
force = 1e7 * found.penetration.values + 200 * found.normal_velocity.values
wrong = abs(found.normal_force.values - force)[touching]
assert touching.any() and wrong.max() < 1e-6 * force[touching].max()
assert {"seesaw"} < {*dir(jp.catalog)}
assert "meadow" in str(jp.Contact.model_json_schema()["properties"]["law"]["enum"])
stored = jp.open("out/stranger_study.nc")
assert stored.sizes["turn"] == 1
print(len(jp.figure(stored, kind="portrait").axes))
"""


@pytest.fixture
def run(tmp_path):
    """Run a program where the package of a stranger is installed, with these entry points."""

    def ran(points, *command, more=""):
        info = tmp_path / "stranger-1.0.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(points)
        (tmp_path / "stranger.py").write_text(MODULE + more)
        path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {"PYTHONPATH": path}
        command = [sys.executable, *command]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)

    return ran


@pytest.mark.long
def test_laws_mechanisms_kinds_and_figures_that_a_package_publishes_are_used_as_ours_are(run, tmp_path):
    (tmp_path / "stranger_study.toml").write_text(STUDY)
    done = run(POINTS, "-m", "jointplay", "run", "stranger_study.toml", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "stranger_study.png").exists()
    done = run(POINTS, "-c", CHECK)
    assert (done.returncode, done.stdout) == (0, "1\n"), done.stderr
    done = run(POINTS, "-m", "jointplay", "cite", "stranger_study.toml")
    assert "A. Stranger, Soft ground, 2026\n    for contact law meadow" in done.stdout
    done = run(POINTS, "-m", "jointplay", "greet", "everybody")
    assert (done.returncode, done.stdout) == (0, "hello everybody\n"), done.stderr
    done = run(POINTS, "-c", "import jointplay as jp; print(jp.echo('hello'), 'echo' in dir(jp))")
    assert done.stdout == "hello True\n", done.stderr


@pytest.mark.nightly
def test_cells_that_another_packages_code_computed_are_not_taken_for_those_of_its_changed_code(run, tmp_path):
    study = STUDY.partition("joints")[0].replace("seesaw", "impact_pair").replace("clearance = 2e-4", PAIR)
    (tmp_path / "a.toml").write_text(study + "[vary]\ngap = [3.6, 3.7]\n[analysis]\nturns = 1\n")
    command = ["-m", "jointplay", "run", "a.toml", "--no-figure", "--jobs", "1"]
    assert run(POINTS, *command).returncode == 0
    again = run(POINTS, *command)
    assert "2 of 2 cells are there already" in again.stderr + again.stdout
    changed = run(POINTS, *command, more="\nOTHER = 1\n")
    assert changed.returncode == 2
    assert "these were computed by another" in changed.stderr


def test_kernels_of_another_packages_law_are_not_those_of_its_changed_law(run):
    code = "from jointplay.solver.codegen.digest import digest; print(digest())"
    first, again, none = (
        run(*how).stdout
        for how in (
            (POINTS, "-c", code),
            (POINTS, "-c", code),
            ("", "-c", code),
        )
    )
    changed = run(POINTS, "-c", code, more="\nOTHER = 1\n").stdout
    assert first == again
    assert len({first, changed, none}) == 3


def test_an_entry_point_that_cannot_be_loaded_names_itself_and_breaks_nothing_else(run):
    code = "import jointplay as jp; print(jp.Contact(law='meadow', stiffness=1.0, damping=0.0).law)"
    done = run(POINTS + BROKEN, "-c", code)
    assert (done.returncode, done.stdout) == (0, "meadow\n"), done.stderr
    done = run(POINTS + BROKEN, "-c", "import jointplay as jp; jp.Contact(law='bog')")
    said = done.stderr.splitlines()[-1]
    assert "contact.law: got 'bog'; there is no such law; these are accepted: kelvin_voigt, " in said
    why = "ModuleNotFoundError: No module named 'missing_module'"
    assert f"not loaded: entry point 'bog' (missing_module:BOG) of stranger in jointplay.laws: {why}" in said
    assert "entry point 'heath' (stranger:ECHOES) of stranger in jointplay.laws: TypeError: " in said
    assert "entry point 'hertz' (stranger:MEADOW) of stranger in jointplay.laws: ValueError: " in said
