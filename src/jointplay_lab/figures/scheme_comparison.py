"""Scheme comparison: error of the paper's scheme after each pass, and of both methods over run time."""

from __future__ import annotations

import numpy as np

from jointplay.display.number_text import PLAIN, measure
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

MEASURES = {
    "deflection": "Error of the deflection",
    "angle": "Error of the angles",
    "force": "Error of the forces",
    "change": "Change from the pass before",
}
HIGHEST = 1e3  # of an error that is drawn: beyond it, the passes have left the solution
COLOURS, MARKERS = (style.BLACK, style.BLUE, style.AMBER, style.GREY), "osD^vP"
DASHES = ("-", (0, (4, 1.5)), (0, (1.2, 1.2)), (0, (6, 1, 1, 1)))


@picture(least=120, choices={"measure": MEASURES})
def scheme_comparison(dataset: Dataset, *, measure: str = "deflection") -> Figure:
    """Draw errors after each pass, a panel for each number of windows a turn, and errors over run times.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.scheme_comparison` returned.
    measure : {"deflection", "angle", "force", "change"}
        The error in the upper panels; the lower one shows that of the deflection.
    """
    variable = f"pass_{select.choice('measure', measure, MEASURES)}" + "_error" * (measure != "change")
    select.require(dataset, "scheme_comparison", ("case", "windows_per_turn", "pass", variable))
    styles = [look(dataset, number) for number in range(dataset.sizes["case"])]
    figure = style.sheet(180.0, 130.0)
    upper, lower = figure.subfigures(2, 1, height_ratios=(1, 1.15))
    axes = upper.subplots(1, dataset.sizes["windows_per_turn"], sharey=True, squeeze=False)[0]
    for number, ax in enumerate(axes):
        passes_panel(ax, dataset[variable].isel(windows_per_turn=number), styles)
    low, high = axes[0].get_ylim()
    axes[0].set_ylim(low, min(high, HIGHEST))  # lines beyond any meaning leave through the top
    unit = str(dataset[variable].attrs.get("units", "1"))
    axes[0].set_ylabel(artists.with_unit(MEASURES[measure], PLAIN.get(unit, unit)))
    ax, words = lower.subplots(1, 2, width_ratios=(1.35, 1))
    work_panel(ax, dataset, styles)
    artists.letter([*axes, ax])
    explain(words, dataset, styles)
    return artists.finish(figure, dataset)


def look(dataset: Dataset, number: int) -> dict:
    """Return the style of a case: colour by its clearance, dashes by its start, and a marker of its own."""
    case = dataset.isel(case=number)
    place = dict.fromkeys(("clearance", "start_turn"), number)
    for name in place:
        if name in dataset.coords:
            place[name] = int(np.unique(dataset[name].values).searchsorted(case[name].item()))
    kind = place["clearance"]
    return {
        "color": COLOURS[kind % len(COLOURS)],
        "marker": MARKERS[(kind + 3 * place["start_turn"]) % len(MARKERS)],
        "linestyle": DASHES[place["start_turn"] % len(DASHES)],
        "markersize": 3.0,
        "linewidth": 0.8,
    }


def passes_panel(ax: Axes, errors: DataArray, styles: list[dict]) -> None:
    """Draw one number of windows: a line a case, as far as its passes stay finite."""
    count = int(errors["windows_per_turn"])
    x = errors["pass"].values
    for values, one in zip(errors.transpose("case", "pass").values, styles, strict=True):
        ax.plot(x, np.where(np.isfinite(values), values, np.nan), markevery=max(1, x.size // 6), **one)
    lost = sum(not (values[-1] <= HIGHEST) for values in errors.transpose("case", "pass").values)
    if lost:
        words = f"{lost} of {len(styles)} cases\ngrow beyond measure"
        ax.text(0.97, 0.97, words, transform=ax.transAxes, ha="right", va="top", fontsize=7)
    ax.set_yscale("log")
    ax.set_xlabel("Pass")
    ax.set_xlim(x[0] - 0.5, x[-1] + 0.5)
    ax.xaxis.get_major_locator().set_params(integer=True)
    artists.heading(ax, f"{count} window{'s' * (count != 1)} per turn")


def work_panel(ax: Axes, dataset: Dataset, styles: list[dict]) -> None:
    """Draw error over run time of both methods, points of a case and method; run times scatter: no lines."""
    for method, hollow in (("scheme", True), ("monolithic", False)):
        times, errors = (
            dataset[f"{method}_{name}"].transpose("case", ...).values for name in ("run_time", "error")
        )
        for x, y, one in zip(times, errors, styles, strict=True):
            there = np.isfinite(x) & np.isfinite(y)
            alone = one | {"markerfacecolor": "white" if hollow else one["color"], "linestyle": "none"}
            ax.plot(1e3 * x[there], y[there], **alone)
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="Run time per turn (ms)", ylabel="Error of the deflection")


def cases(dataset: Dataset) -> list[str]:
    """Return the names of the cases, clearances with a prefix of their unit."""
    names = select.labels(dataset, "case")
    sizes = dataset["clearance"].values if "clearance" in dataset.coords else np.zeros(len(names))
    return [name.replace(f"{size:g} m", measure(size, "m")) for name, size in zip(names, sizes, strict=True)]


def explain(ax: Axes, dataset: Dataset, styles: list[dict]) -> None:
    """Name the cases and the two methods, in a panel of words."""
    plain = {"color": style.BLACK, "marker": "o", "markersize": 3.0, "linestyle": "none"}
    handles = [artists.sample(**one) for one in styles]
    handles += [artists.sample(**plain, markerfacecolor="white"), artists.sample(**plain)]
    names = [*cases(dataset), "scheme, in windows that settle", "all unknowns at once"]
    ax.set_axis_off()
    ax.legend(
        handles, names, loc="center left", title="One window per turn: as in the paper", alignment="left"
    )
