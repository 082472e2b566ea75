"""Code blocks, references to tests, and pages that are written from the code."""

import re
import shlex
import subprocess
import sys
import tomllib
from importlib import import_module

import pytest
from PIL import Image

from jointplay import cli
from jointplay.cli import build_parser
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from tests.docs.pages import DOCS, PAGES, ROOT, blocks, generated

NUMBER = re.compile(r"[-+\N{MINUS SIGN}]?\d+(?:\.\d+)?")
ROW = re.compile(r"^\|.*\| ([\d.e-]+) \| `(tests/[\w/]+\.py)::(\w+)` \|$", re.MULTILINE)
EXAMPLES = {"README.md": "tests/study/test_readme.py", "developers.md": "tests/study/test_developers.py"}
EXAMPLES |= {"own-equations.md": "tests/mechanism/test_own.py"}
WORDS = {  # of a page at most, with its tables and code: what tables of keys say is said there alone
    "study-files": 4250,
    "developers": 2850,
    "model": 2550,
    "benchmarks": 2300,
    "integrator": 2300,
    "stiffness": 2150,
    "laws": 2100,
    "sweeps": 1650,
    "own-equations": 1550,
    "troubles": 800,
    "policy": 350,
}


def commands(block):
    """Lines of a shell block that call jointplay, as lists of words."""
    lines = block.text.splitlines() if block.language == "sh" else []
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("jointplay ")]


@pytest.mark.parametrize(("name", "most"), WORDS.items(), ids=WORDS)
def test_no_page_grows_without_a_decision(name, most):
    assert len((DOCS / f"{name}.md").read_text(encoding="utf-8").split()) <= most


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_blocks_are_python_and_commands_are_ours(page):
    for block in blocks(page):
        if block.language == "python":
            compile(block.text, page.name, "exec")
        for words in commands(block):
            build_parser().parse_args(words)


def test_every_page_with_python_is_run_by_some_test():
    with_code = {page.name for page in PAGES if any(block.language == "python" for block in blocks(page))}
    assert with_code == {"tutorial.md", "api.md", *EXAMPLES}


def alike(said, promised):
    """Whether a line of output says what the page promises: its words, and numbers to a tenth."""
    ours, theirs = (
        list(map(float, NUMBER.findall(text.replace("\N{MINUS SIGN}", "-")))) for text in (said, promised)
    )
    same = NUMBER.sub("#", said) == NUMBER.sub("#", promised)
    return same and ours == pytest.approx(theirs, rel=0.1, abs=0.05)


def test_another_number_or_word_is_not_alike():
    assert alike("contact B 136 N: chaotic", "contact B 135 N: chaotic")
    assert not alike("contact B 160 N: chaotic", "contact B 135 N: chaotic")
    assert not alike("contact B 135 N: stable", "contact B 135 N: chaotic")


@pytest.mark.long
def test_the_tutorial_does_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = iter(
        re.findall(r"[Ss]ave (?:this|it) as `([\w.]+)`", (DOCS / "tutorial.md").read_text(encoding="utf-8"))
    )
    said, space = "", {}
    for block in blocks(DOCS / "tutorial.md"):
        if block.language == "toml":
            (tmp_path / next(names)).write_text(block.text, encoding="utf-8")
        for words in commands(block):
            assert cli.main(words) == 0, words
        said = capsys.readouterr().out or said
        if block.language == "text":
            for line in block.text.splitlines():
                assert any(alike(each, line) for each in said.splitlines()), line
        if block.language == "python":
            exec(compile(block.text, "tutorial.md", "exec"), space)
            assert alike(capsys.readouterr().out.strip(), block.text.rpartition("# ")[2].strip())
    assert next(names, None) is None


def test_the_validation_page_names_tests_and_their_tolerances():
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    rows = ROW.findall(text)
    assert len(rows) == text.count("| `tests/") > 30
    for tolerance, file, name in rows:
        found = re.search(
            rf"^def {name}\(.*?(?=^(?:def|class|@)|\Z)", (ROOT / file).read_text("utf-8"), re.M | re.S
        )
        assert found, name
        assert re.search(rf"(?<![\d.]){re.escape(tolerance)}\b", found[0]), (name, tolerance)


def test_every_key_of_every_record_is_described():
    keys = import_module(f"{generated().__name__}.keys")
    for _, _, several in keys.PLACES:
        for record in several:
            rows = list(keys.rows(record))
            assert [row[0].strip("`") for row in rows] == list(record.model_fields)
            bare = [
                row[0]
                for row in rows
                if row[0].strip("`") not in keys.meanings(record) and row[0] != "`kind`"
            ]
            assert not bare, (record.__name__, bare)


def test_every_record_that_python_offers_is_on_the_page_of_keys():
    import jointplay

    page = generated().pages()["keys.md"]
    places = jointplay._offered().items()
    offered = {name for name, place in places if place.startswith(".solver.mechanism.records:")}
    assert len(offered) > 25
    assert {name for name in offered - {"TestSystem"} if f"### {name}" not in page} == set()


def test_every_kind_has_a_page_with_a_picture_and_a_study():
    pages = generated().pages()
    for kind in KINDS:
        text = pages[f"kind_{kind}.md"]
        assert "![" in text, f"no picture of a shipped study of kind {kind}: put one into docs/images"
        assert f'kind = "{kind}"' in text


@pytest.mark.parametrize("folder", ["docs/images", "results/paper"])
def test_pictures_are_in_full_colour(folder):
    """A reduced palette merges colours that a map tells apart."""
    modes = {}
    for path in sorted((ROOT / folder).glob("*.png")):
        with Image.open(path) as picture:
            modes[path.name] = picture.mode
    assert len(modes) > 20
    assert {name: mode for name, mode in modes.items() if mode not in ("RGB", "RGBA")} == {}


def test_each_analysis_is_told_once_and_in_a_screen():
    """Each section leads to its kind's own page, of keys and results; `assess` shows what is printed."""
    text = (DOCS / "analyses.md").read_text(encoding="utf-8")
    sections = re.findall(r"^## (\w+)\n\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    elsewhere = {"response", "section", "benchmark", "claims", "readings", "scheme_comparison"}
    assert sorted(name for name, _ in sections) == sorted(set(KINDS) - elsewhere)
    for name, section in sections:
        if name != "assess":
            assert section.startswith(f"[`{name}`](generated/kind_{name}.md) "), name
            assert len(section.split()) <= 330, name


def test_examples_of_generated_pages_validate():
    from jointplay.study.file import validate

    with pytest.raises(InputError):
        validate({"name": "x", "kind": "response"})
    for text in generated().pages().values():
        for study in re.findall(r"```toml\n(.*?)```", text, re.DOTALL):
            validate({"name": "page"} | tomllib.loads(study))


@pytest.mark.long
def test_the_site_is_built_without_a_warning_in_three_minutes(tmp_path):
    pytest.importorskip("sphinx")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", str(DOCS), str(tmp_path)]
    built = subprocess.run(command, timeout=180, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    assert "<math" in (tmp_path / "equations.html").read_text(encoding="utf-8")
