"""Wrong input from end to end: exit 2, the key path, the value, what is accepted, and never a traceback."""

import pytest

from jointplay.cli import main
from tests.support.program import jointplay
from tests.support.study_samples import BENT, BENT_WRITTEN_OUT, TEXT, WRITTEN_OUT

NO_CLEARANCE = TEXT.replace("clearance = 2.9e-4", "clearance = 0")
STARTED_AT_B = WRITTEN_OUT + 'section = { kind = "contact", joint = "B" }\n'

CASES = {  # text, change, words that must be said
    "wrong type": (TEXT, "analysis.turns='two'", "analysis.turns: got 'two'; a number greater than 0"),
    "unknown key": (
        TEXT,
        "mechanism.clearence=1e-4",
        "mechanism.clearence: got 0.0001; there is no such key; did you mean 'clearance'? These are accepted",
    ),
    "negative mass": (
        WRITTEN_OUT,
        "mechanism.links[0].mass=-1",
        "mechanism.links[0].mass: got -1; a mass greater than 0 kg is accepted",
    ),
    "clearance 0 in a figure": (
        NO_CLEARANCE,
        "name=a",
        "figure.joint: got 'B'; there is no such joint with clearance",
    ),
    "clearance 0 in a section": (
        STARTED_AT_B,
        "mechanism.joints[2].clearance=0",
        "analysis.section.joint: got 'B'; joint B is ideal (clearance 0)",
    ),
    "no closure": (
        WRITTEN_OUT,
        "mechanism.joints[3].bearing.point=[2.0, 0]",
        "distances between pins (m) that can close",
    ),
    "not positive definite": (
        WRITTEN_OUT,
        "mechanism.links[1].inertia=1e-6",
        "mechanism.links[1].inertia: got 1e-6; a moment of inertia about the link's origin greater than",
    ),
    "no such link": (
        TEXT,
        "mechanism.elastic=['copler']",
        "mechanism.elastic[0]: got 'copler'; there is no such link; did you mean 'coupler'? These",
    ),
    "elements of zero length": (BENT, "mechanism.elements=0", "mechanism.elements: got 0; a whole number of"),
    "more than critical damping": (
        BENT,
        "mechanism.damping_ratio=1.5",
        "a damping ratio from 0 to 1 (critical",
    ),
    "order without a beam": (TEXT, "mechanism.order='paper'", "accepted only where a link is elastic"),
    "a beam too heavy": (
        BENT_WRITTEN_OUT,
        "mechanism.links[1].beam.area=2e-4",
        "mechanism.links[1].beam.area: got 0.0002; an area less than 0.000133748 m²",
    ),
    "modes beyond the elements": (
        BENT_WRITTEN_OUT,
        "mechanism.links[1].beam.modes=5",
        "mechanism.links[1].beam.modes: got 5; at most 4 modes, two an element, are accepted",
    ),
    "a pin within a beam": (
        BENT_WRITTEN_OUT,
        "mechanism.joints[2].journal.at=0.1",
        "mechanism.joints[2].journal.at: got 0.1; a distance along the link of 0 or 0.181 m",
    ),
    "NaN": (TEXT, "mechanism.gear_ratio=nan", "mechanism.gear_ratio: got nan; a finite gear ratio"),
    "infinite": (TEXT, "integrator.rtol=inf", "integrator.rtol: got inf; a number of at least 1e-14 and"),
    "no such variable": (TEXT, "analysis.record=['normal_forse']", "did you mean 'normal_force'?"),
    "not recorded": (
        TEXT,
        "analysis.record=['normal_force']",
        "normal_velocity too: the figure overview draws them",
    ),
    "a window of no turns": (TEXT, "figure.turns=0", "figure.turns: got 0; a number of turns greater than 0"),
    "not TOML": ("kind = \n", "name=a", "study file: got 'kind ='; valid TOML is accepted;"),
}


@pytest.mark.parametrize(("text", "change", "said"), CASES.values(), ids=CASES.keys())
def test_wrong_input_is_refused_with_its_place(text, change, said, tmp_path, capsys):
    (tmp_path / "a.toml").write_text(text)
    words = ["run", tmp_path / "a.toml", "--out", tmp_path / "out", "--set", change]
    assert main([str(word) for word in words]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_everything_wrong_is_said_at_once(tmp_path):
    (tmp_path / "a.toml").write_text(WRITTEN_OUT)
    changes = ["mechanism.links[0].mass=-1", "mechanism.links[1].lenght=3", "integrator.rtol=nan", "nmae=1"]
    done = jointplay("check", tmp_path / "a.toml", "--set", *changes)
    assert done.returncode == 2
    assert "wrong input, 4 problems:" in done.stderr
    keys = [change.partition("=")[0] for change in changes]
    assert all(f"  {key}: got " in done.stderr for key in keys), done.stderr


def test_a_folder_that_cannot_be_written_is_refused_before_any_work(tmp_path):
    (tmp_path / "a.toml").write_text(TEXT)
    (tmp_path / "file").write_text("")
    done = jointplay("run", tmp_path / "a.toml", "--out", tmp_path / "file" / "out")
    assert done.returncode == 2
    assert "--out: got " in done.stderr
    assert "a folder in which files can be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_study_file_in_place_of_its_result_and_a_misspelt_verb_are_told_as_that(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(TEXT)
    assert main(["animate", str(path)]) == 2
    said = capsys.readouterr().err
    assert "that `jointplay run` wrote is accepted; this is a study file, to be run first" in said
    assert main(["check", str(tmp_path / "nope.toml")]) == 2
    assert "the name of a study file (TOML, UTF-8) is accepted; no such file" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["asses", str(path)])
    assert capsys.readouterr().err.endswith("; did you mean 'assess'?\n")
