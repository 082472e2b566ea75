"""What a scene pays for: evaluations, attempted steps and CPU time of a turn, part by part.

    python -m tests.benchmarks.scenes [--turns 40] [--rounds 7] [--rtol 1e-8]

Each row changes one thing of the paper's mechanism at gear ratio 3. All rows run in one process, taking
turns; medians of CPU time. Seconds tell what the machine does besides; evaluations (of one state) and
attempts do not.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median

import numpy as np

from jointplay.analysis.run import Request, counts, functions, memory
from jointplay.analysis.tangents import Bundle
from jointplay.codegen import cache
from jointplay.mechanism import catalog
from jointplay.mechanism.assemble import assemble

PLAIN = {"gear_ratio": 3.0}
ALL = ("crank", "coupler", "rocker")
SCENES = {
    "plain": {},
    "free of friction": {"friction": 0.0},
    "sticking (f = 0.3)": {"friction": 0.3},
    "gravity off": {"gravity": 0.0},
    "one elastic link": {"elastic": ("coupler",)},
    "three elastic links": {"elastic": ALL},
}
SAMPLES = 720


@dataclass
class Row:
    """One scene: how it is run (CPU seconds and counts), and what the runs took."""

    name: str
    run: Callable[[], tuple[float, dict[str, int]]]
    found: dict[str, int] = field(default_factory=dict)
    times: list[float] = field(default_factory=list)

    def measure(self):
        """Run once."""
        seconds, self.found = self.run()
        self.times.append(seconds)


def followed(scene, request):
    """A run of the flow."""
    from jointplay.numerics.interface import direct
    from jointplay.numerics.memory import LOGGED

    flow = cache.method("flow")
    f, run, (k, x, o) = functions(scene.structure), direct(flow.flow), memory(scene, request)
    began, code = time.process_time(), flow.FULL
    while code == flow.FULL:
        code = run(f, k, x, o)
        x.count[LOGGED] = 0
    seconds = time.process_time() - began
    if code != flow.OK:
        raise RuntimeError(f"the run ended with {code}")
    return seconds, counts(x)


def with_tangents(scene, request, vectors):
    """A run of the flow with that many exponents."""
    bundle = Bundle(scene, request, np.eye(len(scene.state))[:vectors], rows=4096)
    began = time.process_time()
    while (status := bundle.advance()) == bundle.full:
        bundle.taken()
    seconds = time.process_time() - began
    if status:
        raise RuntimeError(f"the run ended with {status}")
    return seconds, counts(bundle.x)


def rows(turns, rtol):
    """Every row."""
    for name, changes in SCENES.items():
        scene = assemble(catalog.chunmei2002(**PLAIN | changes))
        request = Request(turns * scene.period, rtol)
        yield Row(name, lambda scene=scene, request=request: followed(scene, request))
    plain, powers = (assemble(catalog.chunmei2002(**PLAIN), powers=powers) for powers in (False, True))
    end = turns * plain.period
    at = np.linspace(0.0, end, SAMPLES * turns + 1)
    recorded = Request(end, rtol, at=at, events=True, log_from=0.0)
    yield Row("recorded, 720 a turn", lambda: followed(plain, recorded))
    yield Row("and its energy balance", lambda: followed(powers, recorded))
    for name, vectors in (("one exponent", 1), ("all exponents", len(plain.state))):
        yield Row(name, lambda n=vectors: with_tangents(plain, Request(end, rtol), n))


def show(found, turns):
    """Print the table, all relative to the first row."""
    print(f"{'':24}{'evaluations':>13}{'attempts':>10}{'events':>8}{'CPU µs':>10}{'of plain':>10}")
    first = median(found[0].times)
    for row in found:
        of = row.found
        attempts = of["n_steps"] + of["n_rejected"] + of["n_failed"]
        numbers = (of["n_evaluations"] / turns, attempts / turns, of["n_events"] / turns)
        cost = median(row.times)
        print(f"{row.name:24}{numbers[0]:13.0f}{numbers[1]:10.1f}{numbers[2]:8.1f}", end="")
        print(f"{1e6 * cost / turns:10.0f}{cost / first:10.2f}")


def main():
    """Measure every row and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--rtol", type=float, default=1e-8)
    asked = parser.parse_args()
    found = list(rows(asked.turns, asked.rtol))
    for count in range(asked.rounds + 1):
        for row in found:
            row.measure()
            if count == 0:
                row.times.clear()  # the first run loads what is compiled
    show(found, asked.turns)


if __name__ == "__main__":
    main()
