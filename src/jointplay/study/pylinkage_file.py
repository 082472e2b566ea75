"""Linkages of pylinkage: the JSON file that its `mechanism_to_json` writes, as of version 0.9.0.

The file has ``joints`` (id, type, position, name) and ``links`` (id, type, ids of joints, name). Joints of
type ``ground`` are fixed, those of type ``revolute`` turn; links are of type ``ground``, ``driver`` or
``link``. Its lengths have no unit; a driver's speed is an angle a step, not a second, and is left out.
Sliders, trackers and drivers that swing are refused, and so is a link whose joints do not lie in a line.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from jointplay.display.errors import NOTHING, InputError, Problem, refuse, unknown
from jointplay.solver.mechanism.base import GROUND, is_number
from jointplay.solver.mechanism.measures import in_si

STRAIGHT = 1e-6  # of a link's length: a joint this far off its line is on it
JOINTS, LINKS = ("ground", "revolute"), ("ground", "driver", "link")
FORMAT = "JSON as pylinkage's mechanism_to_json writes it (0.9.0), with joints and links, is accepted"


@dataclass(frozen=True)
class Drawing:
    """A mechanism as a file has it.

    Parameters
    ----------
    table : dict
        A ``[mechanism]`` table; what the file does not hold is left out.
    angles : dict of str to float
        Angles of the links as drawn, rad, if the file has places.
    notes : list of str
        What else is to be known of it, in lines.
    """

    table: dict[str, Any]
    angles: dict[str, float] = field(default_factory=dict)
    notes: Sequence[str] = ()


def read(text: str, unit: str | None) -> Drawing:
    """Read a file's text, whose lengths have this unit; `InputError` with all that cannot be told."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise refuse(text[:60], f"{FORMAT}; {error}", "file") from None
    if not isinstance(data, Mapping) or not (_tables(data.get("joints")) and _tables(data.get("links"))):
        raise refuse(text[:60], f"{FORMAT}; older files of joints alone are not read", "file")
    if problems := [*_wrong_joints(data["joints"]), *_wrong_links(data), *_wrong_unit(unit)]:
        raise InputError(problems)
    places = {joint["id"]: tuple(joint["position"]) for joint in data["joints"]}
    moving = sorted((link for link in data["links"] if link["type"] != GROUND), key=lambda link: link["type"])
    fixed = {key for link in data["links"] if link["type"] == GROUND for key in link["joints"]}
    fixed |= {joint["id"] for joint in data["joints"] if joint["type"] == GROUND}
    lines = {_name(link): _line({key: places[key] for key in link["joints"]}, fixed) for link in moving}
    table: dict[str, Any] = {"name": data.get("name") or "linkage", "links": [], "joints": []}
    for name, (_, along) in lines.items():
        table["links"].append({"name": name, "length": f"{max(along.values()):.15g} {unit}"})
    free = []
    for joint in data["joints"]:
        found = {name: along[joint["id"]] for name, (_, along) in lines.items() if joint["id"] in along}
        sides = [{"link": name, "at": f"{at:.15g} {unit}"} for name, at in found.items()]
        if joint["id"] in fixed:
            sides.insert(0, {"link": GROUND, "point": [f"{each:.15g} {unit}" for each in joint["position"]]})
        if len(sides) < 2:
            free.append(_name(joint))
        for n, journal in enumerate(sides[1:]):
            name = f"{_name(joint)}_{n + 1}" if n else _name(joint)
            table["joints"].append({"name": name, "journal": journal, "bearing": sides[0]})
    left = [f"Points that connect nothing are left out: {', '.join(free)}."] if free else []
    return Drawing(table, {name: angle for name, (angle, _) in lines.items()}, left)


def _name(part: Mapping[str, Any]) -> str:
    return str(part.get("name") or part["id"])


def _tables(parts: Any) -> bool:
    return isinstance(parts, list) and all(isinstance(part, Mapping) for part in parts)


def _wrong_unit(unit: str | None) -> Iterator[Problem]:
    accepted = "a unit of length, such as mm, is needed: the file does not say which its lengths have"
    try:
        if unit is None or not isinstance(in_si(f"1 {unit}", "m"), float):
            yield Problem("--unit", NOTHING if unit is None else unit, accepted)
    except InputError as error:
        yield Problem("--unit", unit, error.problems[0].expected)


def _wrong_joints(joints: Sequence[Mapping[str, Any]]) -> Iterator[Problem]:
    seen: list[str] = []
    for i, joint in enumerate(joints):
        kind, place = joint.get("type", NOTHING), joint.get("position", NOTHING)
        if kind not in JOINTS:
            yield unknown(f"joints[{i}].type", kind, kind, JOINTS, "type of joint that can be taken over")
        if not (isinstance(place, list) and len(place) == 2 and all(map(is_number, place))):
            yield Problem(f"joints[{i}].position", place, "two finite numbers are accepted")
        yield from _wrong_id(f"joints[{i}].id", joint.get("id", NOTHING), seen)


def _wrong_id(key: str, given: Any, seen: list[str]) -> Iterator[Problem]:
    """Yield a problem of an id; it is added to `seen`, those that precede it."""
    if not isinstance(given, str) or not given or given in seen:
        yield Problem(key, given, "a text that no other has is accepted")
    seen.append(given)


def _wrong_name(key: str, link: Mapping[str, Any], before: Sequence[Mapping[str, Any]]) -> Iterator[Problem]:
    """Yield a problem of a link that is called as another one before it."""
    name = link.get("name") or link.get("id")
    if name in [each.get("name") or each.get("id") for each in before]:
        yield Problem(key, name, "a name that no other link has is accepted")


def _wrong_links(data: Mapping[str, Any]) -> Iterator[Problem]:
    places = {str(joint.get("id")): joint.get("position") for joint in data["joints"]}
    seen: list[str] = []
    for i, link in enumerate(data["links"]):
        kind, own = link.get("type", NOTHING), link.get("joints", NOTHING)
        if kind not in LINKS:
            yield unknown(f"links[{i}].type", kind, kind, LINKS, "type of link that can be taken over")
        yield from _wrong_id(f"links[{i}].id", link.get("id", NOTHING), seen)
        yield from _wrong_name(f"links[{i}].name", link, data["links"][:i])
        ids = isinstance(own, list) and all(isinstance(key, str) for key in own)
        if not ids or (len(own) < 2 and kind != GROUND):
            yield Problem(f"links[{i}].joints", own, "a list of at least two joints is accepted")
        elif lost := [key for key in own if key not in places]:
            yield unknown(f"links[{i}].joints", own, lost[0], places, "joint")
        elif kind != GROUND and _bent([places[key] for key in own]):
            yield Problem(f"links[{i}].joints", own, "joints at different places in one line are accepted")


def _bent(places: Sequence[Any]) -> bool:
    """Whether places do not lie in a line, or two are the same."""
    try:
        (ax, ay), (bx, by) = max(combinations(places, 2), key=lambda pair: math.dist(*pair))
        length = math.hypot(bx - ax, by - ay)
        off = max(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) for x, y in places)
        return off > STRAIGHT * length**2 or min(math.dist(*pair) for pair in combinations(places, 2)) == 0
    except (TypeError, ValueError):  # a place is a problem of its own
        return False


def _line(places: Mapping[str, Any], fixed: Collection[str]) -> tuple[float, dict[str, float]]:
    """Angle of a link from its fixed end, or else the first, and distances of its joints from there."""
    _, ends = max((math.dist(places[a], places[b]), (a, b)) for a, b in combinations(places, 2))
    order = [*places]
    start, end = sorted(ends, key=lambda key: (key not in fixed, order.index(key)))
    (x, y), (x2, y2) = places[start], places[end]
    return math.atan2(y2 - y, x2 - x), {key: math.dist((x, y), place) for key, place in places.items()}
