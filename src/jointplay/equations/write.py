"""From a structure to its equations."""

from . import linkage, oscillators
from .structure import Linkage, Oscillator
from .system import System


def system(structure: Linkage | Oscillator) -> System:
    """Write the equations of a structure."""
    if isinstance(structure, Linkage):
        return linkage.system(structure)
    return oscillators.system(structure)
