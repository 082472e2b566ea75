"""Existence of derivatives, and names of quantities and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.analysis.gradients import selection
from jointplay.analysis.labels import Out
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, TestSystem

WHY = {  # there is no derivative, or hardly one
    "ok": "",
    "grazing": "a contact begins, or a guard is met, at almost no speed",
    "simultaneous_events": "two contacts change at the same instant, and neighbouring motions exchange them",
    "nearly_touching": "a gap almost closes in flight, and neighbouring motions touch there",
    "equal_multipliers": "two multipliers are equal, and they part as a square root does",
    "neutral": "the orbit has a multiplier of 1, and lies in a family of orbits",
    "one_sided": "the motion starts where a contact, wall or switch changes: neighbours differ by side",
    "sensitive": "runs at two tolerances differ by more than a tenth: neighbouring motions part too fast",
    "no_motion": "the motion did not reach its end",
}
VERDICTS = tuple(WHY)
GRAZING, TOGETHER, TOUCHING = 1e-6, 1e-9, 1e-6  # up to which there is hardly a derivative
SENSITIVE, NOTHING = 0.1, 1e-9  # relative error beyond which there is none; what counts as no value


def sensitive(values: np.ndarray, present: np.ndarray, slopes: np.ndarray, error: np.ndarray) -> bool:
    """Whether an error is beyond `SENSITIVE` of its derivative, and of what it would change the value by."""
    with np.errstate(invalid="ignore"):
        beyond = error > SENSITIVE * np.abs(slopes)
        size = np.maximum(np.abs(values[:, None]), NOTHING)
        return bool(np.any(beyond & (error * np.abs(present) > SENSITIVE * size)))


def verdict(
    near: tuple[float, float, float], equal: bool = False, opened: bool = False, parting: bool = False
) -> int:
    """Code of whether there is a derivative: 0, `ok`, if so."""
    if np.isnan(near[0]):
        return len(VERDICTS) - 1
    limits = (GRAZING, TOGETHER, TOUCHING)
    close = (i for i, (v, limit) in enumerate(zip(near, limits, strict=True), 1) if v < limit)
    usual = "one_sided" if opened else "equal_multipliers" if equal else "sensitive" if parting else "ok"
    return next(close, VERDICTS.index(usual))


IN_QUANTITY, IN_PARAMETER = "in the units of quantity_units", "in the units of parameter_units"
LABELS = {
    "quantity": Out("quantity", "quantity", ""),
    "quantity_name": Out("quantity", "the quantity", ""),
    "quantity_units": Out("quantity", "units of the quantity", ""),
    "parameter": Out("parameter", "parameter", ""),
    "parameter_name": Out("parameter", "the parameter", ""),
    "parameter_units": Out("parameter", "units of the parameter", ""),
}


def labels(quantities: list, keys: tuple[str, ...], mechanism: Mechanism | TestSystem) -> dict[str, Any]:
    """Values of `LABELS`: names and units of quantities and parameters."""
    named = [
        (f"start of {key.removeprefix(selection.INITIAL).replace('_', ' ')}", "1")
        if key.startswith(selection.INITIAL)
        else (Parameter(mechanism, key).noun, Parameter(mechanism, key).cf_units)
        for key in keys
    ]
    words = [(each.noun, each.units) for each in quantities]
    return columns("quantity", [each.name for each in quantities], words) | columns("parameter", keys, named)


def columns(dim: str, keys: Sequence[str], words: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """Keys along a dimension, with their nouns and units."""
    nouns, units = [noun for noun, _ in words], [each for _, each in words]
    found = {dim: list(keys), f"{dim}_name": nouns, f"{dim}_units": units}
    return {name: np.array(texts, dtype=str) for name, texts in found.items()}
