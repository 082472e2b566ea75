"""What the harness of a sweep costs beside its cells.

    python -m tests.benchmarks.harness [overhead | efficiency | many | memory] ...

`overhead`: of cells of about 50 ms, the time that is not spent in changed mechanisms and their analysis, in
one process.
`efficiency`: of two workers against one, the pool's start told apart; runs alternate.
`many`: 100 000 cells that compute nothing, planned, journaled and put together, in a process of their own.
`memory`: the most that processes hold, over transient turns and over cells (Linux).
Medians, with the least and the most. Wall times show what else the machine does, CPU times hardly.
"""

import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple
from unittest.mock import patch

from jointplay.analysis.cells import in_memory
from jointplay.analysis.sweeps import gather
from jointplay.jobs.pool import Pool
from jointplay.study import run
from jointplay.study.execute import complete
from jointplay.study.file import Loaded, load, validate
from jointplay.study.toml_text import parse

LINKAGE = """\
name = "harness"
kind = "section"
[mechanism]
catalog = "chunmei2002"
[integrator]
rtol = 1e-7
ensemble = false  # cells in lanes share their time: none has a share of its own
[analysis]
turns = {turns}
transient = 20
[vary]
"joints.B.clearance" = {{ start = 2.9e-5, stop = 6e-5, num = {n} }}
"""
IMPACTS = """\
name = "harness"
kind = "section"
[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.7
[analysis]
turns = 5
transient = {transient}
[vary]
gap = {{ start = 2.9, stop = 3.1, num = {n} }}
"""
CELL, AGAIN = 0.05, 5  # s that a cell is to take, and runs of each kind


class Run(NamedTuple):
    """Seconds of a run; `inside`: in the analysis, as far as this process did it; `cpu`: of this process."""

    wall: float
    cpu: float
    inside: float
    inside_cpu: float
    solver: float  # in the solver, of all cells in all processes


def linkage(n):
    """A study of n cells of about `CELL`; one has run."""
    probe = _study(LINKAGE.format(turns=100, n=4))
    _run(probe, 1)
    each = _run(probe, 1).inside_cpu / 4
    return _study(LINKAGE.format(turns=max(1, round(120 * CELL / each) - 20), n=n))


def _study(text):
    return Loaded(validate(parse(text)), text)


def _run(study, jobs):
    inside, answering = [0.0, 0.0], [False]

    def timed(function, *given, **named):
        began = _clocks()
        try:
            return function(*given, **named)
        finally:
            if answering[0]:
                inside[:] = [sum(pair) for pair in zip(inside, _since(began), strict=True)]

    def answer(own, record, changes):
        answering[0] = True
        found = own(record, changes)
        answering[0] = False
        return found

    with ExitStack() as patched:
        out = patched.enter_context(tempfile.TemporaryDirectory())
        if jobs == 1:  # workers have their own copy
            patched.enter_context(patch.object(run, "answer", partial(answer, run.answer)))
            patched.enter_context(patch.object(run, "computed", partial(timed, run.computed)))
            patched.enter_context(patch.object(run, "changed", partial(timed, run.changed)))
        began = _clocks()
        found = complete(study, Path(out), Pool(jobs)).dataset
        return Run(*_since(began), *inside, float(found["wall_time"].sum()))


def _clocks():
    return time.perf_counter(), time.process_time()


def _since(began):
    return [now - then for now, then in zip(_clocks(), began, strict=True)]


def overhead(n=400):
    """What is not spent in the analysis, over what is, in one process."""
    study = linkage(n)
    runs = [_run(study, 1) for _ in range(AGAIN)]
    of_cpu = [run.cpu / run.inside_cpu - 1 for run in runs]
    of_wall = [run.wall / run.inside - 1 for run in runs]
    cell = median(run.inside_cpu for run in runs) / n * 1e3
    print(
        f"overhead    {n} cells of {cell:.0f} ms, {AGAIN} runs: {_spread(of_cpu, '.2%')} of CPU time, ",
        end="",
    )
    print(f"{_spread(of_wall, '.2%')} of wall time")


def efficiency(n=200):
    """Of two workers against one, and the share of the two workers' time that is spent in analyses."""
    study = linkage(n)
    start = _run(study, 2).wall
    pairs = [(_run(study, 1), _run(study, 2)) for _ in range(AGAIN)]
    each = [one.wall / two.wall / 2 for one, two in pairs]
    busy = [two.solver * one.inside / one.solver / two.wall / 2 for one, two in pairs]
    walls = [median(run.wall for run in runs) for runs in zip(*pairs, strict=True)]
    print(
        f"efficiency  {n} cells, {AGAIN} runs: {_spread(each, '.3f')}; two workers are in analyses for ",
        end="",
    )
    print(
        f"{_spread(busy, '.3f')} of their time; {walls[0]:.2f} s with one, {walls[1]:.2f} s with two, ",
        end="",
    )
    print(f"and once {start - walls[1]:.1f} s to start them")


def _spread(values, form):
    return f"{median(values):{form}} ({min(values):{form}} to {max(values):{form}})"


def many(n=100_000):
    """Cells that compute nothing."""
    subprocess.run([sys.executable, "-m", __spec__.name, "_many", str(n)], check=True)


def _many(n):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "harness.toml"
        path.write_text(IMPACTS.format(transient=0, n=n))
        began = time.perf_counter()
        study = load(path)
        read = time.perf_counter() - began
        before, one = _held(), _one(study.record)
        with patch.object(run, "answer", partial(_nothing, one)):
            began = _clocks()
            found = complete(study, Path(folder), Pool(1)).dataset
            wall, cpu = _since(began)
        print(f"many        {n} empty cells of {len(one.variables)} variables: {read:.1f} s to read ", end="")
        print(f"the study, {wall:.1f} s to run it, {cpu:.1f} s of CPU time; {_held():.0f} MB, ", end="")
        print(f"{before:.0f} MB before; the result holds {found.nbytes / 1e6:.0f} MB")


def _one(record):
    return run.computed(record.model_copy(update={"vary": {}}), partial(in_memory, 1))


def _nothing(dataset, record, changes):
    """What a cell answers, without an analysis."""
    answer = gather.plain(dataset)
    return {"status": 0, "dataset": answer._replace(values=[value.copy() for value in answer.values])}


def memory():
    """The most that the main process and a worker hold."""
    for transient, n in ((100, 2), (100_000, 2), (0, 20), (0, 200), (0, 2000)):
        subprocess.run([sys.executable, "-m", __spec__.name, "_memory", str(transient), str(n)], check=True)


def _memory(transient, n):
    study = _study(IMPACTS.format(transient=transient, n=n))
    with tempfile.TemporaryDirectory() as out:
        complete(study, Path(out), Pool(2))
    print(f"memory      {transient:>6} transient turns, {n:>4} cells: {_held():.0f} MB, ", end="")
    print(f"the largest worker {max(map(_held, _children())):.0f} MB")


def _children():
    process = os.getpid()
    return Path(f"/proc/{process}/task/{process}/children").read_text().split()


def _held(process="self"):
    """The most that a process has held so far, MB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3


def main(words):
    """Run what is named, or all."""
    if words and words[0].startswith("_"):
        {"_many": _many, "_memory": _memory}[words[0]](*map(int, words[1:]))
        return
    for each in words or ("overhead", "efficiency", "many", "memory"):
        {"overhead": overhead, "efficiency": efficiency, "many": many, "memory": memory}[each]()


if __name__ == "__main__":
    main(sys.argv[1:])
