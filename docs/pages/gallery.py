"""The gallery: every shipped study that has a picture, and what is seen in it."""

from __future__ import annotations

import tomllib
from pathlib import Path

from pages.kinds import ROOT, picture, studies, title
from pages.text import markdown

SEEN = tomllib.loads(Path(__file__).with_name("seen.toml").read_text(encoding="utf-8"))


def page() -> str:
    """The page of all pictures, by folder of studies."""
    parts = [
        "# Gallery\n",
        "Each picture comes from the study file under it; `jointplay run` makes it again.\n",
    ]
    folder = None
    for path in studies():
        if not picture(path):
            continue
        if path.parent != folder:
            folder = path.parent
            parts.append(f"## {folder.relative_to(ROOT).as_posix()}\n")
        name = path.relative_to(ROOT).as_posix()
        shown = f"```{{image}} {picture(path)}\n:alt: {title(path)}\n:width: 420px\n```"
        seen = f"\n*What you see:* {SEEN[path.stem]}\n" if path.stem in SEEN else ""
        parts.append(f"{shown}\n\n{markdown(title(path))}: `{name}`\n{seen}")
    return "\n".join(parts)
