"""Results as plain text, where their kind has one: a table in a file, a few lines on the terminal."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from jointplay.jobs.files import replaced
from jointplay.kinds import KINDS, load


def summary(dataset: xr.Dataset) -> str:
    """What a run tells of its result on the terminal; empty for most kinds."""
    row = KINDS.get(str(dataset.attrs.get("kind")))
    return load(row.summary)(dataset) if row and row.summary else ""


def write_table(dataset: xr.Dataset, path: Path) -> list[Path]:
    """Write the table of a result, for the kinds that have one; give back the files."""
    row = KINDS.get(str(dataset.attrs.get("kind")))
    if row is None or not row.table or "swept" in dataset.attrs:
        return []
    with replaced(path) as temporary:
        temporary.write_text(load(row.table)(dataset), encoding="utf-8")
    return [path]
