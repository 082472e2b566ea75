"""Results for other programs: every number is there, with its units."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas
import pytest
import xarray as xr
from scipy.io import loadmat

import jointplay as jp
from jointplay import cli
from jointplay.display.errors import InputError
from jointplay.study.results.export import export
from tests.support.sweep_samples import CELLS, loaded, ran

CLAIMS = Path(__file__).parents[2] / "results" / "paper" / "claims.nc"


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    out = tmp_path_factory.mktemp("export")
    ran(loaded(CELLS), out)
    return jp.open(out / "cells.nc")


@pytest.fixture(scope="module")
def motion():
    return jp.simulate(jp.catalog.impact_pair(3.0, 0.8), turns=3)


def test_matlab_gets_every_variable_and_its_units(sweep, tmp_path):
    found = loadmat(export(sweep, tmp_path / "a.mat"), simplify_cells=True)
    for name in sweep.variables:
        if sweep[name].dtype.kind in "fi":
            assert np.array_equal(found[name], np.squeeze(sweep[name].values), equal_nan=True), name
    assert found["units"]["lyapunov_exponent"] == sweep["lyapunov_exponent"].attrs["units"]
    assert found["dims"]["cell_status"] == "gap restitution"
    assert found["attributes"]["provenance"] == sweep.attrs["provenance"]


def read(path):
    """A table with the numbers that stand there; the reader of pandas before 3.1 misses last digits."""
    table = pandas.read_csv(path, dtype=str)
    for name in table:
        with suppress(ValueError):
            table[name] = table[name].map(float)
    return table


@pytest.mark.filterwarnings("ignore::jointplay.ModelWarning")
def test_a_table_has_names_units_and_a_row_a_cell(sweep, tmp_path):
    path = jp.export(sweep, tmp_path / "a.csv", over=["gap", "restitution", "exponent"])
    table = read(path)
    units = sweep["lyapunov_exponent"].attrs["units"]
    assert list(table.columns[:3]) == ["gap", "restitution", "exponent"]
    assert len(table) == 6
    for _, row in table.iterrows():
        place = {"gap": row["gap"], "restitution": row["restitution"]}
        assert row["lyapunov_exponent" + f" [{units}]" * (units != "1")] == float(
            sweep["lyapunov_exponent"].sel(place).item()
        )
        assert row["n_steps"] == int(sweep["n_steps"].sel(place))
        assert row["cell_status"] == "ok"


def test_a_table_of_histories_has_a_column_a_link_and_names_what_is_left_out(motion, tmp_path):
    told = r"not in the table: .*status[^)]* \(not over time\); event_time[^)]*event_kind \(over event\)$"
    with pytest.warns(jp.ModelWarning, match=told):
        table = read(jp.export(motion, tmp_path / "a.csv"))
    assert table.columns[0] in ("time", f"time [{motion['time'].attrs['units']}]")
    assert np.array_equal(table["state_value:v"], motion["state_value"].sel(state="v").values)
    assert table.dtypes.iloc[0].kind == "f"
    with pytest.warns(jp.ModelWarning, match="not in the table: "):
        events = pandas.read_csv(jp.export(motion, tmp_path / "b.csv", over=["event"]))
    assert set(events["event_kind"]) <= {"contact", "separation", "impact"}
    assert len(events) == motion.sizes["event"] > 0


def test_a_result_without_dimensions_makes_no_table(tmp_path):
    claims = jp.open(CLAIMS)
    with pytest.raises(InputError, match="a result with dimensions is accepted for a table"):
        jp.export(claims.drop_dims([*claims.sizes]), tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_a_dimension_with_codes_has_words(tmp_path):
    kinds = {"flag_values": [0, 1], "flag_meanings": "contact impact", "units": "1"}
    found = xr.Dataset({"force": ("kind", [1.5, np.nan], {"units": "N"})}, {"kind": ("kind", [1, 0], kinds)})
    path = jp.export(found, tmp_path / "a.csv")
    assert path.read_bytes() == b"kind,force [N]\r\nimpact,1.5\r\ncontact,nan\r\n"


def test_codes_are_words_in_matlab(motion, tmp_path):
    found = loadmat(jp.export(motion, tmp_path / "a.mat"), simplify_cells=True)
    told = jp.words(motion)
    assert found["words"]["status"] == "ok"
    assert list(np.atleast_1d(found["words"]["event_kind"])) == list(told["event_kind"].values)
    assert found.keys() >= {str(name) for name in motion.variables}
    assert set(found["words"]) == {n for n in motion.variables if "flag_meanings" in motion[n].attrs}


def test_the_command(sweep, tmp_path, capsys):
    source = str(tmp_path / "cells.nc")
    (tmp_path / "cells.nc").write_bytes(Path(sweep.encoding["source"]).read_bytes())
    assert cli.main(["export", source]) == 0
    assert (tmp_path / "cells.mat").exists()
    assert cli.main(["export", source, "--out", str(tmp_path / "b.csv"), "--over", "gap", "restitution"]) == 0
    assert "warning not in the table: " in capsys.readouterr().err
    assert cli.main(["export", source, "--out", str(tmp_path / "b.csv"), "--over", "gpa"]) == 2
    assert "did you mean 'gap'" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"\.mat, \.csv"):
        export(sweep, tmp_path / "b.xls")
