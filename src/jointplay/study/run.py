"""Run a study: from its record to a dataset that knows where it comes from."""

from collections.abc import Callable

import xarray as xr

from jointplay.analysis.poincare import poincare
from jointplay.analysis.simulate import simulate
from jointplay.study import provenance
from jointplay.study.file import Loaded

ANALYSES: dict[str, Callable[..., xr.Dataset]] = {"response": simulate, "section": poincare}


def run(study: Loaded, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Compute what a study asks for.

    Parameters
    ----------
    study : Loaded
        From `jointplay.study.file.load`.
    progress : callable, optional
        Called with the fraction done, 0 to 1.

    Returns
    -------
    xarray.Dataset
        With the attributes ``study`` (its name), ``title``, ``source`` and ``provenance``. A numerical
        failure is in its ``status``.
    """
    record = study.record
    dataset = ANALYSES[record.kind](record.mechanism, **record.keywords(), progress=progress)
    named = dataset.assign_attrs(study=record.name, title=record.heading)
    return provenance.attach(named, record.model_dump(mode="json"), study.text)
