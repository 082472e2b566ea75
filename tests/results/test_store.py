"""Result files: whole or not at all, and the same for the same data."""

import os
import time

import netCDF4
import numpy as np
import pytest
import xarray as xr

from jointplay.display.errors import InputError
from jointplay.study.results import store
from tests.support.program import ended_process


@pytest.fixture
def dataset():
    rng = np.random.default_rng(1)
    force = rng.normal(size=(2000, 1))
    force[3] = np.nan
    return xr.Dataset(
        {
            "normal_force": (("time", "joint"), force, {"units": "N", "long_name": "normal force"}),
            "mode": (
                ("time", "joint"),
                np.ones((2000, 1), np.int8),
                {"flag_values": np.arange(6, dtype=np.int8)},
            ),
            "status": ((), np.int8(0), {"flag_values": np.arange(8, dtype=np.int8)}),
        },
        coords={"time": ("time", np.linspace(0, 1, 2000), {"units": "s"}), "joint": ["B"]},
        attrs={"title": "a test"},
    )


def test_what_is_written_is_what_is_read(dataset, tmp_path):
    path = store.write_result(dataset, tmp_path / "r.nc")
    back = store.open_result(path)
    xr.testing.assert_identical(back, dataset)
    assert back["mode"].dtype == np.int8
    with netCDF4.Dataset(path) as plain:
        assert np.isnan(plain["normal_force"].getncattr("_FillValue"))
        assert not any("_FillValue" in plain[name].ncattrs() for name in ("time", "mode", "status"))


def test_it_is_written_as_xarray_itself_would(dataset, tmp_path):
    """Types, attributes, compression, and texts, flags, empty dimensions and coordinates beside them."""
    more = {
        "name": ((), "one"),
        "names": ("joint", np.array(["a longer text"])),
        "stable": ("joint", np.array([True])),
        "none": ("turn", np.zeros(0)),
        "gain": (("joint", "time"), np.ones((1, 2000), np.float32), {"list": ["a", "b"], "n": np.int16(3)}),
    }
    whole = dataset.assign(more).assign_coords(level=("time", np.arange(2000)))
    store.write_result(whole, tmp_path / "ours.nc")
    large = {name for name, v in whole.variables.items() if v.size >= 1024}
    form = {
        name: {"zlib": name in large} | ({"_FillValue": None} if name == "time" else {})
        for name in whole.variables
    }
    whole.to_netcdf(tmp_path / "theirs.nc", engine="netcdf4", encoding=form)
    with netCDF4.Dataset(tmp_path / "ours.nc") as ours, netCDF4.Dataset(tmp_path / "theirs.nc") as theirs:
        assert list(ours.variables) == list(theirs.variables)
        assert repr(ours.dimensions) == repr(theirs.dimensions)
        assert ours.ncattrs() == theirs.ncattrs()
        for name, mine in ours.variables.items():
            other = theirs[name]
            assert repr(mine) == repr(other)
            if mine.dtype is not str:
                assert mine.filters() == other.filters()
            np.testing.assert_array_equal(mine[...], other[...])
    assert store.open_result(tmp_path / "ours.nc").identical(xr.load_dataset(tmp_path / "theirs.nc"))


def test_identical_data_give_identical_files(dataset, tmp_path):
    first, second = (store.write_result(dataset, tmp_path / name).read_bytes() for name in ("a.nc", "b.nc"))
    assert first == second


def test_a_failure_in_the_middle_leaves_the_old_file_and_no_litter(dataset, tmp_path, monkeypatch):
    path = tmp_path / "r.nc"
    path.write_text("the old result")

    def breaks(*_):
        raise RuntimeError("NetCDF: HDF error")

    monkeypatch.setattr(store, "_fill", breaks)
    with pytest.raises(OSError, match="HDF error"):
        store.write_result(dataset, path)
    assert path.read_text() == "the old result"
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupt_in_the_middle_leaves_nothing(dataset, tmp_path, monkeypatch):
    def stops(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(store, "_fill", stops)
    with pytest.raises(KeyboardInterrupt):
        store.write_result(dataset, tmp_path / "r.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_result_has_its_name_only_when_it_is_on_the_disk(dataset, tmp_path, monkeypatch):
    order, sync, replace = [], os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda *a: (order.append("sync"), sync(*a)))
    monkeypatch.setattr(os, "replace", lambda *a: (order.append("name"), replace(*a)))
    store.write_result(dataset, tmp_path / "r.nc")
    assert order == ["sync", "name", "sync"]


def test_what_is_no_result_is_refused(tmp_path):
    text = tmp_path / "text.nc"
    text.write_text("no netCDF")
    empty = tmp_path / "empty.nc"
    empty.touch()
    for path in (text, empty, tmp_path, tmp_path / "none.nc", "nul\0byte"):
        with pytest.raises(InputError, match="result file"):
            store.open_result(path)


def test_a_folder_below_a_file_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="Not a directory") as error:
        store.check_writable(tmp_path / "file" / "out")
    assert error.value.problems[0].key == "--out"


def test_a_missing_folder_is_made_and_left_clean(tmp_path):
    folder = store.check_writable(tmp_path / "a" / "b")
    assert list(folder.iterdir()) == []


def test_what_a_killed_run_left_of_a_file_goes_with_the_next(tmp_path):
    """Where its process is gone, and nobody has written to it for a while."""
    gone, here = ended_process(), os.getppid()
    names = [f".r[1].nc.{gone}.tmp", f".r[1].nc.{here}.tmp", f".other.nc.{gone}.tmp", ".r[1].nc.new.tmp"]
    for name in names:
        (tmp_path / name).write_text("half")
        os.utime(tmp_path / name, (time.time() - 60,) * 2)
    store.check_writable(tmp_path, files=["r[1].nc"])
    assert {path.name for path in tmp_path.iterdir()} == {*names[1:]}
    (tmp_path / names[0]).write_text("of another machine, perhaps")
    store.check_writable(tmp_path, files=["r[1].nc"])
    assert (tmp_path / names[0]).exists()
