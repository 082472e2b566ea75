"""What is probably meant in another unit: one line of warning for each, before anything is computed."""

import xarray as xr

from jointplay.cli import main
from tests.support.study_samples import TEXT

RPM = "analysis.initial.crank_speed=1500"


def test_every_verb_that_reads_a_study_warns(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(TEXT)
    for verb in ("check", "plan"):
        assert main([verb, str(path), "--set", RPM]) == 0
        assert capsys.readouterr().err.startswith(
            "warning analysis.initial.crank_speed: got 1500.0; 1500 rad/s are 14324 rpm, "
            "17.9 times what the drive turns at; if 1500 rpm are meant, write '1500 rpm' or 157.08\n"
        )
    assert main(["check", str(path), "--set", "analysis.initial.crank_speed=1500 rpm"]) == 0
    assert capsys.readouterr().err == ""


def test_what_varies_is_doubted_too_and_a_result_keeps_it(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(TEXT + "[vary]\nclearance = [1e-4, 4e-3]\n")
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().err
    assert said.startswith(
        "warning mechanism.joints[2].clearance: got 0.004; that is 0.13 of the shortest link"
    )
    path.write_text(TEXT)
    short = ["--set", RPM, "analysis.turns=0.01", "--no-figure", "--out", str(tmp_path)]
    main(["run", str(path), *short])
    with xr.open_dataset(tmp_path / "a.nc") as result:
        assert result.attrs["doubts"].startswith("analysis.initial.crank_speed: got 1500.0;")
    assert capsys.readouterr().err.count("14324 rpm") == 1


def test_what_varies_nothing_is_doubted_and_whose_clearance_varies_is_said(tmp_path, capsys):
    """With play at C alone, the contact of B is nowhere, and the word `clearance` is B's."""
    path = tmp_path / "a.toml"
    text = TEXT.partition("[figure]")[0].replace("clearance = 2.9e-4", "clearance = { C = 2.9e-4 }")
    path.write_text(text)
    assert main(["check", str(path), "--set", "vary.joints.B.contact.stiffness=[1e7, 2e7]"]) == 0
    assert "vary.joints.B.contact.stiffness: got [1" in (said := capsys.readouterr().err)
    assert "nothing varies" in said
    assert main(["check", str(path), "--set", "vary.joints.C.contact.stiffness=[1e7, 2e7]"]) == 0
    assert "nothing varies" not in capsys.readouterr().err
    assert main(["check", str(path), "--set", "vary.clearance=[1e-4, 2e-4]"]) == 0
    assert "varies     clearance of joint B (none at C), 2 values" in capsys.readouterr().out


def test_a_crank_that_needs_no_whole_turn_is_not_doubted(tmp_path, capsys):
    """A profile that turns it by 3 deg, of a loop that does not close all round."""
    drive = 'drive = { kind = "profile", link = "crank", start = 0.0, end = 1.0, time = 0.1 }\n'
    sizes = "crank = 0.1\nrod = 0.12\noffset = 0.05\nclearance = 0\n"
    path, head = tmp_path / "a.toml", 'kind = "response"\n[vary]\ngravity = [1.0, 9.8]\n'
    path.write_text(
        f'{head}[mechanism]\ncatalog = "slider_crank"\n{sizes}{drive}[analysis]\nduration = 0.1\n'
    )
    assert main(["check", str(path)]) == 0
    assert "cells fail" not in capsys.readouterr().err
