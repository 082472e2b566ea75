"""From a structure to its equations."""

from collections.abc import Callable
from typing import Any

from . import linkage
from .own import own
from .structure import Linkage, Oscillator
from .system import System

WRITERS: dict[type, Callable[[Any], System]] = {Linkage: linkage.system, Oscillator: own.system}


def system(structure: Linkage | Oscillator) -> System:
    """Write the equations of a structure."""
    return WRITERS[type(structure)](structure)
