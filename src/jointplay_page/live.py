"""The part of a page that computes: data of a mechanism for its sliders, pictures and solver;
and the frame of a page: its template, style and scripts.
"""

from __future__ import annotations

import base64
import shlex
from contextlib import suppress
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from typing import Any

from jointplay import figures
from jointplay.display import codes
from jointplay.display.errors import InputError
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.records import CrankAngle, Joint, Mechanism, TestSystem
from jointplay.study import toml_text
from jointplay.study.results.store import write_figure
from jointplay_page import moving, packed, texts
from jointplay_page.script.solver import LIMITS, Solver, solver

FIRST = ("clearance", "gear_ratio", "speed", "friction", "length", "stiffness", "damping")  # seen at once
MOST = 8
TURNS = 50  # of the study that a page gives
RTOL = 1e-7  # of the page's motions: exponents of orbits within 1e-4, forces within 1 % (tests/script)
BARS = {4: "Four-bar linkage", 6: "Six-bar linkage"}

SCRIPTS = ("page.js", "stage.js", "plots.js", "charts.js", "cells.js", "motion.js")
LIVE = ("verdict.js", "sliders.js", "pictures.js", "followed.js", "watched.js")


def live(mechanism: Mechanism | TestSystem, varied: list[str]) -> tuple[dict[str, Any] | None, str]:
    """Return the data with which a page computes a motion, ready for `packed.text`; or None, and the reason.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    varied : list of str
        Parameters along the axes of the page's charts.
    """
    try:
        made = solved(mechanism)
    except InputError as error:
        return None, f"This page does not compute: {error}."
    keys = [each["key"] for each in made.data["parameters"]]
    linkage = isinstance(mechanism, Mechanism)
    corners = {c: codes.contact(c) for c in mechanism.contacts if codes.contact(c) != c} if linkage else {}
    found = {
        "heading": heading(mechanism),
        "text": f"{made.text}\n{own('worker.js')}",
        "solver": made.data,
        "ideal": None,
        "scene": moving.scene(mechanism) if linkage else None,
        "limits": LIMITS | {"corners": corners, "body": "joint" if linkage else "wall"},
        "views": views(mechanism, made.data["state"]),
        "first": [key for word in FIRST for key in keys if key.split(".")[0] == word][:MOST] or keys[:MOST],
        "paths": (paths := paths_of(mechanism, made.data["parameters"])),
        "varied": {
            name: key
            for name in varied
            for key in keys[::-1]
            if name in key.split(".") and len(paths[key]) == 1
        },
        "file": shlex.quote(f"{file_stem(mechanism)}{texts.SAVED}"),
        "study": study(mechanism),
    }
    return with_ideal(found, mechanism), ""


def solved(mechanism: Mechanism | TestSystem) -> Solver:
    """Return the solver of a mechanism, cut once a turn where it has turns."""
    turns = mechanism.drive if isinstance(mechanism, Mechanism) else mechanism.period
    return solver(mechanism, section=CrankAngle() if turns else None, rtol=RTOL)


def with_ideal(found: dict[str, Any], mechanism: Mechanism | TestSystem) -> dict[str, Any]:
    """Add the solver of the same linkage without clearance, where that has one."""
    if not isinstance(mechanism, Mechanism) or not mechanism.clearance_joints:
        return found
    with suppress(InputError):  # its loops may not close by themselves
        made = solved(mechanism.replace(clearance=0.0))
        whole = f"const makeIdeal = (() => {{\n{made.text}\nreturn makeSolver;\n}})();\n{found['text']}"
        return found | {"text": whole, "ideal": made.data}
    return found


def views(mechanism: Mechanism | TestSystem, states: list[str]) -> list[dict[str, Any]]:
    """Return the views to draw: one of each bearing with clearance, else of each guide; else one plane."""
    loose = getattr(mechanism, "clearance_joints", ())
    found = [of_bearing(joint) for joint in loose if not joint.prismatic]
    plane = of_plane(mechanism, states)
    return found or [of_guide(joint, plane) for joint in loose] or [plane]


def of_bearing(joint: Joint) -> dict[str, Any]:
    """Return the view of a bearing: the journal in it, the force, the section of the journal's motion."""
    name = joint.name
    journal = [["journal_x", name], ["journal_y", name]]
    words = [f"Journal in {name}, x (clearances)", "y (clearances)"]
    return {
        "name": name,
        "orbit": journal,
        "force": ["normal_force", name],
        "ideal": ["reaction", name],
        "words": ["", "", f"Force at {name} (N)"],
        "circle": joint.clearance,
        "clearance": f"clearance.{name}",
        "section": {"of": journal, "words": words},
    }


def of_guide(joint: Joint, plane: dict[str, Any]) -> dict[str, Any]:
    """Return the view of a guide: the plane of a mechanism without play, the force of all its corners."""
    words = [*plane["words"][:2], f"Force at {joint.name}, all corners (N)"]
    return plane | {"name": joint.name, "force": ["normal_force", *joint.contacts], "words": words}


def of_plane(mechanism: Mechanism | TestSystem, states: list[str]) -> dict[str, Any]:
    """Return the view of a mechanism without bearings: two states of a system, angle and speed of a link."""
    if isinstance(mechanism, TestSystem):
        names = (states * 2)[:2]
        pair = [["state_value", name] for name in names]
    else:
        link = mechanism.links[-1].name
        pair = [["angle", link], ["angular_velocity", link]]
        names = [f"Angle of {link} (rad)", f"Speed of {link} (rad/s)"]
    section = {"of": pair, "words": names}
    plane = {"name": mechanism.name, "orbit": pair, "force": pair[0], "ideal": None, "circle": None}
    return plane | {"words": [*names, names[0]], "section": section}


def paths_of(mechanism: Mechanism | TestSystem, parameters: list[dict[str, Any]]) -> dict[str, list[str]]:
    """Return the paths of each slider's numbers in a study."""
    linkage = isinstance(mechanism, Mechanism) or named(mechanism)
    root = "mechanism" if linkage else "mechanism.parameters"
    return {each["key"]: [f"{root}.{path}" for path in each["paths"]] for each in parameters}


def named(mechanism: Mechanism | TestSystem) -> bool:
    """Return whether a test system is that of the catalog, whose period and start follow its parameters."""
    try:
        return isinstance(mechanism, TestSystem) and mechanism.replace() == mechanism
    except InputError:  # it is none of the catalog
        return False


def study(mechanism: Mechanism | TestSystem) -> str:
    """Return the text of a study of a motion, the mechanism written out."""
    plain = mechanism.numbers_alone() if isinstance(mechanism, Mechanism) else mechanism  # as on the page
    table = plain.model_dump(mode="json", exclude_none=True)
    if named(mechanism):
        table = {"catalog": mechanism.system} | mechanism.parameters
    lines = ['kind = "response"', "", "[mechanism]"]
    for key, value in table.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            lines += [f"{key} = [", *(f"  {toml_text.written(each)}," for each in value), "]"]
        elif value not in ([], {}):
            lines.append(f"{key} = {toml_text.written(value)}")
    tail = ["", "[integrator]", f"rtol = {RTOL}", "", "[analysis]", f"turns = {TURNS}", ""]
    return "\n".join(lines + tail)


def file_stem(mechanism: Mechanism | TestSystem) -> str:
    """Return a name for files."""
    return "_".join("".join(c if c.isalnum() else " " for c in mechanism.name).split()) or "mechanism"


def section(found: dict[str, Any]) -> str:
    """Return the place of a page where it computes."""
    circle = found["views"][0]["circle"]
    choice = "".join(f"<option>{escape(each['name'])}</option>" for each in found["views"])
    several = f'<label>{"Bearing" if circle else "Guide"} <select id="live-view">{choice}</select></label>'
    second = "; the second curve is the same mechanism without clearance"
    ideal, in_view = (second if each else "" for each in (found["ideal"], found["views"][0]["ideal"]))
    marks = "".join(
        f"<li>{escape(grade)}: {escape(words)}</li>" for grade, words in LIMITS["meaning"].items()
    )
    return Template(own("live.html")).substitute(
        linkage='<canvas id="live-linkage" role="img" aria-label="The mechanism in motion"></canvas>'
        * bool(found["scene"]),
        choice=several if len(found["views"]) > 1 else "",
        orbit="Journal in its bearing: the circle is the clearance, the arrow the force on the journal"
        if circle
        else "Phase plane",
        force=f"Over the turn{ideal and in_view}",
        strain=f"Largest force{ideal}",
        grades=f"<ul>{marks}</ul>" if found["scene"] else "",
        rtol=plain(RTOL, 1),
        file=escape(found["file"]),
        command=texts.copied("live-command", ""),
        study=texts.copied("live-study", found["study"]),
    )


def heading(mechanism: Mechanism | TestSystem) -> str:
    """Return what a mechanism is, in a few words."""
    if isinstance(mechanism, TestSystem):
        return mechanism.name.replace("_", " ").capitalize()
    bars, sliding = len(mechanism.links) + 1, [joint for joint in mechanism.joints if joint.prismatic]
    kind = BARS.get(bars, f"Linkage of {bars} links")
    if (bars, len(mechanism.joints)) == (4, 4) and sliding:
        kind = sliding_kind([{joint.journal.link, joint.bearing.link} for joint in sliding])
    loose = [joint.name for joint in mechanism.clearance_joints]
    where = f"joint{'s' * (len(loose) > 1)} {' and '.join(loose)}"
    return f"{kind} with clearance at {where}" if loose else f"{kind} with ideal joints"


def sliding_kind(ends: list[set[str]]) -> str:
    """Return what a loop of four links is called by the pairs of links that slide on each other."""
    if len(ends) == 1:
        return "Slider-crank" if GROUND in ends[0] else "Inverted slider-crank"
    common, guided = set.intersection(*ends), any(GROUND in pair for pair in ends)
    return "Scotch yoke" if guided and common and GROUND not in common else "Double slider"


def about(mechanism: Mechanism | TestSystem, computes: bool) -> str:
    """Return what a page of a mechanism shows, in words."""
    given = []
    if isinstance(mechanism, Mechanism):
        loose = ((measure(joint.clearance, "m"), joint.name) for joint in mechanism.clearance_joints)
        given = [f"{size} of clearance at joint {name}" for size, name in loose]
        given += [mechanism.drive.description] if mechanism.drive else []
    start = f"At the start: {'; '.join(given)}. " if given else ""
    asks = "whether a joint rattles, and how hard" if "clearance" in start else "what becomes of it"
    how = f"The motion is computed in this page: move a slider, and see {asks}." if computes else ""
    return f"{start}{how}".strip()


def page(mechanism: Mechanism | TestSystem, title: str = "") -> str:
    """Return the HTML of a page of a mechanism alone."""
    found, why = live(mechanism, [])
    still = ""
    if isinstance(mechanism, Mechanism):
        with TemporaryDirectory() as folder:
            still = picture(write_figure(figures.draw(mechanism), Path(folder) / "mechanism.png"))
    data = {"live": found, "cells": None, "motion": None, "panels": []}
    return filled(
        title or heading(mechanism),
        data,
        kind=escape(about(mechanism, bool(found))),
        still=still,
        shown="" if found else f"<p>{escape(why)}</p>{still}",
        live=section(found) if found else "",
        numbers=numbers(found, mechanism),
        origin="<p>The page was made from the mechanism alone.</p>",
    )


def numbers(found: dict[str, Any] | None, mechanism: Mechanism | TestSystem) -> str:
    """Return a table of the sliders' first values, and the mechanism in words."""
    given = found["solver"]["parameters"] if found else []
    rows = (
        texts.row(each["label"], f"{measure(each['value'] * each['factor'], '1')} {each['unit']}".strip())
        for each in given
    )
    table = f'<div class="wide"><table>{"".join(rows)}</table></div>' if given else ""
    return f"{table}<pre>{escape(mechanism.summary())}</pre>"


LIVE += ("live.js", "diagram.js", "point.js")


def filled(title: str, data: dict[str, Any], **parts: str) -> str:
    """Return the HTML of a page.

    Parameters
    ----------
    title : str
        Of the page.
    data : dict
        What its scripts need.
    **parts : str
        HTML of the template's places; those left out stay empty.
    """
    empty = dict.fromkeys(("kind", "answer", "still", "shown", "cell", "motion", "live"), "")
    scripts = SCRIPTS + (LIVE if data.get("live") else ())
    own_parts = {"style": own("page.css"), "data": packed.text(data), "script": "\n".join(map(own, scripts))}
    return Template(own("page.html")).substitute(empty | {"title": escape(title)} | own_parts | parts)


def own(name: str) -> str:
    """Return the text of a file in this package."""
    return files("jointplay_page").joinpath(name).read_text(encoding="utf-8")


def picture(path: Path) -> str:
    """Return a picture inside the page."""
    encoded = base64.b64encode(path.read_bytes()).decode()
    return f'<img alt="What the page is about" src="data:image/png;base64,{encoded}">'
