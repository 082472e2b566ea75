"""Parts of a linkage by key path: ``joints.B.clearance``, or by number, ``joints[2].clearance``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar, get_args

from jointplay.errors import InputError, Problem, join, unknown
from jointplay.mechanism.base import Record

WITH_PARTS = ("links", "joints", "springs", "loads", "drive")
R = TypeVar("R", bound=Record)


def is_path(key: Any) -> bool:
    """Whether a key is a path, and no name."""
    return isinstance(key, str) and ("." in key or "[" in key)


def steps(path: str) -> list[str]:
    """Steps of a path: ``joints``, ``[2]``, ``clearance``."""
    return path.replace("[", ".[").split(".")


def below(record: Any) -> dict[str, Any]:
    """Parts of a record, of a tuple, or of a table, by name; those of a tuple by their numbers too."""
    if isinstance(record, tuple):
        named = {part.name: part for part in record if getattr(part, "name", None)}
        return named | {f"[{i}]": part for i, part in enumerate(record)}
    if isinstance(record, dict):
        return record
    return dict(record) if isinstance(record, Record) else {}


def found(record: Any, path: str, place: str) -> tuple[Any, Problem | None]:
    """The part at the end of a path, or the problem, whose key is `place`, of one that leads to none."""
    for step in steps(path):
        parts = below(record)
        if step not in parts:
            known = [name for name in parts if name[0] != "["] or parts
            return None, unknown(place, step, step, known, "part")
        record = parts[step]
    return record, None


def with_parts(record: R, changes: Mapping[str, Any]) -> R:
    """A validated copy in which other things stand at the ends of these paths, which lead somewhere."""
    for path, value in changes.items():
        try:
            record = _with_part(record, steps(path), value)
        except InputError as error:
            raise InputError(Problem(path, value, each.expected) for each in error.problems) from None
    return record


def checked_paths(record: Any, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Those of the changes that are by path; `InputError` naming every path that leads nowhere."""
    by_path = {key: value for key, value in changes.items() if is_path(key)}
    problems = [problem for key in by_path if (problem := found(record, key, key)[1])]
    if problems:
        raise InputError(problems)
    return by_path


def as_paths(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of changes in which tables of parts stand as paths; a whole drive, which has a kind, stays."""
    own = {key: value for key, value in table.items() if not _holds_parts(key, value)}
    return own | dict(each for key in table.keys() - own.keys() for each in _ends(key, table[key]))


def _holds_parts(key: str, value: Any) -> bool:
    return key in WITH_PARTS and isinstance(value, Mapping) and "kind" not in value


def _ends(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(value, Mapping) or not value:
        yield path, value
        return
    for key, each in value.items():
        yield from _ends(join(path, str(key)), each)


def _with_part(record: Any, path: Sequence[str], value: Any) -> Any:
    first, *rest = path
    if isinstance(record, tuple):
        number = int(first[1:-1]) if first[0] == "[" else [part.name for part in record].index(first)
        return tuple(_changed(part, rest, value) if i == number else part for i, part in enumerate(record))
    if isinstance(record, dict):
        return record | {first: value}
    inner = (
        _with_part(getattr(record, first), rest, value) if rest else as_counted(type(record), first, value)
    )
    return type(record)(**dict(record) | {first: inner})


def _changed(part: Any, rest: Sequence[str], value: Any) -> Any:
    return _with_part(part, rest, value) if rest else value


def as_counted(record: Any, name: str, value: Any) -> Any:
    """A whole number as an int where the record's field is one: the values of a sweep are floats."""
    field = record.model_fields.get(name)
    whole = isinstance(value, float) and value.is_integer()
    return int(value) if whole and field is not None and _counts(field.annotation) else value


def _counts(annotation: Any) -> bool:
    return annotation is int or any(map(_counts, get_args(annotation)))
