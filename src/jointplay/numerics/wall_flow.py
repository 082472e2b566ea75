"""What happens at rigid walls, compiled only for structures that have some; the flow calls it by address."""

from . import walls
from .interface import SIGNATURES, entry, handed

at_wall = entry(SIGNATURES["at_wall"], handed)(walls.at_wall)
