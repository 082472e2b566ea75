"""Benchmarks: published mechanisms followed to their published answer, and compared digit by digit."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import Integration, Moving, Progress, analysis
from jointplay.analysis.labels import Out, ended
from jointplay.analysis.rules import steps
from jointplay.display.errors import Problem
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_lab.benchmarks import flores2010, ivp_crank, siconos_four_bar
from jointplay_lab.benchmarks.answer import Answer

ANSWERS: dict[str, Callable[[Mechanism, float, int, Progress], Answer]] = {
    "ivp_crank": ivp_crank.answer,
    "flores2010": flores2010.answer,
    "siconos_four_bar": siconos_four_bar.answer,
}
ROW = "{:<24} {:<8} {:>22} {:>22} {:>10} {:>10}"
HEAD = ("quantity", "units", "computed", "published", "difference", "relative")


def table(dataset: xr.Dataset) -> str:
    """The quantities, computed and published, with their differences, as text."""
    words = ("quantity", "quantity_units", "computed", "published", "difference", "relative_difference")
    rows = zip(*(dataset[word].values for word in words), strict=True)
    lines = (
        ROW.format(*row[:2], *(f"{x:.15e}" for x in row[2:4]), *(f"{x:.1e}" for x in row[4:])) for row in rows
    )
    return "\n".join([ROW.format(*HEAD), *lines]) + "\n"


def answer(dataset: xr.Dataset) -> str:
    """The largest relative difference of a benchmark."""
    off = dataset["relative_difference"].values
    worst = dataset["quantity"].values[np.argmax(off)]
    return f"all {off.size} published quantities are met to {off.max():.1e} or better (worst: {worst})"


OUTPUTS = Outputs(
    "benchmark",
    {
        "quantity": Out("quantity", "quantity", ""),
        "quantity_units": Out("quantity", "units of the quantity", ""),
    },
    {
        "computed": Out("quantity", "computed, in the units of quantity_units"),
        "published": Out("quantity", "published, in the units of quantity_units"),
        "difference": Out("quantity", "computed less published"),
        "relative_difference": Out("quantity", "difference over the published value"),
        "n_evaluations": Out((), "evaluations"),
    }
    | OUTCOME,
    answer,
    table=table,
)


def _published(mechanism: Mechanism | TestSystem) -> list[Problem]:
    """Problems of a mechanism whose answer is not published: another one, or one that was changed."""
    if mechanism.name in ANSWERS and mechanism == catalog.NAMES[mechanism.name]():
        return []
    known = " or ".join(f"catalog.{name}()" for name in ANSWERS)
    return [Problem("mechanism", mechanism, f"{known}, unchanged, is accepted: its answer is published")]


@analysis(_published, usual={"rtol": 1e-12}, outputs=OUTPUTS)
def benchmark(mechanism: Moving, **motion: Unpack[Integration]) -> xr.Dataset:
    """Follow a published mechanism to where its answer is published, and compare.

    Parameters
    ----------
    mechanism : Mechanism
        `catalog.ivp_crank`, `catalog.flores2010` or `catalog.siconos_four_bar`, unchanged.

    Raises
    ------
    InputError
        If the mechanism is none whose answer is published.
    """
    began = time.perf_counter()
    found = ANSWERS[mechanism.name](mechanism, motion["rtol"], steps(motion["max_steps"]), motion["progress"])
    units, published = map(np.array, zip(*found.published.values(), strict=True))
    values = {"quantity": np.array(list(found.published)), "quantity_units": units, "published": published}
    values["computed"] = np.array(found.computed, dtype=float)
    values["difference"] = values["computed"] - values["published"]
    values["relative_difference"] = np.abs(values["computed"] / values["published"] - 1)
    values["n_evaluations"] = np.int64(found.records.counts["n_evaluations"])
    return OUTPUTS.dataset(values | ended(found.records.status, began))
