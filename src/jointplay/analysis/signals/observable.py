"""One quantity out of many, by variable and label: ``normal_force``, ``angle:rocker``, ``y``."""

from __future__ import annotations

from jointplay.analysis.labels import xr
from jointplay.analysis.quantities import WORDS, recorded
from jointplay.display.errors import InputError, Problem, raise_any, strangers
from jointplay.solver.mechanism.records import Mechanism, TestSystem

MOVED = 0.9  # of the progress, when a motion has been followed and is to be evaluated
STATE = "state_value"


def chosen(mechanism: Mechanism | TestSystem, quantity: str | None, usual: str) -> tuple[str, str]:
    """The `observable`; if none is named, `usual` of the first joint with clearance, or the first state."""
    if quantity is None and isinstance(mechanism, TestSystem):
        return STATE, mechanism.observed[0]
    if quantity is None:
        quantity = usual if mechanism.clearance_joints else "drive_torque"
    return observable(mechanism, quantity)


def observable(mechanism: Mechanism | TestSystem, quantity: str, key: str = "quantity") -> tuple[str, str]:
    """Variable of a dataset and label of a quantity; the label is empty where there is none.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Whose quantity it is.
    quantity : str
        A variable of a dataset, and after a colon the link or joint; the first one if left out. Of a test
        system, the name of a state.
    key : str
        Where it was asked for.

    Raises
    ------
    InputError
        If there is no such quantity here.
    """
    if isinstance(mechanism, TestSystem):
        return STATE, _known(quantity, mechanism.observed, key, "state")
    word, _, label = quantity.partition(":")
    try:
        recorded((word,), mechanism)
    except InputError as error:
        raise InputError([Problem(key, quantity, problem.expected) for problem in error.problems]) from None
    labels = _labels(mechanism, WORDS[word].of)
    if not labels or not label:
        if label:
            raise InputError([Problem(key, quantity, f"{word} alone is accepted: there is only one")])
        return word, labels[0] if labels else ""
    return word, _known(label, labels, key, f"part that {word} is of")


def _labels(mechanism: Mechanism, of: str | None) -> tuple[str, ...]:
    if of in ("link", "bending"):
        return tuple(link.name for link in mechanism.links)
    if of in ("guide", "joint"):
        return mechanism.guides if of == "guide" else mechanism.contacts
    return tuple(joint.name for joint in mechanism.joints if joint.ideal and of in ("pin", "guided"))


def _known(name: str, names: tuple[str, ...], key: str, what: str) -> str:
    raise_any(strangers([(key, name)], names, what))
    return name


def series(dataset: xr.Dataset, word: str, label: str) -> xr.DataArray:
    """The values of a quantity in a result, over time or turns alone; its long name holds the label."""
    array = dataset[word]
    for dim in [dim for dim in array.dims if dim not in ("time", "turn")]:
        array = array.sel({dim: label}, drop=True)
    words = [array.attrs["long_name"], label] if label else [array.attrs["long_name"]]
    return array.assign_attrs(long_name=(" " if word == STATE else ", ").join(words))


def named(array: xr.DataArray) -> dict[str, str]:
    """Name and units of a quantity, as declared outputs are said to be of it."""
    units = array.attrs["units"]
    squared = "1" if units == "1" else f"{units}2" if units.isalpha() else f"({units})2"
    return {"name": array.attrs["long_name"], "units": units, "squared": squared}


def too_few(result: xr.Dataset, count: int, more: str = "") -> str:
    """Remark on too few samples: their number and the number needed; empty where there are enough."""
    least = int(result.get("n_least", 0))
    return f": {count} samples{more}, at least {least} are needed" if count < least else ""
