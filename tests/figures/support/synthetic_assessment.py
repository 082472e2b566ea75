"""An assessment made of numbers that no motion gave."""

from __future__ import annotations

import numpy as np
import xarray as xr

import jointplay as jp
from jointplay.analysis.assessment.assess import OUTPUTS, assembled
from jointplay.analysis.assessment.edges import HOW
from jointplay.analysis.assessment.forces import SHOWN
from jointplay.analysis.labels import ended

KEYS = ("joints.B.clearance", "gear_ratio")
NAN = np.nan


def motion(names, scale=1.0, **more):
    """Answer of a motion: the peak of each joint is a whole number of newtons, its error a tenth."""
    peak = scale * np.arange(10.0, 10.0 + len(names))
    turn = np.abs(np.sin(np.linspace(0, 2 * np.pi, SHOWN + 1)))[:, None] * peak
    given = {"names": names, "force": turn, "peak": peak, "peak_error": np.full(len(names), 0.1)}
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
    """Answer of a side; brackets are 1 % on both sides of their edges."""
    edge = np.array(edges)
    codes = np.array([HOW.index(each) for each in how], dtype=float)
    found = {"edge": edge, "error": 1e-3 * edge, "low": 0.99 * edge, "high": 1.01 * edge, "how": codes}
    found |= {"back": np.array(back), "windows": windows}
    return {"status": status, "trouble": "", "limit": limit, "looked": 50} | found


SIDES = (
    side(1e-4, (1.5e-4, NAN, NAN), ("grazing", "not_met", "not_met")),
    side(3e-4, (NAN, 2.6e-4, 2.8e-4), ("not_met", "period_doubling", "bracketed"), status=2),
    side(1.5, windows=((2.5, 2.4995, 6), (2.0, 1.9998, 1))),
    side(6.0, (5.0, 4.0, 4.5), ("bracketed", "fold", "bracketed"), back=(NAN, NAN, 5.5)),
)


def assessment(now=None, **changes) -> xr.Dataset:
    """Joint B with a clearance of 0.2 mm; the present motion's answer, or `changes` of it."""
    mechanism = jp.catalog.chunmei2002(clearance=2e-4, gear_ratio=3.0)
    now = now or motion(["B", "O", "A", "C"], 2.0, **(LOOSE | changes))
    made = assembled(mechanism, KEYS, [now, motion(["O", "A", "B", "C"]), *SIDES])
    told = {"step": 0.01, "lasting_turns": 400, "lasting_share": 0.01} | ended(int(now["status"]), 0.0)
    return made.assign(OUTPUTS.variables_of(told)[0])
