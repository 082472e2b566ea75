"""Numbers that follow a slider: how everything that a run begins with depends on each parameter.

Assembling a mechanism is not written a second time in JavaScript. Instead each number that a parameter
changes gets a form (jointplay_page.script.forms), found from samples over the parameter's range, and each
number that several change a rule, verified where all have other values at once. A parameter of which
something has no such form gets no slider, nor does one whose forms do not go together with those before it.
Starts follow within a thousandth of their tolerated error. A range ends where the mechanism would be refused,
be another structure, or not close over the turn (jointplay_page.script.closing).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis import vary
from jointplay.display.errors import InputError
from jointplay.display.number_text import raised
from jointplay.display.units import PLAIN, shown
from jointplay.solver.mechanism.paths import part_at
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_page.script import forms

START = 1e-3  # what forms may leave of a start, in its tolerated errors
ROUGH = ("absolute", "weight", "margin", "cone", "rest", "hop", "play")
RANGES = {  # of a slider over its stored value
    "clearance": (0.1, 10.0),
    "stiffness": (0.05, 20.0),
    "coefficient": (0.1, 30.0),
    "damping": (0.1, 10.0),
    "restitution": (0.1, 1.9),
    "at": (0.3, 3.0),
    "": (0.2, 3.0),
}
TRIED, NEARER, SAMPLES, JOINT = 12, 6, 9, 24
WITHIN = 0.98  # of the way to where a mechanism begins to be refused
SIDES = ("journal", "bearing")
OF_A_JOINT = {"friction": "friction.coefficient"}
OF_A_JOINT |= {word: f"contact.{word}" for word in ("stiffness", "damping", "restitution")}
OF_A_LINK = ("mass", "inertia", "inertia_centre")
Place = tuple[str, int]
Found = dict[Place, float]
Numbers = Callable[[Mechanism | TestSystem], Found | None]


@dataclass(eq=False)
class Slider:
    """A parameter, its range, and the form of each number that it changes, by that number's place.

    `paths` lead to all numbers of the mechanism that it stands for; `refused` says whether there is nothing
    below the range, or above it, that makes a mechanism of the same kind.
    """

    key: str
    paths: tuple[str, ...]
    value: float
    low: float = 0.0
    high: float = 0.0
    refused: tuple[bool, ...] = ()
    forms: dict[Place, tuple[str, list[float]]] = field(default_factory=dict)

    def moved(self, place: Place, first: float, x: float) -> float:
        """The number at a place where this parameter alone has the value x."""
        kind, numbers = self.forms.get(place, ("polynomial", [first]))
        if kind == "power":
            return first * (x / self.value) ** numbers[0]
        return float(np.polynomial.polynomial.polyval(x / self.value - 1, numbers))


def followed(mechanism: Mechanism | TestSystem, numbers: Numbers, closes: bool = False) -> dict[str, Any]:
    """Give the sliders of a mechanism, and the numbers that follow them, fit for JSON.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        With the stored values.
    numbers : callable
        All numbers that a run of a mechanism begins with, by place; None where it has another structure.
    closes : bool
        Whether they are found where lengths change.

    Returns
    -------
    dict
        ``parameters``, ``followed`` (numbers with their forms) and ``fixed`` (parameters without a slider,
        each with ``why``).
    """
    first, kept, fixed = numbers(mechanism) or {}, [], []

    def tried(values: dict[Slider, float]) -> Found | None:
        try:
            changes = {path: x for slider, x in values.items() for path in slider.paths}
            return numbers(vary.changed(mechanism, changes))
        except InputError:
            return None

    for slider in candidates(mechanism):
        if slider.key.startswith("length") and not closes:
            fixed.append((slider, "where the motion begins is not known at other lengths"))
        elif why := _fitted(slider, tried, first):
            fixed.append((slider, why))
        else:
            kept.append(slider)
    while isinstance(rules := _rules(kept, tried, first), Slider):
        fixed.append((rules, "it does not go together with the sliders before it"))
        kept.remove(rules)
    return {
        "parameters": [_described(mechanism, slider) for slider in kept],
        "fixed": [_described(mechanism, slider) | {"why": why} for slider, why in fixed],
        "followed": [
            {
                "array": array,
                "at": at,
                "value": first[array, at],
                "rule": rules[array, at],
                "forms": [[i, *s.forms[array, at]] for i, s in enumerate(kept) if (array, at) in s.forms],
            }
            for array, at in dict.fromkeys(place for slider in kept for place in slider.forms)
        ],
    }


def candidates(mechanism: Mechanism | TestSystem) -> Iterator[Slider]:
    """Yield the parameters that might get a slider, the most asked for first."""
    if isinstance(mechanism, TestSystem):
        for name, value in mechanism.parameters.items():
            if value and not isinstance(value, bool):
                yield Slider(name, (name,), value)
        return
    loose = [joint.name for joint in mechanism.clearance_joints]
    found = {f"clearance.{name}": [f"joints.{name}.clearance"] for name in loose}
    found |= {name: [f"drive.{name}"] for name in ("gear_ratio", "speed")}
    found |= {
        f"{word}.{name}": [f"joints.{name}.{path}"] for name in loose for word, path in OF_A_JOINT.items()
    }
    for link in mechanism.links:  # a length, with all joints at the far end
        pairs = [(joint, side) for joint in mechanism.joints for side in SIDES]
        pins = [(f"joints.{joint.name}.{side}.at", getattr(joint, side)) for joint, side in pairs]
        ends = [path for path, pin in pins if (pin.link, pin.at) == (link.name, link.length)]
        found |= {f"length.{link.name}": [f"links.{link.name}.length", *ends]} if ends else {}
    names = [link.name for link in mechanism.links]
    found |= {f"{word}.{name}": [f"links.{name}.{word}"] for name in names for word in OF_A_LINK}
    found |= {name: [f"drive.{name}"] for name in ("rated_torque", "efficiency")} | {"gravity": ["gravity"]}
    for key, paths in found.items():
        value, missing = part_at(mechanism, paths[0], key)
        if value and not missing:
            yield Slider(key, tuple(paths), value)


def _fitted(slider: Slider, tried: Callable, first: Found) -> str:
    """Find the range and the forms; why there are none, or nothing."""
    word = slider.paths[-1].rpartition(".")[2]
    share = RANGES.get(word, RANGES[""])
    ends = [_end(slider, slider.value * each, tried) for each in share]
    if None in ends:
        return "no other value near it gives a mechanism of the same kind"
    pairs = zip(ends, share, strict=True)
    both = sorted((_rounded(end, slider.value), end != slider.value * each) for end, each in pairs)
    (slider.low, slider.high), slider.refused = zip(*both, strict=True)
    angles = np.cos(np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES)
    middle, half = (slider.high + slider.low) / 2, (slider.high - slider.low) / 2
    xs = [slider.low, slider.high, *(middle + half * angles)]
    found = [tried({slider: x}) for x in xs]
    if None in found:
        return "values between its ends give no mechanism of the same kind"
    for place, value in first.items():
        series = np.array([each[place] for each in found])
        if np.any(series != value):
            form = forms.form(np.array(xs) / slider.value, series, value, _allowed(place, first))
            if form is None:
                what = "where the motion begins" if place[0] == "s" else "a number of the equations"
                return f"{what} follows it in no simple form"
            slider.forms[place] = form
    return "" if slider.forms else "nothing depends on it"


def _end(slider: Slider, x: float, tried: Callable) -> float | None:
    """The end of a range that is x, or next to where values towards x begin to be refused."""
    if tried({slider: x}) is not None:
        return x
    good, refused = slider.value, x
    for _ in range(TRIED):
        middle = (good + refused) / 2
        good, refused = (good, middle) if tried({slider: middle}) is None else (middle, refused)
    return None if good == slider.value else slider.value + WITHIN * (good - slider.value)


def _rounded(end: float, value: float) -> float:
    """An end of a range with the digits that are shown, towards the value."""
    step = 10.0 ** (math.floor(math.log10(abs(end))) - 3)
    whole = math.floor(end / step + 1e-6) if end > value else math.ceil(end / step - 1e-6)
    return float(f"{whole * step:.4g}")


def _allowed(place: Place, first: Found) -> tuple[float, bool]:
    """Absolute difference that a form may leave, and whether a rough form will do."""
    array, at = place
    return START * first.get(("absolute", at - 1), 0.0) if array == "s" else 0.0, array in ROUGH


def _rules(sliders: list[Slider], tried: Callable, first: Found) -> dict[Place, Any] | Slider:
    """The rule of each number by its place: `times`, or factors of products; else a slider to do without."""
    shares = np.random.default_rng(7).uniform(0.1, 0.9, (JOINT, len(sliders)))
    pairs = [pair for row in shares if (pair := _together(sliders, row, tried))]
    if sliders and 2 * len(pairs) < JOINT:
        return sliders[-1]
    rules = {}
    for place, value in first.items():
        series = np.array([found[place] for _, found in pairs])
        own = [i for i, slider in enumerate(sliders) if place in slider.forms]
        moved = [[sliders[i].moved(place, value, at[sliders[i]]) for i in own] for at, _ in pairs]
        added = np.array(moved).reshape(len(pairs), -1) - value
        rule = forms.rule(added, series, value, _allowed(place, first))
        if rule is None:
            return sliders[own[-1] if own else -1]
        rules[place] = rule if rule == "times" else [[k, *(own[i] for i in each)] for k, *each in rule]
    return rules


def _together(
    sliders: list[Slider], shares: np.ndarray, tried: Callable
) -> tuple[dict[Slider, float], Found] | None:
    """Other values of all sliders, nearer to those stored where they are refused, and the numbers there."""
    ends = [s.low * (s.high / s.low) ** u for s, u in zip(sliders, shares, strict=True)]
    for n in range(NEARER):
        point = {s: s.value * (x / s.value) ** (0.5**n) for s, x in zip(sliders, ends, strict=True)}
        if (found := tried(point)) is not None:
            return point, found
    return None


def _described(mechanism: Mechanism | TestSystem, slider: Slider) -> dict[str, Any]:
    (axis,) = vary.axes(mechanism, {slider.paths[0]: [slider.value]})
    unit = shown(slider.value, axis.units)
    return {
        "key": slider.key,
        "paths": slider.paths,
        "label": axis.long_name,
        "unit": "" if unit.symbol in PLAIN.values() else raised(unit.symbol),
        "factor": unit.factor,
        "value": slider.value,
        "min": slider.low,
        "max": slider.high,
        "refused": slider.refused,
        "scale": "log" if slider.high > 8 * slider.low > 0 else "lin",
    }
