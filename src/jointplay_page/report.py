"""A result as one HTML page: answer in words, live charts, the mechanism in motion, where it comes from.

Figures of a result inside a page: each as SVG, as in print, and where on it values stand.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from io import StringIO
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from xarray import Dataset

from jointplay import figures
from jointplay.display.errors import InputError, of_a_result, refuse
from jointplay.display.number_text import measure
from jointplay.figures.drawing import artists
from jointplay.figures.registry import suited_to
from jointplay.jobs.files import replaced
from jointplay.kinds import KINDS
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.mechanism.signature import checked
from jointplay.study.file import figure_options
from jointplay.study.models import build_mechanism
from jointplay.study.results import provenance
from jointplay.study.results.store import check_writable, write_figure
from jointplay.study.results.summary import Summary, summary
from jointplay_page import live, moving, sweep_points, texts

MOST = 5  # figures of a page
ROOM = 1_800_000  # bytes of all numbers of a page: in base64, with pictures and solver, less than 5 MB

MARKS = 3_000  # marks of a cloud, or cells of a map, that are drawn one by one; more are an image
DPI = 200  # of such an image
SCREEN = 155  # px an inch of print, at most
STOPS = 257  # along an axis of another scale
SECONDS = {"Time (s)": 1.0, "Time (ms)": 1e3}  # labels of an axis of time, and its factors


@dataclass(frozen=True)
class Content:
    """Content of a page.

    Parameters
    ----------
    dataset : Dataset
        The result.
    origin : dict
        Its provenance; empty where it has none.
    figures : dict of str to Figure
        Pictures by their kinds, the study's own first.
    svgs : dict of str to str
        The same as elements of the page.
    cells, motion, live : dict or None
        Of a sweep; of a response; what the page needs to compute by itself.
    note : str
        Why there is no motion, or not the usual picture, or nothing that computes.
    """

    dataset: Dataset
    origin: dict[str, Any]
    figures: dict[str, Any]
    svgs: dict[str, str]
    cells: dict[str, Any] | None
    motion: dict[str, Any] | None
    live: dict[str, Any] | None
    note: str


@checked()
def report(
    dataset: Annotated[Dataset | Mechanism | TestSystem, accepts("a result or a mechanism")],
    path: Annotated[Path | str, accepts("the name of a file that ends in .html")],
    *,
    mechanism: Annotated[Mechanism | None, accepts("a mechanism")] = None,
    title: Annotated[str | None, accepts("a text")] = None,
) -> list[Path]:
    """Write a result as one HTML page that needs no network, and its picture as a PNG file.

    Parameters
    ----------
    dataset : Dataset, Mechanism or TestSystem
        What an analysis gave, or `jointplay.open`; of any kind. Or what moves, for a page that computes its
        motion.
    path : path-like
        The page's name, ending in ``.html``.
    mechanism : Mechanism, optional
        What moves, where the result does not hold its study; a response that recorded ``angle`` is shown in
        motion.
    title : str, optional
        Of the page; by default that of the result, or what the mechanism is.

    Returns
    -------
    list of pathlib.Path
        The page, and its picture where the kind of result has one.

    Raises
    ------
    InputError
        When the dataset is no result.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.simulate(jp.catalog.chunmei2002(clearance=2.9e-4), turns=5)  # doctest: +SKIP
    >>> jp.report(motion, "motion.html")  # doctest: +SKIP
    [PosixPath('motion.html'), PosixPath('motion_report.png')]
    """
    path = Path(path)
    if path.suffix != ".html":
        raise refuse(str(path), "a name that ends in .html is accepted", "--out")
    if isinstance(dataset, Mechanism | TestSystem):
        check_writable(path.parent, files=[path.name])
        return [written(path, live.page(dataset, title or ""))]
    with of_a_result(dataset):
        return _report(dataset.assign_attrs({"title": title} if title else {}), path, mechanism)


def _report(dataset: Dataset, path: Path, mechanism: Mechanism | None) -> list[Path]:
    """Write the page of a result, and its picture."""
    answer, content = summary(dataset), content_of(dataset, mechanism)
    picture = path.with_name(f"{path.stem}_report.png")  # NAME.png is the figure of the run
    check_writable(path.parent, files=[path.name, picture.name])
    first = list(content.figures.values())[:1]
    still = [write_figure(each, picture) for each in first]
    return [written(path, html(content, answer, *still)), *still]


def written(path: Path, text: str) -> Path:
    """Write a page whole, or not at all."""
    with replaced(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def content_of(dataset: Dataset, mechanism: Mechanism | None) -> Content:
    """Gather the content of a result's page."""
    origin = provenance.read(dataset)
    study = origin.get("study") if isinstance(origin.get("study"), dict) else {}
    with suppress(InputError):  # another version's record: a page without motion, which it says
        mechanism = mechanism or build_mechanism(study.get("mechanism"))
    motion, note = moving.moving(dataset, mechanism if isinstance(mechanism, Mechanism) else None)
    swept = amid(mechanism, dataset, list(study.get("vary") or {})) if mechanism else None
    computing, why = live.live(swept, sweep_points.parameters(dataset)) if swept else (None, "")
    drawn, trouble = pictures(dataset)
    svgs = {kind: svg_text(figure, f"f{number}") for number, (kind, figure) in enumerate(drawn.items())}
    found = sweep_points.cells(dataset, study, max(0, ROOM - sum(map(len, svgs.values()))))
    notes = " ".join(filter(None, (note, trouble, why)))
    return Content(dataset, origin, drawn, svgs, found, motion, computing, notes)


def amid(mechanism: Mechanism | TestSystem, dataset: Dataset, keys: list[str]) -> Mechanism | TestSystem:
    """Return the mechanism in the middle of a sweep, from which sliders reach most of its points."""
    middle = {}
    for name in sweep_points.parameters(dataset):
        if dataset[name].dtype.kind not in "fiu":
            continue
        ends = dataset[name].values[[0, -1]]
        mean = np.sqrt(ends.prod()) * np.sign(ends[0]) if ends.prod() > 0 else ends.mean()
        middle |= {key: float(mean) for key in keys if key.rpartition(".")[2] == name}
    try:
        return mechanism.varied(middle)
    except InputError:  # a start or an order of them, which has no middle
        return mechanism


def pictures(dataset: Dataset) -> tuple[dict[str, Any], str]:
    """Return the figures that can be drawn of a result, and why the study's own figure cannot."""
    options = figure_options(dataset)
    if "swept" in dataset.attrs:
        whole = figures.of_sweep(dataset, options)
        return ({"sweep": figures.draw(dataset, whole)} if whole else {}), ""
    kinds, found, trouble = suited_to(dataset.attrs.get("kind")), {}, ""
    try:
        first = options.get("kind") or figures.usual_kind(dataset)
        found[first] = figures.draw(dataset, options)
    except InputError as error:
        trouble = f"The usual picture cannot be drawn: {error}." if kinds else ""
    for kind in kinds[:MOST]:
        with suppress(InputError):  # this result lacks what that figure needs
            found |= {} if kind in found else {kind: figures.draw(dataset, {"kind": kind})}
    maps = {kind: each for kind, each in found.items() if any(map(is_map, each.axes))}
    one_row = maps and len(sweep_points.parameters(dataset)) > 1  # says less than the map
    return (maps if one_row else found), trouble


def is_map(ax: Any) -> bool:
    """Return whether a panel shows colours over two parameters."""
    return any(isinstance(each, QuadMesh) for each in ax.collections)


def html(content: Any, answer: Summary, *still: Path) -> str:
    """Return the page of a `report.Content` with its answer and still pictures."""
    known = [*sweep_points.parameters(content.dataset), *(["time"] if content.motion else [])]
    data = {"cells": content.cells, "motion": content.motion, "live": content.live}
    data["panels"] = [
        panel | {"picture": number}
        for number, figure in enumerate(content.figures.values())
        for panel in panels(figure, content.dataset, known)
    ]
    drawn = "".join(map(section, range(len(content.svgs)), content.svgs, content.svgs.values()))
    computing = live.section(content.live) if content.live else ""
    numbers = texts.numbers(content.dataset, sweep_points.parameters(content.dataset))
    first = content.dataset.attrs.get("kind") == "assess"  # its verdict moves with the sliders
    table = KINDS["assess"].outputs.table
    whole = f"<pre>{escape(table(content.dataset))}</pre>" if first else ""
    return live.filled(
        str(content.dataset.attrs.get("title") or (content.live or {}).get("heading") or answer.title),
        data,
        kind=escape(answer.title),
        answer=escape("\n".join(answer.lines)),
        still="".join(map(live.picture, still)),
        live="" if first else computing,
        shown=computing + drawn if first else drawn,
        cell=cell_section(content),
        motion=motion_section(content),
        numbers=whole + f"<details><summary>All numbers</summary>{numbers}</details>" if first else numbers,
        origin=texts.origin(content.origin),
    )


def section(number: int, kind: str, svg: str) -> str:
    """Return a picture with its heading, a place for the pointer's reading, and a button for the way back."""
    head = escape(kind.replace("_", " ").capitalize())
    svg = svg.replace("<svg ", f'<svg role="img" aria-label="{head}" ', 1)
    back = f'<button type="button" id="whole{number}" hidden>Whole picture</button>'
    return f"""<section><h2>{head}</h2><div class="picture" id="picture{number}">{svg}</div>
<p class="note reading"><span id="at{number}">&nbsp;</span>{back}</p></section>"""


def cell_section(content: Any) -> str:
    """Return the place where a selected cell is shown."""
    if not content.cells:
        return ""
    runs = all(each["key"] for each in content.cells["parameters"])
    motion, words = point_section(content.live), "With the study below, this computes the point again"
    if {"up", "down"} & {word for name in content.cells["ways"] for word in name.split()}:
        words += ", from the study's own start: upward and downward, each began where its neighbour ended"
    again = f"<p>{words}:</p>{texts.copied('cell-command', '')}"
    labels = (escape(f"{one['y_label']} over {one['x_label']}") for one in content.cells["charts"])
    boxes = "".join(
        f'<figure><canvas id="cell-chart{number}" role="img" aria-label="{label}"></canvas></figure>'
        for number, label in enumerate(labels)
    )
    sliders = "".join(
        f'<label>{escape(each["title"])} <input id="slider{k}" type="range" min="0" value="0" '
        f'max="{len(each["values"]) - 1}"></label>'
        for k, each in enumerate(content.cells["parameters"])
    )
    return f"""
<p class="note">A click in a diagram, the arrow keys or a slider select a point, which is shown below.</p>
<div class="controls">{sliders}</div>
<section id="cell" hidden><h2 id="cell-title"></h2>
<div class="wide"><table id="cell-numbers"></table></div><div class="plots">{boxes}</div>
<p class="note">{escape(content.cells["note"])}</p>{motion}{again if runs else ""}</section>"""


def point_section(live: dict[str, Any] | None) -> str:
    """Return the place where the motion of a selected point is drawn, if the page computes."""
    views = live["views"] if live else []
    boxes = "".join(point_charts(number, view) for number, view in enumerate(views))
    return f'<div class="plots">{boxes}</div><p class="note" id="point-said"></p>' if boxes else ""


def point_charts(number: int, view: dict[str, Any]) -> str:
    """Return the places of a bearing's force and path, or of two states."""
    words = {"force": "Over four turns", "orbit": "Phase plane"}
    if view["circle"]:
        name = escape(view["name"])
        words = {"force": f"Force at {name} over four turns"}
        words["orbit"] = f"Path of the journal in {name}; the circle is the clearance"
    return "".join(canvas(f"point-{key}{number}", text, text) for key, text in words.items())


def motion_section(content: Any) -> str:
    """Return the stage of the mechanism in motion, and a note on missing parts."""
    note = f'<p class="note">{escape(content.note)}</p>' if content.note else ""
    if not content.motion:
        return note
    insets = "".join(inset(number, each) for number, each in enumerate(content.motion["bearings"]))
    insets += "".join(guide_inset(number, each) for number, each in enumerate(content.motion["guides"]))
    return f"""{note}
<section id="motion"><h2>The mechanism in motion</h2>
<div class="stage"><canvas id="linkage" role="img" aria-label="The mechanism in motion"></canvas>
<div>{insets}</div></div>
<div class="controls"><button id="play" type="button">Play</button>
<input id="frame" type="range" min="0" value="0" aria-label="Time in the turn"><span id="moment"></span></div>
<p class="note">{escape(content.motion["note"])} Space plays and stops; the keys , and . step;
a click in a time history goes there.</p></section>"""


def canvas(name: str, label: str, words: str) -> str:
    """Return a place that is drawn in, with words below it."""
    place = f'<canvas id="{name}" role="img" aria-label="{label}"></canvas>'
    return f'<figure>{place}<figcaption class="note">{words}</figcaption></figure>'


def inset(number: int, bearing: dict[str, Any]) -> str:
    """Return the place where the journal in a bearing is shown."""
    name, clearance = escape(bearing["name"]), measure(bearing["clearance"], "m")
    words = f"Journal in bearing {name}: the circle is the clearance of {clearance}"
    force = ", the arrow the force on the journal" if "force" in bearing else ""
    return canvas(f"bearing{number}", f"Journal in bearing {name}", words + force)


def guide_inset(number: int, guide: dict[str, Any]) -> str:
    """Return the place where a slider between the faces of its guide is shown."""
    name, clearance = escape(guide["name"]), measure(guide["clearance"], "m")
    words = f"Slider on guide {name}: the gap on either side is the clearance of {clearance}; the block's"
    words += " height is cut short" + "; corners in contact are filled" * ("touch" in guide)
    force = "; the bars are the forces on the slider" if "force" in guide else ""
    return canvas(f"guide{number}", f"Slider on guide {name}", words + force)


def svg_text(figure: Figure, prefix: str) -> str:
    """Return a figure as an SVG element; names in it begin with a prefix, so that several stand in a page."""
    for mark in (mark for ax in figure.axes for mark in (*ax.lines, *ax.collections)):
        mark.set_rasterized(marks(mark) > MARKS)
    file = StringIO()
    with rc_context({"svg.hashsalt": prefix}):
        figure.savefig(file, format="svg", dpi=DPI, metadata={"Date": None})
    text = file.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.S)
    text = re.sub(r'(id="|href="#|url\(#)', rf"\1{prefix}-", text)
    wide = f'style="max-width: {SCREEN * figure.bbox.width / figure.dpi:.0f}px" '
    return re.sub(r'<svg (.*?)width="\S+" height="\S+"', rf"<svg {wide}\1", text, count=1, flags=re.S).strip()


def marks(artist: Any) -> int:
    """Return the number of marks that an artist draws one by one; a curve is one."""
    if isinstance(artist, QuadMesh):
        return artist.get_array().size
    dotted = isinstance(artist, Line2D) and artist.get_marker() not in ("None", "none", "", " ", None)
    return len(artist.get_xdata()) if dotted else 1


def panels(figure: Figure, dataset: Dataset, known: list[str]) -> list[dict[str, Any]]:
    """Return where values stand on a drawn figure, for each panel that holds data, in reading order.

    Parameters
    ----------
    figure : Figure
        As `jointplay.figures` draws it.
    dataset : Dataset
        What it shows.
    known : list of str
        Coordinates that an axis may stand for: varied parameters, time.

    Returns
    -------
    list of dict
        ``box``: left, top, width and height in the SVG's units (pt). ``log``: which axes are logarithmic.
        ``stops`` of x and y, in the axes' units: the two ends, or values at even distances on a scale that is
        neither linear nor logarithmic. ``over``: the varied parameter, or ``time``, along each. ``factors``:
        from stored units to the axes'. ``labels`` of the axes.
    """
    width, height = 72 * figure.get_size_inches()
    found = []
    for ax in sorted(with_data(figure), key=place):
        box = ax.get_position()
        over, factors = zip(*(stands_for(ax, which, dataset, known) for which in "xy"), strict=True)
        found.append(
            {
                "box": [box.x0 * width, (1 - box.y1) * height, box.width * width, box.height * height],
                "stops": [stops(ax.xaxis), stops(ax.yaxis)],
                "log": [ax.get_xscale() == "log", ax.get_yscale() == "log"],
                "over": over,
                "factors": factors,
                "labels": [plain(next(filter(None, labels(ax, which)), "")) for which in "xy"],
            }
        )
    return found


def with_data(figure: Figure) -> list[Axes]:
    """Return the panels that hold data, and no colour bars."""
    bars = [mark.colorbar.ax for ax in figure.axes for mark in ax.collections if mark.colorbar]
    return [ax for ax in figure.axes if ax not in bars and (ax.lines or ax.collections) and ax.axison]


def place(ax: Axes) -> tuple[float, float]:
    """Return the order of reading."""
    box = ax.get_position()
    return -round(box.y1, 2), box.x0


def stops(axis: Axis) -> list[float]:
    """Return values at even distances along an axis; on a linear or logarithmic one its ends are enough."""
    transform, count = axis.get_transform(), 2 if axis.get_scale() in ("linear", "log") else STOPS
    places = np.linspace(*transform.transform(axis.get_view_interval()), count)
    return transform.inverted().transform(places).tolist()


def labels(ax: Axes, which: str) -> list[str]:
    """Return the labels of an axis and of axes that share it, its own first."""
    shared = getattr(ax, f"get_shared_{which}_axes")().get_siblings(ax)
    return [getattr(each, f"get_{which}label")() for each in (ax, *shared)]


def plain(text: str) -> str:
    """Return a label without the marks of mathematical type."""
    return re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"[{}]|\\(?=[a-zA-Z])", "", found[1]), text)


def stands_for(ax: Axes, which: str, dataset: Dataset, known: list[str]) -> tuple[str | None, float]:
    """Return the coordinate along an axis, found by its label, and the factor to its units."""
    written = {label.replace("\n", " ") for label in labels(ax, which)}
    if "time" in known and (matches := written & SECONDS.keys()):
        return "time", SECONDS[matches.pop()]
    for name in known:
        unit = artists.displayed(dataset[name])[1]
        if artists.axis_label(dataset[name], unit) in written:
            return name, float(unit.factor)
    return None, 1.0
