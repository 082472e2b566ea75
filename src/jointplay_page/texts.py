"""Texts of a page, as HTML: numbers of a result, its origin, commands to run it again. All is escaped."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from html import escape
from itertools import product
from typing import Any

import numpy as np
from xarray import DataArray, Dataset

from jointplay.display import codes
from jointplay.display.errors import NOTHING, InputError, join
from jointplay.display.number_text import measure
from jointplay.figures.drawing import select
from jointplay.study import toml_text
from jointplay.study.file import validate

ENTRIES = 12  # of a variable, that are numbers to be read
SAVED = "_page.toml"  # ends the name of a saved study: the file that it came from stays as it is
LONGEST = 300  # characters of a number or text


def numbers(dataset: Dataset, grid: list[str]) -> str:
    """Return a table of all variables with few entries, except the variables of a sweep's cells."""
    words = {dim: (dim, dataset[f"{dim}_name"].values) for dim in dataset.dims if f"{dim}_name" in dataset}
    dataset = dataset.assign_coords(words)  # keys are for programs
    named = {str(d) for d in dataset.dims if d in dataset.coords and dataset[d].dtype.kind not in "fiu"}
    few = (each for each in dataset.data_vars.values() if each.size <= ENTRIES)
    listed = [each for each in few if {*each.dims} <= named - {*grid}]
    rows = "".join(row(name, value) for array in listed for name, value in entries(array))
    return f'<div class="wide"><table>{rows}</table></div>' if rows else "<p>None but those drawn.</p>"


def entries(array: DataArray) -> list[tuple[str, str]]:
    """Return the entries of a variable: names and values, with units or words."""
    shown = codes.words(array) if "flag_meanings" in array.attrs else array
    found = []
    for place in product(*map(range, array.shape)):
        one = shown[dict(zip(array.dims, place, strict=True))]
        labels = [codes.contact(str(one[dim].values)) for dim in array.dims if dim in one.coords]
        value = one.values[()]
        number = isinstance(value, np.number | int | float) and np.isfinite(value)
        text = measure(float(value), str(array.attrs.get("units", ""))) if number else str(value)
        found.append((", ".join([select.title(array), *labels]), text))
    return found


def row(name: str, value: str) -> str:
    """Return a row of a table."""
    return f"<tr><th>{escape(name)}</th><td>{escape(value[:LONGEST])}</td></tr>"


def origin(record: dict[str, Any]) -> str:
    """Return the origin of a result, and the way to compute it again."""
    if not record:
        return "<p>The result was made in Python and holds no study: what made it is not known here.</p>"
    software, environment = (record.get(key) or {} for key in ("software", "environment"))
    about = {"program": " ".join(str(software.get(key, "")) for key in ("name", "version", "git"))}
    about |= {str(key): str(value) for key, value in environment.items()}
    about["digest of the kernels"] = str(record.get("kernel_digest", ""))
    rows = "".join(row(name, value) for name, value in about.items())
    study = copied("study", str(record.get("study_text", "")))
    return f'<div class="wide"><table>{rows}</table></div>{again(record)}<p>The study:</p>{study}'


def again(record: dict[str, Any]) -> str:
    """Return the way to compute a result again: by its study, or by itself where the run had changed that."""
    name, changed = file_name(record), changes(record)
    if changed == []:
        words = f"Save the study as <code>{escape(name)}</code>; this computes the result again:"
        named = "kind" in toml_text.parse(record["study_text"])
        kind = "" if named else f" --set kind={record['study']['kind']}"
        return f"<p>{words}</p>{copied('again', f'jointplay run {shlex.quote(name)}{kind}')}"
    words = "This version does not accept the study as it stands here, or it is not all of it."
    if changed:
        listed = "; ".join(changed[:ENTRIES]) + (" and more" if changed[ENTRIES:] else "")
        words = f"The run had other values than the study: {listed}."
    words = f"{words} The result itself knows what was run; beside it, this computes it again:"
    result = name.removesuffix(SAVED) + ".nc"
    return f"<p>{escape(words)}</p>{copied('again', f'jointplay run {shlex.quote(result)} --out again')}"


def changes(record: dict[str, Any]) -> list[str] | None:
    """Return the changes of a run to the text of its study, as ``analysis.turns = 6``; None if unknown."""
    try:
        table = toml_text.parse(str(record.get("study_text", "")))
        written = validate({k: record["study"][k] for k in ("name", "kind")} | table).model_dump(mode="json")
        before, after = dict(leaves(written)), dict(leaves(record["study"]))
    except (InputError, KeyError, TypeError):
        return None
    return [
        f"{key} = {json.dumps(value)}" for key, value in after.items() if before.get(key, NOTHING) != value
    ]


def leaves(node: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the paths and values of the entries of tables and lists."""
    if isinstance(node, dict | list):
        pairs = node.items() if isinstance(node, dict) else ((f"[{i}]", each) for i, each in enumerate(node))
        for key, each in pairs:
            yield from leaves(each, join(path, str(key)))
    else:
        yield path, node


def file_name(record: dict[str, Any]) -> str:
    """Return the name of a file for a study that a page has."""
    study = record.get("study")
    return f"{(study.get('name') if isinstance(study, dict) else '') or 'study'}{SAVED}"


def copied(name: str, text: str) -> str:
    """Return a text with a button that copies it."""
    button = f'<button type="button" data-copies="{name}">Copy</button>'
    return f'{button}<pre id="{name}" tabindex="0">{escape(text)}</pre>'
