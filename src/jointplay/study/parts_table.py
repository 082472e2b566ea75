"""A linkage as a table (CSV) of its links and joints, a row each.

Columns, in any order, of which ``part`` and ``name`` are needed; empty cells are left out:

part          ``link`` or ``joint``
name          name of the link or joint
length, mass, inertia, centre      of a link, as in a study file
angle                              of a link: roughly how it lies, rad, to say how loops are assembled
journal, journal_at                of a joint: link of the journal, and the distance along it
bearing, bearing_at, x, y          link of the bearing, and the distance along it; or ``ground`` and the place

Values are in SI units, or written with theirs, as ``30 mm``. Semicolons or tabs may separate cells; numbers
then may have a decimal comma.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping
from typing import Any

from jointplay.display.errors import NOTHING, InputError, Problem, refuse, unknown
from jointplay.solver.mechanism.base import GROUND, is_number
from jointplay.solver.mechanism.measures import in_si
from jointplay.study.pylinkage_file import Drawing

OF_LINKS = ("length", "mass", "inertia", "centre", "angle")
OF_JOINTS = ("journal", "journal_at", "bearing", "bearing_at", "x", "y")
COLUMNS = ("part", "name", *OF_LINKS, *OF_JOINTS)
SEPARATORS = (";", "\t")  # in the place of commas, as spreadsheets write where numbers have a decimal comma
_COMMA = re.compile(r"^([+-]?\d*),(\d)")
PARTS = {"link": OF_LINKS, "joint": OF_JOINTS}


def read(text: str, unit: str | None) -> Drawing:
    """Read a table's text; `InputError` with everything that is wrong, by the lines of the file."""
    separator = next((sign for sign in SEPARATORS if sign in text.partition("\n")[0]), ",")
    reader = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True)
    try:
        lines = [
            (f"line {reader.line_num}", [_cell(cell, separator) for cell in row])
            for row in reader
            if any(row)
        ]
    except csv.Error as error:
        raise refuse(f"line {reader.line_num}", f"a table (CSV) is accepted; {error}", "file") from None
    columns = lines[0][1] if lines else []
    if not {"part", "name"} <= {*columns}:
        accepted = f"a first line that names columns is accepted, part and name among {', '.join(COLUMNS)}"
        raise refuse(columns, accepted, "line 1")
    problems = [unknown("line 1", each, each, COLUMNS, "column") for each in columns if each not in COLUMNS]
    if unit is not None:
        accepted = "accepted for files of pylinkage; here each cell may say its own, as 30 mm"
        problems.append(Problem("--unit", unit, accepted))
    table, angles = {"links": [], "joints": []}, {}
    for place, cells in lines[1:]:
        row = {column: cell for column, cell in zip(columns, cells, strict=False) if cell}
        problems += _wrong_row(place, row, len(cells) > len(columns))
        if row.get("part") == "link":
            values = {key: _value(row[key]) for key in OF_LINKS if key in row}
            if "angle" in values:
                angle = values.pop("angle")
                try:
                    angles[row.get("name")] = _angle(angle)
                except InputError as error:
                    problems += error.under(f"{place}, angle").problems
            table["links"].append({"name": row.get("name"), **values})
        else:
            table["joints"].append(_joint(row))
    if problems:
        raise InputError(problems)
    return Drawing(table, angles)


def _cell(cell: str, separator: str) -> str:
    """The text of a cell; where no comma separates cells, one in a number stands for its point."""
    return cell.strip() if separator == "," else _COMMA.sub(r"\1.\2", cell.strip())


def _wrong_row(place: str, row: Mapping[str, str], longer: bool) -> Iterator[Problem]:
    part = row.get("part", NOTHING)
    if longer:
        yield Problem(place, dict(row), "no more cells than columns are accepted")
    if part not in PARTS:
        yield unknown(f"{place}, part", part, part, PARTS, "part")
        return
    needed = ("name", "length") if part == "link" else ("name", "journal", "bearing")
    for key in (*needed, *(("x", "y") if row.get("bearing") == GROUND else ())):
        if key not in row:
            yield Problem(f"{place}, {key}", NOTHING, f"a {part} needs it")
    for key in row.keys() - {"part", "name", *PARTS[part]}:
        yield Problem(f"{place}, {key}", row[key], f"of a {part}, {', '.join(PARTS[part])} are accepted")


def _joint(row: Mapping[str, str]) -> dict[str, Any]:
    sides = {
        side: {"link": row.get(side)} | ({"at": _value(row[f"{side}_at"])} if f"{side}_at" in row else {})
        for side in ("journal", "bearing")
    }
    if {"x", "y"} & row.keys():
        sides["bearing"]["point"] = [_value(row.get(key, "")) for key in ("x", "y")]
    return {"name": row.get("name"), **sides}


def _angle(given: float | str) -> float:
    angle = in_si(given, "rad")
    if not is_number(angle):
        raise refuse(given, "a rough angle, such as 0.5 or 30 deg, is accepted")
    return angle


def _value(cell: str) -> float | str:
    """A cell as a number, or else the text: a name, or a number with its unit."""
    try:
        return float(cell)
    except ValueError:
        return cell
