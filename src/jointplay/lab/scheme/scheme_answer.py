"""Answer of a comparison of the paper's scheme with the method used here."""

import numpy as np
import xarray as xr

from jointplay.display.number_text import plain


def scheme_answer(dataset: xr.Dataset) -> str:
    """Return in how many cases the scheme's passes settle, and the errors of both methods.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.scheme_comparison`.
    """
    settles = dataset["converged"].any("windows_per_turn").values
    errors = (np.nanmin(dataset[name].values) for name in ("scheme_error", "monolithic_error"))
    scheme, ours = (plain(float(error), 2) for error in errors)
    return (
        f"the scheme's passes settle in {np.count_nonzero(settles)} of {settles.size} cases\n"
        f"smallest error of a deflection: {scheme} by the scheme, {ours} with all unknowns at once"
    )
