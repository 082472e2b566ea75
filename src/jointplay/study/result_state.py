"""State of a study's stored result: its own answer, or that of a study with other settings.

A result is a study's own if the study stored in it asks for the same today, defaults filled in. Title and
figure change no number, and neither do bounds of how far an analysis goes; values of `[vary]` that are added
or taken away find their cells in the journal: results that differ in these alone may be written over.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jointplay.display.errors import InputError, Problem
from jointplay.display.number_text import listed
from jointplay.study.file import validate
from jointplay.study.models import Study
from jointplay.study.results import provenance
from jointplay.study.results.outcome import name_of
from jointplay.study.results.store import attributes, part
from jointplay.study.toml_text import children

NO_NUMBER = ("title", "figure")
UNREAD = "a study that this version cannot read"
SHOWN = 3  # keys of other settings that are named


def refuse_other(record: Study, path: Path) -> None:
    """Raise `InputError` where a run would write over the result of a study with other settings."""
    if os.path.lexists(path) and (others := [key for key in _differences(record, path)[0] if key != "vary"]):
        expected = (
            f"it is a result with other settings ({listed(others, SHOWN)}): --fresh writes over it, "
            "--out DIR or --set name=OTHER keeps both"
        )
        raise InputError([Problem("result", str(path), expected)])


def result_state(record: Study, path: Path) -> str:
    """A few words on the result of a study: ``done``, another end, or the differences; empty: none."""
    if not os.path.exists(path):
        return ""
    others, less = _differences(record, path)
    if others:
        return f"other {'version' if others == [UNREAD] else 'settings'} ({listed(others, SHOWN)})"
    stored = part(path, "status")
    ended = name_of(stored) if "status" in stored else "ok"
    return (less or "done") if ended == "ok" else f"stopped early ({ended})"


def _differences(record: Study, path: Path) -> tuple[list[str], str]:
    """Keys in which a study differs from that of a stored result, and of which bound that has less.

    `UNREAD` is all that is known of a file that has no study.
    """
    try:
        stored = validate(provenance.held(attributes(path)).get("study", {}))
    except InputError:
        return [UNREAD], ""
    before, now = (dict(_flat(_plain(each))) for each in (stored, record))
    others = [key for key in now | before if before.get(key) != now.get(key)]
    counts = [(key, *(getattr(each.analysis, key, 0) for each in (stored, record))) for key in record.bounds]
    less = (
        f"has {had} of {bound} {key}" for key, had, bound in counts if isinstance(bound, int) and had < bound
    )
    return others, next(less, "")


def _plain(record: Study) -> dict[str, Any]:
    """Settings that decide the numbers of a study, as plain JSON types; `[vary]` as one text."""
    left_out = dict.fromkeys(NO_NUMBER, True) | {"analysis": record.bounds}
    table = json.loads(json.dumps(record.model_dump(mode="json", exclude=left_out)))
    return table | ({"vary": json.dumps(table["vary"], sort_keys=True)} if "vary" in table else {})


def _flat(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Paths and plain values of nested tables and lists."""
    plain = isinstance(node, list) and not any(isinstance(each, dict) for each in node)
    if plain or not (inner := children(key, node)):
        yield key, node
        return
    for path, each in inner:
        yield from _flat(each, path)
