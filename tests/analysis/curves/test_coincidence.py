"""Curves along which a slip reversal and the beginning of its contact are at one time."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.curves.grazing import Coincidence, sliding
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Event
from tests.analysis.test_flat_landing import PLAY, STILL, block

CONTACTS = ("contact", "separation")


def reversals(linkage, point, share):
    """Slip reversals of the orbit beside a point of a curve, and the least time from one to the contact's."""
    clearance, ratio = share * float(point["clearance"]), float(point["gear_ratio"])
    start = {"initial": list(point["orbit_state"].values), "transient": 0}
    orbit = jp.words(jp.periodic_orbit(linkage.replace(clearance=clearance, gear_ratio=ratio), **start))
    kinds, times = orbit["event_kind"].values, orbit["event_time"].values / float(orbit["period_time"])
    slips, others = times[kinds == "slip_reversal"], times[np.isin(kinds, CONTACTS)]
    return len(slips), min(np.abs(np.subtract.outer(slips, others)).ravel(), default=np.inf)


CORNERS = [(side, front) for side in (1, -1) for front in (1, -1)]


@pytest.mark.nightly
@pytest.mark.parametrize("corner", range(4))
def test_a_corner_slides_and_is_as_deep_as_its_place_says(corner):
    """Of a block that leans in its guide; in flight too, as if it touched."""
    model, (side, front) = assemble(block(), STILL), CORNERS[corner]
    at = {"theta_block": 0.01, "x_0": 1e-3, "y_0": 2e-5, "w_block": 3.0, "vx_0": 0.2, "vy_0": -0.1}
    state = [at[name] for name in cache.structure_module(model.structure).STATE[1:]]
    ((slides, gap, _),) = sliding(model, np.array([[0.0, *state, *np.zeros(4)]]), corner)
    height = front * 0.02 * math.sin(0.01) + side * 0.01 * math.cos(0.01)
    assert slides == pytest.approx(0.2 - 3.0 * height, abs=1e-12)
    assert gap == pytest.approx(side * (2e-5 + height) - 0.01 - PLAY, abs=1e-15)


def test_where_its_contact_does_not_begin_there_is_no_coincidence():
    condition = Coincidence(0, int(Event.CONTACT), 1.0, (0, int(Event.SLIP_REVERSAL)))
    events = np.zeros((1, 4 + 7 + 4))
    events[0, 1] = Event.CONTACT
    like = SimpleNamespace(orbit=SimpleNamespace(image=SimpleNamespace(events=events)))
    section = SimpleNamespace(model=assemble(block(), STILL))
    trial = SimpleNamespace(section=section, image=SimpleNamespace(events=events[:0]))
    assert math.isnan(condition.value(trial, like))


@pytest.mark.nightly
def test_a_slip_reversal_vanishes_into_flight():
    """Beside the curve orbits differ by one reversal, the nearer to the curve the closer to the contact."""
    linkage = catalog.chunmei2002(4.11e-5, gear_ratio=3.0)
    plane = {"clearance": (4.1e-5, 4.16e-5), "gear_ratio": (2.97, 3.02)}
    given = {"of": "grazing", "grazing_events": "slip_reversal", "step": 0.1, "max_points": 16}
    found = jp.words(jp.curve(linkage, plane=plane, **given))
    assert list(found["curve_kind"].values) == 2 * ["coincidence"]
    assert list(found["curve_event_kind"].values) == 2 * ["slip_reversal"]
    for number in range(2):
        one = found.isel(curve=number, point=slice(0, int(found["n_points"][number])))
        assert one.sizes["point"] > 8
        middle = one.sizes["point"] // 2
        chord = [np.diff(one[name].values[middle : middle + 2])[0] for name in plane]
        slope = [one[f"{name}_tangent"].values[middle : middle + 2].mean() for name in plane]
        assert chord[0] / chord[1] == pytest.approx(slope[0] / slope[1], rel=1e-3)
        for point in (1, middle, one.sizes["point"] - 2):
            at, apart = one.isel(point=point), []
            for distance in (1e-6, 1e-7):
                (few, _), (many, near) = sorted(
                    reversals(linkage, at, 1 + side * distance) for side in (-1, 1)
                )
                assert many == few + 1
                apart.append(near)
            assert apart[1] == pytest.approx(apart[0] / 10, rel=0.05)
            assert apart[1] < 1e-6
