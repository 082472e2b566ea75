"""Many small computations side by side: in worker processes, with kernels compiled before the pool starts.

Who calls an analysis may have its cells run by something else, such as one that keeps what is finished.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Protocol

from joblib import Parallel, delayed

from jointplay.analysis.ensemble import follow_ensemble
from jointplay.analysis.run import Request, follow
from jointplay.analysis.words import STATUS
from jointplay.errors import InputError
from jointplay.mechanism.scene import Scene

JOBS = 2


class Runner(Protocol):
    """Runs cells in place of the pool."""

    def __call__(
        self,
        function: Callable[..., dict[str, Any]],
        cells: Sequence[dict[str, Any]],
        progress: Callable[[float], None] | None,
    ) -> list[dict[str, Any]]:
        """Give what `run_cells` gives."""


_runner: ContextVar[Runner | None] = ContextVar("runner", default=None)


@contextmanager
def cells_run_by(runner: Runner | None) -> Iterator[None]:
    """Have `run_cells` hand its cells to `runner` inside the block, in this thread; None: to its own pool."""
    token = _runner.set(runner)
    try:
        yield
    finally:
        _runner.reset(token)


def run_cells(
    function: Callable[..., dict[str, Any]],
    cells: Sequence[dict[str, Any]],
    n_jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[dict[str, Any]]:
    """Call a function once a cell, each time with the cell's keywords.

    Parameters
    ----------
    function : callable
        Gives back a dict with the key ``status``; importable by name, since workers are processes.
    cells : sequence of dict
        Keywords of the calls.
    n_jobs : int, optional
        Worker processes, `JOBS` if left out; 1: this process alone.
    progress : callable, optional
        Called with the fraction of cells done.

    Returns
    -------
    list of dict
        In the order of the cells. A cell that raised has only a ``status`` (``bad_parameters`` where its
        input was refused, ``crashed`` else) and ``trouble``, the error's text.
    """
    if (runner := _runner.get()) is not None:
        with cells_run_by(None):  # a cell that has cells of its own runs them where it is
            return runner(function, cells, progress)
    n_jobs = JOBS if n_jobs is None else n_jobs
    pool = Parallel(n_jobs=n_jobs, backend="loky" if n_jobs != 1 else "sequential", return_as="generator")
    found = []
    for answer in pool(delayed(guarded)(function, cell) for cell in cells):
        found.append(answer)
        if progress is not None:
            progress(len(found) / len(cells))
    return found


def guarded(function: Callable[..., dict[str, Any]], cell: dict[str, Any]) -> dict[str, Any]:
    """Call a function with a cell's keywords; an error becomes a ``status`` with ``trouble``, its text."""
    try:
        return function(**cell)
    except InputError as error:
        return {"status": STATUS.index("bad_parameters"), "trouble": str(error)}
    except Exception as error:
        return {"status": STATUS.index("crashed"), "trouble": f"{type(error).__name__}: {error}"}


def warm(scenes: Iterable[Scene], ensemble: bool = False) -> None:
    """Compile what these scenes need, once a structure, so that workers find it on the disk."""
    for scene in {scene.structure: scene for scene in scenes}.values():
        brief = Request(duration=1e-9 * scene.period, max_steps=1)
        if ensemble:
            follow_ensemble([scene], [brief])
        else:
            follow(scene, brief)
