"""Between curves in two parameters motions have the label of their region: period, and contacts a turn."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from tests.support.regions import regions

STUDIES = Path(__file__).parents[3] / "studies"


def drawn(points, labels):
    """Curves through points, and a map of 20 x 20 values with the contacts that `labels` tells."""
    points, axis = np.array(points, dtype=float), np.arange(20.0)
    along = {
        f"{name}{of}": (("curve", "point"), values)
        for name, column in zip("xy", points.T, strict=True)
        for of, values in (("", column[None]), ("_tangent", np.gradient(column)[None]))
    }
    curves = xr.Dataset(along | {"n_points": ("curve", [len(points)])}, attrs={"parameters": "x y"})
    contacts = np.array([[labels(x, y) for y in axis] for x in axis])
    cells = {
        "period": (("direction", "x", "y"), np.ones((1, 20, 20), dtype=int)),
        "impacts": (("direction", "x", "y", "joint"), contacts[None, ..., None]),
    }
    return curves, xr.Dataset(cells, coords={"x": axis, "y": axis})


def test_regions_and_cells_that_differ_are_told():
    """A line from edge to edge; one cell differs beside it, two cells off one is wrong."""
    line = [(x, 10.0) for x in range(-3, 24, 3)]
    found = regions(*drawn(line, lambda x, y: 1.0 + (y > 10) + ((x, y) in [(4, 9), (4, 12), (7, 3)])))
    assert found.labels == [(1, 1.0), (1, 2.0)]
    assert int((found.number > 0).sum()) == 20 * 15
    assert np.argwhere((found.number > 0) & ~found.right).tolist() == [[7, 3]]
    assert found.share == pytest.approx(1 - 1 / 300)


@pytest.mark.nightly
def test_cells_between_curves_have_the_label_of_their_region():
    """The shipped studies, with fewer cells: one doubling, and contacts that are gained and lost."""
    curves = jp.run(STUDIES / "orbits" / "curve_wedge.toml")
    fewer = {f"vary.{name}.num": 60 for name in ("clearance", "gear_ratio")}
    diagram = jp.run(STUDIES / "bifurcation" / "map_wedge.toml", **fewer)
    found = regions(curves, diagram)
    assert (found.number > 0).mean() > 0.4
    assert {(1, 1.0), (1, 2.0), (2, 1.5)} <= set(found.labels)
    assert found.share >= 0.99
