"""Sweeps of cells that take milliseconds, and how to compare what came of them."""

import os
import signal
from contextlib import suppress
from pathlib import Path

from jointplay.jobs import worker
from jointplay.jobs.pool import Pool
from jointplay.study.execute import complete
from jointplay.study.file import Loaded, validate
from jointplay.study.toml_text import override, parse

CELLS = """\
kind = "lyapunov"
name = "cells"

[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8

[vary]
gap = { start = 2.9, stop = 3.1, num = 3 }
restitution = [0.7, 0.8]

[analysis]
turns = 5
"""
CHAINS = """\
kind = "bifurcation"
name = "chains"

[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8

[vary]
gap = [2.95, 3.0, 3.05, 3.1]

[analysis]
turns = 8
transient = 5
direction = ["up", "down", "reset"]
"""
PLANE = """\
kind = "basins"
name = "plane"

[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8

[analysis]
plane.y = { start = -1.0, stop = 1.0, num = 6 }
plane.v = { start = -1.0, stop = 1.0, num = 5 }
transient = 5
turns = 4
patience = 1
tolerance = 1e-3
"""
_PAIR = """\
kind = "{0}"
name = "{0}"

[mechanism]
catalog = "impact_pair"
gap = 3.6
restitution = 0.8

"""
_VARIED = (
    _PAIR
    + """\
[vary]
gap = {{ start = 3.4, stop = 3.8, num = 3 }}

[analysis]
"""
)
_REGION = """\
region.y = [-1.6, 1.6]
region.v = [-3.0, 3.0]
turns = 16
transient = 60
"""
SYMMETRIC = """\
initial = [-0.35, 0.77]
transient = 60
"""
KINDS = {  # analyses whose motions are found one after the other, or follow from each other
    "gradient": _VARIED.format("gradient") + """\
of = ["end:state:y", "multiplier_modulus:1"]
by = ["gap", "restitution"]
orbit = true
""" + SYMMETRIC,
    "optimise": _VARIED.format("optimise") + """\
by.restitution = [0.7, 0.9]
least = "multiplier_modulus:1"
neighbourhood = 0.1
""" + SYMMETRIC,
    "curve": _VARIED.format("curve") + """\
plane = { gap = [2.5, 6.0], restitution = [0.7, 0.9] }
of = ["symmetry_breaking"]
step = 0.1
""" + SYMMETRIC,
    "covariant": _VARIED.format("covariant") + """\
turns = 20
settling = 5
""",
    "attractors": _VARIED.format("attractors") + _REGION + """\
starts = 10
lyapunov_turns = 10
""",
    "tolerances": _PAIR.format("tolerances") + """\
[tolerances]
gap = { normal = [3.6, 0.05] }
restitution = { uniform = [0.75, 0.85] }
[analysis]
samples = 20
shares = 4
transient = 10
turns = 12
lyapunov_turns = 10
limits = { "largest:state:v" = 1.5 }
edge = { "largest:state:v" = "gap" }
edge_runs = 8
""",
    "tipping": _PAIR.format("tipping") + "[analysis]\n" + _REGION + """\
starts = 20
phases = 2
steps = 6
""",
}  # fmt: skip
SLOW = ("curve", "optimise", "tipping")  # seconds each
TIMES = ("wall_time",)


def loaded(text, *changes):
    return Loaded(validate(override(parse(text), changes)), text)


def ran(study, out, jobs=1, backend="loky", **options):
    """The dataset of a run."""
    Path(out).mkdir(exist_ok=True)
    return complete(study, Path(out), Pool(jobs, backend), **options).dataset


def same(one, other):
    """Bit for bit the same but for times."""
    drop = [name for name in TIMES if name in one]
    return one.drop_vars(drop).identical(other.drop_vars(drop))


def forked(act):
    """Run something in a copy of this process; how that ended."""
    child = os.fork()
    if not child:
        with suppress(BaseException):
            act()
            os._exit(0)
        os._exit(1)
    return os.waitpid(child, 0)[1]


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def killed_after(parts, act):
    """Run something in a copy of this process, which dies when so many parts of a journal are written."""
    written, write_part = [], worker.write_part

    def fatal(*given):
        write_part(*given)
        written.append(1)
        if len(written) == parts:
            die()

    def counted():  # in the copy alone
        worker.write_part = fatal
        act()

    return forked(counted)


def bare(dataset):
    """A copy without attributes."""
    copy = dataset.copy()
    copy.attrs = {}
    for variable in copy.variables.values():
        variable.attrs = {}
    return copy
