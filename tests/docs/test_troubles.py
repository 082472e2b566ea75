"""Every status and every warning is told, and every way in which a motion is followed."""

import ast
import re
from functools import cache

import pytest

from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.eligibility import ROUTES
from tests.docs.pages import DOCS, ROOT

PAGE = (DOCS / "troubles.md").read_text(encoding="utf-8")
WARNINGS = {  # files that warn, each with the beginning of its row
    "analysis/keywords.py": "a key, what was given, and what is likelier",
    "analysis/evaluate.py": "the journal of … goes … clearances into its bearing",
    "analysis/gradients/gradient.py": "a derivative hardly exists here",
    "analysis/assessment/assess.py": "with ideal joints the crank comes to no steady speed",
    "analysis/rules.py": "… is left out",
    "analysis/orbits/orbit_dataset.py": "… motions are neutral",
    "study/results/export.py": "not in the table",
}


def part(heading):
    """Text under a heading."""
    return re.search(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)[1]


def rows(heading):
    """Rows of the table under a heading, as lists of cells."""
    lines = [line for line in part(heading).splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split(" |")] for line in lines[2:]]


def named(heading):
    """What the list under a heading explains."""
    return re.findall(r"^- `([\w ]+)`: \w", part(heading), re.MULTILINE)


@cache
def calls():
    """Each call in the sources, with its file below a package."""
    return [
        (path.relative_to(ROOT / "src").as_posix().partition("/")[2], node)
        for path in sorted((ROOT / "src").glob("jointplay*/**/*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
    ]


def test_every_status_has_its_row_with_what_to_do():
    statuses = rows("How a run ended")
    assert sorted(row[0].strip("`") for row in statuses) == sorted(Status.words())
    assert all(len(row) == 3 and all(row) for row in statuses)
    assert named("Derivatives in parameters") == list(VERDICTS)


@pytest.mark.long
def test_every_warning_has_its_row():
    warn = {file for file, call in calls() if isinstance(call.func, ast.Name) and call.func.id == "warn"}
    assert warn == set(WARNINGS)
    assert {row[0] for row in rows("Warnings")} == set(WARNINGS.values())


def test_every_beginning_of_a_line_on_stderr_has_its_row():
    said = set()
    for _, call in calls():
        to = [ast.unparse(each.value) for each in call.keywords if each.arg == "file"]
        if to == ["sys.stderr"]:
            texts = [each.value for each in ast.walk(call.args[0]) if isinstance(each, ast.Constant)]
            said |= {
                found[1] for text in texts[:1] if (found := re.match(r"\s*([a-z][a-z ]*[a-z])", str(text)))
            }
    assert len(said) > 5
    assert said | {"kernel cache"} == set(named("What the command prints on stderr"))


def test_every_way_in_which_a_motion_is_followed_has_its_row():
    text = (DOCS / "integrator.md").read_text(encoding="utf-8")
    table = text.partition("| `followed` |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE) == list(ROUTES)
