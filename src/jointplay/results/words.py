"""Results with words where codes stand."""

from __future__ import annotations

from typing import Annotated

import xarray as xr

from jointplay.display import codes
from jointplay.mechanism.base import accepts
from jointplay.mechanism.signature import checked


@checked()
def words(dataset: Annotated[xr.Dataset, accepts("a result")]) -> xr.Dataset:
    """Give a copy of a result with words in place of all codes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result. Files keep codes, with their words in ``flag_meanings``.

    Returns
    -------
    xarray.Dataset
        With ``status``, ``verdict``, ``stable``, ``branch_end``, ``event_kind``, ``event_joint`` (the joint's
        name) and all others that have flags as texts.

    Raises
    ------
    InputError
        When something else is given.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.simulate(jp.catalog.impact_pair(3.6, 0.8), turns=1)  # doctest: +SKIP
    >>> jp.words(motion).status.item()  # doctest: +SKIP
    'ok'
    """
    return dataset.assign(
        {name: codes.words(dataset[name]) for name in dataset.variables if codes.coded(dataset[name])}
    )
