"""What is simulated: a linkage, `Mechanism`, in SI units, or a small known system, `TestSystem`.

All are validated and frozen; every record of the package can be imported from here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from jointplay.accepted import from_pydantic
from jointplay.equations.laws import LAWS
from jointplay.errors import InputError, unknown
from jointplay.mechanism.base import GROUND, Name, Number, Record, Several, measured
from jointplay.mechanism.beam import Beam, Link
from jointplay.mechanism.changes import MAIN_JOINT, Changes, changed
from jointplay.mechanism.drive import ConstantSpeed, Drive, MotorLine
from jointplay.mechanism.joints import Contact, Friction, Joint, Pin
from jointplay.mechanism.section import (
    ContactSection,
    CrankAngle,
    Plane,
    Section,
    SeparationSection,
)
from jointplay.mechanism.signature import checked
from jointplay.mechanism.structure import Draft, first_on_ground, problems
from jointplay.mechanism.systems import TestSystem

__all__ = [
    "GROUND",
    "MAIN_JOINT",
    "Beam",
    "Changes",
    "ConstantSpeed",
    "Contact",
    "ContactSection",
    "CrankAngle",
    "Drive",
    "Friction",
    "Joint",
    "Link",
    "Mechanism",
    "MotorLine",
    "Pin",
    "Plane",
    "Section",
    "SeparationSection",
    "TestSystem",
]


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
    gravity : float
        Acceleration along −y, m/s².
    branch : {'upper', 'lower'}
        Which way a four-bar is assembled: with the joint between coupler and rocker above or below
        (`jointplay.mechanism.closure.ideal_state` says exactly).
    order : {'consistent', 'paper'}
        Inertia terms of elastic links: all to second order in the deflection, or those of Chunmei et al.
        (2002), equations (3) to (12); unused while every link is rigid.
    """

    name: Name = "linkage"
    links: Several[Link] = Field(json_schema_extra={"accepts": "a list of at least one link"})
    joints: Several[Joint] = Field(json_schema_extra={"accepts": "a list of at least one joint"})
    drive: Annotated[Drive | None, Field()] = None
    gravity: Number = measured("gravity", "m/s²", 9.8)
    branch: Literal["upper", "lower"] = "upper"
    order: Literal["consistent", "paper"] = "consistent"

    @model_validator(mode="wrap")
    @classmethod
    def _every_problem_at_once(cls, data: Any, build: Callable[[Any], Self]) -> Self:
        # pydantic alone would look at how the parts fit only once each of them is right.
        record, found, more = None, [], 0
        try:
            record = build(data)
        except ValidationError as error:
            told = from_pydantic(error, cls)
            found, more = told.problems, told.more
        found += problems(Draft.of(data if record is None else record))
        if found or record is None:
            raise InputError(found, more=more)
        return record

    @property
    def clearance_joints(self) -> tuple[Joint, ...]:
        """The joints with clearance, in order."""
        return tuple(joint for joint in self.joints if joint.clearance > 0)

    @property
    def elastic_links(self) -> tuple[Link, ...]:
        """The links that bend, in order."""
        return tuple(link for link in self.links if link.elastic)

    @property
    def crank(self) -> str | None:
        """Name of the driven link; without a drive, of the first link that is pinned to the ground."""
        return (
            self.drive.link
            if self.drive
            else first_on_ground([link.name for link in self.links], self.joints)
        )

    def link(self, name: str) -> Link:
        """Give the link of this name."""
        return self._part(self.links, name, "link")

    def joint(self, name: str) -> Joint:
        """Give the joint of this name."""
        return self._part(self.joints, name, "joint")

    @staticmethod
    def _part(parts: tuple[Any, ...], name: str, what: str) -> Any:
        named = {part.name: part for part in parts}
        if name not in named:
            raise InputError([unknown(what, name, name, named, what)])
        return named[name]

    @checked()
    def replace(self, **changes: Any) -> Mechanism:
        """Give a changed, validated copy.

        Parameters
        ----------
        **changes
            `clearance`, `gear_ratio`, `friction`, `tension`, `efficiency_in_slope`, `elastic`, `elements`,
            `damping_ratio`, `order`, `branch`, `gravity`, `drive`, `speed`: see `Changes`.

        Raises
        ------
        InputError
            Listing every change that does not exist, cannot have its value, or finds nothing to change.
        """
        return type(self)(**dict(self) | changed(self, changes))

    def summary(self) -> str:
        """Describe the mechanism in a few lines of text."""
        links = [
            f"  link {link.name}: {link.length:g} m, {link.mass:g} kg, {link.inertia:g} kg m²{_bending(link)}"
            for link in self.links
        ]
        joints = [f"  joint {j.name}: {j.journal.link} in {j.bearing.link}, {_play(j)}" for j in self.joints]
        order = f", {self.order} order" if self.elastic_links else ""
        last = f"  gravity {self.gravity:g} m/s², {self.branch} branch{order}"
        tail = [f"  drive: {_drive(self.drive)}", last]
        return "\n".join([self.name, *links, *joints, *tail])

    def __repr__(self) -> str:
        play = ", ".join(f"{j.name} {j.clearance:g} m" for j in self.clearance_joints) or "none"
        links = ", ".join(link.name for link in self.links)
        elastic = ", ".join(link.name for link in self.elastic_links)
        bends = f"; elastic: {elastic}" if elastic else ""
        return f"<Mechanism {self.name}: {links}{bends}; clearance: {play}; drive: {_drive(self.drive)}>"

    __str__ = __repr__


def _bending(link: Link) -> str:
    if not link.elastic:
        return ""
    beam = link.beam
    shapes = f"{beam.elements} elements, " if beam.elements else "sine shapes, "
    return f", elastic: {shapes}{beam.size} modes, damping {beam.damping_ratio:g}"


def _play(joint: Joint) -> str:
    if not joint.clearance or joint.contact is None:
        return "ideal"
    contact = joint.contact
    friction = f", friction {joint.friction.coefficient:g}" if joint.friction else ""
    tension = "" if contact.tension else ", no tension"
    units = (unit for _, unit in LAWS[contact.law].numbers.values())
    law = ", ".join(f"{value:g} {unit}" for value, unit in zip(contact.numbers.values(), units, strict=True))
    return f"clearance {joint.clearance:g} m, {law}{tension}{friction}"


def _drive(drive: MotorLine | ConstantSpeed | None) -> str:
    if drive is None:
        return "none"
    if isinstance(drive, MotorLine):
        ratio = f"motor, gear ratio {drive.gear_ratio:g}"
        return f"{ratio} on {drive.link}, no load at {drive.no_load_speed:.6g} rad/s"
    return f"{drive.link} at {drive.speed:g} rad/s"
