"""Results on disk: one labelled netCDF file a study, moved into place whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.errors import refuse
from jointplay.jobs.files import beside, replaced
from jointplay.mechanism.signature import checked

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ENGINE = "netcdf4"  # always named: mixing HDF5 stacks in one process has broken before
COMPRESS_FROM = 1024  # values; below this the chunk headers cost more than they save


def write_result(dataset: xr.Dataset, path: Path | str) -> Path:
    """Write a dataset to `path`, through a temporary file in the same folder.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    path : path-like
        The final name, ending in ``.nc``.

    Returns
    -------
    pathlib.Path
        The final name, which exists only once the file is complete and on the disk.

    Raises
    ------
    OSError
        When the file cannot be written; nothing is left at `path` but what was there before.
    """
    path = Path(path)
    encoding = {str(name): _encoded(v, name in dataset.coords) for name, v in dataset.variables.items()}
    with replaced(path) as temporary:
        try:
            # xarray would take a name that begins with ~ for somebody's home, and http: for an address
            dataset.to_netcdf(temporary.absolute(), engine=ENGINE, encoding=encoding)
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
        raise refuse(str(path), accepted, "--out")
    dated = {"pdf": "CreationDate", "ps": "CreationDate", "eps": "CreationDate", "svg": "Date"}
    with replaced(path) as temporary:
        figure.savefig(temporary, format=form, metadata={dated[form]: None} if form in dated else None)
    return path


@checked()
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
    with opened(path) as dataset:
        return dataset.load()


@contextmanager
def opened(path: Path | str) -> Iterator[xr.Dataset]:
    """Open a result file, of which only what is asked for is read; `InputError` as of `open_result`."""
    import xarray as xr

    with _told(path), xr.open_dataset(Path(path).absolute(), engine=ENGINE) as dataset:
        yield dataset


def attributes(path: Path | str) -> dict[str, Any]:
    """Attributes of a result file, of which nothing else is read; `InputError` as of `open_result`."""
    from netCDF4 import Dataset

    with _told(path), Dataset(Path(path).absolute()) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


@contextmanager
def _told(path: Path | str) -> Iterator[None]:
    """Make an `InputError` of what goes wrong as a result file is read."""
    expected = "the name of a result file (netCDF) that `jointplay run` wrote"
    given = os.fspath(path) if isinstance(path, os.PathLike) else path
    if not isinstance(given, str) or not os.path.isfile(given):
        there = isinstance(given, str) and os.path.lexists(given)
        why = "it is no regular file" if there else "there is no such file"
        raise refuse(given, f"{expected}; {why}", "result")
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:  # in a file of others anything may be of another type than is read here
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise refuse(str(path), f"{expected}; this is none ({reason})", "result") from error


def check_writable(
    folder: Path | str, key: str = "--out", files: Iterable[str] = ("probe",), folders: Iterable[str] = ()
) -> Path:
    """Make the folder if needed and prove that files can be written there.

    Parameters
    ----------
    folder : path-like
        The folder.
    key : str
        Its key in error messages.
    files, folders : iterable of str
        Names to be written in it: nothing of another sort may have them, and none may be too long.

    Raises
    ------
    jointplay.errors.InputError
        Under `key`, when they cannot.
    """
    name = ""
    try:
        if not os.fspath(folder):
            raise ValueError("it has no name")
        place = Path(folder)
        str(place.absolute()).encode()  # netCDF takes no other names
        place.mkdir(parents=True, exist_ok=True)
        for name in files:
            _prove_file(place / name)
        for name in folders:
            _prove_folder(place / name)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        expected = f"a folder in which {name or 'files'} can be written ({reason})"
        raise refuse(str(folder), expected, key) from error
    return place


def _prove_file(path: Path) -> None:
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "a folder has this name")
    probe = beside(path)
    try:
        probe.write_bytes(b"0")  # a full disk may still have room for a name
    finally:
        probe.unlink(missing_ok=True)


def _prove_folder(path: Path) -> None:
    if os.path.lexists(path) and not path.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "something else has this name")


def _encoded(variable: xr.Variable, is_coordinate: bool) -> dict:
    """Encoding of a variable: NaN marks missing floats; integers, flags and counts, are never missing."""
    if variable.dtype.kind not in "fiu":
        return {}
    has_fill = variable.dtype.kind == "f" and not is_coordinate
    encoding: dict = {"_FillValue": variable.dtype.type(np.nan) if has_fill else None}
    if variable.size >= COMPRESS_FROM:
        encoding |= {"zlib": True, "complevel": 4, "shuffle": True}
    return encoding
