"""Studies of initial states: their axes, and all that is wrong with them at once."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.study.file import Loaded, validate
from jointplay.study.run import run
from tests.support.wrong import problems_of

DUFFING = {"catalog": "duffing", "amplitude": 0.0}
PLANE = {"y": {"start": -1.0, "stop": 1.0, "num": 3}, "v": [0.0, 0.4]}


def study(kind, mechanism=DUFFING, figure=None, **analysis):
    table = {"kind": kind, "name": "test", "mechanism": mechanism, "analysis": analysis}
    return validate(table | {"figure": figure or {}})


def test_axes_reach_the_analysis_as_they_were_written():
    record = study("basins", plane=PLANE, turns=8, transient=10)
    assert record.keywords()["plane"] == PLANE
    found = run(Loaded(record, ""), jobs=1)
    assert found.y.values.tolist() == [-1.0, 0.0, 1.0]
    assert found.attrs["kind"] == "basins"
    assert np.isfinite(found.fraction.values).all()


def test_a_study_of_neighbours_needs_nothing_but_a_mechanism():
    record = validate({"kind": "sensitivity", "name": "test", "mechanism": DUFFING})
    assert record.keywords()["rtol"] == 1e-12
    assert "plane" not in record.keywords()


@pytest.mark.parametrize(
    ("kind", "options", "key"),
    [
        ("sensitivity", {"plane": {"y": [0.0, 1.0]}}, "analysis.plane"),
        ("sensitivity", {"plane": {"y": [0.0, 1.0], "x": [0.0, 1.0]}}, "analysis.plane.x"),
        ("sensitivity", {"plane": {"y": 3.0, "v": [0.0, 1.0]}}, "analysis.plane.y"),
        (
            "sensitivity",
            {"plane": {"y": {"start": 0.0, "stop": 1.0}, "v": [0.0, 1.0]}},
            "analysis.plane.y.num",
        ),
        ("sensitivity", {"plane": PLANE, "transient": 5}, "analysis.transient"),
        ("sensitivity", {"compare": "phase"}, "analysis.compare"),
        ("sensitivity", {"distance": 1.5}, "analysis.distance"),
        ("sensitivity", {"figure": {"kind": "field"}}, "figure.kind"),
        ("sensitivity", {"plane": PLANE, "figure": {"kind": "divergence"}}, "figure.kind"),
        ("sensitivity", {"figure": {"kind": "basins"}}, "figure.kind"),
        ("sensitivity", {"section": {"kind": "contact"}}, "analysis.section"),
        ("basins", {}, "analysis.plane"),
        ("basins", {"plane": PLANE, "joint": "B"}, "analysis.joint"),
        ("basins", {"plane": PLANE, "turns": 3}, "analysis.turns"),
        ("basins", {"plane": PLANE, "initial": [0.0]}, "analysis.initial"),
    ],
)
def test_what_is_wrong_is_said_by_its_key(kind, options, key):
    assert key in problems_of(study, kind, **options)


def test_a_table_in_place_of_a_system_s_states_is_told_their_names():
    with pytest.raises(InputError, match="a list of the states y, v is accepted"):
        jp.simulate(jp.catalog.duffing(), duration=1, initial={"y": 1.0, "v": 0.0})
