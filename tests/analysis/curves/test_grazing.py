"""Curves of grazing: gears in closed form, a rigid wall by exact flights, a bearing by runs."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.curves.grazing import Guards
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.starts import placed
from jointplay.solver.method.codes import Mode
from tests.analysis.exact_maps import TAU, Flight


def found_curve(found, kind="grazing", event=None):
    """The points of the first curve of a kind, and of an event, as a dataset."""
    words = jp.words(found)
    fits = (words["curve_kind"] == kind) & ((words["curve_event_kind"] == event) if event else True)
    number = int(np.flatnonzero(fits)[0])
    return words.isel(curve=number, point=slice(0, int(found["n_points"][number])))


ZETA, LOAD = 0.05, 0.1


def limit(W):
    """Amplitude from which on gears that oscillate steadily on one flank lose contact."""
    return LOAD * abs(1 - W**2 + 2j * ZETA * W) / W**2


GEARS = catalog.gear_backlash(LOAD, 0.95 * limit(1.6), 1.6, ZETA)
PLANE = {"amplitude": (0.8 * limit(1.6), 1.2 * limit(1.6)), "frequency": (1.5, 1.7)}
ON_ONE_FLANK = {"initial": [1 + LOAD, 0.0], "transient": 200}


@pytest.mark.nightly
def test_the_gears_lose_contact():
    """Steady oscillation on one flank loses contact where its amplitude is the mean deflection."""
    found = jp.curve(GEARS, plane=PLANE, **ON_ONE_FLANK, of="grazing", step=0.2, max_curves=1)
    one = found_curve(found)
    assert one["curve_event_kind"] == "separation"
    assert one["amplitude"].values == pytest.approx(limit(one["frequency"].values), rel=1e-9)
    assert list(one["curve_end"]) == ["range", "range"]
    assert sorted(one["frequency"].values[[0, -1]]) == [1.5, 1.7]
    h, at = 1e-5, one["frequency"].values
    slopes = one["amplitude_tangent"].values / one["frequency_tangent"].values
    assert slopes == pytest.approx((limit(at + h) - limit(at - h)) / (2 * h), rel=1e-6)


@pytest.mark.nightly
def test_a_grazing_starts_from_a_branch_whose_points_beside_it_are_on_one_side():
    """Found again on another section, an orbit a hair beside a grazing may have the event or not."""
    branches = jp.continuation(
        GEARS, parameter="amplitude", range=PLANE["amplitude"], **ON_ONE_FLANK, step=0.01
    )
    words = jp.words(branches)
    label = int(np.flatnonzero(words["special_event_kind"].values == "separation")[0])
    p = int(branches["special_point"][label])
    few, many = sorted((p, p + 1), key=lambda i: int(branches["impacts"].values[0, i]))
    assert int(branches["impacts"].values[0, many]) == 1 + int(branches["impacts"].values[0, few])
    for name in ("amplitude", "orbit_state"):
        branches[name].values[0, few] = branches[name].values[0, many]
    found = jp.curve(GEARS, plane=PLANE, branches=branches, labels=label, of="grazing", step=0.2)
    one = found_curve(found)
    assert one.sizes["point"] > 4
    assert one["amplitude"].values == pytest.approx(limit(one["frequency"].values), rel=1e-9)


RESTITUTION, SIDEWAYS = 0.5, {"height": (3.7, 5.0), "acceleration": (1.0, 1.7)}
FOLD = math.pi * (1 - RESTITUTION) / (1 + RESTITUTION)  # acceleration from which on the ball bounces
DOUBLING = math.hypot(FOLD, 2 * (1 + RESTITUTION**2) / (1 + RESTITUTION) ** 2)


def under_a_ceiling(acceleration):
    """A ball that bounces once a period of the table, in table amplitudes, and its state at time 0."""
    system = jp.System(
        name="ball under a ceiling",
        states={"y": 1.0, "v": 0.5},
        parameters={"acceleration": acceleration, "restitution": RESTITUTION, "height": 4.6},
        rates={"y": "v", "v": "-1/acceleration"},
        forcing="2*pi",
        impacts=[
            {"name": "table", "gap": "y - sin(t)", "restitution": "restitution"},
            {"name": "ceiling", "gap": "height - y", "restitution": "restitution"},
        ],
    )
    phase = math.acos(FOLD / acceleration)
    flown, v = TAU - phase, math.pi / acceleration
    return system, [math.sin(phase) + v * flown - flown**2 / (2 * acceleration), v - flown / acceleration]


@pytest.mark.nightly
def test_a_doubling_and_a_fold_meet_a_grazing_in_closed_form():
    """A flight rises to sin(phase) + pi^2 / (2 acceleration): the ceiling there changes no multiplier."""
    system, state = under_a_ceiling(1.3)
    given = {"initial": state, "transient": 0, "step": 0.1, "max_curves": 1}
    found = jp.curve(system, plane=SIDEWAYS, of="grazing", **given)
    one = found_curve(found, event="impact")
    rise = math.pi**2 / (2 * one["acceleration"].values)
    heights = one["height"].values
    assert (heights - rise) ** 2 + (FOLD / one["acceleration"].values) ** 2 == pytest.approx(1, rel=1e-8)
    assert np.any(heights < rise)  # round the fold
    assert one.sizes["point"] < 100  # steps follow the prediction, not the stages of the corrections
    assert "range" in list(one["curve_end"].values)
    kinds = jp.words(found)["meeting_kind"].values.tolist()
    tops = {"fold_grazing": FOLD, "doubling_grazing": DOUBLING}
    assert sorted(kinds) == sorted(tops)
    for kind, height, acceleration in zip(
        kinds, found["meeting_height"].values, found["meeting_acceleration"].values, strict=True
    ):
        top = math.sqrt(1 - (FOLD / tops[kind]) ** 2) + math.pi**2 / (2 * tops[kind])
        assert [acceleration, height] == pytest.approx([tops[kind], top], rel=1e-7)

    found = jp.curve(system, plane=dict(reversed(SIDEWAYS.items())), of="period_doubling", **given)
    one = found_curve(found, "period_doubling")
    assert one["acceleration"].values == pytest.approx(DOUBLING, rel=1e-9)
    assert sorted(one["curve_end"].values) == ["grazing", "range"]
    assert jp.words(found)["meeting_kind"].values.tolist() == ["doubling_grazing"]
    top = math.sqrt(1 - (FOLD / DOUBLING) ** 2) + math.pi**2 / (2 * DOUBLING)
    assert found["meeting_height"].values == pytest.approx([top], rel=1e-8)


def nearly_missed(gap, restitution, state, periods):
    """State after some periods by exact flights, and the least distance at which a wall is missed."""
    flight, missed = Flight(0.0, *state), []
    while True:
        t, side = flight.leaves(gap / 2)
        end = min(t, periods * TAU)
        times = np.linspace(flight.t, end, 400)[1:-1]
        speeds = [flight.at(time)[1] for time in times]
        for a, b, v, w in zip(times[:-1], times[1:], speeds[:-1], speeds[1:], strict=True):
            if v * w < 0:
                y = flight.at(brentq(lambda s, f=flight: f.at(s)[1], a, b, xtol=1e-14))[0]
                missed.append(gap / 2 - abs(y))
        if t > end:
            return flight.at(end), min(missed)
        flight = Flight(t, side * gap / 2, -restitution * flight.at(t)[1])


@pytest.mark.nightly
def test_a_flight_grazes_a_rigid_wall():
    """A symmetric motion of three periods, with a square-root singularity beyond the curve."""
    found = jp.curve(
        catalog.impact_pair(3.6, 0.8),
        plane={"gap": (2.3, 3.65), "restitution": (0.72, 0.88)},
        period=3,
        initial=[-0.7248467710645374, -0.18472721301220763],
        transient=0,
        of="grazing",
        step=0.1,
        max_points=16,
    )
    one = found_curve(found)
    assert one["curve_event_kind"] == "impact"
    assert one.sizes["point"] > 5
    assert np.ptp(one["restitution"].values) > 0.02
    for point in range(0, one.sizes["point"], 3):
        at = one.isel(point=point)
        gap, r, state = float(at["gap"]), float(at["restitution"]), at["orbit_state"].values
        reached, missed = nearly_missed(gap, r, state, 3)
        assert reached == pytest.approx(state, abs=1e-9)
        assert missed == pytest.approx(0, abs=1e-9)


def test_guards_are_those_of_the_flow():
    """Impact pair: the walls' gaps; and half of a wall's way a motion is nearest where its speed is 0."""
    section = section_map(
        placed(catalog.impact_pair(30.0, 0.8), [0.0, 2.0], jp.CrankAngle()), jp.CrankAngle(), 1
    )
    guards, state = Guards(section.model), np.array([0.0, 2.0])
    rows, _ = section.sampled(state, np.array([1.0, 2.0]), False)
    y = rows[:, 1]
    assert guards.margins(rows) == pytest.approx(np.stack([15 - y, 15 + y], -1), abs=1e-12)
    assert [guards.owner(g) for g in (0, 1)] == [0, 1]
    mixed = rows[[0, 1, 1, 0]]
    mixed[1:3, 3] = Mode.REST  # the first wall holds, and what it pushes with is watched
    alone = np.concatenate([guards.margins(row[None]) for row in mixed])
    assert abs(alone[1, 0]) != pytest.approx(15 - y[1], rel=0.1)
    assert np.array_equal(guards.margins(mixed), alone)
    falling = np.array([0.0, -0.5])  # v = 0.5 - cos t: lowest at pi/3
    image = section.image(falling, False)
    least, when, _ = guards.nearest(section, falling, image.time, image.events)
    value, time = guards.minimum(section, falling, 1, when[1], image.time / 720, image.time)
    assert time == pytest.approx(math.pi / 3, abs=1e-6)
    assert value == pytest.approx(15 + math.pi / 6 - math.sin(math.pi / 3), abs=1e-12)
    assert least[1] == pytest.approx(value, abs=1e-4)


@pytest.mark.nightly
def test_the_linkage_begins_to_stick_along_a_curve():
    """On either side of the curve runs have, and have not, an onset of sticking more."""
    linkage = catalog.chunmei2002(3.25e-5, gear_ratio=3.0)
    plane = {"clearance": (3.2e-5, 3.4e-5), "gear_ratio": (2.98, 3.02)}
    found = jp.curve(linkage, plane=plane, of="grazing", step=0.1, max_points=12, max_curves=1)
    one = found_curve(found, event="stick_onset")
    for point in (1, one.sizes["point"] - 2):
        at = one.isel(point=point)
        counts = []
        for share in (1 - 2e-5, 1 + 2e-5):
            there = linkage.replace(
                clearance=share * float(at["clearance"]), gear_ratio=float(at["gear_ratio"])
            )
            orbit = jp.words(jp.periodic_orbit(there, transient=60))
            counts.append(int(np.sum(orbit["event_kind"].values == "stick_onset")))
        assert abs(counts[1] - counts[0]) == 1


@pytest.mark.nightly
def test_a_doubling_meets_a_grazing_where_the_grazing_meets_a_doubling():
    """The linkage near gear ratio 3: one place, enclosed along the doubling and along the grazing."""
    found = jp.curve(
        catalog.chunmei2002(4.15e-5, gear_ratio=3.0),
        plane={"clearance": (4.1e-5, 4.24e-5), "gear_ratio": (2.95, 3.02)},
        of=["period_doubling", "grazing"],
        step=0.1,
        max_points=120,
    )
    words = jp.words(found)
    doubling = found_curve(found, "period_doubling")
    assert list(doubling["curve_end"].values) == ["range", "range"]
    assert doubling["gear_ratio"].values.min() < 2.955  # beyond the grazing it turns
    multipliers = doubling["floquet_multiplier"].values @ [1, 1j]
    assert np.max(np.min(np.abs(multipliers + 1), axis=1)) < 1e-5
    corner = found.isel(meeting=found["meeting_curve"] == int(doubling["curve"]))
    assert corner["meeting_gear_ratio"].values == pytest.approx([2.968314], abs=2e-6)
    met = words.isel(meeting=np.flatnonzero(words["meeting_kind"] == "doubling_grazing"))
    kinds = found["curve_kind"].values[met["meeting_curve"].values]
    assert len(set(kinds)) == 2
    assert met["meeting_event_kind"].values[0] == "separation"
    assert met["meeting_gear_ratio"].values == pytest.approx(2.968314, abs=2e-6)
    assert np.ptp(met["meeting_clearance"].values) < 1e-11
