"""An assessment made of numbers that no motion gave."""

from __future__ import annotations

import numpy as np
import xarray as xr

import jointplay as jp
from jointplay.analysis.assessment.assess import OUTPUTS, assembled
from jointplay.analysis.assessment.curves import VALUES, ratios
from jointplay.analysis.assessment.edges import HOW
from jointplay.analysis.assessment.forces import SHOWN
from jointplay.analysis.assessment.page import BY
from jointplay.analysis.labels import ended

KEYS = ("joints.B.clearance", "gear_ratio")
NAN = np.nan


def motion(names, scale=1.0, **more):
    """Answer of a motion: the peak of each joint is a whole number of newtons, its error a tenth."""
    peak = scale * np.arange(10.0, 10.0 + len(names))
    turn = np.abs(np.sin(np.linspace(0, 2 * np.pi, 2 * SHOWN + 1)))[:, None] * peak
    given = {
        "names": names,
        "force": turn,
        "peak": peak,
        "peak_error": np.full(len(names), 0.1),
    }
    given |= {"section_exponent_per_turn": NAN, "section_standard_error_per_turn": NAN}
    given |= {"period": 1, "turn_period": 0.1, "drive_work": 0.031, "joint_work": 0.03}
    return {"status": 0, "trouble": ""} | given | more


LOOSE = {
    "separations": np.array([2.0]),
    "impacts": np.array([2.0]),
    "contact_fraction": np.array([0.9]),
    "impact_speed": np.array([0.05]),
    **{name: np.array([value]) for name, value in (("impact_loss", 0.01), ("friction_loss", 0.02))},
    **{f"{name}_error": np.array([1e-4]) for name in ("impact_loss", "friction_loss", "sliding_work")},
    "sliding_work": np.array([0.4]),
    "traits": np.array([1, 0, 0]),
}


def side(limit, edges=(NAN, NAN, NAN), how=("not_met",) * 3, status=0, back=(NAN, NAN, NAN), windows=()):
    """Answer of a side; brackets are 1 % on both sides of edges. Beyond half the values period 2 is met."""
    edge = np.array(edges)
    codes = np.array([HOW.index(each) for each in how], dtype=float)
    found = {"edge": edge, "error": 1e-3 * edge, "low": 0.99 * edge, "high": 1.01 * edge, "how": codes}
    begin = 2e-4 if limit < 0.1 else 3.0
    found |= {"back": np.array(back), "windows": windows, "looked": np.geomspace(begin, limit, 51)[1:]}
    found |= {"traits": np.tile([True, False, False], (50, 1)), "periods": np.repeat([1, 2], 25)}
    found["states"] = np.zeros((50, 0))
    return {"status": status, "trouble": "", "limit": limit} | found


SIDES = (
    side(1e-4, (1.5e-4, NAN, NAN), ("grazing", "not_met", "not_met")),
    side(3e-4, (NAN, 2.6e-4, 2.8e-4), ("not_met", "period_doubling", "bracketed"), status=2),
    side(1.5, windows=((2.5, 2.4995, 6), (2.0, 1.9998, 1))),
    side(6.0, (5.0, 4.0, 4.5), ("bracketed", "fold", "bracketed"), back=(NAN, NAN, 5.5)),
)
NAMES = ["B", "O", "A", "C"]


def hung(count):
    """Answer of the variants: the force is 20 N, and 2 N more of each; contact is lost from the third on."""
    each = np.arange(count)
    peak = 20.0 + 2 * each[:, None] + np.array([0.0, 0.0, 0.0, 0.0])
    texts = {
        "quantity": np.full(count, "x"),
        "change": np.full(count, "x"),
        "statuses": np.zeros(count, dtype=int),
    }
    numbers = {"period": np.ones(count), "lost": each > 1, "peak": peak}
    numbers |= {"separations": 1.0 * (each > 1)[:, None], "impact_speed": 0.02 * (each > 1)[:, None]}
    return {"status": 0, "trouble": "", "names": NAMES} | texts | numbers


def curved(key, far=NAN, settled=1):
    """Answer of a curve: the force over ideal ones is 1 below the present value, and its ratio above.

    The grade changes at `far` times the present value, where a motion has `settled`; or none repeats.
    """
    ratio = ratios(key)
    peak = np.maximum(ratio, 1.0)[:, None] * np.array([12.0, 10.0, 11.0, 13.0])
    values = {
        "names": NAMES,
        "ratio": ratio,
        "peak": peak,
        "ideal": np.tile([12.0, 10.0, 11.0, 13.0], (VALUES, 1)),
    }
    lost = ratio > 1.2
    values |= {
        "lost": lost,
        "grade": 2.0 * lost,
        "period": np.where(ratio > far, settled, 1),
        "statuses": np.zeros(VALUES, dtype=int),
    }
    values |= {"impact_speed": 0.05 * lost[:, None]}
    before, after = (
        [1 / far, 1, 0, 20.0, 1.6, 0.05, 1],
        [far, 3, 1, 30.0, 3.1, 0.12, BY.index("values" if settled else "unsettled")],
    )
    never = [ratio[0], 1, NAN, NAN, NAN, NAN, 1], [NAN] * 7
    return {"status": 0, "trouble": ""} | values | {"change": np.array([never, [before, after]])}


def assessment(now=None, sides=SIDES, settled=1, mechanism=None, **changes) -> xr.Dataset:
    """Joint B with a clearance of 0.2 mm; the present motion's answer, or `changes` of it."""
    mechanism = mechanism or jp.catalog.chunmei2002(clearance=2e-4, gear_ratio=3.0)
    now = now or motion(NAMES, 2.0, **({"motion": {"radius": 0.5}} | LOOSE | changes))
    over = [curved(KEYS[0], 1.4, settled), curved(KEYS[1], 2.0)]
    made = assembled(mechanism, KEYS, now, motion(["O", "A", "B", "C"]), hung(6), over, sides)
    told = {"step": 0.01, "lasting_turns": 400, "lasting_share": 0.01} | ended(int(now["status"]), 0.0)
    return made.assign(OUTPUTS.variables_of(told)[0])
