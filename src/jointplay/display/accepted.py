"""Errors of pydantic in plain English, with the accepted values read from the model's fields.

Nouns and units come from a field's description and its `units`; limits from its constraints.

Descriptions of parameters and fields, as the docstrings of functions and records give them.
"""

from __future__ import annotations

import math
import numbers
import re
import textwrap
import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import cleandoc, getdoc, isclass
from typing import Any

from jointplay.display.errors import NOTHING, SHOWN, InputError, Problem, join, unknown
from jointplay.display.number_text import typed

_UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
_LISTS, _TABLES = (tuple, list, Sequence), (dict, Mapping)
_BOUNDS = {"gt": "greater than", "ge": "of at least", "lt": "less than", "le": "at most"}

_HEAD = "Parameters\n----------\n"


def from_pydantic(error: Any, model: Any = None, root: str = "") -> InputError:
    """Turn a pydantic ``ValidationError`` into an `InputError`.

    Parameters
    ----------
    error : pydantic.ValidationError
        As pydantic raised it.
    model : type, optional
        The model that was validated: gives the known keys, and nouns and units of its fields.
    root : str, optional
        Put before every key, as ``mechanism`` in ``mechanism.links[0].mass``.
    """
    details = error.errors(include_url=False)
    nested = (detail.get("ctx", {}).get("error") for detail in details)
    more = max(0, len(details) - SHOWN) + sum(getattr(error, "more", 0) for error in nested)
    problems = (problem for detail in details[:SHOWN] for problem in _problems(detail, model, root))
    return InputError(problems, root, more)


@dataclass(frozen=True)
class Refused:
    """Stand-in for a value found wrong before validation: no field takes it, and `error` says why."""

    error: InputError


def units_of(field: Any) -> str | None:
    """Units that a model's field declares; None where it holds no quantity."""
    return _Spot(field.annotation, field)._description.get("units")


def accepted_values(annotation: Any, field: Any = None) -> str:
    """Values that a type takes, as ``a number greater than 0``; empty where the type does not say."""
    return _Spot(annotation, field).values().removesuffix(",")


def bounds_of(field: Any) -> dict[str, float]:
    """Limits of a model's field by name: ``gt``, ``ge``, ``lt``, ``le``."""
    return _bounds(getattr(field, "metadata", ())) | _bounds([field.annotation] if field else ())


def _problems(detail: Mapping[str, Any], model: Any, root: str) -> list[Problem]:
    """Turn one of pydantic's error details into problems with keys under a root."""
    spot = _Spot(model)
    kind, given, context = detail["type"], detail["input"], detail.get("ctx", {})
    *parents, last = detail["loc"] or (None,)
    if kind in _UNKNOWN_KEY:
        key, spot = _walk(parents, spot, root)
        return [unknown(join(key, str(last)), given, last, spot.keys())]
    key, spot = _walk(detail["loc"], spot, root)
    if isinstance(given, Refused):
        return given.error.under(key).problems
    if isinstance(context.get("error"), InputError):
        return context["error"].under(key).problems
    if kind == "union_tag_invalid" or (kind == "union_tag_not_found" and isinstance(given, Mapping)):
        return [_wrong_kind(key, spot, given, context)]
    if last == "[key]":
        return [Problem(key, given, "names, as text, are accepted")]
    if kind == "value_error":
        return [Problem(key, given, str(context["error"]))]
    missing = kind.startswith("missing")
    given, otherwise = (NOTHING, "a value is needed here") if missing else (given, detail["msg"])
    values = spot.values(given)
    return [Problem(key, given, f"{values} is accepted" if values else otherwise)]


def _wrong_kind(key: str, spot: _Spot, given: Any, context: Mapping[str, Any]) -> Problem:
    field = context["discriminator"].strip("'")
    if "()" in field:  # told apart by a function, not by a key
        return Problem(key, given, f"one of {context.get('expected_tags', 'the listed forms')} is accepted")
    word = given.get(field, NOTHING) if isinstance(given, Mapping) else context.get("tag", NOTHING)
    tags = [tag.strip(" '") for tag in context.get("expected_tags", "").split(",") if tag]
    if not tags:
        known = list(dict.fromkeys(spot.kinds()))
        forms = f": one of {', '.join(map(repr, known))}" if known else ""
        text = f"a {field} is needed here, to say which form this is{forms}"
        return Problem(join(key, field), NOTHING, text)
    return unknown(join(key, field), word, word, tags, field)


def _walk(location: Iterable[Any], spot: _Spot, key: str) -> tuple[str, _Spot]:
    """Follow a pydantic location from a model, leaving out mere names of members of a union."""
    for element in location:
        spot, shown = spot.step(element)
        if shown:
            key = join(key, f"[{element}]" if isinstance(element, int) else str(element))
    return key, spot


@dataclass(frozen=True)
class _Spot:
    """Place in a model: the type expected there, the nearest field, the description of the list it is in."""

    annotation: Any = None
    field: Any = None
    around: Mapping[str, Any] | None = None

    def step(self, element: Any) -> tuple[_Spot, bool]:
        members = _members(self.annotation)
        if isinstance(element, int):
            rows = [m for m in map(_bare, members) if typing.get_origin(m) in _LISTS]
            items = typing.get_args(rows[0]) if rows else (None,)
            return self._inside(items[0 if items[-1] is ... else min(element, len(items) - 1)]), True
        if len(members) > 1:
            tagged = [m for m in members if element.removeprefix("constrained-") in _tags(m)]
            return _Spot(tagged[0] if tagged else None, self.field, self._description), False
        member = _bare(members[0]) if members else None
        if element in (fields := _fields(member)):
            return _Spot(fields[element].annotation, fields[element]), True
        values = typing.get_args(member)[1:] if typing.get_origin(member) in _TABLES else ()
        return self._inside(values[0] if values else None), element != "[key]"

    def _inside(self, annotation: Any) -> _Spot:
        """Give the place of an item: a field's description holds for its items, unless they are records."""
        records = any(_fields(_bare(member)) for member in _members(annotation))
        return _Spot(annotation) if records else _Spot(annotation, self.field, self._description)

    @property
    def _description(self) -> dict[str, Any]:
        """Noun, units and accepted values, as far as its field or its type gives them."""
        description = dict(self.around or {})
        for mark in (self.field, *_marks(self.annotation)):
            extra = getattr(mark, "json_schema_extra", None)
            if isinstance(extra, Mapping):
                description |= extra | {"noun": mark.description or ""}
        return description

    def kinds(self) -> list[str]:
        return [kind for member in _members(self.annotation) for kind in _kinds(_bare(member))]

    def keys(self) -> list[str]:
        return [name for member in _members(self.annotation) for name in _fields(_bare(member))]

    def values(self, given: Any = NOTHING) -> str:
        """The accepted values, a clause with the comma that ends it; empty if the model does not tell."""
        extra, bare = self._description, [_bare(member) for member in _members(self.annotation)]
        one = bare[0] if len(bare) == 1 else None
        form, parts = typing.get_origin(one), typing.get_args(one)
        if "accepts" in extra:
            return extra["accepts"]
        if form is typing.Literal:
            return "one of " * (len(parts) > 1) + ", ".join(map(repr, parts))
        if one in (float, int):
            return self._number(one, extra, given)
        if one in (bool, str):
            text = f"a {extra['noun']}, as text," if extra.get("noun") else "text"
            return "true or false" if one is bool else text
        items = ["…" if part is ... else self._inside(part).values().removesuffix(",") for part in parts]
        if form in _TABLES:
            return f"a table {{ name = {items[1] or '…'}; … }}"
        if form in _LISTS:
            return f"a list [{'; '.join(filter(None, items))}{'; …' * (form is not tuple)}]"
        kinds = " or ".join(map(repr, self.kinds()))
        words = ", ".join(self.keys()) if one else f"kind {kinds}" if kinds else ""
        return f"a table of {words}" if words else "an empty table" * hasattr(one, "model_fields")

    def _number(self, kind: type, extra: Mapping[str, Any], given: Any) -> str:
        plain = "whole number" if kind is int else "number"
        noun = extra["noun"] if "units" in extra else plain
        units = extra.get("units", "1")
        bounds = _bounds(getattr(self.field, "metadata", ())) | _bounds([self.annotation])
        limits = " and ".join(f"{_BOUNDS[name]} {typed(value)}" for name, value in bounds.items())
        unit = "" if units == "1" else f" {units}" if limits else f" in {units}"
        is_number = isinstance(given, numbers.Number) and not isinstance(given, bool)
        form = "" if is_number or given is NOTHING or noun == plain else f", as a {plain},"
        if isinstance(given, str) and units != "1" and kind is float:
            form = f", as a number or a text with its unit such as '3 {units}',"
        endless = is_number and not _finite(given) and not {"lt", "le"} & bounds.keys()
        words = " ".join(["finite"] * (endless or not limits) + [noun] + [limits] * bool(limits))
        return f"{article(words)} {words}{unit}{form}"


def _finite(given: Any) -> bool:
    try:
        return math.isfinite(given)
    except (OverflowError, TypeError):  # beyond a float; complex
        return False


def article(words: str) -> str:
    """The indefinite article before these words."""
    return "an" if words[0].lower() in "aeiou" and not words.startswith("uni") else "a"


def _bare(annotation: Any) -> Any:
    while typing.get_origin(annotation) is typing.Annotated:
        annotation = typing.get_args(annotation)[0]
    return annotation


def _members(annotation: Any) -> list[Any]:
    """List the types that a union holds, without None; one type is a union of one."""
    bare = _bare(annotation)
    if typing.get_origin(bare) in (typing.Union, types.UnionType):
        return [m for part in typing.get_args(bare) if part is not type(None) for m in _members(part)]
    return [] if annotation is None else [annotation]


def _fields(model: Any) -> Mapping[str, Any]:
    return getattr(model, "model_fields", {})


def _tags(member: Any) -> list[str]:
    """List the names by which pydantic distinguishes this member of a union from the others."""
    marks = [mark.tag for mark in typing.get_args(member)[1:] if hasattr(mark, "tag")]
    return [*marks, *_kinds(_bare(member)), getattr(_bare(member), "__name__", "")]


def _kinds(model: Any) -> list[str]:
    """List the values of the field `kind`, which distinguishes the records of a family."""
    field = _fields(model).get("kind")
    return list(typing.get_args(_bare(field.annotation))) if field else []


def _marks(annotation: Any) -> Iterator[Any]:
    """Metadata in `Annotated` of a type, or of the members of a union."""
    if typing.get_origin(annotation) is typing.Annotated:
        yield from _marks(typing.get_args(annotation)[0])
        yield from typing.get_args(annotation)[1:]
    elif typing.get_origin(annotation) in (typing.Union, types.UnionType):
        yield from (mark for member in typing.get_args(annotation) for mark in _marks(member))


def _bounds(marks: Iterable[Any]) -> dict[str, float]:
    """Collect limits from a field's metadata and from Annotated types inside it."""
    bounds: dict[str, float] = {}
    for mark in marks:
        bounds |= {name: getattr(mark, name) for name in _BOUNDS if getattr(mark, name, None) is not None}
        bounds |= _bounds((*getattr(mark, "metadata", ()), *_marks(mark)))
    return bounds


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
    known, added = {*_parameters(text)}, ""
    for names, kind, about in (each for one in more for each in _paragraphs(getdoc(one) or "")):
        left = [name for name in names.split(", ") if name not in known]
        added += f"\n{', '.join(left)}{kind}\n{about.rstrip()}" if left else ""
        known |= {*left}
    before, head, after = text.partition(_HEAD)
    own, gap, rest = after.partition("\n\n")
    return before + head + own + added + gap + rest


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
