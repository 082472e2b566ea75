"""Optima of a forced linear oscillator, x'' + c x' + k x = cos w t."""

from __future__ import annotations

import jointplay as jp

FREQUENCY, DAMPING, AMPLITUDE = 1.2, 0.8, 0.5


def oscillator(stiffness: float) -> jp.System:
    """The oscillator."""
    return jp.System(
        name="forced",
        states={"x": 0.5, "v": 0.0},
        parameters={"k": stiffness, "c": DAMPING},
        rates={"x": "v", "v": f"cos({FREQUENCY}*t) - c*v - k*x"},
        forcing=f"2*pi/{FREQUENCY}",
    )


def _found(dataset) -> dict:
    numbers = ("optimum", "value", "confirmed_to", "neighbour_gain", "missed")
    told = {name: dataset[name].values.tolist() for name in numbers}
    told["end"] = dataset["end"].attrs["flag_meanings"].split()[int(dataset["end"])]
    return told | {"neighbours": dataset["neighbour_objective"].values.ravel().tolist()}


def all_found() -> dict:
    """Each optimisation by name."""
    name, run = "largest:state:x", {"transient": 12, "rtol": 1e-9}
    at_resonance, told = oscillator(FREQUENCY**2), []
    watched = run | {"progress": told.append}
    return {
        "resonance": _found(jp.optimise(oscillator(1.0), by={"k": (0.7, 2.5)}, most=name, **watched)),
        "progress": told,
        "damped": _found(
            jp.optimise(at_resonance, by={"c": (0.4, 3.0)}, subject={name: (0.0, AMPLITUDE)}, **run)
        ),
        "impossible": _found(
            jp.optimise(at_resonance, by={"c": (0.4, 1.0)}, subject={name: (0.0, AMPLITUDE)}, **run)
        ),
    }
