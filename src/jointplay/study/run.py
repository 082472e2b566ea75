"""Run a study: from its record to a dataset that knows where it comes from."""

from collections.abc import Callable
from inspect import signature

import xarray as xr

from jointplay.analysis.claims import claims
from jointplay.analysis.poincare import poincare
from jointplay.analysis.readings import readings
from jointplay.analysis.scheme_comparison import scheme_comparison
from jointplay.analysis.simulate import simulate
from jointplay.study import provenance
from jointplay.study.file import Loaded

ANALYSES: dict[str, Callable[..., xr.Dataset]] = {
    "response": simulate,
    "section": poincare,
    "readings": readings,
    "claims": claims,
    "scheme_comparison": scheme_comparison,
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
    """
    record = study.record
    analysis, keywords = ANALYSES[record.kind], record.keywords()
    if "n_jobs" in signature(analysis).parameters:
        keywords["n_jobs"] = jobs
    dataset = analysis(record.mechanism, **keywords, progress=progress)
    named = dataset.assign_attrs(study=record.name, title=record.heading)
    return provenance.attach(named, record.model_dump(mode="json"), study.text)
