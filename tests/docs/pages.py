"""The pages of the documentation, their code blocks, and what docs/pages writes."""

import importlib.util
import re
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
_BLOCK = re.compile(r"(?:`([\w./-]+\.toml)`[^\n`]*:\n\n)?```(\w+)\n(.*?)```", re.DOTALL)


class Block(NamedTuple):
    """A code block: the file that the line before it names, its language, its text."""

    file: str
    language: str
    text: str


def blocks(page):
    """Code blocks of a page in their order."""
    return [Block(*found) for found in _BLOCK.findall(page.read_text(encoding="utf-8"))]


def generated():
    """The package docs/pages."""
    if "pages" not in sys.modules:
        where = DOCS / "pages" / "__init__.py"
        spec = importlib.util.spec_from_file_location(
            "pages", where, submodule_search_locations=[str(where.parent)]
        )
        sys.modules["pages"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules["pages"])
    return sys.modules["pages"]
