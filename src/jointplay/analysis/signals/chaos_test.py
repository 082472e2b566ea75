"""The 0-1 test for chaos on section samples of a motion: median and spread over many frequencies.

A series phi drives a point in the plane, p + i q = sum of phi(j) exp(i c j). Where the series is regular the
point stays bounded; where it is chaotic it walks as in Brownian motion, and its mean square displacement
over n samples grows with n. K is the correlation of displacement and n, near 0 or 1, for almost every
frequency c; at resonant ones K misleads, so many are drawn at random and the median taken. Reference: G. A.
Gottwald and I. Melbourne, Proc. R. Soc. A 460 (2004) 603-611, and SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145,
whose correlation method and limits of c this is.

The displacement holds an oscillation, (mean of phi)^2 (1 - cos n c)/(1 - cos c), which is subtracted there.
Here the mean is taken from the series before, which removes that term with its cross terms.

Validity: samples are section points, one a turn or so: those that follow closely upon each other look regular
whatever the motion. Noise counts as chaos, and that of a constant too: whether a series is one must be asked
before.
"""

from __future__ import annotations

import math
from typing import Any, Unpack

import numpy as np

from jointplay.analysis.declared import Outputs, values_of
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import Cut, Moving, Quantity, Share, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.poincare import poincare
from jointplay.analysis.rules import section_fits
from jointplay.analysis.signals.observable import MOVED, chosen, named, series, too_few
from jointplay.analysis.simulate import simulate
from jointplay.display import codes
from jointplay.display.number_text import MINUS
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import part, ticked

USUAL, FREQUENCIES, TOLERANCE = "journal_x", 100, 1e-4
RTOL = 1e-10  # noise of a periodic motion then stays below the tolerance, also of small quantities
LEAST = 100  # samples that can be judged
QUARTILES = (0.25, 0.5, 0.75)
JUDGED = ("chaos_indicator", "chaos_indicator_quartile", "chaos_indicator_half", "sample_spread", "verdict")
LIMITS = (math.pi / 5, 4 * math.pi / 5)  # of the frequencies
SHARE = 10  # displacements are followed over a tenth of the series
REGULAR, CHAOTIC = 0.25, 0.75
VERDICTS = ("undecided", "regular", "chaotic")


def answer(result: xr.Dataset) -> str:
    """K with its quartiles, and the test's verdict."""
    quartiles = result["chaos_indicator_quartile"]
    low, middle, high = (float(quartiles.sel(quartile=q)) for q in QUARTILES)
    if math.isnan(middle):
        return f"K of the 0-1 test is not known{too_few(result, result.sizes['turn'])}"
    verdict, ends = str(codes.words(result["verdict"]).item()), f"quartiles {low:.3f} to {high:.3f}"
    line = f"0-1 test: {verdict}, " + f"K = {middle:.3f} ({ends})".translate(MINUS)
    if verdict == "chaotic":
        line += "\nthe test has no error bar; a Lyapunov exponent decides (kind = 'lyapunov')"
    return line


OUTPUTS = Outputs(
    "chaos_test",
    {
        "turn": Out("turn", "section point"),
        "test_frequency": Out("test_frequency", "frequency of the test, a sample", "rad"),
        "quartile": Out("quartile", "share of frequencies below"),
        "lag": Out("lag", "samples between two points"),
    },
    {
        "sample": Out("turn", "{name}", "{units}"),
        "chaos_indicator": Out("test_frequency", "K of the 0-1 test"),
        "chaos_indicator_quartile": Out("quartile", "quartile of K", at={"quartile": 0.5}),
        "chaos_indicator_half": Out(
            (), "median of K, first half of the samples", about="how far from settled it is"
        ),
        "walk_x": Out("turn", "driven point, p", "{units}", "at the frequency of the median"),
        "walk_y": Out("turn", "driven point, q", "{units}"),
        "walk_frequency": Out((), "frequency of the driven point, a sample", "rad"),
        "square_displacement": Out("lag", "mean square displacement of the driven point", "{squared}"),
        "sample_spread": Out((), "spread of the samples over their size"),
        "n_least": Out((), "samples that are needed for a verdict"),
        "verdict": Out(
            (),
            "verdict",
            about=f"chaotic: lower quartile above {CHAOTIC}; regular: upper quartile below {REGULAR}",
            flags=VERDICTS,
            missing="undecided",
        ),
    }
    | RUN,
    answer,
    "verdict",
    shown={"chaos_indicator_quartile": "median K of the 0-1 test"},
)


def _quantity_fits(mechanism: Mechanism | TestSystem, quantity: str | None) -> None:
    chosen(mechanism, quantity, USUAL)


@analysis(_quantity_fits, deferred=[section_fits, "model"], usual={"rtol": RTOL}, outputs=OUTPUTS)
def chaos_test(
    mechanism: Moving,
    *,
    quantity: Quantity | None = None,
    every: Natural = 1,
    frequencies: Natural = FREQUENCIES,
    seed: Count = 0,
    tolerance: Share = TOLERANCE,
    **motion: Unpack[Cut],
) -> xr.Dataset:
    """Test a motion for chaos by the 0-1 test on its section samples.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    quantity : str, optional
        Quantity that is sampled, such as ``normal_force`` or ``angle:rocker``; it has to be bounded. By
        default ``journal_x`` of the first joint with clearance; of a test system, the first state.
    every : int
        Only one in so many section points is kept. Where points hop between bands that are chaotic inside,
        the hopping hides the chaos unless only one band is looked at.
    frequencies : int
        Number of random frequencies at which the test is made.
    seed : int
        Seed of the random numbers from which the frequencies are drawn.
    tolerance : float
        Samples that spread less than this fraction of the quantity's largest value in a turn count as one
        point.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    word, label = chosen(mechanism, quantity, USUAL)
    run = motion | {"record": [word], "progress": part(motion["progress"], 0.0, MOVED)}
    points = poincare(mechanism, **run)
    samples = series(points, word, label).isel(turn=slice(None, None, every))
    c = drawn_frequencies(frequencies, seed)
    values = {"turn": samples["turn"].values, "sample": samples.values, "n_least": np.int64(LEAST)}
    values |= {"test_frequency": c, "quartile": np.array(QUARTILES)}
    if int(points.status) or samples.size < LEAST or not np.all(np.isfinite(samples)):
        values |= OUTPUTS.none(*JUDGED, test_frequency=len(c), quartile=len(QUARTILES))
    else:
        turn = simulate(mechanism, **run | {"turns": 1, "section": None, "progress": None})
        scale = float(np.max(np.abs(series(turn, word, label).values), initial=0.0))
        values |= _judged(samples.values, scale, c, tolerance)
    values |= _walk(samples.values, values, c) | values_of(points, RUN)
    return OUTPUTS.dataset(values, of=named(samples), **points.attrs)


def _judged(samples: np.ndarray, scale: float, c: np.ndarray, tolerance: float) -> dict[str, Any]:
    """K, its quartiles, the median of the first half, the verdict; of a constant, K is 0."""
    scale = max(scale, float(np.max(np.abs(samples))))
    spread = float(np.ptp(samples)) / scale if scale else 0.0
    constant = spread <= tolerance
    K, half = (
        np.zeros(len(c)) if constant else indicators(part, c)
        for part in (samples, samples[: len(samples) // 2])
    )
    quartiles = np.quantile(K, QUARTILES)
    found = (K, quartiles, np.median(half), spread, verdict(quartiles))
    return dict(zip(JUDGED, found, strict=True))


def _walk(samples: np.ndarray, judged: dict[str, Any], c: np.ndarray) -> dict[str, Any]:
    """The driven point at the frequency whose K is next to the median."""
    away = np.abs(judged["chaos_indicator"] - judged["chaos_indicator_quartile"][1])
    typical = c[int(np.argmin(away)) if np.all(np.isfinite(away)) else 0]
    path = walk(samples, np.array([typical])) if samples.size else np.zeros((1, 0))
    grown = displacement(path)[0]
    found = {"walk_x": path[0].real, "walk_y": path[0].imag, "walk_frequency": typical}
    return found | {"square_displacement": grown, "lag": np.arange(1, len(grown) + 1)}


def drawn_frequencies(count: int, seed: int) -> np.ndarray:
    """Frequencies drawn evenly from (pi/5, 4 pi/5), rad a sample, ascending."""
    return np.sort(np.random.default_rng(seed).uniform(*LIMITS, count))


def walk(series: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The path p + i q for each frequency: complex, shape (frequencies, samples)."""
    phi = np.asarray(series, dtype=float)
    n, away = 1j * np.arange(1, len(phi) + 1), phi - phi.mean()
    return np.array([np.cumsum(away * np.exp(one * n)) for one in ticked(c)])


def displacement(paths: np.ndarray) -> np.ndarray:
    """Mean square displacement over 1, 2, … samples, to a tenth of the series; shape (frequencies, lags)."""
    longest = paths.shape[1] // SHARE
    kept = paths.shape[1] - longest
    moved = (paths[:, n : n + kept] - paths[:, :kept] for n in ticked(range(1, longest + 1)))
    return np.array([np.mean(np.abs(each) ** 2, axis=1) for each in moved]).reshape(longest, len(paths)).T


def indicators(series: np.ndarray, c: np.ndarray) -> np.ndarray:
    """K for each frequency: the correlation of the mean square displacement with the number of samples.

    Parameters
    ----------
    series : ndarray, shape (samples,)
        At least 20 samples of a bounded quantity without a trend, which is not constant.
    c : ndarray
        Frequencies, rad a sample.
    """
    grown = displacement(walk(series, c))
    away, lags = grown - grown.mean(axis=1, keepdims=True), np.arange(grown.shape[1], dtype=float)
    lags -= lags.mean()
    return away @ lags / np.sqrt(np.sum(away**2, axis=1) * np.sum(lags**2))


def verdict(quartiles: np.ndarray) -> int:
    """Index into `VERDICTS` by quartiles of K: chaotic if all lie above 0.75, regular if all below 0.25."""
    if quartiles[0] > CHAOTIC:
        return VERDICTS.index("chaotic")
    if quartiles[2] < REGULAR:
        return VERDICTS.index("regular")
    return VERDICTS.index("undecided")
