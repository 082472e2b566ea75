"""What a study rests on: references of its mechanism, laws and methods, as text and as BibTeX.

Each reference, and what uses it, is stated once, in ``references.toml`` beside this file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from typing import Any

from jointplay.jobs.origin import version
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.records import Mechanism, MotorLine, Servo
from jointplay.study.models import Study

PROGRAM = {
    "type": "misc",
    "author": "The jointplay authors",
    "title": "jointplay: nonlinear dynamics of planar linkages with play in their joints",
}
_ORDER = (
    "author",
    "title",
    "journal",
    "booktitle",
    "volume",
    "pages",
    "publisher",
    "note",
    "year",
    "version",
)


@cache
def table(name: str) -> dict[str, Any]:
    """The table ``references`` or ``uses``."""
    return tomllib.loads(files("jointplay.study").joinpath("references.toml").read_text("utf-8"))[name]


def parts(record: Study) -> list[str]:
    """Name what a study uses that may have references, as ``uses`` does."""
    found = ["the integrator", f"kind {record.kind}"]
    exponents = record.keywords().get("exponents")
    found += ["saltation of tangents"] * bool(record.row.tangents or exponents) + ["exponents"] * bool(
        exponents
    )
    mechanism = record.mechanism
    if isinstance(mechanism, Mechanism):
        return list(dict.fromkeys([*found, *_of_a_linkage(mechanism)]))
    own = [f"system {mechanism.system}"] * (mechanism.system is not None)
    return [*found, *own, *["impacts on rigid walls"] * bool(mechanism.impacts)]


def _of_a_linkage(mechanism: Mechanism) -> Iterator[str]:
    if mechanism.name in catalog.NAMES:
        yield f"mechanism {mechanism.name}"
    if isinstance(mechanism.drive, MotorLine):
        yield "the motor line"
    if isinstance(mechanism.drive, Servo):
        yield "the servo"
    if mechanism.elastic_links and mechanism.order == "paper":
        yield "the elastic links' paper order"
    for joint in mechanism.clearance_joints:
        kind = "guides" if joint.prismatic else "joints"
        yield from (f"geometry of {kind} with play", "modes of contact", f"contact law {joint.contact.law}")
        if joint.friction:
            yield f"friction law {joint.friction.law}"


def cited(record: Study) -> dict[str, list[str]]:
    """Give the references of a study by key, each with the parts that it is for, the program first."""
    reasons: dict[str, list[str]] = {"jointplay": ["the program"]}
    for part in parts(record):
        for key in table("uses").get(part, ()):
            reasons.setdefault(key, []).append(part)
    return reasons


def unstated(record: Study) -> list[str]:
    """Name the parts of a study of which it is not stated what they rest on."""
    return [part for part in parts(record) if part not in table("uses")]


def _entry(key: str) -> dict[str, Any]:
    return PROGRAM | {"version": version("jointplay")} if key == "jointplay" else table("references")[key]


def _line(entry: dict[str, Any]) -> str:
    volume = ":".join(str(entry[name]) for name in ("volume", "pages") if name in entry)
    names = ("title", "journal", "booktitle"), ("publisher", "note", "year")
    before, after = ([entry.get(name) for name in group] for group in names)
    about = f"version {entry['version']}" if "version" in entry else ""
    return ", ".join(str(each) for each in (entry["author"], *before, volume, *after, about) if each)


def as_text(record: Study) -> str:
    """List the references of a study, each with what it is for."""
    found = (f"{_line(_entry(key))}\n    for {', '.join(parts)}" for key, parts in cited(record).items())
    return "\n".join([*found, *(f"not stated: what to cite for {part}" for part in unstated(record))])


def as_bibtex(record: Study) -> str:
    """List the references of a study as BibTeX entries."""
    entries = []
    for key in cited(record):
        entry = dict(_entry(key))
        people = entry["author"].replace(", ", " and ")
        entry["author"] = f"{{{people}}}" if key == "jointplay" else people  # no person's name
        entry["title"] = f"{{{entry['title']}}}" if "title" in entry else ""  # its capitals are kept
        entry["pages"] = entry.get("pages", "").replace("-", "--")
        fields = [f"  {name} = {{{entry[name]}}}," for name in _ORDER if entry.get(name)]
        entries.append("\n".join([f"@{entry['type']}{{{key},", *fields, "}"]))
    missing = [f"% not stated: what to cite for {part}" for part in unstated(record)]
    return "\n\n".join(entries + missing)
