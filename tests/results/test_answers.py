"""Answers in words, on small results made by hand: what is said follows from numbers and their errors."""

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay.analysis.labels import flags
from jointplay.analysis.orbits.branch import ENDS
from jointplay.analysis.orbits.branch_points import KINDS as SPECIAL
from jointplay.analysis.orbits.orbit_dataset import STABILITY
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.sweeps.bifurcation import motions
from jointplay.kinds import KINDS
from jointplay.solver.method.codes import Event, Mode

MINUS = "\N{MINUS SIGN}"


def var(dims, values, units="1", **attributes):
    return dims, np.asarray(values), {"units": units, "long_name": "x"} | attributes


def coded(dims, values, meanings):
    return dims, np.asarray(values, dtype=np.int8), flags(tuple(meanings))


def result(kind, variables, coords=None, status=0, **attributes):
    return xr.Dataset({"status": coded((), status, STATUS)} | variables, coords, {"kind": kind} | attributes)


def said(dataset):
    return list(jp.summary(dataset).lines)


def exponents(value, error, correlation=0.0, **more):
    names = ("section_exponent_per_turn", "section_standard_error_per_turn", "section_batch_correlation")
    variables = {n: var("multiplier", [v]) for n, v in zip(names, (value, error, correlation), strict=True)}
    variables |= {"section_exponent": var("multiplier", [10 * value], "s-1")}
    return result("lyapunov", variables | more)


@pytest.mark.parametrize(
    ("value", "error", "correlation", "words"),
    [
        (1.64, 0.07, 0.0, "+1.640 ± 0.070 per turn: chaotic"),
        (-1.47, 0.05, -0.9, f"{MINUS}1.470 ± 0.050 per turn: stable"),
        (0.2, 0.07, 0.0, "+0.200 ± 0.070 per turn: undecided"),
        (1.64, 0.07, 0.5, "+1.640 ± 0.070 per turn: chaotic"),
        (1.64, 0.07, 0.99, "+1.640 ± 0.070 per turn: undecided"),
        (0.3, 0.07, 0.3, "+0.300 ± 0.070 per turn: chaotic"),
        (0.3, 0.07, 0.5, "+0.300 ± 0.070 per turn: undecided"),
        (0.3, 0.07, 1.0, "+0.300 ± 0.070 per turn: undecided"),
        (1.64, np.nan, 0.0, "+1.64 per turn: undecided"),
        (-np.inf, np.nan, 0.0, f"{MINUS}∞ per turn: stable"),
    ],
)
def test_chaotic_is_said_only_by_the_error(value, error, correlation, words):
    lines = said(exponents(value, error, correlation))
    assert lines[0] == f"largest exponent of the section map {words}"
    assert ("take more turns" in lines[-1]) == ("undecided" in words)


@pytest.mark.parametrize(
    ("value", "word"), [(0.00227, "undecided"), (0.008, "undecided"), (0.009, "chaotic")]
)
def test_neighbours_that_part_no_faster_than_time_are_no_chaos(value, word):
    """ln 800 / 800 is 0.00836."""
    turns = {"exponent_turns": var((), 800.0)}
    lines = said(exponents(value, 0.00064, **turns))
    assert lines[0].endswith(word)
    assert ("not chaotic may part as fast" in lines[-1]) == (word == "undecided")
    pair = {
        f"section_{name}_per_turn": var(("speed", "multiplier"), [[each]])
        for name, each in (("exponent", value), ("standard_error", 0.00064))
    }
    found = {"period": var("speed", [0]), "cell_status": coded("speed", [0], STATUS)}
    diagram = result(
        "bifurcation", found | pair | {"exponent_turns": var("speed", [800.0])}, {"speed": [1.0]}
    )
    assert motions(diagram).item() == ("chaotic" if word == "chaotic" else "no period found")


def test_unknown_exponents_and_twins():
    assert said(exponents(np.nan, np.nan)) == ["largest exponent of the section map: not known"]
    twins = {"growth": 1.6, "growth_standard_error": 0.12, "growth_difference": -0.4}
    lines = said(exponents(1.64, 0.07, **{name: var((), value) for name, value in twins.items()}))
    assert (
        lines[1]
        == "by twin trajectories, without Jacobians: +1.60 ± 0.12 per turn, 0.4 standard errors from it"
    )


def test_a_motion_at_rest_has_the_flow_s():
    names = ("lyapunov_exponent", "lyapunov_standard_error")
    flow = {n: var("exponent", [v], "s-1") for n, v in zip(names, (-0.48, 0.01), strict=True)}
    line = said(exponents(np.nan, np.nan, **flow))[0]
    assert line.startswith(
        f"largest exponent of the flow {MINUS}0.480 ± 0.010 per second; the motion is at rest"
    )


def test_a_flow_s_exponents_alone_do_not_tell_stability():
    """As in results without those of the section's map: of a motor-driven linkage, 0 is the largest."""
    names = ("lyapunov_exponent", "lyapunov_standard_error")
    flow = {n: var("exponent", [v], "s-1") for n, v in zip(names, (0.0001, 0.01), strict=True)}
    assert said(result("lyapunov", flow))[0].endswith("0.000 ± 0.010 per second: undecided")


def test_a_failed_run_says_so_first():
    lines = said(exponents(np.nan, np.nan).assign(status=coded((), 2, STATUS)))
    assert lines[0].startswith("stopped early: step_limit")


def test_a_status_that_is_not_one_is_refused():
    one = exponents(1.64, 0.07)
    several = xr.concat([one, one], "case")
    with pytest.raises(jp.InputError, match="status: got '2 of them, over case'"):
        jp.summary(several)
    assert said(several.isel(case=0)) == said(one)
    for odd in (one.drop_vars("status"), one.assign(status=3), one.assign(status=one.status + 100)):
        with pytest.raises(jp.InputError, match="one status is accepted"):
            jp.summary(odd)


def swept(kind, variables, clearance, status=None):
    n = len(clearance)
    coords = {"clearance": var("clearance", clearance, "m")}
    ends = {"cell_status": coded("clearance", [0] * n if status is None else status, STATUS)}
    return result(kind, variables | ends, coords, swept="clearance")


def test_a_sweep_of_exponents_failed_cells_first():
    values = np.array([[-1.0], [-0.5], [0.9], [1.2], [0.01], [np.nan]])
    errors = np.full_like(values, 0.05)
    variables = {"section_exponent_per_turn": var(("clearance", "multiplier"), values)}
    variables |= {"section_exponent": var(("clearance", "multiplier"), values)}
    variables |= {"section_standard_error_per_turn": var(("clearance", "multiplier"), errors)}
    clearance = [1e-5, 2e-5, 2.1e-4, 2.9e-4, 3e-4, 4e-4]
    assert said(swept("lyapunov", variables, clearance, [0, 0, 0, 0, 0, 2])) == [
        "1 of 6 failed: 1 step_limit (clearance 400 µm)",
        "chaotic at 2 of 6 values; stable at 2 (clearance 10 µm to 20 µm); "
        "failed at 1 (clearance 400 µm); undecided at 1 (clearance 300 µm)",
        f"largest exponent of the section's map, per turn: from {MINUS}1 (clearance 10 µm) "
        "to 1.2 (clearance 290 µm)",
    ]
    assert said(swept("lyapunov", variables, clearance, [2] * 6)) == [
        "6 of 6 failed: 6 step_limit (clearance 10 µm to 400 µm)"
    ]


def diagram(period, exponent=None, directions=("up",)):
    period = np.array(period)
    dims = ("clearance", "direction")
    variables = {"period": var(dims, period), "cell_status": coded(dims, np.zeros_like(period), STATUS)}
    if exponent is not None:
        for name, values in (("exponent", exponent), ("standard_error", np.full(period.shape, 0.1))):
            variables[f"section_{name}_per_turn"] = var((*dims, "multiplier"), np.array(values)[..., None])
    coords = {
        "clearance": var("clearance", np.linspace(1e-4, 4e-4, len(period)), "m"),
        "direction": ("direction", list(directions)),
    }
    return result("bifurcation", variables, coords)


def test_a_diagram():
    period, exponent = [[1], [1], [0], [2]], [[-1.0], [-0.2], [0.9], [-0.3]]
    assert said(diagram(period, exponent)) == [
        "period 1 at 2 of 4 values; chaotic at 1 (clearance 300 µm); period 2 at 1 (clearance 400 µm)"
    ]
    assert "no period found at 1" in said(diagram(period))[0]
    unsure = [[-1.0], [-0.2], [0.2], [-0.3]]
    assert "no period found at 1" in said(diagram(period, unsure))[0]
    assert "not known at 1" in said(diagram([[1], [1], [-1], [1]], exponent))[0]
    assert said(diagram([[1], [1], [1], [1]])) == ["period 1 at all 4 values"]


def test_a_window_in_chaos_is_told_with_its_two_ends():
    """Between values that are chaotic and less than 1 % apart; one of 3 % is a stretch like others."""
    clearance = np.array([90.0, 93.0, 93.2, 93.4, 96.0, 97.0, 99.0, 99.2, 99.4])
    period = np.array([[0], [0], [2], [0], [0], [3], [0], [0], [1]])
    found = diagram(period, np.full((9, 1), 0.9)).assign_coords(
        clearance=var("clearance", 1e-6 * clearance, "m")
    )
    assert said(found)[1:] == [
        "windows within chaos, each narrower than 1 % of the value: 93 µm to 93.4 µm (period 2)"
    ]
    up = diagram(period[::-1], np.full((9, 1), 0.9))
    coords = up.assign_coords(clearance=var("clearance", 1e-6 * clearance[::-1], "m"))
    assert said(coords)[1:] == [
        "windows within chaos, each narrower than 1 % of the value: 93.4 µm to 93 µm (period 2)"
    ]


def test_many_words_and_stretches_are_counted():
    many = said(diagram([[1], [1], [2], [3], [4], [5], [6], [8]]))[0]
    assert many.startswith("period 1 at 2 of 8 values; period 2 at 1 (clearance ")
    assert many.endswith("; 3 more at 3")
    scattered = said(diagram([[1], [2]] * 4 + [[1]]))[0]
    assert scattered.endswith("period 2 at 4 in 4 stretches of clearance 137.5 µm to 362.5 µm")


def test_two_parameters():
    flat = diagram([[1], [2], [2], [1], [1], [1]]).isel(direction=0, drop=True)
    gap, cells = ("gap", [1.0, 2.0], {"units": "1"}), {"clearance": 3, "gap": 2}
    grid = {
        name: (tuple(cells), flat[name].values.reshape(3, 2), flat[name].attrs)
        for name in ("period", "cell_status")
    }
    found = result("bifurcation", grid, {"gap": gap, "clearance": var("clearance", [1e-4, 2e-4, 3e-4], "m")})
    assert said(found) == [
        "period 1 at 4 of 6 values; period 2 at 2 (clearance 100 µm to 200 µm, gap 1 to 2)"
    ]


def test_directions_that_differ():
    lines = said(diagram([[1, 1], [1, 2], [1, 2], [1, 1]], directions=("up", "down")))
    assert lines == [
        "up: period 1 at all 4 values",
        "down: period 1 at 2 of 4 values; period 2 at 2 (clearance 200 µm to 300 µm)",
        "motions coexist at 2 of 4 values (clearance 200 µm to 300 µm)",
    ]
    unsure = said(diagram([[1, 1], [1, 0], [1, 0], [1, 1]], directions=("up", "down")))
    assert len(unsure) == 2  # a transient that lasts long has no period either
    failed = result("bifurcation", {"cell_status": coded(("gap", "direction"), [[2], [2]], STATUS)})
    assert said(failed.assign_coords(gap=[1.0, 2.0])) == ["2 of 2 failed: 2 step_limit (gap 1 to 2)"]


def orbit(multiplier, stable, period=1.0):
    numbers = {"period": period, "residual": 2e-14, "impacts": 1.0}
    variables = {name: var((), value) for name, value in numbers.items()}
    variables |= {"period_time": var((), 0.075, "s"), "stable": coded((), stable, STABILITY)}
    variables |= {"clearance": var("joint", [2.9e-5], "m")}
    return result(
        "periodic_orbit", variables | {"floquet_multiplier": var(("multiplier", "part"), [multiplier])}
    )


def test_an_orbit():
    assert said(orbit((0.073, 0.0), 1)) == [
        "period 1, stable, largest multiplier 0.073",
        "it lasts 75 ms, contacts begun per turn: 1, closed to a residual of 2 × 10⁻¹⁴",
    ]
    pair = said(orbit((-0.372, 0.668), 1))[0]
    assert pair == f"period 1, stable, largest multiplier 0.765 in modulus ({MINUS}0.372 ± 0.668i)"
    assert said(orbit((-1.2, 0.0), 0))[0] == f"period 1, unstable, largest multiplier {MINUS}1.2"
    assert said(orbit((np.nan, np.nan), 2, np.nan))[0].startswith("no periodic orbit was found")


def branches(ends, special=((), ())):
    n = 5
    clearance = np.linspace(9.22e-5, 1.065e-4, n)
    variables = {
        "clearance": var(("branch", "point"), [[*clearance, np.nan]], "m"),
        "n_points": var("branch", [n]),
        "period": var(("branch", "point"), [[1.0] * n + [np.nan]]),
        "stable": coded(("branch", "point"), [[1, 1, 1, 0, 0, 2]], STABILITY),
        "branch_end": coded(("branch", "end"), [[ENDS.index(end) for end in ends]], ENDS),
        "special_kind": coded("special", [SPECIAL.index(kind) for kind in special[0]], SPECIAL),
        "special_parameter": var("special", np.array(special[1], dtype=float), "m"),
    }
    return result("continuation", variables, parameter="joints.B.clearance")


def test_a_branch():
    assert said(branches(("max_points", "range"))) == [
        "branch 1, period 1, stable at 3 of 5 points: "
        "ended at 92.2 µm: the limit on the number of points and ended at 106.5 µm: end of the range",
        "no bifurcation was found",
    ]
    special = (("period_doubling", "grazing", "grazing"), (9.5e-5, 9.6e-5, 9.7e-5))
    lines = said(branches(("range", "range"), special))
    assert "over the whole range, 92.2 µm to 106.5 µm" in lines[0]
    assert lines[1] == "period doubling at 95 µm, 2 grazings (an event appears or vanishes)"


def test_basins():
    numbers = {"period": [1, 0], "fraction": [0.25, 0.7], "fraction_standard_error": [0.02, 0.02]}
    variables = {name: var("number", values) for name, values in numbers.items()}
    single = {"fraction_none": 0.05, "boundary_dimension": 1.4, "uncertainty_exponent_standard_error": 0.1}
    variables |= {name: var((), value) for name, value in single.items()}
    assert said(result("basins", variables)) == [
        "2 attractors, with their shares of the starts: no period (70.0 ± 2.0) %, period 1 (25.0 ± 2.0) %",
        "5 % of the starts reached no attractor",
        "the boundary of the basins has dimension 1.40 ± 0.10 in the plane",
    ]


def test_a_sweep_of_what_tips_motions_tells_the_share_of_the_most_frequent_one():
    variables = {
        "cell_status": coded("clearance", [0, 0], STATUS),
        "fraction": var(("clearance", "number"), [[0.25, 0.5], [0.75, np.nan]]),
    }
    coords = {"clearance": var("clearance", [1e-4, 2e-4], "m"), "number": ("number", [1, 2])}
    found = result("tipping", variables, coords, swept="clearance")
    assert said(found)[-1] == (
        "fraction of the starts with the most frequent motion: "
        "from 0.5 (clearance 100 µm) to 0.75 (clearance 200 µm)"
    )
    assert said(found.isel(number=slice(0))) == ["2 values, all ok"]


def test_a_knock_that_is_not_confirmed_says_why():
    dims, word = ("number", "knock"), "impulse:rocker"
    numbers = {"knock_size": 3e-4, "knock_safe": 2.99e-4, "confirmed_size": 3.1e-4, "tipping_share": 0.73}
    numbers |= {"knock_reaches": 2, "knock_confirmed": 0, "edge_period": 0}

    def answer(**changes):
        table = {name: var(dims, [[value]] * 2) for name, value in (numbers | changes).items()}
        table |= {"period": var("number", [1, 0]), "knock_units": var("knock", ["N m s"])}
        return said(result("tipping", table, {"number": [1, 2], "knock": [word]}))[0]

    assert answer() == (
        f"motion 1 (period 1): {word} of 0.0003 N m s leads to motion 2 "
        "(not confirmed: all smaller ones that were tried return, "
        "73 % of those up to 1.2 times its size tip, as at a fractal boundary, 0.00031 N m s is confirmed)"
    )
    assert "those up to 0.0001 N m s that were tried return" in answer(knock_safe=1e-4)
    assert "boundary, none is confirmed" in answer(confirmed_size=np.nan)
    assert answer(knock_confirmed=1) == f"motion 1 (period 1): {word} of 0.0003 N m s leads to motion 2"


def test_the_test_for_chaos_says_that_it_is_a_test():
    quartiles = var("quartile", [0.99, 0.995, 1.0])
    variables = {"chaos_indicator_quartile": quartiles}
    variables |= {"verdict": coded((), 2, ("undecided", "regular", "chaotic"))}
    lines = said(result("chaos_test", variables, {"quartile": [0.25, 0.5, 0.75]}))
    assert lines == [
        "0-1 test: chaotic, K = 0.995 (quartiles 0.990 to 1.000)",
        "the test has no error bar; a Lyapunov exponent decides (kind = 'lyapunov')",
    ]


def test_spectrum_dimension_sensitivity():
    variables = {
        "power_spectral_density": var("frequency", [9.0, 1.0, 3.0, 2.0], "N2 Hz-1"),
        "variance": var((), 4.0, "N2", long_name="variance of force, B"),
        "order": var("frequency", [0.0, 0.5, 1.0, 1.5]),
    }
    spectrum = result("spectrum", variables, {"frequency": var("frequency", [0.0, 10.0, 20.0, 30.0], "Hz")})
    assert said(spectrum) == ["force, B: highest density at 20 Hz, order 1; standard deviation 2 N"]
    for value, words in ((1.44, "1.44 ± 0.10 of 500"), (0.0, "0 of 500"), (np.nan, "not known")):
        names = [f"correlation_dimension{each}" for each in ("", "_spread", "_standard_error")]
        found = {n: var((), v) for n, v in zip([*names, "n_points"], (value, 0.1, 0.0, 500), strict=True)}
        assert words in said(result("dimension", found))[0]
    for value, word in (
        (1.6, "it grows"),
        (-1.6, "it shrinks"),
        (0.1, "undecided"),
        (np.nan, "not measured"),
    ):
        growth = {"growth": var((), value), "growth_standard_error": var((), 0.1)}
        assert word in said(result("sensitivity", growth))[0]
    field = {"finite_time_exponent_per_turn": var(("x", "y"), [[-1.0, 2.0], [np.nan, 3.0]])}
    assert said(result("sensitivity", field)) == [
        "finite-time exponents from −1 to 3 per turn, above 0 at 2 of 3 starts".replace("−", MINUS)
    ]


def history(joints=("B",), **variables):
    time = var("time", np.linspace(0.0, 0.2, 5), "s")
    return result(
        "response", variables, {"time": time, "joint": ("joint", [*joints]), "pin": ("pin", ["O", "A"])}
    )


def test_a_response():
    force = {"largest_force": var("joint", [105.4], "N"), "largest_normal_force": var("joint", [101.0], "N")}
    reaction = {"largest_reaction": var("pin", [8.0, 9.0], "N")}
    spans = {"recorded_time": var((), 0.2, "s"), "contacts_begun": var((), 3)}
    spans |= {"turn_period_nominal": var((), 0.1, "s"), "contact_fraction": var("joint", [0.4])}
    assert said(history(**force, **reaction, **spans)) == [
        "largest forces: contact B 105 N (normal 101 N); ideal joints O 8 N, A 9 N",
        "contacts begun per nominal turn: 1.5; share of the time in contact: B 40 %",
    ]
    assert said(history(largest_normal_force=force["largest_normal_force"])) == [
        "largest normal forces: contact B 101 N"
    ]
    speed = var("joint", [80.0], "rad s-1", long_name="largest size of x")
    assert said(history(largest_angular_velocity=speed)) == ["largest size of x: B 80 rad/s"]
    assert said(history()) == ["5 samples over 200 ms"]


def test_samples_alone_state_neither_forces_nor_contacts():
    """They may be few: what is said of the motion comes from the integrator's own record, or is not said."""
    force = {"normal_force": var(("time", "joint"), [[0.0], [105.4], [3.0], [0.0], [0.0]], "N")}
    modes = coded(("time", "joint"), [[0], [2], [2], [0], [0]], Mode.words())
    events = {"event_kind": coded("event", [0, 1, 0, 1, 0, 1], Event.words()), "mode": modes}
    events |= {"turn_period_nominal": var((), 0.1, "s"), "clearance": var("joint", [1e-4], "m")}
    assert said(history(**force, **events)) == ["5 samples over 200 ms"]


def test_a_guide_without_clearance_has_no_part_in_contacts():
    spans = {"recorded_time": var((), 0.2, "s"), "contact_fraction": var("joint", [0.4, np.nan])}
    force = var("joint", [4.0, np.nan], "N")
    found = history("BG", largest_force=force, **spans)
    assert said(found) == ["largest forces: contact B 4 N", "share of the time in contact: B 40 %"]


def test_corners_of_a_guide_are_told_as_figures_name_them():
    spans = {"recorded_time": var((), 0.2, "s"), "contact_fraction": var("joint", [0.4, 0.3])}
    found = history(["B", "G_upper_front"], largest_force=var("joint", [4.0, 3.0], "N"), **spans)
    assert said(found) == [
        "largest forces: contact B 4 N, upper front corner of G 3 N",
        "share of the time in contact: B 40 %, upper front corner of G 30 %",
    ]


def test_section_points():
    def points(values):
        values = np.array(values, dtype=float)[:, None]
        journals = {f"journal_{x}": var(("turn", "joint"), 1e-4 * values, "m") for x in "xy"}
        return said(result("section", journals | {"clearance": var("joint", [1e-4], "m")}))[0]

    assert points([0.5, 0.7] * 8) == "period 2: 16 section points, which repeat to rounding of the clearance"
    assert points(0.5 + 1e-7 * (-1.0) ** np.arange(16)).startswith(
        "period 1: 16 section points, which repeat to 2 × 10⁻⁷"
    )
    assert points(np.random.default_rng(1).uniform(size=16)).startswith(
        "no period was found in 16 section points"
    )


def test_section_points_of_a_mechanism_with_an_ideal_guide():
    """Its journal is not known at any point, and is no part of the period."""
    found = jp.poincare(jp.catalog.slider_crank(clearance=1e-4), transient=60, turns=20)
    assert np.isnan(found.journal_x.sel(joint="G")).all()
    assert said(found)[0].startswith("period 1: 20 section points")


def test_every_kind_has_an_answer_of_its_own():
    assert [row.name for row in KINDS.values() if not row.outputs.answer] == []


def test_what_is_no_result_is_refused():
    for wrong, words in ((xr.Dataset(), "one of the kinds"), ("r.nc", "a result")):
        with pytest.raises(jp.InputError, match=words):
            jp.summary(wrong)


def test_it_shows_in_a_notebook():
    found = jp.summary(exponents(1.64, 0.07).assign_attrs(study="a<b"))
    assert found._repr_html_().startswith("<div><b>a&lt;b: lyapunov</b><br>largest exponent")
    assert repr(found) == f"a<b: lyapunov\n{found}"
