"""Results on disk: one labelled netCDF file a study, moved into place whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from jointplay.errors import InputError, Problem

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # a third of a second that workers need not wait

ENGINE = "netcdf4"  # always named: mixing HDF5 stacks in one process has broken before
COMPRESS_FROM = 1024  # values; below this the chunk headers cost more than they save


def write_result(dataset: xr.Dataset, path: Path | str) -> Path:
    """Write a dataset to `path`, through a temporary file in the same folder.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result in the project's words.
    path : path-like
        The final name, ending in ``.nc``.

    Returns
    -------
    pathlib.Path
        The final name. It exists only once the file is complete and on the disk.

    Raises
    ------
    OSError
        When the file cannot be written; nothing is left at `path` but what was there before.
    """
    path = Path(path)
    with replaced(path) as temporary:
        try:
            dataset.to_netcdf(temporary, engine=ENGINE, encoding=_encoding(dataset))
        except RuntimeError as error:  # how the netCDF library reports a full disk
            raise OSError(f"{path}: {error}") from error
    return path


def write_figure(figure: Figure, path: Path | str) -> Path:
    """Write a figure to a file, whole or not at all. No date goes in: the same figure gives the same file.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The picture.
    path : path-like
        The final name; its ending chooses the format.

    Raises
    ------
    jointplay.errors.InputError
        When there is no such format.
    """
    path = Path(path)
    form = path.suffix.lstrip(".").lower()
    known = figure.canvas.get_supported_filetypes()
    if form not in known:
        accepted = f"a name that ends in one of {', '.join(f'.{name}' for name in sorted(known))} is accepted"
        raise InputError([Problem("--out", str(path), accepted)])
    dated = {"pdf": "CreationDate", "ps": "CreationDate", "eps": "CreationDate", "svg": "Date"}
    with replaced(path) as temporary:
        figure.savefig(temporary, format=form, metadata={dated[form]: None} if form in dated else None)
    return path


def open_result(path: Path | str) -> xr.Dataset:
    """Read a result file into memory and close it.

    Parameters
    ----------
    path : path-like
        A netCDF file that a study wrote.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    jointplay.errors.InputError
        When there is no such file, or it is no netCDF file.
    """
    expected = "the name of a result file (netCDF) that `jointplay run` wrote"
    if not os.path.isfile(path):
        raise InputError([Problem("result", str(path), f"{expected}; there is no such file")])
    try:
        with xr.open_dataset(path, engine=ENGINE) as dataset:
            return dataset.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError([Problem("result", str(path), f"{expected}; this is none ({error})")]) from error


@contextmanager
def replaced(path: Path, flush: bool = True) -> Iterator[Path]:
    """Give a temporary name beside `path`; on success move the file there, else remove it.

    Without `flush` it is there whole after a kill at any moment, but may not be after a power cut.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        if flush:
            _flush(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    with suppress(OSError):  # some file systems cannot sync a folder; the file itself is safe
        if flush:
            _flush(path.parent)


def check_writable(folder: Path | str, key: str = "--out") -> Path:
    """Make the folder if needed and prove that a file can be written there.

    Raises
    ------
    jointplay.errors.InputError
        Under `key`, when it cannot.
    """
    folder = Path(folder)
    probe = folder / f".probe.{os.getpid()}.tmp"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        expected = f"a folder in which files can be written ({reason})"
        raise InputError([Problem(key, str(folder), expected)]) from error
    return folder


def _encoding(dataset: xr.Dataset) -> dict[str, dict]:
    return {
        str(name): _encode(variable, name in dataset.coords) for name, variable in dataset.variables.items()
    }


def _encode(variable: xr.Variable, is_coordinate: bool) -> dict:
    """NaN marks what is missing in float data only; integers are flags and counts and are always there."""
    if variable.dtype.kind not in "fiu":
        return {}
    has_fill = variable.dtype.kind == "f" and not is_coordinate
    encoding: dict = {"_FillValue": variable.dtype.type(np.nan) if has_fill else None}
    if variable.size >= COMPRESS_FROM:
        encoding |= {"zlib": True, "complevel": 4, "shuffle": True}
    return encoding


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
