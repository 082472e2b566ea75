"""Links, the places on them, and the joints between them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from jointplay.errors import NOTHING, InputError, refuse
from jointplay.mechanism.base import (
    GROUND,
    Flag,
    Name,
    NonNegative,
    Number,
    Positive,
    Record,
    measured,
    named,
)
from jointplay.mechanism.beam import Beam, misfits

_POINT = {"accepts": "a point [x, y] on the ground, two finite numbers in m,"}


class Pin(Record):
    """A place where a joint sits: on a link, or fixed to the ground.

    Parameters
    ----------
    link : str
        Name of the link, or ``ground``.
    at : float
        Distance from the link's origin along the link, m.
    point : tuple of float, shape (2,)
        Coordinates x and y, m; on the ground only, and needed there.
    """

    link: Name = named("link name, or 'ground'")
    at: NonNegative = measured("distance along the link", "m", 0.0)
    point: Annotated[tuple[Number, Number] | None, Field(validate_default=True, json_schema_extra=_POINT)] = (
        None
    )

    @field_validator("at")
    @classmethod
    def _along_a_link(cls, at: float, info: ValidationInfo) -> float:
        if at and info.data.get("link") == GROUND:
            raise refuse(at, "a place on the ground is given by point = [x, y] in m, without at")
        return at

    @field_validator("point")
    @classmethod
    def _on_the_ground(cls, point: tuple[float, float] | None, info: ValidationInfo) -> Any:
        link = info.data.get("link")
        if link == GROUND and point is None:
            raise refuse(NOTHING, "a place on the ground needs point = [x, y] in m")
        if link not in (None, GROUND) and point is not None:
            raise refuse(
                point, "only link = 'ground' takes a point; on a link, at = distance from its origin in m"
            )
        return point


class Link(Record):
    """A link: a line with an origin, its pin at distance 0; rigid, or bending between its two ends.

    Parameters
    ----------
    name : str
        Name; ``ground`` is taken.
    length : float
        Length from the origin to the far end, m.
    mass : float
        Mass, kg.
    centre : float, optional
        Distance of the mass centre from the origin along the link, m; half the length if left out.
    inertia : float
        Moment of inertia about the origin, kg m²; greater than mass × centre², so that
        the moment about the mass centre is positive.
    elastic : bool
        Whether the link bends. Its pins then sit at its ends, 0 and length.
    beam : Beam
        How it bends; unused while the link is rigid.
    """

    name: Name = named("link name")
    length: Positive = measured("length", "m")
    mass: Positive = measured("mass", "kg")
    centre: Number = measured("distance of the mass centre", "m", None, validate_default=True)
    inertia: Positive = measured("moment of inertia about the link's origin", "kg m²")
    elastic: Flag = False
    beam: Beam = Beam()

    @field_validator("name")
    @classmethod
    def _not_the_ground(cls, name: str) -> str:
        if name == GROUND:
            raise refuse(name, "a name other than 'ground' is accepted: that one is the fixed frame")
        return name

    @field_validator("centre", mode="before")
    @classmethod
    def _halfway(cls, centre: Any, info: ValidationInfo) -> Any:
        return info.data.get("length", 0.0) / 2 if centre is None else centre

    @field_validator("inertia")
    @classmethod
    def _positive_definite(cls, inertia: float, info: ValidationInfo) -> float:
        if not {"length", "mass", "centre"} <= info.data.keys():
            return inertia  # one of them is wrong, and says so itself
        least = info.data["mass"] * info.data["centre"] * info.data["centre"]
        if inertia <= least:
            limit = f"greater than mass × centre² = {least:.6g} kg m²"
            raise refuse(inertia, f"a moment of inertia about the link's origin {limit} is accepted")
        return inertia

    @model_validator(mode="after")
    def _bends_as_a_beam_can(self) -> Self:
        if self.elastic and (found := misfits(self)):
            raise InputError(found)
        return self


class Contact(Record):
    """The law of the normal force in a joint with clearance: F_n = K u + C_n du/dt at a penetration u ≥ 0.

    Parameters
    ----------
    law : {'kelvin_voigt'}
        Name of the law.
    stiffness : float
        K, N/m.
    damping : float
        C_n, N s/m.
    tension : bool
        True: the force may pull just before separation, as the law reads. False: contact ends where the force
        reaches 0.
    """

    law: Literal["kelvin_voigt"] = "kelvin_voigt"
    stiffness: Positive = measured("contact stiffness", "N/m")
    damping: NonNegative = measured("contact damping", "N s/m")
    tension: Flag = True


class Friction(Record):
    """The law of the tangential force in a joint with clearance: Coulomb's, with true stick, or smoothed.

    ``tanh`` replaces sign(v_t) by tanh(v_t/v_0), as many multibody codes do: it never sticks, and creeps
    under load at a speed below v_0.

    Parameters
    ----------
    law : {'coulomb', 'tanh'}
        Name of the law.
    coefficient : float
        f, dimensionless.
    viscous : float
        C_t, N s/m.
    velocity : float, optional
        v_0, m/s; needed by ``tanh``, and only there.
    """

    law: Literal["coulomb", "tanh"] = "coulomb"
    coefficient: NonNegative = measured("friction coefficient", "1")
    viscous: NonNegative = measured("viscous friction", "N s/m", 0.0)
    velocity: Positive | None = measured("smoothing velocity", "m/s", None, validate_default=True)

    @field_validator("velocity")
    @classmethod
    def _of_a_smoothed_law(cls, velocity: float | None, info: ValidationInfo) -> float | None:
        smoothed = info.data.get("law") == "tanh"
        if smoothed and velocity is None:
            raise refuse(NOTHING, "friction law tanh needs a smoothing velocity greater than 0 m/s")
        if velocity is not None and info.data.get("law") == "coulomb":
            raise refuse(velocity, "a smoothing velocity is accepted with law = 'tanh' only")
        return velocity


class Joint(Record):
    """A revolute joint: a journal on one link in a bush on another.

    Parameters
    ----------
    name : str
        Name.
    journal, bush : Pin
        Where the journal and the bush sit.
    clearance : float
        Radial clearance e, m; 0 makes the joint ideal, and contact data then rest unused.
    radius : float, optional
        Radius R of the journal, m; needed with clearance.
    contact : Contact, optional
        Law of the normal force; needed with clearance.
    friction : Friction, optional
        Law of the tangential force; none if left out.
    """

    name: Name = named("joint name")
    journal: Pin
    bush: Pin
    clearance: NonNegative = measured("radial clearance", "m", 0.0)
    radius: Positive | None = measured("journal radius", "m", None, validate_default=True)
    contact: Annotated[Contact | None, Field(validate_default=True)] = None
    friction: Friction | None = None

    @field_validator("bush")
    @classmethod
    def _two_links(cls, bush: Pin, info: ValidationInfo) -> Pin:
        if "journal" in info.data and info.data["journal"].link == bush.link:
            raise refuse(bush.link, "a link other than the journal's is accepted", "link")
        return bush

    @field_validator("radius")
    @classmethod
    def _radius_with_clearance(cls, radius: float | None, info: ValidationInfo) -> float | None:
        if radius is None and info.data.get("clearance"):
            raise refuse(NOTHING, "a joint with clearance needs a journal radius greater than 0 m")
        return radius

    @field_validator("contact")
    @classmethod
    def _contact_with_clearance(cls, contact: Contact | None, info: ValidationInfo) -> Contact | None:
        if contact is None and info.data.get("clearance"):
            raise refuse(
                NOTHING,
                "a joint with clearance needs contact data: a table of stiffness (N/m), damping (N s/m)",
            )
        return contact
