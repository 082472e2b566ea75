"""What docstrings say of parameters, and Markdown tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from inspect import cleandoc
from typing import Any

_PARAMETER = re.compile(r"^(\S[^:\n]*?)(?: : (.*))?\n((?:    .*\n?|\n)*)", re.MULTILINE)


def summary(described: Any) -> str:
    """First line of a docstring."""
    return cleandoc(described.__doc__).partition("\n")[0]


def story(described: Any) -> str:
    """A docstring up to its first section."""
    return re.split(r"\n(?:\w[\w ]*)\n---+\n", cleandoc(described.__doc__))[0].strip()


def parameters(described: Any) -> dict[str, str]:
    """Meaning of each parameter of a docstring in numpydoc's form; names that share a text each have it."""
    text = cleandoc(described.__doc__ or "")
    found = re.search(r"^Parameters\n-+\n(.*?)(?=^\w[\w ]*\n-+\n|\Z)", text, re.MULTILINE | re.DOTALL)
    meanings = {}
    for names, _, lines in _PARAMETER.findall(found[1] + "\n" if found else ""):
        meanings |= dict.fromkeys(re.split(r",\s*", names), markdown(" ".join(lines.split())))
    return meanings


def markdown(text: str) -> str:
    """Text of a docstring as Markdown."""
    return re.sub(r"(?<!`)``?([^`]+)``?(?!`)", r"`\1`", text).replace("|", r"\|").replace("*", r"\*")


def unmarked(text: str) -> str:
    """A page without the marks by which measured numbers are found (`docs/measured.py`)."""
    return re.sub(r"<!--(=[\w.]+|/)-->", "", text)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines) + "\n"
