"""Calls with drawn keywords: every public function and record with right, wrong and strange values.

A call has to end in an answer with a status, or in an `InputError`; soon, and with no warning but our own.
"""

from __future__ import annotations

import inspect
import random
import re
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
import xarray as xr
from pydantic import BaseModel

import jointplay as jp
from jointplay.analysis.quantities import STATUS
from jointplay.kinds import KINDS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.changes import Changes

from .loop import MAX_STEPS, brief, tried, within
from .values import FOREIGN, MANY, OPTIONS, OWN, SEEN, STRANGE, accepted, schemas, value

mpl.use("agg")
LIMIT = 60.0  # s of CPU, a call; compiling takes most of it
MEMORY = 16 * 2**30
LOOSE = catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
IDEAL = catalog.chunmei2002(clearance=0)
BENT = LOOSE.replace(elastic=("coupler",))
GUIDED = catalog.slider_crank(clearance={"B": 1e-4, "G": 1e-4})
RIGID = catalog.flores2010()
PAIR, DUFFING, LORENZ = catalog.impact_pair(3.0, 0.8), catalog.duffing(), catalog.lorenz()
MOVING = (LOOSE, LOOSE, IDEAL, PAIR, DUFFING, LORENZ)
FOLDER = TemporaryDirectory()  # for what calls write
STORED = Path(__file__).parents[2] / "results" / "paper"
RESULTS = tuple(jp.open(STORED / f"{name}.nc") for name in ("fig10", "fig12a", "readings", "claims"))
PLACES = (
    *(f"{FOLDER.name}/a{end}" for end in (".mat", ".csv", ".html", ".png", ".gif", "")),
    "none.nc",
    "/",
    ".",
)
HELD = {  # what no file can say, by key
    "mechanism": (*MOVING, BENT, GUIDED, RIGID),
    "dataset": (*RESULTS, xr.Dataset({"a": ("time", [1.0])}), xr.Dataset(attrs={"kind": "response"})),
    "motion": RESULTS,
    "path": (*PLACES, "/none/a.csv"),
    "section": (jp.CrankAngle(angle=1.0), jp.ContactSection(joint="B"), jp.SeparationSection(joint="X")),
    "initial": ([0.1, 0.2], np.array([0.1, 0.1]), [1e300, 1.0], [10**400, 0], {"angle": None}),
    "at": (np.array([0.01]), xr.DataArray([0.0, 0.01])),
    "turns": (np.int64(2),),
    "rtol": (np.float32(1e-6),),
    "window": ("hann", ("kaiser", 3.0)),
    "links": (LOOSE.links, LOOSE.links[:1]),
    "joints": (LOOSE.joints, LOOSE.joints[::-1], LOOSE.joints[:2]),
    "drive": (LOOSE.drive, jp.ConstantSpeed(link="crank", speed=3.0)),
}
LOOPS = {"budget", "step", "seconds", "rate", "reach", "repeats", "steps", "starts", "largest", "frames"}
SHORT = {  # calls of what has no trial in its row
    "bifurcation": {"over": {"gap": [3.0]}},
    "attractors": {"region": {"y": [-1.0, 1.0], "v": [0.0, 1.0]}, "over": {"gap": [3.0]}, "carry": False},
    "assess": {"mechanism": LOOSE, "turns": 2, "transient": 2, "lyapunov_turns": 2, "reach": 1.01},
    "readings": {"panels": ["a"], "readings": ["none"], "turns": 3, "transient": 2, "growth_turns": 2},
    "claims": {"mechanism": DUFFING, "turns": 3, "transient": 2, "growth_turns": 2},
    "scheme_comparison": {"mechanism": LOOSE, "passes": 1, "repeats": 1},
    "stress": {"scenes": 1, "variants": ["none"], "turns": 1},
    "work_precision": {"tolerances": [1e-4], "peers": [], "rounds": 0, "budget": 0.01},
    "simulate": {"mechanism": LOOSE, "turns": 0.3},
    "poincare": {"mechanism": LOOSE, "turns": 0.3},
    "lyapunov": {"mechanism": LOOSE, "turns": 0.3},
    "sensitivity": {"mechanism": DUFFING, "turns": 6},
    "basins": {"mechanism": DUFFING},
    "periodic_orbit": {"transient": 5},
    "continuation": {"transient": 5},
    "curve": {"transient": 5},
    "growth": {"mechanism": DUFFING, "turns": 3, "transient": 2},
    "waveform": {"mechanism": IDEAL.replace(elastic=("coupler",)), "passes": 1, "step": 4e-5},
    "open": {"path": "none.nc"},
    "run": {"study": "none.toml"},
    "contact_stiffness": {"radius": 0.01, "clearance": 1e-4},
    "contact_data": {"radius": 0.01, "clearance": 2e-5, "pin": "steel", "bush": "POM", "length": 0.01},
    "fit": {"name": "H7/f7", "diameter": 0.02},
    "animate": {"motion": xr.Dataset(), "path": f"{FOLDER.name}/film.png"},
    "export": {"dataset": RESULTS[0], "path": f"{FOLDER.name}/result.csv"},
    "report": {"dataset": RESULTS[1], "path": f"{FOLDER.name}/result.html"},
    "Mechanism": {"links": LOOSE.links, "joints": LOOSE.joints, "drive": LOOSE.drive},
    "Joint": dict(LOOSE.joints[2]),
    "MotorLine": dict(LOOSE.drive),
    "TestSystem": dict(PAIR),
    "System": dict(catalog.jerk()),
} | {name: {"dataset": xr.Dataset()} for name in ("cell", "figure", "summary", "words")}
NO_CALLS = {"__version__", "InputError", "ModelWarning", "catalog"}
REPLACED = {"Mechanism.replace": LOOSE, "TestSystem.replace": DUFFING}


def _bases():
    """A right call of everything public, by name: its row's trial, or what its record needs."""
    found = {kind.function.__name__: {"mechanism": PAIR} | brief(name) for name, kind in KINDS.items()}
    found["readings"].pop("mechanism"), found["stress"].pop("mechanism")
    for name in {*jp.__all__} - NO_CALLS - {*found}:
        owner = getattr(jp, name)
        needed = owner.model_json_schema().get("required", ()) if _is_record(owner) else ()
        dice = random.Random(name)
        found[name] = {key: accepted(schemas(owner)[key], dice) for key in needed}
    found |= {f"catalog.{name}": dict(make.trial or {}) for name, make in catalog.NAMES.items()}
    found |= {name: {} for name in REPLACED}
    return {name: given | SHORT.get(name, {}) for name, given in found.items()}


def _is_record(owner):
    return isinstance(owner, type) and issubclass(owner, BaseModel)


CALLS = dict(sorted(_bases().items()))
WEIGHTS = [1 + 3 * name.islower() for name in CALLS]  # analyses more often than records


def found(name):
    """What is called, what it takes, and whose schemas say what is right."""
    if name in REPLACED:
        moving = REPLACED[name]
        more = [] if moving is LOOSE else [*moving.parameters, "initial", "period"]
        return moving.replace, more or list(Changes.model_fields), Changes
    owner = getattr(catalog, name[8:]) if name.startswith("catalog.") else getattr(jp, name)
    known = [key for key in inspect.signature(owner).parameters if key not in ("values", "data", "options")]
    extra = {
        "catalog.chunmei2002": [*Changes.model_fields],
        "figure": ["kind", *OPTIONS],
        "cell": ["clearance"],
    }
    return owner, [*known, *extra.get(name, ())], Changes if name == "catalog.chunmei2002" else owner


def _small(key, given, schema):
    """Whether a keyword's value cannot make a call long."""
    counts = any(each.get("maximum", 0) >= MANY for each in (schema, *schema.get("anyOf", ())))
    if not (counts or key in LOOPS) or isinstance(given, bool):
        return True
    values = given if isinstance(given, list | tuple) else [given]
    return not any(isinstance(x, int | float) and (10 < x <= 1e12 or 0 < x < 1e-6) for x in values)


def drawn(number, seed):
    """A call: name, function, arguments by position, keywords."""
    dice = random.Random(f"{seed} {number}")
    (name,) = dice.choices(list(CALLS), WEIGHTS)
    function, known, owner = found(name)
    short = {"max_steps": MAX_STEPS, "n_jobs": 1}
    always = {key: x for key, x in short.items() if key in known}
    given = always | CALLS[name]
    for key in dice.sample(known, min(len(known), dice.choice((0, 1, 1, 1, 2, 3)))):
        held = HELD.get(key, ())
        drawn = dice.choice(held) if held and dice.random() < 0.5 else _value(key, dice, owner)
        if key in short and (drawn is None or (isinstance(drawn, int) and 0 < drawn < 10**10)):
            continue  # right, but long
        if _small(key, drawn, schemas(owner).get(key, {})):
            given[key] = drawn
    if dice.random() < 0.05:
        given[dice.choice(("turms", "", "self", "1", "model_config"))] = dice.choice(STRANGE + OWN)
    if given and dice.random() < 0.05:
        given.pop(dice.choice(list(given)))
        given |= always
    positional = [dice.choice(STRANGE + OWN) for _ in range(3)] if dice.random() < 0.03 else []
    if name in ("figure", "cell") and not positional:
        positional = [given.pop("dataset", None)]
    return name, function, positional, given


def _value(key, dice, owner):
    """A value, or one as a tuple or an array."""
    known = key in schemas(owner) or key in SEEN
    drawn = value(key if known else None, dice, owner if key in schemas(owner) else None, OWN)
    if isinstance(drawn, list) and dice.random() < 0.2:
        return tuple(drawn) if dice.random() < 0.5 else _array(drawn)
    return drawn


def _array(values):
    try:
        return np.array(values)
    except (ValueError, OverflowError):
        return tuple(values)


def fault(name, function, positional, given):
    """What is wrong with how a call ended, or None; and how it ended."""

    def call():
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.simplefilter("ignore", jp.ModelWarning)
            try:
                return function(*positional, **given), None
            except jp.InputError as error:
                return None, error

    ended, raised = within(LIMIT, call)
    if raised:
        return raised, "raised"
    answer, error = ended
    if error is not None:
        if foreign := re.search(f"; {FOREIGN}.*", str(error)):
            return f"refused with{foreign[0]}", "refused"
        return (None if error.problems and str(error) else "refused without a reason"), "refused"
    return wrong_answer(name, answer), "answered"


# which give no dataset
OTHERS = ("figure", "summary", "contact_data", "contact_stiffness", "fit", "animate", "export", "report")


def wrong_answer(name, answer):
    """What is wrong with an answer; None if nothing is."""
    if not isinstance(answer, xr.Dataset):
        fine = name[0].isupper() or name.startswith("cat") or name in OTHERS
        return None if fine else f"gave {answer!r}"
    if name != "words" and not 0 <= int(answer.status) < len(STATUS):
        return f"status {answer.status.item()}"
    if name in ("sensitivity", "growth") and not int(answer.status) and "growth" in answer:
        return None if np.isfinite(answer.growth) else "ok, but growth is NaN"
    return None


def warm():
    """Compile and import what calls need, so that none is slow for that."""
    from matplotlib import pyplot  # noqa: F401

    for one in (*MOVING, BENT, GUIDED, RIGID):
        for more in ({}, {"record": ["energy_residual"] if isinstance(one, jp.Mechanism) else None}):
            jp.simulate(one, turns=0.1, **more)
        jp.lyapunov(one, turns=0.1)
    CALLS["animate"]["motion"] = jp.simulate(LOOSE, turns=0.1, record=["angle"])
    turning = {"crank_angle": [0, 1], "crank_speed": [8, 9]}
    for one in (PAIR, DUFFING, LOOSE, IDEAL):
        plane = turning if one in (LOOSE, IDEAL) else {"y": [0.0, 0.1], "v": [0.0, 0.1]}
        jp.growth(one, turns=1, transient=0)
        jp.basins(one, plane=plane, turns=4, transient=0, n_jobs=1, max_steps=9)


def shortly(value):
    """A value in a line."""
    text = "<a huge number>" if isinstance(value, int) and abs(value) > 10**30 else repr(value)
    return text.replace("\n", " ")[:120]


def main(calls=3000, seed=0, first=0):
    """Try so many calls; tell what was wrong, and how long the slowest took."""
    import resource  # of POSIX

    warm()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    def case(number):
        name, function, positional, given = drawn(number, seed)
        wrong, end = fault(name, function, positional, given)
        shown = ", ".join([*map(shortly, positional), *(f"{k}={shortly(v)}" for k, v in given.items())])
        return f"{name}({shown})", [end], wrong

    return tried("call", seed, range(first, first + calls), case)
