"""Source of the eight-lane kernels: a structure's equations, and the method's algebra and control."""

from ...equations.laws import LAWS
from ...equations.structure import Course, Linkage, Oscillator
from ...numerics.ensemble import CONTACTS, N
from ..cache import structure_module

FRICTION = (  # with which it has been tried: laws without a state of their own
    *("none", "coulomb", "tanh", "ramp", "ambrosio", "threlfall", "andersson", "brown_mcphee", "stribeck"),
)
DRIVES = ("none", "motor", "torque")


def known(structure: Linkage | Oscillator) -> bool:
    """Whether eight can run at once: rigid links that turn freely, the crank first, and bearings with play.

    Each law of contact that has a force is known, and up to three joints with play; springs, and loads and
    torques that stay the same. Ideal loops, corners of sliders, rigid bearings, bristles, elastic links,
    imposed speeds and what varies with time or an angle are not. Systems of somebody's own are known that
    have few states, phases, contacts, switches and jumps, and no switch that slides.
    """
    if isinstance(structure, Oscillator):
        return _few(structure)
    if not structure.joints or structure.closures:  # at a dead centre the motion has to end
        return False
    fit = _positions(structure) <= N and len(structure.joints) <= CONTACTS
    bearings = all(
        not LAWS[joint.law].rigid and joint.corner is None and joint.friction in FRICTION
        for joint in structure.joints
    )
    free = structure.drive in DRIVES and structure.driven == structure.links[0]
    courses = [load.course for load in structure.loads] + [structure.course] * bool(structure.course)
    steady = not any(map(_varies, courses)) and not structure.powers
    section = structure.section in (None, f"angle:{structure.driven}")
    return fit and bearings and not structure.beams and free and steady and section


def _few(structure: Oscillator) -> bool:
    """Whether the states of a system with its phases, and all that touches or jumps, have room in a lane."""
    sizes = structure_module(structure).SIZES
    clock = int(not structure.period)
    fit = clock + sizes["angles"] + sizes["speeds"] <= N and sizes["contacts"] + sizes["resets"] <= CONTACTS
    slides = any(switch.slides for switch in structure.switches)
    return fit and not slides and structure.section in (None, "phase")


def _positions(structure: Linkage) -> int:
    free = [link for link in structure.links if link not in structure.dependent]
    return len(free) + 2 * len(structure.floating) + len(structure.slides)


def _varies(course: Course) -> bool:
    return bool(course.orders or course.timed)
