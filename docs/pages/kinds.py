"""Every kind of study: its picture, keys, results, figures and shipped studies, below the text of docs/kinds.

A kind of another package has no such text, and a page of its own with what its docstring says.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from jointplay import figures
from jointplay.figures.registry import suited
from jointplay.kinds import KINDS, Kind
from jointplay.study import cite
from jointplay.study.models import ELSEWHERE, INTEGRATOR
from pages.keys import HEAD, keyword_rows
from pages.text import markdown, story, summary, table

ROOT = Path(__file__).parents[2]
TEXTS = ROOT / "docs" / "kinds"
PICTURES = (ROOT / "docs" / "images", ROOT / "results" / "paper")


@cache
def studies() -> dict[Path, dict[str, Any]]:
    """Every shipped study by its path."""
    paths = sorted((ROOT / "studies").rglob("*.toml"))
    return {path: tomllib.loads(path.read_text(encoding="utf-8")) for path in paths}


def picture(study: Path) -> str:
    """Where a shipped study's picture is, from docs/generated; empty: it has none."""
    found = [folder / f"{study.stem}.png" for folder in PICTURES if (folder / f"{study.stem}.png").exists()]
    return f"../../{found[0].relative_to(ROOT).as_posix()}" if found else ""


def title(study: Path) -> str:
    """What a shipped study says of itself."""
    return studies()[study].get("title") or study.stem.replace("_", " ")


def shipped(kind: str) -> list[Path]:
    """Paths of the shipped studies of a kind, those with a picture first."""
    return sorted(
        (path for path, table in studies().items() if table["kind"] == kind), key=lambda p: not picture(p)
    )


def place(kind: str) -> str:
    """Where the page of a kind is, from docs/generated."""
    return f"../kinds/{kind}.md" if (TEXTS / f"{kind}.md").exists() else f"kind_{kind}.md"


def tables(row: Kind) -> str:
    """What the page of a kind has below its text."""
    own, parts = shipped(row.name), []
    if own and picture(own[0]):
        parts.append(
            f"![{title(own[0])}]({picture(own[0])})\n\n*{title(own[0])}*: `{own[0].relative_to(ROOT)}`.\n"
        )
    hidden = frozenset((*ELSEWHERE, *INTEGRATOR))
    if keys := list(keyword_rows(row.function, hidden)):
        parts.append(f"## Keys of `[analysis]`\n\n{table(HEAD, keys)}")
    rows = [
        (f"`{name}`", f"`{dims}`" if dims else "–", units, markdown(meaning))
        for name, dims, units, meaning in row.outputs.rows()
    ]
    if rows:
        head = ("variable", "over", "unit", "meaning")
        said = markdown(story(row.function).partition("\n\n")[2])
        parts.append(f"## What it gives\n\n{said}\n\n{table(head, rows)}")
        parts.append(f"{markdown(' '.join(row.outputs.notes()))}\n")
    drawn = [
        (f"[`{name}`](../generated/figures.md#{name})", markdown(summary(figures.KINDS[name])))
        for name in suited(row)
    ]
    parts.append(f"## Figures\n\n{table(('kind of figure', 'what it draws'), drawn)}")
    if own:
        listed = [(f"`{path.relative_to(ROOT)}`", markdown(title(path))) for path in own]
        text = own[0].read_text(encoding="utf-8").strip()
        parts.append(
            f"## Shipped studies\n\n{table(('file', 'what it shows'), listed)}\nThe first of them:\n"
        )
        parts.append(f"```toml\n{text}\n```\n")
    if row.references:
        cited = "\n".join(f"- {markdown(cite._line(cite._entry(key)))}" for key in row.references)
        parts.append(f"## References\n\n{cited}\n")
    parts.append(f"In Python: {{py:func}}`jointplay.{row.home.partition(':')[2]}`.\n")
    return "\n".join(parts)


def page(row: Kind) -> str:
    """The page of a kind that has no text."""
    said = markdown(summary(row.function))
    return f"# {row.name}\n\n{said}\n\n```{{include}} kind_{row.name}.inc\n```\n"


def pages() -> dict[str, str]:
    """Tables of all kinds, pages of those without a text, and the page that lists them."""
    figures.KINDS  # noqa: B018  all figures are imported
    found = {f"kind_{name}.inc": tables(row) for name, row in KINDS.items()}
    found |= {place(name): page(row) for name, row in KINDS.items() if not (TEXTS / f"{name}.md").exists()}
    rows = [
        (f"[`{name}`]({place(name)})", markdown(summary(row.function)), "yes" if row.varies else "no")
        for name, row in KINDS.items()
    ]
    names = "\n".join(place(name).removesuffix(".md") for name in KINDS)
    found["kinds.md"] = (
        "# Kinds of study\n\n"
        "The key `kind` of a study file says which question is asked.\n"
        "Every kind but those marked “no” can be swept over parameters by a table `[vary]`.\n\n"
        f"{table(('kind', 'what it does', 'with `[vary]`'), rows)}\n"
        f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    )
    return found
