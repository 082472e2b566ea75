"""What the README and the pages of docs/ promise: examples run, studies validate, commands are tested."""

import re
import tomllib
from pathlib import Path

import pytest

from jointplay import kinds
from jointplay.cli import build_parser
from jointplay.figures import KINDS
from jointplay.study.file import validate
from tests.docs.pages import DOCS, PAGES, follow, generated

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
OWN_KIND = "developers.md"  # its study is of a kind that it adds: test_developers runs it


def blocks(text, language):
    """The code blocks of a page in one language."""
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_the_readme_is_short_and_shows_small_pictures():
    assert len(README.split()) <= 750
    pictures = re.findall(r"!\[.+\]\((.+)\)", README)
    assert 1 <= len(pictures) <= 2
    assert all(10_000 < (ROOT / picture).stat().st_size < 300_000 for picture in pictures)


def test_the_two_commands_are_those_that_ci_runs():
    run, test = (block.strip() for block in blocks(README, "sh"))
    assert run == "pip install . && jointplay run studies/quickstart.toml"
    ci = (ROOT / ".ci" / "run").read_text()
    install, check = test.split(" && ")
    assert test in ci
    assert check in ci.splitlines()
    assert install.removeprefix("pip install ") in ci.replace(test, "")


def test_the_python_example_runs(tmp_path, monkeypatch, capsys):
    (example,) = blocks(README, "python")
    assert len(example.splitlines()) <= 8
    short = re.sub(r"\b(turns|transient)=\d+", r"\1=2", example)
    assert short != example
    monkeypatch.chdir(tmp_path)
    exec(compile(short, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert re.match(r"largest exponent of the section map [+\N{MINUS SIGN}].* per turn: \w+\n", said)
    assert {path.name for path in tmp_path.iterdir()} == {"orbit.pdf", "exponents.pdf"}


@pytest.mark.long
def test_who_does_what_the_readme_says_gets_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    follow(ROOT / "README.md", tmp_path, capsys)


@pytest.mark.parametrize("page", [p for p in PAGES if p.name != OWN_KIND], ids=lambda page: page.name)
def test_study_files_on_the_pages_validate(page):
    for text in blocks(page.read_text(encoding="utf-8"), "toml"):
        validate({"name": "page"} | tomllib.loads(text))


def test_every_verb_is_on_the_page_of_commands():
    verbs = next(action for action in build_parser()._actions if action.choices).choices
    page = (DOCS / "commands.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `jointplay (\w+)", page, re.MULTILINE)) == set(verbs)


def test_every_kind_for_users_is_in_the_readme():
    ours = {name for name, row in kinds.KINDS.items() if row.home.startswith(".")}
    assert ours <= set(re.findall(r"`(\w+)`", README))


def test_every_option_of_every_figure_is_on_the_page_of_figures():
    page = generated().pages()["figures.md"]
    for part in page.split("\n## ")[1:]:
        name = part.partition("\n")[0]
        rows = dict(re.findall(r"^\| `(\w+)` \| .* \| (.+) \|$", part, re.MULTILINE))
        assert list(rows) == list(KINDS[name].__wrapped__.__kwdefaults__ or ()), name
    assert set(re.findall(r"^## (\w+)$", page, re.MULTILINE)) == set(KINDS)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page):
    targets = set(re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")))
    missing = {target for target in targets if not (page.parent / target).exists()}
    written = {(ROOT / "docs" / "generated" / name).resolve() for name in generated().pages()}
    assert {(page.parent / target).resolve() for target in missing} <= written
