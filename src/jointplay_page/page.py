"""The HTML of a page: pictures, the page's own script and style, and the data, in one text."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from jointplay.display.units import measure
from jointplay.study.results.summary import Summary
from jointplay_page import charts, live, sweep_points, template, texts


def html(content: Any, answer: Summary, *still: Path) -> str:
    """Return the page of a `report.Content` with its answer and still pictures."""
    known = [*sweep_points.parameters(content.dataset), *(["time"] if content.motion else [])]
    data = {"cells": content.cells, "motion": content.motion, "live": content.live}
    data["panels"] = [
        panel | {"picture": number}
        for number, figure in enumerate(content.figures.values())
        for panel in charts.panels(figure, content.dataset, known)
    ]
    return template.filled(
        str(content.dataset.attrs.get("title") or answer.title),
        data,
        kind=escape(answer.title),
        answer=escape("\n".join(answer.lines)),
        still="".join(map(template.picture, still)),
        live=live.section(content.live) if content.live else "",
        shown="".join(map(section, range(len(content.svgs)), content.svgs, content.svgs.values())),
        cell=cell_section(content),
        motion=motion_section(content),
        numbers=texts.numbers(content.dataset, sweep_points.parameters(content.dataset)),
        origin=texts.origin(content.origin),
    )


def section(number: int, kind: str, svg: str) -> str:
    """Return a picture with its heading, and the places of what a pointer is at and of the way back."""
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
    if {"up", "down"} & {word for way in content.cells["ways"] for word in way.split()}:
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
