"""Lyapunov exponents: convergence of their means, with error bands, and their final values."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from jointplay.display.number_text import plain, with_error
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

PER = {"turn": ("Lyapunov exponent per turn", "Turns"), "second": ("Lyapunov exponent (1/s)", "Time (s)")}
LIMIT = 0.32  # of the correlation of batch means: above it, batches are too short for their error bar
ERRORS = 3  # standard errors by which an exponent differs from 0
WIDE = 10.0  # ratio of the largest to the smallest exponent, from which the axis is logarithmic
APART = 3.2  # mm between two labels
ROW = 0.075  # of a table's height
COLUMNS = {0.0: "left", 0.68: "right", 0.99: "right"}  # right ends are numbers', left ends words'


@picture(least=140, choices={"per": PER}, checks={"exponents": partial(select.leading, "exponents")})
def lyapunov(dataset: Dataset, *, per: str | None = None, exponents: int | None = None) -> Figure:
    """Draw the running means of exponents with bands of one standard error, and a table of the final values.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.lyapunov` returned.
    per : {"turn", "second"}, optional
        What rates are counted in; turns where there are any, if left out.
    exponents : int, optional
        How many, the largest first; all if left out.
    """
    select.require(dataset, "lyapunov", ("lyapunov_exponent", "lyapunov_trace"))
    known = list(PER) if "turn_period" in dataset else ["second"]
    per = select.choice("per", per, known) if per else known[0]
    part = dataset.isel(exponent=slice(select.leading("exponents", exponents)))
    factor = float(dataset["turn_period"]) if per == "turn" else 1.0
    figure = style.sheet(180.0, 80.0)
    traces, words = figure.subplots(1, 2, width_ratios=(1.25, 1))
    trace_panel(traces, part, factor, per)
    table_panel(words, part, factor, per)
    artists.letter((traces, words))
    return artists.finish(figure, dataset)


def trace_panel(ax: Axes, dataset: Dataset, factor: float, per: str) -> None:
    """Draw a line and a band for each exponent, and the zero line."""
    finals, errors = (dataset[f"lyapunov_{name}"].values * factor for name in ("exponent", "standard_error"))
    time = dataset["block_time"].values / (factor if per == "turn" else 1.0)
    ax.axhline(0.0, color=style.GREY, linewidth=0.6, zorder=0)
    traces = [dataset[f"lyapunov_{name}"].values * factor for name in ("trace", "trace_error")]
    for mean, error in zip(*(values.T for values in traces), strict=True):
        (line,) = ax.plot(time, np.where(np.isfinite(mean), mean, np.nan))
        ax.fill_between(time, mean - error, mean + error, color=line.get_color(), alpha=0.25, linewidth=0)
    finite = finals[np.isfinite(finals)]
    if not (time.size and finite.size):
        artists.say(ax, artists.EMPTY)
        return
    vertical(ax, finals, errors)
    ax.set(xlim=(time[0], time[-1]), xlabel=PER[per][1], ylabel=PER[per][0])
    label_ends(ax, finals)


def vertical(ax: Axes, finals: np.ndarray, errors: np.ndarray) -> None:
    """Set the scale and limits of the axis by the final values, not by the first means."""
    sizes = np.abs(finals[np.isfinite(finals)])
    sure = np.abs(finals[np.abs(finals) > ERRORS * np.nan_to_num(errors)])
    sure = sure[np.isfinite(sure) & (sure > 0)]
    least = float(sure.min()) if sure.size else float(sizes.max()) or 1.0
    low, high = (float(of(finals[np.isfinite(finals)], initial=0.0)) for of in (np.min, np.max))
    if sizes.max() > WIDE * least:
        threshold = 10.0 ** math.floor(math.log10(least))
        ax.set_yscale("symlog", linthresh=threshold)
        ax.yaxis.get_major_locator().set_params(numticks=9)
        ax.set_ylim(2.5 * low - threshold if low < 0 else -threshold, 2.5 * high + threshold)
        return
    pad = 0.35 * (high - low or 1.0)
    ax.set_ylim(low - pad, high + pad)


def label_ends(ax: Axes, finals: np.ndarray) -> None:
    """Number the lines at their right ends; lines that end together share a label."""
    numbers = [number for number in range(len(finals)) if np.isfinite(finals[number])]
    heights = {n: ax.transData.transform((ax.get_xlim()[1], finals[n]))[1] for n in numbers}
    gap, groups = APART * style.MILLIMETRE * ax.figure.dpi, []
    for n in numbers:
        if groups and heights[groups[-1][-1]] - heights[n] < gap:
            groups[-1].append(n)
        else:
            groups.append([n])
    for group in groups:
        words = f"$\\lambda_{{{','.join(str(n + 1) for n in group)}}}$"
        look = {"xytext": (3, 0), "textcoords": "offset points", "va": "center", "annotation_clip": False}
        ax.annotate(words, (ax.get_xlim()[1], float(np.mean(finals[group]))), **look)


def table_panel(ax: Axes, dataset: Dataset, factor: float, per: str) -> None:
    """Write the final values with their errors, and their reliability."""
    values, errors = (dataset[f"lyapunov_{name}"].values * factor for name in ("exponent", "standard_error"))
    correlations = dataset["batch_correlation"].values
    ax.set_axis_off()
    head = ("", "per turn" if per == "turn" else "1/s", "batches")
    rows = [
        (f"$\\lambda_{{{n}}}$", with_error(value, error), correlation_words(correlation))
        for n, (value, error, correlation) in enumerate(zip(values, errors, correlations, strict=True), 1)
    ]
    artists.lines(ax, [head, *rows], COLUMNS, (1.0 - ROW, ROW), remarks(dataset, correlations), 1.35)


def correlation_words(value: float) -> str:
    """Return the correlation of batch means, marked where it is too high."""
    if not math.isfinite(value):
        return "\N{EN DASH}"
    words = f"{round(value, 2) + 0.0:.2f}".replace("-", "\N{MINUS SIGN}")
    return f"{words}*" if value > LIMIT else words


def remarks(dataset: Dataset, correlations: np.ndarray) -> list[str]:
    """Return the lines below the table."""
    lines = ["Batches: correlation of a batch mean with the next one."]
    if np.any(correlations > LIMIT):
        lines.append("*Successive batches are correlated: the error bar may be too small.")
    residual, divergence = float(dataset["sum_residual"]), float(dataset["mean_divergence"])
    if math.isfinite(residual) and divergence:
        lines.append(f"Sum of all less divergence, relative: {plain(residual / abs(divergence), 1)}")
    if "section_exponent" in dataset:
        value, error = (float(dataset[f"section_{name}"][0]) for name in ("exponent", "standard_error"))
        factor, unit = (
            (float(dataset["turn_period"]), "per turn") if "turn_period" in dataset else (1.0, "1/s")
        )
        lines.append(f"Section's map, largest: {with_error(value * factor, error * factor)} {unit}")
    if "growth" in dataset:
        growth = with_error(float(dataset["growth"]), float(dataset["growth_standard_error"]))
        lines.append(f"Twin trajectories: {growth} per turn")
        lines.append(
            f"   {plain(float(dataset['growth_difference']), 2)} standard errors from the section's map"
        )
    return lines
