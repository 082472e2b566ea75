"""The tables of docs/benchmarks.md that no study gives: `python -m tests.benchmarks.store FOLDER [NAME ...]`.

One file a table, named after the benchmark of the suite that it comes from; `docs/measured.py` reads them.
"""

import re
import sys
from pathlib import Path

import numpy as np
import xarray as xr

from jointplay.jobs.origin import processor
from jointplay.study.results.store import write_result

from .suite import ensembles, scenes, starts, turns, valve


def _scenes():
    columns = ("evaluations", "attempts", "events", "CPU µs", "of plain")
    return {name: [found[key] for key in columns] for name, found in scenes.measured().items()}


def _ensembles():
    """Turns a second at 1e-5, then how many times as fast as one by one, a column a tolerance."""
    rows = {}
    for load in ensembles.LOADS:
        found = {rtol: ensembles.compared(load, rtol) for rtol in ensembles.TOLERANCES}
        rows[load] = [1e6 / found[1e-5]["µs a turn"], *(each["times as fast"] for each in found.values())]
    return rows


def _starts():
    """CPU seconds of the first run ever, and of the first one of a process."""
    start, rows = starts.Start(), {}
    for name in starts.FIRST:
        start.setup(name)
        rows[name] = [start.track_cold(name), start.track_warm(name)]
    return rows


def _turns():
    """Turns a second and core; cells an hour and core."""
    found = scenes.measured()
    rows = {name: [1e6 / found[name]["CPU µs"]] for name in turns.SPEEDS}
    sweep = turns.Sweep()
    sweep.setup()
    return rows | {"cells": [sweep.track_cells_an_hour()]}


TABLES = {
    "scenes": _scenes,
    "ensembles": _ensembles,
    "starts": _starts,
    "turns": _turns,
    "valve": valve.measured,
}


def main(folder, *names):
    """Measure what is asked for, all tables by default, and write each as it is done."""
    for name in names or TABLES:
        rows = TABLES[name]()
        longest = max(map(len, rows.values()))
        cells = np.array([[*cells, *[np.nan] * (longest - len(cells))] for cells in rows.values()])
        value = ("row", "column"), cells, {"units": "1", "long_name": "of the table"}
        labels = [re.sub(r"\W+", "_", label).strip("_") for label in rows]
        about = {"kind": f"benchmark_{name}", "processor": processor()}
        path = Path(folder) / f"{name}.nc"
        print(write_result(xr.Dataset({"value": value}, {"row": labels}, about), path))


if __name__ == "__main__":
    main(*sys.argv[1:])
