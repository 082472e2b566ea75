"""Section points a second of the relief valve beside Boost odeint; a user's system beside the catalog's."""

import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

import jointplay as jp
from tests.peers.odeint_valve import compiled, follow

FLOWS, DURATION, RTOL, ROUNDS = (1.0, 3.0, 5.0, 7.5), 4000.0, 1e-10, 7
SHORT, EXACT = 100.0, 1e-13  # of the motion whose last section point is compared
LOOSER = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, RTOL)
SECTION = jp.Plane(quantity="v", value=0.0, direction="down")
TURNS = 4000


def ours(flow, duration=DURATION, rtol=RTOL):
    """Section points of the valve and the CPU seconds that they took."""
    valve, begin = jp.catalog.relief_valve(flow=flow), time.process_time()
    points = jp.poincare(valve, section=SECTION, duration=duration, rtol=rtol)
    return points, time.process_time() - begin


def lift(flow, rtol):
    """The last lift on the section of a short motion."""
    return float(ours(flow, SHORT, rtol)[0].state_value.sel(state="x")[-1])


def measured():
    """Rows by flow, and the cost of a user's system over the catalog's.

    Points a second here and there, how many times as fast, both errors of a last lift; then the tolerance
    with which that error is no larger here than there, and how many times as fast it is.
    """
    rows = {}
    with TemporaryDirectory() as folder:
        program = compiled(Path(folder))
        if program is None:
            raise RuntimeError("the comparison needs g++ and Boost's headers (libboost-dev)")
        for flow in FLOWS:
            exact = lift(flow, EXACT)
            errors = {rtol: abs(lift(flow, rtol) / exact - 1) for rtol in LOOSER}
            there = abs(follow(program, "dopri5", RTOL, SHORT, flow).last[1] / exact - 1)
            alike = max(rtol for rtol, error in errors.items() if error <= max(there, errors[RTOL]))
            speeds = [speeds_at(program, flow, alike) for _ in range(ROUNDS)]
            same, looser, theirs = map(median, zip(*speeds, strict=True))
            name = f"flow_{flow:g}".replace(".", "_")
            rows[name] = [same, theirs, same / theirs, errors[RTOL], there, alike, looser / theirs]
    return rows | {"own": [own_over_catalog()]}


def speeds_at(program, flow, alike):
    """Section points a second here at both tolerances, and there, in turn."""
    found = [(points.sizes["turn"] / seconds) for points, seconds in (ours(flow), ours(flow, rtol=alike))]
    theirs = follow(program, "dopri5", RTOL, DURATION, flow)
    return *found, theirs.points / theirs.seconds


def own_over_catalog():
    """CPU time of the impact pair as a user writes it over that of the catalog's, run alternately."""
    walls = [{"name": name, "gap": f"gap/2 {sign} y", "restitution": "restitution"}
             for name, sign in (("upper", "-"), ("lower", "+"))]  # fmt: skip
    own = jp.System(
        name="rattle",
        states={"y": 0.0, "v": 0.0},
        parameters={"gap": 0.4, "restitution": 0.8},
        rates={"y": "v", "v": "sin(t)"},
        forcing=2 * np.pi,
        impacts=walls,
    )
    spent = {True: [], False: []}
    for _ in range(2 * ROUNDS + 1):
        for users, system in ((True, own), (False, jp.catalog.impact_pair(0.4, 0.8))):
            begin = time.process_time()
            jp.poincare(system, turns=TURNS)
            spent[users].append(time.process_time() - begin)
    return median(a / b for a, b in zip(spent[True][1:], spent[False][1:], strict=True))


class Valve:
    """How many times as fast as odeint."""

    def setup_cache(self):
        return measured()

    setup_cache.timeout = 1800

    def track_times_as_fast(self, found):
        return min(row[2] for name, row in found.items() if name != "own")

    track_times_as_fast.unit = "times"
