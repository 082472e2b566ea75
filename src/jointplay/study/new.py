"""A study file to begin with: made of the kind's row and signature, and of the records of a mechanism."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Collection, Iterator, Mapping
from typing import Any, Literal, get_args, get_origin

from jointplay.display.accepted import accepted_values, descriptions, first_sentence, units_of
from jointplay.display.errors import InputError, Problem, raise_any, refuse, strangers
from jointplay.display.number_text import typed
from jointplay.kinds import KINDS, Kind
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.records import Changes, Mechanism
from jointplay.study import models
from jointplay.study.file import validate
from jointplay.study.models import ELSEWHERE, INTEGRATOR
from jointplay.study.toml_text import parse, written

ALIAS = {"four_bar": "chunmei2002"}
USUAL = {"catalog": "chunmei2002", "clearance": 2.9e-4, "gear_ratio": 3.0}
TABLES = ("links", "joints", "springs", "loads")  # of a linkage: a table each entry
SHAPE = {"bar": {"width": "40 mm", "thickness": "6 mm"}, "material": "steel"}
PARTS = {"pin": "steel", "bush": "bronze", "length": "12 mm"}
INSTEAD = {  # of what the first of these says: other forms, and what they take the place of
    "links": [("shape", SHAPE, "Instead of mass, centre and inertia: what the link is made of")],
    "joints": [
        ("fit", "H7/f7", "Instead of a clearance: a fit of ISO 286 at twice the radius"),
        ("contact", PARTS, "Instead of contact and friction in numbers: pin and bush"),
    ],
}
COLUMN = 48  # where comments begin
WIDTH = 110
DIGITS = 15  # of a number: what it is meant to be, without the rounding of how it was computed
FRIENDLY = {"m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "rad/s": ("rpm", 30 / math.pi)}
SHORT = 7  # letters of a number in such a unit; what is longer stays in SI


def new(kind: str, name: str, mechanism: str | None = None) -> str:
    """Write the text of a study that runs, with a comment on every key.

    Parameters
    ----------
    kind : str
        Kind of study.
    name : str
        Name of the file, without its ending.
    mechanism : str, optional
        A linkage of the catalog, which is written out, link by link; the kind's own example if left out.

    Raises
    ------
    InputError
        When there is no such kind or mechanism, or the kind's example does not suit the mechanism.
    """
    raise_any(strangers([("kind", kind)], KINDS, "kind of study"))
    row = KINDS[kind]
    text = "\n".join(_lines(row, name, mechanism)) + "\n"
    try:
        validate({"name": name} | parse(text))
    except InputError as error:
        if mechanism is None:
            raise
        why = f"another one is accepted: the example of a {kind} does not suit it ({error})"
        raise refuse(mechanism, why, "--mechanism") from None
    return text


def names() -> list[str]:
    """Names of the linkages that can be written out."""
    return [*ALIAS, *(name for name in catalog.NAMES if name not in catalog.SYSTEMS)]


def _lines(row: Kind, name: str, mechanism: str | None) -> Iterator[str]:
    about = row.function.__doc__.partition("\n")[0]
    yield from (
        f"# {about}",
        f"# Validate: jointplay check {name}.toml. Compute and draw: jointplay run {name}.toml",
        '# A number without a unit is in SI units (m, kg, s, rad, N); a text has its own, such as "0.29 mm".',
        "# A line that begins with # sets nothing: it shows what holds without the key, or another form.",
        f"kind = {written(row.name)}",
        *_commented("title", None, "What this study is about, for figures and pages (text)"),
        "",
        "[mechanism]",
    )
    if mechanism is None:
        own = row.example.get("mechanism", {})
        yield from _entry(own if "catalog" in own else USUAL | own)
    else:
        yield from _mechanism(mechanism)
    if "over" in row.function.fields() or row.varies:
        yield from _vary(row.example.get("vary", {}))
    for table in models.TABLES.values():
        if table in row.example:
            yield from ("", f"[{table}]", *_spreads(row.example[table]))
    yield from _keywords(row)
    if row.figures:
        known = f"one of {', '.join(row.figures)}" if len(row.figures) > 1 else "the only one of this kind"
        yield from ("", "[figure]", *_commented("kind", row.figures[0], f"Which figure is drawn ({known})"))


def _keywords(row: Kind) -> Iterator[str]:
    """The tables of the analysis's keywords: first keywords that the example sets, then defaults."""
    given, fields = row.example.get("analysis", {}), row.function.fields()
    tables = {"integrator": [], "analysis": sorted(given, key=list(fields).index)}
    for key in (key for key in fields if key not in (*given, *ELSEWHERE, *models.TABLES)):
        tables["integrator" if key in INTEGRATOR else "analysis"].append(key)
    for table, keys in tables.items():
        if keys:
            yield from ("", f"[{table}]")
        for key in keys:
            annotation, default = fields[key]
            about = _with(_about(row, key), accepted_values(annotation))
            yield from _set(key, given[key], about) if key in given else _commented(key, default, about)


def _about(row: Kind, key: str) -> str:
    """Description of a keyword, also where that refers to another analysis."""
    text = descriptions(row.function).get(key, "")
    other = re.match(r"As in `(\w+)`", text)
    rows = {each.home.partition(":")[2]: each for each in KINDS.values()}
    return _about(rows[other[1]], key) if other and other[1] in rows else first_sentence(text)


def _with(about: str, accepted: str) -> str:
    """The meaning of a key, and in parentheses the values that it takes."""
    accepted = re.sub(r" and at most 1e9| \(in Python .*?\(\)[^)]*\)", "", accepted)
    return f"{about} ({accepted})" if about and accepted else about


def _set(key: str, value: Any, about: str, units: str | None = None) -> Iterator[str]:
    """A line that sets a key, with its description."""
    return _line(f"{key} = {written(_plain(value, units))}", about)


def _commented(key: str, default: Any, about: str) -> Iterator[str]:
    """A commented line with the default of a key."""
    value = "" if default is None or default is ... else written(_plain(default))
    return _line(f"# {key} = {value}".rstrip(), about)


def _line(line: str, about: str) -> Iterator[str]:
    """A line and its comment, at its end or, where they are long together, above."""
    about = about.replace("``", "`")
    if about and max(len(line) + 1, COLUMN) + len(about) + 2 > WIDTH:
        yield from textwrap.wrap(about, WIDTH, initial_indent="# ", subsequent_indent="#   ")
        yield line
    else:
        yield f"{line:<{COLUMN - 1}} # {about}" if about else line


def _plain(value: Any, units: str | None = None) -> Any:
    """A value as a person writes it into a file."""
    if isinstance(value, Record):
        return {key: _plain(each, units_of(type(value).model_fields[key])) for key, each in _items(value)}
    if isinstance(value, Mapping):
        return {key: _plain(each, units) for key, each in value.items()}
    if isinstance(value, float):
        return _friendly(value, units)
    return [_plain(each, units) for each in value] if isinstance(value, list | tuple) else value


def _friendly(value: float, units: str | None) -> float | str:
    unit, factor = FRIENDLY.get(units or "", ("", 0.0))
    text = typed(value * factor, DIGITS - 3)
    below_one = abs(value) < 1 or units != "m"  # a metre is a metre
    if unit and value and below_one and len(text) <= SHORT:
        return f"{text} {unit}"
    return float(f"{value:.{DIGITS}g}")


def _items(record: Record) -> Iterator[tuple[str, Any]]:
    """Keys of a record that a file has to say."""
    for key, field in type(record).model_fields.items():
        value, annotation = getattr(record, key), field.annotation
        says_which = get_origin(annotation) is Literal and len(get_args(annotation)) == 1
        if says_which or (value is not None and (field.is_required() or value != field.default)):
            yield key, value


def _spreads(example: Mapping[str, Any]) -> Iterator[str]:
    """Spreads of the example."""
    about = "What this number may be: normal (mean, standard deviation), uniform, within, fit, …"
    for key, value in example.items():
        yield from _set(key, value, about, units_of(Changes.model_fields[key]))


def _vary(example: Mapping[str, Any]) -> Iterator[str]:
    about = "Values that are looked at: start, stop and num (scale: linear or log), or a list"
    yield from ("", "[vary]" if example else "# [vary]")
    for key, value in example.items():
        units = units_of(Changes.model_fields.get(key))
        ends = {each: _plain(x, units) for each, x in value.items()}
        yield from _set(key, ends, about)
    if not example:
        yield from _line(
            '# clearance = ["0.1 mm", "0.2 mm", "0.3 mm"]', "One analysis for each of these values"
        )


def _entry(table: Mapping[str, Any]) -> Iterator[str]:
    """An entry of the catalog, and the changes to it."""
    make = catalog.NAMES[table["catalog"]]
    texts = descriptions(Changes) | descriptions(make)
    entry = first_sentence(make.__doc__).removeprefix("Give ")
    yield from _set("catalog", table["catalog"], entry[0].upper() + entry[1:])
    for key, value in table.items():
        if key != "catalog":
            units = units_of(Changes.model_fields[key]) if key in Changes.model_fields else None
            yield from _set(key, value, first_sentence(texts.get(key, "")), units)


def _mechanism(name: str) -> Iterator[str]:
    """A linkage of the catalog, written out."""
    raise_any(strangers([("--mechanism", name)], names(), "mechanism"))
    record = catalog.NAMES[ALIAS.get(name, name)]()
    if not isinstance(record, Mechanism):
        raise InputError([Problem("--mechanism", name, "a linkage is accepted, not equations of their own")])
    yield from _keys(record, {*TABLES, "drive"})
    for table in TABLES:
        known, forms = set[str](), INSTEAD.get(table, [])
        for part in getattr(record, table):
            yield from ("", f"[[mechanism.{table}]]", *_keys(part, known=known))
            if forms and (table == "links" or not (part.ideal or part.prismatic)):
                yield from (line for form in forms for line in _commented(*form))
                forms = []
    if record.drive:
        yield from ("", "[mechanism.drive]", *_keys(record.drive))


def _keys(record: Record, left_out: Collection[str] = (), known: set[str] | None = None) -> Iterator[str]:
    """The keys of a record, each with a comment unless it is among the known ones, which it joins."""
    known = set() if known is None else known
    texts, fields = descriptions(type(record)), type(record).model_fields
    for key, value in _items(record):
        if key not in left_out:
            text = texts.get(key) or (type(record).__doc__ or "").partition("\n")[0]  # of a kind: what it is
            if other := re.search(r"see `(\w+)`", text):
                text = next(
                    descriptions(base)[key] for base in type(record).__mro__ if base.__name__ == other[1]
                )
            words = first_sentence(text), accepted_values(fields[key].annotation, fields[key])
            about = "" if key in known else _with(*words)
            yield from _set(key, value, about, units_of(fields[key]))
            known.add(key)
