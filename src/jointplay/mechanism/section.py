"""Where a motion is cut to make a Poincaré section."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism.base import Name, Number, Record, measured, named

if TYPE_CHECKING:
    from jointplay.mechanism.records import Mechanism


class CrankAngle(Record):
    """Once a turn, where the driven link passes an angle.

    Parameters
    ----------
    angle : float
        rad, taken modulo 2π.
    """

    kind: Literal["crank_angle"] = "crank_angle"
    angle: Number = measured("crank angle", "rad", 0.0)


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


Section = Annotated[CrankAngle | ContactSection | SeparationSection | Plane, Field(discriminator="kind")]


def check_section(section: Section, mechanism: Mechanism) -> None:
    """Refuse a section that a mechanism cannot have.

    Raises
    ------
    InputError
        If it names a link or joint that the mechanism lacks, or needs clearance where there is none.
    """
    problems = []
    link, joint = getattr(section, "link", None), getattr(section, "joint", None)
    names = [each.name for each in mechanism.links]
    if link is not None and link not in names:
        problems.append(unknown("section.link", link, link, names, "link"))
    if joint is not None or section.kind in ("contact", "separation"):
        problems += _joint_problems(joint, mechanism)
    if problems:
        raise InputError(problems, "section")


def _joint_problems(joint: str | None, mechanism: Mechanism) -> list[Problem]:
    names = [each.name for each in mechanism.joints]
    loose = [each.name for each in mechanism.clearance_joints]
    if joint is not None and joint not in names:
        return [unknown("section.joint", joint, joint, names, "joint")]
    if joint in loose or (joint is None and loose):
        return []
    given = NOTHING if joint is None else joint
    state = (
        "every joint here is ideal (clearance 0)"
        if joint is None
        else f"joint {joint} is ideal (clearance 0)"
    )
    return [
        Problem(
            "section.joint",
            given,
            f"{state}; a joint with clearance is accepted: {', '.join(loose) or 'none'}",
        )
    ]
