"""Mutated study files: `python -m tests.cli.fuzz [FILES] [SEED] [KIND …]` (10 000 files take some minutes).

Every shipped study and the samples of the tests are changed at random (mutations.py). `jointplay check` has
to accept each, in silence or with doubts, or refuse it by lines of a key path, what was given and what is
accepted; soon, and nothing else. A share of what is accepted is planned and run too, each motion over a few
hundred steps. Where kinds are named, files of these alone are changed, and all that are accepted are run.
"""

import contextlib
import io
import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

from jointplay import cli
from tests.cli import mutations

LIMIT, RUN_LIMIT = 10.0, 60.0  # s of CPU, a file
RUN_SHARE = 0.25  # of what is accepted
LINE = re.compile(r"  ((?P<key>\S.*?): got (?P<given>.*?); (?P<accepted>.+)|and [\d,]+ more)")
ROOTS = re.compile(r"(kind|name|title|mechanism|vary|integrator|analysis|figure|study file|--set)\b")
CELLS = 12  # at most, of what is run
SETTLED = ["analysis.starts=3", "analysis.turns=8", "analysis.transient=2", "analysis.patience=1"]
KNOCKS = [f"analysis.{name}=2" for name in ("steps", "phases", "directions", "edge_turns")]
BRIEF = {  # kinds that are run, and what makes them short
    "response": ["analysis.turns=2"],
    "section": ["analysis.turns=2"],
    "lyapunov": ["analysis.turns=2"],
    "covariant": ["analysis.turns=2", "analysis.settling=1"],
    "chaos_test": ["analysis.turns=20"],
    "spectrum": ["analysis.turns=2", "analysis.segments=2"],
    "dimension": ["analysis.turns=40"],
    "periodic_orbit": ["analysis.max_iterations=2"],
    "continuation": ["analysis.max_points=3", "analysis.max_branches=2"],
    "curve": ["analysis.max_points=3", "analysis.max_curves=1"],
    "bifurcation": ["analysis.turns=3", "analysis.transient=1", "analysis.lyapunov_turns=2"],
    "sensitivity": ["analysis.turns=2", "analysis.neighbours=2"],
    "gradient": ["analysis.turns=1", "analysis.transient=2"],
    "optimise": ["analysis.transient=2", "analysis.max_iterations=2"],
    "attractors": [*SETTLED, "analysis.lyapunov_turns=2"],
    "tipping": SETTLED + KNOCKS,
}


class Hang(BaseException):
    """It took too long."""


def _alarm(*_):
    raise Hang


def called(words, limit):
    """Exit code, output, errors and time of a command; the traceback in place of a code."""
    out, err, began = io.StringIO(), io.StringIO(), time.process_time()
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main(words)
    except (Exception, SystemExit, Hang):
        code = traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return code, out.getvalue(), err.getvalue(), time.process_time() - began


def fault(code, out, err):
    """What is wrong with how `check` ended; None if nothing is."""
    if code == 0:
        doubted = all(line.startswith("warning ") for line in err.splitlines())
        return None if out and doubted else "accepted, but not in silence"
    if code != 2:
        return f"ended with {code}"
    first, *lines = err.splitlines()
    wrong = [line for line in lines if not LINE.fullmatch(line)]
    return None if first.startswith("wrong input") and lines and not wrong else f"says {wrong or err}"


def brief(table):
    """Changes that make a run short; None where it cannot be, or would compile."""
    mechanism, analysis = table.get("mechanism", {}), table.get("analysis", {})
    if table.get("kind") not in BRIEF or "catalog" not in mechanism or "elastic" in mechanism:
        return None
    if {"duration", "windows", "at", "plane", "error"} & set(analysis):
        return None
    return ["integrator.max_steps=300", *BRIEF[table["kind"]]]


def ran(path, table, folder):
    """How planning and running an accepted study ended: None if well."""
    changes = brief(table)
    if changes is None or called(["check", path, "--set", *changes], LIMIT)[0] != 0:
        return None, False
    words = ["--out", folder, "--jobs", "1", "--set", *changes]
    planned = called(["plan", path, *words], RUN_LIMIT)
    if planned[0] not in (0, 2):
        return f"plan ended with {planned[0]}", True
    cells = re.search(r"(\d+) cells", planned[1])
    if cells and int(cells[1]) > CELLS:
        return None, True
    code, _, err, _ = called(["run", path, "--fresh", *words], RUN_LIMIT)
    return (None if code in (0, 1) else f"run ended with {code}\n{err}"), True


def mutated(dice, numbers):
    """A text, its table where it is one still, and words for the command line."""
    i = dice.choice(numbers)
    if dice.random() < 0.2:
        return mutations.changed_text(mutations.TEXTS[i], dice), {}, []
    table = mutations.changed_table(mutations.TABLES[i], dice)
    words = ["--set", mutations.change(mutations.TABLES[i], dice)] if dice.random() < 0.15 else []
    return mutations.dumped(table), table, words


def main(files=10_000, seed=0, *kinds):
    """Try so many files; tell what was wrong, and how long the slowest took."""
    numbers = [n for n, table in enumerate(mutations.TABLES) if not kinds or table.get("kind") in kinds]
    signal.signal(signal.SIGPROF, _alarm)
    counts, slow, faults, began = Counter(), [], [], time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "study.toml")
        for n in numbers:  # what checking compiles, so that none is slow for that
            Path(path).write_text(mutations.TEXTS[n])
            assert called(["check", path], 10 * RUN_LIMIT)[0] == 0, mutations.TEXTS[n]
        for number in range(files):
            dice = random.Random(f"{seed} {number}")
            text, table, words = mutated(dice, numbers)
            Path(path).write_bytes(text.encode("utf-8", "surrogatepass"))
            code, out, err, took = called(["check", path, *words], LIMIT)
            wrong = fault(code, out, err)
            counts[code if isinstance(code, int) else "traceback"] += 1
            slow = sorted([*slow, (took, number)])[-5:]
            if code == 0 and not words and (kinds or dice.random() < RUN_SHARE):
                wrong, tried = ran(path, table, os.path.join(folder, "out"))
                counts["run"] += tried
            if wrong:
                faults.append(number)
                print(f"---- file {number} of seed {seed}: {wrong}\n{' '.join(words)}\n{text}", flush=True)
    told = ", ".join(f"{count} times {code}" for code, count in counts.items())
    spent = f"{time.process_time() - began:.0f} s of CPU"
    print(f"{files} files: {told}; {len(faults)} faults {faults[:20]}; {spent}")
    print("slowest: " + ", ".join(f"file {number} {took:.2f} s" for took, number in reversed(slow)))
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3]), *sys.argv[3:]))
