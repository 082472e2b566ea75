"""What another package publishes by entry points is used as ours is; what cannot be loaded is named."""

import os
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

EXAMPLE, DOCS = Path(__file__).parent / "example_package", Path(__file__).parents[1] / "docs"
POINTS = "jointplay_example-1.0.dist-info/entry_points.txt"
BUILD = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
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
stored = jp.open("out/study.nc")
assert float(stored.echo_share) == 1 and jp.echo("hello") == "hello" and "echo" in dir(jp)
"""
COMMANDS = """
import sys
from jointplay.cli import main

for line in sys.stdin.read().splitlines():
    print("==", line, file=sys.stderr, flush=True)
    try:
        print(main(line.split()), file=sys.stderr)
    except SystemExit as end:  # of --help
        print(end, file=sys.stderr)
"""
PAGES = """
import sys
sys.path.insert(0, sys.argv[1])
import pages
for name, text in pages.pages().items():
    print(*(f"{name}: {line}" for line in text.splitlines()), sep="\\n")
"""
BROKEN_CODE = """
LOST = Kind("lost", "missing_module:lost")
GONE = Kind("gone", "jointplay_example:gone")


def __getattr__(name):
    raise SystemExit(3) if name == "QUIT" else AttributeError(name)


@preset()
def torn() -> jp.Mechanism:
    "Torn."
    return {}["nothing"]


@preset()
def wheel() -> jp.System:
    "Equations."
    return jp.System(name="wheel", states={"y": 1.0}, rates={"y": "-y"})
"""
BROKEN_POINTS = {
    "laws": "bog = missing_module:BOG\nheath = jointplay_example:ECHOES\nhertz = jointplay_example:MEADOW",
    "frictions": "silk = jointplay_example:SILK\nfelt = jointplay_example:QUIT",
    "mechanisms": "sunk = missing_module:sunk\ntorn = jointplay_example:torn\n"
    "wheel = jointplay_example:wheel",
    "kinds": "none = missing_module:NONE\nlost = jointplay_example:LOST\ngone = jointplay_example:GONE",
    "figures": "blank = missing_module:blank",
}
MISSING = "ModuleNotFoundError: No module named 'missing_module'"
NO_CODE = "entry point '{}' (jointplay_example:{}) of jointplay-example in jointplay.{}: "
NO_MODULE = f"entry point '{{}}' (missing_module:{{}}) of jointplay-example in jointplay.{{}}: {MISSING}"
REFUSED = {  # by command: exit code, and what it says
    "check study.toml --set kind=none": (2, NO_MODULE.format("none", "NONE", "kinds")),
    "check study.toml --set kind=lost": (
        2,
        NO_CODE.format("lost", "LOST", "kinds") + "its analysis missing_mod",
    ),
    "new gone": (
        2,
        NO_CODE.format("gone", "GONE", "kinds") + "its analysis jointplay_example:gone cannot be",
    ),
    "schema": (2, NO_CODE.format("lost", "LOST", "kinds")),
    "check study.toml --set mechanism.catalog=sunk": (2, NO_MODULE.format("sunk", "sunk", "mechanisms")),
    "new response --mechanism wheel": (2, "got 'wheel'; a linkage is accepted"),
    "new response --mechanism torn": (1, "error in code of jointplay-example: "),
    "check study.toml --set figure.kind=blank": (2, NO_MODULE.format("blank", "blank", "figures")),
    "check study.toml --set mechanism.joints.B.friction.law=silk": (
        2,
        NO_CODE.format("silk", "SILK", "frictions") + "AttributeError: ",
    ),
    "check study.toml": (0, "0"),
}


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The example package as a wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-c", BUILD, str(folder)]
    subprocess.run(command, cwd=EXAMPLE, check=True, capture_output=True)
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture
def run(wheel, tmp_path):
    """Run Python where the example package is installed: with more code or entry points in it, or none."""
    (tmp_path / "study.toml").write_text(STUDY)

    def ran(*command, code="", points=(), given=None):
        ZipFile(wheel).extractall(tmp_path)
        whole = tmp_path / POINTS
        text = whole.read_text()
        for group, more in dict(points or {}).items():
            text = text.replace(f"[jointplay.{group}]\n", f"[jointplay.{group}]\n{more}\n")
        whole.write_text("" if points is None else text)
        with (tmp_path / "jointplay_example.py").open("a") as module:
            module.write(code)
        path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
        environment, command = os.environ | {"PYTHONPATH": path}, [sys.executable, *command]
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, input=given
        )

    return ran


@pytest.mark.nightly
def test_what_a_package_adds_is_checked_listed_told_and_written_as_ours_is(run, tmp_path):
    commands = (
        *("check study.toml", "schema", "new echoes own.toml", "new response saw.toml --mechanism seesaw"),
        *("check own.toml", "check saw.toml", "list .", "new --help", "--help"),
    )
    done = run("-c", COMMANDS, given="\n".join(commands))
    assert done.stderr.splitlines() == [line for each in commands for line in (f"== {each}", "0")]
    for each in ("200 µm, meadow, stiffness 1", "friction 0.2 (velvet, nap 20 mm/s)", "own.toml    echoes"):
        assert each in done.stdout
    for name in ("echoes", "meadow", "velvet", "nap", "seesaw", "portrait"):
        assert f'"{name}"' in done.stdout, name  # of the schema
    assert "echoes, " in done.stdout.partition("usage: jointplay new")[2]
    assert "greet somebody" in done.stdout
    assert '# kind = "portrait"' in (tmp_path / "own.toml").read_text(encoding="utf-8")
    assert 'contact = { law = "meadow", ' in (tmp_path / "saw.toml").read_text(encoding="utf-8")


@pytest.mark.nightly
def test_what_a_package_adds_is_in_the_tables_of_the_documentation(run):
    done = run("-c", PAGES, str(DOCS))
    assert done.returncode == 0, done.stderr
    for line in (
        "kinds.md: | [`echoes`](kind_echoes.md) | Give the share of section points that ",
        "kind_echoes.md: # echoes",
        "kind_echoes.inc: | [`portrait`](../generated/figures.md#portrait) | Draw the share as a bar. |",
        "api_others.md: .. autofunction:: jointplay.echo",
        'figures.md: | `colour` | `"black"` | Of the bar. |',
        "keys.md: | `meadow` | `stiffness` | N/m | needed | greater than 0 |",
        "keys.md: | `velvet` | `nap` | m/s | `0.1` | greater than 0 |",
        "laws.md: | `meadow` | K u + C v | A. Stranger, Soft ground, 2026 |",
        "laws.md: | `velvet` | f tanh(v_t/c) | textbooks |",
    ):
        assert f"\n{line}" in done.stdout, line
    linkages = done.stdout.partition("catalog.md: ## Linkages")[2].partition("catalog.md: ## Test systems")[0]
    assert "catalog.md: ### seesaw\n" in linkages


@pytest.mark.nightly
def test_laws_mechanisms_kinds_and_figures_that_a_package_publishes_are_used_as_ours_are(run, tmp_path):
    done = run("-m", "jointplay", "run", "study.toml", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "study.png").exists()
    done = run("-c", CHECK)
    assert done.returncode == 0, done.stderr
    done = run("-m", "jointplay", "cite", "study.toml")
    assert "A. Stranger, Soft ground, 2026\n    for contact law meadow" in done.stdout
    done = run("-m", "jointplay", "greet", "everybody")
    assert (done.returncode, done.stdout) == (0, "hello everybody\n"), done.stderr


@pytest.mark.nightly
def test_cells_that_another_packages_code_computed_are_not_taken_for_those_of_its_changed_code(run, tmp_path):
    study = STUDY.partition("joints")[0].replace("seesaw", "impact_pair").replace("clearance = 2e-4", PAIR)
    (tmp_path / "a.toml").write_text(study + "[vary]\ngap = [3.6, 3.7]\n[analysis]\nturns = 1\n")
    command = ["-m", "jointplay", "run", "a.toml", "--no-figure", "--jobs", "1"]
    assert run(*command).returncode == 0
    again = run(*command)
    assert "2 of 2 cells are there already" in again.stderr + again.stdout
    changed = run(*command, code="\nOTHER = 1\n")
    assert changed.returncode == 2
    assert "these were computed by another" in changed.stderr


@pytest.mark.long
def test_kernels_of_another_packages_law_are_not_those_of_its_changed_law(run):
    code = "from jointplay.solver.codegen.place import digest; print(digest())"
    ways = ({}, {}, {"code": "\nOTHER = 1\n"}, {"points": None})
    first, again, changed, none = (run("-c", code, **way).stdout for way in ways)
    assert first == again
    assert len({first, changed, none}) == 3


@pytest.mark.nightly
def test_what_is_broken_in_a_package_is_told_with_its_name_and_breaks_nothing_else(run):
    done = run("-c", COMMANDS, given="\n".join(REFUSED), code=BROKEN_CODE, points=BROKEN_POINTS)
    assert "Traceback" not in done.stderr
    told = dict(each.split("\n", 1) for each in done.stderr.split("== ")[1:])
    for command, (code, why) in REFUSED.items():
        assert why in told[command], command
        assert told[command].splitlines()[-1] == str(code), command
    assert NO_CODE.format("felt", "QUIT", "frictions") + "SystemExit: 3" in done.stderr
    assert "jointplay_example.py, line " in told["new response --mechanism torn"]
    done = run("-c", "import jointplay as jp; jp.Contact(law='bog')", code=BROKEN_CODE, points=BROKEN_POINTS)
    said = done.stderr.splitlines()[-1]
    assert "contact.law: got 'bog'; there is no such law; these are accepted: kelvin_voigt, " in said
    assert f"not loaded: {NO_MODULE.format('bog', 'BOG', 'laws')}" in said
    assert NO_CODE.format("heath", "ECHOES", "laws") + "TypeError: " in said
    assert NO_CODE.format("hertz", "MEADOW", "laws") + "ValueError: " in said
