"""What a status means, in a sentence, and what to try."""

import numpy as np
import xarray as xr

SHOWN = 8  # cells named

MEANING = {
    "diverged": (
        "the motion grew without bound",
        "check the initial state, the masses and the contact stiffness; try a smaller integrator.rtol",
    ),
    "step_limit": (
        "the limit on the number of steps was reached",
        "raise integrator.max_steps, ask for fewer turns, or loosen integrator.rtol",
    ),
    "chatter": (
        "events followed each other too closely to be told apart",
        "try a smaller integrator.rtol, or give the contact more damping",
    ),
    "not_converged": (
        "a step could not be solved to the tolerance, however short",
        "loosen integrator.rtol; check that masses, inertias and stiffnesses are of a sensible size",
    ),
    "bad_parameters": (
        "these parameters give no finite accelerations at the start",
        "check masses, inertias, lengths and the initial state",
    ),
    "crashed": (
        "the computation stopped before it could answer",
        "run it again; please report it if it repeats",
    ),
    "not_run": ("nothing was computed", "run the study"),
}


def name_of(dataset: xr.Dataset) -> str:
    """The status of a result by name, such as ``ok`` or ``step_limit``."""
    status = dataset["status"]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    return names[int(status)]


def explain(dataset: xr.Dataset) -> str | None:
    """Say in a line what went wrong and what to try, with the cells in which; None when all is well."""
    name = name_of(dataset)
    if name == "ok":
        return None
    sentence, remedy = MEANING[name]
    cells = failed_cells(dataset)
    shown = ", ".join(cells[:SHOWN]) + (f" and {len(cells) - SHOWN} more" if len(cells) > SHOWN else "")
    return f"{name}: {sentence}; {remedy}" + (f" (in {shown})" if cells else "")


def failed_cells(dataset: xr.Dataset) -> list[str]:
    """Labels of the cells of a result whose own status is not ok, such as ``b no_tension``."""
    found = []
    for name in (name for name in dataset.data_vars if str(name).endswith("_status")):
        cells = dataset[name]
        for place in np.argwhere(cells.values != 0):
            labels = (cells[dim].values[i] for dim, i in zip(cells.dims, place, strict=True))
            found.append(" ".join(map(str, labels)))
    return found
