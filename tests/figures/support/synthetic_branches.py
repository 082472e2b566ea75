"""Branches of periodic orbits as their analyses return them: a parabola of single orbits, a doubled one."""

import numpy as np
import xarray as xr

KINDS = ("fold", "branch_point", "period_doubling", "neimark_sacker", "grazing")


def _flags(words):
    return {
        "units": "1",
        "flag_values": np.arange(len(words), dtype=np.int8),
        "flag_meanings": " ".join(words),
    }


def branches() -> xr.Dataset:
    """A fold at point 10 of 21, half of it unstable; a doubled branch of 8 points from point 5; a jump."""
    x = np.full((2, 21), np.nan)
    x[0] = 1e-5 * (3 - np.linspace(-1, 1, 21) ** 2)
    x[1, :8] = np.linspace(x[0, 5], 2.95e-5, 8)
    y = np.full((2, 21, 2, 1), np.nan)
    y[0, :, 0, 0] = np.linspace(0, 1, 21)
    y[1, :8, :, 0] = 0.25 + np.outer(np.linspace(0, 0.2, 8), [1, -1])
    stable = np.full((2, 21), 2, np.int8)
    stable[0], stable[1, :8] = np.arange(21) <= 10, 1
    turns = np.where(np.isfinite(x), [[1.0], [2.0]], np.nan)
    multipliers = np.full((2, 21, 2, 2), np.nan)
    multipliers[0, :, 0, 0], multipliers[0, :, 1, 0] = np.linspace(0.2, 1.8, 21), 0.1
    multipliers[0, :, :, 1] = 0
    multipliers[1, :8] = [[0.3, 0.4], [0.3, -0.4]]
    jump = np.zeros((2, 21), np.int8)
    jump[0, 15] = 1
    dims, one = ("branch", "point"), {"units": "1", "long_name": "a number"}
    variables = {
        "clearance": (dims, x, {"units": "m", "long_name": "radial clearance"}),
        "eccentricity_ratio": (
            (*dims, "turn", "joint"),
            y,
            {"units": "1", "long_name": "eccentricity ratio"},
        ),
        "stable": (dims, stable, {"long_name": "stability"} | _flags(("unstable", "stable", "unknown"))),
        "period": (dims, turns, one),
        "period_time": (dims, 0.075 * turns, {"units": "s", "long_name": "period"}),
        "floquet_multiplier": ((*dims, "multiplier", "part"), multipliers, one),
        "section_jump": (dims, jump, {"long_name": "jump"} | _flags(("no", "yes"))),
        "special_kind": ("special", np.int8([0, 2, 4]), {"long_name": "kind"} | _flags(KINDS)),
        "special_branch": ("special", [0, 0, 1], one),
        "special_point": ("special", [10, 5, 6], one),
        "status": ((), np.int8(0), {"long_name": "status"} | _flags(("ok", "diverged"))),
    }
    coords = {"joint": ["B"], "part": ["real", "imaginary"], "multiplier": [1, 2]}
    attrs = {"kind": "continuation", "parameter": "clearance"}
    return xr.Dataset(variables, coords, attrs)


def curves() -> xr.Dataset:
    """A fold on a parabola, a doubling on a line that ends early, and their meeting."""
    t = np.linspace(-1, 1, 9)
    x, y = np.full((2, 9), np.nan), np.full((2, 9), np.nan)
    x[0], y[0] = 1e-5 * (3 - t**2), 3 + t
    x[1, :5], y[1, :5] = 3e-5, 3 + t[:5] / 2
    slopes = np.stack([-2e-5 * t, np.zeros(9)]), np.ones((2, 9))
    dims, one = ("curve", "point"), {"units": "1", "long_name": "a number"}
    clearance = {"units": "m", "long_name": "radial clearance"}
    kinds, ends = ("fold", "period_doubling"), ("range", "max_points")
    variables = {
        "clearance": (dims, x, clearance),
        "gear_ratio": (dims, y, {"units": "1", "long_name": "gear ratio"}),
        "clearance_tangent": (dims, slopes[0], clearance),
        "gear_ratio_tangent": (dims, slopes[1], one),
        "period": (dims, np.where(np.isfinite(x), 1.0, np.nan), one),
        "n_points": ("curve", [9, 5], one),
        "curve_kind": ("curve", np.int8([0, 1]), {"long_name": "kind"} | _flags(kinds)),
        "curve_end": (("curve", "end"), np.int8([[0, 0], [0, 1]]), {"long_name": "end"} | _flags(ends)),
        "meeting_kind": ("meeting", np.int8([0]), {"long_name": "kind"} | _flags(("fold_doubling",))),
        "meeting_clearance": ("meeting", [3e-5], clearance),
        "meeting_gear_ratio": ("meeting", [3.0], one),
        "status": ((), np.int8(0), {"long_name": "status"} | _flags(("ok", "diverged"))),
    }
    return xr.Dataset(variables, attrs={"kind": "curve", "parameters": "clearance gear_ratio"})


def orbit(*pairs, period=1.0) -> xr.Dataset:
    """One orbit with these multipliers."""
    values = np.array(pairs, dtype=float)
    with np.errstate(divide="ignore"):
        exponents = np.log(np.hypot(*values.T)) / 0.5
    stable = np.int8(np.all(np.hypot(*values.T) < 1))
    variables = {
        "floquet_multiplier": (("multiplier", "part"), values),
        "lyapunov_exponent": ("multiplier", exponents),
        "stable": ((), stable, _flags(("unstable", "stable", "unknown"))),
        "period": period,
        "period_time": 0.5 * period,
        "impacts": 2.0,
        "residual": 3e-14,
    }
    coords = {"part": ["real", "imaginary"], "multiplier": np.arange(1, len(values) + 1)}
    return xr.Dataset(variables, coords, {"kind": "periodic_orbit"})
