"""A linkage from another program's file, as the text of a study file.

What the file does not hold is not made up: it stands in the text as a comment to be filled in, and `check`
names it until it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from jointplay.display.errors import InputError, Problem
from jointplay.display.terminal import one_line
from jointplay.solver.mechanism.loops.closure import BRANCHES, ideal_state
from jointplay.solver.mechanism.loops.loop import find_four_bar
from jointplay.solver.mechanism.measures import SMALLEST, in_si
from jointplay.solver.mechanism.records import Mechanism
from jointplay.study import parts_table, pylinkage_file
from jointplay.study.pylinkage_file import Drawing
from jointplay.study.toml_text import read_text, written

READERS = {".json": pylinkage_file.read, ".csv": parts_table.read}
WHAT = {".json": "a file of pylinkage (JSON, UTF-8)", ".csv": "a table of links and joints (CSV, UTF-8)"}
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


def imported(path: Path | str, unit: str | None = None, bar: str | None = None) -> tuple[str, list[str]]:
    """Read a file, and write what it holds as a study.

    Parameters
    ----------
    path : path-like
        A JSON file of pylinkage, or a table (CSV) of links and joints.
    unit : str, optional
        Unit of the lengths of a file that does not say it.
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
    if (suffix := Path(path).suffix.lower()) not in READERS:
        accepted = "a file that ends in .json (of pylinkage) or .csv (links and joints) is accepted"
        raise InputError([Problem("file", str(path), accepted)])
    drawing = READERS[suffix](read_text(path, "file", WHAT[suffix]), unit)
    for link in drawing.table["links"] if density else ():
        length = _si(link["length"], "m")
        if length and not NEEDED.keys() & link.keys():
            link |= {"mass": density * length, "inertia": density * length**3 / 3}  # about its end
    lines = [*_lines(drawing, _complete(drawing), Path(path).name)]
    missing = [
        f"mechanism.links[{i}].{key} ({link['name']})"
        for i, link in enumerate(drawing.table["links"])
        for key in NEEDED
        if key not in link
    ]
    return "\n".join(lines) + "\n", missing


def _density(bar: str) -> float:
    density = _si(bar, "kg/m")
    if density is None or density <= 0:
        accepted = "a mass per length greater than 0, such as '0.8 kg/m', is accepted"
        raise InputError([Problem("--bar", bar, accepted)])
    return density


def _si(value: Any, units: str) -> float | None:
    """A value in SI units; None where it is none, which its record tells."""
    try:
        value = in_si(value, units)
    except InputError:
        return None
    sound = isinstance(value, float) and SMALLEST <= abs(value) <= 1 / SMALLEST
    return value if sound else None


def _complete(drawing: Drawing) -> Mechanism:
    """The mechanism with some mass and inertia where they are missing, to look at all the rest."""
    links = []
    for link in drawing.table["links"]:
        length, mass, inertia = (_si(link.get(key), units) for key, units in OF_A_BAR.items())
        square = (length or 1.0) ** 2
        links.append({"mass": (inertia or square) / square, "inertia": square * (mass or 1.0)} | link)
    names = [part["name"] for kind in ("links", "joints") for part in drawing.table[kind]]
    if odd := [name for name in names if not str(name).isprintable()]:
        raise InputError(Problem("name", name, "a name of printable characters is accepted") for name in odd)
    return Mechanism.model_validate(drawing.table | {"links": links})


def _branch(mechanism: Mechanism, angles: Mapping[str, float]) -> str | None:
    """On which branch of a four-bar its links have nearly these angles; None of another linkage."""
    if find_four_bar(mechanism.joints, mechanism.crank) is None or not angles:
        return None
    apart = {}
    for branch in BRANCHES:
        try:
            ideal, _ = ideal_state(mechanism, angles.get(mechanism.crank, 0.0), branch=branch)
        except InputError:  # drawn at a dead centre
            return None
        off = (abs(math.remainder(ideal[name] - angle, math.tau)) for name, angle in angles.items())
        apart[branch] = max(off)
    nearest = min(apart, key=apart.get)
    return nearest if apart[nearest] < NEAR else None


def _lines(drawing: Drawing, mechanism: Mechanism, source: str) -> Iterator[str]:
    """The lines of a study file."""
    table, branch = drawing.table, _branch(mechanism, drawing.angles)
    yield f"# From {one_line(source)}. Lines that say FILL IN stand for what that file does not hold."
    yield from (f"# {one_line(note)}" for note in drawing.notes)
    yield from ('kind = "response"', "", "[mechanism]", f"name = {written(table.get('name', 'linkage'))}")
    if branch:
        yield f"branch = {written(branch)}"
    elif drawing.angles:
        drawn = ", ".join(f"{written(name)} = {angle:.9g}" for name, angle in drawing.angles.items())
        dead = find_four_bar(mechanism.joints, mechanism.crank) is not None
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
        yield f"initial = {{ crank_angle = {drawing.angles.get(mechanism.crank, 0.0)!r} }}"
