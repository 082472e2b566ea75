"""Changes of a mechanism by keyword, as `Mechanism.replace` takes them.

Words are aliases of key paths (`paths_of`): a change puts its value at the ends of these. What a word does
beside is written in `_ends`: other joints become ideal, a friction or a drive begins to be.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import Discriminator, Field, Tag

from jointplay.display.errors import InputError, Problem, also_known, raise_any, strangers, unknown, with_keys
from jointplay.solver.mechanism.base import (
    DOWNWARDS,
    Branch,
    Few,
    Flag,
    Name,
    NonNegative,
    Number,
    Positive,
    Record,
    Turn,
    measured,
)
from jointplay.solver.mechanism.parts.beam import DampingRatio, Elements, damping_field, elements_field
from jointplay.solver.mechanism.parts.drive import ConstantSpeed, Drive, MotorLine
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.mechanism.parts.joints import Joint
from jointplay.solver.mechanism.parts.loads import AnyLoad, AnySpring
from jointplay.solver.mechanism.paths import at_paths, is_path, main_joint, part_at
from jointplay.solver.mechanism.plausible import too_wide
from jointplay.solver.mechanism.signature import first

_IN_JOINTS = {"friction": "friction.coefficient", "tension": "contact.tension"}
_NEED_BENDING = ("elements", "damping_ratio", "order")
_OF_MOTORS = ("gear_ratio", "efficiency_in_slope")
_IN_DRIVES = dict.fromkeys(_OF_MOTORS, MotorLine) | {"speed": ConstantSpeed}
_BENDS = "accepted only where a link is elastic, and none is: name some, as elastic = ['{link}']"
_NOWHERE = {  # what is accepted of a word that leads nowhere
    **dict.fromkeys(_IN_JOINTS, "accepted only where a joint has contact data, and no joint here has"),
    **dict.fromkeys(_NEED_BENDING, _BENDS),
    **dict.fromkeys(_OF_MOTORS, "accepted only for a motor drive, and {drive}"),
}
_LINKS = {"accepts": "a list of link names, as ['coupler'],"}
Clearance = Annotated[
    Annotated[NonNegative, Tag("number")] | Annotated[dict[Name, NonNegative], Tag("joints")],
    Discriminator(lambda value: "joints" if isinstance(value, Mapping) else "number"),
]


class Changes(Record):
    """Changes to a mechanism; a key left out stays as it is.

    Parameters
    ----------
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's, or of the only joint that can have one; a dict names
        several. 0 or unnamed: ideal; 0 alone: all.
    gear_ratio : float
        Of the motor's gear.
    friction : float
        Coefficient of friction in every joint that has contact data, of whichever law; 0 removes friction.
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
        Acceleration, m/s².
    gravity_direction : float
        Where it points to, rad.
    springs : tuple of Spring or TorsionSpring
        Springs, in place of those that there are.
    loads : tuple of Force or Torque
        Loads, in place of those that there are.
    drive : MotorLine, ConstantSpeed or None
        Another drive, or none.
    speed : float
        A constant speed of the driven link instead of the drive, rad/s.
    as_meant : bool
        Whether all numbers are as meant, however strange: nothing is doubted.
    """

    root: ClassVar[str | None] = ""
    clearance: Clearance = measured("radial clearance", "m", 0.0)
    gear_ratio: Positive = measured("gear ratio", "1", 1.0)
    friction: NonNegative = measured("friction coefficient", "1", 0.0)
    tension: Flag = True
    efficiency_in_slope: Flag = False
    elastic: tuple[Name, ...] = Field(default=(), json_schema_extra=_LINKS)
    elements: Elements = elements_field(2)
    damping_ratio: DampingRatio = damping_field()
    order: Literal["consistent", "paper"] = "consistent"
    branch: Branch = "upper"
    gravity: Number = measured("gravity", "m/s²", 9.8)
    gravity_direction: Turn = measured("direction of gravity", "rad", DOWNWARDS)
    springs: Few[AnySpring] = ()
    loads: Few[AnyLoad] = ()
    drive: Annotated[Drive | None, Field()] = None
    speed: Number = measured("speed", "rad/s", 0.0)
    as_meant: Flag = False


M = TypeVar("M", bound=Record)


def changed(mechanism: M, changes: Mapping[str, Any]) -> M:
    """Give a validated copy with changes by word.

    Parameters
    ----------
    mechanism : Mechanism
        What the changes start from.
    changes : mapping of str to object
        Names and values as in `Changes`.

    Raises
    ------
    InputError
        Listing every change that does not exist, cannot have its value, or finds nothing to change.
    """
    values, problems = _valid(mechanism, changes)
    begun = _begun(mechanism, values)
    problems += [*_clearance_problems(mechanism, values), *_friction_problems(mechanism, values)]
    names = [link.name for link in mechanism.links]
    problems += [*strangers(with_keys("elastic", values.get("elastic")), names, "link")]
    problems += _drive_problems(values)
    doubtful = _NEED_BENDING if any(first(problem.key) == "elastic" for problem in problems) else ()
    nowhere = [word for word in _NOWHERE if word not in doubtful and not paths_of(begun, word)]
    problems = [also_known(problem, without=nowhere) for problem in problems]
    kind = "speed" if "speed" in values else getattr(begun.drive, "kind", None)
    drive = f"this drive is of kind {kind!r}" if kind else "there is no drive"
    here = {"link": names[len(names) // 2], "drive": drive}
    problems += [Problem(w, values[w], _NOWHERE[w].format(**here)) for w in nowhere if w in values]
    raise_any(problems)
    return at_paths(mechanism, _ends(mechanism, begun, values))


def paths_of(mechanism: Any, word: str) -> tuple[str, ...]:
    """Key paths that a word stands for, if any; its present value is that at the first of them."""
    if word == "clearance":
        return (f"joints.{main_joint(mechanism)}.clearance",)
    if word in _IN_JOINTS:
        names = sorted((j.name for j in mechanism.joints if j.contact), key=main_joint(mechanism).__ne__)
        return tuple(f"joints.{name}.{_IN_JOINTS[word]}" for name in names)
    if word in _NEED_BENDING:
        bent = [link.name for link in mechanism.links if link.elastic]
        return (word,) if bent and word == "order" else tuple(f"links.{name}.beam.{word}" for name in bent)
    if word in _IN_DRIVES:  # a servo has another speed, that of its wanted angle
        return (f"drive.{word}",) if isinstance(mechanism.drive, _IN_DRIVES[word]) else ()
    return (word,)


def value_of(mechanism: Any, key: str) -> Any:
    """Present value of a word or a path, 0 of a friction that is not there; None where there is nothing."""
    first = (key,) if is_path(key) else paths_of(mechanism, key)[:1]
    found = part_at(mechanism, *first, "")[0] if first else None
    return 0.0 if found is None and key == "friction" else found


def _valid(mechanism: Any, changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Split the changes into values that are valid in themselves, and problems."""
    try:
        record, problems = Changes(**changes), []
    except InputError as error:
        if error.more:  # too many to tell the others apart
            raise
        problems = list(error.problems)
        invalid = {first(problem.key) for problem in problems}
        record = Changes(**{name: value for name, value in changes.items() if name not in invalid})
    values = {name: getattr(record, name) for name in record.model_fields_set}
    if isinstance(values.get("clearance"), float):
        values["clearance"] = {main_joint(mechanism): values["clearance"]} if values["clearance"] else {}
    return values, problems


def _clearance_problems(mechanism: Any, values: Mapping[str, Any]) -> Iterator[Problem]:
    joints = {joint.name: joint for joint in mechanism.joints}
    for name, value in values.get("clearance", {}).items():
        key = f"clearance.{name}"
        if name not in joints:
            yield unknown(key, value, name, joints, "joint")
        elif value and not joints[name].sized:
            sizes = "half_length, half_height" if joints[name].prismatic else "radius"
            expected = f"only 0 is accepted: joint {name} has no {sizes} and contact data{_others(joints)}"
            yield Problem(key, value, expected)
        elif text := too_wide(value, mechanism.links):
            yield Problem(key, value, text)


def _others(joints: Mapping[str, Any]) -> str:
    """Paths of the joints that can have clearance."""
    able = [f"joints.{name}.clearance" for name, joint in joints.items() if joint.sized]
    return f"; {', '.join(able)} can vary" if able else ""


def _friction_problems(mechanism: Any, values: Mapping[str, Any]) -> Iterator[Problem]:
    for joint in mechanism.joints if "friction" in values else ():
        try:
            _friction(joint, values["friction"])
        except InputError as error:
            whose = f"friction of joint {joint.name} then has"
            texts = (
                f"{whose} {p.key.rpartition('.')[2]} = {p.given}, but {p.expected}" for p in error.problems
            )
            yield from (Problem("friction", values["friction"], text) for text in texts)


def _drive_problems(values: Mapping[str, Any]) -> Iterator[Problem]:
    if "speed" in values and "drive" in values:
        yield Problem("speed", values["speed"], "either speed or drive is accepted, not both")
    if "speed" in values and not values["speed"]:
        yield Problem("speed", values["speed"], "a finite speed in rad/s other than 0 is accepted")


def _begun(mechanism: M, values: Mapping[str, Any]) -> M:
    """The mechanism, not checked, with the drive and the bending links of the changes: where words lead."""
    bent = values.get("elastic", [link.name for link in mechanism.links if link.elastic])
    links = tuple(link.model_copy(update={"elastic": link.name in bent}) for link in mechanism.links)
    drive = None if "speed" in values else values.get("drive", mechanism.drive)
    return mechanism.model_copy(update={"links": links, "drive": drive})


def _ends(mechanism: Any, begun: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of valid changes, by key path."""
    found: dict[str, Any] = {}
    if "elastic" in values:
        found |= {f"links.{link.name}.elastic": link.elastic for link in begun.links}
    if "elements" in values:
        found |= {f"links.{link.name}.beam.shapes": "hermite" for link in begun.links if link.elastic}
    if "clearance" in values:
        given = values["clearance"]
        found |= {f"joints.{joint.name}.clearance": given.get(joint.name, 0.0) for joint in mechanism.joints}
    if "friction" in values:
        rubbing = (joint for joint in mechanism.joints if joint.contact)
        found |= {f"joints.{joint.name}.friction": _friction(joint, values["friction"]) for joint in rubbing}
    if "speed" in values:
        found["drive"] = ConstantSpeed(link=mechanism.crank, speed=values["speed"])
    for word in values.keys() - {"elastic", "clearance", "friction", "speed"}:
        found |= dict.fromkeys(paths_of(begun, word), values[word])
    return found


def _friction(joint: Joint, coefficient: float) -> Friction | None:
    old = joint.friction.model_dump() if joint.friction else {}
    none = not coefficient and not (joint.contact and joint.contact.parts)  # these would give another
    return None if none else Friction(**old | {"coefficient": coefficient})
