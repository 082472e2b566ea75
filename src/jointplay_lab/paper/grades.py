"""The rules by which the paper's four conclusions are graded, and the line of evidence for each.

Every conclusion is taken apart into checks. A ratio of two means is above 1 if it exceeds 1 by more than
`MARGIN` and its error of `ERRORS` standard errors, is not above 1 if it stays below that margin by as much,
and else is undecided. All decided checks hold: ``reproduced``; some: ``partly``; none: ``not``. Where a run
failed, or no check is decided: ``undecidable``.

peaks        with rigid links: in every panel and window, joint force and the accelerations of coupler and
             crank have larger peaks with clearance than with ideal joints
impacts      an elastic coupler lowers the peak of the joint force wherever there are impacts, at every
             damping ratio; and with ideal joints, where elasticity acts alone, it raises it
deflection   a damping ratio of 0.01 instead of 0 lowers the coupler's deflection, largest and root mean
             square, and its fast part, in both windows, with ideal joints and with clearance; and in steady
             motion its change from turn to turn
chaos        some panel is periodic from every start, and every start ends on the same points; some panel is
             chaotic from every start; and, as section 4.4 has it, those that keep contact are the periodic
             ones and those that lose it the chaotic ones

What is periodic and what chaotic is decided in `jointplay_lab.paper.character`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from jointplay.display.number_text import plain
from jointplay_lab.paper.character import MOTIONS

GRADES = ("undecidable", "not", "partly", "reproduced")
CLAIMS = {
    "peaks": "clearance raises the peaks of acceleration and joint force",
    "impacts": "elasticity alone raises the joint force, but lowers the impact peaks with clearance",
    "deflection": "structural damping reduces the deflection and makes it more regular",
    "chaos": "motion with clearance is partly periodic, partly chaotic and sensitive to the start",
}
MARGIN = 0.01  # smaller differences count as none
REGULAR = 1e-3  # a change from turn to turn below this is none: two of them are equal
ERRORS = 3
SAME = 1e-3  # clearances: two starts whose section points lie closer end on the same points


@dataclass(frozen=True)
class Ratio:
    """Ratios of means with their standard errors, arrays of one shape; NaN: nothing to compare."""

    value: np.ndarray
    error: np.ndarray

    def above(self) -> np.ndarray:
        """1 where above 1, 0 where not, NaN where undecided."""
        low, high = self.value - ERRORS * self.error, self.value + ERRORS * self.error
        return np.where(low > 1 + MARGIN, 1.0, np.where(high <= 1 + MARGIN, 0.0, np.nan))

    def below(self) -> np.ndarray:
        """1 where below 1, 0 where not, NaN where undecided."""
        low, high = self.value - ERRORS * self.error, self.value + ERRORS * self.error
        return np.where(high < 1 - MARGIN, 1.0, np.where(low >= 1 - MARGIN, 0.0, np.nan))

    def __getitem__(self, rows: np.ndarray) -> Ratio:
        return Ratio(self.value[rows], self.error[rows])

    def __str__(self) -> str:
        values = self.value[np.isfinite(self.value)]
        return f"{plain(values.min(), 3)} to {plain(values.max(), 3)}" if len(values) else "none"


def graded(claim: str, numbers: xr.Dataset) -> tuple[str, str]:
    """Grade of a conclusion (one of `GRADES`) and its evidence in one line."""
    failed = numbers["motion_status" if claim == "chaos" else "peak_status"].values.any()
    checks, evidence = _RULES[claim](numbers)
    return ("undecidable", f"a run failed; {evidence}") if failed else (grade(checks), evidence)


def grade(checks: Iterable[float]) -> str:
    """Grade from checks: 1 holds, 0 does not, NaN is undecided."""
    decided = np.array([check for check in checks if not np.isnan(check)])
    if not len(decided):
        return "undecidable"
    return "reproduced" if decided.all() else "partly" if decided.any() else "not"


def _count(checks: np.ndarray, word: str) -> str:
    decided = int(np.sum(~np.isnan(checks)))
    rest = np.size(checks) - decided
    return f"{int(np.nansum(checks))} of {decided} {word}" + (f", {rest} not told" if rest else "")


def _ratio(numbers: xr.Dataset, name: str, over: dict[str, str], under: dict[str, str]) -> Ratio:
    """Ratios of a quantity between two selections."""
    (a, b), (da, db) = (
        [numbers[word].sel(place) for place in (over, under)] for word in (name, f"{name}_error")
    )
    if name == "irregularity":
        a, b = a.clip(min=REGULAR), b.clip(min=REGULAR)
    relative = np.hypot(*xr.broadcast(da / a, db / b))
    value, error = xr.broadcast(a / b, relative * (a / b))
    return Ratio(value.values, error.values)


def _peaks(numbers: xr.Dataset) -> tuple[np.ndarray, str]:
    texts = {"peak_force": "force at B", "peak_coupler_acceleration": "coupler acceleration"}
    texts |= {"peak_crank_acceleration": "crank acceleration"}
    rigid = numbers.sel(links="rigid").transpose("window", "panel", ...)
    parts, checks = [], []
    for name, text in texts.items():
        ratio = _ratio(rigid, name, {"joints": "clearance"}, {"joints": "ideal"})
        rows = (
            f"{_plain(window)} {', '.join(plain(value, 3) for value in row)}"
            for window, row in zip(rigid.window.values, ratio.value, strict=True)
        )
        parts.append(f"{text} {', '.join(rows)}")
        checks.append(ratio.above().ravel())
    values = np.concatenate(checks)
    panels = ", ".join(map(str, numbers.panel.values))
    return values, f"clearance over ideal, panels {panels}: {'; '.join(parts)} ({_count(values, 'above 1')})"


def _plain(word: str) -> str:
    return str(word).replace("_", "-")


def _impacts(numbers: xr.Dataset) -> tuple[np.ndarray, str]:
    elastic, checks, parts = {"links": numbers.links.values[1:]}, [], []
    for joints, text in (("clearance", "with clearance, where there are impacts"), ("ideal", "ideal joints")):
        for window in numbers.window.values:
            one = numbers.sel(joints=joints, window=window).transpose("panel", ...)
            ratio = _ratio(one, "peak_force", elastic, {"links": "rigid"})
            if joints == "clearance":
                ratio = ratio[one.impacts.sel(links="rigid").values > 0]
            checks.append((ratio.below() if joints == "clearance" else ratio.above()).ravel())
            word = "below 1" if joints == "clearance" else "above 1"
            parts.append(f"{text}, {_plain(window)} {ratio} ({_count(checks[-1], word)})")
    return np.concatenate(checks), "peak force, elastic over rigid: " + "; ".join(parts)


def _deflection(numbers: xr.Dataset) -> tuple[np.ndarray, str]:
    free, damped = ({"links": f"elastic {ratio:g}"} for ratio in (0.0, 0.01))
    texts = {"peak_deflection": "largest", "rms_deflection": "root mean square", "vibration": "fast part"}
    texts |= {"irregularity": "turn-to-turn change"}
    checks, parts = [], []
    for name, text in texts.items():
        for window in numbers.window.values if name != "irregularity" else ["steady"]:
            ratio = _ratio(numbers.sel(window=window), name, damped, free)
            checks.append(ratio.below().ravel())
            parts.append(f"{text}, {_plain(window)} {ratio} ({_count(checks[-1], 'below 1')})")
    return np.concatenate(checks), "deflection, damping ratio 0.01 over 0: " + "; ".join(parts)


def _chaos(numbers: xr.Dataset) -> tuple[list[float], str]:
    motion, apart = numbers.motion.values, numbers.distance.values
    periodic, chaotic = ((motion == MOTIONS.index(word)).all(axis=1) for word in ("periodic", "chaotic"))
    kept = (numbers.separations.values == 0).all(axis=1)
    checks = [
        (periodic & (apart < SAME).all(axis=1)).any(),
        chaotic.any(),
        np.where(kept, periodic, chaotic).all(),
    ]
    evidence = "; ".join(_panel(str(panel), numbers.sel(panel=panel)) for panel in numbers.panel.values)
    return [float(check) for check in checks], evidence


def _panel(name: str, one: xr.Dataset) -> str:
    words = "/".join(sorted({MOTIONS[code] for code in one.motion.values}))
    periods = "/".join(str(p) if p else "none" for p in sorted(set(one.period.values.tolist())))
    error, apart = (plain(float(one[key].max()), 1) for key in ("growth_standard_error", "distance"))
    return (
        f"{name} {words}: losses of contact per turn {_span(one.separations)}, period {periods}, growth"
        f" per turn {_span(one.growth)} (standard error {error}), starts end {apart} clearances apart"
    )


def _span(values: xr.DataArray) -> str:
    """Smallest and largest of the starts, as one number where they do not differ."""
    return " to ".join(dict.fromkeys(plain(float(value), 3) for value in (values.min(), values.max())))


_RULES = {"peaks": _peaks, "impacts": _impacts, "deflection": _deflection, "chaos": _chaos}
