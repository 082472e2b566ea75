"""Names of the quantities and parameters of derivatives, and their checks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from jointplay.analysis.gradients.multipliers import MULTIPLIERS
from jointplay.analysis.quantities import BALANCE, WORDS, WORK
from jointplay.display.errors import NOTHING, InputError, Problem, unknown
from jointplay.solver.mechanism.parameters import EXAMPLE, INITIAL, NAMED, Parameter
from jointplay.solver.mechanism.paths import parts_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem

POINTS = ("end", "largest", "smallest")
DISCRETE = ("mode", "contact_angle", *BALANCE, "energy", "state_value")


@dataclass(frozen=True)
class Quantity:
    """A number of a motion: ``end:angle:rocker``, ``largest:normal_force:B``, ``work:drive``, ``time``.

    Parameters
    ----------
    name : str
        As it was asked for.
    how : str
        Its first word.
    key : str
        Of what is looked at, as the equations call it; of a work, its name.
    units : str
        As in a dataset.
    """

    name: str
    how: str
    key: str
    units: str

    @property
    def noun(self) -> str:
        """What it is, as ``largest normal contact force, B`` or ``work of the drive``."""
        word, _, label = self.key.partition(":")
        if self.how not in POINTS:
            return " ".join(
                [self.how.replace("_", " "), *["of the"] * (self.how == "work"), self.key]
            ).strip()
        what = WORDS[word].long_name if word in WORDS else "state"
        what = f"{what} at the end" if self.how == "end" else f"{self.how} {what}"
        return f"{what}, {label}" if label else what


def quantity(name: str) -> Quantity:
    """The quantity of this name, which is a right one."""
    how, _, key = name.partition(":")
    units = {"time": "s", "work": "J"} | MULTIPLIERS
    word = WORDS.get(key.partition(":")[0])
    return Quantity(name, how, key, units.get(how) or (word.units if word else "1"))


def known_quantities(mechanism: Mechanism | TestSystem, orbit: bool = False) -> list[str]:
    """Names of all quantities of a mechanism, and of the multipliers of a periodic orbit."""
    from jointplay.analysis.starts import crank_place, state_names
    from jointplay.solver.mechanism.assemble import assemble

    model = assemble(mechanism)
    states = state_names(model)
    fixed = (isinstance(mechanism, TestSystem) and mechanism.period is None) or crank_place(model) is not None
    numbers = range(1, 1 + len(states) - fixed) if orbit else ()
    of_orbit = [f"{word}:{number}" for word in MULTIPLIERS for number in numbers]
    if isinstance(mechanism, TestSystem):
        keys = [f"state:{name}" for name in states]
        return [f"{how}:{key}" for how in POINTS for key in keys] + ["time", *of_orbit]
    links = [link.name for link in mechanism.links]
    labels = {
        None: ("",),
        "link": links,
        "bending": [link.name for link in mechanism.elastic_links],
        "joint": mechanism.contacts,
        "pin": [joint.name for joint in mechanism.joints if joint.ideal],
        "guide": mechanism.guides,
        "guided": [joint.name for joint in mechanism.joints if joint.ideal and joint.prismatic],
    }
    words = [name for name in WORDS if name not in DISCRETE]
    keys = [f"{name}:{label}".rstrip(":") for name in words for label in labels[WORDS[name].of]]
    works = [word for word, there in _works(mechanism).items() if there]
    return [f"{how}:{key}" for how in POINTS for key in keys] + [
        "time",
        *(f"work:{word}" for word in works),
        *of_orbit,
    ]


def _works(mechanism: Mechanism) -> dict[str, bool]:
    """Names of all works, and whether the mechanism has each."""
    parts = {"links": mechanism.elastic_links, "springs": mechanism.springs, "loads": mechanism.loads}
    return {word: bool(parts.get(word, True)) for word in WORK}


def _rigid(joint) -> bool:
    from jointplay.solver.equations.laws import LAWS

    return LAWS[joint.contact.law].rigid


def usual_quantities(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Quantities that are differentiated by default."""
    if isinstance(mechanism, TestSystem):
        return tuple(name for name in known_quantities(mechanism) if name.startswith("end:"))
    soft = [name for joint in mechanism.clearance_joints if not _rigid(joint) for name in joint.contacts]
    return (*(f"largest:normal_force:{name}" for name in soft), "work:drive", "time")


def largest_forces(mechanism: Mechanism | TestSystem) -> dict[str, str]:
    """Quantities of the largest force by joint, those that bear on their contacts first."""
    names = () if isinstance(mechanism, TestSystem) else known_quantities(mechanism)
    heads = ("largest:normal_force:", "largest:reaction:")
    rigid = {} if not names else {n for j in mechanism.clearance_joints if _rigid(j) for n in j.contacts}
    found = {n.rpartition(":")[2]: n for head in heads for n in names if n.startswith(head)}
    return {joint: name for joint, name in found.items() if joint not in rigid}


def usual_parameters(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Default parameters: joints' clearances and contacts, friction, links' masses, the drive."""
    if isinstance(mechanism, TestSystem):
        return tuple(each.key for each in Parameter.of(mechanism))
    keys = []
    for joint in mechanism.clearance_joints:
        keys += [f"joints.{joint.name}.clearance"]
        keys += [f"joints.{joint.name}.contact.{word}" for word in ("stiffness", "damping")]
        keys += [f"joints.{joint.name}.friction.coefficient"]
    keys += [f"links.{link.name}.mass" for link in mechanism.links] + ["gear_ratio", "speed"]
    return tuple(key for key in keys if Parameter(mechanism, key).value)


def quantities_fit(
    mechanism: Mechanism | TestSystem, of: tuple[str, ...] | None, orbit: bool
) -> Iterator[Problem]:
    """Yield the problems of quantities that the mechanism has not."""
    known = known_quantities(mechanism, orbit) if of else ()
    for i, name in enumerate(of or ()):
        if name not in known:
            yield unknown(f"of[{i}]", name, name, known, "quantity")


def parameters_fit(
    mechanism: Mechanism | TestSystem, by: tuple[str, ...] | None, states: tuple[str, ...]
) -> Iterator[Problem]:
    """Yield the problems of parameters that the mechanism has not, or whose value is no number."""
    for i, key in enumerate(by or ()):
        place = f"by[{i}]"
        if key.startswith(INITIAL):
            name = key.removeprefix(INITIAL)
            if name not in states:
                yield unknown(place, key, name, states, "state")
            continue
        wrong = [problem for part in parts_of(key) for problem in _part_fits(mechanism, part, place)]
        yield from wrong
        if not wrong and not Parameter(mechanism, key).uniform:
            yield Problem(
                place,
                key,
                f"a parameter that has a single value here, or a path such as {EXAMPLE}, is accepted",
            )


def _part_fits(mechanism: Mechanism | TestSystem, key: str, place: str) -> Iterator[Problem]:
    try:
        parameter = Parameter.named(mechanism, key, place)
    except InputError as error:
        yield from (replace(problem, given=key) for problem in error.problems)
        return
    if not parameter.smooth:
        also = f", one of {', '.join(NAMED)} or a path," if isinstance(mechanism, Mechanism) else ""
        given = NOTHING if parameter.value is None else parameter.value
        yield Problem(place, key, f"a parameter that has a value here{also} is accepted, not {given!r}")
