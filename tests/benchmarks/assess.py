"""CPU seconds until the parts of an assessment are known, import included, on one processor.

``python -m tests.benchmarks.assess [NAME ...] [--cold]``: a row of a table each, beside what is wanted. The
kernels are compiled by a run before; ``--cold`` has none at all, as the first run of an installation.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from functools import partial

PARTS = ("verdict", "what it hangs on", "curves", "edges")
WANTED = (3, 4, 6)  # s
EDGES = {"period 1": 15, "longer period": 30, "no period": 60}  # s
WIPER = {"lengths": (0.045, 0.31, 0.09, 0.3), "masses": (0.18, 0.42, 0.35), "speed": 65 * math.pi / 30}
INERTIAS = (3.1e-5, 3.4e-3, 2.4e-4)
CRANK = {"lengths": (0.04, 0.16, 0.11, 0.17), "masses": (0.25, 0.6, 0.4), "speed": 10 * math.pi}


def four_bar(lengths, masses, speed, play, inertias=None, friction=0.1):
    """A four-bar with play at the coupler's far end; slender bars where no inertia is given."""
    import jointplay as jp
    from jointplay.solver.mechanism.catalog.presets import four_bar_pins, joined

    names, (crank, coupler, rocker, ground) = ("crank", "coupler", "rocker"), lengths
    inertias = inertias or [m * size**2 / 12 for m, size in zip(masses, lengths, strict=False)]
    rows = zip(names, lengths, masses, inertias, strict=False)
    links = [
        jp.Link(name=name, length=size, mass=mass, centre=size / 2, inertia_centre=inertia)
        for name, size, mass, inertia in rows
    ]
    pins = four_bar_pins(crank, coupler, rocker, ground)
    joints = joined(pins, "", radius=0.006, stiffness=1e7, damping=300.0, friction=friction)
    drive = jp.ConstantSpeed(link="crank", speed=speed)
    return jp.Mechanism(links=tuple(links), joints=joints, drive=drive).replace(clearance={"B": play})


def made(name, **given):
    """A mechanism of the catalogue."""
    import jointplay as jp

    return getattr(jp.catalog, name)(**given)


MECHANISMS = {  # seven of the documentation and the tests, and three more
    "slider-crank": partial(made, "slider_crank", clearance={"B": 1e-4}),
    "slider-crank, 20 rad/s": partial(made, "slider_crank", clearance={"B": 1e-4}, speed=20.0),
    "four-bar, 29 µm": partial(made, "chunmei2002", clearance=2.9e-5, gear_ratio=3.0),
    "four-bar, 29 µm, slow": partial(made, "chunmei2002", clearance=2.9e-5, gear_ratio=15.0),
    "four-bar, 0.29 mm": partial(made, "chunmei2002", clearance=2.9e-4, gear_ratio=3.0),
    "quick return": partial(made, "quick_return", clearance={"D": 5e-5}),
    "Watt": partial(made, "watt", clearance={"D": 5e-5}),
    "wiper": partial(four_bar, **WIPER, inertias=INERTIAS, play=6e-5),
    "wiper without friction": partial(four_bar, **WIPER, inertias=INERTIAS, play=6e-5, friction=0.0),
    "crank-rocker": partial(four_bar, **CRANK, play=3e-5),
}


def one(name):
    """Print CPU seconds of this process when each part is known, and how the motion repeats."""
    from jointplay.analysis.cells import driven, in_memory

    def show(dataset, _):
        times.append(time.process_time())
        periods[:] = [float(dataset["period"])]

    import jointplay as jp

    times, periods = [], []
    call = partial(jp.assess, MECHANISMS[name](), budget=1e6, progress=False)
    driven(call, partial(in_memory, 1), show)
    kind = {0.0: "no period", 1.0: "period 1"}.get(periods[0], "longer period")
    print(*(f"{each:.1f}" for each in times), kind, sep="\t")


def main():
    """Measure the asked mechanisms and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=[*MECHANISMS], metavar="NAME")
    parser.add_argument("--cold", action="store_true")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        one(*given.names)
        return
    print("|", " | ".join(("mechanism", "its motion", *PARTS, "edges wanted")), "|")
    print("|", " | ".join(["---"] * 7), "|", flush=True)
    for name in given.names:
        with tempfile.TemporaryDirectory() as folder:
            env = os.environ | {"OMP_NUM_THREADS": "1"} | ({"JOINTPLAY_CACHE": folder} if given.cold else {})
            again = [sys.executable, "-m", __spec__.name, name, "--one"]
            for _ in range(1 if given.cold else 2):
                done = subprocess.run(again, env=env, check=True, capture_output=True, text=True)
        *times, kind = done.stdout.strip().split("\t")
        print("|", " | ".join([name, kind, *times, str(EDGES[kind])]), "|", flush=True)
    print("|", " | ".join(["wanted", "", *map(str, WANTED), "", ""]), "|")


if __name__ == "__main__":
    main()
