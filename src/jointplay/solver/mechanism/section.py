"""Poincaré sections: the events of a motion at which its state is recorded."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from jointplay.solver.mechanism.base import Name, Number, Record, Turn, accepts, measured, named


class CrankAngle(Record):
    """Once a turn, where the driven link passes an angle.

    Parameters
    ----------
    angle : float
        rad, at most a turn to either side.
    """

    kind: Literal["crank_angle"] = "crank_angle"
    angle: Turn = measured("crank angle", "rad", 0.0)


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
    CrankAngle | ContactSection | SeparationSection | Plane,
    Field(discriminator="kind"),
    accepts(_KINDS),
]
