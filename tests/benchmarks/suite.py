"""The benchmark suite: what a user waits for, and how much a core does.

    python -m tests.benchmarks.suite [start] [speed] [cells] [memory]

`start`: CPU and wall time of a first run in a process of its own, with an empty cache and with a full one.
`speed`: revolutions of the crank a second and core at rtol 1e-8: rigid, elastic coupler, one exponent, all.
`cells`: cells of a sweep an hour and core: 100 section points after 100 turns, at rtol 1e-7, one process.
`memory`: the most that a process holds, after importing and after each of these runs (Linux).
Medians; what scenes pay is in `scenes`, peers in `peers` and in studies of kind work_precision.
"""

from __future__ import annotations

import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from statistics import median

from . import scenes

FIRST = "import jointplay as jp; jp.simulate(jp.catalog.chunmei2002({changes}), turns=1)"
STARTS = {"rigid": "gear_ratio=3.0", "elastic coupler": "gear_ratio=3.0, elastic=('coupler',)"}
TURNS, ROUNDS = 200, 5
CELL_TURNS = 200


def start():
    """A first run: cold, then warm."""
    for name, changes in STARTS.items():
        with tempfile.TemporaryDirectory() as folder:
            cold = _process(FIRST.format(changes=changes), folder)
            warm = [_process(FIRST.format(changes=changes), folder) for _ in range(3)]
        cpu, wall = (median(times) for times in zip(*warm, strict=True))
        print(f"start   {name:18} cold {cold[0]:6.1f} s CPU {cold[1]:6.1f} s wall; ", end="")
        print(f"warm {cpu:5.2f} s CPU {wall:5.2f} s wall")
    bare = median(_process("import jointplay as jp; jp.simulate", None)[0] for _ in range(3))
    print(f"start   {'imports alone':18} {bare:.2f} s CPU")


def _process(code, cache):
    """CPU and wall seconds of a Python process and what it starts."""
    own = os.environ | ({"JOINTPLAY_CACHE": cache} if cache else {})
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-c", code], env=own, check=True)
    after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - began
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def speed():
    """Revolutions a second and core."""
    named = {row.name: row for row in scenes.rows(TURNS, 1e-8)}
    chosen = [named[name] for name in ("plain", "one elastic link", "one exponent", "all exponents")]
    for count in range(ROUNDS + 1):
        for row in chosen:
            row.measure()
            if count == 0:
                row.times.clear()
    for row in chosen:
        print(f"speed   {row.name:18} {TURNS / median(row.times):7.0f} revolutions a second and core")


def cells():
    """Cells an hour and core, with assembling and all that a cell does."""
    import jointplay as jp

    def cell(number):
        mechanism = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=2.9e-5 + 1e-7 * number)
        began = time.process_time()
        jp.poincare(mechanism, turns=CELL_TURNS // 2, transient=CELL_TURNS // 2, rtol=1e-7)
        return time.process_time() - began

    cell(0)
    each = median(cell(number) for number in range(1, 21))
    print(f"cells   {CELL_TURNS} turns at rtol 1e-7 {3600 / each:9.0f} an hour and core, ", end="")
    print(f"{1e3 * each:.0f} ms each")


def memory():
    """The most that a process holds."""
    held = "print(*(x.split()[1] for x in open('/proc/self/status') if x.startswith('VmHWM')))"
    runs = {"imports alone": "import jointplay as jp; jp.simulate"}
    runs |= {name: FIRST.format(changes=changes) for name, changes in STARTS.items()}
    for name, code in runs.items():
        done = subprocess.run([sys.executable, "-c", f"{code}\n{held}"], check=True, capture_output=True)
        print(f"memory  {name:18} {int(done.stdout) / 1e3:.0f} MB")


def main(words):
    """Run what is named, or all, and say where."""
    told = ", ".join(f"{name} {version(name)}" for name in ("numba", "numpy"))
    print(f"on {platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}, {told}")
    known = {"start": start, "speed": speed, "cells": cells, "memory": memory}
    for word in words or known:
        known[word]()


if __name__ == "__main__":
    main(sys.argv[1:])
