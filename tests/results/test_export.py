"""Results for other programs: every number is there, with its units."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import jointplay as jp
from jointplay import cli
from jointplay.errors import InputError
from jointplay.results.export import export
from tests.support.sweep_samples import CELLS, loaded, ran


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    out = tmp_path_factory.mktemp("export")
    ran(loaded(CELLS), out)
    return jp.open(out / "cells.nc")


def test_matlab_gets_every_variable_and_its_units(sweep, tmp_path):
    found = loadmat(export(sweep, tmp_path / "a.mat"), simplify_cells=True)
    for name in sweep.variables:
        if sweep[name].dtype.kind in "fi":
            assert np.array_equal(found[name], np.squeeze(sweep[name].values), equal_nan=True), name
    assert found["units"]["lyapunov_exponent"] == sweep["lyapunov_exponent"].attrs["units"]
    assert found["dims"]["cell_status"] == "gap restitution"
    assert found["attributes"]["provenance"] == sweep.attrs["provenance"]


def test_a_table_has_names_units_and_a_row_a_cell(sweep, tmp_path):
    path = export(sweep, tmp_path / "a.csv", over=["gap", "restitution", "exponent"])
    names, units, *rows = csv.reader(path.read_text().splitlines())
    assert len(rows) == 6
    at = names.index("lyapunov_exponent")
    assert units[at] == sweep["lyapunov_exponent"].attrs["units"]
    for row in rows:
        told = dict(zip(names, row, strict=True))
        place = {"gap": float(told["gap"]), "restitution": float(told["restitution"])}
        assert float(told["lyapunov_exponent"]) == float(sweep["lyapunov_exponent"].sel(place).item())
        assert int(told["n_steps"]) == int(sweep["n_steps"].sel(place))


def test_a_table_of_histories_has_a_column_a_link(tmp_path):
    motion = jp.simulate(jp.catalog.impact_pair(3.0, 0.8), turns=1)
    names, units, *rows = csv.reader(export(motion, tmp_path / "a.csv").read_text().splitlines())
    assert names[:2] == ["time", "state_value:y"] or {"time", "state_value:y", "state_value:v"} <= set(names)
    assert units[names.index("time")] == "s" or units[names.index("time")] == motion["time"].attrs["units"]
    column = [float(row[names.index("state_value:v")]) for row in rows]
    assert np.array_equal(column, motion["state_value"].sel(state="v").values)


def test_the_command(sweep, tmp_path, capsys):
    source = str(tmp_path / "cells.nc")
    (tmp_path / "cells.nc").write_bytes(Path(sweep.encoding["source"]).read_bytes())
    assert cli.main(["export", source]) == 0
    assert (tmp_path / "cells.mat").exists()
    assert cli.main(["export", source, "--out", str(tmp_path / "b.csv"), "--over", "gap", "restitution"]) == 0
    assert cli.main(["export", source, "--out", str(tmp_path / "b.csv"), "--over", "gpa"]) == 2
    assert "did you mean 'gap'" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"\.mat, \.csv"):
        export(sweep, tmp_path / "b.xls")
