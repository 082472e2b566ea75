"""Numbers that follow a slider: how everything that a run begins with depends on each parameter.

Assembling a mechanism is not written a second time in JavaScript. Instead each number that a parameter
changes gets a form, found from samples over the parameter's range and verified on others:

    power        v = v_0 (x / x_0)^n
    polynomial   v = sum c_k z^k, z = x / x_0 - 1, of low degree

and numbers that several parameters change are v_0 times, or plus, what each of them does to v_0, verified
where all have other values at once. A parameter of which something has no such form gets no slider; nor does
one whose forms do not go together with those before it, and no length has one: where a motion begins is a
matter of all lengths together. Tolerances (`ROUGH`) follow within a factor of ten
where they have no simple form, starts within a thousandth of their tolerated error. A range ends where the
mechanism would be refused, or be another structure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis import vary
from jointplay.display.number_text import raised
from jointplay.display.units import PLAIN, shown
from jointplay.errors import InputError
from jointplay.mechanism.records import Mechanism, TestSystem

EXACT, START = 3e-14, 1e-3  # what forms may leave: relative; of a start, in its tolerated errors
ROUGHLY = 10.0  # factor by which a tolerance may be off
ROUGH = ("absolute", "weight", "margin", "cone", "rest", "hop", "play")
RANGES = {  # of a slider over its stored value
    "clearance": (0.1, 10.0),
    "stiffness": (0.05, 20.0),
    "coefficient": (0.1, 30.0),
    "damping": (0.1, 10.0),
    "restitution": (0.1, 1.9),
    "": (0.2, 3.0),
}
TRIED, SAMPLES, JOINT = 12, 9, 6
HIGHEST = 6  # degree of a polynomial
Numbers = Callable[[Mechanism | TestSystem], dict[tuple[str, int], float] | None]


@dataclass
class Slider:
    """A parameter, its range, and the form of each number that it changes, by that number's place."""

    key: str
    path: str
    value: float
    low: float = 0.0
    high: float = 0.0
    forms: dict[tuple[str, int], tuple[str, list[float]]] = field(default_factory=dict)

    def moved(self, place: tuple[str, int], first: float, x: float) -> float:
        """The number at a place where this parameter alone has the value x."""
        kind, numbers = self.forms.get(place, ("polynomial", [first]))
        if kind == "power":
            return first * (x / self.value) ** numbers[0]
        return float(np.polynomial.polynomial.polyval(x / self.value - 1, numbers))


def followed(mechanism: Mechanism | TestSystem, numbers: Numbers) -> dict[str, Any]:
    """Give the sliders of a mechanism, and the numbers that follow them, fit for JSON.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        With the stored values.
    numbers : callable
        All numbers that a run of a mechanism begins with, by place; None where it has another structure.

    Returns
    -------
    dict
        ``parameters``, ``followed`` (numbers with their forms) and ``fixed`` (parameters without a slider,
        and why).
    """
    first, kept, fixed, rules = numbers(mechanism) or {}, [], {}, {}

    def tried(changes: dict[str, float]) -> dict[tuple[str, int], float] | None:
        try:
            return numbers(vary.changed(mechanism, changes))
        except InputError:
            return None

    for slider in candidates(mechanism):
        why = _fitted(slider, tried, first)
        found = None if why else _rules([*kept, slider], tried, first)
        if found is None:
            fixed[slider.key] = why or "it does not go together with the sliders before it"
        else:
            kept, rules = [*kept, slider], found
    return {
        "parameters": [_described(mechanism, slider) for slider in kept],
        "fixed": fixed,
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
                yield Slider(name, name, value)
        return
    drive = mechanism.drive
    for joint in mechanism.clearance_joints:
        yield Slider(f"clearance.{joint.name}", f"joints.{joint.name}.clearance", joint.clearance)
    for word, name in (("gear_ratio", "gear_ratio"), ("imposed_speed", "speed")):
        if value := getattr(drive, word, None):
            yield Slider(name, name, value)
    for joint in mechanism.clearance_joints:
        own = f"joints.{joint.name}"
        if joint.friction and joint.friction.coefficient:
            yield Slider(f"friction.{joint.name}", f"{own}.friction.coefficient", joint.friction.coefficient)
        for word in ("stiffness", "damping", "restitution"):
            if value := getattr(joint.contact, word, None):
                yield Slider(f"{word}.{joint.name}", f"{own}.contact.{word}", value)


def _fitted(slider: Slider, tried: Callable, first: dict) -> str:
    """Find the range and the forms; why there are none, or nothing."""
    word = slider.path.rpartition(".")[2]
    share = RANGES.get(word, RANGES[""])
    ends = [_end(slider, slider.value * each, tried) for each in share]
    if None in ends:
        return "no other value near it gives a mechanism of the same kind"
    slider.low, slider.high = sorted(ends)
    angles = np.cos(np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES)
    middle, half = (slider.high + slider.low) / 2, (slider.high - slider.low) / 2
    xs = [slider.low, slider.high, *(middle + half * angles)]
    found = [tried({slider.path: x}) for x in xs]
    if None in found:
        return "values between its ends give no mechanism of the same kind"
    for place, value in first.items():
        series = np.array([each[place] for each in found])
        if np.any(series != value):
            form = _form(np.array(xs) / slider.value, series, value, _allowed(place, first))
            if form is None:
                return f"{place[0]}[{place[1]}] follows it in no simple form"
            slider.forms[place] = form
    return "" if slider.forms else "nothing depends on it"


def _end(slider: Slider, x: float, tried: Callable) -> float | None:
    """The end of a range that is x, or nearer to the stored value where x is refused."""
    for _ in range(TRIED):
        if tried({slider.path: x}) is not None:
            return x
        x = slider.value + (x - slider.value) / 2
    return None


def _allowed(place: tuple[str, int], first: dict) -> tuple[float, bool]:
    """Absolute difference that a form may leave, and whether a rough form will do."""
    array, at = place
    return START * first["absolute", at - 1] if array == "s" and at else 0.0, array in ROUGH


def _form(
    ratio: np.ndarray, series: np.ndarray, value: float, allowed: tuple[float, bool]
) -> tuple[str, list[float]] | None:
    """Form of a number that is `series` where the parameter is `ratio` times its stored value."""
    powers = bool(value) and bool(np.all(series / value > 0))
    if powers:
        n = round(2 * np.log(series[1] / value) / np.log(ratio[1])) / 2
        if _close(value * ratio**n, series, allowed[0]):
            return "power", [n]
    z = ratio - 1
    for degree in range(1, HIGHEST + 1):
        basis = np.vander(z, degree + 1, increasing=True)[:, 1:]
        c = np.linalg.lstsq(basis, series - value, rcond=None)[0]
        if _close(value + basis @ c, series, allowed[0]):
            return "polynomial", [value, *c.tolist()]
    if powers and allowed[1]:
        n = float(np.polyfit(np.log(ratio), np.log(series / value), 1)[0])
        return ("power", [n]) if _near(value * ratio**n, series) else None
    return None


def _close(found: Any, wanted: np.ndarray, allowed: float) -> bool:
    same = np.isinf(wanted) & (found == wanted)
    allowed = max(allowed, EXACT * np.max(np.abs(wanted[~same]), initial=0.0))
    return bool(np.all(same | (np.abs(found - wanted) <= allowed)))


def _near(found: Any, wanted: np.ndarray) -> bool:
    return bool(np.all(np.abs(np.log(found / wanted)) <= np.log(ROUGHLY)))


def _rules(sliders: list[Slider], tried: Callable, first: dict) -> dict[tuple[str, int], str] | None:
    """Whether changes of each number are multiplied or added, by its place; None where neither is right."""
    shares = np.random.default_rng(7).uniform(0.1, 0.9, (JOINT, len(sliders)))
    points = [
        {s.path: s.low * (s.high / s.low) ** u for s, u in zip(sliders, row, strict=True)} for row in shares
    ]
    pairs = [(point, found) for point in points if (found := tried(point)) is not None]
    rules = {}
    for place, value in first.items():
        series = np.array([found[place] for _, found in pairs])
        if not any(place in slider.forms for slider in sliders):
            if np.any(series != value):
                return None
            continue
        alone = np.array([[s.moved(place, value, point[s.path]) for s in sliders] for point, _ in pairs])
        plus, times = value + np.sum(alone - value, 1), value * np.prod(alone / value, 1) if value else None
        allowed, rough = _allowed(place, first)
        if value and _close(times, series, allowed):
            rules[place] = "times"
        elif _close(plus, series, allowed):
            rules[place] = "plus"
        elif rough and value and np.all(times / series > 0) and _near(times, series):
            rules[place] = "times"
        else:
            return None
    return rules


def _described(mechanism: Mechanism | TestSystem, slider: Slider) -> dict[str, Any]:
    (axis,) = vary.axes(mechanism, {slider.path: [slider.value]})
    unit = shown(slider.value, axis.units)
    return {
        "key": slider.key,
        "label": axis.long_name,
        "unit": "" if unit.symbol in PLAIN.values() else raised(unit.symbol),
        "factor": unit.factor,
        "value": slider.value,
        "min": slider.low,
        "max": slider.high,
        "scale": "log" if slider.high > 8 * slider.low > 0 else "lin",
    }
