"""Edges of assessments against dense sweeps at rtol 1e-8: each lies between neighbouring cells that differ.

A sweep carries the motion from the present value outward in steps of 1 %, and across each edge in steps a
tenth as long. The cells next to the edge on its two sides must differ in the trait; of a motion that is not
chaotic, no cell before the edge may differ from the present one, nor any where no edge was met.
Where a motion without a period loses contact now and then, some cell beside the edge has to.
"""

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment.edges import HOW
from jointplay.analysis.assessment.settled import CHANGES

MECHANISMS = {
    "four-bar, 0.029 mm, slow": lambda: jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0),
    "four-bar, 0.29 mm": lambda: jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0),
    "slider-crank": lambda: jp.catalog.slider_crank(clearance={"B": 1e-4}),
    "quick return": lambda: jp.catalog.quick_return(clearance={"D": 5e-5}),
    "Watt": lambda: jp.catalog.watt(clearance={"D": 5e-5}),
}
STEP, FINE, CELLS = 0.01, 0.1, 5  # relative step; of it the fine ones; their number on each side of an edge


def outward(limit, edges):
    """Ratios to the present value from 1 to a limit; each edge lies in the middle of a fine step."""
    coarse = np.geomspace(1.0, limit, int(np.ceil(abs(np.log(limit)) / np.log1p(STEP))) + 1)[1:]
    fine = (1 + FINE * STEP) ** (np.arange(2 * CELLS) + 0.5 - CELLS)
    for edge in edges:
        coarse = coarse[np.abs(np.log(coarse / edge)) > CELLS * FINE * STEP]
    ratios = np.concatenate([coarse, *(edge * fine for edge in edges)])
    ratios = np.sort(np.append(ratios[(ratios > 1) == (limit > 1)], 1.0))
    return ratios if limit > 1 else ratios[::-1]


def traits(mechanism, key, values):
    """Answers of `CHANGES` of the settled motions, in the order of the values."""
    way = "up" if abs(values[-1]) > abs(values[0]) else "down"
    settings = {"transient": 600, "turns": 60, "exponents": 1, "rtol": 1e-8, "n_jobs": 1}
    sweep = jp.bifurcation(mechanism, over={key: np.sort(values)}, direction=way, **settings)
    assert np.all(sweep["cell_status"] == 0)
    sweep = sweep.isel(direction=0)
    period = sweep["period"].values
    value, error, follows = (
        sweep[f"section_{name}"].isel(multiplier=0).values
        for name in ("exponent_per_turn", "standard_error_per_turn", "batch_correlation")
    )
    follows = np.clip(follows, 0.0, 0.99)  # of batch means, by which their error is too small
    chaotic = (period == 0) & (value > 3 * error * np.sqrt((1 + follows) / (1 - follows)))
    lost = (sweep["contact_fraction"].values < 1).any(axis=-1)
    found = dict(zip(CHANGES, (lost, period != 1, chaotic), strict=True))
    return {name: each if values[-1] > values[0] else each[::-1] for name, each in found.items()}


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", MECHANISMS)
def test_edges_lie_between_neighbouring_cells_of_a_dense_sweep(name):
    mechanism = MECHANISMS[name]()
    found = jp.assess(mechanism)
    assert int(found["status"]) == 0
    assert np.all(found["side_status"] == 0)
    present = dict(zip(CHANGES, found["present"].values == 1, strict=True))
    wrong, met = [], 0
    for key in found["parameter"].values:
        begin = float(found["present_value"].sel(parameter=key))
        for side in found["side"].values:
            here = found.sel(parameter=key, side=side)
            edges = here["edge_ratio"].values
            limit, there = float(here["limit_ratio"]), np.isfinite(edges)
            met += there.sum()
            ratios = outward(limit, edges[there])
            cells = traits(mechanism, str(key), begin * ratios)
            for change, edge, how in zip(CHANGES, edges, here["found_by"].values, strict=True):
                values, was = cells[change], present[change]
                if HOW[how] == "irregular":  # seen in some of the cells
                    near = np.abs(np.log(ratios / edge)) < CELLS * FINE * STEP
                    bad = np.all(values[near] == was)
                elif np.isfinite(edge):
                    first = int(np.argmax((ratios > edge) == (limit > 1)))  # beyond it
                    values = values[: first + 1]
                    bad = values[-2] != was or values[-1] == was
                    bad |= not present["chaos"] and np.any(values[:-1] != was)
                else:
                    bad = not present["chaos"] and np.any(values != was)
                if bad:
                    wrong.append((str(key), str(side), change, edge, values.tolist()))
    assert met
    assert wrong == []
