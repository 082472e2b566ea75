"""Laws of the normal force at a contact, each one object: a law that stands in `LAWS` can be used everywhere.

No SymPy here: what is written with arithmetic alone takes symbols as well as numbers.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Law:
    """A law of the normal force F_n over the penetration u and the normal speed v_n (positive outwards).

    It must be defined and smooth for u < 0 too, and for v_n of either sign: stages of a step lie beyond the
    surface, and where nothing touches the force is multiplied by 0, which makes no 0 of what is not finite.
    It must vanish with u and v_n, and push (F_n > 0) where u > 0 = v_n. Compiled equations are found by the
    law's name: a law from outside this package that changes needs another one.

    Parameters
    ----------
    force : callable
        F_n, and the energy that it stores, of u, v_n and the law's numbers in their order.
    slopes : callable
        Bounds of |dF_n/du| and |dF_n/dv_n| at u = v_n = 0, of the law's numbers: what rounding makes of a
        force near zero.
    numbers : mapping of str to tuple of str
        Letter and units of each number by its name: ``stiffness``, ``damping``, and what it has beside these.
    """

    force: Callable
    slopes: Callable
    numbers: Mapping[str, tuple[str, str]]
    rigid: bool = False

    @property
    def letters(self) -> tuple[str, ...]:
        """Letters of its numbers, in order."""
        return tuple(letter for letter, _ in self.numbers.values())

    @property
    def further(self) -> tuple[str, ...]:
        """Names of its numbers beside stiffness and damping."""
        return tuple(name for name in self.numbers if name not in ("stiffness", "damping"))


# Kelvin-Voigt, the law of Chunmei et al. (2002), equation (17): F_n = K u + C_n v_n, stored K u^2 / 2. F_n
# jumps by C_n v_n at entry and may pull just before separation. Valid for small penetration; the restitution
# that it gives does not depend on the impact speed.
LAWS = {
    "kelvin_voigt": Law(
        force=lambda u, v_n, K, C: (K * u + C * v_n, K * u**2 / 2),
        slopes=lambda K, C: (K, C),
        numbers={"stiffness": ("K", "N/m"), "damping": ("C", "N s/m")},
    ),
    "restitution": Law(
        force=None,
        slopes=None,
        numbers={"restitution": ("r", "1")},
        rigid=True,
    ),
}
