"""Stress: scenes far outside ordinary use, each run twice, and what that says of the answers.

Ranges: stiffness 10⁴ … 10¹¹ N/m, damping 0 … 10⁵ N s/m, clearance 10⁻⁷ … 3·10⁻³ m, gear ratio 0.2 … 60,
friction 0 … 1.5, links from thin and long to thick and short, dead centres and change points, starts deep in
contact, at rest, or far from the nominal speed, with and without tension and an elastic coupler; other laws
of contact, and other mechanisms with springs, loads and a run-up (`jointplay_lab.stress.others`).
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Unpack

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.tangents import warm_tangents
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism
from jointplay_lab.stress.motion import kick, largest_growth, move, sizes, upto
from jointplay_lab.stress.scenes import FOUR_BARS, VARIANTS, Case, draw, not_drawable, unknown_variants
from jointplay_lab.stress.stress_dataset import dataset
from jointplay_lab.stress.verdict import CAUSES, VERDICTS, disagreement, judge

if TYPE_CHECKING:
    import xarray as xr

TIGHTER = 1e-2  # tolerance of the second run, relative to the first's
PATIENCE = 4  # steps that the second run may take, relative to the first's
GROWING = 2  # likewise with differences, relative to that without
TURNS, MAX_STEPS, LISTED = 2, 100_000, 10
LOOKED = 500  # scenes that are looked through for structures to compile


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
