"""Systems to simulate: a linkage, `Mechanism`, in SI units, or a small known system, `TestSystem`.

All are validated and frozen; every record of the package can be imported from here.
"""

# ruff: noqa: F401  records are offered here that nothing here uses

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from jointplay.display.accepted import from_pydantic
from jointplay.display.errors import InputError, unknown
from jointplay.display.units import measure
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism import plausible
from jointplay.solver.mechanism.base import (
    DOWNWARDS,
    GROUND,
    Few,
    Flag,
    Name,
    Number,
    Record,
    Several,
    Turn,
    hash_of,
    measured,
)
from jointplay.solver.mechanism.changes import MAIN_JOINT, Changes, changed, value_of
from jointplay.solver.mechanism.draft import Draft, driven_link
from jointplay.solver.mechanism.own.own import System
from jointplay.solver.mechanism.own.own_parts import Impact, Jump, Rubbing, Switch, Touch
from jointplay.solver.mechanism.own.systems import TestSystem
from jointplay.solver.mechanism.parts.beam import Beam, Link, PointMass
from jointplay.solver.mechanism.parts.courses import Harmonic
from jointplay.solver.mechanism.parts.drive import (
    ConstantSpeed,
    Drive,
    MotorLine,
    PrescribedTorque,
    Servo,
    SpeedCycle,
    SpeedProfile,
)
from jointplay.solver.mechanism.parts.joints import Contact, Friction, Joint, Pin
from jointplay.solver.mechanism.parts.loads import AnyLoad, Force, Torque
from jointplay.solver.mechanism.parts.springs import AnySpring, Spring, TorsionSpring
from jointplay.solver.mechanism.paths import as_counted, checked_paths, one_by_one, with_parts
from jointplay.solver.mechanism.section import ContactSection, CrankAngle, Plane, Section, SeparationSection
from jointplay.solver.mechanism.signature import checked


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
    branch: Literal["upper", "lower"] = "upper"
    order: Literal["consistent", "paper"] = "consistent"
    guess: dict[Name, Number] = Field(
        default={}, json_schema_extra={"accepts": "a table of angles by link, in rad,"}
    )
    as_meant: Flag = False

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        joints = data.get("joints")
        tables = (
            each if isinstance(each, Mapping) else dict(each) if isinstance(each, Joint) else {}
            for each in (joints if isinstance(joints, list | tuple) else ())
        )
        slides = [each.get("name") for each in tables if each.get("kind") == "prismatic"]
        guess = data.get("guess")
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
            `damping_ratio`, `order`, `branch`, `gravity`, `gravity_direction`, `springs`, `loads`, `drive`,
            `speed`: see `Changes`; then, by key path, parts: ``**{"joints.C.clearance": 1e-4}``.

        Raises
        ------
        InputError
            Listing every change that does not exist, cannot have its value, or finds nothing to change.
        """
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
        """Give the same mechanism without what its numbers follow from, so that each changes by itself.

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
        links = [f"  link {link.name}: {link.description}" for link in self.links]
        joints = [f"  joint {joint.name}: {joint.description}" for joint in self.joints]
        springs = [f"  spring {spring.name}: {spring.description}" for spring in self.springs]
        loads = [f"  load {load.name}: {load.description}" for load in self.loads]
        order = f", {self.order} order" if self.elastic_links else ""
        towards = measure(self.gravity_direction, "rad")
        towards = f" towards {towards}" if self.gravity_direction != DOWNWARDS else ""
        last = f"  gravity {measure(self.gravity, 'm/s2')}{towards}, {self.branch} branch{order}"
        return "\n".join([self.name, *links, *joints, *springs, *loads, f"  drive: {self._drive}", last])

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
