"""Pictures of whole sweeps from study files: what is drawn of itself, what is refused before a run."""

import pytest

from jointplay import cli
from jointplay import open as opened
from tests.support.sweep_samples import CELLS

ONE = CELLS.replace("restitution = [0.7, 0.8]\n", "")


def said(capsys, *words):
    code = cli.main(list(map(str, words)))
    out, err = capsys.readouterr()
    return code, out + err


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "cells.toml"
    path.write_text(ONE)
    return path


@pytest.mark.long
def test_a_run_draws_the_usual_number_of_each_cell_and_says_which(study, tmp_path, capsys):
    code, words = said(capsys, "run", study, "--out", tmp_path, "--jobs", 1)
    assert code == 0
    assert "section_exponent_per_turn of each cell" in words
    assert (tmp_path / "cells.png").stat().st_size > 10_000
    (tmp_path / "cells.pdf").unlink()
    code, words = said(
        capsys,
        "run",
        study,
        "--out",
        tmp_path,
        "--jobs",
        1,
        "--set",
        "figure.kind=lyapunov",
        "figure.per=turn",
    )
    assert code == 0
    assert "none of the whole sweep" in words  # the picture asked for is that of one cell
    assert not (tmp_path / "cells.pdf").exists()
    assert opened(tmp_path / "cells.nc").attrs["swept"] == "gap"
    options = ["quantity=n_steps", "along=gap"]
    code, _ = said(capsys, "figure", tmp_path / "cells.nc", "--kind", "sweep", "--set", *options)
    assert code == 0
    assert (tmp_path / "cells_sweep.pdf").exists()
    assert not (tmp_path / "cells.pdf").exists()  # the place of the picture that the study asks for


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        (
            ["figure.kind=sweep", "figure.along=gup"],
            "figure.along: got 'gup'; there is no such varied parameter;",
        ),
        (["figure.kind=sweep", "figure.at=2"], "figure.at: got 2; a table"),
        (["figure.kind=sweep", "figure.per=turn"], "figure.per: got 'turn'; there is no such option;"),
        (
            ["kind=section", "figure.kind=sweep"],
            "figure.quantity: got nothing; the name of a variable is needed",
        ),
        (["kind=bifurcation", "figure.kind=sweep"], "figure.kind: got 'sweep'; for this bifurcation one of"),
        (["vary={}", "figure.kind=sweep"], "figure.kind: got 'sweep'; for this lyapunov one of lyapunov is"),
    ],
)
def test_a_picture_that_the_sweep_cannot_have_is_refused_at_once(study, capsys, changes, key):
    code, words = said(capsys, "check", study, "--set", *changes)
    assert code == 2
    assert key in words


@pytest.mark.parametrize("number", [0, 9, 1.5, '"all"'])
def test_a_motion_that_no_sweep_of_so_many_starts_can_have_is_refused_at_once(study, capsys, number):
    region = "analysis={ region = { y = [-1, 1], v = [0, 1] }, starts = 8, steps = 2, turns = 16 }"
    changes = ["kind=tipping", 'mechanism={ catalog = "duffing" }', "vary={ damping = [0.2, 0.25] }", region]
    for given, code in ((number, 2), (8, 0), ('"largest"', 0)):
        told = said(
            capsys,
            "check",
            study,
            "--set",
            *changes,
            f"figure={{ kind = 'sweep', at = {{ number = {given} }} }}",
        )
        assert told[0] == code, told
        assert ("from 1 to 8, that of the starts, or 'largest' is accepted" in told[1]) == (code == 2)


def test_of_branches_and_orbits_the_whole_sweep_is_accepted(study, capsys):
    orbits = ["kind=periodic_orbit", "analysis={ transient = 1 }", "figure.kind=sweep"]
    assert said(capsys, "check", study, "--set", *orbits)[0] == 0
    branches = [
        "kind=continuation",
        'analysis={ parameter = "gap", range = [2.8, 3.2] }',
        "figure.kind=sweep",
    ]
    assert "figure.quantity" in said(capsys, "check", study, "--set", *branches)[1]
    assert said(capsys, "check", study, "--set", *branches, "figure.quantity=wall_time")[0] == 0
