"""A page for every kind of study: what it answers, a picture, its keys, its figures, the shipped studies."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from jointplay import figures
from jointplay.figures.registry import suited
from jointplay.kinds import KINDS, Kind
from jointplay.study.models import ELSEWHERE, INTEGRATOR
from pages.keys import HEAD, keyword_rows
from pages.text import markdown, story, summary, table

ROOT = Path(__file__).parents[2]
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


def page(row: Kind) -> str:
    """The page of one kind."""
    own = shipped(row.name)
    parts = [f"# {row.name}\n", f"{markdown(story(row.function))}\n"]
    if own and picture(own[0]):
        parts.append(
            f"![{title(own[0])}]({picture(own[0])})\n\n*{title(own[0])}*: `{own[0].relative_to(ROOT)}`.\n"
        )
    hidden = frozenset((*ELSEWHERE, *INTEGRATOR))
    parts.append(f"## Keys of `[analysis]`\n\n{table(HEAD, keyword_rows(row.function, hidden))}")
    rows = [
        (f"`{name}`", f"`{dims}`" if dims else "–", units, markdown(meaning))
        for name, dims, units, meaning in row.outputs.told()
    ]
    if rows:
        head = ("variable", "over", "unit", "meaning")
        parts.append(f"## What it gives\n\n{table(head, rows)}\n{markdown(' '.join(row.outputs.notes()))}\n")
    drawn = [
        (f"[`{name}`](figures.md#{name})", markdown(summary(figures.KINDS[name]))) for name in suited(row)
    ]
    parts.append(f"## Figures\n\n{table(('kind of figure', 'what it draws'), drawn)}")
    if own:
        listed = [(f"`{path.relative_to(ROOT)}`", markdown(title(path))) for path in own]
        text = own[0].read_text(encoding="utf-8").strip()
        parts.append(
            f"## Shipped studies\n\n{table(('file', 'what it shows'), listed)}\nThe first of them:\n"
        )
        parts.append(f"```toml\n{text}\n```\n")
    parts.append(f"In Python: {{py:func}}`jointplay.{row.home.partition(':')[2]}`.\n")
    return "\n".join(parts)


def pages() -> dict[str, str]:
    """The pages of all kinds, and the one that lists them."""
    figures.KINDS  # noqa: B018  all figures are imported
    found = {f"kind_{name}.md": page(row) for name, row in KINDS.items()}
    rows = [
        (f"[`{name}`](kind_{name}.md)", markdown(summary(row.function)), "yes" if row.varies else "no")
        for name, row in KINDS.items()
    ]
    names = "\n".join(f"kind_{name}" for name in KINDS)
    found["kinds.md"] = (
        "# Kinds of study\n\n"
        "The key `kind` of a study file says which question is asked.\n"
        "Every kind but those marked “no” can be swept over parameters by a table `[vary]`.\n\n"
        f"{table(('kind', 'what it gives', 'with `[vary]`'), rows)}\n"
        f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    )
    return found
