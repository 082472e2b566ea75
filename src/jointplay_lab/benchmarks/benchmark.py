"""Benchmarks: published mechanisms followed to their published answer, and compared digit by digit."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.keywords import Integration, Moving, Progress, analysis
from jointplay.analysis.labels import number, outcome
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


def _published(mechanism: Mechanism | TestSystem) -> list[Problem]:
    """Problems of a mechanism whose answer is not published: another one, or one that was changed."""
    if mechanism.name in ANSWERS and mechanism == catalog.NAMES[mechanism.name]():
        return []
    known = " or ".join(f"catalog.{name}()" for name in ANSWERS)
    return [Problem("mechanism", mechanism, f"{known}, unchanged, is accepted: its answer is published")]


@analysis(_published, usual={"rtol": 1e-12})
def benchmark(
    mechanism: Moving,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Follow a published mechanism to where its answer is published, and compare.

    Parameters
    ----------
    mechanism : Mechanism
        `catalog.ivp_crank`, `catalog.flores2010` or `catalog.siconos_four_bar`, unchanged.

    Returns
    -------
    xarray.Dataset
        Over ``quantity``: ``computed``, ``published`` and ``difference`` in the units of ``quantity_units``,
        and ``relative_difference``; ``n_evaluations`` and ``status`` of the run.

    Raises
    ------
    InputError
        If the mechanism is none whose answer is published.
    """
    began = time.perf_counter()
    found = ANSWERS[mechanism.name](mechanism, motion["rtol"], steps(motion["max_steps"]), motion["progress"])
    computed, published = (
        np.array([getattr(row, word) for row in found.rows]) for word in ("computed", "published")
    )
    table = {
        "computed": number("quantity", computed, "1", "computed, in the units of quantity_units"),
        "published": number("quantity", published, "1", "published, in the units of quantity_units"),
        "difference": number("quantity", computed - published, "1", "computed less published"),
        "relative_difference": number(
            "quantity", np.abs(computed / published - 1), "1", "difference over the published value"
        ),
        "n_evaluations": number((), np.int64(found.counts["n_evaluations"]), "1", "evaluations"),
    }
    names = np.array([row.quantity for row in found.rows])
    units = np.array([row.units for row in found.rows])
    labels = {
        "quantity": ("quantity", names, {"long_name": "quantity"}),
        "quantity_units": ("quantity", units, {"long_name": "units of the quantity"}),
    }
    attributes = {"Conventions": "CF-1.11", "kind": "benchmark"}
    return xr.Dataset(table | outcome(found.status, began), labels, attributes)
