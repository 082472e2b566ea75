"""Run a study: from its record to a dataset that knows where it comes from."""

from collections.abc import Callable
from inspect import signature
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

from jointplay.analysis.exponents.lyapunov import lyapunov
from jointplay.analysis.orbits.continuation import continuation
from jointplay.analysis.orbits.periodic_orbit import periodic_orbit
from jointplay.analysis.paper.claims import claims
from jointplay.analysis.paper.readings import readings
from jointplay.analysis.poincare import poincare
from jointplay.analysis.precision.work_precision import work_precision
from jointplay.analysis.scheme.scheme_comparison import scheme_comparison
from jointplay.analysis.signals.chaos_test import chaos_test
from jointplay.analysis.signals.dimension import dimension
from jointplay.analysis.signals.spectrum import spectrum
from jointplay.analysis.simulate import simulate
from jointplay.analysis.states.basins import basins
from jointplay.analysis.states.sensitivity import sensitivity
from jointplay.analysis.stress.stress import stress
from jointplay.analysis.sweeps.bifurcation import bifurcation
from jointplay.errors import InputError, Problem
from jointplay.study import provenance
from jointplay.study.file import Loaded
from jointplay.study.kinds import Study

ANALYSES: dict[str, Callable[..., xr.Dataset]] = {
    "response": simulate,
    "section": poincare,
    "readings": readings,
    "claims": claims,
    "scheme_comparison": scheme_comparison,
    "bifurcation": bifurcation,
    "lyapunov": lyapunov,
    "chaos_test": chaos_test,
    "spectrum": spectrum,
    "dimension": dimension,
    "sensitivity": sensitivity,
    "basins": basins,
    "periodic_orbit": periodic_orbit,
    "continuation": continuation,
    "stress": stress,
    "work_precision": work_precision,
}


def run(
    study: Loaded, progress: Callable[[float], None] | None = None, jobs: int | None = None
) -> xr.Dataset:
    """Compute what a study asks for.

    Parameters
    ----------
    study : Loaded
        From `jointplay.study.file.load`.
    progress : callable, optional
        Called with the fraction done, 0 to 1.
    jobs : int, optional
        Worker processes, for the kinds of study that have cells.

    Returns
    -------
    xarray.Dataset
        With the attributes ``study`` (its name), ``title``, ``source`` and ``provenance``. A numerical
        failure is in its ``status``.

    Raises
    ------
    jointplay.errors.InputError
        When the number of jobs is wrong.
    """
    check_jobs(jobs)
    if study.record.vary and study.record.kind != "bifurcation":
        from jointplay.study.execute import execute  # it needs this file
        from jointplay.study.pool import Pool

        with TemporaryDirectory(prefix="jointplay-") as folder:
            return execute(study, Path(folder), Pool(jobs or 1), progress).dataset
    return named(study, analysed(study.record, progress, jobs))


def analysed(
    record: Study, progress: Callable[[float], None] | None = None, jobs: int | None = None
) -> xr.Dataset:
    """Compute what one mechanism answers, whatever varies."""
    more = {"n_jobs": jobs} if takes_jobs(record.kind) else {}
    return ANALYSES[record.kind](record.mechanism, **record.keywords(), **more, progress=progress)


def takes_jobs(kind: str) -> bool:
    """Whether the analysis of a kind of study runs cells side by side."""
    return "n_jobs" in signature(ANALYSES[kind]).parameters


def named(study: Loaded, dataset: xr.Dataset) -> xr.Dataset:
    """Give a copy that says which study it answers, and where it comes from."""
    record = study.record
    titled = dataset.assign_attrs(study=record.name, title=record.heading)
    return provenance.attach(titled, record.model_dump(mode="json"), study.text)


def check_jobs(jobs: int | None) -> None:
    """Refuse a number of worker processes that there cannot be.

    Raises
    ------
    jointplay.errors.InputError
        As it says.
    """
    if jobs is not None and jobs < 1:
        accepted = "a whole number of worker processes, 1 or more, is accepted"
        raise InputError([Problem("--jobs", jobs, accepted)])
