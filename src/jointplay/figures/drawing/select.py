"""Selection of a figure's content from a dataset, with errors that name the valid choices."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from numbers import Real

import numpy as np

from jointplay.display import codes
from jointplay.display.errors import InputError, Problem, unknown
from jointplay.figures.drawing import DataArray, Dataset


def refuse(option: str, given, expected: str) -> InputError:
    """Return the error for one wrong figure option."""
    return InputError([Problem(f"figure.{option}", given, expected)])


def choice(option: str, given, known: Iterable[str], what: str = "") -> str:
    """Return `given` where it is one of `known`."""
    known = list(known)
    if not isinstance(given, str) or given not in known:
        raise InputError([unknown(f"figure.{option}", given, given, known, what or option)])
    return given


def labels(dataset: Dataset, dim: str) -> list[str]:
    """Return the labels along `dim`; none where the dataset has no such dimension."""
    return [str(label) for label in dataset[dim].values] if dim in dataset.coords else []


def switch(option: str, given) -> bool:
    """Return `given` where it is true or false."""
    if not isinstance(given, bool):
        raise refuse(option, given, "true or false")
    return given


def leading(option: str, given) -> int | None:
    """Return the number of leading entries to draw; None where it is left open."""
    if given is not None and not (isinstance(given, int) and not isinstance(given, bool) and given >= 1):
        raise refuse(option, given, "a whole number, 1 or more")
    return given


def require(dataset: Dataset, figure: str, names: Iterable[str], expected: str = "") -> None:
    """Refuse a dataset without the variables or dimensions `names`: it is of another kind of study."""
    if not {*dataset.variables, *dataset.dims}.issuperset(names):
        raise refuse("kind", figure, expected or f"a result of a study of kind {figure}")


def label(dataset: Dataset, dim: str, given: str | None) -> str:
    """Return `given` where it is a label of `dim`, the first label where it is None."""
    known = labels(dataset, dim)
    if given is None and known:
        return known[0]
    return choice(dim, given, known)


def names(dataset: Dataset, dim: str) -> list[str]:
    """Return the names that can be drawn over `dim`: numeric variables, then labels of a system's states."""
    drawn = [
        name for name, array in dataset.data_vars.items() if dim in array.dims and array.dtype.kind in "fiu"
    ]
    found = [str(name).removeprefix("section_") if dim == "turn" else str(name) for name in drawn]
    return found + (labels(dataset, "state") if "state_value" in found else [])


def variable(dataset: Dataset, name: str, option: str = "variables", dim: str = "time") -> DataArray:
    """Return the variable `name`, or the state of a test system that is labelled so, over `dim`.

    A section kept inside a response has its variables under `section_` names: both names are understood.
    """
    for stored in (name, f"section_{name}") if dim == "turn" else (name,):
        if isinstance(stored, str) and stored in dataset.data_vars and dim in dataset[stored].dims:
            return dataset[stored]
    states = "section_state_value" if dim == "turn" and "section_state_value" in dataset else "state_value"
    if states in dataset and dim in dataset[states].dims and name in labels(dataset, "state"):
        return dataset[states].sel(state=name).assign_attrs(long_name=f"state {name}")
    raise InputError([unknown(f"figure.{option}", name, name, names(dataset, dim), "variable")])


def curve(dataset: Dataset, name: str, option: str, dim: str = "time", **labelled: str | None) -> DataArray:
    """Return `name` along `dim` alone, as by `labelled_slice`."""
    return labelled_slice(variable(dataset, name, option, dim), dataset, (dim,), **labelled)


def labelled_slice(
    array: DataArray, dataset: Dataset, along: Collection, **labelled: str | None
) -> DataArray:
    """Return an array along some dimensions alone, at the given (or first) label of each other one.

    Its `long_name` says which label that is wherever there was a choice.
    """
    for dim in [d for d in array.dims if d not in along]:
        chosen, several = label(dataset, str(dim), labelled.get(str(dim))), array.sizes[dim] > 1
        array = array.sel({dim: chosen})
        if several:
            array = array.assign_attrs(long_name=f"{title(array)}, {codes.contact(chosen)}")
    return array


def title(array: DataArray) -> str:
    """Return the name of `array` on an axis."""
    words = array.attrs.get("long_name") or str(array.name).replace("_", " ")
    return words[:1].upper() + words[1:]


def in_contact(dataset: Dataset, joint: str) -> np.ndarray | None:
    """Booleans over time, true where the journal feels the bearing; None where modes are not recorded.

    `free` and `released` carry no force, all other modes do.
    """
    if "mode" not in dataset or "time" not in dataset["mode"].dims:
        return None
    return ~np.isin(codes.words(dataset["mode"].sel(joint=joint)).values, ("free", "released"))


def unseen(dataset: Dataset, joint: str | None, contact: np.ndarray | None) -> str:
    """Say how many contacts of a joint a path does not show, since they begin and end between two samples."""
    if contact is None or "event_kind" not in dataset:
        return ""
    begun = np.isin(codes.words(dataset["event_kind"]).values, ("contact", "impact"))
    begun &= codes.words(dataset["event_joint"]).values == joint
    after = np.searchsorted(dataset["time"].values, dataset["event_time"].values[begun])
    after = after[(after > 0) & (after < contact.size)]
    count = int(np.sum(~contact[after] & ~contact[after - 1]))
    return f"{count} contact{'s' * (count > 1)} between samples not drawn" if count else ""


def is_number(given) -> bool:
    """Return whether an option is a finite number, however large."""
    return isinstance(given, Real) and not isinstance(given, bool) and -np.inf < given < np.inf


def numbers(option: str, given, count: int, expected: str) -> tuple[float, ...]:
    """Return `given` as `count` increasing numbers."""
    items = list(given) if isinstance(given, list | tuple) else [given]
    if len(items) != count or not all(map(is_number, items)) or any(np.diff(items) <= 0):
        raise refuse(option, given, expected)
    return tuple(map(float, items))
