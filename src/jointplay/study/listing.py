"""What studies there are, and which of them have a result. Reads headings only and validates nothing."""

import os
from pathlib import Path

from jointplay.errors import InputError, Problem
from jointplay.study.toml_text import parse, read_text
from jointplay.terminal import one_line


def rows(folder: Path | str, out: Path | str = "results") -> list[tuple[str, str, str, str]]:
    """The studies below a folder.

    Parameters
    ----------
    folder : path-like
        Searched with its sub-folders for ``*.toml``.
    out : path-like
        Where results are looked for: in it, and in its sub-folder of the same name as the study's.

    Returns
    -------
    list of (str, str, str, str)
        File, kind, ``done`` or nothing, title; padded to columns.

    Raises
    ------
    jointplay.errors.InputError
        When there is no such folder.
    """
    folder = Path(folder)
    if not os.path.isdir(folder):
        raise InputError(
            [Problem("folder", str(folder), "a folder with study files; there is no such folder")]
        )
    found = [
        _row(path, path.parent.relative_to(folder), Path(out)) for path in sorted(folder.rglob("*.toml"))
    ]
    widths = [max((len(row[i]) for row in found), default=0) for i in range(3)] + [0]
    return [tuple(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in found]  # type: ignore[misc]


def _row(path: Path, inside: Path, out: Path) -> tuple[str, str, str, str]:
    try:
        table = parse(read_text(path))
    except InputError:
        return str(path), "?", "", "not a readable study file: see `jointplay check`"
    name = str(table.get("name", path.stem))
    done = any(os.path.isfile(place / f"{name}.nc") for place in (out, out / inside))
    kind, title = (one_line(str(table.get(key, usual))) for key, usual in (("kind", "?"), ("title", "")))
    return str(path), kind, "done" if done else "", title
