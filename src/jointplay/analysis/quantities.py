"""Catalogue of recorded variables: dimensions, units and long name of each."""

from collections.abc import Sequence
from dataclasses import dataclass

from jointplay.display.errors import Problem, raise_any, unknown
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.method.codes import Event, Mode, Status


@dataclass(frozen=True)
class Word:
    """A recorded quantity, with UDUNITS units and long name.

    `of` says over what: link, joint, pin, guide (a prismatic joint; in datasets along joint), state, bending
    (links where one bends, nothing else) or None.
    """

    of: str | None
    units: str
    long_name: str


WORDS = {
    "angle": Word("link", "rad", "link angle"),
    "angular_velocity": Word("link", "rad s-1", "link angular velocity"),
    "angular_acceleration": Word("link", "rad s-2", "link angular acceleration"),
    "journal_x": Word("joint", "m", "journal centre relative to the bearing, x"),
    "journal_y": Word("joint", "m", "journal centre relative to the bearing, y"),
    "eccentricity": Word("joint", "m", "distance of journal and bearing centres"),
    "eccentricity_ratio": Word("joint", "1", "eccentricity over clearance"),
    "penetration": Word("joint", "m", "eccentricity less clearance"),
    "normal_velocity": Word("joint", "m s-1", "normal velocity of the journal"),
    "tangential_velocity": Word("joint", "m s-1", "sliding velocity at the contact"),
    "contact_angle": Word("joint", "rad", "direction of the eccentricity"),
    "normal_force": Word("joint", "N", "normal contact force"),
    "tangential_force": Word("joint", "N", "tangential contact force"),
    "mode": Word("joint", "1", "contact mode"),
    "reaction_x": Word("pin", "N", "force on the bearing of an ideal joint, x"),
    "reaction_y": Word("pin", "N", "force on the bearing of an ideal joint, y"),
    "reaction": Word("pin", "N", "force at an ideal joint"),
    "reaction_moment": Word(
        "guided", "N m", "moment on the bearing of an ideal joint about the journal's point"
    ),
    "slide_position": Word("guide", "m", "distance of a slider along its guide"),
    "slide_velocity": Word("guide", "m s-1", "velocity of a slider along its guide"),
    "deflection": Word("bending", "m", "deflection of a link"),
    "drive_torque": Word(None, "N m", "drive torque"),
    "kinetic_energy": Word(None, "J", "kinetic energy"),
    "potential_energy": Word(None, "J", "potential energy of gravity, of bent links and of springs"),
    "strain_energy": Word(None, "J", "elastic energy of bent links and of springs"),
    "energy": Word(None, "J", "mechanical energy with the contacts' elastic energy"),
    "energy_residual": Word(None, "J", "energy unaccounted for since the start"),
    "drive_work": Word(None, "J", "work of the drive since the start"),
    "joint_work": Word(None, "J", "work taken in by the contacts since the start"),
    "structural_work": Word(None, "J", "work taken in by elastic links' damping since the start"),
    "spring_work": Word(None, "J", "work taken in by springs' dampers since the start"),
    "load_work": Word(None, "J", "work of the loads since the start"),
    "state_value": Word("state", "1", "state"),
}
MODES, EVENTS, STATUS = Mode.words(), Event.words(), Status.words()
WORK = {  # integrals of power by what they count, with the sign of their part in the balance
    "drive": ("drive_work", 1),
    "joints": ("joint_work", -1),
    "links": ("structural_work", -1),
    "springs": ("spring_work", -1),
    "loads": ("load_work", 1),
}
BALANCE = ("energy_residual", *(name for name, _ in WORK.values()))  # need integrals of power
ENERGIES = ("kinetic_energy", "potential_energy", "strain_energy", "energy")
LINKAGE = tuple(name for name in WORDS if name not in (*BALANCE, *ENERGIES, "state_value"))


def recorded(
    record: Sequence[str] | None,
    mechanism: Mechanism | TestSystem,
    key: str = "record",
    integrals: bool = True,
) -> tuple[str, ...]:
    """Names to record: the given ones, checked, or the usual ones that the mechanism has.

    Without `integrals`, integrals over time since the start are refused.

    Raises
    ------
    InputError
        Naming every unknown quantity, and every one that the mechanism cannot have.
    """
    linkage = isinstance(mechanism, Mechanism)
    known = tuple(name for name in WORDS if (name == "state_value") != linkage)
    absent = _absent(mechanism) if linkage else {}
    if record is None:
        return tuple(name for name in LINKAGE if WORDS[name].of not in absent) if linkage else known
    wrong = []
    for i, name in enumerate(record):
        if name not in known:
            wrong.append(unknown(f"{key}[{i}]", name, name, known, "quantity"))
        elif WORDS[name].of in absent:
            wrong.append(Problem(f"{key}[{i}]", name, f"accepted only where {absent[WORDS[name].of]}"))
        elif name in BALANCE and not integrals:
            expected = "a quantity of the state is accepted, no integral over time"
            wrong.append(Problem(f"{key}[{i}]", name, expected))
    raise_any(wrong)
    return tuple(dict.fromkeys(record))


def owners(mechanism: Mechanism) -> dict[str | None, Sequence[str]]:
    """Names of the parts that a quantity can be of, by their kind; one without a name: the mechanism."""
    ideal = [joint for joint in mechanism.joints if joint.ideal]
    return {
        None: ("",),
        "link": [link.name for link in mechanism.links],
        "bending": [link.name for link in mechanism.elastic_links],
        "joint": mechanism.contacts,
        "pin": [joint.name for joint in ideal],
        "guide": mechanism.guides,
        "guided": [joint.name for joint in ideal if joint.prismatic],
    }


def _absent(mechanism: Mechanism) -> dict[str, str]:
    """Kinds of part that the mechanism does not have, with the condition under which it would."""
    there = owners(mechanism)
    missing = {"joint": "a joint has clearance", "pin": "a joint is ideal (clearance 0)"}
    missing |= {"guide": "a joint is prismatic", "bending": "a link is elastic"}
    absent = {of: text for of, text in missing.items() if not there[of]}
    return absent | ({"guided": absent["guide"]} if "guide" in absent else {})
