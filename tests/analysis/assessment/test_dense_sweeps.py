"""Edges of assessments against dense sweeps at rtol 1e-8: each lies between neighbouring cells that differ.

A sweep carries the motion from the present value outward in steps of 1 %, and across the edge in steps a
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


def ladder(begin, edge):
    """Values from the present one to beyond an edge, which lies in the middle of a fine step; ratios."""
    way = 1 if edge > 1 else -1
    fine = edge * (1 + FINE * STEP) ** (way * (np.arange(2 * CELLS) + 0.5 - CELLS))
    count = max(int(np.ceil(abs(np.log(fine[0])) / np.log1p(STEP))), 1)
    coarse = np.geomspace(1.0, fine[0], count, endpoint=False)
    return begin * np.concatenate([coarse, fine])


def coarse(begin, limit):
    """Values from the present one to the last that was looked at."""
    return begin * np.geomspace(1.0, limit, int(np.ceil(abs(np.log(limit)) / np.log1p(STEP))) + 1)


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
            whole = None
            for change in CHANGES:
                edge = float(found["edge_ratio"].sel(parameter=key, side=side, change=change))
                if np.isfinite(edge):
                    met += 1
                    cells = traits(mechanism, str(key), ladder(begin, edge))[change]
                    before, after = cells[:-CELLS], cells[-CELLS]
                    how = int(found["found_by"].sel(parameter=key, side=side, change=change))
                    if how == HOW.index("irregular"):  # seen in some of the cells
                        if np.all(cells == present[change]):
                            wrong.append((str(key), str(side), change, edge, cells.tolist()))
                        continue
                    bad = before[-1] != present[change] or after == present[change]
                else:
                    limit = float(found["limit_ratio"].sel(parameter=key, side=side))
                    whole = whole or traits(mechanism, str(key), coarse(begin, limit))
                    before, bad = whole[change], False
                if bad or (not present["chaos"] and np.any(before != present[change])):
                    wrong.append((str(key), str(side), change, edge, before.tolist()))
    assert met
    assert wrong == []
