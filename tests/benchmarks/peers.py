"""One turn of the paper's mechanism by the methods of `work_precision`, and by heyoka tuned by hand.

Run as ``python -m tests.benchmarks.peers [A B C] [--rounds 7] [--budget 60]`` from the root of the
repository.
"""

from __future__ import annotations

import argparse

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import MAX_STEPS
from jointplay_lab.precision.contenders import Ours
from jointplay_lab.precision.work_precision import (
    PEERS,
    SHARP,
    TOLERANCES,
    Row,
    Truth,
    contender,
    dataset,
    measure,
)

from .tuned_heyoka import TunedHeyoka

CASES = {
    "A": {},
    "B": {"gear_ratio": 3.0},
    "C": {"gear_ratio": 3.0, "clearance": 2.9e-4},
    "B_sticking": {"gear_ratio": 3.0, "friction": 0.3},
}


def compare(case, methods, rounds, budget):
    """The dataset of `work_precision` for a case, with `methods` (classes of peers) beside ours."""
    model = assemble(catalog.chunmei2002(**CASES[case]))
    truth = Truth.of(model, SHARP, model.period)
    rows = []
    for method in (Ours, *methods):
        for rtol in TOLERANCES:
            ready = contender(method, model, rtol, model.period, truth, MAX_STEPS)
            rows.append(Row(method.name, rtol, ready))
    measure(rows, truth, rounds, budget)
    return dataset(rows, truth, TOLERANCES, 1.0, SHARP)


def show(case, result):
    """Print CPU times in ms at errors reached, and how many times this package's the best peer's is."""
    times = 1e3 * result["cpu_time_at_error"].to_pandas().T
    times["best peer, times"] = times.drop(columns=Ours.name).min(axis=1) / times[Ours.name]
    print(f"\ncase {case}: CPU time of a turn, ms, at an error reached")
    print(times.to_string(float_format="{:.3g}".format), flush=True)


def main():
    """Measure the asked cases and print."""
    known = PEERS | {TunedHeyoka.name: TunedHeyoka}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=["A", "B", "C"])
    parser.add_argument("--rounds", type=int, default=7, help="timed runs of each method at most")
    parser.add_argument("--budget", type=float, default=60.0, help="CPU seconds of a case")
    parser.add_argument("--only", nargs="*", default=list(known), choices=list(known))
    given = parser.parse_args()
    for case in given.cases:
        show(case, compare(case, [known[name] for name in given.only], given.rounds, given.budget))


if __name__ == "__main__":
    main()
