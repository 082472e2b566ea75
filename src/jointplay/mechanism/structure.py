"""What must hold between the parts of a mechanism: names, places, connection, closure.

The checks take a draft, in which a part that is itself wrong is None, so that they still find what is wrong
elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from jointplay.errors import InputError, Problem, unknown
from jointplay.mechanism.base import GROUND, MOST, Record
from jointplay.mechanism.beam import Link
from jointplay.mechanism.drive import ConstantSpeed, MotorLine
from jointplay.mechanism.joints import Joint
from jointplay.mechanism.loop import find_four_bar


@dataclass(frozen=True)
class Draft:
    """Parts with the names they were given; the record is None where a part is wrong in itself.

    Parameters
    ----------
    links, joints : list of (str or None, record or None)
        In the order given.
    drive : record or None
        None where there is no drive, or a wrong one.
    """

    links: Sequence[tuple[Any, Link | None]]
    joints: Sequence[tuple[Any, Joint | None]]
    drive: MotorLine | ConstantSpeed | None

    @classmethod
    def of(cls, data: Any) -> Draft:
        """Read what is sound out of raw input, or out of a mechanism."""
        value = data.get if isinstance(data, Mapping) else lambda key: getattr(data, key, None)
        drive = value("drive")
        drives = (_sound(form, drive) for form in (MotorLine, ConstantSpeed) if drive is not None)
        drive = next((each for each in drives if each), None)
        return cls(_each(Link, value("links")), _each(Joint, value("joints")), drive)

    @property
    def names(self) -> list[str]:
        """Names of the links that can be names, of wrong links too."""
        return [name for name, _ in self.links if isinstance(name, str) and name != GROUND]

    @property
    def crank(self) -> str | None:
        """The driven link; without a drive the first link pinned to the ground."""
        return (
            self.drive.link if self.drive else first_on_ground(self.names, [j for _, j in self.joints if j])
        )


def first_on_ground(names: Sequence[str], joints: Sequence[Joint]) -> str | None:
    """Name the first link that a joint pins to the ground; None if there is none."""
    pairs = [{joint.journal.link, joint.bearing.link} for joint in joints]
    return next((name for name in names if {name, GROUND} in pairs), None)


def problems(draft: Draft) -> list[Problem]:
    """List everything wrong between the parts; keys are relative to the mechanism."""
    found = [*_duplicates("links", draft.links), *_duplicates("joints", draft.joints)]
    if not draft.links or len(set(draft.names)) < len(draft.links):
        return found  # with a link's name unknown, none can be called missing
    found += [*_pins(draft), *_driven(draft)]
    joints = [joint for _, joint in draft.joints if joint is not None]
    if found or not joints or len(joints) < len(draft.joints):
        return found  # what is connected to what is not known well enough to say more
    return [*_loose(draft, joints), *_locked(draft, joints), *_open(draft, joints)]


def _each(form: type[Record], given: Any) -> list[tuple[Any, Any]]:
    parts = given if isinstance(given, list | tuple) and len(given) <= MOST else ()
    names = (part.get("name") if isinstance(part, Mapping) else getattr(part, "name", None) for part in parts)
    return [(name, _sound(form, part)) for name, part in zip(names, parts, strict=True)]


def _sound(form: Any, given: Any) -> Any:
    try:
        return form.model_validate(given)
    except InputError:
        return None


def _duplicates(kind: str, parts: Sequence[tuple[Any, Any]]) -> Iterator[Problem]:
    names = [name for name, _ in parts]
    for i, name in enumerate(names):
        if isinstance(name, str) and name in names[:i]:
            yield Problem(f"{kind}[{i}].name", name, f"a name that no other of the {kind} has is accepted")


def _pins(draft: Draft) -> Iterator[Problem]:
    known = {name: link for name, link in draft.links if link is not None}
    for i, (_, joint) in enumerate(draft.joints):
        for side, pin in (("journal", joint.journal), ("bearing", joint.bearing)) if joint else ():
            key = f"joints[{i}].{side}"
            if pin.link not in (*draft.names, GROUND):
                yield unknown(f"{key}.link", pin.link, pin.link, [*draft.names, GROUND], "link")
            elif link := known.get(pin.link):
                limit = _misplaced(pin.at, link)
                if limit:
                    yield Problem(f"{key}.at", pin.at, f"a distance along the link {limit} is accepted")


def _misplaced(at: float, link: Link) -> str:
    """Say where on the link a pin may sit, if not there."""
    if link.elastic and at != 0 and not math.isclose(at, link.length, rel_tol=1e-9):
        return f"of 0 or {link.length:g} m, the ends of the elastic {link.name},"
    return f"from 0 to {link.name}'s length of {link.length:g} m" if at > link.length else ""


def _driven(draft: Draft) -> Iterator[Problem]:
    if draft.drive and draft.drive.link not in draft.names:
        yield unknown("drive.link", draft.drive.link, draft.drive.link, draft.names, "link")


def _loose(draft: Draft, joints: Sequence[Joint]) -> Iterator[Problem]:
    reached, before = {GROUND}, set()
    while reached != before:
        before = set(reached)
        for joint in joints:
            ends = {joint.journal.link, joint.bearing.link}
            reached |= ends if ends & reached else set()
    for i, name in enumerate(draft.names):
        if name not in reached:
            yield Problem(f"links[{i}].name", name, "a link that joints connect to the ground is accepted")


def _locked(draft: Draft, joints: Sequence[Joint]) -> Iterator[Problem]:
    ideal = [joint.name for joint in joints if not joint.clearance]
    most = (3 * len(draft.links) - 1) // 2  # a joint takes two freedoms, a link has three, one must stay
    if len(ideal) > most:
        yield Problem(
            "joints", ideal, f"at most {most} ideal joints leave {len(draft.links)} links free to move"
        )


def _open(draft: Draft, joints: Sequence[Joint]) -> Iterator[Problem]:
    loop = find_four_bar(joints, draft.crank)
    if loop is not None and not loop.closes:
        rule = "none 0 and the longest shorter than the other three together"
        yield Problem(
            "links", loop.lengths, f"distances between pins (m) that can close are accepted: {rule}"
        )
