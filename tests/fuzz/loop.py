"""Many cases one after the other, each by its number alone: what was wrong, how they ended, the slowest."""

from __future__ import annotations

import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from jointplay.kinds import KINDS

SHORT = {  # keywords that make a study or a call of a kind brief, beside those of its trial
    "response": {"turns": 2, "steps": False},
    "section": {"turns": 2},
    "lyapunov": {"turns": 2},
    "covariant": {"turns": 2, "settling": 1},
    "chaos_test": {"turns": 20},
    "spectrum": {"turns": 2, "segments": 2},
    "dimension": {"turns": 40},
    "periodic_orbit": {"max_iterations": 2},
    "continuation": {"max_points": 3, "max_branches": 2},
    "curve": {"max_points": 3, "max_curves": 1},
    "bifurcation": {"turns": 3, "transient": 1, "lyapunov_turns": 2},
    "sensitivity": {"turns": 2, "neighbours": 2},
    "gradient": {"turns": 1},
    "optimise": {"max_iterations": 2},
    "attractors": {"starts": 3, "turns": 8, "transient": 2, "patience": 1, "lyapunov_turns": 2},
    "tipping": {"starts": 3, "turns": 8, "transient": 2, "patience": 1}
    | dict.fromkeys(("steps", "phases", "directions", "edge_turns"), 2),
    "tolerances": {"samples": 6, "turns": 8, "transient": 2, "lyapunov_turns": 2, "edge_runs": 3},
}
MAX_STEPS = 300


class Hang(BaseException):
    """It took too long."""


def _alarm(*_: Any) -> None:
    raise Hang


def within(limit: float, function: Callable[..., Any], *given: Any, **named: Any) -> tuple[Any, str | None]:
    """What a function gives, or the traceback of what it raised: `Hang` after so many s of CPU."""
    signal.signal(signal.SIGPROF, _alarm)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        return function(*given, **named), None
    except (Exception, SystemExit, Hang):
        return None, traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def brief(kind: str) -> dict[str, Any]:
    """Keywords of a short analysis of a kind."""
    return dict(KINDS[kind].trial) | SHORT.get(kind, {})


Case = tuple[str, Sequence[str], str | None]


def tried(what: str, seed: int, numbers: range, case: Callable[[int], Case]) -> bool:
    """Try cases by number: each gives how it is called, how it ended, and what was wrong; whether any was."""
    counts, slow, faults, began = Counter(), [], [], time.process_time()
    for number in numbers:
        started = time.process_time()
        shown, ends, wrong = case(number)
        took = time.process_time() - started
        counts.update(ends)
        slow = sorted([*slow, (took, number)])[-5:]
        if wrong:
            faults.append(number)
            print(f"---- {what} {number} of seed {seed}: {wrong}\n{shown}", flush=True)
    told = ", ".join(f"{count} {end}" for end, count in counts.items())
    spent = f"{time.process_time() - began:.0f} s of CPU"
    print(f"{len(numbers)} {what}s: {told}; {len(faults)} faults {faults[:20]}; {spent}")
    print("slowest: " + ", ".join(f"{number} {took:.1f} s" for took, number in reversed(slow)))
    return bool(faults)
