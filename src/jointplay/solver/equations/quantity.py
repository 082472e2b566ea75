"""Numbers of a law of force, and the common description of laws of the normal force and of friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True)
class Quantity:
    """A number that a law takes.

    Parameters
    ----------
    letter : str
        How it is called in the equations: v for ``velocity``, else one that no other number of a joint has.
    units : str
        As ``m/s``; ``1`` also of what files of results have no unit for, such as N/m^n.
    usual : float, optional
        Its value where none is given; None: it is needed.
    least, most : float, optional
        Bounds that it may reach.
    above : float or str
        Without `least`: what it must exceed. With a name it must exceed 0, and the number of that name.
    or_equal : bool
        Whether it may also equal the number of that name.
    trial : float, optional
        A value with which the law is tried; the usual one if left out.
    """

    letter: str
    units: str
    usual: float | None = None
    least: float | None = None
    most: float | None = None
    above: float | str = 0.0
    or_equal: bool = False
    trial: float | None = None


@dataclass(frozen=True, kw_only=True)
class ForceLaw:
    """Common base of laws of the normal force and of friction.

    Parameters
    ----------
    numbers : mapping of str to Quantity
        Its numbers by name, in the order in which its functions take them.
    formula : str
        The force in a line, for tables of the documentation.
    references : tuple of str, optional
        Keys of `study/references.toml`, or whole references as text; none: textbook matter. None: not stated.
    """

    numbers: Mapping[str, Quantity] = field(default_factory=lambda: MappingProxyType({}))
    formula: str = ""
    references: tuple[str, ...] | None = None

    @property
    def trial(self) -> dict[str, float | None]:
        """Numbers with which it is tried, by name."""
        return {n: each.usual if each.trial is None else each.trial for n, each in self.numbers.items()}
