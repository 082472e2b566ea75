"""What stands for numerics.wall_flow in structures without rigid walls. It is never called."""

from .interface import SIGNATURES, entry, handed


@entry(SIGNATURES["at_wall"], handed)
def at_wall(f, guard, at, k, x, o):
    """Do nothing."""
