"""Linkages from tables of links and joints: the study that is written, what is left open, what is refused."""

import re
from pathlib import Path

import pytest

from jointplay.cli import main
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.study.file import load
from jointplay.study.import_file import imported
from tests.support.wrong import refused

PAGE = (Path(__file__).parents[2] / "docs" / "how-to" / "from-cad.md").read_text(encoding="utf-8")
CSV = re.search(r"```csv\n(.*?)```", PAGE, re.DOTALL)[1]
PAPER = catalog.chunmei2002(clearance=0)


def written(tmp_path, text, **options):
    path = tmp_path / "linkage.csv"
    path.write_text(text)
    return imported(path, **options)


def without_mass(text):
    return re.sub(r"^(link, .*), [\d.]+, [\d.e-]+$", r"\1", text, flags=re.MULTILINE)


def test_links_without_mass_are_uniform_bars(tmp_path):
    text, missing = written(tmp_path, without_mass(CSV), bar="0.8 kg/m")
    assert missing == []
    path = tmp_path / "study.toml"
    path.write_text(text)
    mechanism = load(path).record.mechanism
    assert [link.name for link in mechanism.links] == ["crank", "coupler", "rocker"]
    assert (mechanism.crank, mechanism.drive) == ("crank", None)
    for link, paper in zip(mechanism.links, PAPER.links, strict=True):
        assert link.length == pytest.approx(paper.length, rel=1e-12)
        assert link.mass == pytest.approx(0.8 * link.length, rel=1e-12)
        assert link.inertia == pytest.approx(link.mass * link.length**2 / 3, rel=1e-12)


def test_what_a_table_does_not_hold_is_left_open_and_named(tmp_path, capsys):
    path, out = tmp_path / "linkage.csv", tmp_path / "study.toml"
    path.write_text(without_mass(CSV))
    assert main(["import", str(path), "--out", str(out)]) == 0
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
    assert main(["import", str(path), "--out", str(out)]) == 2
    assert "the name of a file that is not there yet" in capsys.readouterr().err


def test_a_wrong_file_or_bar_is_refused(tmp_path):
    for bar in ("3", "3 kg", "-1 kg/m"):
        with pytest.raises(InputError, match="a mass per length greater than 0"):
            written(tmp_path, CSV, bar=bar)
    with pytest.raises(InputError, match=r"file: got 'a\.json'; a file that ends in \.csv"):
        imported("a.json")
    with pytest.raises(InputError, match=r"name: got .*; a name of printable characters"):
        written(tmp_path, CSV.replace("coupler", "a\x7fb"))


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
        (("journal_at", "jurnal_at"), "line 1", "no such column; did you mean 'journal_at'?"),
        (("link, rocker", "lnk, rocker"), "line 4, part", "no such part; did you mean 'link'?"),
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
            "kg does not convert to m",
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
    found = refused(imported, path)
    assert said in found[key]


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


def test_a_file_in_another_encoding_is_called_what_it_is(tmp_path):
    path = tmp_path / "latin.csv"
    path.write_bytes("part, name\nlink, Kürbel".encode("latin-1"))
    with pytest.raises(InputError) as caught:
        imported(path)
    (problem,) = caught.value.problems
    assert problem.key == "file"
    assert "a table of links and joints" in problem.expected
    assert "byte 18 is not UTF-8" in problem.expected
    assert "TOML" not in problem.expected


def test_the_help_has_an_example(capsys):
    with pytest.raises(SystemExit):
        main(["import", "--help"])
    assert "example: jointplay import linkage.csv --bar" in " ".join(capsys.readouterr().out.split())


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
