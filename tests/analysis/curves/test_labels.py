"""Special points of branches from which curves start: which labels fit."""

import pytest
import xarray as xr

from jointplay.analysis.curves.curve import SPECIAL, labels_fit

PLANE = {"clearance": (1e-5, 1e-4), "gear_ratio": (2.0, 4.0)}
BRANCHES = xr.Dataset(
    {
        "special_kind": ("special", [SPECIAL.index(kind) for kind in ("fold", "period_doubling")]),
        "clearance": ("point", [1e-5, 1e-4], {"key": "clearance"}),
    },
    attrs={"parameter": "clearance", "kind": "continuation"},
)


@pytest.mark.parametrize(
    ("labels", "of", "keys"),
    [
        (None, ["fold"], []),
        ([0], ["fold"], []),
        ([1], ["fold", "period_doubling"], []),
        ([1], ["fold"], ["labels"]),
        (None, ["grazing"], ["branches"]),
        ([0, 2], ["fold"], ["labels[1]"]),
    ],
)
def test_labels_are_numbers_of_special_points_from_which_a_wanted_curve_can_start(labels, of, keys):
    assert [problem.key for problem in labels_fit(PLANE, BRANCHES, labels, of)] == keys


def test_labels_need_branches_over_one_of_the_two_parameters():
    assert [problem.key for problem in labels_fit(PLANE, None, [0], ["fold"])] == ["labels"]
    other = {"gravity": (0.0, 9.8), "gear_ratio": (2.0, 4.0)}
    assert [problem.key for problem in labels_fit(other, BRANCHES, [0], ["fold"])] == ["plane"]
