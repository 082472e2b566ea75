"""Elements of several figures: curves with gaps, paths with contact, point clouds, labels, notes.

Powers of ten of an axis stand in its label, beside the unit, and never over a title or a tick.

Tables as pictures: cells in mm on a bare page, shaded from white to dark grey.

Paths drawn smoothly: through samples over time, and through points with tangents.

Between samples stand modified Akima splines, which do not overshoot at kinks. A contact vibrates many times a
turn. At ten samples an oscillation straight lines miss the path by 5 % of the amplitude, the splines by 1 %;
samples themselves are not moved. SciPy has the same splines, but its module of interpolation takes longer to
import than a picture to draw. Source: Akima, Journal of the ACM 17 (1970); the weights are those of his
method's modified form. Between points with tangents stand cubics, which meet smoothly.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from string import ascii_lowercase
from textwrap import fill

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import PLAIN, RAISED, Shown, shown
from jointplay.figures.drawing import (
    Axes,
    Axis,
    DataArray,
    Dataset,
    Figure,
    FigureBase,
    Line2D,
    Patch,
    select,
    style,
)
from jointplay.figures.drawing.style import Panel

LONGEST, NARROW = 34, 26  # characters before a label, or a heading, breaks
BESIDE_TOP_AXIS = 15.5  # pt: how high a heading stands where a second axis has its numbers
DENSE = 3000  # samples of a path, from which it is drawn thinner
SEEN = 1e-4  # of the radius of the clearance circle: what a print cannot show
LONGEST_PERIOD = 16
SCATTER = 50.0  # half an axis over the scatter of points that are one
PLAIN_PATH = {"color": style.BLACK, "linewidth": 0.6, "label": "path (modes not recorded)"}
EMPTY = "No samples in this run"
NOTE = 7.0  # mm of height for the status of the run
DOUBT = 0.12  # of a panel's height for a line above the curves
EXPLAINED = {
    "diverged": "the solution grew beyond bounds",
    "step_limit": "the step limit was reached",
    "chatter": "contacts followed each other ever faster",
    "not_converged": "an iteration did not converge",
    "bad_parameters": "the parameters cannot be simulated",
    "crashed": "the computation crashed",
    "not_run": "it has not been run",
    "interrupted": "it was stopped before its end",
    "no_derivative": "the motion has no derivative",
    "jammed": "rigid contacts had no answer",
}
POWER = re.compile(r"^1e([−\d]+)$")  # as matplotlib writes it
UNIT = re.compile(r"\(([^()]*)\)$")  # that a label ends with
DARKEST = 0.62  # of black: how dark a cell of shade 1 is
TEXT, BESIDE = 6.5, 7.0  # pt
PAD = 1.0  # mm above and below

BETWEEN = 8  # pieces of an interval in which the path bends
BENT = np.deg2rad(4.0)  # between neighbouring lines, in a square panel that the path fills
FLAT = 1e-9  # of the largest weight: below it all lines around a point are level
MOST = 20_000  # samples; a longer path is dense enough


def curve(ax: Axes, x: np.ndarray, y: np.ndarray, **look) -> Line2D:
    """Draw y over x; samples without neighbours, which a line would not show, become dots."""
    there = np.isfinite(x) & np.isfinite(y)
    alone = np.flatnonzero(there & ~neighbours(there)).tolist()
    look = {"linewidth": 0.8, "rasterized": x.size > style.VERTEX_LIMIT} | look
    dots = {"marker": "o", "markersize": 1.5 * look["linewidth"], "markevery": alone} if alone else {}
    (line,) = ax.plot(x, y, **look, **dots)
    return line


def neighbours(mask: np.ndarray) -> np.ndarray:
    """Return which samples stand directly before or after a marked one."""
    adjacent = np.zeros_like(mask)
    adjacent[:-1] |= mask[1:]
    adjacent[1:] |= mask[:-1]
    return adjacent


def path(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    contact: np.ndarray | None,
    times: np.ndarray | None = None,
    touches: Callable | None = None,
    flight: float = 0.0,
) -> None:
    """Draw the path (x, y): free flight light and thin, contact dark and thick; plain if unknown.

    With the samples' times it is smooth in between; `touches` is as in `smooth`. Flights that are too short
    to be seen so are drawn `flight` points wide.
    """
    if not x.size:
        say(ax, EMPTY)
    thin = 1.0 if x.size < DENSE else 0.6
    if times is not None:
        touching = np.zeros(x.shape, dtype=bool) if contact is None else contact
        x, y, touching = smooth(times, x, y, touching, touches)
        contact = None if contact is None else touching
    if contact is None:
        curve(ax, x, y, **PLAIN_PATH)
        return
    free = ~contact
    joined = free | neighbours(free)  # flight is drawn up to the contact samples
    for where, look in ((joined, style.IN_FLIGHT), (contact, style.IN_CONTACT)):
        width = thin * look["linewidth"] if where is contact else max(thin * look["linewidth"], flight)
        changes = {"linewidth": width, "label": look["label"] if where.any() else "_"}
        curve(ax, x, np.where(where, y, np.nan), **(look | changes))


def cloud(ax: Axes, x: np.ndarray, y: np.ndarray) -> Line2D:
    """Draw points, the smaller the more of them stand apart, embedded as an image in vector files."""
    apart = spots(x, y)
    size = 2.4 if apart < 300 else 0.9 if apart < 5000 else 0.5
    look = {"color": style.BLACK, "markersize": size, "markeredgewidth": 0, "rasterized": True}
    return ax.plot(x, y, "o", linestyle="none", **look)[0]


def spots(x: np.ndarray, y: np.ndarray) -> int:
    """Count the cells, a thousandth of the points' size each, that hold points: a fixed point is one."""
    points = np.stack([x, y], -1)[np.isfinite(x) & np.isfinite(y)]
    size = np.max(np.abs(points), axis=0, initial=1e-300)
    return len(np.unique(np.round(points / size * 1e3), axis=0))


def clearance_circle(ax: Axes, reach: float) -> None:
    """Draw the clearance circle, of radius 1, and set limits around it and the farthest point, at `reach`."""
    from matplotlib.patches import Circle
    from matplotlib.ticker import MaxNLocator

    look = {"facecolor": style.DISC, "edgecolor": style.GREY, "linewidth": 0.6, "zorder": 0}
    ax.add_patch(Circle((0, 0), 1, label="clearance circle", **look))
    half = 1.08 * max(1.0, reach)
    ax.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def sample(**look) -> Line2D:
    """Return a line, or a marker, for a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **look)


def swatch(**look) -> Patch:
    """Return an area for a legend."""
    from matplotlib.patches import Patch

    return Patch(**look)


def shared_legend(figure: Figure, axes: Iterable[Axes], columns: int | None = None) -> None:
    """Put one legend, usually a row, below the figure for all that some panels name, each name once."""
    handles = {}
    for ax in axes:
        handles |= dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=columns or len(handles) or 1
    )


def axis_label(array: DataArray, unit: Shown) -> str:
    """Return `array`'s name with its display unit."""
    return with_unit(select.title(array), unit.symbol)


def capital(words: str) -> str:
    """Return words as they begin a label."""
    return words[:1].upper() + words[1:]


def with_unit(words: str, symbol: str) -> str:
    """Return words with the symbol of a unit, if there is one."""
    return words if symbol in PLAIN.values() else f"{words} ({symbol})"


def broken(label: str, longest: int = LONGEST) -> str:
    """Return a label in lines of at most so many characters; its unit never stands alone on one."""
    unit = UNIT.search(label)
    start = unit.start() - 1 if unit else len(label)
    kept = label[start:].replace(" ", "\N{NO-BREAK SPACE}")
    return fill(label[:start] + kept, longest).replace("\N{NO-BREAK SPACE}", " ")


def name_axes(ax: Axes, x: DataArray, x_unit: Shown, y: DataArray, y_unit: Shown) -> None:
    """Label both axes with their quantity and its unit."""
    ax.set_xlabel(broken(axis_label(x, x_unit)))
    name_y(ax, y, y_unit)
    if x_unit.symbol == "deg":
        in_degrees(ax.xaxis)


def name_y(ax: Axes, y: DataArray, unit: Shown, longest: int = LONGEST) -> None:
    """Label the y axis, broken where it would be longer than the panel is high."""
    ax.set_ylabel(broken(axis_label(y, unit), longest))
    if unit.symbol == "deg":
        in_degrees(ax.yaxis)


def in_degrees(axis: Axis) -> None:
    """Put ticks at round parts of a turn on an axis."""
    from jointplay.figures.drawing.derived import Degrees

    axis.set_major_locator(Degrees())


def displayed(array: DataArray, unit: Shown | None = None) -> tuple[np.ndarray, Shown]:
    """Return the values of `array` in its display unit, or in `unit`, and that unit."""
    if unit is None:
        others = (other[array.name].values for other in style.same_sheet() if array.name in other)
        values = np.concatenate([np.ravel(each) for each in (array.values, *others)])
        unit = shown(values, str(array.attrs.get("units", "")))
    return array.values * unit.factor, unit


def valued(axis: DataArray) -> str:
    """Return the name and the one value of a parameter."""
    value, unit = displayed(axis)
    symbol = "" if unit.symbol == PLAIN["1"] else f" {unit.symbol}"
    return f"{select.title(axis)} {float(value):.4g}{symbol}"


def roomy(ax: Axes, x: np.ndarray, y: np.ndarray, one: bool = False) -> None:
    """Set limits around points; ones narrower than 0.1 % of their size, or said to be one, as a point."""
    for values, set_limits in ((x, ax.set_xlim), (y, ax.set_ylim)):
        values = values[np.isfinite(values)]
        if values.size:
            low, high, size = values.min(), values.max(), np.abs(values).max()
            wide = high - low > 1e-3 * size and not one
            pad = 0.06 * (high - low) if wide else max(0.02 * size, SCATTER * (high - low)) or 1.0
            set_limits(low - pad, high + pad)


def returning(points: np.ndarray) -> tuple[int, float]:
    """Return the period of section points and the most by which they miss it; 0 and NaN where none is seen.

    Points, shape (points, 2), are in units in which `SEEN` cannot be told from 0 on paper.
    """
    for period in range(1, min(LONGEST_PERIOD, len(points) // 3) + 1):
        missed = np.hypot(*(points[period:] - points[:-period]).T).max()
        if missed < SEEN:
            return period, float(missed)
    return 0, np.nan


def shade_missing(ax: Axes, x: np.ndarray, missing: np.ndarray, label: str) -> None:
    """Hatch the stretches of a history that have no value."""
    edges = np.flatnonzero(np.diff(np.r_[False, missing, False])).reshape(-1, 2)
    look = {"facecolor": style.DISC, "edgecolor": style.GREY, "hatch": "////", "linewidth": 0.0, "zorder": 0}
    for number, (first, end) in enumerate(edges):
        span = x[max(first - 1, 0)], x[min(end, x.size - 1)]
        ax.axvspan(*span, **look, label=label if number == 0 else "_")


def missing_note(x: np.ndarray, y: np.ndarray, what: str) -> str:
    """Return a note on the number of missing points of a cloud or path; empty where none is."""
    lost = int(np.count_nonzero(~(np.isfinite(x) & np.isfinite(y))))
    return f"no value at {lost} of {x.size} {what}" if lost else ""


def heading(ax: Axes, *words: str, beside_top_axis: bool = False) -> None:
    """Write the words that are not empty above the left end of a panel."""
    place = {"y": 1.0, "pad": BESIDE_TOP_AXIS} if beside_top_axis else {}
    ax.set_title(fill(" ".join(filter(None, words)), NARROW), loc="left", **place)


def letters(count: int) -> list[str]:
    """Return the letters of so many panels; empty ones of a single panel."""
    return [f"({one})" for one in ascii_lowercase[:count]] if count > 1 else [""] * count


def letter(axes: Iterable[Axes]) -> None:
    """Write a letter before the headings of panels, where there are several."""
    panels = list(axes)
    for ax, one in zip(panels, letters(len(panels)), strict=False):
        heading(ax, one, ax.get_title(loc="left"), beside_top_axis=bool(ax.child_axes))


def say(ax: Axes, sentence: str, colour: str = style.WARNING) -> None:
    """Write a sentence in a panel that has nothing to draw: a warning, or an answer in black."""
    look = {"ha": "center", "va": "center", "color": colour}
    ax.text(0.5, 0.5, fill(sentence, 30), transform=ax.transAxes, **look)
    ax.tick_params(left=False, bottom=False, labelleft=False, labelbottom=False)


def remark(ax: Axes, *sentences: str) -> None:
    """Write doubts about what is drawn above it, into a panel."""
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + DOUBT * len(sentences) * (high - low))
    look = {"ha": "right", "va": "top", "color": style.WARNING}
    ax.text(0.99, 0.97, "\n".join(sentences), transform=ax.transAxes, **look)


def status_note(dataset: Dataset) -> str:
    """Return one line on the failure of a run; empty where it did not fail."""
    if "status" not in dataset:
        return ""
    meanings = codes.flags(dataset["status"])
    ends = dataset["cell_status" if "cell_status" in dataset else "status"].values
    found = [meanings.get(int(end), f"code {int(end)}" if end else "ok") for end in np.unique(ends)]
    bad = [f"{EXPLAINED.get(word, 'see the status')} (status {word})" for word in found if word != "ok"]
    many = f" in {np.count_nonzero(ends)} of {ends.size}" if ends.size > 1 else ""
    return f"Incomplete result{many}: " + ", ".join(bad) if bad else ""


def literal(figure: Figure) -> None:
    """Have texts drawn as they stand that are no mathematics, such as names with dollar signs."""
    from matplotlib.cbook import is_math_text
    from matplotlib.mathtext import MathTextParser
    from matplotlib.text import Text

    mathematics = MathTextParser("path")
    for ax in figure.axes:  # texts of ticks are made when they are asked for
        ax.get_xticklabels(), ax.get_yticklabels()
    for text in figure.findobj(Text):
        try:
            for line in filter(is_math_text, text.get_text().split("\n")):
                mathematics.parse(line)
        except ValueError:
            text.set_parse_math(False)


def finish(figure: Figure, dataset: Dataset) -> Figure:
    """Write the run's status on top if it is not ok, and settle the layout while the style still holds."""
    from jointplay.figures.drawing.derived import Sheet

    note, whole = status_note(dataset), isinstance(figure, Sheet)
    if note and whole:
        width, height = figure.get_size_inches()
        height += NOTE * style.MILLIMETRE
        figure.set_size_inches(width, height)
    if note:
        frame = {"facecolor": "white", "edgecolor": style.WARNING, "linewidth": 0.8, "pad": 2.0}
        lines = fill(note, int(figure.bbox.width / figure.dpi / style.MILLIMETRE / 1.8))
        figure.suptitle(lines, fontsize=8, color=style.WARNING, bbox=frame)
    literal(figure)
    if not isinstance(figure, Panel) and not style.same_sheet():
        settle(figure)
    return figure


def settle(figure: FigureBase) -> None:
    """Lay a figure out, with the powers of ten that matplotlib writes next to axes in the axes' labels.

    Panels that share an axis share its power; each that has a label gets it.
    """
    _lay_out(figure.get_figure(root=True))  # powers are chosen as ticks are made
    moved = False
    axes = [ax for each in figure.axes for ax in (each, *each.child_axes)]
    for axis in (axis for ax in axes for axis in (ax.xaxis, ax.yaxis)):
        if power := POWER.search(axis.get_offset_text().get_text()):
            digits = power[1].replace("\N{MINUS SIGN}", "-")
            move(axis, f"10{digits.translate(RAISED)}")
            moved = True
    if moved:  # labels take room
        _lay_out(figure.get_figure(root=True))


def _lay_out(figure: Figure) -> None:
    """Lay a figure out, without drawing it where its engine can."""
    engine = figure.get_layout_engine()
    if engine is None:
        figure.draw_without_rendering()
    else:
        engine.execute(figure)


def unit(label: str) -> str:
    """Return the unit that a label ends with; empty where there is none."""
    found = UNIT.search(label.replace("\n", " "))
    return found[1] if found else ""


def move(axis: Axis, factor: str) -> None:
    """Write a factor before the unit of an axis' label, and not at the end of the axis."""
    label = axis.get_label()
    text = label.get_text()
    if unit := UNIT.search(text):
        words = factor if unit[1] in PLAIN.values() else f"{factor} {unit[1]}"
        label.set_text(f"{text[: unit.start()]}({words})")
    elif text:
        label.set_text(f"{text} ({factor})")
    axis.get_offset_text().set_visible(False)


def page(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure and its one bare axes, in mm from the upper left corner."""
    figure = style.sheet(width, height + 2 * PAD)
    figure.get_layout_engine().set(w_pad=0.0, h_pad=PAD * style.MILLIMETRE)
    ax = figure.subplots()
    ax.set(xlim=(0, width), ylim=(height, 0), aspect="equal")
    ax.set_axis_off()
    return figure, ax


def cell(ax: Axes, box: tuple[float, float, float, float], words: str = "", shade: float = 0.0) -> None:
    """Draw one cell: `box` is left, top, width and height in mm, `shade` from 0 (white) to 1."""
    from matplotlib.patches import Rectangle

    left, top, width, height = box
    grey = 1.0 - DARKEST * (float(np.clip(shade, 0.0, 1.0)) if np.isfinite(shade) else 0.0)
    look = {"facecolor": str(grey), "edgecolor": style.GREY, "linewidth": 0.4}
    ax.add_patch(Rectangle((left, top), width, height, **look))
    colour = "white" if grey < 0.55 else "black"
    write(ax, left + width / 2, top + height / 2, words, ha="center", color=colour)


def lines(ax: Axes, rows, columns: dict[float, str], heights: tuple[float, float], notes, spacing) -> None:
    """Write rows of words, then notes, in a panel: columns by place and alignment, heights of top and row."""
    height, step = heights
    look = {"fontsize": BESIDE, "transform": ax.transAxes}
    for row in rows:
        for (place, align), words in zip(columns.items(), row, strict=True):
            ax.text(place, height, words, ha=align, va="center", **look)
        height -= step
    ax.text(0.0, height, "\n".join(notes), va="top", linespacing=spacing, **look)


def write(ax: Axes, x: float, y: float, words: str, **look) -> None:
    """Write words at a place in mm."""
    ax.text(x, y, words, **{"va": "center", "fontsize": TEXT, "linespacing": 1.05} | look)


def smooth(
    times: np.ndarray, x: np.ndarray, y: np.ndarray, contact: np.ndarray, touches: Callable | None = None
) -> tuple[np.ndarray, ...]:
    """Return x, y and contact with further points where the path bends or contact begins or ends.

    Parameters
    ----------
    times, x, y : ndarray
        Samples; NaN where there is no value.
    contact : ndarray of bool
        Whether a sample is in contact.
    touches : callable, optional
        Of x and y: how far points are in contact, negative in flight. Between a sample in contact and one in
        flight it tells the points apart, and where contact begins or ends; without it none is in contact.
    """
    there = np.isfinite(x) & np.isfinite(y)
    rising = np.r_[True, np.diff(times) > 0]  # at an event there may be two samples
    if 4 <= x.size <= MOST and there.all() and rising.all():
        x, y, contact = denser(times, x, y, contact, touches)
    return (x, y, contact) if touches is None else edged(x, y, contact, touches(x, y))


def denser(
    times: np.ndarray, x: np.ndarray, y: np.ndarray, contact: np.ndarray, touches: Callable | None
) -> tuple[np.ndarray, ...]:
    """Return the path with points of the splines in between, as `smooth` does."""
    points = np.stack([x, y], -1)
    changing = contact[1:] != contact[:-1]
    intervals = np.flatnonzero(bends(points) | changing)
    slopes, lengths = akima(times, points), np.diff(times)[intervals, None]
    ends = (lengths * slopes[intervals], lengths * slopes[intervals + 1])
    shares = np.arange(1, BETWEEN) / BETWEEN
    curve = cubic(points[intervals], np.diff(points, axis=0)[intervals], *ends, shares)
    places = np.repeat(intervals + 1, BETWEEN - 1)
    both = np.repeat(contact[intervals] & contact[intervals + 1], BETWEEN - 1)
    if touches is not None:
        both = np.where(np.repeat(changing[intervals], BETWEEN - 1), touches(*curve.T) > 0, both)
    x, y = (np.insert(each, places, curve[:, column]) for column, each in enumerate((x, y)))
    return x, y, np.insert(contact, places, both)


def edged(x: np.ndarray, y: np.ndarray, contact: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the path with the points, in contact, at which it crosses from flight to contact or back."""
    before = np.flatnonzero((contact[1:] != contact[:-1]) & (level[1:] * level[:-1] < 0))
    shares = level[before] / (level[before] - level[before + 1])
    points = (each[before] + shares * (each[before + 1] - each[before]) for each in (x, y))
    x, y = (np.insert(each, before + 1, new) for each, new in zip((x, y), points, strict=True))
    return x, y, np.insert(contact, before + 1, True)


def akima(times: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return slopes at points, shape (samples, 2): means of both sides', the steadier side weighing more."""
    inner = np.diff(points, axis=0) / np.diff(times)[:, None]
    before, after = (2 * a - b for a, b in ((inner[0], inner[1]), (inner[-1], inner[-2])))
    lines = np.vstack([2 * before - inner[0], before, inner, after, 2 * after - inner[-1]])
    unsteady = np.abs(np.diff(lines, axis=0)) + np.abs(lines[1:] + lines[:-1]) / 2
    left, right = unsteady[2:], unsteady[:-2]  # weights of the lines on these sides
    whole = left + right
    flat = whole <= FLAT * whole.max()
    weighed = (left * lines[1:-2] + right * lines[2:-1]) / np.where(flat, 1.0, whole)
    return np.where(flat, (lines[:-3] + lines[3:]) / 2, weighed)


def bends(points: np.ndarray) -> np.ndarray:
    """Return between which samples a path bends visibly, of shape (samples - 1,)."""
    size = np.ptp(points, axis=0)
    steps = np.diff(points / np.where(size > 0, size, 1.0), axis=0)
    course = np.arctan2(steps[:, 1], steps[:, 0])
    sharp = np.abs((np.diff(course) + np.pi) % (2 * np.pi) - np.pi) > BENT
    return np.r_[sharp, False] | np.r_[False, sharp]


def through(points: np.ndarray, tangents: np.ndarray, straight: np.ndarray | bool = False) -> np.ndarray:
    """Return a denser path through points, shape (points, 2), with tangents along any smooth parameter.

    The parameter's steps are those that fit the chords best: a parabola is met exactly. Where a tangent
    points away from the neighbour, as at a cusp, or is none, the chord takes its place, as it does at both
    ends of pieces that are `straight`.
    """
    if len(points) < 2:
        return points
    chords, means = np.diff(points, axis=0), (tangents[:-1] + tangents[1:]) / 2
    size = np.sum(means**2, axis=1, keepdims=True)
    steps = np.sum(chords * means, axis=1, keepdims=True) / np.where(size > 0, size, np.inf)
    steps = np.where(np.reshape(straight, (-1, 1)), np.nan, steps)
    begin, end = (_forward(steps * each, chords) for each in (tangents[:-1], tangents[1:]))
    path = cubic(points[:-1], chords, begin, end, np.arange(BETWEEN) / BETWEEN)
    return np.concatenate([path, points[-1:]])


def cubic(
    points: np.ndarray, chords: np.ndarray, begin: np.ndarray, end: np.ndarray, shares: np.ndarray
) -> np.ndarray:
    """Return points at shares of intervals, given where each begins, its chord and its tangents by share."""
    t = shares[None, :, None]
    path = points[:, None] + t * chords[:, None]
    path = path + t * (1 - t) * ((1 - t) * (begin - chords)[:, None] + t * (chords - end)[:, None])
    return path.reshape(-1, 2)


def _forward(tangents: np.ndarray, chords: np.ndarray) -> np.ndarray:
    """Return tangents, or chords where they point away or are far longer."""
    along, size = np.sum(tangents * chords, axis=1, keepdims=True), np.sum(chords**2, axis=1, keepdims=True)
    fits = (along > 0) & (np.sum(tangents**2, axis=1, keepdims=True) < 9 * size)
    return np.where(fits, tangents, chords)
