"""Digits to compare programs with: `python -m tests.reference.values`, a quarter of an hour on two cores.

Each of `SYSTEMS` gives rows: a quantity by the package, its error, and the same by something that shares
nothing with it: a closed form, an exact map, SciPy or another program, a published number; or, where there is
none, by another tolerance and another section. An error is a standard error of a statistic, the accuracy of a
located point, or else how far a run at a hundred times the tolerance is away. Where two values are further
apart than three times both their errors, the table is not written.

The table is written as netCDF and CSV (`results/reference`), with all digits: a run on the same kind of
processor gives them again. Rows have the system in full, with the keys of study files.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.rules import quantity
from jointplay.solver.mechanism.assemble import assemble
from jointplay.study.file import load
from tests.analysis.exact_maps import TAU, Symmetric, Walls, impacts, strobed, symmetry_lost
from tests.peers.exudyn_twin import follow, free
from tests.support.multibody_records import at_state, state_at
from tests.support.multibody_run import followed

FOLDER = Path(__file__).parents[2] / "results" / "reference"
OWN = Path(__file__).parents[2] / "studies" / "own"
ROUNDING = 1e-12  # relative: what a value computed by other formulas may differ by beside all errors
TIGHT, LOOSE = 1e-12, 1e-10
STEP = 1e-7  # rad and m, of differences
PARTS = 20  # of a record, for its standard error


@dataclass(frozen=True)
class Row:
    """One quantity of a system: by the package, and confirmed."""

    quantity: str
    units: str
    value: float
    error: float
    method: str
    confirmed_by: str
    confirmed: float
    confirmed_error: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether both values are one within three times their errors, and rounding."""
        most = 3 * math.hypot(self.error, self.confirmed_error) + ROUNDING * abs(self.confirmed)
        return abs(self.value - self.confirmed) <= most


Rows = Iterator[Row]
SYSTEMS: dict[str, tuple[str, Any, Callable[[Any], Rows]]] = {}


def system(title: str, mechanism: Any) -> Callable[[Callable[[Any], Rows]], Callable[[Any], Rows]]:
    """Add a system and the function that gives its rows."""

    def added(function: Callable[[Any], Rows]) -> Callable[[Any], Rows]:
        SYSTEMS[function.__name__] = title, mechanism, function
        return function

    return added


def study(name: str, **changes: float) -> Any:
    """The system of a study in studies/own."""
    return load(OWN / f"{name}.toml").record.mechanism.replace(**changes)


def assessed() -> Any:
    """The slider-crank of the study that the docs assess, just below its edge of contact."""
    return load(OWN.parent / "assess" / "assess_slider_crank.toml").record.mechanism.replace(
        clearance=1.05e-4
    )


def twice(of: Callable[[float], float]) -> dict[str, float]:
    """A value at a tight tolerance, and how far it is at a looser one."""
    tight, loose = of(TIGHT), of(LOOSE)
    return {"value": float(tight), "error": abs(float(tight - loose))}


def special(found: xr.Dataset, kind: str) -> dict[str, Any]:
    """The first special point of a kind on the first branch."""
    here = (jp.words(found)["special_kind"].values == kind) & (found["special_branch"].values == 0)
    first = found.isel(special=int(np.flatnonzero(here)[0]))
    return located(first)


def located(point: xr.Dataset) -> dict[str, Any]:
    """Parameter and accuracy of a special point."""
    found = {"value": float(point["special_parameter"]), "error": float(point["special_accuracy"])}
    return found | {"method": "continuation"}


def multiplier(mechanism: Any, rtol: float, **keywords: Any) -> complex:
    """The largest multiplier of a periodic orbit."""
    found = jp.periodic_orbit(mechanism, rtol=rtol, **keywords)
    assert jp.words(found)["status"] == "ok", found["status"]
    values = found["floquet_multiplier"].values @ [1, 1j]
    return complex(values[np.argsort(-np.abs(values), kind="stable")][0])


def exponent(mechanism: Any, **keywords: Any) -> dict[str, float]:
    """The largest exponent per time, and its standard error."""
    found = jp.lyapunov(mechanism, exponents=1, **keywords)
    assert jp.words(found)["status"] == "ok", found["status"]
    return {
        "value": float(found["lyapunov_exponent"][0]),
        "error": float(found["lyapunov_standard_error"][0]),
    }


def by_parts(logs: np.ndarray, times: np.ndarray) -> dict[str, float]:
    """Growth per time of an exact map, and its standard error from parts of the record."""
    logs_of, times_of = (np.array_split(values, PARTS) for values in (logs, times))
    parts = [np.sum(log) / np.sum(time) for log, time in zip(logs_of, times_of, strict=True)]
    error = np.std(parts, ddof=1) / math.sqrt(PARTS)
    return {"confirmed": np.sum(logs) / np.sum(times), "confirmed_error": error}


def halved(low: float, high: float, beyond: Callable[[float], bool], times: int) -> tuple[float, float]:
    """Values between which something begins, halved so many times."""
    for _ in range(times):
        middle = (low + high) / 2
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return low, high


# Impacts on rigid walls.


@system("Impact pair, wide", catalog.impact_pair(0.5 * Symmetric(1.0, 0.8).fold, 0.8))
def impact_pair(pair: Any) -> Rows:
    r = pair.parameters["restitution"]
    motion = Symmetric(pair.parameters["gap"], r)
    keywords = {"initial": list(motion.at_zero), "transient": 0, "step": 0.06, "max_points": 90}
    limits = (0.9 * symmetry_lost(r), 1.05 * motion.fold)
    found = jp.continuation(pair, parameter="gap", range=limits, branch_switching=False, **keywords)
    for word, kind, exact in (
        ("gap where the symmetry is lost", "branch_point", symmetry_lost(r)),
        ("gap at the fold of the symmetric motion", "fold", motion.fold),
    ):
        yield Row(
            *(word, "1"),
            **special(found, kind),
            confirmed_by="closed form",
            confirmed=exact,
        )
    trace, determinant = Symmetric(2.92, r).half_map
    start = list(Symmetric(2.92, r).at_zero)
    yield Row(
        *("largest multiplier of the symmetric motion at gap 2.92", "1"),
        **twice(lambda rtol: multiplier(pair.replace(gap=2.92), rtol, initial=start, transient=0).real),
        method="periodic_orbit",
        confirmed_by="closed form: half-period map",
        confirmed=max(np.abs(np.roots([1, -trace, determinant]))) ** 2,
    )


@system("Impact pair, narrow", catalog.impact_pair(0.4, 0.8))
def impact_pair_chaos(pair: Any) -> Rows:
    gap, r = (pair.parameters[name] for name in ("gap", "restitution"))
    met = np.array(impacts(gap, r, (0.0, 0.05, 0.7), 300_100)[100:])
    (t, side, speed), logs = met.T, []
    d = np.array([1.0, 1.0])  # of the time, and of the speed after an impact
    for k in range(len(t) - 1):
        after, before, T = -r * side[k] * speed[k], side[k + 1] * speed[k + 1], t[k + 1] - t[k]
        moved = d[1] * T - (math.sin(t[k]) * T + after) * d[0]
        later = -moved / before
        d = np.array([later, -r * (d[1] - math.sin(t[k]) * d[0] + math.sin(t[k + 1]) * later)])
        logs.append(math.log(np.abs(d).max()))
        d /= np.abs(d).max()
    yield Row(
        *("largest exponent", "1"),
        **exponent(pair, turns=300_000, transient=100, initial=(0.05, 0.7)),
        method="lyapunov",
        confirmed_by="exact map from impact to impact",
        **by_parts(np.array(logs), np.diff(t)),
    )


@system("Bouncing ball", catalog.bouncing_ball(1.3, 0.5))
def bouncing_ball(ball: Any) -> Rows:
    a = ball.parameters["restitution"]
    fold = math.pi * (1 - a) / (1 + a)
    doubling = math.hypot(fold, 2 * (1 + a**2) / (1 + a) ** 2)
    keywords = {"range": (1.02, 1.6), "step": 0.1, "branch_switching": False, "max_points": 120}
    found = jp.continuation(ball, parameter="acceleration", **keywords)
    for word, kind, exact in (
        ("acceleration where it begins to bounce once a period", "fold", fold),
        ("acceleration where its period doubles", "period_doubling", doubling),
    ):
        yield Row(
            *(word, "1"),
            **special(found, kind),
            confirmed_by="closed form",
            confirmed=exact,
        )


@system("Oscillator with a stop", study("impact_oscillator", distance=0.3))
def impact_oscillator(oscillator: Any) -> Rows:
    w, damping = oscillator.parameters["frequency"], oscillator.parameters["damping"]
    amplitude = 1 / math.hypot(1 - w**2, 2 * damping * w)
    keywords = {"range": (0.13, 0.31), "transient": 300, "branch_switching": False, "step": 0.1}
    found = jp.continuation(oscillator, parameter="distance", **keywords)
    yield Row(
        *("distance of the stop where the motion grazes it", "1"),
        **special(found, "grazing"),
        confirmed_by="closed form: amplitude of the linear oscillator",
        confirmed=amplitude,
    )


@system("Rocking block", study("rocking_block"))
def rocking_block(block: Any) -> Rows:
    p, r, a, time = block.parameters["frequency"], block.parameters["restitution"], 0.9, 0.0
    for _ in range(3):
        time += math.acosh(1 / (1 - a)) / p
        a = 1 - math.sqrt(1 - r**2 * (1 - (1 - a) ** 2))
        again = time
        time += math.acosh(1 / (1 - a)) / p

    def third(rtol: float) -> float:
        return float(jp.simulate(block, duration=6.0, rtol=rtol)["event_time"].values[2])

    yield Row(
        *("time of the third impact", "s"),
        **twice(third),
        method="simulate",
        confirmed_by="closed form after Housner",
        confirmed=again,
    )


@system("Rimless wheel", study("rimless_wheel"))
def rimless_wheel(wheel: Any) -> Rows:
    slope, half = wheel.parameters["slope"], wheel.parameters["half"]
    c = math.cos(2 * half)
    steady = math.sqrt(4 * math.sin(slope) * math.sin(half) * c**2 / (1 - c**2))
    section = jp.ContactSection(joint="step")
    yield Row(
        *("rate after a step of the steady walk", "1"),
        **twice(
            lambda rtol: (
                jp.poincare(wheel, section, turns=1, transient=200, rtol=rtol)
                .state_value.sel(state="rate")
                .values[-1]
            )
        ),
        method="poincare",
        confirmed_by="closed form",
        confirmed=steady,
    )


# Contacts with stiffness.


@system("Soft impact pair", catalog.soft_impact_pair(2.0, 50.0, 4.0, tension=False))
def soft_impact_pair(pair: Any) -> Rows:
    walls = Walls(1.0, 50.0, 4.0, pulls=False, sin=1.0)

    def period(state: np.ndarray) -> np.ndarray:
        return walls.run(*state, TAU + 1e-9, [TAU])[1][0]

    state = jp.poincare(pair, turns=1, transient=60, rtol=1e-12).state_value.values[-1]
    state = fsolve(lambda x: period(x) - x, state, xtol=1e-13)
    h = 1e-5
    slope = np.transpose([(period(state + d) - period(state - d)) / (2 * h) for d in h * np.eye(2)])
    yield Row(
        *("largest modulus of a multiplier of the symmetric motion", "1"),
        **twice(lambda rtol: abs(multiplier(pair, rtol))),
        method="periodic_orbit",
        confirmed_by="differences of exact pieces",
        confirmed=max(abs(np.linalg.eigvals(slope))),
        confirmed_error=1e-9,
    )


@system("Gear pair on one flank", catalog.gear_backlash(0.1, 0.06, 1.6, 0.05))
def gear_pair(pair: Any) -> Rows:
    W, zeta, load = (pair.parameters[name] for name in ("frequency", "damping", "mean_load"))
    limit = load * abs(1 - W**2 + 2j * zeta * W) / W**2
    keywords = {"range": (0.5 * limit, 1.1 * limit), "initial": [1 + load, 0.0], "transient": 300}
    found = jp.continuation(
        pair.replace(amplitude=0.9 * limit),
        parameter="amplitude",
        branch_switching=False,
        max_points=60,
        **keywords,
    )
    yield Row(
        *("amplitude of the torque where contact is lost", "1"),
        **special(found, "grazing"),
        confirmed_by="closed form: amplitude of the linear oscillator",
        confirmed=limit,
    )


@system("Gear pair with backlash", catalog.gear_backlash(0.1, 0.2, 1.6, 0.05))
def gear_pair_chaos(pair: Any) -> Rows:
    W, T = pair.parameters["frequency"], TAU / pair.parameters["frequency"]
    walls, periods = Walls(1.0, 1.0, 0.0, W=W, cos=0.2 * W**2, mean=0.1, drag=0.1), 60_000
    events, _ = walls.run(0.5, 0.0, periods * T)
    free, held = np.array([[0, 1], [0, -0.1]]), np.array([[0, 1], [-1, -0.1]])
    d, at, inside, logs, times = np.array([1.0, 0.0]), 0.0, False, [], []
    for t, _, kind in events:  # the force has no jump: tangents have none either
        d = expm((held if inside else free) * (t - at)) @ d
        logs.append(math.log(np.abs(d).max()))
        times.append(t - at)
        d, at, inside = d / np.abs(d).max(), t, kind == "contact"
    yield Row(
        *("largest exponent", "1"),
        **exponent(pair, turns=160_000, transient=100),
        method="lyapunov",
        confirmed_by="exact pieces",
        **by_parts(np.array(logs[200:]), np.array(times[200:])),
    )


def meshed(t: float, x: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """Gears whose mesh has a stiffness that varies, and two neighbours."""
    wave = math.cos(p["frequency"] * t)
    touching = abs(x[0]) > 1
    stiffness = (1 + p["mesh"] * wave) * touching
    push = p["mean_load"] + p["amplitude"] * p["frequency"] ** 2 * wave - 2 * p["damping"] * x[1]
    y, v = x[2::2], x[3::2]
    rates = np.empty(6)
    rates[0], rates[1] = x[1], push - stiffness * (x[0] - math.copysign(1, x[0]))
    rates[2::2], rates[3::2] = v, -stiffness * y - 2 * p["damping"] * v
    return rates


def pieces(
    rate: Callable[..., np.ndarray], x: np.ndarray, until: float, guards: list, *arguments: Any
) -> np.ndarray:
    """SciPy's DOP853 from guard to guard: `rate` has kinks where one of the guards is 0."""
    t = 0.0
    while t < until:
        ends = [lambda t, x, *_, guard=guard: guard(x) for guard in guards]
        for end in ends:
            end.terminal = True
        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "events": ends, "args": arguments}
        found = solve_ivp(rate, (t, until), x, **options)
        t, x = found.t[-1], found.y[:, -1]
        if found.status == 1:  # a little beyond the guard, without one
            step = min(1e-7, until - t)
            x = solve_ivp(rate, (t, t + step), x, **(options | {"events": None})).y[:, -1]
            t += step
    return x


@system(
    "Gear pair with backlash and a mesh whose stiffness varies",
    catalog.gear_backlash(0.1, 0.1, 0.8, 0.05, 0.2),
)
def gear_pair_mesh(pair: Any) -> Rows:
    T = TAU / pair.parameters["frequency"]
    found = jp.periodic_orbit(pair, transient=600, rtol=TIGHT)
    number = int(found["period"])
    start = np.r_[found["orbit_state"].values.reshape(-1, 2)[0], 1, 0, 0, 1]
    guards = [lambda x: x[0] - 1, lambda x: x[0] + 1]
    end = pieces(meshed, start, number * T, guards, pair.parameters)
    assert np.abs(end[:2] - start[:2]).max() < 1e-8
    values = np.linalg.eigvals(end[2:].reshape(2, 2).T)
    yield Row(
        *(f"largest modulus of a multiplier of the motion of period {number}", "1"),
        **twice(lambda rtol: abs(multiplier(pair, rtol, transient=600))),
        method="periodic_orbit",
        confirmed_by="SciPy's DOP853 with variational equations",
        confirmed=max(abs(values)),
        confirmed_error=1e-8,
    )


# Dry friction, switches, a valve.


@system("Block on a belt", study("stick_slip"))
def stick_slip(block: Any) -> Rows:
    p = block.parameters
    w, D = math.sqrt(p["stiffness"] / p["mass"]), (p["static"] - p["sliding"]) * p["load"] / p["stiffness"]

    def onsets(rtol: float) -> float:
        found = jp.simulate(block, duration=20.0, rtol=rtol)
        begins = found["event_time"].values[jp.words(found)["event_kind"].values == "slip_onset"]
        return begins[-1] - begins[-2]

    yield Row(
        *("period of sticking and slipping", "s"),
        **twice(onsets),
        method="simulate",
        confirmed_by="closed form",
        confirmed=2 / w * (math.pi - math.atan(D * w / p["belt"])) + 2 * D / p["belt"],
    )


@system("Buck converter", study("buck_converter", source=24.0))
def buck_converter(buck: Any) -> Rows:
    p = buck.parameters
    A = np.array([[-1 / p["load"] / p["capacity"], 1 / p["capacity"]], [-1 / p["coil"], 0.0]])
    T, ramp = p["cycle"], p["high"] - p["low"]

    def worst(source: float) -> float:
        """Least multiplier of the motion of one cycle: the switch is on from its share `begins` on."""
        rest = -np.linalg.solve(A, [0.0, source / p["coil"]])

        def start(begins: float) -> np.ndarray:
            on = expm(A * (1 - begins) * T)
            return np.linalg.solve(np.eye(2) - on @ expm(A * begins * T), rest - on @ rest)

        def miss(begins: float) -> float:
            x = expm(A * begins * T) @ start(begins)
            return p["low"] + ramp * begins - p["gain"] * (x[0] - p["reference"])

        begins = brentq(miss, 0.05, 0.95, xtol=1e-15)
        x = expm(A * begins * T) @ start(begins)
        off = A @ x
        n = np.array([-p["gain"], 0.0])
        jump = np.eye(2) + np.outer([0.0, source / p["coil"]], n) / (n @ off + ramp / T)
        values = np.linalg.eigvals(expm(A * (1 - begins) * T) @ jump @ expm(A * begins * T))
        return float(min(values.real))

    exact = brentq(lambda source: worst(source) + 1, 20.0, 30.0, xtol=1e-12)
    section = jp.Plane(quantity="clock", value=0.2, direction="up")
    found = jp.continuation(
        buck,
        section,
        parameter="source",
        range=(22.0, 26.0),
        transient=200,
        branch_switching=False,
        max_points=60,
    )
    yield Row(
        *("source voltage where the cycle doubles", "V"),
        **special(found, "period_doubling"),
        confirmed_by="closed form: exponentials of matrices",
        confirmed=exact,
    )


def valve(t: float, x: np.ndarray, q: float) -> list[float]:
    """Relief valve above its seat."""
    return [x[1], -1.25 * x[1] - (x[0] + 10) + x[2], 20 * (q - x[0] * math.sqrt(x[2]))]


@system("Relief valve", catalog.relief_valve(flow=7.8))
def relief_valve(found_valve: Any) -> Rows:
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    top = lambda t, x, q: x[1]  # noqa: E731
    top.terminal, top.direction = True, -1

    def cycle(q: float, x: np.ndarray, p: float) -> tuple[np.ndarray, float, float]:
        """From a largest lift to the next one: state, and lift at the least between."""
        state = solve_ivp(valve, (0, 1e-4), [x, 0.0, p], args=(q,), **options).y[:, -1]
        run = solve_ivp(valve, (0, 100), state, args=(q,), events=top, dense_output=True, **options)
        low = brentq(lambda t: run.sol(t)[1], 0.2 * run.t[-1], 0.8 * run.t[-1], xtol=1e-14)
        return run.y[:, -1], float(run.sol(low)[0]), run.t[-1]

    def closed(q: float, guess: np.ndarray) -> np.ndarray:
        return fsolve(lambda z: cycle(q, *z)[0][[0, 2]] - z, guess, xtol=1e-13)

    section = jp.Plane(quantity="v", value=0.0, direction="down")
    settled = jp.poincare(found_valve, section, turns=4, transient=600).state_value.values[-1]
    guess = closed(7.8, settled[[0, 2]])
    h = 1e-6
    slope = np.transpose(
        [(cycle(7.8, *(guess + d))[0] - cycle(7.8, *(guess - d))[0])[[0, 2]] / (2 * h) for d in h * np.eye(2)]
    )
    yield Row(
        *("largest multiplier of the cycle at the flow 7.8", "1"),
        **twice(lambda rtol: multiplier(found_valve, rtol, section=section, transient=600).real),
        method="periodic_orbit",
        confirmed_by="SciPy's DOP853: differences of its return map",
        confirmed=max(np.linalg.eigvals(slope).real),
        confirmed_error=1e-7,
    )
    known = {"z": guess}

    def least(q: float) -> float:
        known["z"] = closed(q, known["z"])
        return cycle(q, *known["z"])[1]

    flows = np.arange(7.8, 7.0, -0.02)
    below = next(q for q in flows if least(q) < 0)
    exact = brentq(least, below, below + 0.02, xtol=1e-11)
    found = jp.continuation(
        found_valve,
        section,
        parameter="flow",
        range=(7.0, 8.0),
        transient=600,
        branch_switching=False,
        max_points=80,
    )
    yield Row(
        *("flow where the cycle grazes the seat", "1"),
        **special(found, "grazing"),
        confirmed_by="SciPy's DOP853",
        confirmed=exact,
        confirmed_error=1e-9,
    )


# Smooth systems.


def as_published(flow: Any, published: float, **keywords: Any) -> Row:
    """The largest exponent, and the one of Sprott's tables, with four digits."""
    return Row(
        *("largest exponent", "1"),
        **exponent(flow, **keywords),
        method="lyapunov",
        confirmed_by="published: Sprott (2003)",
        confirmed=published,
        confirmed_error=5e-5,
    )


@system("Lorenz", catalog.lorenz())
def lorenz(flow: Any) -> Rows:
    section = jp.Plane(quantity="z", value=27.0, direction="up")
    yield Row(
        *("period of the shortest orbit", "1"),
        **twice(lambda rtol: float(jp.periodic_orbit(flow, section, period=2, rtol=rtol)["period_time"])),
        method="periodic_orbit",
        confirmed_by="published: Viswanath (2004)",
        confirmed=1.5586522107161747,
    )
    yield as_published(flow, 0.9056, duration=400_000, transient=50)


@system("Rössler", catalog.rossler())
def rossler(flow: Any) -> Rows:
    yield as_published(flow, 0.0714, duration=1_000_000, transient=100)


@system("Jerk with a bend", catalog.jerk())
def jerk(flow: Any) -> Rows:
    yield as_published(flow, 0.0362, duration=2_000_000, transient=500, initial=(0.1, 0.1, 0.1))


def shaken(t: float, x: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """Duffing's oscillator and a neighbour."""
    push = p["amplitude"] * math.cos(p["frequency"] * t)
    bend = 1 - 3 * x[0] ** 2
    pull = x[0] - x[0] ** 3
    return np.array([x[1], push - p["damping"] * x[1] + pull, x[3], bend * x[2] - p["damping"] * x[3]])


def grown(
    rate: Callable[..., np.ndarray], x: list[float], period: float, turns: int, *arguments: Any
) -> dict[str, float]:
    """Growth of the neighbour behind a state of two, by DOP853, without the first hundredth of the turns."""
    state, logs = np.array(x), []
    for turn in range(turns):
        options = {"method": "DOP853", "rtol": 1e-8, "atol": 1e-10, "args": arguments}
        state = solve_ivp(rate, (turn * period, (turn + 1) * period), state, **options).y[:, -1]
        half = len(state) // 2
        size = np.linalg.norm(state[half:])
        logs.append(math.log(size))
        state[half:] /= size
    kept = np.array(logs[turns // 100 :])
    return by_parts(kept, np.full(len(kept), period))


@system("Duffing, two wells", catalog.duffing())
def duffing(flow: Any) -> Rows:
    yield Row(
        *("largest exponent", "1"),
        **exponent(flow, turns=300_000, transient=50),
        method="lyapunov",
        confirmed_by="SciPy's DOP853 with variational equations",
        **grown(shaken, [1.0, 0.0, 1.0, 0.0], TAU, 20_000, flow.parameters),
    )


def chua_rate(t: float, x: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """Chua's circuit and a neighbour."""
    inside = abs(x[0]) < 1
    slope = p["inner"] if inside else p["outer"]
    held = p["outer"] * x[0] + (p["inner"] - p["outer"]) * min(max(x[0], -1), 1)
    own = [p["alpha"] * (x[1] - x[0] - held), x[0] - x[1] + x[2], -p["beta"] * x[1]]
    near = [p["alpha"] * (x[4] - x[3] - slope * x[3]), x[3] - x[4] + x[5], -p["beta"] * x[4]]
    return np.array(own + near)


@system("Chua's circuit", study("chua"))
def chua(circuit: Any) -> Rows:
    yield Row(
        *("largest exponent", "1"),
        **exponent(circuit, duration=400_000, transient=100),
        method="lyapunov",
        confirmed_by="SciPy's DOP853 with variational equations",
        **grown(chua_rate, [0.1, 0.0, 0.0, 1.0, 0.0, 0.0], 1.0, 25_000, circuit.parameters),
    )


# Linkages.


SECOND = "second multibody program, in all coordinates of the bodies: "


def later(mechanism: Any, found: xr.Dataset) -> Callable[[np.ndarray], np.ndarray]:
    """The second program's map of states at crank angle 0 over the time of an orbit."""
    model, T = assemble(mechanism, None, quantity(jp.CrankAngle(), mechanism)), float(found["period_time"])

    def image(state: np.ndarray) -> np.ndarray:
        bodies, y = at_state(mechanism, model, state)
        end = state_at(mechanism, model, bodies, T, followed(bodies, y, [T], 1e-12)[0][-1].y)
        turns = np.round((end - state)[: len(state) // 2] / TAU)
        end[: len(state) // 2] -= TAU * turns * model.turning
        return end

    return image


def orbit(mechanism: Any, transient: int = 100) -> xr.Dataset:
    """A linkage's orbit of one turn."""
    found = jp.periodic_orbit(mechanism, transient=transient, rtol=TIGHT)
    assert (int(found["status"]), int(found["period"])) == (0, 1)
    return found


def a_turn_later(mechanism: Any, found: xr.Dataset) -> Row:
    """A speed of an orbit, and the same after a turn by the second program."""
    state = found["orbit_state"].values
    word = next(i for i, name in enumerate(found["state"].values) if name.startswith(("w_", "vslide")))
    return Row(
        *(f"{found['state'].values[word]} of the motion of one turn where the crank angle is 0", "rad s-1"),
        **twice(
            lambda rtol: jp.periodic_orbit(mechanism, transient=100, rtol=rtol)["orbit_state"].values[word]
        ),
        method="periodic_orbit",
        confirmed_by=SECOND + "a turn later",
        confirmed=later(mechanism, found)(state)[word],
        confirmed_error=1e-10 * abs(state[word]),
    )


def largest_multiplier(mechanism: Any, confirmed_by: str, confirmed: float, confirmed_error: float) -> Row:
    """The largest multiplier of a linkage's orbit of a turn."""
    return Row(
        *("largest modulus of a multiplier of the motion of one turn", "1"),
        **twice(lambda rtol: abs(multiplier(mechanism, rtol, transient=100))),
        method="periodic_orbit",
        confirmed_by=confirmed_by,
        confirmed=confirmed,
        confirmed_error=confirmed_error,
    )


def by_differences(mechanism: Any, found: xr.Dataset) -> Row:
    """The largest multiplier, and the same by differences of the second program's states."""
    state, image, T = found["orbit_state"].values, later(mechanism, found), float(found["period_time"])
    half = len(state) // 2
    largest = []
    for step in (STEP, 10 * STEP):
        units = np.r_[np.ones(half), np.full(half, TAU / T)] * step
        columns = [(image(state + d) - image(state - d)) / (2 * d.max()) for d in np.diag(units)]
        values = np.sort(np.abs(np.linalg.eigvals(np.transpose(columns))))[::-1]
        driven = not mechanism.drive.imposed_speed  # a motor's speed is unknown: time's own multiplier is 1
        largest.append(np.delete(values, np.argmin(np.abs(values - 1)))[0] if driven else values[0])
    error = max(abs(largest[0] - largest[1]), 1e-9)
    return largest_multiplier(mechanism, SECOND + "differences", largest[0], error)


def by_another_section(mechanism: Any) -> Row:
    """The largest multiplier, and the same at another crank angle and a looser tolerance."""
    other = abs(multiplier(mechanism, 1e-9, section=jp.CrankAngle(angle=2.0), transient=100))
    return largest_multiplier(mechanism, "another section and tolerance", other, 1e-6)


def orbit_rows(mechanism: Any) -> Rows:
    """Both rows of a linkage's orbit."""
    found = orbit(mechanism)
    yield by_differences(mechanism, found)
    yield a_turn_later(mechanism, found)


@system("Four-bar of Figure 12a", catalog.chunmei2002(2.9e-5, gear_ratio=15.0))
def four_bar_12a(linkage: Any) -> Rows:
    yield by_another_section(linkage)
    yield a_turn_later(linkage, orbit(linkage))


@system("Four-bar of Figure 12b", catalog.chunmei2002(2.9e-5, gear_ratio=3.0))
def four_bar_12b(linkage: Any) -> Rows:
    yield from orbit_rows(linkage)


@system("Four-bar of Figure 12c", catalog.chunmei2002(2.9e-4, gear_ratio=3.0))
def four_bar_12c(linkage: Any) -> Rows:
    twins = jp.growth(linkage, turns=20_000, transient=200)
    yield Row(
        *("largest exponent", "s-1"),
        **exponent(linkage, turns=20_000, transient=200),
        method="lyapunov",
        confirmed_by="growth of differences at 1e-12, without derivatives",
        confirmed=float(twins["growth_rate"]),
        confirmed_error=float(twins["growth_standard_error"] * twins["growth_rate"] / twins["growth"]),
    )


@system("Four-bar at gear ratio 3", catalog.chunmei2002(4.195e-5, gear_ratio=3.0))
def four_bar_doubling(linkage: Any) -> Rows:
    def doubling(section: jp.CrankAngle, rtol: float) -> dict[str, Any]:
        return special(
            jp.continuation(
                linkage,
                section,
                range=(4.19e-5, 4.215e-5),
                branch_switching=False,
                step=0.4,
                record=(),
                rtol=rtol,
            ),
            "period_doubling",
        )

    other = doubling(jp.CrankAngle(angle=2.0), 1e-9)
    yield Row(
        *("clearance at B where the period first doubles", "m"),
        **doubling(jp.CrankAngle(), TIGHT),
        confirmed_by="another section and tolerance",
        confirmed=other["value"],
        confirmed_error=max(other["error"], 1e-7 * other["value"]),
    )


def separations(mechanism: Any, clearance: float) -> int:
    """How often contact is lost in the last two of sixty turns."""
    run = jp.simulate(mechanism.replace(clearance=clearance), turns=60, rtol=1e-11, samples_per_turn=1)
    late = run["event_time"].values > 58 * float(run["turn_period_nominal"])
    return int((late & (jp.words(run)["event_kind"].values == "separation")).sum())


@system("Slider-crank", assessed())
def slider_crank(mechanism: Any) -> Rows:
    found = jp.continuation(
        mechanism, range=(1.05e-4, 1.108e-4), branch_switching=False, step=0.1, record=(), rtol=TIGHT
    )
    lost = jp.words(found)["special_event_kind"].values == "separation"
    first = found.isel(special=int(np.flatnonzero(lost)[0]))
    low, high = halved(1.05e-4, 1.108e-4, lambda x: separations(mechanism, x) > 0, 24)
    yield Row(
        *("clearance at B above which contact is lost", "m"),
        **located(first),
        confirmed_by="runs on either side, halved",
        confirmed=(low + high) / 2,
        confirmed_error=(high - low) + 1e-9 * high,
    )


@system("Slider-crank that loses contact once a turn", catalog.slider_crank(clearance=1.5e-4))
def slider_crank_orbit(mechanism: Any) -> Rows:
    yield from orbit_rows(mechanism)


@system("Watt's six-bar", catalog.watt(clearance={"B": 3e-5}))
def watt(linkage: Any) -> Rows:
    yield from orbit_rows(linkage)


@system("Stephenson's six-bar", catalog.stephenson(clearance={"B": 3e-5}))
def stephenson(linkage: Any) -> Rows:
    yield from orbit_rows(linkage)


@system(
    "Four-bar of Figure 12b with a coupler that bends", catalog.chunmei2002(2.9e-5, 3.0, elastic=["coupler"])
)
def four_bar_elastic(linkage: Any) -> Rows:
    yield by_another_section(linkage)


def published(name: str, rows: dict[str, tuple[str, float]], source: str) -> Rows:
    """Published numbers of a benchmark, with what is known of their errors."""
    tight, loose = (
        jp.benchmark(getattr(catalog, name)(), rtol=x).set_index(quantity="quantity") for x in (TIGHT, LOOSE)
    )
    for word, (units, error) in rows.items():
        value = float(tight["computed"].sel(quantity=word))
        yield Row(
            *(word, units, value, abs(value - float(loose["computed"].sel(quantity=word)))),
            method="benchmark",
            confirmed_by=source,
            confirmed=float(tight["published"].sel(quantity=word)),
            confirmed_error=error,
        )


@system("Slider-crank with a rod that bends (test set of initial value problems)", catalog.ivp_crank())
def ivp_crank(mechanism: Any) -> Rows:
    rows = {"rod angle": ("rad", 1e-12), "rod speed": ("rad s-1", 1e-10), "multiplier 2": ("N", 1e-7)}
    yield from published("ivp_crank", rows, "published: Simeon (1996), by other integrators")


@system("Four-bar with three clearances (Siconos)", catalog.siconos_four_bar())
def siconos_four_bar(mechanism: Any) -> Rows:
    rows = {f"{link} angle at 1 s": ("rad", 2e-5) for link in ("crank", "coupler", "rocker")}
    yield from published("siconos_four_bar", rows, "Siconos: time steps of 0.1 ms, first order")


# A cam, and shares of starts.

ARCS = (  # of the cam: turn at the end, distance of the centre from the axis, turn where it is, radius
    (1.050328174371336, -0.45, 0.0, 0.85),
    (1.22173047639603, 0.40393320723821, 1.22173047639603, 0.15),
    (math.pi - 1.22173047639603, 0.0, 0.0, 0.55393320723821),
    (math.pi - 1.050328174371336, 0.40393320723821, math.pi - 1.22173047639603, 0.15),
    (math.pi, -0.45, math.pi, 0.85),
    (TAU, 0.0, 0.0, 0.4),
)


def cam(turn: float) -> tuple[float, float]:
    """Radius of the cam where its edge is, and its slope."""
    _, far, centre, rho = next(arc for arc in ARCS if turn % TAU <= arc[0])
    along, across = far * math.cos(turn - centre), far * math.sin(turn - centre)
    root = math.sqrt(rho**2 - across**2)
    return along + root, -across * (1 + along / root)


def cam_flight(p: dict[str, float], t: float, v: float) -> tuple[float, float, np.ndarray]:
    """From the cam at t with the speed v: time of the next impact, speed there, derivatives in t and v."""
    w, x, Omega = math.sqrt(p["stiffness"] / p["mass"]), cam(p["speed"] * t)[0] - 0.3, p["speed"]

    def gap(s: float) -> float:
        return x * math.cos(w * s) + v / w * math.sin(w * s) + 0.3 - cam(Omega * (t + s))[0]

    step = 0.002 / (1 + Omega / 50)
    s = min(step, 2e-4 * max(v - Omega * cam(Omega * t)[1], 1e-6))
    while gap(s) > 0:
        s, step = s + min(step, s), step
    s = brentq(gap, max(s - step, s / 2), s, xtol=1e-16)
    c, d = math.cos(w * s), math.sin(w * s)
    there, before = x * c + v / w * d, v * c - w * x * d
    slope, landed = Omega * cam(Omega * t)[1], Omega * cam(Omega * (t + s))[1]
    # a later start, at the same speed, is `slope` further out and sees a flight that is shorter by its delay
    place = np.array([slope * c - before, d / w])
    speed = np.array([-w * d * slope + w**2 * there, c])
    later = -place / (before - landed)
    return t + s, before, np.array([later, speed - w**2 * there * later])


@system("Cam and follower at 660 rpm", catalog.cam_follower(speed=22 * math.pi))
def cam_chaos(follower: Any) -> Rows:
    p, t, v = follower.parameters, 0.0, 4.0
    d, logs, times = np.array([1.0, 0.0]), [], []
    for _ in range(150_000):
        landing, before, slope = cam_flight(p, t, v)
        d, turn = slope @ d, p["speed"] * landing
        h = 1e-7
        bend = (cam(turn + h)[1] - cam(turn - h)[1]) / (2 * h) * p["speed"] ** 2
        r = p["restitution"]
        v = (1 + r) * p["speed"] * cam(turn)[1] - r * before
        d = np.array([d[0], (1 + r) * bend * d[0] - r * d[1]])
        logs.append(math.log(np.abs(d).max()))
        times.append(landing - t)
        d, t = d / np.abs(d).max(), landing
    yield Row(  # once in some 40 000 turns rebounds end in rest, which forgets all
        *("largest exponent", "s-1"),
        **exponent(follower, turns=20_000, transient=200),
        method="lyapunov",
        confirmed_by="exact map from impact to impact",
        **by_parts(np.array(logs[200:]), np.array(times[200:])),
    )


@system("Cam and follower that leaves it", catalog.cam_follower(speed=12.0))
def cam_separation(follower: Any) -> Rows:
    p, far, rho = follower.parameters, 0.40393320723821, 0.15
    angle = 1.050328174371336 - 1.22173047639603  # where the nose's edge begins, from its centre
    root = math.sqrt(rho**2 - (far * math.sin(angle)) ** 2)
    radius = far * math.cos(angle) + root
    bend = rho**2 * (rho**2 - far**2) / root**3 - radius

    def leaves(speed: float) -> bool:
        run = jp.simulate(follower.replace(speed=speed), turns=12, rtol=1e-11, samples_per_turn=1)
        assert int(run["status"]) == 0
        late = run["event_time"].values > 10 * TAU / speed
        return bool((late & (jp.words(run)["event_kind"].values == "separation")).any())

    low, high = halved(11.0, 13.0, leaves, 34)
    yield Row(
        *("speed above which the follower leaves the cam", "rad s-1"),
        value=(low + high) / 2,
        error=high - low,
        method="simulate, halved",
        confirmed_by="closed form: k (r - 0.3 m) = -m r'' where the flank ends",
        confirmed=math.sqrt(p["stiffness"] * (radius - 0.3) / (-p["mass"] * bend)),
    )


@system("Impact pair at gap 3.6", catalog.impact_pair(3.6, 0.8))
def impact_pair_shares(pair: Any) -> Rows:
    gap, r = (pair.parameters[name] for name in ("gap", "restitution"))
    region, starts = {"y": (-1.6, 1.6), "v": (-3.0, 3.0)}, 4000
    found = jp.attractors(pair, over={"gap": [gap]}, region=region, starts=starts, exponents=False)
    fraction = float(found["fraction"].values[0, found["period"].values[0] == 3].sum())
    motion, dice, reached = Symmetric(gap, r).at_zero, np.random.default_rng(1), 0
    for y, v in dice.uniform((-1.6, -3.0), (1.6, 3.0), (1500, 2)):
        end = strobed(gap, r, (0.0, y, v), 60)
        reached += math.dist(end, motion) > 0.05
    share = reached / 1500
    yield Row(
        *("share of starts, y within 1.6 and v within 3 of 0, that reach a motion of period 3", "1"),
        value=fraction,
        error=math.sqrt(fraction * (1 - fraction) / starts),
        method="attractors",
        confirmed_by="exact flights from 1500 other starts",
        confirmed=share,
        confirmed_error=math.sqrt(share * (1 - share) / 1500),
    )


# By other programs.


STOP = jp.System(
    name="follower on a rigid stop",
    states={"x": 0.4, "v": 0.4},
    parameters={"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8},
    rates={"x": "v", "v": "-stiffness*x/mass"},
    impacts=[{"name": "stop", "gap": "x", "restitution": "restitution"}],
)
SICONOS = {0.05: (0.0354071028, 10.89166279), 0.5: (0.0255702809, -4.40258941)}  # s: m and m/s


@system(
    "Follower on a rigid stop (Siconos' stored CamFollower-Rheonomous, whose constraint leaves out the cam)",
    STOP,
)
def siconos_follower(follower: Any) -> Rows:
    for at, (place, speed) in SICONOS.items():

        def there(rtol: float, at: float = at) -> float:
            return jp.simulate(follower, duration=at + 1e-9, at=[at], rtol=rtol).state_value.values[0, 0]

        yield Row(
            *(f"place at {at:g} s", "m"),
            **twice(there),
            method="simulate",
            confirmed_by="Siconos: time steps of 0.1 ms, of which a motion may be off by one",
            confirmed=place,
            confirmed_error=1e-4 * abs(speed),
        )


FREE = free(catalog.slider_crank(clearance={"B": 1e-4}, gravity=9.8, damping=500.0))


@system("Slider-crank let go, without friction", FREE)
def exudyn_slider_crank(mechanism: Any) -> Rows:
    start, end = {"crank_angle": 0.3, "crank_speed": 60.0}, 0.006
    joint = mechanism.clearance_joints[0]
    begins = [follow(mechanism, start, end, h).begins(joint)[-1] for h in (4e-7, 2e-7)]

    def last(rtol: float) -> float:
        run = jp.simulate(mechanism, duration=end, initial=start, rtol=rtol)
        return run["event_time"].values[jp.words(run)["event_kind"].values == "contact"][-1]

    yield Row(
        *("time at which contact begins for the last time within 6 ms", "s"),
        **twice(last),
        method="simulate",
        confirmed_by="Exudyn: time steps of 0.2 µs",
        confirmed=float(begins[1]),
        confirmed_error=max(abs(begins[1] - begins[0]), 2e-7),
    )


@system("Relief valve above its seat", catalog.relief_valve(flow=8.0))
def heyoka_valve(found_valve: Any) -> Rows:
    import heyoka as hy

    x, v, p = hy.make_vars("x", "v", "p")
    rates = [(x, v), (v, -1.25 * v - (x + 10.0) + p), (p, 20.0 * (8.0 - x * hy.sqrt(p)))]
    tops: list[float] = []
    top = hy.nt_event(
        v, lambda integrator, time, sign: tops.append(time), direction=hy.event_direction.negative
    )
    hy.taylor_adaptive(rates, [2.0, 0.0, 12.0], nt_events=[top]).propagate_until(4000.0)
    section = jp.Plane(quantity="v", value=0.0, direction="down")
    yield Row(
        *("period of the cycle", "1"),
        **twice(
            lambda rtol: float(
                jp.periodic_orbit(found_valve, section, transient=600, rtol=rtol)["period_time"]
            )
        ),
        method="periodic_orbit",
        confirmed_by="heyoka: Taylor series",
        confirmed=(tops[-1] - tops[-101]) / 100,
        confirmed_error=1e-13,
    )


# The table.


def in_full(mechanism: Any) -> str:
    """A mechanism's keys as JSON."""
    return json.dumps(mechanism.model_dump(mode="json", exclude_none=True), ensure_ascii=False)


def rows_of(name: str) -> list[dict[str, Any]]:
    """The rows of a system, with its title and the system in full."""
    title, mechanism, function = SYSTEMS[name]
    text = in_full(mechanism)
    found = []
    for row in function(mechanism):
        assert row.agrees, (
            f"{name}, {row.quantity}: {row.value!r} ± {row.error:g}, "
            f"but {row.confirmed!r} ± {row.confirmed_error:g}"
        )
        numbers = {
            name: float(getattr(row, name)) for name in ("value", "error", "confirmed", "confirmed_error")
        }
        found.append({"system": title, "mechanism": text} | vars(row) | numbers)
    return found


COLUMNS = {
    "system": "system",
    "quantity": "quantity",
    "units": "units of the quantity",
    "value": "value by jointplay",
    "error": "its error: of a statistic, a located point, or the tolerance",
    "method": "analysis of jointplay",
    "confirmed_by": "what the confirmation is made by",
    "confirmed": "the same quantity by that",
    "confirmed_error": "error of the confirmation, as far as it is known; 0 of a closed form",
    "mechanism": "the system in full, as JSON of the keys of a study file",
}


def write(rows: list[dict[str, Any]], folder: Path) -> None:
    """The table as netCDF and CSV."""
    folder.mkdir(parents=True, exist_ok=True)
    values = {
        name: ("row", [row[name] for row in rows], {"long_name": said}) for name, said in COLUMNS.items()
    }
    title = "Reference values of mechanisms and systems with play, impacts and friction"
    dataset = xr.Dataset(values, attrs={"Conventions": "CF-1.11", "title": title})
    dataset.to_netcdf(folder / "reference.nc")
    frame = dataset.to_dataframe()
    frame.to_csv(folder / "reference.csv", index=False, lineterminator="\n")


def tried(name: str) -> tuple[list[dict[str, Any]], str]:
    """The rows of a system, or why there are none."""
    try:
        return rows_of(name), ""
    except AssertionError as error:
        return [], f"{name}: {error}"


def main(arguments: list[str] | None = None) -> int:
    """Make the table anew, or print the rows of some systems; 1 where one has none."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("systems", nargs="*", help="print the rows of these alone: " + ", ".join(SYSTEMS))
    parser.add_argument("--out", type=Path, default=FOLDER)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args(arguments)
    names = given.systems or list(SYSTEMS)
    work = Parallel(n_jobs=given.jobs, return_as="generator")(delayed(tried)(name) for name in names)
    rows, failed = [], []
    for found, why in work:
        rows += found
        failed += [why] if why else []
        for row in found:
            print(
                f"{row['system']}: {row['quantity']} = {row['value']!r} ± {row['error']:.1e}"
                f" ({row['confirmed']!r} ± {row['confirmed_error']:.1e}, {row['confirmed_by']})",
                flush=True,
            )
    print(*failed, sep="\n", file=sys.stderr)
    if not given.systems and not failed:
        write(rows, given.out)
    return len(failed) > 0


if __name__ == "__main__":
    sys.exit(main())
