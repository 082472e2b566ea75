"""A linkage from a table (CSV) of its links and joints, a row each, as the text of a study file.

Columns, in any order, of which ``part`` and ``name`` are needed; empty cells are left out:

part          ``link`` or ``joint``
name          name of the link or joint
length, mass, inertia, centre      of a link, as in a study file
angle                              of a link: roughly how it lies, rad, to say how loops are assembled
journal, journal_at                of a joint: link of the journal, and the distance along it
bearing, bearing_at, x, y          link of the bearing, and the distance along it; or ``ground`` and the place

Values are in SI units, or written with theirs, as ``30 mm``. Semicolons or tabs may separate cells; numbers
then may have a decimal comma.

What the table does not hold is not made up: it stands in the text as a comment to be filled in, and `check`
names it until it is.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, refuse, unknown
from jointplay.display.terminal import one_line
from jointplay.solver.mechanism.base import GROUND, Branch, is_number
from jointplay.solver.mechanism.loops.dyads import FourBar
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.measures import SMALLEST, in_si
from jointplay.solver.mechanism.records import Mechanism
from jointplay.study.toml_text import read_text, written

OF_LINKS = ("length", "mass", "inertia", "centre", "angle")
OF_JOINTS = ("journal", "journal_at", "bearing", "bearing_at", "x", "y")
COLUMNS = ("part", "name", *OF_LINKS, *OF_JOINTS)
SEPARATORS = (";", "\t")  # in the place of commas, as spreadsheets write where numbers have a decimal comma
_COMMA = re.compile(r"^([+-]?\d*),(\d)")
PARTS = {"link": OF_LINKS, "joint": OF_JOINTS}
NEEDED = {"mass": "kg", "inertia": "kg m², about the link's origin"}  # of a link
OF_A_BAR = {"length": "m", "mass": "kg", "inertia": "kg m²"}
NEAR = 0.5  # rad; so near a branch rough angles name it
AT_THE_END = """
# Every joint is ideal. One with clearance has, beside its other keys (FILL IN):
# clearance =    # m, radial
# radius =    # m, of the journal
# contact = { stiffness = , damping = }    # N/m, N s/m

# No drive turns it. One at constant speed (FILL IN):
# [mechanism.drive]
# kind = "speed"
# link =    # the crank
# speed =    # rad/s

[analysis]
turns = 1    # of 2π s each, as long as no drive turns the crank"""


def imported(path: Path | str, bar: str | None = None) -> tuple[str, list[str]]:
    """Read a table of links and joints, and write it as a study.

    Parameters
    ----------
    path : path-like
        A table (CSV) of links and joints.
    bar : str, optional
        Mass per length, such as ``0.8 kg/m``, by which links without mass and inertia get those of a uniform
        slender bar.

    Returns
    -------
    text : str
        A study file.
    missing : list of str
        Keys that have to be filled in before the study can run.

    Raises
    ------
    InputError
        If the file cannot be read, or what it holds is no linkage.
    """
    density = None if bar is None else _density(bar)
    if Path(path).suffix.lower() != ".csv":
        raise refuse(str(path), "a file that ends in .csv (a table of links and joints) is accepted", "file")
    table, angles = _read(read_text(path, "file", "a table of links and joints (CSV, UTF-8)"))
    for link in table["links"] if density else ():
        length = _si(link["length"], "m")
        if length and not NEEDED.keys() & link.keys():
            link |= {"mass": density * length, "inertia": density * length**3 / 3}  # about its end
    lines = [*_lines(table, angles, _complete(table), Path(path).name)]
    missing = [
        f"mechanism.links[{i}].{key} ({link['name']})"
        for i, link in enumerate(table["links"])
        for key in NEEDED
        if key not in link
    ]
    return "\n".join(lines) + "\n", missing


def _read(text: str) -> tuple[dict[str, Any], dict[str, float]]:
    """Read a ``[mechanism]`` table and rough angles of links, rad; `InputError` by the lines of the file."""
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
    raise_any(problems)
    return table, angles


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


def _density(bar: str) -> float:
    density = _si(bar, "kg/m")
    if density is None or density <= 0:
        accepted = "a mass per length greater than 0, such as '0.8 kg/m', is accepted"
        raise InputError([Problem("--bar", bar, accepted)])
    return density


def _si(value: Any, units: str) -> float | None:
    """A value in SI units; None where it is none, as its record reports."""
    try:
        value = in_si(value, units)
    except InputError:
        return None
    sound = isinstance(value, float) and SMALLEST <= abs(value) <= 1 / SMALLEST
    return value if sound else None


def _complete(table: Mapping[str, Any]) -> Mechanism:
    """The mechanism with some mass and inertia where they are missing, for the checks of all the rest."""
    links = []
    for link in table["links"]:
        length, mass, inertia = (_si(link.get(key), units) for key, units in OF_A_BAR.items())
        square = (length or 1.0) ** 2
        links.append({"mass": (inertia or square) / square, "inertia": square * (mass or 1.0)} | link)
    names = [part["name"] for kind in ("links", "joints") for part in table[kind]]
    if odd := [name for name in names if not str(name).isprintable()]:
        raise InputError(Problem("name", name, "a name of printable characters is accepted") for name in odd)
    return Mechanism.model_validate(table | {"links": links})


def _branch(mechanism: Mechanism, angles: Mapping[str, float]) -> str | None:
    """On which branch of a four-bar its links have nearly these angles; None of another linkage."""
    if FourBar.of(mechanism.joints, mechanism.crank) is None or not angles:
        return None
    apart = {}
    for branch in get_args(Branch):
        try:
            ideal = ideal_state(mechanism, angles.get(mechanism.crank, 0.0), branch=branch).angles
        except InputError:  # drawn at a dead centre
            return None
        off = (abs(math.remainder(ideal[name] - angle, math.tau)) for name, angle in angles.items())
        apart[branch] = max(off)
    nearest = min(apart, key=apart.get)
    return nearest if apart[nearest] < NEAR else None


def _lines(
    table: Mapping[str, Any], angles: Mapping[str, float], mechanism: Mechanism, source: str
) -> Iterator[str]:
    """The lines of a study file."""
    branch = _branch(mechanism, angles)
    yield f"# From {one_line(source)}. Lines that say FILL IN stand for what that file does not hold."
    yield from ('kind = "response"', "", "[mechanism]", 'name = "linkage"')
    if branch:
        yield f"branch = {written(branch)}"
    elif angles:
        drawn = ", ".join(f"{written(name)} = {angle:.9g}" for name, angle in angles.items())
        dead = FourBar.of(mechanism.joints, mechanism.crank) is not None
        word = "# These angles are of no branch, or of both:" if dead else "guess ="
        yield f"{word} {{ {drawn} }}    # rad"
    for link in table["links"]:
        yield from ("", "[[mechanism.links]]", *(f"{key} = {written(value)}" for key, value in link.items()))
        yield from (f"# FILL IN: {key} =    # {words}" for key, words in NEEDED.items() if key not in link)
        if "centre" not in link:
            yield "# centre =    # m from the origin; half the length if left out"
    for joint in table["joints"]:
        yield from (
            "",
            "[[mechanism.joints]]",
            *(f"{key} = {written(value)}" for key, value in joint.items()),
        )
    yield AT_THE_END
    if branch:
        yield f"initial = {{ crank_angle = {angles.get(mechanism.crank, 0.0)!r} }}"
