"""The verb selftest: five answers of this installation, each compared with one that is known otherwise."""

import math
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass

import jointplay as jp
from jointplay.cli.verb import DONE, FAILED, say, verb
from jointplay.display.number_text import plain, with_error


@dataclass(frozen=True)
class Known:
    """A known answer: its name, value and unit, its source, and how near ours must be.

    `compute` gives ours and its standard error, of which four are allowed besides `within`.
    """

    what: str
    value: float
    units: str
    origin: str
    within: float
    compute: Callable[[], tuple[float, float]]


def _journal() -> tuple[float, float]:
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    motion = jp.simulate(mechanism, turns=1, at=[0.075], record=["journal_x"], rtol=1e-10)
    return motion["journal_x"].values.item(), 0.0


def _fold() -> tuple[float, float]:
    start = (-13.318242544195524, 7.967078759992283)  # of the motion at the gap 28, in closed form too
    keywords = {"parameter": "gap", "range": (28.0, 28.4), "step": 0.2, "max_points": 30, "max_branches": 1}
    found = jp.continuation(jp.catalog.impact_pair(28.0, 0.8), initial=start, **keywords)
    return found["special_parameter"].values.item(), 0.0


def _chaos() -> tuple[float, float]:
    pair = jp.catalog.impact_pair(0.4, 0.8)
    found = jp.lyapunov(pair, turns=2000, transient=50, initial=(0.05, 0.7))
    return found["lyapunov_exponent"].values[0], found["lyapunov_standard_error"].values[0]


def _multiplier() -> tuple[float, float]:
    gears = jp.catalog.gear_backlash(mean_load=0.1, amplitude=0.2, frequency=0.8, damping=0.05)
    orbit = jp.periodic_orbit(gears, period=2, transient=300)
    multiplier = math.hypot(*orbit["floquet_multiplier"].values[0])
    return math.log(multiplier) / float(orbit["period_time"]), 0.0


def _sticking() -> tuple[float, float]:
    floor = {"name": "floor", "speed": "v", "normal": "1", "coefficient": "mu"}
    swings = {"rates": {"y": "v", "v": "-y"}, "friction": [floor]}
    block = jp.System(name="block", parameters={"mu": 0.15}, states={"y": 1.0, "v": 0.0}, **swings)
    return jp.simulate(block, duration=12, rtol=1e-10)["end_state"].values[0], 0.0


KNOWN = (
    Known(
        "four-bar with clearance: where the journal of joint B is after one turn, along x",
        *(-0.00011990911978185248, "m"),
        "Taylor series with 80-bit numbers, another program: tests/reference/truth.json, C",
        *(1e-11, _journal),
    ),
    Known(
        "mass between two rigid walls: the largest gap at which it hits each wall once a period",
        *(28.3449811516649, ""),
        "closed form √(π²k² + 4), k = (1 + r)/(1 − r), r = 0.8",
        *(1e-7, _fold),
    ),
    Known(
        "the same mass in chaos: its largest Lyapunov exponent",
        *(0.23792, ""),
        "exact map from impact to impact, to 1.2 × 10⁻⁴",
        *(3.6e-4, _chaos),
    ),
    Known(
        "gear pair with backlash: the rate at which its motion of two periods is approached",
        *(-0.01241887, ""),
        "exact motion of its linear pieces",
        *(2e-8, _multiplier),
    ),
    Known(
        "block on a spring with dry friction: where it sticks",
        *(-0.1, ""),
        "closed form: each half swing loses 2μ, μ = 0.15, from 1 on until at most μ is left",
        *(1e-8, _sticking),
    ),
)


@verb("selftest", example="")
def check_installation(_: Namespace) -> int:
    """Compare five answers with known ones, within a minute, and say what differs."""
    from jointplay.jobs.origin import environment, version

    packages = ", ".join(f"{name} {found}" for name, found in environment().items())
    say(f"jointplay {version('jointplay')}; {packages}")
    wrong = sum(not _compared(known) for known in KNOWN)
    if wrong:
        say(f"{wrong} of {len(KNOWN)} answers are wrong: do not trust results of this installation")
        return FAILED
    say(f"all {len(KNOWN)} answers are right")
    return DONE


def _compared(known: Known) -> bool:
    """Print whether one answer is right; an error is an answer that is not."""
    say(known.what)
    units = f" {known.units}".rstrip()
    try:
        value, error = known.compute()
    except Exception as failure:
        say(f"  wrong: {type(failure).__name__}: {failure}")
        return False
    right = abs(value - known.value) <= known.within + 4 * error
    ours = f"{with_error(value, error) if error else plain(value, 9)}{units}"
    say(f"  {'right' if right else 'wrong'}: {ours}; known: {plain(known.value, 9)}{units} ({known.origin})")
    return bool(right)
