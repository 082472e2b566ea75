"""Kill a run at random moments, main process, a worker or all of it; compare with one left alone.

    python -m tests.jobs.kill_at_random [KILLS [STUDY …]]

A run is killed up to three times and then left to end. Every answer in the journal must be there once, and
the result must be the undisturbed one bit for bit. 30 runs take some twenty minutes, mostly to start Python
anew. Of a checkout that stays as it is meanwhile: its state is in the result.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

from xarray.testing import assert_identical

from jointplay.jobs.journal import Journal
from jointplay.study.results.store import open_result
from tests.support.sweep_samples import CELLS, CHAINS, KINDS, PLANE, TIMES, loaded, ran

KILLS = 3  # of one run
LONGER = {
    "cells": (CELLS, ["vary.gap={start=2.9, stop=3.1, num=60}", "analysis.turns=1500"]),
    "chains": (CHAINS, ["vary.gap={start=2.9, stop=3.1, num=80}", "analysis.turns=1500"]),
    "plane": (PLANE, ["analysis.plane.y.num=80", "analysis.plane.v.num=80", "analysis.transient=300"]),
    "fine": (
        PLANE.replace('"plane"', '"fine"'),
        [
            "analysis.plane.y.num=81",
            "analysis.plane.v.num=81",
            "analysis.refine=3",
            "analysis.transient=300",
        ],
    ),
    "refined": (
        CHAINS.replace('"chains"', '"refined"'),
        [
            "vary.gap={start=1.0, stop=9.0, num=33}",
            "vary.restitution={start=0.7, stop=0.86, num=33}",
            "analysis.direction='reset'",
            "analysis.refine=3",
            "analysis.turns=100",
        ],
    ),
} | {
    kind: (KINDS[kind], changes)
    for kind, changes in {
        "gradient": ["vary.gap={start=3.4, stop=3.8, num=40}"],
        "optimise": ["vary.gap={start=3.4, stop=3.8, num=20}"],
        "curve": ["vary.gap={start=3.4, stop=3.8, num=8}"],
        "covariant": ["vary.gap={start=2.9, stop=3.1, num=12}", "analysis.turns=300"],
        "attractors": ["vary.gap={start=3.4, stop=3.8, num=12}", "analysis.starts=80"],
        "tolerances": ["analysis.samples=3000"],
        "tipping": ["analysis.starts=40"],
    }.items()
}


def children(process):
    """Processes that a process has started."""
    with suppress(OSError):
        return [int(word) for word in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    return []


def run_and_kill(command, journal, wait):
    """Kill a run some time after it began to write, or let it end; its exit code, and who was killed."""
    before = len(journal.parts())
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, start_new_session=True, **silent)
    while process.poll() is None and len(journal.parts()) == before:
        time.sleep(0.01)
    with suppress(subprocess.TimeoutExpired):
        return process.wait(wait), None
    workers = children(process.pid)[:2]
    whom = random.choice(["main", "group", *(["worker"] if workers else [])])
    with suppress(OSError):
        if whom == "group":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            os.kill(process.pid if whom == "main" else random.choice(workers), signal.SIGKILL)
    return process.wait(), whom


def twice(journal):
    """Keys that stand in more than one part."""
    keys = Counter(key for frame in journal._sound() for key in frame.index)
    return [key for key, count in keys.items() if count > 1]


def main(kills, *names):
    """Take the studies in turn."""
    names, alone = names or list(LONGER), {}
    for number in range(kills):
        name = names[number % len(names)]
        text, changes = LONGER[name]
        with tempfile.TemporaryDirectory() as folder:
            out, path, told = Path(folder), Path(folder) / f"{name}.toml", []
            path.write_text(text)
            command = [sys.executable, "-m", "jointplay", "run", path, "--out", out, "--no-figure"]
            command = [*map(str, command), "--set", *changes]
            journal = Journal(out / f"{name}.journal")
            while not told or told[-1][0]:
                told.append(
                    run_and_kill(command, journal, random.uniform(0.0, 2.0) if len(told) < KILLS else 600)
                )
                time.sleep(0.5)  # workers whose parent is dead end within a quarter of a second
                assert not twice(journal), "a finished cell ran twice"
            if name not in alone:
                ran(loaded(text, *changes), out / "alone", jobs=2)
                alone[name] = open_result(out / "alone" / f"{name}.nc").load()
            one = open_result(out / f"{name}.nc").load()
            assert_identical(*(each.drop_vars(TIMES, errors="ignore") for each in (one, alone[name])))
            print(f"{number + 1:>3} {name:<7} {told}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30, *sys.argv[2:])
