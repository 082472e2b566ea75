"""Results on disk: one labelled netCDF file a study, moved into place whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.display.errors import refuse, sealed
from jointplay.jobs.files import clear_leftovers, replaced, temporary_name
from jointplay.jobs.interrupts import held
from jointplay.solver.mechanism.signature import checked

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr
    from matplotlib.figure import Figure

ENGINE = "netcdf4"  # always named: mixing HDF5 stacks in one process has broken before
NO_NETCDF = -51  # the number of its error for a file of another format
COMPRESS_FROM = 1024  # values; below this the chunk headers cost more than they save
BLOCK = 2**21  # bytes written at a time: some 50 ms of compressing
SOON = 2**24  # bytes that are still written where Ctrl-C was pressed: half a second
PARTIAL = 2**25  # bytes of a partial result, which is not compressed, and written in a tenth of that


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
    return _write(dataset, Path(path), compress=True)


def write_partial(dataset: xr.Dataset, path: Path | str) -> Path:
    """Write the result of an interrupted run, within a second: as `write_result`, but not compressed.

    Of more than `PARTIAL` bytes it is every n-th entry along one dimension; an attribute ``partial`` says so.
    """
    from jointplay.analysis.evaluate import thinned

    return _write(sealed(thinned(dataset, PARTIAL)), Path(path), compress=False)


def _write(dataset: xr.Dataset, path: Path, compress: bool) -> Path:
    """Write a file from which Ctrl-C can keep only a large one, that is a whole one, between two blocks."""
    import netCDF4

    with held() as pressed, replaced(path, flush=compress) as temporary:
        try:
            # xarray's own writer keeps a lock of this process, which Ctrl-C in it would leave taken
            with netCDF4.Dataset(str(temporary.absolute()), "w") as file:
                _fill(file, dataset, compress, pressed if compress else lambda: False)
        except RuntimeError as error:  # how the netCDF library reports a full disk
            raise OSError(f"{path}: {error}") from error
    return path


def _fill(file: netCDF4.Dataset, dataset: xr.Dataset, compress: bool, pressed: Callable[[], bool]) -> None:
    """Write a dataset into a file that is open, block by block; Ctrl-C ends it where much is left."""
    from xarray.conventions import encode_cf_variable, encode_dataset_coordinates

    variables, attributes = encode_dataset_coordinates(dataset)
    file.setncatts(attributes)
    for dim, size in dataset.sizes.items():
        file.createDimension(dim, size)
    left = dataset.nbytes
    for name, variable in variables.items():
        given = variable.copy(deep=False)
        given.encoding = _missing(given, name in dataset.coords)
        encoded = encode_cf_variable(given, name=name)
        values, attrs = encoded.values, dict(encoded.attrs)
        texts = values.dtype.kind in "OU"
        large = given.dtype.kind in "fiu" and given.size >= COMPRESS_FROM
        packed = {"zlib": True, "complevel": 4, "shuffle": True} if compress and large else {}
        place = file.createVariable(
            name,
            str if texts else values.dtype,
            encoded.dims,
            fill_value=attrs.pop("_FillValue", None),
            **packed,
        )
        place.setncatts(attrs)
        place.set_auto_maskandscale(False)
        for part in _blocks(values, place.chunking()):
            place[part] = values[part].astype(object) if texts else values[part]
            left -= values[part].nbytes
            if left > SOON and pressed():
                raise KeyboardInterrupt


def _blocks(values: np.ndarray, chunks: list[int] | str) -> Iterator[tuple]:
    """Places of the parts of an array along its longest dimension, in whole chunks of the file."""
    if values.nbytes <= BLOCK:
        yield (...,)
        return
    along = int(np.argmax(values.shape))
    chunk = 1 if isinstance(chunks, str) else chunks[along]
    step = max(1, round(values.shape[along] * BLOCK / values.nbytes / chunk)) * chunk
    for first in range(0, values.shape[along], step):
        yield (*[slice(None)] * along, slice(first, first + step))


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
    jointplay.display.errors.InputError
        When there is no such format.
    """
    path = Path(path)
    form = path.suffix.lstrip(".").lower()
    known = figure.canvas.get_supported_filetypes()
    if form not in known:
        accepted = f"a name that ends in one of {', '.join(f'.{name}' for name in sorted(known))} is accepted"
        raise refuse(str(path), accepted, "--out")
    with replaced(path) as temporary:
        dated = {"pdf": "CreationDate", "svg": "Date"}.get(form)  # also in figures of others' kinds
        figure.savefig(temporary, format=form, metadata={dated: None} if dated else None)
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
    jointplay.display.errors.InputError
        When there is no such file, or it is no netCDF file.
    """
    with _reading(path), _dataset(path) as dataset:
        return dataset.load()


def part(path: Path | str, *names: str) -> xr.Dataset:
    """The named variables that a result file has, and its attributes; `InputError` as of `open_result`."""
    with _reading(path), _dataset(path) as dataset:
        return dataset[[name for name in names if name in dataset]].load()


def _dataset(path: Path | str) -> xr.Dataset:
    import xarray as xr

    return xr.open_dataset(Path(path).absolute(), engine=ENGINE)


def attributes(path: Path | str) -> dict[str, Any]:
    """Attributes of a result file, of which nothing else is read; `InputError` as of `open_result`."""
    from netCDF4 import Dataset

    with _reading(path), Dataset(Path(path).absolute()) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


@contextmanager
def _reading(path: Path | str) -> Iterator[None]:
    """Turn an error of the libraries that read a result file into an `InputError`."""
    expected = "the name of a result file (netCDF) that `jointplay run` wrote is accepted"
    given = os.fspath(path) if isinstance(path, os.PathLike) else path
    if not isinstance(given, str) or not os.path.isfile(given):
        there = isinstance(given, str) and os.path.lexists(given)
        why = "it is no regular file" if there else "there is no such file"
        raise refuse(given, f"{expected}; {why}", "result")
    if given.endswith(".toml"):
        raise refuse(given, f"{expected}; this is a study file, to be run first", "result")
    try:
        with held():
            yield
    except MemoryError:
        raise
    except Exception as error:  # in a file of others anything may be of another type than is read here
        reason = " ".join(f"({type(error).__name__}: {error})".split())
        why = "" if getattr(error, "errno", None) == NO_NETCDF else f" {reason}"
        raise refuse(str(path), f"{expected}; this file is not one{why}", "result") from error


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
    jointplay.display.errors.InputError
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
    clear_leftovers(path)
    probe = temporary_name(path)
    try:
        probe.write_bytes(b"0")  # a full disk may still have room for a name
    finally:
        probe.unlink(missing_ok=True)


def _prove_folder(path: Path) -> None:
    if os.path.lexists(path) and not path.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "something else has this name")


def _missing(variable: xr.Variable, is_coordinate: bool) -> dict:
    """Encoding of a variable: NaN marks missing floats; integers, flags and counts, are never missing."""
    if variable.dtype.kind not in "fiu":
        return {}
    has_fill = variable.dtype.kind == "f" and not is_coordinate
    return {"_FillValue": variable.dtype.type(np.nan) if has_fill else None}
