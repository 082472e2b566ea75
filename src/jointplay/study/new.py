"""A study file to begin with: made of the kind's row and signature, and of the records of a mechanism."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args, get_origin

from jointplay.display.described import descriptions, first_sentence
from jointplay.display.errors import InputError, refuse, unknown
from jointplay.kinds import KINDS, Kind
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.records import Changes, Mechanism
from jointplay.study.file import validate
from jointplay.study.models import ELSEWHERE, INTEGRATOR
from jointplay.study.toml_text import parse, written

ALIAS = {"four_bar": "chunmei2002"}
USUAL = {"catalog": "chunmei2002", "clearance": 2.9e-4, "gear_ratio": 3.0}
TABLES = ("links", "joints", "springs", "loads")  # of a linkage: a table each entry
COLUMN = 48  # where comments begin
DIGITS = 15  # of a number: what it is meant to be, without the rounding of how it was computed


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
    if kind not in KINDS:
        raise InputError([unknown("kind", kind, kind, KINDS, "kind of study")])
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
        f"kind = {written(row.name)}",
        *_commented("title", None, "What this study is, in a line"),
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
    yield from _keywords(row)
    if row.figures:
        yield from ("", "[figure]", *_commented("kind", row.figures[0], " or ".join(row.figures)))


def _keywords(row: Kind) -> Iterator[str]:
    """The tables of the analysis's keywords: first keywords that the example sets, then defaults."""
    given, fields = row.example.get("analysis", {}), row.function.fields()
    tables = {"integrator": [], "analysis": sorted(given, key=list(fields).index)}
    for key in (key for key in fields if key not in (*given, *ELSEWHERE)):
        tables["integrator" if key in INTEGRATOR else "analysis"].append(key)
    for table, keys in tables.items():
        if keys:
            yield from ("", f"[{table}]")
        for key in keys:
            about = _about(row, key)
            yield from (
                _set(key, given[key], about) if key in given else _commented(key, fields[key][1], about)
            )


def _about(row: Kind, key: str) -> str:
    """Description of a keyword, also where that refers to another analysis."""
    text = descriptions(row.function).get(key, "")
    other = re.match(r"As in `(\w+)`", text)
    rows = {each.home.partition(":")[2]: each for each in KINDS.values()}
    return _about(rows[other[1]], key) if other and other[1] in rows else first_sentence(text)


def _set(key: str, value: Any, about: str) -> Iterator[str]:
    """A line that sets a key, with its description."""
    return _line(f"{key} = {written(_plain(value))}", about)


def _commented(key: str, default: Any, about: str) -> Iterator[str]:
    """A commented line with the default of a key."""
    value = "" if default is None or default is ... else written(_plain(default))
    return _line(f"# {key} = {value}".rstrip(), about)


def _line(line: str, about: str) -> Iterator[str]:
    """A line and its comment, at its end or, where it is long, above."""
    about = about.replace("``", "`")
    if about and len(line) >= COLUMN:
        yield f"# {about}:"
        yield line
    else:
        yield f"{line:<{COLUMN}}# {about}" if about else line


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return {key: _plain(each) for key, each in _told(value)}
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_plain(each) for each in value] if isinstance(value, list | tuple) else value


def _told(record: Record) -> Iterator[tuple[str, Any]]:
    """Keys of a record that a file has to say."""
    for key, field in type(record).model_fields.items():
        value, annotation = getattr(record, key), field.annotation
        says_which = get_origin(annotation) is Literal and len(get_args(annotation)) == 1
        if says_which or (value is not None and (field.is_required() or value != field.default)):
            yield key, value


def _vary(example: Mapping[str, Any]) -> Iterator[str]:
    yield from ("", "[vary]" if example else "# [vary]    # one analysis for each value")
    for key, value in example.items():
        yield from _set(key, value, "start, stop, num and scale, or a list of values")
    if not example:
        yield "# clearance = [1e-4, 2e-4, 3e-4]"


def _entry(table: Mapping[str, Any]) -> Iterator[str]:
    """An entry of the catalog, and the changes to it."""
    make = catalog.NAMES[table["catalog"]]
    texts = descriptions(Changes) | descriptions(make) | {"catalog": first_sentence(make.__doc__)}
    for key, value in table.items():
        yield from _set(key, value, first_sentence(texts.get(key, "")))


def _mechanism(name: str) -> Iterator[str]:
    """A linkage of the catalog, written out."""
    if name not in (known := names()):
        raise InputError([unknown("--mechanism", name, name, known, "mechanism")])
    record = catalog.NAMES[ALIAS.get(name, name)]()
    about = descriptions(Mechanism)
    single = [(key, value) for key, value in _told(record) if key not in (*TABLES, "drive")]
    yield from (line for key, value in single for line in _set(key, value, first_sentence(about[key])))
    for table in TABLES:
        for number, part in enumerate(getattr(record, table)):
            yield from _part(f"[[mechanism.{table}]]", part, commented=not number)
    if record.drive:
        yield from _part("[mechanism.drive]", record.drive, commented=True)


def _part(head: str, record: Record, commented: bool) -> Iterator[str]:
    texts = descriptions(type(record)) if commented else {}
    yield from ("", head)
    for key, value in _told(record):
        yield from _set(key, value, first_sentence(texts.get(key, "")))
