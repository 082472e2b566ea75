"""Pages of the documentation, their code blocks, a reader who does what they say, what docs/pages writes."""

import importlib.util
import math
import os
import re
import shlex
import shutil
import sys
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(ROOT.glob("*.md")), *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("how-to/*.md"))]
_BLOCK = re.compile(r"(?:`([\w./-]+\.(?:toml|csv))`[^\n`]*:\n\n)?```(\w+)\n(.*?)```", re.DOTALL)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?: ± \d+(?:\.\d+)?)?")


class Block(NamedTuple):
    """A code block: the file that the line before it names, its language, its text."""

    file: str
    language: str
    text: str


def blocks(page):
    """Code blocks of a page in their order."""
    return [Block(*found) for found in _BLOCK.findall(page.read_text(encoding="utf-8"))]


def commands(block):
    """Lines of a shell block that call jointplay, as lists of words."""
    lines = re.split(r"\n| && ", block.text) if block.language == "sh" else []
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("jointplay ")]


def _near(said, promised):
    """Whether a number is the one promised, digit by digit; with an error, whether within four of them."""
    pairs = [[float(each) for each in text.split(" ± ")] for text in (said, promised)]
    if not all(len(pair) == 2 for pair in pairs):
        return said == promised
    (value, error), (other, its) = pairs
    return abs(value - other) <= 4 * math.hypot(error, its) and its / 3 <= error <= 3 * its


def alike(said, promised):
    """Whether a line of output says what the page promises, in its words and its numbers."""
    said, promised = (text.strip().replace("\N{MINUS SIGN}", "-") for text in (said, promised))
    ours, theirs = _NUMBER.findall(said), _NUMBER.findall(promised)
    return _NUMBER.sub("#", said) == _NUMBER.sub("#", promised) and all(map(_near, ours, theirs))


def follow(page, folder, capsys):
    """Do in an empty folder what a page says, and hold what is printed against it.

    Tables that the line above names are saved, commands run beside the shipped studies, Python runs in one
    session. A block of text is of what was printed last, the comment behind a `print` is what that prints.
    """
    from jointplay import cli
    from jointplay.solver.equations.friction import FRICTIONS
    from jointplay.solver.equations.laws import LAWS

    shutil.copytree(ROOT / "studies", folder / "studies")
    said, space = "", {}
    with patch.dict(LAWS), patch.dict(FRICTIONS):  # a law that a page adds is gone behind it
        for block in blocks(page):
            if block.file:
                (folder / block.file).write_text(block.text, encoding="utf-8")
            for words in commands(block):
                assert cli.main([os.path.expandvars(word) for word in words]) == 0, words
            if block.language == "python":
                exec(compile(block.text, page.name, "exec"), space)
            said = capsys.readouterr().out or said
            promised = block.text.splitlines() if block.language == "text" else []
            if block.language == "python":
                promised = re.findall(r"^ *print\(.*\)  # (.+)$", block.text, re.MULTILINE)
            for line in filter(str.strip, promised):
                assert any(alike(each, line) for each in said.splitlines()), (line, said)


def unfounded(page):
    """Numbers of a page's sentences that stand in none of its blocks."""
    text = page.read_text(encoding="utf-8")
    prose = re.sub(r"```.*?```|`[^`\n]+`|\]\([^)]*\)|^#+ .*?$", " ", text, flags=re.DOTALL | re.MULTILINE)
    shown = {*re.findall(r"\d+(?:\.\d+)?", "".join(block.text for block in blocks(page)))}
    return [each for each in re.findall(r"\d+(?:\.\d+)?", prose) if each not in shown]


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
