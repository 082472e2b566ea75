"""Descriptions of parameters and fields, as the docstrings of functions and records give them."""

import re
import textwrap
from collections.abc import Iterable
from inspect import cleandoc, getdoc, isclass
from typing import Any

_HEAD = "Parameters\n----------\n"


def descriptions(documented: Any) -> dict[str, str]:
    """Give the description of each parameter of a function, or of each field of a record, in one line.

    Parameters
    ----------
    documented : function or type
        With a numpydoc docstring; of a record, those of its bases hold too.

    Returns
    -------
    dict of str to str
        By name, in the order of the docstring.
    """
    if isclass(documented):
        above = [base for base in documented.__mro__ if base.__doc__ and base is not object]
        texts = [_parameters(getdoc(base) or "") for base in reversed(above)]
        return {name: text for each in texts for name, text in each.items()}
    return _parameters(getdoc(documented) or "")


def with_parameters(doc: str | None, *more: type) -> str:
    """A docstring extended by the parameters of classes, except any that it describes itself."""
    text = cleandoc(doc or "")
    known, told = {*_parameters(text)}, ""
    for names, kind, about in (each for one in more for each in _paragraphs(getdoc(one) or "")):
        left = [name for name in names.split(", ") if name not in known]
        told += f"\n{', '.join(left)}{kind}\n{about.rstrip()}" if left else ""
        known |= {*left}
    before, head, after = text.partition(_HEAD)
    own, gap, rest = after.partition("\n\n")
    return before + head + own + told + gap + rest


def with_returns(doc: str | None, given: str) -> str:
    """A docstring with a section `Returns` on a dataset, put before `Raises`."""
    before, gap, rest = cleandoc(doc or "").partition("\n\nRaises\n------\n")
    lines = textwrap.indent(given, "    ", lambda line: True)
    return f"{before}\n\nReturns\n-------\nxarray.Dataset\n{lines}{gap}{rest}"


def _paragraphs(doc: str) -> Iterable[tuple[str, str, str]]:
    """Names, kind and meaning of the parameters of a docstring, as they stand there."""
    text = doc.partition(_HEAD)[2].partition("\n\n")[0]
    return re.findall(r"^(\S[^:\n]*?)( :.*)?\n((?:    .*\n?)+)", text, re.M)


def _parameters(doc: str) -> dict[str, str]:
    found = _paragraphs(doc)
    return {name: " ".join(about.split()) for names, _, about in found for name in names.split(", ")}


def first_sentence(text: str) -> str:
    """Give the first sentence of a description, without its full stop."""
    return re.split(r"\.\s+(?=[A-Z0-9`])|\.$", text, maxsplit=1)[0]
