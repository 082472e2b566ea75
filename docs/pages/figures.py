"""Every figure: what it draws, and its options with their defaults."""

from __future__ import annotations

from collections.abc import Iterator

from jointplay import figures
from jointplay.figures.registry import suited
from jointplay.kinds import KINDS
from pages.keys import written_default
from pages.kinds import place
from pages.text import markdown, parameters, story, table


def options(name: str) -> Iterator[tuple[str, str, str]]:
    """A row for each option of a figure."""
    draw = figures.KINDS[name]
    said = parameters(draw)
    for key, default in (draw.__wrapped__.__kwdefaults__ or {}).items():
        yield f"`{key}`", written_default(default), said[key]


def page() -> str:
    """The page of all figures."""
    parts = [
        "# Every figure\n",
        "`[figure]` of a study file takes these keys, and so do `jp.figure` and\n"
        "`jointplay figure RESULT.nc --kind KIND --set KEY=VALUE`.\n"
        "Every figure also takes `width` (mm) and `font`, in Python `ax`.\n",
    ]
    for name in sorted(figures.KINDS):
        of = [f"[`{row.name}`]({place(row.name)})" for row in KINDS.values() if name in suited(row)]
        parts.append(f"## {name}\n\n{markdown(story(figures.KINDS[name]))}\n")
        parts.append(f"Of results of kind {', '.join(of)}.\n" if of else "Of a mechanism, not of a result.\n")
        if rows := list(options(name)):
            parts.append(table(("option", "default", "meaning"), rows))
    return "\n".join(parts)
