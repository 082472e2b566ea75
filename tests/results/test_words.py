"""Words in place of codes."""

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.display import codes


def test_every_code_becomes_its_word():
    pair = catalog.impact_pair(3.6, 0.8)
    found = jp.simulate(pair, turns=3, initial=(0.0, 0.5), section=jp.ContactSection())
    told = jp.words(found)
    assert told.status.item() == "ok"
    assert set(told.event_kind.values) == {"impact"}
    assert told.event_joint.values.tolist() == [("upper", "lower")[i] for i in found.event_joint.values]
    assert set(told.event_joint.values) == {"upper", "lower"}
    assert not any("flag_meanings" in each.attrs for each in told.variables.values())
    assert np.array_equal(told.event_time, found.event_time)
    assert np.issubdtype(found.event_joint.dtype, np.integer)  # the result itself keeps its codes


def test_a_section_of_no_event_has_no_joint():
    told = jp.words(jp.poincare(catalog.duffing(), turns=2))
    assert told.section_joint.values.tolist() == ["none", "none"]


def test_a_joint_of_an_orbit_s_events():
    pair = catalog.impact_pair(3.6, 0.8)
    told = jp.words(jp.periodic_orbit(pair, initial=(0.0, 0.5), transient=50))
    assert told.stable.item() == "stable"
    assert sorted(told.event_joint.values) == ["lower", "upper"]


def test_what_is_no_result_is_refused():
    with pytest.raises(jp.InputError, match="a result"):
        jp.words("r.nc")


def test_words_of_a_condition_leave_the_units_of_what_it_stands_over():
    at = xr.DataArray([True, False], dims="gap", coords={"gap": ("gap", [1.0, 2.0], {"units": "m"})})
    words = codes.chosen(at, "near", "far")
    assert words.values.tolist() == ["near", "far"]
    assert words["gap"].attrs == {"units": "m"}
