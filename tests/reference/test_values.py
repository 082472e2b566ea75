"""The table of reference values: what is stored, and the exact motions of the cam and of a mesh behind it."""

import csv
import json
import math

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.solver.mechanism.assemble import assemble
from tests.reference import values
from tests.reference.values import FOLDER, SYSTEMS, Row, cam, cam_flight, meshed, pieces
from tests.support.tangent_map import tangent_map

QUICK = ("bouncing_ball", "rocking_block", "stick_slip", "ivp_crank", "rimless_wheel")
PEERS = {"exudyn_slider_crank": "exudyn", "heyoka_valve": "heyoka"}
SICONOS = {  # s: radius less 0.3 m and its rate at 358 rpm, of the stored CF.ref
    0.01: (0.1151296915, 3.0753695346),
    0.028: (0.2310860392, 10.2905875942),
    0.0301: (0.2473802608, 5.3179505774),
    0.07: (0.1292317819, -4.3654234545),
    0.12: (0.1, 0.0),
    0.21: (0.2539332072, 0.0),
}


def stored():
    with (FOLDER / "reference.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_table_has_every_system_as_it_is_and_every_row_agrees():
    rows = stored()
    assert {row["system"] for row in rows} == {title for title, _, _ in SYSTEMS.values()}
    assert len(SYSTEMS) >= 24
    for title, mechanism, _ in SYSTEMS.values():
        own = [row for row in rows if row["system"] == title]
        assert len({row["quantity"] for row in own}) == len(own) > 0
        assert {row["mechanism"] for row in own} == {values.in_full(mechanism)}
        again = type(mechanism).model_validate(json.loads(own[0]["mechanism"]))
        assert again == mechanism
    numbers = ("value", "error", "confirmed", "confirmed_error")
    for row in rows:
        found = {name: float(row[name]) for name in numbers}
        assert Row(row["quantity"], row["units"], method="", confirmed_by="", **found).agrees


def test_netcdf_and_csv_are_one_table():
    rows = stored()
    with xr.open_dataset(FOLDER / "reference.nc") as found:
        for name in ("system", "quantity", "units", "method", "confirmed_by", "mechanism"):
            assert found[name].values.tolist() == [row[name] for row in rows]
        for name in ("value", "error", "confirmed", "confirmed_error"):
            assert found[name].values.tolist() == [float(row[name]) for row in rows]


def test_a_row_whose_values_are_apart_is_refused():
    row = Row("largest exponent", "1", 0.2379, 1e-4, "lyapunov", "exact map", 0.2386, 1e-4)
    assert not row.agrees
    assert Row("", "1", 0.2379, 1e-4, "", "", 0.2382, 1e-4).agrees
    assert not Row("", "m", 4.2e-5, 0.0, "", "", 4.2001e-5).agrees


def again(name):
    rows = {row["quantity"]: row for row in stored() if row["system"] == SYSTEMS[name][0]}
    for row in values.rows_of(name):
        for key in ("value", "confirmed"):
            known, error = float(rows[row["quantity"]][key]), float(rows[row["quantity"]]["error"])
            assert row[key] == pytest.approx(known, rel=1e-9, abs=3 * (error + row["confirmed_error"]))


@pytest.mark.nightly
@pytest.mark.parametrize("name", QUICK)
def test_rows_made_anew_are_those_stored(name):
    again(name)


@pytest.mark.nightly
@pytest.mark.parametrize("name", [name for name in SYSTEMS if name not in QUICK])
def test_all_others_made_anew_are_those_stored(name):
    pytest.importorskip(PEERS.get(name, "numpy"))
    again(name)


def test_made_twice_the_same_digits():
    assert values.rows_of("rimless_wheel") == values.rows_of("rimless_wheel")


def test_the_cam_is_the_one_of_siconos():
    speed = 358 / 60 * 2 * 3.14159265
    for t, (lift, rate) in SICONOS.items():
        radius, slope = cam(speed * t)
        assert radius - 0.3 == pytest.approx(lift, abs=3e-8)
        assert speed * slope == pytest.approx(rate, abs=3e-6)


@pytest.mark.parametrize("rpm", [358, 660])
def test_a_follower_hits_its_cam_where_exact_flights_do(rpm):
    """Ten impacts: chaos at these speeds doubles an error from one to the next."""
    speed = rpm * math.pi / 30
    follower = catalog.cam_follower(speed=speed, mass=1.3)
    found = jp.simulate(follower, duration=12 * math.pi / speed, rtol=1e-12)
    names = jp.words(found)["event_joint"].values
    hits = found["event_time"].values[names == "cam"]
    t, p, r = hits[0], follower.parameters, follower.parameters["restitution"]
    at = jp.simulate(follower, duration=t * (1 - 1e-9), at=[t * (1 - 1e-9)], rtol=1e-12).state_value.values[0]
    v = speed * cam(speed * t)[1] - r * at[1]
    for hit in hits[1:11]:
        t, before, _ = cam_flight(p, t, v)
        assert hit == pytest.approx(t, abs=1e-8)
        v = (1 + r) * speed * cam(speed * t)[1] - r * before


def test_tangents_of_a_follower_are_those_of_its_neighbours():
    follower = catalog.cam_follower(speed=69.0)
    until, start = 0.31, np.array([0.02, 1.0])

    def end(state):
        modes = assemble(follower).state[2:]
        run = jp.simulate(follower, duration=until + 1e-9, at=[until], initial=[*state, *modes], rtol=1e-13)
        return run.state_value.values[0, :2]

    model = assemble(follower, [*start, *assemble(follower).state[2:]])
    found = tangent_map(model, until, 1e-12)[:2, :2]
    h = 1e-6
    exact = np.transpose([(end(start + d) - end(start - d)) / (2 * h) for d in h * np.eye(2)])
    assert found == pytest.approx(exact, rel=1e-6, abs=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize(("speed", "leaves"), [(12.03, False), (12.05, True)])
def test_a_follower_leaves_its_cam_at_the_corner(speed, leaves):
    """Its force first comes to 0 where the cam's curvature jumps, where the nose begins; then at its end."""
    corner = 1.050328174371336
    run = jp.simulate(catalog.cam_follower(speed=speed), turns=12, rtol=1e-11)
    assert int(run["status"]) == 0
    late = run["event_time"].values > 10 * 2 * math.pi / speed
    away = run["event_time"].values[late & (jp.words(run)["event_kind"].values == "separation")]
    turns = (speed * away) % (2 * math.pi)
    assert len(turns) == 4 * leaves
    assert turns[::2] == pytest.approx([corner] * len(turns[::2]), abs=1e-9)
    assert ((turns[1::2] > math.pi - corner - 0.01) & (turns[1::2] < math.pi - corner)).all()


def test_gears_whose_mesh_varies_move_as_scipy_says():
    gears = catalog.gear_backlash(0.1, 0.2, 1.6, 0.05, mesh=0.3)
    start, until = np.array([0.5, 0.0, 1, 0, 0, 1]), 9.0
    end = pieces(meshed, start, until, [lambda x: x[0] - 1, lambda x: x[0] + 1], gears.parameters)
    run = jp.simulate(gears, duration=until + 1e-9, at=[until], rtol=1e-12)
    assert len(run["event_time"]) > 3
    assert run.state_value.values[0] == pytest.approx(end[:2], abs=1e-9)
    found = tangent_map(assemble(gears), until, 1e-12)
    assert found.T.ravel() == pytest.approx(end[2:], abs=1e-7)


def test_a_mesh_of_constant_stiffness_is_the_pair_it_was():
    assert catalog.gear_backlash(0.1, 0.2, 1.6, 0.05, mesh=0.0) == catalog.gear_backlash(0.1, 0.2, 1.6, 0.05)
    with pytest.raises(jp.InputError, match=r"mesh.*less than 1"):
        catalog.gear_backlash(0.1, 0.2, 1.6, 0.05, mesh=1.0)
