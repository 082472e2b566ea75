"""What it takes to add a law, a quantity and a kind: done as docs/developers.md says, in a copy, and counted.

What a command writes is not counted: tables of the documentation, and pictures. Nor is the text about a kind.
"""

import difflib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "developers.md").read_text(encoding="utf-8")
LAW, ANALYSIS, ROW, FIGURE, _ = re.findall(r"^```python\n(.*?)^```", PAGE, re.S | re.M)
EXPRESSION, WORD, _ = re.findall(r"^```py\n(.*?)^```", PAGE, re.S | re.M)
(STUDY,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.S | re.M)
KINDS, LAWS = "src/jointplay/kinds.py", "src/jointplay/solver/equations/laws.py"
PLAY, WORDS = "src/jointplay/solver/equations/play.py", "src/jointplay/analysis/quantities.py"
TEXT = """# returns

How often the section points of a motion come back to where the first one was, as a share of all of them.

```{include} ../generated/kind_returns.inc
```
"""
LISTED = "\n)\n\n\nKINDS = "  # where the rows end


class Copy:
    """The project, copied: what is edited by hand, and commands that run in it."""

    def __init__(self, folder):
        self.folder, self.before = folder, {}
        for name in ("src", "tests", "docs", "studies"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for path in (*ROOT.glob("*.toml"), *ROOT.glob("*.md"), *ROOT.glob("*.cff")):
            shutil.copy(path, folder)
        (folder / "results").symlink_to(ROOT / "results")

    def edit(self, name, change):
        """Change a file's text, or make one of that name."""
        path = self.folder / name
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        self.before.setdefault(name, text)
        path.write_text(change(text), encoding="utf-8")
        assert path.read_text(encoding="utf-8") != text

    @property
    def cost(self):
        """Files touched by hand, and lines added or changed in them that are not blank."""
        lines = 0
        for name, text in self.before.items():
            after = (self.folder / name).read_text(encoding="utf-8")
            found = difflib.unified_diff(text.splitlines(), after.splitlines(), n=0)
            lines += sum(line[:1] == "+" and line[:3] != "+++" and line[1:].strip() != "" for line in found)
        return len(self.before), lines

    def run(self, *command, **surroundings):
        """Run Python on the copied sources."""
        path = os.pathsep.join([str(self.folder / "src"), os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {"PYTHONPATH": path} | surroundings
        command = [sys.executable, *command]
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
        return done.stdout

    def test(self, *which):
        """Run tests there: all pass, and there are some."""
        said = self.run("-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *which)
        assert re.search(r"^[1-9]\d* passed", said, re.M)


@pytest.fixture
def copy(tmp_path):
    return Copy(tmp_path)


@pytest.mark.nightly
def test_a_law_is_one_file_and_its_trial_reference_and_rows_of_tables_follow(copy):
    added = "".join(line for line in LAW.splitlines(keepends=True) if not line.startswith("from "))
    copy.edit(LAWS, lambda text: f"{text}\n{added}")
    files, lines = copy.cost
    assert files <= 2
    assert lines <= 20
    assert "| `quadratic` | K |u| u + C v |" in copy.run("-c", TABLE)
    tests = ("test_laws.py", "test_normal_laws.py", "test_friction_laws.py")
    chosen = "quadratic or pages or says or letter"
    copy.test(*(f"tests/equations/{name}" for name in tests), "tests/cli/test_cite.py", "-k", chosen)
    beside = "quadratic and rigid and response and single or in_a_scene"  # bodies of their own
    copy.test("tests/reference/test_pairs.py", "-k", beside, "-m", "")


@pytest.mark.nightly
def test_all_tests_of_laws_pass_with_one_more(copy):
    added = "".join(line for line in LAW.splitlines(keepends=True) if not line.startswith("from "))
    copy.edit(LAWS, lambda text: f"{text}\n{added}")
    copy.test("tests/equations", "tests/cli/test_cite.py", "tests/docs", "tests/lab/test_stress_scenes.py")


TABLE = """
import sys

sys.path.insert(0, "docs")
from pages import laws

print(laws.page())
"""
POWER = """
import jointplay as jp
from jointplay.analysis.evaluate import Quantities
from jointplay.solver.mechanism.assemble import assemble

mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
record = ["friction_power", "tangential_force", "tangential_velocity"]
found = jp.simulate(mechanism, turns=0.03, record=record)
assert int(found.status) == 0 and found.friction_power.units == "W"
power = found.tangential_force * found.tangential_velocity
assert abs(power).max() > 0 and abs(found.friction_power - power).max() <= 1e-12 * abs(power).max()
model = assemble(mechanism)
module = Quantities(model, model.state[None, :0], model.state).module
assert "friction_power:B" in module.ABRUPT and "normal_force:B" not in module.ABRUPT
"""


@pytest.mark.long
def test_a_quantity_is_two_lines_and_whether_it_follows_accelerations_is_found(copy):
    stored = re.search(r"^( +)yield f\"stored_energy.*\n", (ROOT / PLAY).read_text("utf-8"), re.M)
    copy.edit(PLAY, lambda text: text.replace(stored[0], stored[0] + stored[1] + EXPRESSION))
    copy.edit(WORDS, lambda text: text.replace("WORDS = {\n", f"WORDS = {{\n    {WORD}"))
    assert copy.cost == (2, 2)
    copy.run("-c", POWER, NUMBA_DISABLE_JIT="1")


@pytest.mark.nightly
def test_a_kind_is_four_files(copy):
    row = "".join(f"\n    {line}" for line in ROW.splitlines())
    copy.edit("src/jointplay/analysis/signals/returns.py", lambda _: ANALYSIS)
    copy.edit("src/jointplay/figures/analyses/returns.py", lambda _: FIGURE)
    copy.edit(KINDS, lambda text: text.replace(LISTED, f"{row},{LISTED}"))
    copy.edit("studies/chaos/returns.toml", lambda _: STUDY)
    files, lines = copy.cost
    assert files <= 4
    assert lines <= 100
    copy.run("-m", "jointplay", "run", "studies/chaos/returns.toml", "--out", "made")
    shutil.copy(copy.folder / "made" / "returns.png", copy.folder / "docs" / "images")
    (copy.folder / "docs" / "kinds" / "returns.md").write_text(TEXT, encoding="utf-8")
    where = ("study/test_sweep_kinds.py", "study/test_shipped.py", "cli/test_cite.py", "docs/test_pages.py")
    where += ("figures/test_pictures.py", "cli/test_new.py", "test_layout.py")
    chosen = "returns or everything or every_kind or examples or layout"
    copy.test(*(f"tests/{name}" for name in where), "-k", chosen)
    where = ("analysis/test_declared.py", "study/test_sweep_kinds.py", "cli/test_new.py")
    copy.test(*(f"tests/{name}" for name in where), "-k", "returns", "-m", "")
