"""Every key of a mechanism, from its records: name, unit, default, and what their docstrings say."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

import jointplay
from jointplay.analysis.quantities import BALANCE, ENERGIES, WORDS
from jointplay.display.accepted import units_of
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.equations.quantity import ForceLaw
from jointplay.solver.mechanism import catalog, records
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.own.systems import SYSTEMS
from jointplay.solver.mechanism.parts import beam, contact_data, materials
from jointplay.solver.mechanism.parts.courses import Course
from jointplay.solver.mechanism.parts.drive import DRIVES
from jointplay.solver.mechanism.parts.friction import bounds
from jointplay.solver.mechanism.parts.joints import place_of
from jointplay.solver.mechanism.signature import types_of
from pages.text import markdown, parameters, story, summary, table

HEAD = ("key", "unit", "default", "meaning")
# headings of the page, where the keys stand in a study file, and their records
PLACES: tuple[tuple[str, str, tuple[type[Record], ...]], ...] = (
    ("The mechanism", "[mechanism]", (records.Mechanism,)),
    (
        "Equations of your own",
        "[mechanism] with states",
        (records.System, records.Touch, records.Rubbing, records.Switch, records.Impact, records.Jump),
    ),
    ("Links", "[[mechanism.links]]", (records.Link, records.PointMass, records.Beam)),
    (
        "Shapes of links",
        "shape, of a link",
        (beam.Shape, beam.Bar, beam.Rod, beam.Tube, beam.Plate, materials.Material),
    ),
    ("Joints", "[[mechanism.joints]]", (records.Joint, records.Pin)),
    ("Contact", "contact, of a joint", (records.Contact, contact_data.PinInBush)),
    ("Friction", "friction, of a joint", (records.Friction,)),
    ("Drives", "[mechanism.drive]", DRIVES),
    ("Loads", "[[mechanism.loads]]", (records.Force, records.Torque, records.Harmonic)),
    ("Springs", "[[mechanism.springs]]", (records.Spring, records.TorsionSpring)),
    (
        "Sections",
        "section, of [analysis]",
        (records.CrankAngle, records.ContactSection, records.SeparationSection, records.Plane),
    ),
)

OVER = {
    "link": "link",
    "joint": "joint with clearance",
    "pin": "ideal joint",
    "guide": "prismatic joint",
    "guided": "ideal joint, where one is prismatic",
    "bending": "link, where one bends",
    "state": "state of a system of equations",
    None: "–",
}


def meanings(record: type[Record]) -> dict[str, str]:
    """What each key of a record means."""
    own = parameters(record)
    shared = parameters(Course) if issubclass(record, Course) else {}
    return own | {
        name: text for name, text in shared.items() if "see `Course`" in own.get(name, "see `Course`")
    }


def rows(record: type[Record]) -> Iterator[tuple[str, str, str, str]]:
    """A row for each key of a record."""
    said = meanings(record)
    for name, field in record.model_fields.items():
        words = said.get(name) or f"{field.description or _kind(name, field)}."
        yield (
            f"`{name}`",
            units_of(field) or "",
            written_default(field.get_default(call_default_factory=True)),
            words,
        )


def _kind(name: str, field: FieldInfo) -> str:
    hint = field.annotation
    if get_origin(hint) is Literal:
        return "Which of the records this table is" if name == "kind" else "One of the words in its heading"
    return name.replace("_", " ").capitalize()


def written_default(default: Any) -> str:
    """A default as it is written in a table."""
    if default is PydanticUndefined:
        return "needed"
    if default is None or default in ((), {}) or isinstance(default, Record):
        return "–"
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    if isinstance(default, str):
        return f'`"{default}"`'
    if isinstance(default, list | tuple):
        return f"`{json.dumps(default)}`"
    return f"`{default:.6g}`" if isinstance(default, float) else f"`{default}`"


def law_numbers(laws: Mapping[str, ForceLaw], place: Callable[[str], str] = str) -> str:
    """Numbers of every law, each by its key, in a table."""
    lines = []
    for name, law in laws.items():
        for key, each in law.numbers.items():
            per_power = key == "stiffness" and each.units == "1"
            usual = "needed" if each.usual is None else f"`{each.usual:g}`"
            shown = "N/mⁿ" if per_power else each.units
            lines.append((f"`{name}`", f"`{place(key)}`", shown, usual, bounds(each, "1")))
    return table(("law", "key", "unit", "default", "accepted"), lines)


def quantities() -> str:
    """Recorded quantities with their units, by what they are of."""
    left_out = {*ENERGIES, *BALANCE}
    rows = [
        (f"`{name}`", OVER[word.of], "" if word.units == "1" else word.units, word.long_name)
        for name, word in WORDS.items()
    ]
    named = ", ".join(f"`{name}`" for name in WORDS if name in left_out)
    return (
        f"{table(('quantity', 'over', 'unit', 'meaning'), rows)}\n"
        f"A `response` or `section` without `record` keeps all that the mechanism has but {named}:\n"
        "these cost time, and are kept where `record` names them.\n"
    )


def page() -> str:
    """The page of all keys of a mechanism."""
    parts = [
        "# Every key of a mechanism\n",
        "The tables below are made from the program's own records. Numbers are in SI units; a text such as\n"
        '`"0.29 mm"` or `"1500 rpm"` gives another unit. In Python the keys are the keywords of the record\n'
        "whose name is in the heading. “Needed” means that there is no default, “–” that nothing is taken.\n",
    ]
    for heading, place, several in PLACES:
        parts.append(f"## {heading}\n\nIn a study file: `{place}`.\n")
        for record in several:
            kind = record.model_fields.get("kind")
            named = f', `kind = "{kind.default}"`' if kind and len(get_args(kind.annotation)) == 1 else ""
            parts.append(
                f"### {record.__name__}{named}\n\n{markdown(summary(record))}\n\n{table(HEAD, rows(record))}"
            )
        if heading == "Contact":
            parts.append(f"### Numbers of the laws of contact\n\n{law_numbers(LAWS, place_of)}")
        if heading == "Friction":
            parts.append(f"### Numbers of the laws of friction\n\n{law_numbers(FRICTIONS)}")
    parts.append(f"## Recorded quantities\n\nIn a study file: `record`, of `[analysis]`.\n\n{quantities()}")
    return "\n".join(parts)


def meaning(name: str, said: str) -> str:
    """What a keyword means, with the words of the function that it is as in."""
    found = re.match(r"As in `(\w+)`(, (?!or ))?[,.:]? ?(.*)", said)
    if not found:
        return said
    theirs = meaning(
        name, parameters(getattr(jointplay, found[1])).get(name, "Number in the equations above.")
    )
    own = found[3][:1].upper() + found[3][1:]
    return f"{own.rstrip('.')}: {theirs}" if found[2] else f"{theirs} {own}".strip()


def keyword_rows(
    function: Callable[..., Any], without: frozenset[str] = frozenset()
) -> Iterator[tuple[str, ...]]:
    """A row for each keyword of a function."""
    said, hints = parameters(function), types_of(function)
    for name, each in signature(function).parameters.items():
        if each.kind is each.VAR_KEYWORD or name in without:
            continue
        default = PydanticUndefined if each.default is each.empty else each.default
        units = units_of(FieldInfo.from_annotation(hints.get(name, Any))) or ""
        yield f"`{name}`", units, written_default(default), meaning(name, said.get(name, "As in `simulate`."))


def catalog_page() -> str:
    """The page of the catalog's entries."""
    parts = [
        "# The catalog\n",
        'A study file names an entry as `catalog = "chunmei2002"`, with its keywords as further keys of\n'
        "`[mechanism]`; in Python it is a function, `jp.catalog.chunmei2002(...)`.\n",
        "## Linkages\n",
    ]
    for name, function in sorted(catalog.NAMES.items(), key=lambda entry: entry[0] in SYSTEMS):
        if name == next(iter(SYSTEMS)):
            parts.append("## Test systems with known answers\n")
        parts.append(f"### {name}\n\n{markdown(story(function))}\n\n{table(HEAD, keyword_rows(function))}")
    changes = table(HEAD, rows(records.Changes))
    parts.append(f"## Changes that every linkage of the catalog takes\n\n{changes}")
    return "\n".join(parts)
