"""A mechanism's solver as JavaScript: its equations, the method, and the driver of solver.js, in one text.

The text belongs to a structure, the data to a mechanism. The flow is that of method.flow with its tangents,
translated (jointplay_page.script.translate) line by line; recorded quantities are those of the structure's
own program.

As lengths change, a motion's start is found again: it begins as its ideal mechanism does, at the crank's
angle. Angles and slides with their speeds are outputs of that mechanism's equations, which close its loops
(`equations.loops.loop`): the same program gives them at other lengths. Over the turn it shows whether loops
close: where they do not, there is the root of a negative number. Assumption: ideal loops close by two links
at a time; of others None. Units: rad, m, s.
"""

from __future__ import annotations

import hashlib
import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jointplay.analysis import evaluate, rules
from jointplay.analysis.assessment import page
from jointplay.analysis.assessment.page import ALIKE
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.exponents.frame_growth import SOLVED, frame, has_no_clock
from jointplay.analysis.quantities import EVENTS, WORDS
from jointplay.analysis.tangents import measures, scales, tolerated
from jointplay.display.errors import InputError, refuse
from jointplay.solver.codegen import cache, outputs, place
from jointplay.solver.codegen.generated import source
from jointplay.solver.codegen.lambert import LAMBERT
from jointplay.solver.codegen.outputs import needed
from jointplay.solver.codegen.reader import RefusedError, Text, imported
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parts.joints import Joint
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.method.codes import Row, Status
from jointplay.solver.method.control import FULL
from jointplay.solver.method.interface import Functions, Variations
from jointplay.solver.method.memory import COUNTERS, GROWTH, LEVEL, H
from jointplay.solver.method.modes import RELEASED
from jointplay.solver.method.tangents.tangent import (
    BLOCK,
    GRAZING,
    LIMIT,
    NEUTRAL,
    NEXT,
    SALTATION,
    TOLERANCE,
    tangents,
)
from jointplay.solver.motion.trajectory import Request, memory, wall_unit
from jointplay_page.script.sliders import followed
from jointplay_page.script.translate import Script

RECORDED = ("angle", "angular_velocity", "journal_x", "journal_y", "normal_force", "reaction")
RECORDED += ("slide_position", "state_value", "tangential_force", "normal_velocity")
NEEDED = ("angle", "journal_x", "journal_y", "slide_position", "eccentricity_ratio")  # for places, and `set`
ARRAYS = ("s", "p", "absolute", "relative", "margin", "clearance_squared", "cone")
TOLERANCES = ("speed_tolerance", "height_tolerance", "gap_rounding", "rate_tolerance")
OPTIONS = ("h_max", "chatter_time", *TOLERANCES)
LIMITS = {  # of an assessment's grades and words
    "names": page.GRADES,
    "meaning": page.MEANING,
    "gentle": page.GENTLE,
    "hard": page.HARD,
    "light": page.LIGHT,
    "heavy": page.HEAVY,
    "alike": ALIKE,
    "negligible": page.NEGLIGIBLE,
    "corners": {},  # words for a mechanism's own
    "body": "joint",
}
LOG_ROWS = 512
HEADER = "from math import atan2, copysign, cos, exp, log, sin, sqrt, tan, tanh\n"
OUTPUTS = {"theta": "angle", "w": "angular_velocity", "slide": "slide_position", "vslide": "slide_velocity"}
TURN = 128  # angles of the crank in a turn
ROUNDED = 1e-12  # of the largest: outputs agree with the start to this, or to what is tolerated
Numbers = dict[tuple[str, int], float]


@dataclass(frozen=True)
class Solver:
    """JavaScript that defines ``makeSolver``, and the data to call it with, which are fit for JSON.

    Parameters
    ----------
    text : str
        Belongs to the structure: mechanisms that differ in numbers alone share it.
    data : dict
        Numbers, names, start, tolerances.
    """

    text: str
    data: dict[str, Any]


def solver(
    mechanism: Mechanism | TestSystem,
    *,
    initial: Any = None,
    section: Any = None,
    rtol: float = 1e-8,
    names: tuple[str, ...] = RECORDED,
) -> Solver:
    """Give the solver of a mechanism's motion.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    initial, section, rtol
        As in `jointplay.simulate`.
    names : tuple of str
        Quantities that it records; those that the mechanism has not are left out.

    Raises
    ------
    InputError
        If the start or the section does not fit the mechanism, or its equations have no translation.
    """
    model = rules.model_for(mechanism, initial, section)
    named = Quantities(model, model.state[None, :0], model.state)
    wanted = dict.fromkeys((*names, *NEEDED))
    pairs = [(name, label) for name in wanted for label in named.labels(WORDS[name].of)]
    shown = [each for each in pairs if named.key(*each) in named.module.OUTPUTS]

    def request(model: Model) -> Request:
        fields = rules.section_fields(section, model, 0)
        sharp = evaluate.needed(model, (name for name, _ in shown))
        return Request(math.inf, rtol, log_from=0.0, events=True, rates=sharp, **fields)

    loops = closing(mechanism, initial, model)

    def numbers(changed: Mechanism | TestSystem) -> dict[tuple[str, int], float] | None:
        other = rules.model_for(changed, initial, section)
        if other.structure != model.structure:
            return None
        found = _numbers(other, request(other))
        return loops.followed(found, other, ideal(changed, initial)) if loops else found

    free = mechanism.numbers_alone() if isinstance(mechanism, Mechanism) else mechanism
    data = _begun(model, request(model)) | followed(free, numbers, bool(loops))
    data |= {
        "quantities": [
            {"name": n, "label": k, "units": WORDS[n].units, "shown": n in names} for n, k in shown
        ],
        "joints": [*model.joints, *model.walls],
        "links": model.links,
        "events": EVENTS,
        "statuses": [{"word": each.word, "meaning": each.meaning} for each in Status],
        "state": named.module.STATE[1:],
        "linkage": [*map(_joint, mechanism.joints)] if isinstance(mechanism, Mechanism) else [],
        "closing": loops.data if loops else None,
    }
    start = (loops.ideal.structure, loops.outputs) if loops else None
    try:
        text = solver_text(model.structure, tuple(named.key(*each) for each in shown), start)
        return Solver(text, data)
    except RefusedError as error:
        expected = f"what can be written as JavaScript is accepted here; {error}"
        raise refuse(mechanism.name, expected, "mechanism") from None


def _joint(joint: Joint) -> dict[str, Any]:
    """Data of a joint from which places of links follow, as of `mechanism.loops.positions`."""
    kind = {"prismatic": joint.prismatic, "ideal": joint.ideal, "label": (*joint.contacts, joint.name)[0]}
    return joint.model_dump(mode="json", include={"name", "journal", "bearing"}) | kind


def _numbers(model: Model, request: Request) -> dict[tuple[str, int], float]:
    """All that a run begins with and that a parameter may change, by array and place."""
    _, motion, options = memory(model, request)
    arrays = {name: getattr(motion, name) for name in ARRAYS} | {"weight": 1 / measures(model)}
    arrays |= {name: np.array([getattr(options, name)]) for name in OPTIONS} | {
        "span": np.array([model.period])
    }
    return {(name, i): float(v) for name, array in arrays.items() for i, v in enumerate(array)}


def solver_text(structure: Linkage | Oscillator, keys: tuple[str, ...], start: Any = None) -> str:
    """Give the JavaScript of a structure's equations, of the method and of the driver; it defines makeSolver.

    `keys` are outputs that it evaluates; `start` an ideal structure and those that its start follows from.
    The text is kept beside the compiled kernels, under a name of all that decides it.

    Raises
    ------
    RefusedError
        If a kernel, or an equation, holds what has no translation.
    """
    own = b"".join(each.read_bytes() for each in sorted(Path(__file__).parent.glob("*.[pj][ys]")))
    name = f"{hashlib.sha256(own + repr((structure, keys, start)).encode()).hexdigest()[:16]}.js"
    if (data := place.read(name)) is None:
        place.compiling(name)
        place.write(name, data := _translated(structure, keys, start).encode())
        place.settle()
    return data.decode()


def _translated(structure: Linkage | Oscillator, keys: tuple[str, ...], start: Any) -> str:
    from jointplay.solver.codegen import algebra, variation  # SymPy takes a while to import
    from jointplay.solver.equations.write import system

    script = Script()
    script.function(imported("jointplay.solver.method.flow"), "run")
    module = cache.structure_module(structure)
    sizes, own = module.SIZES, Text.of(source(module), "structure")
    derived = variation.text(system(structure), sizes["first"], bool(sizes["planned"]))
    parts = {"functions": [own], "variations": [Text.of(derived, "variation")]}
    if not sizes["planned"]:
        text = algebra.text(sizes["positions"], sizes["speeds"])
        parts["functions"].append(Text.of(text, "algebra"))
    if wall := wall_unit(structure):
        parts["functions"].append(imported(f"jointplay.solver.method.{wall}"))
    handed = []
    for name, fields in (("functions", Functions._fields), ("variations", Variations._fields)):
        known = {field: unit for unit in parts[name] for field in fields if field in unit.functions}
        pairs = (f"{field}: {script.function(unit, field)}" for field, unit in known.items())
        handed.append(f"const {name} = {{ {', '.join(pairs)} }};")
    handed.append(f"const tangentRows = {parts['variations'][0].scope['ROWS']};")
    for name, wanted in (("quantities", (structure, keys)), ("closing", start)):
        unit = wanted and _quantities(name, cache.structure_module(wanted[0]), wanted[1])
        handed.append(f"const {name} = {script.function(unit, 'quantities') if unit else 'null'};")
    runtime, driver = (Path(__file__).with_name(name).read_text() for name in ("runtime.js", "solver.js"))
    body = "\n".join([runtime, script.text, *handed, driver])
    return f"const makeSolver = (() => {{\n{body}\nreturn makeSolver;\n}})();\n"


def _quantities(word: str, module: Any, keys: tuple[str, ...]) -> Text:
    """The part of a structure's program that some quantities need, as a function of a record."""
    lines, wanted = needed(module, keys)
    names = {name: f"row[{i}]" for i, name in enumerate(module.STATE)}
    names |= {name: f"p[{i}]" for i, name in enumerate(module.PARAMETERS)}
    for j, name in enumerate((*module.CONTACTS, *module.RESETS)):
        mode = f"row[{len(module.STATE) + j}]"
        names[f"touch_{name}"] = f"1.0 if {mode} > {RELEASED} else 0.0"
        names[f"slip_{name}"] = f"1.0 if {mode} == 2 else (-1.0 if {mode} == 3 else 0.0)"
        names[f"stick_{name}"] = f"1.0 if {mode} == 4 else 0.0"
    head = [f"{name} = {value}" for name, value in names.items() if name in wanted]
    tail = [f"out[{i}] = {module.OUTPUTS[key]}" for i, key in enumerate(keys)]
    body = "\n".join(f"    {line}" for line in (*head, *lines, *tail))
    law = LAMBERT if "lambert(" in body else ""
    return Text.of(f"{HEADER}{law}def quantities(row, p, out):\n{body or '    pass'}\n", word)


def _begun(model: Model, request: Request) -> dict[str, Any]:
    """Arrays and options of a run, as lengths where they begin as zeros."""
    work, motion, options = memory(model, request)
    names = cache.structure_module(model.structure).STATE[1:]
    crank = f"theta_{model.crank}"
    return {
        "work": {name: len(array) for name, array in work._asdict().items()},
        "trajectory": {n: _packed(a) for n, a in motion._asdict().items() if n not in ("samples", "log")},
        "options": {name: _plain(value) for name, value in options._asdict().items()},
        "tangents": _tangents(model, request, options, len(motion.s)),
        "log_rows": LOG_ROWS,
        "period": model.period,
        "first_step": float(motion.real[H]) / model.period,
        "crank": names.index(crank) if crank in names else None,
        "places_of": {"count": list(range(COUNTERS)), "real": {"H": H, "LEVEL": LEVEL, "GROWTH": GROWTH}},
        "codes": {"OK": int(Status.OK), "FULL": FULL, "STEP_LIMIT": int(Status.STEP_LIMIT)},
        "rows": {each.word: float(each) for each in Row},
    }


def _tangents(model: Model, request: Request, options: Any, n_s: int) -> dict[str, Any]:
    """One tangent, and the motion's own direction before it where nothing outside keeps the time."""
    neutral = has_no_clock(model)
    wanted = frame(1 + neutral, scales(model), model.memories)
    made = tangents(wanted, measures(model), options.n, 0, 1, n_s=n_s)  # tangentRows, where it runs
    made.count[SALTATION], made.count[NEUTRAL] = 1, neutral
    made.real[GRAZING] = made.real[BLOCK] = made.real[NEXT] = np.inf
    made.real[TOLERANCE], made.real[LIMIT] = SOLVED * request.rtol, tolerated(model.structure, request.rtol)
    return {name: _packed(array) for name, array in made._asdict().items() if name not in ("rows", "w")}


def _packed(array: np.ndarray) -> int | list[Any]:
    """Length of zeros, else the values."""
    return [_plain(value) for value in array.tolist()] if array.any() else len(array)


def _plain(value: float) -> float | str:
    """A number for JSON: one that is not finite becomes a word that both languages read."""
    return value if math.isfinite(value) else str(value).replace("inf", "Infinity").replace("nan", "NaN")


def closing(mechanism: Mechanism | TestSystem, initial: Any, model: Model) -> Closing | None:
    """Give the closing of a model at its start; None where the ideal mechanism's equations do not give it."""
    with suppress(InputError):  # its loops do not close by themselves, or not from there
        found = Closing(model, ideal(mechanism, initial)) if isinstance(mechanism, Mechanism) else None
        closes = found and not found.ideal.structure.guessed and found.followed({}, model, found.ideal)
        return found if closes else None
    return None


def ideal(mechanism: Mechanism, initial: Any) -> Model:
    """Assemble a mechanism without clearance, at its start."""
    return rules.model_for(mechanism.replace(clearance=0.0), initial)


class Closing:
    """A model and its ideal mechanism's; `keys` are outputs of the latter by places of the former's start.

    They are the first of `outputs`, of which all have to be numbers.
    """

    def __init__(self, model: Model, ideal: Model) -> None:
        self.ideal, states = ideal, cache.structure_module(model.structure).STATE
        module, own = cache.structure_module(ideal.structure), f"theta_{ideal.crank}"
        pairs = ((at, *name.partition("_")[::2]) for at, name in enumerate(states))
        named = {at: f"{OUTPUTS.get(word)}:{part}" for at, word, part in pairs}
        self.keys = {at: key for at, key in named.items() if key in module.OUTPUTS}
        moving = (key for key in module.OUTPUTS if key.partition(":")[0] in OUTPUTS.values())
        self.outputs = tuple(dict.fromkeys([*self.keys.values(), *moving]))
        turns = own in module.STATE  # else the crank's angle is led by the time
        self.step = math.tau / TURN if turns else ideal.period / TURN
        self.swept, self.turn = module.STATE.index(own) if turns else 0, TURN
        if self.begun(ideal) is None:
            self.turn = 1  # no full turn: other lengths have to close at the start
        self.first = model.state[[at - 1 for at in self.keys]]

    def begun(self, ideal: Model) -> np.ndarray | None:
        """Outputs at the start, where all are numbers at every angle of the crank; else None."""
        rows = np.tile(np.append(0.0, ideal.state), (self.turn, 1))
        rows[:, self.swept] += self.step * np.arange(self.turn)
        module, given = cache.structure_module(ideal.structure), Quantities(ideal, rows, rows[0]).given(rows)
        with np.errstate(all="ignore"):
            found = outputs.evaluate(module, self.outputs, given)
        series = np.stack([np.broadcast_to(each, self.turn) for each in found.values()], -1)
        return series[0, : len(self.keys)] if np.all(np.isfinite(series)) else None

    def followed(self, numbers: Numbers, model: Model, ideal: Model) -> Numbers | None:
        """A model's numbers, the ideal mechanism's for dependent ones; None where it does not close."""
        if ideal.structure != self.ideal.structure or (found := self.begun(ideal)) is None:
            return None
        at, angles = [*self.keys], [key.startswith("angle:") for key in self.keys.values()]
        off = model.state[[k - 1 for k in at]] - found
        off -= math.tau * np.round(off / math.tau) * angles
        allowed = [numbers.get(("absolute", k - 1), 0.0) for k in at]
        if np.any(np.abs(off) > np.maximum(allowed, ROUNDED * np.abs(found).max())):
            return None
        own = {"ideal_s": np.append(0.0, ideal.state), "ideal_p": ideal.numbers}
        kept = {place: v for place, v in numbers.items() if place[0] != "s" or place[1] not in self.keys}
        return kept | {(name, i): float(v) for name, row in own.items() for i, v in enumerate(row)}

    @property
    def data(self) -> dict[str, Any]:
        """Data of the driver, fit for JSON; angles are given but for whole turns."""
        turns = np.round((self.first - self.begun(self.ideal)) / math.tau)
        places = [[at, math.tau * n] for at, n in zip(self.keys, turns, strict=True)]
        start = {"ideal_s": [0.0, *self.ideal.state.tolist()], "ideal_p": self.ideal.numbers.tolist()}
        start["outputs"] = len(self.outputs)
        return start | {"swept": self.swept, "step": self.step, "turn": self.turn, "places": places}
