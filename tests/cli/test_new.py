"""`jointplay new`: studies to begin with are valid, complete, and run."""

import re
import tomllib
from itertools import permutations

import pytest

from jointplay.cli import build_parser, main
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.solver.mechanism import catalog
from jointplay.study.file import load, validate
from jointplay.study.models import ELSEWHERE, TABLES
from jointplay.study.new import names, new
from jointplay.study.toml_text import parse


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_study_of_every_kind_passes_check_and_names_every_key(kind, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", kind]) == 0
    assert capsys.readouterr().out == f"written {kind}.toml\n"
    assert main(["check", f"{kind}.toml"]) == 0
    text = (tmp_path / f"{kind}.toml").read_text()
    keys = set(re.findall(r"^(?:# )?(\w+) =", text, re.M))
    assert keys >= KINDS[kind].function.fields().keys() - {*ELSEWHERE, *TABLES}
    assert ("[tolerances]" in text) == (kind == "tolerances")
    assert "`" not in "".join(re.findall(r"As in `.*", text)), "a reference that a reader cannot follow"


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_new_study_says_of_defaults_is_true(kind):
    text = new(kind, "own")
    assert "\n# " in text
    told = re.sub(r"^# (\w+ = [^#\s].*)$", r"\1", text, flags=re.M)  # as if every default were set
    told = re.sub(r"^# \[vary\].*\nclearance = .*$", "", told, flags=re.M)
    plain = re.sub(r"^kind = .*# \w+ or .*$", "", told, flags=re.M)  # of figures, the usual one
    tables = tomllib.loads(plain)
    assert (
        validate({"name": "own", **tables}).keywords()
        == validate({"name": "own", **tomllib.loads(text)}).keywords()
    )


@pytest.mark.parametrize("name", names())
def test_a_linkage_written_out_is_the_catalogs(name, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(new("response", "own", name))
    record = catalog.NAMES[{"four_bar": "chunmei2002"}.get(name, name)]()
    assert told(load(path).record.mechanism) == told(record)
    assert "catalog" not in path.read_text().replace("jointplay", "")
    assert not re.search(r"\d(0000|9999)\d{8}", path.read_text())  # 0.00019750000000000003


@pytest.mark.parametrize("words", [*permutations(["response", "own.toml", "--mechanism=watt"])], ids=" ".join)
def test_arguments_stand_in_any_order(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    apart = [part for word in words for part in word.split("=")]
    assert main(["new", *apart]) == 0
    assert (tmp_path / "own.toml").read_text() == new("response", "own", "watt")


def comments(text):
    """Table, key and comment of each line that sets a key, or shows its default."""
    table, above = "", []
    for line in text.splitlines():
        head = re.match(r"(?:# )?\[+([\w.]+)", line)
        if key := re.match(r"(?:# )?(\w+) =", line):
            *_, beside = re.split(r" # (?=[A-ZΑ-Ωa-zα-ω])", line[2:])
            yield table, key[1], " ".join([*above, *([beside] if beside != line[2:] else [])])
        elif head:
            table = head[1]
        above = [*above, line[2:].strip()] if line[:2] == "# " and not key and not head else []


@pytest.mark.parametrize(
    "text", [*(new(kind, "own") for kind in KINDS), *(new("response", "own", name) for name in names())]
)
def test_each_key_has_a_comment_of_its_own_that_fits_on_the_page(text):
    body, about = text.partition("[mechanism]")[2], {}
    for table, key, comment in comments(body):
        if (table, key) in about and not comment:
            continue  # of a further link or joint
        assert comment, (table, key)
        assert not re.search(r"As in|see `[A-Z]", comment), (key, comment)
        other = "instead" * comment.startswith("Instead of")  # another form of what has been said
        assert about.setdefault((table, key + other), comment) == comment
    assert len({*about.values()}) == len(about)
    assert all(len(line) <= 110 for line in text.splitlines() if line.startswith("#") and " = " not in line)


def test_numbers_are_written_as_a_person_writes_them():
    text = new("response", "own", "four_bar")
    assert 'length = "117.5 mm"' in text
    assert 'clearance = "0.029 mm"' in text
    assert 'synchronous_speed = "3000 rpm"' in text
    assert "stiffness = 7.15e6, damping = 228 }" in text
    for kind in KINDS:
        assert not re.search(r"\de[-+]0\d|\d\.0\b|\d{7}", new(kind, "own"))


def told(record):
    """A record with its numbers to 14 digits: files say 15."""
    return re.sub(r"\d+\.\d+(e-?\d+)?", lambda number: f"{float(number[0]):.14g}", record.model_dump_json())


@pytest.mark.parametrize("name", ["four_bar", "slider_crank"])
def test_other_forms_that_a_new_study_shows_are_accepted_in_the_place_of_numbers(name):
    text = new("response", "own", name)
    table = parse(text)
    links, joints = (table["mechanism"][each] for each in ("links", "joints"))
    loose = next(joint for joint in joints if joint.get("clearance"))
    replaced = {"shape": (links[0], ("mass", "centre", "inertia", "inertia_centre"))}
    replaced |= {"fit": (loose, ("clearance",)), "contact": (loose, ("contact", "friction"))}
    shown = re.findall("^# (shape|fit|contact) = (.*?)(?: +#.*)?$", text, re.MULTILINE)
    assert [key for key, _ in shown] == [*replaced]
    for key, value in shown:
        part, keys = replaced[key]
        for each in keys:
            part.pop(each, None)
        part |= parse(f"{key} = {value}")
    mechanism = validate({"name": "own"} | table).mechanism
    assert mechanism.links[0].shape.bar.thickness == 6e-3
    assert (found := mechanism.joint(loose["name"])).fit == "H7/f7"
    assert set(found.sources.values()) == {"from pin and bush"}


def test_nothing_is_written_over_and_wrong_names_are_told(tmp_path, capsys):
    path = tmp_path / "own.toml"
    path.write_text("mine")
    for words, said in (
        (["response", path], "not there yet"),
        (["responce"], "did you mean 'response'?"),
        (["response", tmp_path / "own.txt"], "ends in .toml"),
        (["response", tmp_path / "x.toml", "--mechanism", "slidercrank"], "did you mean 'slider_crank'?"),
        (["stress", tmp_path / "x.toml", "--mechanism", "watt"], "the example of a stress does not suit it"),
    ):
        assert main(["new", *map(str, words)]) == 2
        assert said in capsys.readouterr().err
    assert path.read_text() == "mine"
    assert [each.name for each in tmp_path.iterdir()] == ["own.toml"]


def test_the_help_of_every_verb_has_an_example_that_it_can_parse():
    parser = build_parser()
    verbs = parser._subparsers._group_actions[0].choices
    for name, verb in verbs.items():
        words = re.sub(" >.*", "", verb.epilog.removeprefix("example: jointplay ")).split()
        assert words[0] == name
        assert parser.parse_args([word.strip("'") for word in words if word != "kg/m'"]).verb


@pytest.mark.nightly
@pytest.mark.parametrize("kind", KINDS)
def test_a_new_study_runs_to_its_answer(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", kind]) == 0
    assert main(["run", f"{kind}.toml"]) == 0
    assert (tmp_path / "results" / f"{kind}.nc").exists()
    assert capsys.readouterr().out.splitlines()[-1].strip()


@pytest.mark.nightly
@pytest.mark.parametrize("name", names())
def test_a_linkage_written_out_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "response", "--mechanism", name]) == 0
    assert main(["run", "response.toml"]) == 0


def test_an_example_that_does_not_suit_the_kind_is_no_study(monkeypatch):
    monkeypatch.setitem(KINDS["response"].example["analysis"], "turns", -1)
    with pytest.raises(InputError, match=r"analysis\.turns"):
        new("response", "own")
