"""Parts of a linkage by key path: ``joints.B.clearance``, or by number, ``joints[2].clearance``."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, TypeVar, get_args

from jointplay.display.errors import InputError, Problem, join, raise_any, unknown
from jointplay.solver.mechanism.base import Record, is_number

WITH_PARTS = ("links", "joints", "springs", "loads", "drive")
# Whose clearance a bare number is: the joint between coupler and rocker of the catalog's linkages.
MAIN_JOINT = "B"
R = TypeVar("R", bound=Record)


def is_path(key: Any) -> bool:
    """Whether a key is a path, and no name."""
    return isinstance(key, str) and ("." in key or "[" in key)


def parts_of(key: Any) -> list[Any]:
    """Words or paths that change by one amount, as in ``links.coupler.length + joints.B.journal.at``."""
    return [part.strip() for part in key.split("+")] if isinstance(key, str) and "+" in key else [key]


def one_by_one(changes: Mapping[str, Any], value_of: Callable[[str], Any]) -> dict[str, Any]:
    """Changes of single words and paths: of several the first gets the value, others go by as much."""
    found = {}
    for key, value in changes.items():
        first, *others = parts_of(key)
        own = {each: value_of(each) for each in others and (first, *others)}
        shifted = all(map(is_number, (value, *own.values())))
        found |= {
            k: x + (value - own[first]) if shifted and x != own[first] else value for k, x in own.items()
        }
        found[first] = value
    return found


def steps(path: str) -> list[str]:
    """Steps of a path: ``joints``, ``[2]``, ``clearance``."""
    return path.replace("[", ".[").split(".")


def below(record: Any) -> dict[str, Any]:
    """Parts of a record, of a tuple, or of a table, by name; parts of a tuple by their numbers too."""
    if isinstance(record, tuple):
        named = {part.name: part for part in record if getattr(part, "name", None)}
        return named | {f"[{i}]": part for i, part in enumerate(record)}
    if isinstance(record, dict):
        return record
    return dict(record) if isinstance(record, Record) else {}


def part_at(record: Any, path: str, place: str) -> tuple[Any, Problem | None]:
    """The part at the end of a path, or the problem, whose key is `place`, of one that leads to none."""
    above = ""
    for step in steps(path):
        parts = below(record)
        if not parts:
            return None, Problem(place, step, f"nothing is accepted: {above} has no parts here")
        if step not in parts:
            known = [name for name in parts if name[0] != "["] or [*parts]
            within = [join(name, step) for name in known if step in below(parts[name])]
            return None, unknown(place, step, step, within or known, "part")
        record, above = parts[step], join(above, step)
    return record, None


def at_paths(record: R, changes: Mapping[str, Any]) -> R:
    """A validated copy in which other things stand at the ends of paths; errors have keys of the record."""
    return _with(record, {tuple(steps(path)): value for path, value in changes.items()}, record._root())


def with_parts(record: R, changes: Mapping[str, Any]) -> R:
    """A validated copy in which other things stand at the ends of these paths, which lead somewhere.

    All change at once: some fit only together, as a length and where the joint at its end sits.
    """
    try:
        return at_paths(record, changes)
    except InputError as error:
        together = [_named(record, each) for each in error.problems]
    if all(any(_within(each.key, path) for path in changes) for each in together):
        raise InputError(replace(each, given=changes.get(each.key, each.given)) for each in together)
    for path, value in changes.items():  # to tell by its path what is wrong elsewhere
        try:
            record = at_paths(record, {path: value})
        except InputError as error:
            raise InputError(_told_of(record, path, value, each) for each in error.problems) from None
    raise InputError(together)


def _within(key: str, path: str) -> bool:
    """Whether a key is a path, or below it."""
    return key == path or key.startswith((f"{path}.", f"{path}["))


def _told_of(record: Any, path: str, value: Any, problem: Problem) -> Problem:
    """A problem where a value was changed, which may not fit to a number elsewhere."""
    other, expected = _named(record, problem).key, str(problem.expected)
    if _within(other, path) and other != path:
        return replace(problem, key=other)
    if is_number(problem.given) and problem.given != value and other != path:
        expected = f"{other} is {problem.given:g}, and there {expected}"
        expected += f"; '{path} + {other}' changes both by as much" if other.endswith(".at") else ""
    return Problem(path, value, expected)


def _named(record: Any, problem: Problem) -> Problem:
    """A problem of a record with its key as a path in that, by names."""
    return replace(problem, key=_by_name(record, problem.key.partition(".")[2]) or problem.key)


def _by_name(record: Any, path: str) -> str:
    """A path with the names of parts in place of their numbers."""
    result = ""
    for step in steps(path):
        record = below(record).get(step)
        named = step.startswith("[") and getattr(record, "name", None)
        result = join(result, named or step)
    return result


def begun_anew(record: Any, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes in which numbers of a part that is not there, or gets another law with them, are that part."""
    found: dict[str, Any] = {}
    for path, value in changes.items():
        above, _, last = path.rpartition(".")
        while above and not _anew(record, above, changes):
            above = above.rpartition(".")[0]
        if not above or any(path.startswith(f"{other}.") for other in changes):
            found[path] = value
            continue
        table = found.setdefault(above, {})
        for step in path.removeprefix(f"{above}.").split(".")[:-1]:
            table = table.setdefault(step, {})
        table[last] = value
    return found


def _anew(record: Any, path: str, changes: Mapping[str, Any]) -> bool:
    """Whether changes make the part at the end of a path another one, whose numbers all stand there."""
    part, problem = part_at(record, path, path)
    if part is None or problem:
        return not problem
    law, several = changes.get(f"{path}.law"), sum(key.startswith(f"{path}.") for key in changes) > 1
    return several and law not in (None, getattr(part, "law", law)) and getattr(part, "parts", None) is None


def checked_paths(record: Any, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The changes that are by path; `InputError` naming each that leads nowhere, or where another does."""
    by_path = {key: value for key, value in changes.items() if is_path(key)}
    raise_any(problem for key in by_path if (problem := part_at(record, key, key)[1]))
    first: dict[str, str] = {}
    same = ((key, first.setdefault(_by_name(record, key), key)) for key in by_path)
    text = "either this or {}, which is the same, is accepted, not both"
    raise_any(Problem(key, by_path[key], text.format(one)) for key, one in same if one != key)
    return by_path


def main_joint(mechanism: Any) -> str:
    """Name of the joint whose clearance a bare number is: B, or where B can have none the only other."""
    sized = [joint for joint in mechanism.joints if joint.sized]
    revolute = [joint.name for joint in sized if not joint.prismatic]
    loose = [joint.name for joint in mechanism.joints if joint.clearance]
    if MAIN_JOINT in revolute:
        return MAIN_JOINT
    only = (names[0] for names in (loose, revolute, [joint.name for joint in sized]) if len(names) == 1)
    return next(only, MAIN_JOINT)


def as_paths(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of changes in which tables of parts stand as paths.

    A whole drive, which has a kind, stays, and so do a shape, and a contact given by its pin and bush.
    """
    own = {key: value for key, value in table.items() if not _holds_parts(key, value)}
    return own | dict(ends({key: table[key] for key in table.keys() - own.keys()}))


def _holds_parts(key: str, value: Any) -> bool:
    return key in WITH_PARTS and isinstance(value, Mapping) and "kind" not in value


def ends(
    table: Mapping[str, Any], above: str = "", whole: Collection[str] = ("pin", "bush")
) -> Iterator[tuple[str, Any]]:
    """Paths and values of the entries of nested tables; a shape, or one with any `whole` key, is a value."""
    for key, value in table.items():
        path, table_of_parts = join(above, str(key)), isinstance(value, Mapping) and value and key != "shape"
        if table_of_parts and value.keys().isdisjoint(whole):
            yield from ends(value, path, whole)
        else:
            yield path, value


def _with(record: Any, changes: Mapping[tuple[str, ...], Any], place: str) -> Any:
    """A validated copy of a record, a tuple of records or a table at a place, by the steps of each path."""
    record, inner = changes.get((), record), {}
    for path, value in changes.items():
        if path:
            inner.setdefault(path[0], {})[path[1:]] = value
    if not inner:
        return record
    if isinstance(record, tuple):
        return tuple(_with(part, _of_part(inner, i, part), f"{place}[{i}]") for i, part in enumerate(record))
    present = dict(record)
    whole = {name: below_it[()] for name, below_it in inner.items() if () in below_it}
    parts = record._stated(whole) if isinstance(record, Record) else present
    for name, below_it in inner.items():
        changed = _with(parts.get(name, present.get(name)), below_it, f"{place}.{name}")
        counted = isinstance(record, Record) and () in below_it
        parts[name] = as_counted(type(record), name, changed) if counted else changed
    if isinstance(record, dict):
        return parts
    try:
        return type(record)(**parts)
    except InputError as error:
        raise error.under(place) if error.root else error from None


def _of_part(inner: Mapping[str, dict], number: int, part: Any) -> dict[tuple[str, ...], Any]:
    """Changes of one of a tuple's parts, by its name or its number."""
    return inner.get(getattr(part, "name", ""), {}) | inner.get(f"[{number}]", {})


def as_counted(record: Any, name: str, value: Any) -> Any:
    """A whole number as an int where the record's field is one: the values of a sweep are floats."""
    field = record.model_fields.get(name)
    whole = isinstance(value, float) and value.is_integer()
    return int(value) if whole and field is not None and _counts(field.annotation) else value


def _counts(annotation: Any) -> bool:
    return annotation is int or any(map(_counts, get_args(annotation)))
