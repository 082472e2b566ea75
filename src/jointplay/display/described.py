"""Descriptions of parameters and fields, as the docstrings of functions and records give them."""

import re
from inspect import getdoc, isclass
from typing import Any


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


def _parameters(doc: str) -> dict[str, str]:
    text = doc.partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    paragraphs = re.findall(r"^(\S[^:\n]*?)(?: :.*)?\n((?:    .*\n?)+)", text, re.M)
    return {name: " ".join(about.split()) for names, about in paragraphs for name in names.split(", ")}


def first_sentence(text: str) -> str:
    """Give the first sentence of a description, without its full stop."""
    return re.split(r"\.\s+(?=[A-Z0-9])|\.$", text, maxsplit=1)[0]
