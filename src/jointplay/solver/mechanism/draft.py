"""Rules between the parts of a mechanism: names, places, connection, closure.

The checks take a draft, in which a part that is itself invalid is None, so that they still find what is wrong
elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from jointplay.display.errors import InputError, Problem, unknown
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import GROUND, MOST, Record
from jointplay.solver.mechanism.loops.four_bar import find_four_bar
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.drive import DRIVES, AnyDrive
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.parts.loads import Force, Torque
from jointplay.solver.mechanism.parts.springs import Spring, TorsionSpring
from jointplay.solver.mechanism.plausible import too_wide


def driven_link(drive: AnyDrive | None, links: Sequence[str], joints: Sequence[Joint]) -> str | None:
    """Name the link that a drive turns; without a drive the first link pinned to the ground, if any is."""
    turning = [joint.links for joint in joints if not joint.prismatic]
    grounded = (name for name in links if {name, GROUND} in turning)
    return drive.link if drive else next(grounded, None)


@dataclass(frozen=True)
class Draft:
    """Parts with the names they were given; the record is None where a part is invalid in itself.

    Parameters
    ----------
    links, joints, springs, loads : list of (str or None, record or None)
        In the order given.
    drive : record or None
        None where there is no drive, or an invalid one.
    guess : tuple
        Names of which a rough position is given.
    """

    links: Sequence[tuple[Any, Link | None]]
    joints: Sequence[tuple[Any, Joint | None]]
    drive: AnyDrive | None
    springs: Sequence[tuple[Any, Any]] = ()
    loads: Sequence[tuple[Any, Any]] = ()
    guess: tuple[Any, ...] = ()

    @classmethod
    def of(cls, data: Any) -> Draft:
        """Read the valid parts out of raw input, or out of a mechanism."""
        value = data.get if isinstance(data, Mapping) else lambda key: getattr(data, key, None)
        drive = value("drive")
        drives = filter(None, (_valid(kind, drive) for kind in DRIVES if drive is not None))
        parts, guess = [_parts(value(key), *kinds) for key, kinds in _KINDS.items()], value("guess")
        guessed = tuple(guess) if isinstance(guess, Mapping) else ()
        return cls(*parts[:2], next(drives, None), *parts[2:], guessed)

    @cached_property
    def names(self) -> list[str]:
        """Names of the links that can be names, of invalid links too."""
        return [name for name, _ in self.links if isinstance(name, str) and name != GROUND]

    def problems(self) -> list[Problem]:
        """List everything wrong between the parts; keys are relative to the mechanism."""
        problems = [p for key in _KINDS for p in _duplicates(key, getattr(self, key))]
        if not self.links or len(set(self.names)) < len(self.links):
            return problems  # with a link's name unknown, none can be called missing
        problems += [*self._misplaced_pins(), *self._misnamed_links()]
        problems += self._strange_guesses()
        if self.drive and self.drive.link not in self.names:
            problems.append(unknown("drive.link", self.drive.link, self.drive.link, self.names, "link"))
        joints = [joint for _, joint in self.joints if joint is not None]
        if problems or not joints or len(joints) < len(self.joints):
            return problems  # what is connected to what is not known well enough to say more
        found = [*self._loose_links(joints), *self._locked(joints), *self._open_loop(joints)]
        found += [*_rubbed(joints), *self._too_wide(joints), *self._unfit_guides(joints)]
        found += self._thinner_than_pins(joints)
        return found or list(self._unwound(joints))

    def _unwound(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        """A torsion spring needs whole turns counted, which links of a closed loop are not."""
        twisted = [each for each in self._twisted() if each[0].startswith("springs")]
        if not twisted or not all(joint.ideal for joint in joints):
            return
        loop = find_four_bar(joints, driven_link(self.drive, self.names, joints))
        for key, name in twisted if loop else ():
            if name in loop.links[1:]:
                text = f"{loop.crank} or ground is accepted while no joint has clearance: the angles of other"
                yield Problem(key, name, f"{text} links are then known up to whole turns only")

    def _too_wide(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        links = [link for _, link in self.links if link is not None]
        for i, joint in enumerate(joints):
            if text := too_wide(joint.clearance, links):
                yield Problem(f"joints[{i}].clearance", joint.clearance, text)

    def _thinner_than_pins(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        """Links whose shape has no room for the pin, or its hole, of a joint."""
        thickest = {}
        for joint in joints:
            for name in joint.links if joint.radius else ():
                thickest[name] = max(thickest.get(name, (0.0, "")), (2 * joint.radius, joint.name))
        for i, (name, link) in enumerate(self.links):
            if not (link and link.shape and name in thickest):
                continue
            (key, across), (pin, joint) = link.shape.across, thickest[name]
            if across <= pin:
                size = f"a {key.partition('.')[2]} greater than {pin:g} m is accepted"
                text = f"{size}: the pin of joint {joint} is that thick"
                yield Problem(f"links[{i}].shape.{key}", across, text)

    def _unfit_guides(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        """Links that bend at a guide, and guides whose contacts are called as another joint."""
        bent = {link.name for _, link in self.links if link is not None and link.elastic}
        names = [joint.name for joint in joints]
        for i, joint in enumerate(joints):
            for side in ("journal", "bearing") * joint.prismatic:
                if (name := getattr(joint, side).link) in bent:
                    text = "a rigid link is accepted: what slides would bend an elastic one"
                    yield Problem(f"joints[{i}].{side}.link", name, text)
            loose = joint.prismatic and not joint.ideal
            if loose and (same := {*joint.contacts} & {*names}):
                text = f"a name is accepted whose corner is not called as another joint, {', '.join(same)}"
                yield Problem(f"joints[{i}].name", joint.name, text)

    def _misplaced_pins(self) -> Iterator[Problem]:
        known = {name: link for name, link in self.links if link is not None}
        for key, pin in self._pins():
            if pin.link not in (*self.names, GROUND):
                yield unknown(f"{key}.link", pin.link, pin.link, [*self.names, GROUND], "link")
            elif (link := known.get(pin.link)) and (limit := _limit(pin.at, link)):
                yield Problem(f"{key}.at", pin.at, f"a distance along the link {limit} is accepted")

    def _misnamed_links(self) -> Iterator[Problem]:
        """Problems of links that are named by springs and loads: which feel a moment, whose angle counts."""
        known = {name: link for name, link in self.links if link is not None}
        for key, name in self._twisted():
            accepted = [*self.names, GROUND] if key.startswith("springs") else self.names
            if name not in accepted:
                yield unknown(key, name, name, accepted, "link")
            elif name in known and known[name].elastic:
                text = "a rigid link is accepted: a moment on an elastic one would bend it"
                yield Problem(key, name, text)
        for i, (_, load) in enumerate(self.loads):
            if load and load.angle not in (None, *self.names):
                yield unknown(f"loads[{i}].angle", load.angle, load.angle, self.names, "link")

    def _pins(self) -> Iterator[tuple[str, Pin]]:
        """Every pin with its key."""
        for i, (_, joint) in enumerate(self.joints):
            for side in ("journal", "bearing") if joint else ():
                yield f"joints[{i}].{side}", getattr(joint, side)
        for kind in ("springs", "loads"):
            for i, (_, part) in enumerate(getattr(self, kind)):
                yield from ((f"{kind}[{i}].{end}", pin) for end, pin in (part.pins if part else {}).items())

    def _twisted(self) -> Iterator[tuple[str, str]]:
        """Every link that feels a moment, with its key."""
        for i, (_, spring) in enumerate(self.springs):
            ends = zip(("from", "to"), spring.links, strict=True) if spring and spring.twists else ()
            yield from ((f"springs[{i}].{end}", link) for end, link in ends)
        for i, (_, load) in enumerate(self.loads):
            if load and load.twists:
                yield f"loads[{i}].link", load.link

    def _strange_guesses(self) -> Iterator[Problem]:
        slides = [name for name, joint in self.joints if joint is None or joint.prismatic]
        known = [*self.names, *(name for name in slides if isinstance(name, str))]
        for name in self.guess:
            if name not in known:
                yield unknown(f"guess.{name}", name, name, known, "link or prismatic joint")

    def _loose_links(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        connected, before = {GROUND}, set()
        while connected != before:
            before = set(connected)
            for joint in joints:
                connected |= joint.links if joint.links & connected else set()
        for i, name in enumerate(self.names):
            if name not in connected:
                text = "a link that joints connect to the ground is accepted"
                yield Problem(f"links[{i}].name", name, text)

    def _locked(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        ideal = [joint.name for joint in joints if joint.ideal]
        most = (3 * len(self.links) - 1) // 2  # a joint takes two freedoms, a link has three, one must stay
        if len(ideal) > most:
            text = f"at most {most} ideal joints leave {len(self.links)} links free to move"
            yield Problem("joints", ideal, text)

    def _open_loop(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        loop = find_four_bar(joints, driven_link(self.drive, self.names, joints))
        if loop is not None and not loop.closes:
            rule = "none 0 and the longest shorter than the other three together"
            text = f"distances between pins (m) that can close are accepted: {rule}"
            yield Problem("links", loop.lengths, text)


_KINDS = {
    "links": (Link,),
    "joints": (Joint,),
    "springs": (Spring, TorsionSpring),
    "loads": (Force, Torque),
}


def _rubbed(joints: Sequence[Joint]) -> Iterator[Problem]:
    """Friction other than Coulomb's where the law is one of impacts, in which only that has a meaning."""
    for i, joint in enumerate(joints):
        friction, rigid = joint.friction, not joint.ideal and LAWS[joint.contact.law].rigid
        wrong = {"law": friction.law, "viscous": friction.viscous} if rigid and friction else {}
        for key, value in wrong.items():
            if value not in ("coulomb", 0.0):
                text = f"Coulomb's law without a viscous part is accepted with the law {joint.contact.law}"
                yield Problem(f"joints[{i}].friction.{key}", value, text)


def _parts(given: Any, *kinds: type[Record]) -> list[tuple[Any, Any]]:
    parts = given if isinstance(given, list | tuple) and len(given) <= MOST else ()
    names = (part.get("name") if isinstance(part, Mapping) else getattr(part, "name", None) for part in parts)
    valid = (next(filter(None, (_valid(kind, part) for kind in kinds)), None) for part in parts)
    return list(zip(names, valid, strict=True))


def _valid(kind: Any, given: Any) -> Any:
    try:
        return given if isinstance(given, kind) else kind.model_validate(given)
    except InputError:
        return None


def _duplicates(kind: str, parts: Sequence[tuple[Any, Any]]) -> Iterator[Problem]:
    names = [name for name, _ in parts]
    for i, name in enumerate(names):
        if isinstance(name, str) and name in names[:i]:
            yield Problem(f"{kind}[{i}].name", name, f"a name that no other of the {kind} has is accepted")


def _limit(at: float, link: Link) -> str:
    """Say where on a link a pin may sit, if not at a distance; empty if it may."""
    if link.elastic and at != 0 and not math.isclose(at, link.length, rel_tol=1e-9):
        return f"of 0 or {link.length:g} m, the ends of the elastic {link.name},"
    return f"from 0 to {link.name}'s length of {link.length:g} m" if at > link.length else ""
