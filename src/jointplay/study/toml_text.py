"""The text of a study file: read it, parse it as TOML, apply changes from the command line."""

import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from jointplay.display.errors import InputError, Problem, raise_any, unknown
from jointplay.display.number_text import typed
from jointplay.kinds import KINDS
from jointplay.solver.mechanism.measures import SMALLEST

DEPTH = 16  # tables inside tables; no study needs more
DOTS = 1000  # in one key, which takes time as their square
BARE = re.compile(r"[\w-]+(\.[\w-]+)*", re.ASCII)  # keys that need no quotes
LARGEST = 50_000_000  # bytes of a study file
STEP = re.compile(r"""(?:^|\.)(?:(["'])(?P<quoted>.+?)\1|(?P<name>[^.\[\]=\s"']+))|\[(?P<index>\d{1,6})\]""")


def read_text(path: Path | str, key: str = "study file", what: str = "a study file (TOML, UTF-8)") -> str:
    """Text of a file; `InputError` where it is no readable file or its bytes are not UTF-8."""
    expected = f"the name of {what} is accepted"
    try:
        return _content(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        reason = f"byte {error.start} is not UTF-8"
    except (OSError, ValueError) as error:
        reason = str(getattr(error, "strerror", None) or error).lower()
    raise InputError([Problem(key, str(path), f"{expected}; {reason}")])


def _content(path: Path | str) -> bytes:
    """Bytes of a regular file: a pipe would wait for somebody to write into it, a device may never end."""
    info = os.stat(path)
    if not stat.S_ISREG(info.st_mode):
        raise OSError("it is a folder" if stat.S_ISDIR(info.st_mode) else "it is no regular file")
    if info.st_size > LARGEST:
        raise OSError(f"its {info.st_size:,} bytes are more than {LARGEST:,}")
    return Path(path).read_bytes()


def parse(text: str) -> dict[str, Any]:
    """Parse a TOML text; `InputError` where it is none, with the offending line and its number."""
    try:
        return _table(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        message = str(error)
    except (RecursionError, ValueError) as error:  # nested too deeply; a number or date out of range
        message = str(error) or "nested too deeply"
    raise InputError([Problem("study file", _line_of(text, message), f"valid TOML is accepted; {message}")])


def _table(text: str) -> dict[str, Any]:
    if text.count(".") > DOTS and any(part.count(".") > DOTS for part in re.split(r"[=,{}\[\]\n]", text)):
        raise ValueError(f"a key of more than {DOTS} parts")
    return tomllib.loads(text)


def kinds_there(path: Path, out: Path, changes: Iterable[str] = ()) -> list[str]:
    """The kinds as which a study file that names none has results, or begun ones; a result names its own."""
    if path.suffix == ".nc" or "kind" in override(parse(read_text(path)), changes):
        return []
    files = ((kind, out / f"{path.stem}_{kind}{end}") for kind in KINDS for end in (".nc", ".journal"))
    return list(dict.fromkeys(kind for kind, file in files if file.exists()))


def override(table: dict[str, Any], changes: Iterable[str]) -> dict[str, Any]:
    """Apply ``key.path=value`` changes to a parsed study.

    Parameters
    ----------
    table : dict
        The parsed study; left as it is.
    changes : iterable of str
        Such as ``mechanism.clearance=1e-4``, ``mechanism.links[0].mass=0.2`` or, by an entry's name,
        ``mechanism.links.crank.mass=0.2``; what stands in quotes is one key, dots and all. A value is read as
        TOML, and as a plain string where it is none.

    Returns
    -------
    dict
        A changed copy; `InputError` naming every change that does not fit.
    """
    raise_any(too_deep(table))
    table, problems = deepcopy(table), []
    for change in changes:
        path, equals, value = change.partition("=")
        steps = _of_the_catalog(table, _steps(path.strip()))
        if not equals or not steps or not _is_text(change):
            expected = "key.path=value, such as mechanism.clearance=1e-4, is accepted"
            problems.append(Problem("--set", change, expected))
        elif problem := _set(table, steps, _value(value.strip()), change):
            problems.append(problem)
    raise_any(problems)
    return table


def written(value: Any) -> str:
    """A value as TOML writes it on one line."""
    if isinstance(value, Mapping):
        pairs = ((key if BARE.fullmatch(key) else json.dumps(key), each) for key, each in value.items())
        return f"{{ {', '.join(f'{key} = {written(each)}' for key, each in pairs)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, float) and math.isfinite(value):
        return typed(value, 0)
    return json.dumps(value, ensure_ascii=False)


def _is_text(change: str) -> bool:
    """Whether the bytes on the command line were text, of which Python makes no surrogates."""
    return not any("\ud800" <= character <= "\udfff" for character in change)


def implausible(table: dict[str, Any]) -> list[Problem]:
    """Problems of a study of any kind: endless nesting, numbers whose products overflow or underflow."""
    nodes = (item for level in _levels(table) for item in level)
    return [problem for path, node in nodes for problem in _out_of_size(path, node)] + too_deep(table)


def too_deep(table: dict[str, Any]) -> list[Problem]:
    """A problem where tables are nested more deeply than any study needs."""
    *_, last = _levels(table, DEPTH + 1)
    return [Problem(path[:60] + "...", "...", f"at most {DEPTH} levels of tables") for path, _ in last[:1]]


def _levels(table: dict[str, Any], count: int = DEPTH) -> Iterator[list[tuple[str, Any]]]:
    """Path and value of each entry, depth by depth; the table itself first."""
    level: list[tuple[str, Any]] = [("", table)]
    for _ in range(count):
        yield level
        level = [(below, child) for path, node in level for below, child in children(path, node)]


def _out_of_size(path: str, node: Any) -> Iterator[Problem]:
    """Yield a problem where a number is too large or small; its record refuses one that is not finite."""
    if not isinstance(node, int | float) or not node or SMALLEST <= abs(node) <= 1 / SMALLEST:
        return
    if isinstance(node, int) or math.isfinite(node):
        shown = node if isinstance(node, float) else hex(node)[:20] + "..."
        expected = f"a number between {typed(SMALLEST)} and {typed(1 / SMALLEST)} in size is accepted"
        yield Problem(path, shown, expected)


def children(path: str, node: Any) -> list[tuple[str, Any]]:
    """Path and value of each entry of a table or a list."""
    if isinstance(node, dict):
        return [(f"{path}.{key}" if path else key, child) for key, child in node.items()]
    return [(f"{path}[{i}]", child) for i, child in enumerate(node)] if isinstance(node, list) else []


def _steps(path: str) -> list[str | int]:
    """``a.b[2].c`` as ['a', 'b', 2, 'c']; empty when the path is malformed."""
    matches = list(STEP.finditer(path))
    whole = "".join(match.group() for match in matches) == path and not path.startswith("[")
    return [match["quoted"] or match["name"] or int(match["index"]) for match in matches] if whole else []


def _of_the_catalog(table: dict[str, Any], steps: list[str | int]) -> list[str | int]:
    """Steps of a path; the numbers of parts of a mechanism that its table only names stay in brackets."""
    mechanism = table.get("mechanism")
    named = steps[:1] == ["mechanism"] and isinstance(mechanism, dict) and "catalog" in mechanism
    if not named or steps[1:2] == [] or steps[1] in mechanism:
        return steps
    return [f"[{step}]" if isinstance(step, int) else step for step in steps]


def _set(node: Any, steps: list[str | int], value: Any, change: str) -> Problem | None:
    """Set the value at the end of a path, making missing tables; the problem where the path does not fit."""
    *path, last = steps
    for step in path:
        if isinstance(node, dict) and isinstance(step, str):
            node = node.setdefault(step, {})
        elif (place := _place(node, step)) is None:
            return _lost(node, step, change)
        else:
            node = node[place]
    place = last if isinstance(node, dict) and isinstance(last, str) else _place(node, last)
    if place is None:
        return _lost(node, last, change)
    node[place] = value
    return None


def _place(node: Any, step: str | int) -> int | None:
    """Index in a list of the entry with this number or name."""
    known = [*range(len(node)), *_names(node)] if isinstance(node, list) else []
    return known.index(step) % len(node) if step in known else None


def _names(entries: list[Any]) -> list[Any]:
    """Names of the tables in a list; None of an entry without one."""
    return [each.get("name") if isinstance(each, dict) else None for each in entries]


def _lost(node: Any, step: str | int, change: str) -> Problem:
    """Problem of a path whose step leads nowhere."""
    names = [str(name) for name in _names(node) if name] if isinstance(node, list) else []
    if isinstance(step, str) and names:
        return unknown("--set", change, step, names, "entry")
    return Problem("--set", change, "a path through tables and existing list entries")


def _value(text: str) -> Any:
    try:
        table = _table(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def _line_of(text: str, message: str) -> str:
    number = re.search(r"at line (\d+)", message)
    lines = text.splitlines()
    index = int(number[1]) - 1 if number else 0
    return lines[index].strip()[:120] if index < len(lines) else ""
