"""The answers of a stress study as one labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.evaluate import flags
from jointplay.analysis.quantities import STATUS
from jointplay.lab.stress.geometry import GEOMETRIES
from jointplay.lab.stress.lines import lines
from jointplay.lab.stress.scenes import STARTS, VARIANTS, Case, draw
from jointplay.lab.stress.verdict import CAUSES, VERDICTS
from jointplay.mechanism.records import MAIN_JOINT, Mechanism

NUMBERS = {
    "excess": ("1", "distance from what can be explained, over its bound"),
    "disagreement": ("1", "largest difference from the tighter run, in units of the states' sizes"),
    "growth": ("1", "largest growth of a small difference; NaN where it was not needed"),
    "energy_residual": ("1", "energy unaccounted for, over what flowed"),
    "tight_energy_residual": ("1", "energy unaccounted for in the tighter run, over what flowed"),
    "turns": ("1", "nominal turns reached"),
    "wall_time": ("s", "wall time of a nominal turn; NaN where none was reached"),
    "cpu_time": ("s", "processor time of a nominal turn, free of what else runs; NaN where none was reached"),
}
COUNTS = {
    "n_steps": "accepted steps",
    "n_rejected": "rejected steps",
    "n_failed": "steps that did not converge",
    "n_evaluations": "evaluations of the accelerations",
    "n_events": "events",
    "tight_n_steps": "accepted steps of the tighter run",
}
CODES = {
    "verdict": (VERDICTS, "what the two runs say"),
    "cause": (CAUSES, "what makes a scene suspect"),
    "status": (STATUS, "how the run ended"),
    "tight_status": (STATUS, "how the tighter run ended"),
}
DRAWN = {
    "stiffness": ("N m-1", "contact stiffness"),
    "damping": ("N s m-1", "contact damping"),
    "clearance": ("m", "radial clearance"),
    "gear_ratio": ("1", "gear ratio"),
    "friction": ("1", "friction coefficient"),
    "stiffness_number": ("1", "radians of contact vibration in a nominal turn"),
}
WORDS = {
    "variant": (tuple(VARIANTS), "what parts the scene has"),
    "geometry": (GEOMETRIES, "where its links lie at the start"),
    "start": (STARTS, "where its journal lies at the start"),
}


def dataset(
    printed: Mechanism,
    numbers: Sequence[int],
    settings: dict[str, Any],
    answers: list[dict[str, Any]],
    listed: int,
) -> xr.Dataset:
    """Put a stress study together; `settings` are those of its cells."""
    cases = [draw(printed, number, settings["seed"], settings["variants"]) for number in numbers]
    found = _of_answers(answers) | _of_cases(cases)
    found |= _listing("slowest", "cpu_time", cases, found, settings, listed)
    found |= _listing("worst", "excess", cases, found, settings, listed)
    crashed = [
        a["status"] for a in answers if a["status"] in map(STATUS.index, ("bad_parameters", "crashed"))
    ]
    told = {"long_name": "ok unless a scene crashed"} | flags(STATUS)
    found["status"] = ((), np.int8(crashed[0] if crashed else 0), told)
    scene = ("scene", np.array(numbers), {"units": "1", "long_name": "number of the scene"})
    return xr.Dataset(
        found, {"scene": scene}, {"Conventions": "CF-1.11", "kind": "stress", "seed": settings["seed"]}
    )


def _column(answers: list[dict[str, Any]], key: str, missing: Any, dtype: Any) -> np.ndarray:
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype)


def _of_answers(answers: list[dict[str, Any]]) -> dict[str, Any]:
    suspect, not_run = VERDICTS.index("suspect"), STATUS.index("not_run")
    found: dict[str, Any] = {}
    for key, (meanings, text) in CODES.items():
        missing = {"verdict": suspect, "tight_status": not_run}.get(key, 0)  # a scene that crashed is suspect
        name = "scene_status" if key == "status" else key
        found[name] = (
            "scene",
            _column(answers, key, missing, np.int8),
            {"long_name": text} | flags(meanings),
        )
    for key, (units, text) in NUMBERS.items():
        values = _column(answers, key, math.nan, float)
        found[key] = ("scene", values, {"units": units, "long_name": text})
    for key, text in COUNTS.items():
        found[key] = ("scene", _column(answers, key, -1, np.int64), {"units": "1", "long_name": text})
    trouble = _column(answers, "trouble", "", object).astype(str)
    return found | {"trouble": ("scene", trouble, {"long_name": "what went wrong, where something did"})}


def _of_cases(cases: list[Case]) -> dict[str, Any]:
    rows = [_drawn(case.mechanism) for case in cases]
    found: dict[str, Any] = {
        key: ("scene", np.array([row[key] for row in rows]), {"units": units, "long_name": text})
        for key, (units, text) in DRAWN.items()
    }
    for key, (meanings, text) in WORDS.items():
        codes = np.array([meanings.index(getattr(case, key)) for case in cases], dtype=np.int8)
        found[key] = ("scene", codes, {"long_name": text} | flags(meanings))
    return found


def _drawn(mechanism: Mechanism) -> dict[str, float]:
    """The numbers of a scene by which a picture tells scenes apart."""
    joint, speed = mechanism.joint(MAIN_JOINT), mechanism.drive.nominal_speed
    mass = min(mechanism.link(name).mass for name in (joint.journal.link, joint.bearing.link))
    return {
        "stiffness": joint.contact.stiffness,
        "damping": joint.contact.damping,
        "clearance": joint.clearance,
        "gear_ratio": mechanism.drive.gear_ratio,
        "friction": joint.friction.coefficient if joint.friction else 0.0,
        "stiffness_number": math.tau * math.sqrt(joint.contact.stiffness / mass) / speed,
    }


def _listing(
    word: str, key: str, cases: list[Case], found: dict, settings: dict, listed: int
) -> dict[str, Any]:
    """The scenes of the largest values, and their study lines; one without a value is the worst, not slow."""
    values = np.nan_to_num(found[key][1], nan=np.inf if word == "worst" else 0.0)
    order = np.argsort(-values, kind="stable")[:listed]
    shared = {name: settings[name] for name in ("seed", "turns", "rtol", "max_steps")}
    texts = np.array([lines(cases[i], **shared) for i in order], dtype=object).astype(str)
    numbers = np.array([cases[i].number for i in order])
    return {
        word: ("rank", numbers, {"units": "1", "long_name": f"number of the {word} scenes"}),
        f"{word}_lines": ("rank", texts, {"long_name": f"study files of the {word} scenes"}),
    }
