"""Joints between links, their pins, and the law of contact in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from jointplay.display.accepted import units_of
from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, refuse, unknown
from jointplay.display.number_text import measure
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.equations.structure import CORNERS
from jointplay.solver.mechanism.base import (
    GROUND,
    Flag,
    Name,
    NonNegative,
    Number,
    PartName,
    Positive,
    Record,
    Turn,
    is_number,
    measured,
    named,
)
from jointplay.solver.mechanism.measures import in_si
from jointplay.solver.mechanism.parts.contact_data import ContactData, PinInBush
from jointplay.solver.mechanism.parts.fits import Fit, limits
from jointplay.solver.mechanism.parts.friction import FRICTIONLESS, Friction, checked_numbers, law_of, made_of

_POINT = {"units": "m", "accepts": "a point [x, y] on the ground, two finite numbers in m,"}
_Point = Annotated[tuple[Number, Number] | None, Field(validate_default=True, json_schema_extra=_POINT)]
_ANY_DIAMETER = 0.02  # m: of a joint whose own is wrong, to find out whether its fit exists
_BESIDE = ("stiffness", "damping")  # numbers of laws that are fields of their own


class Pin(Record):
    """One side of a joint: a point on a link, or fixed to the ground.

    Parameters
    ----------
    link : str
        Name of the link, or ``ground``.
    at : float
        Distance from the link's origin along the link, m.
    point : tuple of float, shape (2,)
        Coordinates x and y, m; on the ground only, and needed there.
    direction : float
        Of a prismatic joint's line, rad: from the link's line, on the ground from +x.
    """

    link: Name = named("link name, or 'ground'")
    at: NonNegative = measured("distance along the link", "m", 0.0)
    point: _Point = None
    direction: Turn = measured("direction of a line", "rad", 0.0)

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
            accepted = "only link = 'ground' takes a point; on a link, at = distance from its origin in m"
            raise refuse(point, accepted)
        return point


def on_a_link(pin: Pin) -> Pin:
    """Rule: the pin is on a moving link."""
    if pin.link == GROUND:
        raise refuse(GROUND, "a moving link is accepted", "link")
    return pin


class Joint(Record):
    """A joint between two links: revolute, a journal in a bearing, or prismatic, a slider on a guide.

    Parameters
    ----------
    name : str
        Name.
    kind : {'revolute', 'prismatic'}
        Prismatic: the journal's point moves along the bearing's line, and both lines stay parallel.
    journal : Pin
        Link that carries the journal (the pin), and where on it; of a prismatic joint, the slider.
    bearing : Pin
        Link that carries the bearing (the hole), or the ground, and where; of a prismatic joint, the guide.
    clearance : float
        Radial clearance e, of a prismatic joint that on either side, m; 0 makes the joint ideal, and contact
        data are then not used.
    radius : float, optional
        Radius R of the journal, m; needed with clearance by a revolute joint.
    fit : str, optional
        Fit of ISO 286 at twice the radius, as ``"H7/f7"``, in the place of a clearance: this is then half the
        difference of the diameters, in the middle between least and largest.
    half_length, half_height : float, optional
        Half sizes of a prismatic joint's slider along and across its line, about its point, m; needed with
        clearance. The guide's faces are the half height and the clearance away from its line on either side.
    contact : Contact, optional
        Law of the normal force; needed with clearance.
    friction : Friction, optional
        Law of the tangential force; none if left out.
    """

    name: PartName = named("joint name")
    kind: Literal["revolute", "prismatic"] = "revolute"
    journal: Pin
    bearing: Pin
    clearance: NonNegative = measured("radial clearance", "m", 0.0)
    radius: Positive | None = measured("journal radius", "m", None, validate_default=True)
    fit: Name | None = Field(default=None, json_schema_extra={"accepts": "a fit of ISO 286 such as 'H7/f7'"})
    half_length: Positive | None = measured("half length of a slider", "m", None, validate_default=True)
    half_height: Positive | None = measured("half height of a slider", "m", None, validate_default=True)
    contact: Annotated[Contact | None, Field(validate_default=True)] = None
    friction: Annotated[Friction | None, Field(validate_default=True)] = None

    @model_validator(mode="wrap")
    @classmethod
    def _of_a_fit(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping) or not isinstance(data.get("fit"), str):
            return handler(data)
        clearance, problems = _fitted(data)
        return made_of(cls, handler, {**data, "clearance": clearance}, problems)

    @field_validator("bearing")
    @classmethod
    def _two_links(cls, bearing: Pin, info: ValidationInfo) -> Pin:
        if "journal" in info.data and info.data["journal"].link == bearing.link:
            raise refuse(bearing.link, "a link other than the journal's is accepted", "link")
        return bearing

    @field_validator("journal", "bearing")
    @classmethod
    def _line(cls, pin: Pin, info: ValidationInfo) -> Pin:
        if pin.direction and info.data.get("kind") == "revolute":
            raise refuse(pin.direction, "a direction is accepted with kind = 'prismatic' only", "direction")
        return pin

    @field_validator("radius", "half_length", "half_height")
    @classmethod
    def _sizes_with_clearance(cls, size: float | None, info: ValidationInfo) -> float | None:
        kind = "revolute" if info.field_name == "radius" else "prismatic"
        own, word = info.data.get("kind") == kind, cls.model_fields[info.field_name].description
        if size is not None and "kind" in info.data and not own:
            raise refuse(size, f"a {word} is accepted with kind = '{kind}' only")
        if size is None and own and info.data.get("clearance"):
            raise refuse(NOTHING, f"a {kind} joint with clearance needs a {word} greater than 0 m")
        return size

    @field_validator("contact")
    @classmethod
    def _contact_with_clearance(cls, contact: Contact | None, info: ValidationInfo) -> Contact | None:
        if contact is None and info.data.get("clearance"):
            needed = (
                "contact data: a table of stiffness (N/m), damping (N s/m), or of another law and its numbers"
            )
            raise refuse(NOTHING, f"a joint with clearance needs {needed}")
        if contact and info.data.get("kind") == "prismatic" and "R" in LAWS[contact.law].joint:
            flat = "a law that needs no journal's radius is accepted at a guide, whose faces are flat"
            raise refuse(contact.law, flat, "law")
        return _resolved(contact, info.data) if contact and contact.parts else contact

    @field_validator("friction")
    @classmethod
    def _of_the_parts(cls, friction: Friction | None, info: ValidationInfo) -> Friction | None:
        contact = info.data.get("contact")
        derived = friction is None and contact is not None and contact.parts is not None
        return Friction(coefficient=contact.parts.friction.value) if derived else friction

    def _stated(self, changed: Mapping[str, Any] = {}) -> dict[str, Any]:
        """Fields but for those that follow from fit or parts; another clearance takes the place of a fit.

        Pin and bush in the place of numbers bring their friction too.
        """
        own, parts = dict(self), self.contact and self.contact.parts
        contact = changed.get("contact")
        fields = dict(contact) if isinstance(contact, Mapping | Contact) else {}
        brought = not parts and (fields.get("parts") or {"pin", "bush"} & fields.keys())
        if brought or (parts and self.friction == Friction(coefficient=parts.friction.value)):
            del own["friction"]
        if parts and not self.ideal:
            given = self.contact.given
            values = self.data.numbers(self.contact.law, given)
            own["contact"] = self.contact.with_numbers({k: x for k, x in given.items() if values.get(k) != x})
        alone = "clearance" not in changed or changed == {"clearance": self.clearance}
        if changed.get("fit", self.fit) and alone:
            del own["clearance"]
        elif self.fit:
            del own["fit"]
        return own

    def numbers_alone(self) -> Joint:
        """Give the same joint without its fit, and without its parts where it has clearance."""
        alone = {"fit": None}
        if self.contact and not self.ideal:
            alone["contact"] = self.contact.model_copy(update={"parts": None})
        return self.model_copy(update=alone)

    @property
    def limits(self) -> Fit | None:
        """Its fit, with least and largest clearance; None where its clearance is given by hand."""
        return limits(self.fit, 2 * self.radius) if self.fit else None

    @property
    def data(self) -> ContactData | None:
        """Contact data by pin and bush, with spread and source; None where they are not given."""
        parts = self.contact and self.contact.parts
        return ContactData(parts, self.radius, self.clearance) if parts and not self.ideal else None

    @property
    def sources(self) -> dict[str, str]:
        """Where each number of its contact comes from, and its friction."""
        own, contact = self._stated(), self.contact
        follow = self.data.numbers(contact.law, contact.given) if self.data else {}
        made = dict.fromkeys(follow, "from pin and bush") | dict.fromkeys(own["contact"].given, "given")
        places = {name: made.get(name, "default") for name in contact.numbers}
        rubs = "given" if self.friction else "left out"
        return places | {"friction": "from pin and bush" if "friction" not in own else rubs}

    @property
    def ideal(self) -> bool:
        """Whether it has no clearance."""
        return not self.clearance

    @property
    def prismatic(self) -> bool:
        """Whether it is a slider on a guide."""
        return self.kind == "prismatic"

    @property
    def sized(self) -> bool:
        """Whether it has all that it needs to be given clearance."""
        sizes = (self.half_length, self.half_height) if self.prismatic else (self.radius,)
        return self.contact is not None and None not in sizes

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of its contacts: its own, of a prismatic joint its corners', of an ideal one none."""
        if self.ideal:
            return ()
        return tuple(f"{self.name}_{corner}" for corner in CORNERS) if self.prismatic else (self.name,)

    @property
    def ends(self) -> tuple[tuple[Pin, Pin], tuple[Pin, Pin]]:
        """Each of its pins, and the pin on the other side."""
        return (self.journal, self.bearing), (self.bearing, self.journal)

    @property
    def links(self) -> set[str]:
        """Names of the links that it connects."""
        return {self.journal.link, self.bearing.link}

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters of the equations of a joint with clearance, by letter."""
        friction = (self.friction or FRICTIONLESS).parameters
        return {"e": self.clearance} | self._sizes | self.contact.coefficients | friction

    @property
    def _sizes(self) -> dict[str, float]:
        if not self.prismatic:
            return {"R": self.radius}
        pairs = (("d", self.bearing), ("j", self.journal))
        lines = {f"{word}c": math.cos(pin.direction) for word, pin in pairs}
        lines |= {f"{word}s": math.sin(pin.direction) for word, pin in pairs}
        return lines | {"ha": self.half_length, "hb": self.half_height}

    @property
    def deepest(self) -> float:
        """Penetration at which the law of the normal force ends, m; infinite if it holds at any."""
        law = LAWS[self.contact.law]
        if law.deepest is None:
            return math.inf
        return law.deepest(*(self.numbers[letter] for letter in law.arguments))

    @property
    def description(self) -> str:
        """The links that it connects, its clearance and laws, in a few words."""
        links = f"{self.journal.link} {'on' if self.prismatic else 'in'} {self.bearing.link}"
        if self.ideal or self.contact is None:
            return f"{links}, ideal{' guide' * self.prismatic}"
        friction = f", friction {self.friction.description}" if self.friction else ""
        fit = f" ({self.fit})" if self.fit else ""
        clearance = f"clearance {measure(self.clearance, 'm')}{fit}"
        return f"{links}, {clearance}, {self.contact.description}{friction}"


def _resolved(contact: Contact, joint: Mapping[str, Any]) -> Contact:
    """A contact with the numbers of its law that follow from its pin and bush, in a joint of these fields."""
    if joint.get("kind") == "prismatic":
        raise refuse("prismatic", "pin and bush are accepted with kind = 'revolute'", "parts")
    if not joint.get("clearance") or not joint.get("radius"):
        return contact
    data = ContactData(contact.parts, joint["radius"], joint["clearance"])
    data.check()
    made = contact.with_numbers(data.numbers(contact.law, contact.given) | contact.given)
    needed = (name for name, value in made.numbers.items() if value is None)
    text = f"needed beside pin and bush, of which it does not follow with law = {contact.law!r}"
    raise_any(Problem(place_of(name), NOTHING, f"a {name} is {text}") for name in needed)
    return made


def _fitted(given: Mapping[str, Any]) -> tuple[Any, list[Problem]]:
    """Clearance to build a joint with whose fit is given, and the problems of that."""
    own, radius = given.get("clearance"), _metres(given.get("radius"))
    size = 2 * radius if is_number(radius) and radius > 0 else _ANY_DIAMETER
    if given.get("kind", "revolute") != "revolute":
        problems = [Problem("fit", given["fit"], "a fit is accepted with kind = 'revolute' only")]
    else:
        try:
            found, problems = limits(given["fit"], size, "fit"), []
        except InputError as error:
            problems = [
                Problem("radius", given["radius"], each.expected) if each.key == "diameter" else each
                for each in error.problems
            ]
    if own is None:  # where none is known, any one lets what a joint with clearance needs tell so
        return 1.0 if problems else found.clearance, problems
    if not problems and is_number(clearance := _metres(own)) and clearance != found.clearance:
        each = f"{found}, on average {measure(found.clearance, 'm')} of radial clearance"
        problems = [Problem("clearance", own, f"either fit or clearance is accepted, not both: {each}")]
    return own, problems


def _metres(given: Any) -> Any:
    """A length in m; None where it is in another unit, of which its field tells."""
    try:
        return in_si(given, "m")
    except InputError:
        return None


def place_of(number: str) -> str:
    """Key of a law's number in the record."""
    return number if number in _BESIDE else f"parameters.{number}"


def _with_parts(schema: dict[str, Any]) -> None:
    """Let the JSON schema of a contact take the keys of a pin in its bush beside its own."""
    for name, field in PinInBush.model_fields.items():
        units = units_of(field)
        about = {"type": "number", "units": units} if units else {}
        schema["properties"].setdefault(name, about | {"title": name.capitalize()})
    schema["additionalProperties"] = False


_SOME = PinInBush(
    pin="steel", bush="steel", length=0.01
)  # in the place of a wrong one, so that others are told


ContactLaw = law_of(LAWS, "law")


class Contact(Record):
    """The law of the normal force in a joint with clearance, at a penetration u ≥ 0.

    Parameters
    ----------
    law : str
        Name of the law, one of `jointplay.solver.equations.laws.LAWS`: ``kelvin_voigt`` (F_n = K u + C_n
        du/dt), ``hertz``, ``hunt_crossley``, ``flores`` and others.
    stiffness : float, optional
        K, N/m; of a law with a power of u, N/m^n. Needed by laws that have it, and accepted there alone.
    damping : float, optional
        C_n, N s/m; needed by laws that have it, and accepted there alone.
    parameters : dict of str to float
        The law's further numbers by name, where it has any.
    tension : bool
        True: the force may pull just before separation, as the law reads. False: contact ends where the force
        reaches 0.
    parts : PinInBush, optional
        Pin and bush, of which the joint takes what is not given beside them: numbers of the law and friction.
        The law is then ``hunt_crossley`` if left out. In a study file its keys stand here: ``pin``, ``bush``,
        ``length`` and others.
    """

    model_config = ConfigDict(json_schema_extra=_with_parts)
    law: ContactLaw = "kelvin_voigt"
    stiffness: Positive | None = measured("contact stiffness", "N/m", None)
    damping: NonNegative | None = measured("contact damping", "N s/m", None)
    parameters: dict[Name, Number] = Field(default={})
    tension: Flag = True
    parts: PinInBush | None = None

    @model_validator(mode="wrap")
    @classmethod
    def _of_the_law(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping) or not isinstance(data.get("parameters", {}), Mapping):
            return handler(data)
        data, wrong = _with_their_parts(data)
        law, further = data.get("law", "kelvin_voigt"), data.get("parameters", {})
        given = {key: data.get(key) for key in _BESIDE} | {place_of(name): x for name, x in further.items()}
        values, problems = checked_numbers(law, LAWS, given, place=place_of, units=per_power(law, further))
        follow = data.get("parts") is not None  # in a joint
        problems = wrong + [problem for problem in problems if not (follow and problem.given is NOTHING)]
        own = {key: values.get(key) for key in _BESIDE}
        own["parameters"] = {name: values[place_of(name)] for name in further if place_of(name) in values}
        return made_of(cls, handler, {**data, **own}, problems)

    @property
    def given(self) -> dict[str, float]:
        """Numbers of the law by name that there are."""
        own = {"stiffness": self.stiffness, "damping": self.damping} | self.parameters
        return {name: value for name, value in own.items() if value is not None}

    def with_numbers(self, numbers: Mapping[str, float]) -> Contact:
        """The same with these numbers of its law, by name."""
        own = {key: numbers.get(key) for key in _BESIDE}
        further = {name: value for name, value in numbers.items() if name not in _BESIDE}
        return Contact(**dict(self) | own | {"parameters": further})

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the law by name, in its order."""
        return {name: self.given.get(name, each.usual) for name, each in LAWS[self.law].numbers.items()}

    @property
    def coefficients(self) -> dict[str, float]:
        """Coefficients of the law's equations, by letter."""
        law = LAWS[self.law]
        return dict(zip(law.letters, law.coefficients(*self.numbers.values()), strict=True))

    @property
    def description(self) -> str:
        """The law and its numbers, in a few words."""
        units = [each.units for each in LAWS[self.law].numbers.values()]
        numbers = [*self.numbers.items()]
        if self.law == "kelvin_voigt":
            texts = (measure(value, unit) for (_, value), unit in zip(numbers, units, strict=True))
        else:
            texts = (
                f"{name.replace('_', ' ')} {measure(value, unit)}"
                for (name, value), unit in zip(numbers, units, strict=True)
            )
            texts = (self.law.replace("_", " "), *texts)
        parts = f" ({self.parts.pin.name} in {self.parts.bush.name})" if self.parts else ""
        return ", ".join(texts) + parts + ("" if self.tension else ", no tension")

    def __hash__(self) -> int:
        return hash((self.law, *self.numbers.values(), self.tension))


def _with_their_parts(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Problem]]:
    """A contact's table with pin and bush in their own, and the problems of these."""
    given = {"pin", "bush"} & data.keys()
    flat = {key: value for key, value in data.items() if given and key in PinInBush.model_fields}
    problems = []
    if flat:
        known = [key for key in (*PinInBush.model_fields, *Contact.model_fields) if key != "parts"]
        problems = [unknown(str(key), x, key, known, "key") for key, x in data.items() if key not in known]
        data = {key: value for key, value in data.items() if key in known and key not in flat}
        try:
            data["parts"] = PinInBush(**flat)
        except InputError as error:
            problems, data["parts"] = problems + error.problems, _SOME
    if data.get("parts") is not None and data.get("law") is None:
        data = {**data, "law": "hunt_crossley"}
    return data, problems


def per_power(law: Any, further: Mapping[str, Any]) -> dict[str, str]:
    """Units of the stiffness of a law with a power of u, N/m^n."""
    numbers = LAWS[law].numbers if isinstance(law, str) and law in LAWS else {}
    power = further.get("exponent", numbers["exponent"].usual) if "exponent" in numbers else None
    return {"stiffness": f"N/m^{power:.4g}"} if is_number(power) else {}
