"""Notebooks as pages: their text, and their code to be read; outputs are made by whoever runs them."""

from __future__ import annotations

import json
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "notebooks"
NOTE = "*This page is the notebook `docs/notebooks/{}`, which the continuous integration runs.*\n"


def cells(path: Path) -> list[tuple[str, str]]:
    """Kind and text of each cell of a notebook."""
    found = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def page(path: Path) -> str:
    """A notebook as Markdown."""
    parts = [text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in cells(path)]
    return "\n\n".join([*parts, NOTE.format(path.name)])


def pages() -> dict[str, str]:
    """The pages of all notebooks."""
    return {f"{path.stem}.md": page(path) for path in sorted(FOLDER.glob("*.ipynb"))}
