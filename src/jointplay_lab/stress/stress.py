"""Stress: scenes far outside ordinary use, each run twice, and the judgement of the answers.

Ranges: stiffness 10⁴ … 10¹¹ N/m, damping 0 … 10⁵ N s/m, clearance 10⁻⁷ … 3·10⁻³ m, gear ratio 0.2 … 60,
friction 0 … 1.5, links from thin and long to thick and short, dead centres and change points, starts deep in
contact, at rest, or far from the nominal speed, with and without tension and an elastic coupler; other laws
of contact, and other mechanisms with springs, loads and a run-up (`jointplay_lab.stress.others`).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import coded, column, number
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.tangents import warm_tangents
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import GROUND, Mechanism
from jointplay.solver.method.codes import COUNTERS
from jointplay_lab.stress.geometry import GEOMETRIES
from jointplay_lab.stress.motion import kick, largest_growth, move, sizes, upto
from jointplay_lab.stress.others import secant
from jointplay_lab.stress.scenes import (
    FOUR_BARS,
    STARTS,
    VARIANTS,
    Case,
    draw,
    not_drawable,
    unknown_variants,
)
from jointplay_lab.stress.verdict import CAUSES, VERDICTS, disagreement, judge

if TYPE_CHECKING:
    import xarray as xr

TIGHTER = 1e-2  # tolerance of the second run, relative to the first's
PATIENCE = 4  # steps that the second run may take, relative to the first's
GROWING = 2  # likewise with differences, relative to that without
TURNS, MAX_STEPS, LISTED = 2, 100_000, 10
LOOKED = 500  # scenes that are looked through for structures to compile
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
COUNTS = COUNTERS | {"tight_n_steps": "accepted steps of the tighter run"}
CODES = {
    "verdict": (VERDICTS, "what the two runs say"),
    "cause": (CAUSES, "what makes a scene suspect"),
    "status": (STATUS, "how the run ended"),
    "tight_status": (STATUS, "how the tighter run ended"),
}
DRAWN = {
    "stiffness": ("N m-1", "contact stiffness; of laws with a power that at a tenth of the clearance"),
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
    "contact_law": (tuple(LAWS), "law of contact of its joints with clearance"),
    "friction_law": (("none", *FRICTIONS), "law of friction of its joints with clearance"),
}
# Recorded by the study that runs a scene again
RECORD = ("mode", "penetration", "normal_velocity", "tangential_velocity", "normal_force", "energy_residual")


@analysis(not_drawable, unknown_variants, usual={"max_steps": MAX_STEPS})
def stress(
    mechanism: Moving | None = None,
    *,
    scenes: Natural,
    first: Count = 0,
    seed: Count = 0,
    variants: listed(str, f"a list of variants: {', '.join(VARIANTS)}") = FOUR_BARS,
    turns: Natural = TURNS,
    listed: Natural = LISTED,
    n_jobs: Natural | None = None,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Run scenes drawn from wide ranges, each at two tolerances, and judge the first run by the second.

    Parameters
    ----------
    mechanism : Mechanism, optional
        A motor-driven four-bar whose numbers are changed; the catalog's `chunmei2002` if left out.
    scenes, first : int
        How many, and the number of the first; the first 64 of a series are its corners.
    seed : int
        Which series.
    variants : sequence of str
        Of `VARIANTS`: what parts a scene has; one of them each.
    turns : int
        Nominal turns of each run.
    rtol : float
        Relative tolerance of the run that is judged; the second has a hundredth of it.
    max_steps : int, optional
        Attempted steps after which it stops; the second may take four times as many.
    listed : int
        How many of the slowest, and of the worst, are listed with the study lines that run them again.
    n_jobs
        As in `readings`.

    Returns
    -------
    xarray.Dataset
        Over ``scene``: ``verdict`` (flags ok, sensitive, stopped, unconfirmed, suspect: see
        `jointplay_lab.stress.verdict`), ``cause`` and ``excess`` of a suspicion, ``disagreement``,
        ``growth``, ``energy_residual``, ``scene_status``, ``tight_status``, counts, ``wall_time`` and
        ``cpu_time`` of a turn (s), the numbers drawn. Over ``rank``: ``slowest``, ``worst`` and their study
        lines. ``status`` is ok unless a scene crashed.

    Raises
    ------
    InputError
        Listing what does not fit.
    """
    printed = catalog.chunmei2002() if mechanism is None else mechanism
    limit = MAX_STEPS if motion["max_steps"] is None else motion["max_steps"]
    settings = {"seed": seed, "variants": tuple(variants), "turns": turns}
    settings |= {"rtol": motion["rtol"], "max_steps": limit}
    cells = [{"printed": printed, "number": first + k} | settings for k in range(scenes)]
    _warm(cells)
    answers = handed_out(cell, cells, motion["progress"], n_jobs)
    return dataset(printed, range(first, first + scenes), settings, answers, listed)


def cell(
    printed: Mechanism,
    number: int,
    seed: int,
    variants: tuple[str, ...],
    turns: int,
    rtol: float,
    max_steps: int,
) -> dict[str, Any]:
    """Draw one scene, run it twice, judge it."""
    case = draw(printed, number, seed, variants)
    scene = model_of(case)
    warm([scene])  # what that costs is no part of its time
    loose = move(scene, turns, rtol, max_steps)
    tight = move(scene, turns, TIGHTER * rtol, PATIENCE * max_steps)
    unit, common = sizes(scene, tight), min(loose.turns, tight.turns)

    def growth(tighter: bool, closer: int) -> float:
        if not closer:
            kicked = kick(scene, TIGHTER * rtol * unit)
            twin = move(kicked, turns, TIGHTER * rtol, PATIENCE * max_steps)
            return disagreement(upto(twin, loose), tight, unit) / (TIGHTER * rtol)
        steps, tolerance = (PATIENCE * max_steps, TIGHTER * rtol) if tighter else (max_steps, rtol)
        plain = assemble(case.mechanism, case.initial)
        return largest_growth(plain, unit, common, tolerance, GROWING * steps, closer)

    answer = asdict(judge(loose, tight, unit, (rtol, TIGHTER * rtol), growth))
    answer |= {"verdict": VERDICTS.index(answer["verdict"]), "cause": CAUSES.index(answer["cause"])}
    reached = loose.turns or math.nan
    answer |= {"status": loose.status, "turns": loose.turns} | loose.counts
    answer |= {"energy_residual": loose.residual if loose.turns else math.nan}
    answer |= {"wall_time": loose.wall_time / reached, "cpu_time": loose.cpu_time / reached}
    answer |= {"tight_energy_residual": tight.residual, "tight_status": tight.status}
    return answer | {"tight_n_steps": tight.counts["n_steps"]}


def model_of(case: Case) -> Model:
    """Assemble a scene, with the work of its parts."""
    return assemble(case.mechanism, case.initial, powers=True)


def _warm(cells: list[dict[str, Any]]) -> None:
    """Compile the scenes' structures, once each, so that workers find them on the disk."""
    drawn = (draw(*(one[key] for key in ("printed", "number", "seed", "variants"))) for one in cells[:LOOKED])
    cases = {model_of(case).structure: case for case in drawn}.values()
    warm(map(model_of, cases))
    for case in cases:
        warm_tangents(assemble(case.mechanism, case.initial))


def dataset(
    printed: Mechanism,
    numbers: Sequence[int],
    settings: dict[str, Any],
    answers: list[dict[str, Any]],
    listed: int,
) -> xr.Dataset:
    """Put a stress study together; `settings` are its cells' settings."""
    cases = [draw(printed, number, settings["seed"], settings["variants"]) for number in numbers]
    found = _of_answers(answers) | _of_cases(cases)
    found |= _listing("slowest", "cpu_time", cases, found, settings, listed)
    found |= _listing("worst", "excess", cases, found, settings, listed)
    lost = [STATUS.index(word) for word in ("bad_parameters", "crashed")]
    crashed = [answer["status"] for answer in answers if answer["status"] in lost]
    found["status"] = coded((), crashed[0] if crashed else 0, "ok unless a scene crashed", STATUS)
    scene = number("scene", np.array(numbers), "1", "number of the scene")
    attributes = {"Conventions": "CF-1.11", "kind": "stress", "seed": settings["seed"]}
    return xr.Dataset(found, {"scene": scene}, attributes)


def _of_answers(answers: list[dict[str, Any]]) -> dict[str, Any]:
    suspect, not_run = VERDICTS.index("suspect"), STATUS.index("not_run")
    found: dict[str, Any] = {}
    for key, (meanings, text) in CODES.items():
        missing = {"verdict": suspect, "tight_status": not_run}.get(key, 0)  # a scene that crashed is suspect
        name = "scene_status" if key == "status" else key
        found[name] = coded("scene", column(answers, key, missing), text, meanings)
    for key, (units, text) in NUMBERS.items():
        found[key] = number("scene", column(answers, key, math.nan), units, text)
    for key, text in COUNTS.items():
        found[key] = number("scene", column(answers, key, -1, np.int64), "1", text)
    trouble = column(answers, "trouble", "", object).astype(str)
    return found | {"trouble": ("scene", trouble, {"long_name": "what went wrong, where something did"})}


def _of_cases(cases: list[Case]) -> dict[str, Any]:
    rows = [_drawn(case) for case in cases]
    found: dict[str, Any] = {
        key: number("scene", column(rows, key, math.nan), units, text) for key, (units, text) in DRAWN.items()
    }
    for key, (meanings, text) in WORDS.items():
        codes = [meanings.index(getattr(case, key)) for case in cases]
        found[key] = coded("scene", codes, text, meanings)
    return found


def _drawn(case: Case) -> dict[str, float]:
    """The numbers of a scene that distinguish it in a figure."""
    mechanism = case.mechanism
    joint, drive = mechanism.clearance_joints[0], mechanism.drive
    speed = drive.nominal_speed if drive else case.initial["crank_speed"]
    ends = {joint.journal.link, joint.bearing.link} - {GROUND}
    mass = min(mechanism.link(name).mass for name in ends)
    K, C = (math.nan if x is None else x for x in (joint.contact.stiffness, joint.contact.damping))
    if joint.contact.law != "kelvin_voigt":
        K *= secant(joint)
    return {
        "stiffness": K,
        "damping": C,
        "clearance": joint.clearance,
        "gear_ratio": getattr(mechanism.drive, "gear_ratio", math.nan),
        "friction": joint.friction.coefficient if joint.friction else 0.0,
        "stiffness_number": math.tau * math.sqrt(K / mass) / speed,
    }


def _listing(
    word: str, key: str, cases: list[Case], found: dict, settings: dict, listed: int
) -> dict[str, Any]:
    """Scenes of the largest values, and their study files; one without a value is the worst, not slow."""
    values = np.nan_to_num(found[key][1], nan=np.inf if word == "worst" else 0.0)
    order = np.argsort(-values, kind="stable")[:listed]
    shared = {name: settings[name] for name in ("seed", "turns", "rtol", "max_steps")}
    texts = np.array([study_text(cases[i], **shared) for i in order], dtype=object).astype(str)
    numbers = np.array([cases[i].number for i in order])
    return {
        word: number("rank", numbers, "1", f"number of the {word} scenes"),
        f"{word}_lines": ("rank", texts, {"long_name": f"study files of the {word} scenes"}),
    }


def study_text(case: Case, seed: int, turns: int, rtol: float, max_steps: int) -> str:
    """Write a scene as a study file (TOML) of kind ``response``, with the settings of the stress study."""
    record = case.mechanism.model_dump(exclude_none=True)
    title = f"Scene {case.number} of seed {seed}: {case.variant}, {case.geometry}, {case.start}"
    parts = [_table("", {"kind": "response", "title": title})]
    own = {k: v for k, v in record.items() if not isinstance(v, tuple | dict)}
    own |= {"guess": record["guess"]} if record["guess"] else {}
    parts.append(_table("[mechanism]", own))
    several = ("links", "joints", "springs", "loads")
    parts += [_table(f"[[mechanism.{key}]]", one) for key in several for one in record[key]]
    parts += [_table("[mechanism.drive]", record["drive"])] if "drive" in record else []
    parts.append(_table("[integrator]", {"rtol": rtol, "max_steps": max_steps}))
    parts.append(_table("[analysis]", {"turns": turns, "record": RECORD, "initial": case.initial}))
    return "\n".join(parts)


def _table(head: str, values: Mapping[str, Any]) -> str:
    return "".join(f"{line}\n" for line in ([head] if head else []) + list(_pairs(values)))


def _pairs(values: Mapping[str, Any]) -> Iterator[str]:
    return (f"{key} = {_value(value)}" for key, value in values.items())


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value) if isinstance(value, float) else json.dumps(value)  # both as TOML writes them
