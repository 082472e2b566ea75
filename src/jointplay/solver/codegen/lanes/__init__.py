"""Source of the eight-lane kernels: a structure's equations, and the method's algebra and control."""

from collections.abc import Iterator

from ...equations.laws import LAWS
from ...equations.structure import Linkage, Oscillator
from ...method.lanes import CONTACTS, FOLDS, N
from ..cache import structure_module

DRIVES = ("none", "motor", "speed", "torque")
EXCLUSIONS = {  # what does not go in lanes: a word for results, and what it is
    "no_clearance": "a linkage without clearance",
    "rigid_impacts": "impacts of rigid joints (`restitution`)",
    "bristles": "a law of friction with bristles",
    "falling_friction": "friction that falls with the sliding speed, and may excite vibrations",
    "imposed_motion": "a speed that is imposed and varies, or leaves no angle free",
    "driven_link": "a drive at another link than the first",
    "work": "works, which are integrated",
    "section": "a section other than at an angle of the driven link, or a phase",
    "loop_groups": "ideal loops that close by more than two links at a time",
    "sliding_switch": "a switch that slides",
    "bending_guard": "a guard or gap that is no polynomial of the state",
    "size": f"more than {N} positions (modes, phases), {CONTACTS} contacts and walls, or {FOLDS} ideal loops",
}


def exclusion(structure: Linkage | Oscillator) -> str:
    """The first of `EXCLUSIONS` that a structure has; empty where eight can run at once."""
    found = _oscillator(structure) if isinstance(structure, Oscillator) else _linkage(structure)
    return next((name for name, there in found if there), "")


def _linkage(structure: Linkage) -> Iterator[tuple[str, bool]]:
    joints, loops = structure.joints, structure.loops
    yield "no_clearance", not joints
    yield "rigid_impacts", any(LAWS[joint.law].rigid for joint in joints)
    yield "bristles", any(joint.bends for joint in joints)
    yield "falling_friction", any(joint.falls for joint in joints)
    turned = structure.drive != "speed" or any(link != structure.driven for link in _free(structure))
    yield "imposed_motion", structure.drive not in DRIVES or not turned  # angles tell a linkage (form)
    yield "driven_link", structure.driven != structure.links[0]
    yield "work", structure.powers
    yield "section", structure.section not in (None, f"angle:{structure.driven}")
    yield "loop_groups", any(len(loop) > 1 for loop in loops)
    yield "size", _positions(structure) > N or len(joints) > CONTACTS or len(loops) > FOLDS


def _oscillator(structure: Oscillator) -> Iterator[tuple[str, bool]]:
    yield "sliding_switch", any(switch.slides for switch in structure.switches)
    yield "section", structure.section not in (None, "phase")
    sizes = structure_module(structure).SIZES
    yield "bending_guard", sizes["bends"]
    positions = int(not structure.period) + sizes["angles"] + sizes["speeds"]
    yield "size", positions > N or sizes["contacts"] + sizes["resets"] > CONTACTS


def _free(structure: Linkage) -> list[str]:
    dependent = structure.dependent
    return [link for link in structure.links if link not in dependent]


def _positions(structure: Linkage) -> int:
    dependent = structure.dependent
    slides = [slide for slide in structure.slides if slide.freedom not in dependent]
    modes = sum(beam.modes + beam.axial for beam in structure.beams if not structure.relaxed)
    return len(_free(structure)) + 2 * len(structure.floating) + len(slides) + modes
