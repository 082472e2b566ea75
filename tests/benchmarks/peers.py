"""One crank revolution, this package against its peers: time at equal error reached.

Run as ``python -m tests.benchmarks.peers [A B C] [--rounds 7] [--budget 60]`` from the root of the
repository. Every contender sees the same start, equations, events and end time; all are measured in one
process, taking turns, after a first run that compiles; medians of CPU time. Error: largest difference of a
state from truth.json in units of (1 rad, a/b). A run whose events differ from truth's is shown, and
left out of the comparison.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from importlib.util import find_spec

import numpy as np

from . import systems
from .heyoka_peer import Heyoka
from .solver_peers import Cvode, Scipy

TOLERANCES = {
    "jointplay": (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    "heyoka": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12),
    "CVODE": (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13),
    "LSODA": (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    "Radau": (1e-5, 1e-7, 1e-9, 1e-11),
    "DOP853": (1e-5, 1e-7, 1e-9, 1e-11),
}
ERRORS = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
KINDS = ("contact", "separation", "reopening", "slip_reversal", "stick_onset", "slip_onset", "impact")


def jointplay_run(case, rtol):
    """End state (6,), CPU seconds and evaluations of this package; the events are kept as an attribute.

    What is timed is the integration, as for the peers: assembling and allocating come before.
    """
    from jointplay.analysis.run import Request, functions, memory
    from jointplay.mechanism import catalog
    from jointplay.mechanism.assemble import assemble
    from jointplay.numerics import flow
    from jointplay.numerics.interface import direct
    from jointplay.numerics.memory import EVALUATIONS, LOGGED

    scene = assemble(catalog.chunmei2002(clearance=case.e, gear_ratio=case.i))
    k, x, o = memory(scene, Request(case.t_end, rtol, events=True, log_from=0.0))
    f, run = functions(scene.structure), direct(flow.flow)
    began = time.process_time()
    run(f, k, x, o)
    seconds = time.process_time() - began
    log = x.log[: x.count[LOGGED]]
    jointplay_run.events = [KINDS[int(kind)] for kind in log[:, 2]]
    return x.s[1:7].copy(), seconds, int(x.count[EVALUATIONS])


class Jointplay:
    """This package as a contender."""

    name = "jointplay"

    def __init__(self, tol):
        self.tol = tol

    def timed(self, case):
        """CPU seconds, end state, evaluations and event kinds."""
        state, seconds, evaluations = jointplay_run(case, self.tol)
        return seconds, state, evaluations, jointplay_run.events


class Peer:
    """Another solver as a contender: its ``run`` is timed whole."""

    def __init__(self, solver):
        self.solver, self.name, self.tol = solver, solver.name, solver.tol

    def timed(self, case):
        """CPU seconds, end state, evaluations (heyoka: steps) and event kinds."""
        began = time.process_time()
        found = self.solver.run(case)
        return time.process_time() - began, *found


@dataclass
class Row:
    """What one contender reached on one case."""

    contender: object
    error: float = float("nan")
    evaluations: int = 0
    events: int = 0
    trouble: str = ""
    times: list = field(default_factory=list)

    @property
    def median(self):
        """Median CPU time, s."""
        return float(np.median(self.times)) if self.times else float("nan")

    def measure(self, case, first=False):
        """Run once: the first run compiles and is judged, the others are timed."""
        try:
            seconds, state, self.evaluations, kinds = self.contender.timed(case)
        except Exception as trouble:  # a peer may fail in any way of its own; the table says how
            self.trouble = f"{type(trouble).__name__}: {trouble}"[:60]
            return
        if not first:
            self.times.append(seconds)
            return
        self.error, self.events = float(np.max(np.abs(state - case.truth) / case.scale)), len(kinds)
        if tuple(kinds) != case.events:
            self.trouble = "other events"


def contenders(names):
    """Every contender at every tolerance."""
    make = {
        "jointplay": Jointplay,
        "heyoka": lambda tol: Peer(Heyoka(tol)),
        "CVODE": lambda tol: Peer(Cvode(tol)),
    }
    for name in names:
        for tol in TOLERANCES[name]:
            yield make[name](tol) if name in make else Peer(Scipy(tol, name))


def compare(case, entries, rounds, budget):
    """Rows of one case: a judging run of each, then rounds of timed turns while the time budget lasts."""
    rows = [Row(entry) for entry in entries]
    for row in rows:
        row.measure(case, first=True)
    for _ in range(rounds):
        for row in rows:
            if not row.trouble and sum(row.times) < budget / len(rows):
                row.measure(case)
    return rows


def time_at(rows, error):
    """CPU time at an error, log over log between the runs no other run beats; nan beyond the tightest."""
    good = sorted((row for row in rows if row.times and not row.trouble), key=lambda row: row.median)
    front = []
    for row in good:
        if not front or row.error < front[-1].error:
            front.append(row)
    if not front or front[-1].error > error:
        return float("nan")
    errors = [np.log(row.error) for row in reversed(front)]
    times = [np.log(row.median) for row in reversed(front)]
    return float(np.exp(np.interp(np.log(error), errors, times)))


def show(case, rows):
    """Print the rows of a case and the comparison at equal error."""
    print(f"\ncase {case.name}: i = {case.i:g}, e = {case.e:g} m, {len(case.events)} events")
    print(f"{'':10}{'tol':>8}{'CPU ms':>11}{'error':>10}{'evaluations':>13}{'events':>8}")
    for row in rows:
        head = f"{row.contender.name:10}{row.contender.tol:8.0e}{1e3 * row.median:11.3f}{row.error:10.1e}"
        print(f"{head}{row.evaluations:13d}{row.events:8d}  {row.trouble}")
    names = list(dict.fromkeys(row.contender.name for row in rows))
    print(
        f"\n{'ms at error':12}" + "".join(f"{name:>11}" for name in names) + f"{'best peer / jointplay':>24}"
    )
    for error in ERRORS:
        at = {name: time_at([r for r in rows if r.contender.name == name], error) for name in names}
        peers = {name: t for name, t in at.items() if name != "jointplay" and t == t}
        best = min(peers, key=peers.get) if peers else "none"
        ratio = peers.get(best, float("nan")) / at.get("jointplay", float("nan"))
        print(
            f"{error:<12.0e}" + "".join(f"{1e3 * t:11.3f}" for t in at.values()) + f"{ratio:12.2f} ({best})"
        )


def main():
    """Measure the asked cases and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=["A", "B", "C"])
    parser.add_argument("--rounds", type=int, default=7, help="timed runs of each contender at most")
    parser.add_argument("--budget", type=float, default=60.0, help="CPU seconds of timed runs a case")
    parser.add_argument("--only", nargs="*", default=list(TOLERANCES), choices=list(TOLERANCES))
    asked = parser.parse_args()
    names = [name for name in asked.only if name != "jointplay" or find_spec("jointplay")]
    entries = list(contenders(names))
    for name in asked.cases:
        case = systems.load(name)
        show(case, compare(case, entries, asked.rounds, asked.budget))


if __name__ == "__main__":
    main()
