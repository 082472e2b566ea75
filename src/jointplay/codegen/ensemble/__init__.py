"""Source of the eight-lane kernels: a structure's equations, and the method's algebra and control."""

from ...equations.structure import Linkage, Oscillator

LAWS = ("kelvin_voigt",)  # with which it has been tried
FRICTION = (
    *("none", "coulomb", "tanh", "ramp", "ambrosio", "threlfall", "andersson", "brown_mcphee", "stribeck"),
)


def known(structure: Linkage | Oscillator) -> bool:
    """Whether eight can run at once: three rigid links that turn freely, the crank first, and one contact."""
    if isinstance(structure, Oscillator) or len(structure.joints) != 1 or len(structure.links) != 3:
        return False
    (joint,), crank = structure.joints, structure.links[0]
    free = structure.drive in ("none", "motor") and structure.driven == crank
    open_chains = not (structure.beams or structure.floats or structure.closures)
    plain = not structure.powers and structure.section in (None, f"angle:{crank}")
    plain = plain and not (structure.tilted or structure.springs or structure.loads)
    return joint.law in LAWS and joint.friction in FRICTION and free and open_chains and plain
