"""Power spectral density of a quantity, by Welch's method, with its interval of confidence.

Samples are taken evenly in time, not in crank angle. A periodic motion of period T has sharp lines at
multiples of 1/T all the same, however the crank's speed varies within the turn; where the time of a turn
itself varies, the lines broaden by that. Orders are frequencies in units of the crank's mean frequency over
the run (of a forced system, the forcing's).

The record is cut into segments that overlap by half, each freed of its mean and weighted by a window, and
their periodograms are averaged (SciPy's `welch`). References: P. D. Welch, IEEE Trans. Audio Electroacoust.
15 (1967) 70-73, for the estimate and its degrees of freedom; D. B. Percival and A. T. Walden, Spectral
Analysis for Physical Applications, Cambridge 1993, for the chi-square interval.

Validity: the interval is that of a broad spectrum; a sharp line has its height by the window's width. What
lies above half the sampling frequency is folded down: forces of contacts reach far up, so look whether the
density has fallen before the end of the axis.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import AfterValidator, Field

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs, values_of
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import Lasting, Moving, Quantity, Text, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.signals.observable import MOVED, chosen, named, series, too_few
from jointplay.analysis.simulate import simulate
from jointplay.display.errors import refuse
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.base import Natural, accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import part

USUAL, SAMPLES_PER_TURN, SEGMENTS, WINDOW = "normal_force", 512, 8, "hann"
LEVEL = 0.95  # of the interval
LEAST = 8  # samples in a segment
_WINDOW = "the name of a window of scipy.signal.get_window that needs no number"


def answer(result: xr.Dataset) -> str:
    """The frequency at which the spectrum is highest, and the size of the signal."""
    density, frequency = result["power_spectral_density"].values, result["frequency"].values
    beyond = np.isfinite(density) & (frequency > 0)
    if not beyond.any():
        segments = f" in {int(result['n_segments'])} segments" if "n_segments" in result else ""
        return f"the spectrum is not known{too_few(result, int(result.get('n_samples', 0)), segments)}"
    at = int(np.flatnonzero(beyond)[np.argmax(density[beyond])])
    place = measure(float(frequency[at]), "Hz")
    if "order" in result:
        place += f", order {plain(float(result['order'][at]), 4)}"
    variance, squared = float(result["variance"]), str(result["variance"].attrs.get("units", "1"))
    name = str(result["variance"].attrs.get("long_name", "signal")).removeprefix("variance of ")
    size = measure(math.sqrt(variance), squared[:-1] if squared.endswith("2") else "1")
    return f"{name}: highest density at {place}; standard deviation {size}"


OUTPUTS = Outputs(
    "spectrum",
    {
        "frequency": Out("frequency", "frequency", "Hz"),
        "order": Out("frequency", "frequency over that of the crank"),
        "bound": Out("bound", "end of the interval", ""),
    },
    {
        "power_spectral_density": Out(
            "frequency", "power spectral density of {name}", "{per_hertz}", "one-sided"
        ),
        "confidence_factor": Out(
            "bound",
            "95 % interval over the estimate",
            about="the true density lies between these multiples of the estimate in 95 of 100 cases",
        ),
        "degrees_of_freedom": Out((), "degrees of freedom of the estimate"),
        "variance": Out((), "variance of {name}", "{squared}"),
        "parseval_residual": Out((), "integral of the density over variance, less 1"),
        "turn_period": Out((), "mean period of a turn", "s"),
    }
    | RUN
    | {
        "n_samples": Out((), "samples"),
        "n_segments": Out((), "segments"),
        "n_least": Out((), "samples that so many segments need"),
    },
    answer,
    shown={"variance": ""},
)


def _quantity_fits(mechanism: Mechanism | TestSystem, quantity: str | None) -> None:
    chosen(mechanism, quantity, USUAL)


def _known(window: str) -> str:
    from scipy.signal import get_window

    try:
        get_window(window, LEAST)
    except (ValueError, TypeError):
        raise refuse(window, f"{_WINDOW} is accepted, as hann") from None
    return window


@analysis(
    _quantity_fits,
    rules.length_fits,
    deferred=["model", rules.samples_fit],
    outputs=OUTPUTS,
    left_out=rules.lasting(50, 100),
)
def spectrum(
    mechanism: Moving,
    *,
    quantity: Quantity | None = None,
    samples_per_turn: Annotated[Natural, Field(ge=2)] = SAMPLES_PER_TURN,
    segments: Natural = SEGMENTS,
    window: Annotated[Text, AfterValidator(_known), accepts(_WINDOW)] = WINDOW,
    **motion: Unpack[Lasting],
) -> xr.Dataset:
    """Give the power spectral density of a quantity of a motion.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    quantity : str, optional
        Quantity whose spectrum is computed, such as ``normal_force`` or ``angle:rocker``; of a test system, a
        state. By default ``normal_force`` of the first joint with clearance, or the first state.
    samples_per_turn : int
        Number of evenly spaced samples in a nominal turn.
    segments : int
        Number of half-overlapping segments whose spectra are averaged; 1 gives the periodogram of the whole
        record. More of them scatter less and resolve less.
    window : str
        Window function of `scipy.signal.get_window`.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    word, label = chosen(mechanism, quantity, USUAL)
    record = [word, "angle"] if isinstance(mechanism, Mechanism) else [word]
    history = simulate(
        mechanism,
        samples_per_turn=samples_per_turn,
        record=record,
        **motion | {"progress": part(motion["progress"], 0.0, MOVED)},
    )
    values, time = series(history, word, label), history.time.values
    rate = (len(time) - 1) / float(time[-1] - time[0]) if len(time) > 1 else math.nan
    if int(history.status) or len(values) <= LEAST * (segments + 1):
        found = missing(rate)
    else:
        found = density(values.values[:-1], rate, segments, window)
    period, of = _turn(history, mechanism), named(values)
    found |= {"order": found["frequency"] * period, "bound": ["lower", "upper"], "turn_period": period}
    found |= {"n_samples": len(values), "n_segments": segments, "n_least": LEAST * (segments + 1) + 1}
    of["per_hertz"] = "Hz-1" if of["squared"] == "1" else f"{of['squared']} Hz-1"
    return OUTPUTS.dataset(found | values_of(history, RUN), of=of, **history.attrs)


def _turn(motion: xr.Dataset, mechanism: Mechanism | TestSystem) -> float:
    """Mean time of a turn of the crank; the nominal period where that is exact, or nothing turns."""
    nominal = float(motion.turn_period_nominal)
    if not isinstance(mechanism, Mechanism) or motion.sizes["time"] < 2:
        return nominal
    angle = motion["angle"].sel(link=mechanism.crank).values
    turned = abs(angle[-1] - angle[0]) / math.tau
    exact = getattr(mechanism.drive, "kind", "") == "cycle"  # and the run may end within one
    return float(motion.time[-1] - motion.time[0]) / turned if turned > 0.5 and not exact else nominal


def density(values: np.ndarray, rate: float, segments: int, window: str) -> dict[str, Any]:
    """Welch's estimate for evenly spaced values, `rate` of them a second; keywords as in `spectrum`."""
    from scipy.signal import get_window, welch

    half = len(values) // (segments + 1)
    weights, used = get_window(window, 2 * half), values[: (segments + 1) * half]
    f, values = welch(used, rate, weights, 2 * half, half, detrend="constant")
    degrees, variance = degrees_of_freedom(weights, segments), float(np.var(used))
    return {
        "frequency": f,
        "power_spectral_density": values,
        "degrees_of_freedom": degrees,
        "confidence_factor": interval(degrees),
        "variance": variance,
        "parseval_residual": abs(float(values.sum() * f[1]) / variance - 1) if variance else 0.0,
    }


def degrees_of_freedom(weights: np.ndarray, segments: int) -> float:
    """Degrees of freedom of a mean of half-overlapping periodograms of noise: 2 for each independent one."""
    half = len(weights) // 2
    shared = float(weights[half:] @ weights[:half]) / float(weights @ weights)
    return 2 * segments / (1 + 2 * (1 - 1 / segments) * shared**2)


def interval(degrees: float) -> np.ndarray:
    """Factors by which an estimate is multiplied to give the ends of its interval."""
    from scipy.stats import chi2

    tail = (1 - LEVEL) / 2
    return degrees / chi2.ppf([1 - tail, tail], degrees)


def missing(rate: float) -> dict[str, Any]:
    """Estimate of a run that failed, or was too short: NaN at both ends of the axis."""
    names = ("power_spectral_density", "degrees_of_freedom", "confidence_factor", "variance")
    nothing = OUTPUTS.none(*names, "parseval_residual", frequency=2, bound=2)
    return nothing | {"frequency": np.array([0.0, rate / 2])}
