"""What the first run of a process costs."""

import os
import resource
import subprocess
import sys
import tempfile
from statistics import median

SIMULATE = "import jointplay as jp; jp.simulate(jp.catalog.chunmei2002(gear_ratio=3.0{}), turns=1)"
LANES = (
    "import jointplay as jp; jp.bifurcation(jp.catalog.chunmei2002(gear_ratio=3.0), direction='reset', "
    "over={'clearance': [2e-5, 3e-5]}, turns=1, transient=0, n_jobs=1, ensemble=True)"
)
FIRST = {
    "imports alone": "import jointplay as jp; jp.simulate",
    "rigid": SIMULATE.format(""),
    "elastic coupler": SIMULATE.format(", elastic=('coupler',), elements=2"),
    "an ensemble": LANES,
}


class Start:
    """A first run in a process of its own, CPU seconds; in `track_cold` with nothing compiled before."""

    params = (list(FIRST),)
    param_names = ("first run",)
    timeout = 1800

    def setup(self, name):
        _cpu(FIRST[name])  # compiles what never was

    def track_cold(self, name):
        with tempfile.TemporaryDirectory() as folder:
            return _cpu(FIRST[name], JOINTPLAY_CACHE=folder)

    track_cold.unit = "seconds"

    def track_warm(self, name):
        return median(_cpu(FIRST[name]) for _ in range(3))

    track_warm.unit = "seconds"

    def peakmem_first(self, name):
        exec(FIRST[name])


def _cpu(code, **changes):
    """CPU seconds of a Python process and what it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], env=os.environ | changes, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
