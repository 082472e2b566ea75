"""The HTML of a page: Bokeh's charts, the page's own script and style, and the data, in one text."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from bokeh.document import Document
from bokeh.embed import components
from bokeh.events import DocumentReady, RangesUpdate, Reset, Tap
from bokeh.models import ColumnDataSource, CustomJS, Range1d, Span
from bokeh.plotting import figure as new_chart
from bokeh.resources import Resources

from jointplay.display.units import measure
from jointplay.study.results.summary import Summary
from jointplay_page import live, panels, sweep_points, template, texts, thin

SELECTED = "#d55e00"


def html(content: Any, answer: Summary, *still: Path) -> str:
    """Return the page of a `report.Content` with its answer and still pictures."""
    made = charts(content)
    detail = cell_charts(content.cells["charts"]) if content.cells else []
    script, divs, library = embedded([*(panel.chart for _, panel in made), *detail])
    data = {"cells": content.cells, "motion": content.motion, "live": content.live}
    data["panels"] = [{"over": panel.over, "factors": panel.factors} for _, panel in made]
    seen = "".join(map(template.picture, still))
    return template.filled(
        str(content.dataset.attrs.get("title") or answer.title),
        data,
        kind=escape(answer.title),
        answer=escape("\n".join(answer.lines)),
        still=seen,
        live=live.section(content.live) if content.live else "",
        shown=sections(made, divs) if made else seen,
        cell=cell_section(content, divs[len(made) :]),
        motion=motion_section(content),
        numbers=texts.numbers(content.dataset, sweep_points.parameters(content.dataset)),
        origin=texts.origin(content.origin),
        library=library,
        charts=script,
    )


def embedded(charts: list[Any]) -> tuple[str, tuple[str, ...], str]:
    """Return the script that draws charts and begins the page, their places, and the library they need."""
    if not charts:
        return template.START, (), ""
    document = Document()
    for chart in charts:
        document.add_root(chart)
    document.js_on_event(DocumentReady, CustomJS(code="jointplay.start()"))
    script, divs = components(charts)
    return script, divs, Resources(mode="inline", components=["bokeh"]).render_js()


def charts(content: Any) -> list[tuple[str, panels.Panel]]:
    """Return the live charts, each with the kind of its figure, and let them tell the page what is done."""
    known = [*sweep_points.parameters(content.dataset), *(["time"] if content.motion else [])]
    most = thin.limit(thin.sizes(content.figures.values()))
    found: list[tuple[str, panels.Panel]] = []
    for kind, figure in content.figures.items():
        made = panels.panels(figure, content.dataset, known, len(found), most)
        found += [(kind, panel) for panel in made]
    for number, (_, panel) in enumerate(found):
        ready(panel, number)
    return found


def ready(panel: panels.Panel, number: int) -> None:
    """Let a chart tell of clicks and changed ranges, and give it the lines of what is selected."""
    panel.chart.js_on_event(Tap, CustomJS(code=f"jointplay.tapped({number}, cb_obj.x, cb_obj.y)"))
    for event in (RangesUpdate, Reset):
        panel.chart.js_on_event(event, CustomJS(code="jointplay.zoomed()"))
    for which, over, dimension in zip("xy", panel.over, ("height", "width"), strict=True):
        if over:
            look = {"line_color": SELECTED, "line_width": 1.5, "visible": False, "location": 0}
            panel.chart.add_layout(Span(name=f"mark{number}{which}", dimension=dimension, **look))


def cell_charts(given: list[dict[str, Any]]) -> list[Any]:
    """Return the charts of a selected cell, empty."""
    found = []
    for number, one in enumerate(given):
        chart = new_chart(
            height=300,
            sizing_mode="stretch_width",
            tools=panels.TOOLS,
            name=f"cell-chart{number}",
            x_range=Range1d(0, 1),
            y_range=Range1d(0, 1),
            x_axis_label=one["x_label"],
            y_axis_label=one["y_label"],
        )
        chart.toolbar.logo = None
        source = ColumnDataSource({"x": [], "y": [], "colour": []}, name=f"cell{number}")
        if one["joined"]:
            chart.line("x", "y", source=source)
        else:
            chart.scatter("x", "y", color="colour", size=3, source=source)
        found.append(chart)
    return found


def sections(live: list[tuple[str, panels.Panel]], divs: tuple[str, ...]) -> str:
    """Return the charts, those of a figure on one grid, with notes of what they leave out."""
    found = []
    for kind in dict.fromkeys(kind for kind, _ in live):
        pairs = [(panel, div) for (other, panel), div in zip(live, divs, strict=False) if other == kind]
        boxes = (f'<div class="chart" style="grid-column: span {p.columns}">{div}</div>' for p, div in pairs)
        notes = dict.fromkeys(note for panel, _ in pairs for note in panel.notes)
        said = f'<p class="note">{escape("; ".join(notes))}.</p>' if notes else ""
        head = escape(kind.replace("_", " ").capitalize())
        found.append(f'<section><h2>{head}</h2><div class="charts">{"".join(boxes)}</div>{said}</section>')
    return "".join(found)


def cell_section(content: Any, divs: tuple[str, ...]) -> str:
    """Return the place where a selected cell is shown."""
    if not content.cells:
        return ""
    runs = all(each["key"] for each in content.cells["parameters"])
    motion, words = point_section(content.live), "With the study below, this computes the point again"
    if {"up", "down"} & {word for way in content.cells["ways"] for word in way.split()}:
        words += ", from the study's own start: upward and downward, each began where its neighbour ended"
    again = f"<p>{words}:</p>{texts.copied('cell-command', '')}"
    boxes = "".join(f'<div class="chart" style="grid-column: span 6">{div}</div>' for div in divs)
    sliders = "".join(
        f'<label>{escape(each["title"])} <input id="slider{k}" type="range" min="0" value="0" '
        f'max="{len(each["values"]) - 1}"></label>'
        for k, each in enumerate(content.cells["parameters"])
    )
    return f"""
<p class="note">A click in a diagram, the arrow keys or a slider select a point, which is shown below.</p>
<div class="controls">{sliders}</div>
<section id="cell" hidden><h2 id="cell-title"></h2>
<div class="wide"><table id="cell-numbers"></table></div><div class="charts">{boxes}</div>
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
    return "".join(
        f'<figure><canvas id="point-{key}{number}" role="img" aria-label="{text}"></canvas>'
        f'<figcaption class="note">{text}</figcaption></figure>'
        for key, text in words.items()
    )


def motion_section(content: Any) -> str:
    """Return the stage of the mechanism in motion, and what the page has not, and why."""
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
<input id="frame" type="range" min="0" value="0" aria-label="Moment"><span id="moment"></span></div>
<p class="note">{escape(content.motion["note"])} Space plays and stops; the keys , and . step;
a click in a time history goes there.</p></section>"""


def inset(number: int, bearing: dict[str, Any]) -> str:
    """Return the place where the journal in a bearing is shown."""
    name, clearance = escape(bearing["name"]), measure(bearing["clearance"], "m")
    words = f"Journal in bearing {name}: the circle is the clearance of {clearance}"
    force = ", the arrow the force on the journal" if "force" in bearing else ""
    canvas = f'<canvas id="bearing{number}" role="img" aria-label="Journal in bearing {name}"></canvas>'
    return f'<figure>{canvas}<figcaption class="note">{words}{force}</figcaption></figure>'


def guide_inset(number: int, guide: dict[str, Any]) -> str:
    """Return the place where a slider between the faces of its guide is shown."""
    name, clearance = escape(guide["name"]), measure(guide["clearance"], "m")
    words = (
        f"Slider on guide {name}: the gap on either side is the clearance of {clearance}; the block's height"
    )
    words += " is cut short; corners in contact are filled"
    force = ", the bars are the forces on the slider" if "force" in guide else ""
    canvas = f'<canvas id="guide{number}" role="img" aria-label="Slider on guide {name}"></canvas>'
    return f'<figure>{canvas}<figcaption class="note">{words}{force}</figcaption></figure>'
