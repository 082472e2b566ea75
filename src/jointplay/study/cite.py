"""References of a study: of its mechanism, laws and methods, as text and as BibTeX.

Each reference is stated once, in ``references.toml`` beside this file. Laws, kinds and mechanisms say what
they rest on in their rows; of parts without a row the table ``uses`` of that file says it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from jointplay.jobs.origin import version
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
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


Keys = Sequence[str] | None  # of references, or references as text; None: not stated


def parts(record: Study) -> dict[str, Keys]:
    """Parts of a study that may have references, each with the keys of these."""
    uses = table("uses")
    return {name: keys if keys is not None else uses.get(name) for name, keys in _parts(record)}


def _parts(record: Study) -> Iterator[tuple[str, Keys]]:
    exponents, mechanism = record.keywords().get("exponents"), record.mechanism
    yield from (("the integrator", None), (f"kind {record.kind}", record.row.references))
    if record.row.tangents or exponents:
        yield "saltation of tangents", None
    if exponents:
        yield "exponents", None
    if isinstance(mechanism, Mechanism):
        yield from _of_a_linkage(mechanism)
    else:
        yield from [(f"system {name}", _of(name)) for name in (mechanism.system,) if name]
        yield from [("impacts on rigid walls", None)] * bool(mechanism.impacts)


def _of(name: str) -> Keys:
    """References of an entry of the catalog."""
    return catalog.NAMES[name].references if name in catalog.NAMES else None


def _of_a_linkage(mechanism: Mechanism) -> Iterator[tuple[str, Keys]]:
    if mechanism.name in catalog.NAMES:
        yield f"mechanism {mechanism.name}", _of(mechanism.name)
    if isinstance(mechanism.drive, MotorLine):
        yield "the motor line", None
    if isinstance(mechanism.drive, Servo):
        yield "the servo", None
    if mechanism.elastic_links and mechanism.order == "paper":
        yield "the elastic links' paper order", None
    for joint in mechanism.clearance_joints:
        contact, friction = joint.contact.law, joint.friction and joint.friction.law
        yield f"geometry of {'guides' if joint.prismatic else 'joints'} with play", None
        yield "modes of contact", None
        yield f"contact law {contact}", LAWS[contact].references
        if joint.fit:
            yield "the clearance of a fit", None
        if joint.data:
            yield "contact data of a pin in its bush", None
        if friction:
            yield f"friction law {friction}", FRICTIONS[friction].references


def cited(record: Study) -> dict[str, list[str]]:
    """Give the references of a study by key, each with the parts that it is for, the program first."""
    reasons: dict[str, list[str]] = {"jointplay": ["the program"]}
    for part, keys in parts(record).items():
        for key in keys or ():
            reasons.setdefault(key, []).append(part)
    return reasons


def unstated(record: Study) -> list[str]:
    """Name the parts of a study whose references are not stated."""
    return [part for part, keys in parts(record).items() if keys is None]


def short(key: str) -> str:
    """Authors and year of a reference; as it stands, of one that is given as text."""
    if key not in table("references"):
        return key
    entry = _entry(key)
    *others, last = (_family(each) for each in entry["author"].split(", "))
    return f"{', '.join(others)}{' and ' * bool(others)}{last} ({entry['year']})"


def _family(person: str) -> str:
    return " ".join(part for part in person.split() if not part.endswith("."))


def _entry(key: str) -> dict[str, Any]:
    if key == "jointplay":
        return PROGRAM | {"version": version("jointplay")}
    return table("references").get(
        key, {"type": "misc", "note": key}
    )  # a whole reference, of a stranger's law


def _line(entry: dict[str, Any]) -> str:
    volume = ":".join(str(entry[name]) for name in ("volume", "pages") if name in entry)
    names = ("author", "title", "journal", "booktitle"), ("publisher", "note", "year")
    before, after = ([entry.get(name) for name in group] for group in names)
    about = f"version {entry['version']}" if "version" in entry else ""
    return ", ".join(str(each) for each in (*before, volume, *after, about) if each)


def as_text(record: Study) -> str:
    """List the references of a study, each with the parts that it is for."""
    found = (f"{_line(_entry(key))}\n    for {', '.join(parts)}" for key, parts in cited(record).items())
    return "\n".join([*found, *(f"not stated: what to cite for {part}" for part in unstated(record))])


def as_bibtex(record: Study) -> str:
    """List the references of a study as BibTeX entries."""
    entries = []
    for key in cited(record):
        entry = dict(_entry(key))
        people = entry.get("author", "").replace(", ", " and ")
        entry["author"] = f"{{{people}}}" if key == "jointplay" else people  # no person's name
        entry["title"] = f"{{{entry['title']}}}" if "title" in entry else ""  # its capitals are kept
        entry["pages"] = entry.get("pages", "").replace("-", "--")
        name = re.sub(r"\W+", "_", key)
        fields = [f"  {field} = {{{entry[field]}}}," for field in _ORDER if entry.get(field)]
        entries.append("\n".join([f"@{entry['type']}{{{name},", *fields, "}"]))
    missing = [f"% not stated: what to cite for {part}" for part in unstated(record)]
    return "\n\n".join(entries + missing)
