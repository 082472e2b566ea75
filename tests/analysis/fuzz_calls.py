"""Calls with drawn keywords: `python -m tests.analysis.fuzz_calls [CALLS] [SEED] [FIRST]` (3 000: minutes).

Every public function and record is called with right, wrong and strange values. A call has to end in an
answer with a status, or in an `InputError`; soon, and with no warning but our own. Drawn by its number alone.
"""

import inspect
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from collections import Counter

import matplotlib as mpl
import numpy as np
import xarray as xr

import jointplay as jp
from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.changes import Changes
from tests.analysis.fuzz_values import (
    BENT,
    BRIEF,
    CALLS,
    DUFFING,
    FIGURES,
    GUIDED,
    IDEAL,
    LOOPS,
    LOOSE,
    MOVING,
    PAIR,
    RIGHT,
    RIGID,
    STRANGE,
    WEIGHTS,
)

mpl.use("agg")
LIMIT = 60.0  # s of CPU, a call; compiling takes most of it
MEMORY = 16 * 2**30


class Hang(BaseException):
    """It took too long."""


def _alarm(*_):
    raise Hang


def found(name):
    """What is called, and what it takes."""
    if name.endswith("replace"):
        owner = LOOSE if name.startswith("Mech") else DUFFING
        known = list(Changes.model_fields) if owner is LOOSE else [*owner.parameters, "initial", "period"]
        return owner.replace, known
    function = (
        getattr(catalog, name.removeprefix("catalog.")) if name.startswith("cat") else getattr(jp, name)
    )
    known = [
        key for key in inspect.signature(function).parameters if key not in ("values", "data", "options")
    ]
    extra = {"catalog.chunmei2002": list(Changes.model_fields), "figure": FIGURES, "cell": ("clearance",)}
    return function, [*known, *extra.get(name, ())]


def _small(key, value):
    """Whether a keyword's value cannot make a call long."""
    if key not in LOOPS or isinstance(value, bool):
        return True
    values = value if isinstance(value, list | tuple) else [value]
    return not any(
        isinstance(each, int | float) and (10 < each <= 1e12 or 0 < each < 1e-6) for each in values
    )


def drawn(number, seed):
    """A call: name, function, arguments by position, keywords."""
    dice = random.Random(f"{seed} {number}")
    (name,) = dice.choices(list(CALLS), WEIGHTS)
    function, known = found(name)
    given = {key: value for key, value in BRIEF.items() if key in known} | CALLS[name]
    for key in dice.sample(known, min(len(known), dice.choice((0, 1, 1, 1, 2, 3)))):
        right = RIGHT.get(key, ())
        value = dice.choice(right) if right and dice.random() < 0.6 else dice.choice(STRANGE)
        if key in BRIEF and (value is None or (isinstance(value, int) and 0 < value < 10**10)):
            continue  # right, but long
        if _small(key, value):
            given[key] = value
    if dice.random() < 0.05:
        given[dice.choice(("turms", "", "self", "1", "model_config"))] = dice.choice(STRANGE)
    if given and dice.random() < 0.05:
        given.pop(dice.choice(list(given)))
        given |= {key: value for key, value in BRIEF.items() if key in known}
    positional = [dice.choice(STRANGE) for _ in range(3)] if dice.random() < 0.03 else []
    if name in ("figure", "cell") and not positional:
        positional = [given.pop("dataset", None)]
    return name, function, positional, given


def fault(name, function, positional, given):
    """What is wrong with how a call ended, or None; and how it ended."""
    signal.signal(signal.SIGPROF, _alarm)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.simplefilter("ignore", jp.ModelWarning)
            answer = function(*positional, **given)
    except jp.InputError as error:
        signal.setitimer(signal.ITIMER_PROF, 0)
        return (None, "refused") if error.problems and str(error) else ("refused without a reason", "refused")
    except (Exception, Hang):
        signal.setitimer(signal.ITIMER_PROF, 0)
        return traceback.format_exc(), "raised"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return wrong_answer(name, answer), "answered"


OTHERS = (
    "figure",
    "summary",
    "contact_data",
    "contact_stiffness",
    "fit",
    "animate",
    "export",
    "report",
)  # which give no dataset


def wrong_answer(name, answer):
    """What is wrong with an answer; None if nothing is."""
    if not isinstance(answer, xr.Dataset):
        fine = name[0].isupper() or name.startswith("cat") or name in OTHERS
        return None if fine else f"gave {answer!r}"
    if name != "words" and not 0 <= int(answer.status) < len(STATUS):
        return f"status {answer.status.item()}"
    if name in ("sensitivity", "growth") and not int(answer.status) and "growth" in answer:
        return None if np.isfinite(answer.growth) else "ok, but growth is NaN"
    return None


def warm():
    """Compile and import what calls need, so that none is slow for that."""
    from matplotlib import pyplot  # noqa: F401

    for one in (*MOVING, BENT, GUIDED, RIGID):
        for more in ({}, {"record": ["energy_residual"] if isinstance(one, jp.Mechanism) else None}):
            jp.simulate(one, turns=0.1, **more)
        jp.lyapunov(one, turns=0.1)
    CALLS["animate"]["motion"] = jp.simulate(LOOSE, turns=0.1, record=["angle"])
    for one in (PAIR, DUFFING, LOOSE, IDEAL):
        jp.growth(one, turns=1, transient=0)
        jp.basins(
            one,
            plane={"crank_angle": [0, 1], "crank_speed": [8, 9]}
            if one in (LOOSE, IDEAL)
            else RIGHT["plane"][0],
            turns=4,
            transient=0,
            n_jobs=1,
            max_steps=9,
        )


def main(calls=3000, seed=0, first=0):
    """Try so many calls; tell what was wrong, and how long the slowest took."""
    warm()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    counts, slow, faults, began = Counter(), [], [], time.process_time()
    for number in range(first, first + calls):
        name, function, positional, given = drawn(number, seed)
        started = time.process_time()
        wrong, end = fault(name, function, positional, given)
        took = time.process_time() - started
        counts[end] += 1
        slow = sorted([*slow, (took, number, name)])[-5:]
        if wrong or took > LIMIT:
            faults.append(number)
            shown = ", ".join([*map(shortly, positional), *(f"{k}={shortly(v)}" for k, v in given.items())])
            print(f"---- call {number} of seed {seed}: {name}({shown})\n{wrong or 'too slow'}", flush=True)
    told = ", ".join(f"{count} {end}" for end, count in counts.items())
    print(f"{calls} calls: {told}; {len(faults)} faults {faults}; {time.process_time() - began:.0f} s of CPU")
    print("slowest: " + ", ".join(f"{number} {name} {took:.1f} s" for took, number, name in reversed(slow)))
    return bool(faults)


def shortly(value):
    """A value in a line."""
    text = "<a huge number>" if isinstance(value, int) and abs(value) > 10**30 else repr(value)
    return text.replace("\n", " ")[:120]


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
