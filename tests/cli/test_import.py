"""Linkages from files of other programs: the study that is written, what is left open, what is refused."""

import json
import math
import re
from pathlib import Path

import pytest

from jointplay.cli import main
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.loops.closure import ideal_state
from jointplay.study.file import load
from jointplay.study.import_file import imported

PAGE = (Path(__file__).parents[2] / "docs" / "study-files.md").read_text(encoding="utf-8")
CSV = re.search(r"```csv\n(.*?)```", PAGE, re.DOTALL)[1]
PAPER = catalog.chunmei2002(clearance=0)
CRANK_ANGLE = 0.7


def four_bar(branch="upper"):
    """The paper's mechanism in mm as pylinkage stores it, drawn at a crank angle."""
    angles, _ = ideal_state(PAPER, CRANK_ANGLE, branch=branch)
    end = {"A": (30 * math.cos(angles["crank"]), 30 * math.sin(angles["crank"]))}
    end["B"] = (200 + 117.5 * math.cos(angles["rocker"]), 117.5 * math.sin(angles["rocker"]))
    middle = [sum(pair) / 2 for pair in zip(end["A"], end["B"], strict=True)]
    return {
        "name": "paper",
        "joints": [
            {"id": "O", "type": "ground", "position": [0.0, 0.0]},
            {"id": "C", "type": "ground", "position": [200.0, 0.0]},
            {"id": "A", "type": "revolute", "position": list(end["A"])},
            {"id": "P", "type": "revolute", "position": middle, "name": "tracer"},
            {"id": "j4", "type": "revolute", "position": list(end["B"]), "name": "B"},
        ],
        "links": [
            {"id": "ground", "type": "ground", "joints": ["O", "C"]},
            {"id": "l2", "type": "link", "joints": ["A", "P", "j4"], "name": "coupler"},
            {"id": "rocker", "type": "link", "joints": ["j4", "C"]},
            {
                "id": "crank",
                "type": "driver",
                "joints": ["O", "A"],
                "angular_velocity": 0.1,
                "motor_joint": "O",
            },
        ],
        "ground": "ground",
    }


def written(tmp_path, data, **options):
    path = tmp_path / "linkage.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return imported(path, **options)


def refused(tmp_path, data, **options):
    with pytest.raises(InputError) as caught:
        written(tmp_path, data, **{"unit": "mm"} | options)
    return {problem.key: problem.expected for problem in caught.value.problems}


def changed(key, index, **changes):
    data = four_bar()
    data[key][index] |= changes
    return data


@pytest.mark.parametrize("branch", ["upper", "lower"])
def test_a_four_bar_of_pylinkage_is_the_same_four_bar(tmp_path, branch):
    text, missing = written(tmp_path, four_bar(branch), unit="mm", bar="0.8 kg/m")
    assert missing == []
    path = tmp_path / "study.toml"
    path.write_text(text)
    record = load(path).record
    mechanism, paper = record.mechanism, {link.name: link for link in PAPER.links}
    assert [link.name for link in mechanism.links] == ["crank", "coupler", "rocker"]
    assert (mechanism.branch, mechanism.crank, mechanism.drive) == (branch, "crank", None)
    for link in mechanism.links:
        assert link.length == pytest.approx(paper[link.name].length, rel=1e-12)
        assert link.mass == pytest.approx(0.8 * link.length, rel=1e-12)
        assert link.inertia == pytest.approx(link.mass * link.length**2 / 3, rel=1e-12)
    drawn = ideal_state(PAPER, CRANK_ANGLE, branch=branch)[0]
    own = ideal_state(mechanism, record.analysis.initial["crank_angle"])[0]
    assert own["crank"] == pytest.approx(drawn["crank"], rel=1e-12)
    assert own["coupler"] == pytest.approx(drawn["coupler"], rel=1e-9)
    assert own["rocker"] == pytest.approx(drawn["rocker"], rel=1e-9)
    assert {joint.name: joint.links for joint in mechanism.joints} == {j.name: j.links for j in PAPER.joints}
    assert "# Points that connect nothing are left out: tracer." in text


def test_what_a_file_does_not_hold_is_left_open_and_named(tmp_path, capsys):
    path, out = tmp_path / "linkage.json", tmp_path / "study.toml"
    path.write_text(json.dumps(four_bar()))
    assert main(["import", str(path), "--unit", "mm", "--out", str(out)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:3] == [
        f"written {out}",
        "fill in mechanism.links[0].mass (crank)",
        "fill in mechanism.links[0].inertia (crank)",
    ]
    text = out.read_text()
    assert not re.search(r"^(mass|inertia|clearance|speed) =", text, re.MULTILINE)
    with pytest.raises(InputError) as caught:
        load(out)
    assert [f"fill in {p.key}" for p in caught.value.problems] == [
        line.partition(" (")[0] for line in said[1:]
    ]
    out.write_text(re.sub(r"# FILL IN: (mass|inertia) = ", r"\1 = 0.1", text))
    assert load(out).record.mechanism.links[2].inertia == 0.1
    assert main(["import", str(path), "--unit", "mm", "--out", str(out)]) == 2
    assert "the name of a file that is not there yet" in capsys.readouterr().err


def test_a_joint_of_three_links_is_two(tmp_path):
    data = four_bar()
    data["joints"] += [{"id": "E", "type": "ground", "position": [90.0, -70.0]}]
    data["joints"] += [{"id": "F", "type": "revolute", "position": [150.0, -60.0]}]
    data["links"] += [{"id": "arm", "type": "link", "joints": ["j4", "F"]}]
    data["links"] += [{"id": "leg", "type": "link", "joints": ["F", "E"]}]
    text, _ = written(tmp_path, data, unit="mm")
    assert text.count('bearing = { link = "coupler"') == 2
    assert 'name = "B_2"' in text
    assert "guess = { " in text  # which way other linkages are assembled


@pytest.mark.parametrize(
    ("data", "key", "said"),
    [
        ("no JSON", "file", "JSON as pylinkage's mechanism_to_json writes it (0.9.0)"),
        ({"name": "old", "joints": [{"type": "Static", "x": 0}]}, "file", "older files of joints alone"),
        (
            changed("joints", 2, type="prismatic"),
            "joints[2].type",
            "no such type of joint that can be taken over",
        ),
        (
            changed("links", 3, type="arc_driver"),
            "links[3].type",
            "no such type of link that can be taken over",
        ),
        (changed("joints", 2, position=[None, None]), "joints[2].position", "two finite numbers"),
        (changed("joints", 2, id="O"), "joints[2].id", "a text that no other has"),
        (
            changed("joints", 3, position=[90.0, 60.0]),
            "links[1].joints",
            "joints at different places in one line",
        ),
        (
            changed("joints", 3, position=[200.0, 0.0]),
            "links[1].joints",
            "joints at different places in one line",
        ),
        (changed("links", 2, joints=["j4", "D"]), "links[2].joints", "no such joint"),
        (changed("links", 2, joints=["j4"]), "links[2].joints", "a list of at least two joints"),
        (changed("links", 2, joints=[["j4"], {}]), "links[2].joints", "a list of at least two joints"),
        (changed("links", 2, name="a\x7fb"), "name", "a name of printable characters"),
        (changed("links", 2, name="coupler"), "links[2].name", "a name that no other link has"),
    ],
)
def test_what_cannot_be_told_is_refused(tmp_path, data, key, said):
    found = refused(tmp_path, data)
    assert said in found[key]


def test_units_that_the_file_does_not_say(tmp_path):
    assert "the file does not say which" in refused(tmp_path, four_bar(), unit=None)["--unit"]
    assert "kg comes to kg and not m" in refused(tmp_path, four_bar(), unit="kg")["--unit"]
    assert "the file does not say which" in refused(tmp_path, four_bar(), unit="3")["--unit"]
    for bar in ("3", "3 kg", "-1 kg/m"):
        assert "a mass per length greater than 0" in refused(tmp_path, four_bar(), bar=bar)["--bar"]
    with pytest.raises(InputError, match=r"file: got 'a\.txt'; a file that ends in \.json"):
        imported("a.txt")


def test_the_table_of_the_docs_is_the_papers_mechanism(tmp_path, capsys):
    path = tmp_path / "paper.csv"
    path.write_text(CSV)
    assert main(["import", str(path)]) == 0
    assert capsys.readouterr().out == f"written {tmp_path / 'paper.toml'}\n"
    assert main(["check", str(tmp_path / "paper.toml")]) == 0
    mechanism = load(tmp_path / "paper.toml").record.mechanism
    plain = {"elastic": False, "beam": PAPER.links[0].beam}
    assert [link.model_copy(update=plain) for link in mechanism.links] == [*PAPER.links]
    assert [(joint.name, joint.journal, joint.bearing) for joint in mechanism.joints] == [
        (joint.name, joint.journal, joint.bearing) for joint in PAPER.joints
    ]


@pytest.mark.parametrize(
    ("change", "key", "said"),
    [
        (("part, name", "prat, name"), "line 1", "a first line that names columns"),
        (("journal_at", "jurnal_at"), "line 1", "no such column: did you mean 'journal_at'?"),
        (("link, rocker", "lnk, rocker"), "line 4, part", "no such part: did you mean 'link'?"),
        (("crank, 30 mm, 0.4489", "crank, , 0.4489"), "line 2, length", "a link needs it"),
        (("200 mm, 0", "200 mm"), "line 8, y", "a joint needs it"),
        (
            ("link, crank, 30 mm, 0.4489, 1.5e-4", "link, crank, 30 mm, 1, 1, coupler"),
            "line 2, journal",
            "of a link",
        ),
        (
            ("rocker, , ground, , 200 mm, 0", "rocker, , ground, , 200 mm, 0, 9"),
            "line 8",
            "no more cells than",
        ),
        (
            ("crank, 30 mm, 0.4489", "crank, 30 kg, 0.4489"),
            "mechanism.links[0].length",
            "kg comes to kg and not m",
        ),
        (
            ("crank, 30 mm, coupler", "crnk, 30 mm, coupler"),
            "mechanism.joints[1].journal.link",
            "no such link",
        ),
    ],
)
def test_a_wrong_table_is_refused_by_its_lines(tmp_path, change, key, said):
    path = tmp_path / "paper.csv"
    assert change[0] in CSV
    path.write_text(CSV.replace(*change))
    with pytest.raises(InputError) as caught:
        imported(path)
    found = {problem.key: str(problem.expected) for problem in caught.value.problems}
    assert said in found[key]


def test_a_table_says_its_units_itself(tmp_path):
    path = tmp_path / "paper.csv"
    path.write_text(CSV)
    with pytest.raises(InputError, match="--unit: got 'mm'; accepted for files of pylinkage"):
        imported(path, "mm")


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_as_spreadsheets_write_it(tmp_path, separator):
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_text(CSV)
    cells = [[cell.strip().replace(".", ",") for cell in line.split(",")] for line in CSV.splitlines()]
    other.write_text("\n".join(separator.join(row) for row in cells))
    assert imported(other)[0].splitlines()[1:] == imported(plain)[0].splitlines()[1:]


@pytest.mark.parametrize("length", ["1e-320", "1e-320 mm", "1e300"])
def test_a_length_that_is_none_is_refused(tmp_path, length):
    path = tmp_path / "paper.csv"
    path.write_text(CSV.replace("crank, 30 mm, 0.4489", f"crank, {length}, 0.4489"))
    with pytest.raises(InputError, match=r"mechanism.links\[0\].length: got"):
        imported(path)


@pytest.mark.parametrize(
    ("suffix", "said"), [("csv", "a table of links and joints"), ("json", "a file of pylinkage")]
)
def test_a_file_in_another_encoding_is_called_what_it_is(tmp_path, suffix, said):
    path = tmp_path / f"latin.{suffix}"
    path.write_bytes("part, name\nlink, Kürbel".encode("latin-1"))
    with pytest.raises(InputError) as caught:
        imported(path)
    (problem,) = caught.value.problems
    assert problem.key == "file"
    assert said in problem.expected
    assert "byte 18 is not UTF-8" in problem.expected
    assert "TOML" not in problem.expected


def test_the_help_has_an_example(capsys):
    with pytest.raises(SystemExit):
        main(["import", "--help"])
    assert "example: jointplay import linkage.json --unit mm" in " ".join(capsys.readouterr().out.split())


PLATE = """part, name, length, mass, inertia, angle, journal, journal_at, bearing, bearing_at, x, y
link, crank, 1, 0.5, 0.4, 0
link, rod, 1, 0.8, 0.4, 90 deg
link, plate, 1, 1.1, 0.5, 0
link, right, 1, 1.4, 0.6, -2.55
link, left, 1, 1.7, 0.7, 2.36
joint, O, , , , , crank, , ground, , 0, 0
joint, A, , , , , crank, 0.1, rod
joint, B, , , , , rod, 0.9, plate
joint, D, , , , , right, 0.7, plate, 0.8
joint, Q, , , , , right, , ground, , 1.4, 1.3
joint, C, , , , , left, 0.7, plate, 0.4
joint, P, , , , , left, , ground, , 0.9, 0.4
"""


def test_rough_angles_in_a_table_say_how_it_is_assembled(tmp_path):
    """A plate on three bars, whose loops close together only; a four-bar's branch."""
    path, out = tmp_path / "plate.csv", tmp_path / "plate.toml"
    path.write_text(PLATE)
    assert main(["import", str(path)]) == 0
    assert 'guess = { "crank" = 0, "rod" = 1.57079633,' in out.read_text()
    assert main(["check", str(out)]) == 0
    assert len(load(out).record.mechanism.guess) == 5
    head, rest = CSV.replace("inertia,", "inertia, angle,").split("joint,", 1)
    rows = (head + "joint," + rest).replace(", , , , ", ", , , , , ")
    for branch, angles in {"upper": ("0.9", "1.6"), "lower": ("-0.9", "-1.6")}.items():
        table = rows.replace("2.7e-3", f"2.7e-3, {angles[0]}").replace("1.34e-3", f"1.34e-3, {angles[1]}")
        path.write_text(table.replace("1.5e-4", "1.5e-4, 0"))
        (tmp_path / "plate.toml").unlink()
        assert main(["import", str(path)]) == 0
        assert f'branch = "{branch}"' in out.read_text()
    path.write_text(PLATE.replace("90 deg", "steep"))
    with pytest.raises(InputError, match="line 3, angle: got 'steep'; a rough angle"):
        imported(path)
