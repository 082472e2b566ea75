"""Datasets of `gradient`: values and derivatives, and whether there are any."""

from __future__ import annotations

from typing import Any

import numpy as np

from jointplay.analysis.gradients import wanted
from jointplay.analysis.labels import labelled, number
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, TestSystem

WHY = {  # there is no derivative, or hardly one
    "ok": "",
    "grazing": "a contact begins, or a guard is met, with next to no speed",
    "simultaneous_events": "two contacts change at one instant, in an order that neighbours exchange",
    "nearly_touching": "a gap is all but closed in flight, and neighbouring motions touch there",
    "equal_multipliers": "a multiplier is equal to another one, and both part as a root",
    "one_sided": "the body starts at rest on a wall, and neighbours start away from it or inside it",
    "no_motion": "the motion did not get to its end",
}
VERDICTS = tuple(WHY)
GRAZING, TOGETHER, TOUCHING = 1e-6, 1e-9, 1e-6  # up to which there is hardly a derivative


def verdict(near: tuple[float, float, float], equal: bool = False, opened: bool = False) -> int:
    """Code of whether there is a derivative: 0, `ok`, if so."""
    if np.isnan(near[0]):
        return len(VERDICTS) - 1
    limits = (GRAZING, TOGETHER, TOUCHING)
    close = (i for i, (v, limit) in enumerate(zip(near, limits, strict=True), 1) if v < limit)
    usual = "one_sided" if opened else "equal_multipliers" if equal else "ok"
    return next(close, VERDICTS.index(usual))


def variables(
    values: np.ndarray, slopes: np.ndarray, error: np.ndarray, present: np.ndarray
) -> dict[str, Any]:
    """Values, derivatives, their errors and relative sensitivities, at present values of parameters."""
    both, units = ("quantity", "parameter"), "in the units of quantity_units"
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = slopes * present / values[:, None]
    return {
        "value": number("quantity", values, "1", f"value, {units}"),
        "derivative": number(both, slopes, "1", f"derivative, {units} over parameter_units"),
        "error": number(both, error, "1", f"error of the derivative, {units} over parameter_units"),
        "relative_sensitivity": number(both, relative, "1", "relative change over that of the parameter"),
        "parameter_value": number("parameter", present, "1", "value, in the units of parameter_units"),
    }


def nearness(near: tuple[float, float, float]) -> dict[str, Any]:
    """Nearness of the motion to places where derivatives end, as `evaluated.nearness` gives it."""
    words = {
        "grazing": "slowest event: of a guard relative to its terms, of a gap to the fastest",
        "nearest_events": "shortest time between events of two contacts, over the period",
        "closest_approach": "smallest gap left in flight, over the clearance",
    }
    return labelled({name: (v, "1", text) for (name, text), v in zip(words.items(), near, strict=True)})


def of_orbit(state: np.ndarray, moves: np.ndarray) -> dict[str, Any]:
    """Starting state of an orbit, and its derivatives in each parameter (a row each)."""
    units = "in rad, m and their rates, or a system's own units"
    return {
        "orbit_state": number("state", state, "1", f"state where the orbit starts, {units}"),
        "orbit_state_derivative": number(
            ("state", "parameter"), moves.T, "1", f"derivative of that state, {units}, over parameter_units"
        ),
    }


def labels(quantities: list, keys: tuple[str, ...], mechanism: Mechanism | TestSystem) -> dict[str, Any]:
    """Names and units of quantities and parameters."""

    def named(dim: str, texts: list[str], text: str) -> tuple:
        return dim, np.array(texts), {"long_name": text}

    units = ["1" if key.startswith(wanted.INITIAL) else Parameter(mechanism, key).cf_units for key in keys]
    return {
        "quantity": named("quantity", [each.name for each in quantities], "quantity"),
        "quantity_units": named("quantity", [each.units for each in quantities], "units of the quantity"),
        "parameter": named("parameter", list(keys), "parameter"),
        "parameter_units": named("parameter", units, "units of the parameter"),
    }
