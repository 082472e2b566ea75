"""One quantity out of many, by word and label: ``normal_force``, ``angle:rocker``, ``y``."""

from __future__ import annotations

from typing import Any

import xarray as xr

from jointplay.analysis.quantities import WORDS, recorded
from jointplay.errors import InputError, Problem, unknown
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism, TestSystem

MOVED = 0.9  # of the progress, when a motion has been followed and is to be looked at

STATE = "state_value"


def observable(mechanism: Mechanism | TestSystem, quantity: Any, key: str = "quantity") -> tuple[str, str]:
    """Word of a dataset and label of a quantity; the label is empty where there is none.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Whose quantity it is.
    quantity : str
        A word of a dataset, and after a colon the link or joint; the first one if left out. Of a test
        system, the name of a state.
    key : str
        Where it was asked for.

    Raises
    ------
    InputError
        If there is no such quantity here.
    """
    if not isinstance(mechanism, Mechanism | TestSystem):
        accepted = "a Mechanism or TestSystem is accepted, such as catalog.chunmei2002()"
        raise InputError([Problem("mechanism", mechanism, accepted)])
    if not isinstance(quantity, str):
        raise InputError([Problem(key, quantity, "the name of a quantity is accepted")])
    if isinstance(mechanism, TestSystem):
        return STATE, _known(quantity, assemble(mechanism).states, key, "state")
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
    links, joints = mechanism.links, mechanism.joints
    return {
        "link": tuple(link.name for link in links),
        "bending": tuple(link.name for link in links),
        "joint": tuple(joint.name for joint in joints if joint.clearance > 0),
        "pin": tuple(joint.name for joint in joints if not joint.clearance),
    }.get(of or "", ())


def _known(name: str, names: tuple[str, ...], key: str, what: str) -> str:
    if name not in names:
        raise InputError([unknown(key, name, name, names, what)])
    return name


def usual(mechanism: Mechanism | TestSystem, word: str) -> str:
    """The quantity looked at where none is named: `word` of the first joint with clearance, or a state."""
    if isinstance(mechanism, TestSystem):
        return assemble(mechanism).states[0]
    return word if getattr(mechanism, "clearance_joints", ()) else "drive_torque"


def series(dataset: xr.Dataset, word: str, label: str) -> xr.DataArray:
    """The values of a quantity in a result, over time or turns alone; its long name says of what."""
    array = dataset[word]
    for dim in [dim for dim in array.dims if dim not in ("time", "turn")]:
        array = array.sel({dim: label}, drop=True)
    words = [array.attrs["long_name"], label] if label else [array.attrs["long_name"]]
    return array.assign_attrs(long_name=(" " if word == STATE else ", ").join(words))


def squared(units: str) -> str:
    """Units of a square."""
    return "1" if units == "1" else f"{units}2" if units.isalpha() else f"({units})2"


def described(table: dict[str, tuple[Any, Any, str, str]]) -> dict[str, Any]:
    """Variables from dimensions, values, units and long names."""
    return {key: (dims, v, {"units": u, "long_name": text}) for key, (dims, v, u, text) in table.items()}


def ended(dataset: xr.Dataset) -> xr.Dataset:
    """What a result says of its run: status, times and counters, nothing else."""
    return dataset[[name for name in _RUN if name in dataset]]


_RUN = ("status", "wall_time", "turn_period_nominal", "n_steps", "n_rejected", "n_failed", "n_evaluations")
_RUN += ("n_events",)
