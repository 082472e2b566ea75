"""Answers of the laboratory's kinds: on the stored results of the paper, and on a table made by hand."""

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay_lab.precision.work_precision import answer
from tests.study.test_readme import ROOT


@pytest.mark.parametrize("name", ["claims", "readings", "scheme_comparison"])
def test_answers_count_what_the_result_holds(name):
    found = jp.open(ROOT / "results" / "paper" / f"{name}.nc")
    lines = jp.summary(found).lines
    if name == "claims":
        assert lines == ("conclusions of the paper: 4 partly reproduced",)
        assert set(jp.words(found).grade.values) == {"partly"}
    elif name == "readings":
        motions = jp.words(found).motion
        assert len(lines) == 3
        assert f"{int((motions.sel(panel='c') == 'chaotic').sum())} chaotic" in lines[2]
    else:
        settled = int(found.converged.any("windows_per_turn").sum())
        assert lines[0] == f"the scheme's passes settle in {settled} of {found.sizes['case']} cases"


def test_the_fastest_solver_at_each_error():
    times = ("solver", "error_level"), [[0.002, np.nan], [0.001, 0.004]]
    coords = {"solver": ["ours", "LSODA"], "error_level": [1e-6, 1e-9]}
    table = xr.Dataset(
        {"cpu_time_at_error": times, "truth_confirmed": 1}, coords, {"truth_confirmed_by": "x"}
    )
    assert answer(table).splitlines() == [
        "at an error of 1 × 10⁻⁶: LSODA, 1 ms per turn",
        "the truth is confirmed by x",
    ]
