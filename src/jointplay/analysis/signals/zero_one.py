"""The 0-1 test for chaos, on any series.

A series phi drives a point in the plane, p + i q = sum of phi(j) exp(i c j). Where the series is regular the
point stays bounded; where it is chaotic it walks as in Brownian motion, and its mean square displacement
over n samples grows with n. K is the correlation of displacement and n, near 0 or 1, for almost every
frequency c; at resonant ones K misleads, so many are drawn at random and the median taken. Reference: G. A.
Gottwald and I. Melbourne, Proc. R. Soc. A 460 (2004) 603-611, and SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145,
whose correlation method and limits of c this is.

The displacement holds an oscillation, (mean of phi)^2 (1 - cos n c)/(1 - cos c), which is subtracted there.
Here the mean is taken from the series before, which removes that term with its cross terms.

Validity: samples must be taken once a turn or so: samples that follow closely upon each other look regular
whatever the motion. Noise counts as chaos, and that of a constant too: whether a series is one must be asked
before.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.solver.motion.looks import seen

LIMITS = (math.pi / 5, 4 * math.pi / 5)  # of the frequencies
SHARE = 10  # displacements are followed over a tenth of the series
REGULAR, CHAOTIC = 0.25, 0.75
VERDICTS = ("undecided", "regular", "chaotic")


def frequencies(count: int, seed: int) -> np.ndarray:
    """Frequencies drawn evenly from (pi/5, 4 pi/5), rad a sample, ascending."""
    return np.sort(np.random.default_rng(seed).uniform(*LIMITS, count))


def walk(series: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The path p + i q for each frequency: complex, shape (frequencies, samples)."""
    phi = np.asarray(series, dtype=float)
    n, away = 1j * np.arange(1, len(phi) + 1), phi - phi.mean()
    return np.array([np.cumsum(away * np.exp(one * n)) for one in seen(c)])


def displacement(paths: np.ndarray) -> np.ndarray:
    """Mean square displacement over 1, 2, … samples, to a tenth of the series; shape (frequencies, lags)."""
    longest = paths.shape[1] // SHARE
    kept = paths.shape[1] - longest
    moved = (paths[:, n : n + kept] - paths[:, :kept] for n in seen(range(1, longest + 1)))
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
