"""A mechanism's solver as JavaScript: its equations, the method, and the driver of solver.js, in one text.

The text belongs to a structure, the data to a mechanism. The flow is that of method.flow with its tangents,
translated (jointplay_page.script.translate) line by line; recorded quantities are those of the structure's
own program.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jointplay.analysis import rates, rules
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.exponents.frame_growth import SOLVED, frame
from jointplay.analysis.exponents.section_exponents import timeless
from jointplay.analysis.quantities import EVENTS, WORDS
from jointplay.analysis.tangents import measures, scales, tolerated
from jointplay.display.errors import refuse
from jointplay.solver.codegen import cache, place
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
from jointplay_page.script.closing import closing, ideal
from jointplay_page.script.sliders import followed
from jointplay_page.script.translate import Script

RECORDED = ("angle", "angular_velocity", "journal_x", "journal_y", "normal_force", "reaction")
RECORDED += ("slide_position", "state_value")
NEEDED = ("angle", "journal_x", "journal_y", "slide_position", "eccentricity_ratio")  # for places, and `set`
ARRAYS = ("s", "p", "absolute", "relative", "margin", "clearance_squared", "cone")
OPTIONS = ("h_max", "near", "rest", "hop", "play", "sharp")
LOG_ROWS = 512
HEADER = "from math import atan2, copysign, cos, exp, log, sin, sqrt, tan, tanh\n"


@dataclass(frozen=True)
class Solver:
    """JavaScript that defines ``makeSolver``, and what to call it with, which is fit for JSON.

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
        sharp = rates.needed(name for name, _ in shown)
        return Request(math.inf, rtol, log_from=0.0, events=True, rates=sharp, **fields)

    loops = closing(mechanism, initial, model)

    def numbers(changed: Mechanism | TestSystem) -> dict[tuple[str, int], float] | None:
        other = rules.model_for(changed, initial, section)
        if other.structure != model.structure:
            return None
        found = _numbers(other, request(other))
        return loops.followed(found, other, ideal(changed, initial)) if loops else found

    data = _begun(model, request(model)) | followed(mechanism, numbers, bool(loops))
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
    """What places of links follow from, as `mechanism.loops.positions` has it."""
    kind = {"prismatic": joint.prismatic, "ideal": joint.ideal, "label": (*joint.contacts, joint.name)[0]}
    return joint.model_dump(mode="json", include={"name", "journal", "bearing"}) | kind


def _numbers(model: Model, request: Request) -> dict[tuple[str, int], float]:
    """All that a run begins with and that a parameter may change, by array and place."""
    _, x, o = memory(model, request)
    arrays = {name: getattr(x, name) for name in ARRAYS} | {"weight": 1 / measures(model)}
    arrays |= {name: np.array([getattr(o, name)]) for name in OPTIONS} | {"span": np.array([model.period])}
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
    if beside := wall_unit(structure):
        parts["functions"].append(imported(f"jointplay.solver.method.{beside}"))
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
    k, x, o = memory(model, request)
    names = cache.structure_module(model.structure).STATE[1:]
    crank = f"theta_{model.crank}"
    return {
        "work": {name: len(array) for name, array in k._asdict().items()},
        "trajectory": {n: _packed(a) for n, a in x._asdict().items() if n not in ("samples", "log")},
        "options": {name: _plain(value) for name, value in o._asdict().items()},
        "tangents": _tangents(model, request, o, len(x.s)),
        "log_rows": LOG_ROWS,
        "period": model.period,
        "first_step": float(x.real[H]) / model.period,
        "crank": names.index(crank) if crank in names else None,
        "places_of": {"count": list(range(COUNTERS)), "real": {"H": H, "LEVEL": LEVEL, "GROWTH": GROWTH}},
        "codes": {"OK": int(Status.OK), "FULL": FULL, "STEP_LIMIT": int(Status.STEP_LIMIT)},
        "rows": {each.word: float(each) for each in Row},
    }


def _tangents(model: Model, request: Request, o: Any, n_s: int) -> dict[str, Any]:
    """One tangent, and the motion's own direction before it where nothing outside keeps the time."""
    neutral = timeless(model)
    wanted = frame(1 + neutral, scales(model), model.memories)
    y = tangents(wanted, measures(model), o.n, 0, 1, n_s=n_s)  # tangentRows, where it runs
    y.count[SALTATION], y.count[NEUTRAL] = 1, neutral
    y.real[GRAZING] = y.real[BLOCK] = y.real[NEXT] = np.inf
    y.real[TOLERANCE], y.real[LIMIT] = SOLVED * request.rtol, tolerated(model.structure, request.rtol)
    return {name: _packed(array) for name, array in y._asdict().items() if name not in ("rows", "w")}


def _packed(array: np.ndarray) -> int | list[Any]:
    """Length of zeros, else the values."""
    return [_plain(value) for value in array.tolist()] if array.any() else len(array)


def _plain(value: float) -> float | str:
    """A number as JSON has it: what is not finite as a word that both languages read."""
    return value if math.isfinite(value) else str(value).replace("inf", "Infinity").replace("nan", "NaN")
