"""Turns a second of CPU time of the solver in Node over those of the compiled one, run alternately.

``python -m tests.benchmarks.script [A B C …] [--turns 200] [--rounds 3]``; medians, and what pages ask for.
"""

import argparse
import json
import subprocess
import tempfile
import time
from math import inf
from pathlib import Path
from statistics import median

from jointplay.analysis.rules import model_for
from jointplay.solver.mechanism import catalog
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_page.script.solver import solver

CASES = {"A": {}, "B": {"gear_ratio": 3.0}, "C": {"gear_ratio": 3.0, "clearance": 2.9e-4}}
RTOL, WARM, SHARE = 1e-8, 30, 1 / 6
PROGRAM = """
const { data, warm, turns, tangent } = JSON.parse(require("fs").readFileSync(0, "utf8"));
const solver = makeSolver(data);
solver.run(warm, { tangent });
const before = process.cpuUsage();
const found = solver.run(turns, { tangent });
const used = process.cpuUsage(before);
if (found.status !== "ok") throw new Error(found.meaning);
console.log((used.user + used.system) / 1e6);
"""


def in_node(script, turns, tangent):
    """CPU time of a run in Node, after turns in which its compiler learns."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.js"
        path.write_text(script.text + PROGRAM)
        given = json.dumps({"data": script.data, "warm": WARM, "turns": turns, "tangent": tangent})
        return float(
            subprocess.run(["node", path], input=given, capture_output=True, check=True, text=True).stdout
        )


def compiled(model, turns):
    """CPU time of the same run compiled."""
    begun = time.process_time()
    records = follow(model, Request(turns * model.period, RTOL, events=True, log_from=inf))
    assert records.status == 0
    return time.process_time() - begun


def main():
    """Measure the asked cases and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=["A", "B", "C"])
    parser.add_argument("--turns", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    for case in given.cases:
        mechanism = catalog.chunmei2002(**CASES[case])
        script, model = solver(mechanism, rtol=RTOL), model_for(mechanism, None)
        compiled(model, WARM)
        pairs = [
            (compiled(model, given.turns), in_node(script, given.turns, False)) for _ in range(given.rounds)
        ]
        native, node = (median(times) for times in zip(*pairs, strict=True))
        verdict = "fast enough" if native / node >= SHARE else "too slow"
        print(
            f"case {case}: compiled {given.turns / native:.0f} turns/s, in Node {given.turns / node:.0f}: "
            f"a share of {native / node:.2f}, {verdict} for {SHARE:.2f}"
        )


if __name__ == "__main__":
    main()
