"""The catalog against Table 1 of the paper and the known systems."""

import inspect
import math

import pytest

from jointplay.display.errors import NOTHING, InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.catalog import presets, published
from jointplay.solver.mechanism.own import systems
from jointplay.solver.mechanism.records import Mechanism, MotorLine, TestSystem
from jointplay.solver.mechanism.signature import Preset
from tests.support.wrong import problems_of

REQUIRED = {name: make.trial for name, make in catalog.NAMES.items() if make.trial}
LINKAGES = [
    *("chunmei2002", "slider_crank", "watt", "stephenson", "quick_return"),
    *("ivp_crank", "flores2010", "siconos_four_bar"),
]
HOMES = (catalog, presets, published, systems)
SYSTEMS = [name for name in catalog.NAMES if name not in LINKAGES]


@pytest.mark.parametrize(
    ("entry", "given", "key"),
    [
        ("watt", {"output": 1e200}, "output"),
        ("stephenson", {"arm": 1e300}, "arm"),
        ("quick_return", {"rod": 1e300}, "rod"),
        ("slider_crank", {"rod": 1e200}, "rod"),
        ("slider_crank", {"centre": {"rod": -1e200}}, "centre.rod"),
    ],
)
def test_lengths_whose_squares_are_no_numbers_are_refused(entry, given, key):
    ((wrong, problem),) = problems_of(getattr(catalog, entry), **given).items()
    assert wrong == key
    assert "1e9" in str(problem)


# Chunmei et al. (2002)


def test_table_1_links():
    mechanism = catalog.chunmei2002()
    rows = {link.name: (link.length, link.mass, link.inertia) for link in mechanism.links}
    assert rows == {
        "crank": (0.03, 0.4489, 1.5e-4),
        "coupler": (0.181, 0.1743, 2.7e-3),
        "rocker": (0.1175, 0.2916, 1.34e-3),
    }
    assert [link.centre for link in mechanism.links] == [0.015, 0.0905, 0.05875]
    assert mechanism.gravity == 9.8
    assert mechanism.branch == "upper"


def test_table_1_joints():
    mechanism = catalog.chunmei2002()
    assert [joint.name for joint in mechanism.joints] == ["O", "A", "B", "C"]
    assert [joint.journal.link for joint in mechanism.joints] == ["crank", "crank", "coupler", "rocker"]
    assert [joint.bearing.link for joint in mechanism.joints] == ["ground", "coupler", "rocker", "ground"]
    assert [joint.journal.at for joint in mechanism.joints] == [0, 0.03, 0.181, 0]
    assert [joint.bearing.at for joint in mechanism.joints] == [0, 0, 0.1175, 0]
    assert [mechanism.joint(name).bearing.point for name in "OC"] == [(0, 0), (0.2, 0)]
    assert [joint.clearance for joint in mechanism.joints] == [0, 0, 2.9e-5, 0]
    for joint in mechanism.joints:
        assert joint.radius == 0.015
        assert (joint.contact.stiffness, joint.contact.damping, joint.contact.tension) == (7.15e6, 228, True)
        assert (joint.friction.coefficient, joint.friction.viscous) == (0.01, 0)


def test_table_1_motor():
    drive = catalog.chunmei2002().drive
    assert isinstance(drive, MotorLine)
    assert drive.link == "crank"
    assert drive.gear_ratio == 15
    assert drive.efficiency == 0.8
    assert drive.synchronous_speed == pytest.approx(100 * math.pi)
    assert drive.rated_speed == pytest.approx(2825 * 2 * math.pi / 60)
    assert drive.rated_torque == pytest.approx(21.56)
    assert not drive.efficiency_in_slope


@pytest.mark.parametrize("ratio", [15.0, 3.0])
def test_motor_line_is_the_printed_one(ratio):
    """Equations (1) and (2), in the paper's rpm and kg·m."""
    mu, n_C, n_B, M_b = 0.8, 3000, 2825, 2.2
    drive = catalog.chunmei2002(gear_ratio=ratio).drive
    assert drive.stall_torque == pytest.approx(ratio * mu * 9.8 * n_C * M_b / (n_C - n_B))
    assert drive.slope == pytest.approx(ratio**2 * 60 * 9.8 * M_b / (2 * math.pi * (n_C - n_B)))
    consistent = catalog.chunmei2002(gear_ratio=ratio, efficiency_in_slope=True).drive
    assert consistent.slope == pytest.approx(mu * drive.slope)
    assert consistent.no_load_speed == pytest.approx(100 * math.pi / ratio)


@pytest.mark.parametrize(("ratio", "speed"), [(15, 16.755), (3, 83.776)])
def test_no_load_speed(ratio, speed):
    drive = catalog.chunmei2002(gear_ratio=ratio).drive
    assert drive.no_load_speed == pytest.approx(speed, abs=5e-4)
    assert drive.stall_torque - drive.slope * drive.no_load_speed == pytest.approx(0, abs=1e-9)
    assert drive.nominal_speed == drive.no_load_speed


def test_clearance_at_any_joints():
    assert catalog.chunmei2002(clearance=0).clearance_joints == ()
    assert catalog.chunmei2002(clearance={"B": 0}).clearance_joints == ()
    everywhere = dict.fromkeys("OABC", 1e-5)
    assert len(catalog.chunmei2002(clearance=everywhere).clearance_joints) == 4


def test_a_speed_replaces_the_motor():
    assert catalog.chunmei2002(speed=16.755).drive.nominal_speed == 16.755
    assert catalog.chunmei2002(drive=None).drive is None
    assert set(problems_of(catalog.chunmei2002, speed=16.755, gear_ratio=3)) == {"gear_ratio"}


def test_every_wrong_change_at_once():
    found = problems_of(catalog.chunmei2002, clearance=-1e-5, gear_ratio=0, fricton=0.1)
    assert set(found) == {"clearance", "gear_ratio", "fricton"}
    assert "did you mean 'friction'?" in found["fricton"].expected
    assert found["clearance"].given == -1e-5


# Test systems


@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_are_named_by_their_function(name):
    function = catalog.NAMES[name]
    record = function(**REQUIRED.get(name, {}))
    assert isinstance(record, TestSystem)
    assert record.system == record.name == name == function.__name__
    assert list(record.parameters) == list(inspect.signature(function).parameters)
    assert function(**record.parameters) == record
    assert hash(record) == hash(function(**record.parameters))


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("lorenz", {"sigma": 10, "rho": 28, "beta": 8 / 3}),
        ("rossler", {"a": 0.2, "b": 0.2, "c": 5.7}),
        ("duffing", {"amplitude": 0.3, "damping": 0.2, "frequency": 1}),
    ],
)
def test_defaults_are_those_with_known_exponents(name, parameters):
    assert catalog.NAMES[name]().parameters == parameters


def test_periods_follow_the_forcing():
    assert catalog.lorenz().period is None
    assert catalog.rossler().period is None
    assert catalog.duffing(frequency=2).period == pytest.approx(math.pi)
    assert catalog.gear_backlash(0.1, 0.2, 1.6, 0.05).period == pytest.approx(2 * math.pi / 1.6)
    for name in ("impact_pair", "soft_impact_pair", "bouncing_ball"):
        assert catalog.NAMES[name](**REQUIRED[name]).period == 2 * math.pi


def test_gear_pair_starts_as_its_known_exponents_do():
    assert catalog.gear_backlash(0.1, 0.2, 1.6, 0.05).initial == (0.5, 0.0)


@pytest.mark.parametrize("acceleration", [0.9, 1.05, 1.2, 1.5, 3.0])
def test_ball_starts_above_the_table_near_one_bounce_a_period(acceleration):
    ratio = 0.5
    y, v = catalog.bouncing_ball(acceleration, ratio).initial
    assert y > 0
    cosine = min(1, math.pi * (1 - ratio) / (acceleration * (1 + ratio)))
    bounce = math.acos(cosine)
    fall = bounce  # time from 0 to the bounce
    hit = y - 0.01 + v * fall - fall**2 / (2 * acceleration)
    assert hit == pytest.approx(math.sin(bounce), abs=1e-12)
    incoming = v - fall / acceleration
    if cosine < 1:
        assert -ratio * incoming + (1 + ratio) * cosine == pytest.approx(math.pi / acceleration)


def test_soft_pair_keeps_its_switch():
    assert catalog.soft_impact_pair(1, 1e4, 3).initial == (0.0, 0.0)
    assert catalog.soft_impact_pair(1, 1e4, 3).parameters["tension"] is True
    assert catalog.soft_impact_pair(1, 1e4, 3, tension=False).parameters["tension"] is False


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("lorenz", {"sigma": "ten", "rho": float("nan")}),
        ("rossler", {"a": None}),
        ("duffing", {"amplitude": -1, "damping": -1, "frequency": 0}),
        ("impact_pair", {"gap": 0, "restitution": 1.1}),
        ("impact_pair", {"restitution": -0.1}),
        ("soft_impact_pair", {"gap": -1, "stiffness": 0, "damping": -1, "tension": "no"}),
        ("bouncing_ball", {"acceleration": 0, "restitution": 2}),
        ("gear_backlash", {"mean_load": float("inf"), "amplitude": -1, "frequency": 0, "damping": -1}),
    ],
)
def test_every_wrong_parameter_at_once(name, bad):
    assert set(problems_of(catalog.NAMES[name], **REQUIRED.get(name, {}) | bad)) == set(bad)


def test_unknown_and_missing_parameters():
    found = problems_of(catalog.impact_pair, 0.4, restituton=0.8)
    assert found["restitution"].given is NOTHING
    assert "did you mean 'restitution'?" in found["restituton"].expected


def test_replace_recomputes_what_follows_from_the_parameters():
    ball = catalog.bouncing_ball(1.2, 0.5)
    assert ball.replace(acceleration=1.3) == catalog.bouncing_ball(1.3, 0.5)
    moved = ball.replace(acceleration=1.3, initial=(5.0, 0.0))
    assert (moved.initial, moved.parameters["acceleration"]) == ((5.0, 0.0), 1.3)
    found = problems_of(ball.replace, aceleration=1, restitution=-1)
    assert set(found) == {"aceleration", "restitution"}
    assert set(problems_of(ball.replace, initial=("up", 0))) == {"system.states.y"}


def test_names_are_complete():
    assert isinstance(catalog.NAMES["chunmei2002"](), Mechanism)
    functions = [f for home in HOMES for f in vars(home).values() if inspect.isfunction(f)]
    here = [f for f in functions if f.__module__ in [home.__name__ for home in HOMES]]
    public = {f.__name__: f for f in here if isinstance(f, Preset)}
    assert catalog.NAMES == public == {name: getattr(catalog, name) for name in public}


def test_presets_take_values_with_units():
    found = catalog.slider_crank(clearance="0.2 mm", speed="1500 rpm", crank="5 cm")
    assert found == catalog.slider_crank(clearance=2e-4, speed=50 * math.pi, crank=0.05)
    assert catalog.slider_crank(clearance={"A": "20 um"}).joint("A").clearance == 2e-5
    tables = {"mass": {"rod": "300 g"}, "inertia_centre": {"rod": "4 kg cm²"}, "centre": {"rod": "40 mm"}}
    numbers = {"mass": {"rod": 0.3}, "inertia_centre": {"rod": 4e-4}, "centre": {"rod": 0.04}}
    assert catalog.slider_crank(**tables) == catalog.slider_crank(**numbers)


def test_presets_name_the_link_whose_number_is_wrong():
    wrong = {"mass": {"slider": -1.0}, "inertia_centre": {"crank": 0.0}, "centre": {"rod": "2 kg"}}
    found = problems_of(catalog.slider_crank, **wrong)
    assert set(found) == {"mass.slider", "inertia_centre.crank", "centre.rod"}


def test_the_slider_crank_lies_flat_unless_gravity_is_asked_for():
    assert catalog.slider_crank().gravity == 0.0
    assert catalog.slider_crank(gravity=9.8).gravity == 9.8


@pytest.mark.parametrize(
    ("preset", "own"),
    [
        (catalog.slider_crank, ["crank", "rod", "offset", "mass"]),
        (catalog.quick_return, ["crank", "arm", "rod", "pivot"]),
        (catalog.chunmei2002, ["clearance", "gear_ratio"]),
    ],
)
def test_what_is_accepted_is_what_this_preset_accepts(preset, own):
    with pytest.raises(InputError) as caught:
        preset(crank_length=1)
    (problem,) = caught.value.problems
    accepted = str(problem.expected).partition("accepted: ")[2].split(", ")
    assert problem.key == "crank_length"
    assert accepted[: len(own)] == own
    assert len({*accepted}) == len(accepted)
    assert {"gravity", "friction", "springs"} <= {*accepted}
