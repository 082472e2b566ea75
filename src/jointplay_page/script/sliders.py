"""Numbers that follow a slider: dependence of a run's starting values on each parameter.

Assembling a mechanism is not written a second time in JavaScript. Instead each number that a parameter
changes gets a form, found from samples over the parameter's range, and each
number that several change a rule, verified where all have other values at once. A parameter of which
something has no such form gets no slider, nor does one whose forms do not go together with those before it.
Starts follow within a thousandth of their tolerated error. A range ends where the mechanism would be refused,
be another structure, or not close over the turn (jointplay_page.script.solver).

A number that a parameter x changes is, with v_0 and x_0 as they are stored,

    power        v = v_0 (x / x_0)^n
    polynomial   v = sum c_k z^k, z = x / x_0 - 1, of low degree

and one that several change, with d_i what each of them by itself adds to v_0,

    times        v = v_0 prod (1 + d_i / v_0)
    products     v = v_0 + sum d_i + sum k_ij d_i d_j + sum k_ijl d_i d_j d_l

What has none of these forms is refused, never approximated; tolerances may be off by `ROUGHLY`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from jointplay.display.errors import InputError
from jointplay.display.number_text import PLAIN, raised, shown
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.parts.joints import per_power
from jointplay.solver.mechanism.paths import part_at, parts_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem

START = 1e-3  # what forms may leave of a start, in its tolerated errors
ROUGH = ("absolute", "weight", "margin", "cone", "speed_tolerance", "height_tolerance", "gap_rounding")
RANGES = {  # of a slider over its stored value
    "clearance": (0.1, 10.0),
    "stiffness": (0.05, 20.0),
    "coefficient": (0.1, 30.0),
    "damping": (0.1, 10.0),
    "restitution": (0.1, 1.9),
    "gear_ratio": (0.2, 7.0),
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
EXACT, ROUGHLY = 3e-14, 10.0  # what forms may leave: relative; a factor
HIGHEST = 6  # degree of a polynomial


@dataclass(eq=False)
class Slider:
    """A parameter, its range, and the form of each number that it changes, by that number's place.

    `refused` says whether there is nothing below the range, or above it, that makes a mechanism of the same
    kind.
    """

    key: str
    parameter: Parameter
    low: float = 0.0
    high: float = 0.0
    refused: tuple[bool, ...] = ()
    forms: dict[Place, tuple[str, list[float]]] = field(default_factory=dict)

    @property
    def value(self) -> float:
        """The stored number."""
        return self.parameter.value

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
            return numbers(mechanism.varied({slider.parameter.key: x for slider, x in values.items()}))
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
        "parameters": [_described(slider) for slider in kept],
        "fixed": [_described(slider) | {"why": why} for slider, why in fixed],
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
    """Yield the parameters that might get a slider, the most useful first."""
    linkage = isinstance(mechanism, Mechanism)
    found = _of_linkage(mechanism) if linkage else {name: name for name in mechanism.parameters}
    for key, name in found.items():
        parameter = Parameter(mechanism, name)
        if is_number(parameter.value) and parameter.value:
            yield Slider(key, parameter)


def _of_linkage(mechanism: Mechanism) -> dict[str, str]:
    """Keys of parameters, there or not, of each slider that a linkage might have."""
    loose = [joint.name for joint in mechanism.clearance_joints]
    found = {f"clearance.{name}": f"joints.{name}.clearance" for name in loose}
    found |= {name: f"drive.{name}" for name in ("gear_ratio", "speed")}
    found |= {
        f"{word}.{name}": f"joints.{name}.{path}" for name in loose for word, path in OF_A_JOINT.items()
    }
    for link in mechanism.links:  # a length, with all joints at the far end
        pairs = [(joint, side) for joint in mechanism.joints for side in SIDES]
        pins = [(f"joints.{joint.name}.{side}.at", getattr(joint, side)) for joint, side in pairs]
        ends = [path for path, pin in pins if (pin.link, pin.at) == (link.name, link.length)]
        found |= {f"length.{link.name}": " + ".join([f"links.{link.name}.length", *ends])} if ends else {}
    names = [link.name for link in mechanism.links]
    found |= {f"{word}.{name}": f"links.{name}.{word}" for name in names for word in OF_A_LINK}
    return found | {name: f"drive.{name}" for name in ("rated_torque", "efficiency")} | {"gravity": "gravity"}


def _fitted(slider: Slider, tried: Callable, first: Found) -> str:
    """Find the range and the forms; why there are none, or nothing."""
    word = slider.parameter.key.rpartition(".")[2]
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
            form = form_of(np.array(xs) / slider.value, series, value, _allowed(place, first))
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
        rule = rule_of(added, series, value, _allowed(place, first))
        if rule is None:
            return sliders[own[-1] if own else -1]
        rules[place] = rule if rule == "times" else [[k, *(own[i] for i in each)] for k, *each in rule]
    return rules


def _together(
    sliders: list[Slider], shares: np.ndarray, tried: Callable
) -> tuple[dict[Slider, float], Found] | None:
    """Other values of all sliders, nearer to the stored ones if they are refused, and the numbers there."""
    ends = [s.low * (s.high / s.low) ** u for s, u in zip(sliders, shares, strict=True)]
    for n in range(NEARER):
        point = {s: s.value * (x / s.value) ** (0.5**n) for s, x in zip(sliders, ends, strict=True)}
        if (found := tried(point)) is not None:
            return point, found
    return None


def _described(slider: Slider) -> dict[str, Any]:
    unit, power = shown(slider.value, slider.parameter.cf_units), {}
    if slider.parameter.key.endswith(".contact.stiffness"):
        contact, _ = part_at(slider.parameter.mechanism, slider.parameter.key.removesuffix(".stiffness"), "")
        power = per_power(contact.law, contact.parameters)
    return {
        "key": slider.key,
        "paths": parts_of(slider.parameter.key),
        "label": slider.parameter.noun,
        "unit": power.get("stiffness", "" if unit.symbol in PLAIN.values() else raised(unit.symbol)),
        "factor": unit.factor,
        "value": slider.value,
        "min": slider.low,
        "max": slider.high,
        "refused": slider.refused,
        "scale": "log" if slider.high > 8 * slider.low > 0 else "lin",
    }


def form_of(
    ratio: np.ndarray, series: np.ndarray, value: float, allowed: tuple[float, bool]
) -> tuple[str, list[float]] | None:
    """Form of a number that is `series` where the parameter is `ratio` times its stored value."""
    powers = bool(value) and bool(np.all(series / value > 0))
    if powers:
        n = round(2 * np.log(series[1] / value) / np.log(ratio[1])) / 2
        if close(value * ratio**n, series, allowed[0]):
            return "power", [n]
    z = ratio - 1
    for degree in range(1, HIGHEST + 1):
        basis = np.vander(z, degree + 1, increasing=True)[:, 1:]
        c = np.linalg.lstsq(basis, series - value, rcond=None)[0]
        if close(value + basis @ c, series, allowed[0]):
            return "polynomial", [value, *c.tolist()]
    if powers and allowed[1]:
        n = float(np.polyfit(np.log(ratio), np.log(series / value), 1)[0])
        return ("power", [n]) if near(value * ratio**n, series) else None
    return None


def close(found: Any, wanted: np.ndarray, allowed: float) -> bool:
    """Whether numbers equal the wanted ones, to rounding or to the allowed error."""
    same = np.isinf(wanted) & (found == wanted)
    allowed = max(allowed, EXACT * np.max(np.abs(wanted[~same]), initial=0.0))
    with np.errstate(invalid="ignore"):
        return bool(np.all(same | (np.abs(found - wanted) <= allowed)))


def near(found: Any, wanted: np.ndarray) -> bool:
    """Whether they are the wanted ones, roughly."""
    return bool(np.all(np.abs(np.log(found / wanted)) <= np.log(ROUGHLY)))


def rule_of(added: np.ndarray, series: np.ndarray, value: float, allowed: tuple[float, bool]) -> Any:
    """Rule by which changes by each slider, shape (points, sliders), combine; None where there is none."""
    times = value * np.prod(1 + added / value, 1) if value else None
    if value and close(times, series, allowed[0]):
        return "times"
    plus, columns = value + np.sum(added, 1), range(added.shape[1])
    for most in (1, 2, 3):
        sets = [each for size in range(2, most + 1) for each in combinations(columns, size)]
        products = np.array([np.prod(added[:, each], 1) for each in sets]).reshape(-1, len(series))
        sizes = np.linalg.norm(products, axis=1)[:, None]
        if 2 * len(sets) > len(series) or not np.all(sizes > 0):
            break
        k = np.linalg.lstsq((products / sizes).T, series - plus, rcond=1e-12)[0] / sizes[:, 0]
        if close(plus + k @ products, series, allowed[0]):
            mask = np.abs(k) * sizes[:, 0] > EXACT * np.linalg.norm(series)
            return [(k[n].item(), *sets[n]) for n in np.flatnonzero(mask)]
    rough = allowed[1] and value and np.all(times / series > 0) and near(times, series)
    return "times" if rough else None
