"""The changes that `Mechanism.replace` knows, and how each is made."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Protocol

from pydantic import Discriminator, Field, Tag

from jointplay.errors import InputError, Problem, unknown
from jointplay.mechanism.base import Flag, Name, NonNegative, Number, Positive, Record, measured
from jointplay.mechanism.beam import DampingRatio, Elements, Link, damping_field, elements_field
from jointplay.mechanism.drive import ConstantSpeed, Drive, MotorLine
from jointplay.mechanism.joints import Friction, Joint

# Whose clearance a bare number is: the joint between coupler and rocker of the catalog's linkages.
MAIN_JOINT = "B"


def _form(value: Any) -> str:
    return "joints" if isinstance(value, Mapping) else "number"


_Clearance = Annotated[
    Annotated[NonNegative, Tag("number")] | Annotated[dict[Name, NonNegative], Tag("joints")],
    Discriminator(_form),
]


class Changes(Record):
    """Changes to a mechanism; what is left out stays as it is.

    Parameters
    ----------
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's; a dict names several. 0 or unnamed: ideal.
    gear_ratio : float
        Of the motor's gear.
    friction : float
        Coulomb's coefficient in every joint that has contact data; 0 removes friction.
    tension : bool
        Whether contact may pull just before separation, in every joint that has contact data.
    efficiency_in_slope : bool
        Whether the gear's efficiency multiplies the slope of the motor line too.
    elastic : tuple of str
        Names of the links that bend; all others become rigid.
    elements : int
        Number of Hermite elements, 1 to 20, of every elastic link, in place of other shapes.
    damping_ratio : float
        Structural damping, 0 to 1, of every elastic link.
    order : {'consistent', 'paper'}
        Inertia terms of elastic links.
    branch : {'upper', 'lower'}
        Assembly branch.
    gravity : float
        Downward acceleration, m/s².
    drive : MotorLine, ConstantSpeed or None
        Another drive, or none.
    speed : float
        A constant speed of the driven link instead of the drive, rad/s.
    """

    root: ClassVar[str | None] = ""
    clearance: _Clearance = measured("radial clearance", "m", 0.0)
    gear_ratio: Positive = measured("gear ratio", "1", 1.0)
    friction: NonNegative = measured("friction coefficient", "1", 0.0)
    tension: Flag = True
    efficiency_in_slope: Flag = False
    elastic: tuple[Name, ...] = Field(
        (), json_schema_extra={"accepts": "a list of link names, as ['coupler'],"}
    )
    elements: Elements = elements_field(2)
    damping_ratio: DampingRatio = damping_field()
    order: Literal["consistent", "paper"] = "consistent"
    branch: Literal["upper", "lower"] = "upper"
    gravity: Number = measured("gravity", "m/s²", 9.8)
    drive: Annotated[Drive | None, Field()] = None
    speed: Number = measured("speed", "rad/s", 0.0)


class _Linkage(Protocol):
    """What is changed: a `Mechanism`."""

    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    drive: MotorLine | ConstantSpeed | None
    crank: str | None


def changed(mechanism: _Linkage, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Give the fields that the changes make other ones.

    Parameters
    ----------
    mechanism : Mechanism
        What the changes start from.
    changes : mapping of str to object
        Names and values as in `Changes`.

    Returns
    -------
    dict of str to object
        Fields of the new `Mechanism` that may differ from those of the old one.

    Raises
    ------
    InputError
        Listing every change that does not exist, cannot have its value, or finds nothing to change.
    """
    told, problems = _told(changes)
    problems += _misfits(mechanism, told)
    if "elastic" in told or "elastic" not in changes:
        problems += _elastic_misfits(mechanism, told)
    if problems:
        raise InputError(problems)
    fields = {name: told[name] for name in ("branch", "gravity", "order") if name in told}
    fields["links"] = tuple(_link(link, told) for link in mechanism.links)
    fields["joints"] = tuple(_joint(joint, told) for joint in mechanism.joints)
    fields["drive"] = _drive(mechanism, told)
    return fields


def _told(changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Split the changes into values that are right in themselves, and problems."""
    try:
        record, problems = Changes(**changes), []
    except InputError as error:
        if error.more:  # too many to tell the others apart
            raise
        wrong = {re.split(r"[.\[]", problem.key)[0] for problem in error.problems}
        record, problems = (
            Changes(**{k: v for k, v in changes.items() if k not in wrong}),
            list(error.problems),
        )
    told = {name: getattr(record, name) for name in record.model_fields_set}
    if isinstance(told.get("clearance"), float):
        told["clearance"] = {MAIN_JOINT: told["clearance"]}
    return told, problems


def _misfits(mechanism: _Linkage, told: Mapping[str, Any]) -> list[Problem]:
    return [
        *_clearance_misfits(mechanism, told),
        *_contact_misfits(mechanism, told),
        *_drive_misfits(mechanism, told),
    ]


def _clearance_misfits(mechanism: _Linkage, told: Mapping[str, Any]) -> list[Problem]:
    joints = {joint.name: joint for joint in mechanism.joints}
    found = []
    for name, value in told.get("clearance", {}).items():
        key = f"clearance.{name}"
        if name not in joints:
            found.append(unknown(key, value, name, joints, "joint"))
        elif value and (joints[name].contact is None or joints[name].radius is None):
            found.append(
                Problem(key, value, "only 0 is accepted for a joint without a radius and contact data")
            )
    return found


def _contact_misfits(mechanism: _Linkage, told: Mapping[str, Any]) -> list[Problem]:
    given = [name for name in ("friction", "tension") if name in told]
    if any(joint.contact for joint in mechanism.joints):
        return []
    return [
        Problem(n, told[n], "accepted only where a joint has contact data, and no joint here has")
        for n in given
    ]


def _elastic_misfits(mechanism: _Linkage, told: Mapping[str, Any]) -> list[Problem]:
    names = [link.name for link in mechanism.links]
    given = enumerate(told.get("elastic", ()))
    strange = [unknown(f"elastic[{i}]", name, name, names, "link") for i, name in given if name not in names]
    if strange:
        return strange  # what else fits depends on which links they should name
    if any(_bends(link, told) for link in mechanism.links):
        return []
    why = "accepted only where a link is elastic, and none is: name some, as elastic = ['coupler']"
    return [Problem(name, told[name], why) for name in ("elements", "damping_ratio", "order") if name in told]


def _drive_misfits(mechanism: _Linkage, told: Mapping[str, Any]) -> list[Problem]:
    found = []
    if "speed" in told and "drive" in told:
        found.append(Problem("speed", told["speed"], "either speed or drive is accepted, not both"))
    if "speed" in told and not told["speed"]:
        found.append(Problem("speed", told["speed"], "a finite speed in rad/s other than 0 is accepted"))
    motor = isinstance(told.get("drive", mechanism.drive), MotorLine) and "speed" not in told
    for name in ("gear_ratio", "efficiency_in_slope"):
        if name in told and not motor:
            found.append(Problem(name, told[name], "accepted only for a motor drive, and this drive is none"))
    return found


def _bends(link: Link, told: Mapping[str, Any]) -> bool:
    return link.name in told["elastic"] if "elastic" in told else link.elastic


def _link(link: Link, told: Mapping[str, Any]) -> Link | dict[str, Any]:
    """Give a link, or the table of a changed one: the mechanism checks it again and knows its place."""
    new: dict[str, Any] = {"elastic": _bends(link, told)}
    beam = {name: told[name] for name in ("elements", "damping_ratio") if new["elastic"] and name in told}
    if "elements" in beam:
        beam["shapes"] = "hermite"
    if new["elastic"] == link.elastic and not beam:
        return link
    table = link.model_dump()
    return table | new | {"beam": table["beam"] | beam}


def _joint(joint: Joint, told: Mapping[str, Any]) -> Joint:
    new: dict[str, Any] = {}
    if "clearance" in told:
        new["clearance"] = told["clearance"].get(joint.name, 0.0)
    if joint.contact and "tension" in told:
        new["contact"] = joint.contact.model_copy(update={"tension": told["tension"]})
    if joint.contact and "friction" in told:
        old = joint.friction.model_dump() if joint.friction else {}
        new["friction"] = Friction(**old | {"coefficient": told["friction"]}) if told["friction"] else None
    return joint.model_copy(update=new)


def _drive(mechanism: _Linkage, told: Mapping[str, Any]) -> MotorLine | ConstantSpeed | None:
    if "speed" in told:
        return ConstantSpeed(link=mechanism.crank, speed=told["speed"])
    drive = told.get("drive", mechanism.drive)
    line = {name: told[name] for name in ("gear_ratio", "efficiency_in_slope") if name in told}
    return drive.model_copy(update=line) if drive and line else drive
