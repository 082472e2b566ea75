"""The frame of a page: its template, style and scripts."""

from __future__ import annotations

import base64
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from jointplay_page import packed

SCRIPTS = ("page.js", "stage.js", "plots.js", "charts.js", "cells.js", "motion.js")
LIVE = ("verdict.js", "sliders.js", "pictures.js", "followed.js", "watched.js")
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
