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

import numpy as np

from jointplay.analysis.quantities import EVENTS
from jointplay.lab.precision.contenders import Ours
from jointplay.lab.precision.measure import SHORT, time_at
from jointplay.mechanism import catalog
from jointplay.mechanism.assemble import assemble

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


class Jointplay:
    """This package as a contender."""

    name = "jointplay"

    def __init__(self, tol):
        self.tol = tol

    def timed(self, case):
        """CPU seconds, end state, evaluations and event kinds."""
        model = assemble(catalog.chunmei2002(clearance=case.e, gear_ratio=case.i))
        found = Ours(model, self.tol, case.t_end).run()
        return found.seconds, found.state, int(found.evaluations), [EVENTS[kind] for _, kind in found.events]


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
    def agreement(self):
        """Whether it was timed and met truth's events."""
        return "same" if self.times and not self.trouble else "other_events"

    @property
    def median(self):
        """Median CPU time, s."""
        return float(np.median(self.times)) if self.times else float("nan")

    def measure(self, case, first=False):
        """Run once: the first run compiles and is judged, the others are timed."""
        try:
            seconds, state, self.evaluations, kinds = self.contender.timed(case)
            if seconds < SHORT and not first:
                seconds = self.contender.timed(case)[0]
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
    entries = list(contenders(asked.only))
    for name in asked.cases:
        case = systems.load(name)
        show(case, compare(case, entries, asked.rounds, asked.budget))


if __name__ == "__main__":
    main()
