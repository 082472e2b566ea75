"""Datasets as the studies of the paper's statements return them."""

import numpy as np
import xarray as xr

from tests.figures.support.synthetic import STATUS, flag_words

READINGS = ("as_printed", "no_tension", "rated_torque_in_newton_metres", "lower_branch")
PANELS = {"a": (2.9e-5, 15.0), "b": (2.9e-5, 3.0), "c": (2.9e-4, 3.0)}
MOTIONS = ("undecided", "periodic", "chaotic")


def readings(points: int = 200) -> xr.Dataset:
    """Panel c a cloud, the others one point; the last reading of panel c not computed."""
    shape, dims = (len(PANELS), len(READINGS)), ("panel", "reading")
    chaotic = np.array([False, False, True])[:, None] & np.ones(shape, bool)
    lost = np.zeros(shape, bool)
    lost[-1, -1] = True
    turn = np.random.default_rng(3).uniform(0, 2 * np.pi, (*shape, points))
    spread = np.where(chaotic, 0.4, 0.0)[..., None]
    angle, size = -2.0 + spread * np.sin(turn), 1.02 - spread * np.cos(turn) ** 2

    def told(values, **attrs):
        return dims, np.where(lost, np.nan, values), {"units": "1", "long_name": "number"} | attrs

    data = {
        "separations": told(np.where(chaotic, 7.125, 1.0)),
        "impacts": told(np.where(chaotic, 7.125, 1.0)),
        "growth": told(np.where(chaotic, 0.42, -0.81)),
        "growth_standard_error": told(np.full(shape, 0.031)),
        "period": (dims, np.where(lost, -1, np.where(chaotic, 0, 1)).astype(np.int32), {"units": "1"}),
        "motion": (dims, np.where(chaotic, 2, 1).astype(np.int8), flag_words(MOTIONS, "motion")),
        "status": (dims, np.where(lost, 6, 0).astype(np.int8), flag_words(STATUS, "outcome")),
    }
    for name, values in (("section_x", size * np.cos(angle)), ("section_y", size * np.sin(angle))):
        cut = np.where(lost[..., None], np.nan, values)
        data[name] = ((*dims, "point"), cut, {"units": "1", "long_name": "journal centre over clearance"})
    coords = {
        "panel": list(PANELS),
        "reading": list(READINGS),
        "clearance": ("panel", [pair[0] for pair in PANELS.values()], {"units": "m"}),
        "gear_ratio": ("panel", [pair[1] for pair in PANELS.values()], {"units": "1"}),
    }
    return xr.Dataset(data, coords, {"kind": "readings"})


def claims() -> xr.Dataset:
    """Four conclusions, one of each grade, the longest evidence of several lines."""
    grades = ("undecidable", "not", "partly", "reproduced")
    names = ("peaks", "impacts", "deflection", "chaos")
    evidence = ["a run failed", "ratio 1.02 to 1.3", "0.7 (4 of 6 below 1)", "a: periodic 1; " * 30]
    data = {
        "grade": ("claim", np.arange(4, dtype=np.int8), flag_words(grades, "grade")),
        "evidence": ("claim", evidence, {"long_name": "the numbers"}),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    data |= {
        "ratio": (("comparison", "pair"), [[0.5, 1.2], [1.5, np.nan], [20.0, 1.0]], {"units": "1"}),
        "ratio_error": (("comparison", "pair"), [[0.01, 0.1], [0.0, np.nan], [1.0, 0.0]], {"units": "1"}),
        "ratio_holds": (("comparison", "pair"), [[1.0, np.nan], [0.0, np.nan], [1.0, 0.0]], {"units": "1"}),
        "compared": ("comparison", ["force at B, start-up", "force at B, steady", "fast part, steady"]),
        "compared_for": ("comparison", ["peaks", "peaks", "impacts"]),
        "compared_grade": ("comparison", np.int8([3, 1, 2]), flag_words(grades, "grade")),
    }
    texts = ("claim", [f"what the paper says of {name}, at some length" for name in names])
    return xr.Dataset(data, {"claim": list(names), "claim_text": texts}, {"kind": "claims"})


def schemes() -> xr.Dataset:
    """Ideal joints settle with any windows; with clearance, one window a turn grows beyond measure."""
    cases, windows, passes = (
        ("ideal joints, turn 1", "ideal joints, turn 21", "clearance, turn 1"),
        (1, 48),
        12,
    )
    number = np.arange(1, passes + 1)
    falling = np.maximum(0.3**number, 1e-4)
    growing = np.where(number < 8, 9.0**number, np.inf)
    errors = np.array([[falling, falling], [0.1 * falling, 0.1 * falling], [growing, falling]])
    dims = ("case", "windows_per_turn", "pass")
    data = {
        f"pass_{name}": (dims, errors, {"units": units})
        for name, units in (
            ("deflection_error", "1"),
            ("angle_error", "rad"),
            ("force_error", "1"),
            ("change", "1"),
        )
    }
    for method, dim, count, seconds in (("scheme", "step", 3, 0.1), ("monolithic", "tolerance", 2, 0.001)):
        size = 10.0 ** -np.arange(count) * np.array([1.0, 0.5, 2.0])[:, None]
        data[f"{method}_error"] = (("case", dim), 1e-2 * size, {"units": "1"})
        data[f"{method}_run_time"] = (("case", dim), seconds / size, {"units": "s"})
    data["status"] = ((), np.int8(0), flag_words(STATUS, "outcome"))
    coords = {
        "case": list(cases),
        "windows_per_turn": list(windows),
        "pass": number,
        "clearance": ("case", [0.0, 0.0, 2.9e-5], {"units": "m"}),
        "start_turn": ("case", [0, 20, 0]),
    }
    return xr.Dataset(data, coords, {"kind": "scheme_comparison"})
