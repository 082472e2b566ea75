"""Code blocks, references to tests, and pages that are written from the code."""

import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
from PIL import Image

from jointplay.cli import build_parser
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from tests.docs.pages import DOCS, PAGES, ROOT, alike, blocks, commands, follow, generated, unfounded

ROW = re.compile(r"^\|.*\| ([\d.e-]+) \| `(tests/[\w/]+\.py)::(\w+)` \|$", re.MULTILINE)
EXAMPLES = {"README.md": "tests/study/test_readme.py", "developers.md": "tests/study/test_developers.py"}
FOLLOWED = (  # pages that are done as they say
    "tutorial.md",
    "how-to/rattling-speed.md",
    "how-to/from-cad.md",
    "how-to/choose-stiffness.md",
    "how-to/compare-laws.md",
    "how-to/own-law.md",
    "how-to/own-oscillator.md",
    "how-to/on-a-cluster.md",
    "how-to/paper-diagram.md",
    "how-to/change-figure.md",
    "how-to/other-programs.md",
)
TOO = ("stiffness.md",)  # whose sentences have numbers of other sources
WORDS = {  # of a page at most, with its tables and code: what tables of keys say is said there alone
    "study-files": 3200,
    "validation": 3105,
    "developers": 2770,
    "benchmarks": 2280,
    "model": 2090,
    "integrator": 2030,
    "analyses": 1900,
    "paper": 1420,
    "testing": 1500,
    "laws": 1330,
    "sweeps": 1230,
    "tutorial": 1050,
    "findings": 1040,
    "own-equations": 995,
    "friction-laws": 870,
    "troubles": 825,
    "stiffness": 750,
    "equations": 730,
    "report": 700,
    "glossary": 530,
    "index": 420,
    "commands": 415,
    "policy": 350,
    "reference": 270,
    "api": 80,
    "notebooks": 60,
    "how-to/index": 100,
} | {name.removesuffix(".md"): 300 for name in FOLLOWED if name.startswith("how-to/")}


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


def test_every_how_to_is_followed_and_listed():
    names = {path.relative_to(DOCS).as_posix() for path in DOCS.glob("how-to/*.md")} - {"how-to/index.md"}
    assert names == {*FOLLOWED} - {"tutorial.md"}
    index = (DOCS / "how-to" / "index.md").read_text(encoding="utf-8")
    assert {f"how-to/{name}" for name in re.findall(r"\]\(([\w-]+\.md)\)", index)} == names


def test_every_page_with_python_is_run_by_some_test():
    with_code = {page.name for page in PAGES if any(block.language == "python" for block in blocks(page))}
    assert with_code <= {"api.md", *EXAMPLES, *(Path(name).name for name in FOLLOWED + TOO)}


def test_another_number_or_word_is_not_alike():
    assert alike("contact B 135 N: stable", "contact B 135 N: stable")
    assert not alike("contact B 136 N: stable", "contact B 135 N: stable")
    assert not alike("contact B 135 N: chaotic", "contact B 135 N: stable")
    assert alike("exponent +1.70 ± 0.03", "exponent +1.66 ± 0.02")
    assert not alike("exponent +1.90 ± 0.03", "exponent +1.66 ± 0.02")
    assert not alike("exponent +1.66 ± 0.20", "exponent +1.66 ± 0.02")


@pytest.mark.parametrize("name", FOLLOWED + TOO)
def test_who_does_what_a_page_says_gets_what_it_says(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SLURM_ARRAY_TASK_ID", "1")
    follow(DOCS / name, tmp_path, capsys)


@pytest.mark.parametrize("name", FOLLOWED)
def test_numbers_of_its_sentences_are_those_of_its_blocks(name):
    assert unfounded(DOCS / name) == []


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


def test_marks_of_numbers_are_not_on_the_site():
    """Markdown would take a line that begins with one as HTML, and end its paragraph there."""
    unmarked = import_module(f"{generated().__name__}.text").unmarked
    assert unmarked("at\n<!--=a.b_1-->5.3<!--/--> µm") == "at\n5.3 µm"
    assert not re.search("<!--[=/]", "".join(unmarked(page.read_text(encoding="utf-8")) for page in PAGES))


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
        text = pages[f"kind_{kind}.inc"]
        assert "![" in text, f"no picture of a shipped study of kind {kind}: put one into docs/images"
        assert f'kind = "{kind}"' in text


def test_every_picture_of_the_gallery_has_a_sentence():
    kinds, gallery = (import_module(f"{generated().__name__}.{name}") for name in ("kinds", "gallery"))
    assert {path.stem for path in kinds.studies() if kinds.picture(path)} == set(gallery.SEEN)
    page = generated().pages()["gallery.md"]
    assert page.count("```{image}") == page.count("*What you see:* ") == len(gallery.SEEN)


@pytest.mark.parametrize("folder", ["docs/images", "results/paper"])
def test_pictures_are_in_full_colour(folder):
    """A reduced palette merges colours that a map tells apart."""
    modes = {}
    for path in sorted((ROOT / folder).glob("*.png")):
        with Image.open(path) as picture:
            modes[path.name] = picture.mode
    assert len(modes) > 20
    assert {name: mode for name, mode in modes.items() if mode not in ("RGB", "RGBA")} == {}


def test_each_kind_is_told_once_and_in_a_screen():
    """A text, and below it what is written from the code: no kind is forgotten."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "kinds").glob("*.md")}
    ours = {name for name, row in KINDS.items() if row.home.partition(".")[0] in ("", "jointplay_lab")}
    assert texts.keys() == ours
    for name, text in texts.items():
        assert text.startswith(f"# {name}\n\n")
        assert text.endswith(f"\n\n```{{include}} ../generated/kind_{name}.inc\n```\n")
        assert 20 < len(text.split()) <= 300, name
    assert sum(len(text.split()) for text in texts.values()) <= 155 * len(texts)


def test_a_kind_of_another_package_has_a_page_too(monkeypatch):
    from dataclasses import replace

    kinds = import_module(f"{generated().__name__}.kinds")
    monkeypatch.setitem(KINDS, "others", replace(KINDS["dimension"], name="others"))
    pages = generated().pages()
    assert pages["kind_others.md"].startswith("# others\n\n")
    assert "```{include} kind_others.inc\n```" in pages["kind_others.md"]
    assert "`shares`" in pages["kind_others.inc"]
    assert "\nkind_others\n" in pages["kinds.md"]
    assert "\n../kinds/dimension\n" in pages["kinds.md"]
    assert kinds.place("dimension") == "../kinds/dimension.md"


def test_every_public_name_is_on_one_page_of_the_interface():
    import jointplay

    pages = {name: text for name, text in generated().pages().items() if name.startswith("api_")}
    names = re.findall(
        r"^\.\. auto(?:class|function|exception):: jointplay\.(\w+)$", "".join(pages.values()), re.M
    )
    assert sorted(names) == sorted({*jointplay.__all__} - {"__version__", "catalog"})
    assert "jointplay.simulate\n" in pages["api_simulate.md"]
    assert "jointplay.Mechanism.replace\n" in pages["api_mechanism.md"]
    assert "api_others.md" not in pages, "a name of this package has no task"


def test_references_of_a_kind_are_on_its_page():
    pages = generated().pages()
    for name, row in KINDS.items():
        cited = pages[f"kind_{name}.inc"].partition("## References\n")[2]
        assert cited.count("\n- ") == len(row.references or ()), name
    assert "Ginelli" in pages["kind_covariant.inc"]


def test_no_key_is_told_by_the_name_of_another_analysis():
    pages = generated().pages()
    rows = "".join(text for name, text in pages.items() if name.startswith(("kind_", "catalog")))
    assert not re.findall(r"^\|.*\| as in .*$", rows, re.MULTILINE | re.IGNORECASE)
    shared = re.search(r"^\| `tolerance` .*\| (.*) \|$", pages["kind_periodic_orbit.inc"], re.MULTILINE)[1]
    assert f"| Of the first orbit: {shared} |" in pages["kind_continuation.inc"]


def test_every_recorded_quantity_is_on_the_page_of_keys():
    from jointplay.analysis.quantities import WORDS as QUANTITIES

    part = generated().pages()["keys.md"].partition("## Recorded quantities")[2]
    assert re.findall(r"^\| `(\w+)` \|", part, re.MULTILINE) == list(QUANTITIES)


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
    assert "<!--=" not in (tmp_path / "findings.html").read_text(encoding="utf-8")
