"""Overview of a response: force history, journal orbit, phase portrait and Poincaré section on one sheet."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from xarray import Dataset

from jointplay.figures.drawing import artists, select, style, timebase, window_panels
from jointplay.figures.motion.journal_orbit import orbit_panel
from jointplay.figures.motion.phase_portrait import portrait_panel
from jointplay.figures.motion.poincare_section import counted, journal_points
from jointplay.figures.motion.time_history import history_panel, legends
from jointplay.figures.registry import picture


@picture(needs=("normal_force", "journal_x", "journal_y", "eccentricity", "normal_velocity"), clearance=True)
def overview(dataset: Dataset, *, joint: str | None = None, turns: float | Sequence[float] = 3) -> Figure:
    """Draw four pictures of one clearance joint.

    Parameters
    ----------
    dataset : Dataset
        A response of a mechanism with clearance.
    joint : str, optional
        The joint; by default the first with clearance.
    turns : float or pair
        Window of the first three pictures: the last so many turns, or [first, last]. The section is whole.
    """
    if not select.labels(dataset, "joint") or "time" not in dataset.dims:
        expected = "a response of a mechanism with clearance; else one of the other kinds"
        raise select.refuse("kind", "overview", expected)
    joint = select.label(dataset, "joint", joint)
    part = window_panels.last(timebase.window(dataset, turns))
    figure = style.sheet(180.0, 122.0)
    axes = figure.subplot_mosaic("aaa;bcd", height_ratios=(1, 1.15))
    force(axes["a"], dataset, part, joint)
    orbit_panel(axes["b"], part, joint, "(b)")
    portrait_panel(axes["c"], part, None, None, None, joint, titles=("(c)",))
    axes["c"].set_box_aspect(1)
    for key in "bd":
        axes[key].locator_params(nbins=4)  # narrow panels
    section(axes["d"], dataset, joint)
    artists.shared_legend(figure, (axes["b"], axes["c"]), 4)
    return artists.finish(figure, dataset)


def force(ax: Axes, dataset: Dataset, part: Dataset, joint: str) -> None:
    """Draw the normal force of the window."""
    bases = timebase.bases(dataset, part["time"].values, None)
    array = select.variable(part, "normal_force").sel(joint=[joint])
    history_panel(ax, array, bases[0], named=False)
    legends([ax])
    timebase.dress(ax, ax, bases)
    artists.heading(ax, "(a)", beside_top_axis=len(bases) > 1)


def section(ax: Axes, dataset: Dataset, joint: str) -> None:
    """Draw the section that the run kept, or a note that it kept none."""
    if "turn" in dataset.dims:
        journal_points(ax, dataset, joint, False, "(d)", counted(dataset))
        return
    artists.say(ax, "This run kept no Poincaré section")
    ax.set_box_aspect(1)
    artists.heading(ax, "(d)")
