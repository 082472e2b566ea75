"""Systems to simulate: a linkage, `Mechanism`, in SI units, or a small known system, `TestSystem`.

All are validated and frozen; every record of the package can be imported from here.

Poincaré sections: the events of a motion at which its state is recorded.

Rules between the parts of a mechanism: names, places, connection, closure.

The checks take a draft, in which a part that is itself invalid is None, so that they still find what is wrong
elsewhere.
"""

from __future__ import annotations

import math

# ruff: noqa: F401  records are offered here that nothing here uses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from jointplay.display.accepted import from_pydantic
from jointplay.display.errors import InputError, Problem, raise_any, strangers, unknown
from jointplay.display.number_text import measure
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism import plausible
from jointplay.solver.mechanism.base import (
    DOWNWARDS,
    GROUND,
    MOST,
    Branch,
    Few,
    Flag,
    Name,
    Number,
    Record,
    Several,
    Turn,
    accepts,
    hash_of,
    in_millimetres,
    is_number,
    measured,
    named,
)
from jointplay.solver.mechanism.changes import Changes, changed, value_of
from jointplay.solver.mechanism.loops.dyads import FourBar
from jointplay.solver.mechanism.own.own import System
from jointplay.solver.mechanism.own.own_parts import Impact, Jump, Rubbing, Switch, Touch
from jointplay.solver.mechanism.own.systems import TestSystem
from jointplay.solver.mechanism.parts.beam import Beam, Link, PointMass
from jointplay.solver.mechanism.parts.courses import Harmonic
from jointplay.solver.mechanism.parts.drive import (
    DRIVES,
    AnyDrive,
    ConstantSpeed,
    Drive,
    MotorLine,
    PrescribedTorque,
    Servo,
    SpeedCycle,
    SpeedProfile,
)
from jointplay.solver.mechanism.parts.joints import Contact, Friction, Joint, Pin
from jointplay.solver.mechanism.parts.loads import AnyLoad, AnySpring, Force, Spring, Torque, TorsionSpring
from jointplay.solver.mechanism.paths import (
    as_counted,
    begun_anew,
    checked_paths,
    main_joint,
    one_by_one,
    parts_of,
    with_parts,
)
from jointplay.solver.mechanism.plausible import too_wide
from jointplay.solver.mechanism.signature import as_one, checked


class Mechanism(Record):
    """A planar linkage.

    Parameters
    ----------
    name : str
        Name, for titles.
    links : tuple of Link
        Moving links; the ground is not among them.
    joints : tuple of Joint
        Joints between links, or between a link and the ground.
    drive : MotorLine, ConstantSpeed or None
        What turns the driven link; None: nothing does.
    springs : tuple of Spring or TorsionSpring
        Springs with dampers between links, or between a link and the ground.
    loads : tuple of Force or Torque
        Forces and torques on links.
    gravity : float
        Acceleration, m/s².
    gravity_direction : float
        Where it points to, rad anticlockwise from x; along −y if left out.
    branch : {'upper', 'lower'}
        Which way a four-bar is assembled: with the joint between coupler and rocker above or below
        (`jointplay.solver.mechanism.loops.ideal.ideal_state` says exactly).
    order : {'consistent', 'paper'}
        Inertia terms of elastic links: all to second order in the deflection, or those of Chunmei et al.
        (2002), equations (3) to (12); unused while every link is rigid.
    guess : dict of str to float
        Rough angle of each link by name, rad (left out: those on guides; the driven one, 0), and where wanted
        slides by joint name, m. The branch on which the mechanism is assembled, where it is no four-bar.
    as_meant : bool
        Whether its numbers, its start and its section are as meant, however strange: nothing is doubted.
    """

    name: Name = "linkage"
    links: Several[Link] = Field(json_schema_extra={"accepts": "a list of at least one link"})
    joints: Several[Joint] = Field(json_schema_extra={"accepts": "a list of at least one joint"})
    drive: Annotated[Drive | None, Field()] = None
    springs: Few[AnySpring] = ()
    loads: Few[AnyLoad] = ()
    gravity: Number = measured("gravity", "m/s²", 9.8)
    gravity_direction: Turn = measured("direction of gravity", "rad", DOWNWARDS)
    branch: Branch = "upper"
    order: Literal["consistent", "paper"] = "consistent"
    guess: dict[Name, Number] = Field(
        default={}, json_schema_extra={"accepts": "a table of angles by link, in rad,"}
    )
    as_meant: Flag = False

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        joints, guess = data.get("joints"), data.get("guess")
        known = joints if isinstance(joints, list | tuple) else ()
        slides = [_value(each, "name") for each in known if _value(each, "kind") == "prismatic"]
        names = guess if isinstance(guess, Mapping) else ()
        return {"guess": {name: "m" if name in slides else "rad" for name in names}}

    @model_validator(mode="wrap")
    @classmethod
    def _every_problem_at_once(cls, data: Any, build: Callable[[Any], Self]) -> Self:
        # pydantic alone would look at how the parts fit only once each of them is right.
        record, problems, more = None, [], 0
        try:
            record = build(data)
        except ValidationError as invalid:
            error = from_pydantic(invalid, cls)
            problems, more = error.problems, error.more
        problems += Draft.of(data if record is None else record).problems()
        problems += plausible.nonsense(record) if record is not None else ()
        if problems or record is None:
            raise InputError(problems, more=more)
        return record

    def __hash__(self) -> int:
        return hash_of(self)

    @property
    def clearance_joints(self) -> tuple[Joint, ...]:
        """The joints with clearance, in order; joints with a law of impact after the others."""
        loose = [joint for joint in self.joints if not joint.ideal]
        return tuple(sorted(loose, key=lambda joint: LAWS[joint.contact.law].rigid))

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts of the joints with clearance, in their order."""
        return tuple(name for joint in self.clearance_joints for name in joint.contacts)

    @property
    def guides(self) -> tuple[str, ...]:
        """Prismatic joints as results call them: an ideal one by its name, another by its contacts'."""
        sliding = (joint for joint in self.joints if joint.prismatic)
        return tuple(name for joint in sliding for name in (joint.contacts or (joint.name,)))

    @property
    def elastic_links(self) -> tuple[Link, ...]:
        """The links that bend, in order."""
        return tuple(link for link in self.links if link.elastic)

    @property
    def crank(self) -> str | None:
        """Name of the driven link; without a drive, of the first link that is pinned to the ground."""
        return driven_link(self.drive, [link.name for link in self.links], self.joints)

    def link(self, name: str) -> Link:
        """Give the link of this name."""
        return self._part(self.links, name, "link")

    def joint(self, name: str) -> Joint:
        """Give the joint of this name."""
        return self._part(self.joints, name, "joint")

    @staticmethod
    def _part(parts: tuple[Any, ...], name: str, what: str) -> Any:
        named = {part.name: part for part in parts}
        raise_any(strangers([(what, name)], named, what))
        return named[name]

    @checked(before=lambda given: as_one(given, main_joint(given["self"])))
    def replace(self, **changes: Any) -> Mechanism:
        """Give a changed, validated copy.

        Parameters
        ----------
        **changes
            `clearance`, `gear_ratio`, `friction`, `tension`, `efficiency_in_slope`, `elastic`, `elements`,
            `damping_ratio`, `order`, `branch`, `gravity`, `gravity_direction`, `springs`, `loads`, `drive`,
            `speed`: see `Changes`; then parts, as ``joints={"C": {"clearance": 1e-4}}`` or by key path,
            ``**{"joints.C.clearance": 1e-4}``; and several that change by as much, as
            ``links.coupler.length + joints.B.journal.at``.

        Raises
        ------
        InputError
            Listing every change that does not exist, cannot have its value, or finds nothing to change.
        """
        return self.changed(changes)

    def changed(self, changes: Mapping[str, Any]) -> Mechanism:
        """Give the copy of `replace`; where a clearance stands by word and by path, that by path holds."""
        several = [(k, v) for k, v in changes.items() if len(parts_of(k)) > 1 and not is_number(v)]
        raise_any(Problem(k, v, "a number in SI units is accepted for several together") for k, v in several)
        changes = begun_anew(self, one_by_one(changes, partial(value_of, self)))
        by_path = checked_paths(self, changes)
        named = {name: value for name, value in changes.items() if name not in by_path}
        return with_parts(changed(self, named), by_path)

    def varied(self, changes: Mapping[str, Any]) -> Mechanism:
        """Give a copy as sweeps vary it, by the keys of `mechanism.parameters`.

        A whole float is accepted where `replace` wants an integer.
        """
        if not changes:
            return self
        if all(type(value) in (int, float) for value in changes.values()):
            return _with_numbers(self, tuple(changes), *changes.values())
        return self._varied(changes)

    def _varied(self, changes: Mapping[str, Any]) -> Mechanism:
        single = one_by_one(changes, partial(value_of, self))
        return self.replace(**{key: as_counted(Changes, key, value) for key, value in single.items()})

    def numbers_alone(self) -> Mechanism:
        """Give the same mechanism without the sources of its numbers, so that each changes by itself.

        Shapes of links, fits and parts of joints are left out; a joint without clearance keeps its parts.
        """
        links = tuple(link.model_copy(update={"shape": None}) for link in self.links)
        return self.model_copy(
            update={"links": links, "joints": tuple(joint.numbers_alone() for joint in self.joints)}
        )

    def known_by(self, numbers: Mapping[str, float]) -> Mechanism:
        """Give the copy with other numbers, for a hash."""
        return self.varied(numbers)

    def summary(self) -> str:
        """Describe the mechanism in a few lines of text."""
        every = {"link": self.links, "joint": self.joints, "spring": self.springs, "load": self.loads}
        parts = [f"  {what} {part.name}: {part.description}" for what, all_ in every.items() for part in all_]
        order = f", {self.order} order" if self.elastic_links else ""
        towards = measure(self.gravity_direction, "rad")
        towards = f" towards {towards}" if self.gravity_direction != DOWNWARDS else ""
        last = f"  gravity {measure(self.gravity, 'm/s2')}{towards}, {self.branch} branch{order}"
        return "\n".join([self.name, *parts, f"  drive: {self._drive}", last])

    def __repr__(self) -> str:
        sizes = ", ".join(f"{j.name} {measure(j.clearance, 'm')}" for j in self.clearance_joints) or "none"
        links = ", ".join(link.name for link in self.links)
        elastic = ", ".join(link.name for link in self.elastic_links)
        bends = f"; elastic: {elastic}" if elastic else ""
        return f"<Mechanism {self.name}: {links}{bends}; clearance: {sizes}; drive: {self._drive}>"

    __str__ = __repr__

    @property
    def _drive(self) -> str:
        return self.drive.description if self.drive else "none"


@lru_cache(maxsize=1024, typed=True)
def _with_numbers(mechanism: Mechanism, keys: tuple[str, ...], *values: float) -> Mechanism:
    """A varied copy, made once for all who check, name and follow a cell; 1 is another value than 1.0."""
    return mechanism._varied(dict(zip(keys, values, strict=True)))


class CrankAngle(Record):
    """Once a turn, where the driven link passes an angle.

    Parameters
    ----------
    angle : float
        rad, at most a turn to either side.
    """

    kind: Literal["crank_angle"] = "crank_angle"
    angle: Turn = measured("crank angle", "rad", 0.0)


ONCE_A_TURN = CrankAngle()


class ContactSection(Record):
    """Each time a joint comes into contact.

    Parameters
    ----------
    joint : str, optional
        A joint with clearance; any of them if left out.
    """

    kind: Literal["contact"] = "contact"
    joint: Name | None = named("joint name", None)


class SeparationSection(Record):
    """Each time a joint loses contact.

    Parameters
    ----------
    joint : str, optional
        A joint with clearance; any of them if left out.
    """

    kind: Literal["separation"] = "separation"
    joint: Name | None = named("joint name", None)


class Plane(Record):
    """Each time a recorded quantity passes a value in one direction.

    Parameters
    ----------
    quantity : str
        Name of the quantity, as in a response's dataset.
    link, joint : str, optional
        Whose quantity it is, for those that each link or each joint has.
    value : float
        The value, in the quantity's own units.
    direction : {'up', 'down'}
        Rising or falling through the value.
    """

    kind: Literal["plane"] = "plane"
    quantity: Name = named("quantity name")
    link: Name | None = named("link name", None)
    joint: Name | None = named("joint name", None)
    value: Number
    direction: Literal["up", "down"] = "up"


_KINDS = "a table of kind crank_angle, contact, separation or plane (in Python also CrankAngle() and so on)"


Section = Annotated[
    CrankAngle | ContactSection | SeparationSection | Plane, Field(discriminator="kind"), accepts(_KINDS)
]


def driven_link(drive: AnyDrive | None, links: Sequence[str], joints: Sequence[Joint]) -> str | None:
    """Name the link that a drive turns; without a drive the first link pinned to the ground, if any is."""
    turning = [joint.links for joint in joints if not joint.prismatic]
    return drive.link if drive else next((name for name in links if {name, GROUND} in turning), None)


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
        drive, guess = _value(data, "drive"), _value(data, "guess")
        drives = filter(None, (_valid(kind, drive) for kind in DRIVES if drive is not None))
        parts = [_parts(_value(data, key), *kinds) for key, kinds in _RECORDS.items()]
        guessed = tuple(guess) if isinstance(guess, Mapping) else ()
        return cls(*parts[:2], next(drives, None), *parts[2:], guessed)

    @cached_property
    def names(self) -> list[str]:
        """Names of the links that can be names, of invalid links too."""
        return [name for name, _ in self.links if isinstance(name, str) and name != GROUND]

    def problems(self) -> list[Problem]:
        """List everything wrong between the parts; keys are relative to the mechanism."""
        problems = [p for key in _RECORDS for p in _duplicates(key, getattr(self, key))]
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
        return [*found, *self._thinner_than_pins(joints)]

    def _too_wide(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        links = [link for _, link in self.links if link is not None]
        for i, joint in enumerate(joints):
            if text := too_wide(joint.clearance, links):
                yield Problem(f"joints[{i}].clearance", joint.clearance, text)

    def _thinner_than_pins(self, joints: Sequence[Joint]) -> Iterator[Problem]:
        """Links whose shape has no room for the pin, or its hole, of a joint."""
        thickest = {}
        for j, joint in enumerate(joints):
            for name in joint.links if joint.radius else ():
                thickest[name] = max(thickest.get(name, (0.0, j)), (joint.radius, j))
        for i, (name, link) in enumerate(self.links):
            if not (link and link.shape and name in thickest):
                continue
            (key, across), (radius, j) = link.shape.across, thickest[name]
            size = key.partition(".")[2]
            if across <= 2 * radius and radius > link.length:  # then the pin is meant otherwise
                meant = in_millimetres(radius) if 2 * radius / 1000 < across else ""
                text = f"a radius less than {across / 2:g} m is accepted, half the {size} of {name}{meant}"
                yield Problem(f"joints[{j}].radius", radius, text)
            elif across <= 2 * radius:
                text = f"a {size} greater than {2 * radius:g} m is accepted"
                less = f"with {across:g} m a radius of joint {joints[j].name} less than {across / 2:g} m"
                yield Problem(f"links[{i}].shape.{key}", across, f"{text}: {less}")

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
        return strangers(((f"guess.{name}", name) for name in self.guess), known, "link or prismatic joint")

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
        loop = FourBar.of(joints, driven_link(self.drive, self.names, joints))
        if loop is not None and not loop.closes:
            rule = "none 0 and the longest shorter than the other three together"
            text = f"distances between pins (m) that can close are accepted: {rule}"
            yield Problem("links", loop.lengths, text)


_RECORDS = {
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


def _value(part: Any, key: str) -> Any:
    """A value of a record, or of a table that is to be one; None where it has none."""
    return part.get(key) if isinstance(part, Mapping) else getattr(part, key, None)


def _parts(given: Any, *kinds: type[Record]) -> list[tuple[Any, Any]]:
    parts = given if isinstance(given, list | tuple) and len(given) <= MOST else ()
    names = (_value(part, "name") for part in parts)
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
