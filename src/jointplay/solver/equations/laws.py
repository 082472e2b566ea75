"""Laws of the normal force at a contact, each one object: a law that stands in `LAWS` can be used everywhere.

No SymPy here: a law takes the functions that it needs beside arithmetic (those of equations.functions, or of
NumPy) as its first argument.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import exp

from ..extensions import Table
from . import cylinders
from .cylinders import ROUND
from .quantity import ForceLaw, Quantity


@dataclass(frozen=True, kw_only=True)
class Law(ForceLaw):
    """A law of the normal force F_n over the penetration u and the normal speed v_n (positive outwards).

    It must be defined and smooth for u < 0 too, and for v_n of either sign: stages of a step lie beyond the
    surface, and where nothing touches the force is multiplied by 0, which makes no 0 of what is not finite.
    It must vanish with u and v_n, and push (F_n > 0) where u > 0 = v_n. Compiled equations are found by the
    law's name: a law from outside this package that changes needs another one. A law that ends at a depth has
    no force beyond it, but what is not a number, and no step gets there.

    A law may remember the speed of approach v_0 with which a contact began, from a smallest one on: then v_0
    is the last argument of `force` and `push`. Its numbers are ``stiffness``, ``damping``, and what it has
    beside these.

    Parameters
    ----------
    force : callable
        F_n, and the energy that it stores, of the functions, u, v_n and the law's arguments in their order.
    slopes : callable
        Bounds of |dF_n/du| and |dF_n/dv_n| up to a penetration, of that and the arguments: what rounding
        makes of a force.
    push : callable, optional
        Of v_n and the arguments, what has the sign of F_n where u > 0, is smooth and linear in v_n: of a
        law whose force vanishes with u.
    coefficients : callable, optional
        What the equations take, of the numbers in their order; the same if left out.
    floor : str
        Letter of the number that is the smallest v_0, m/s; empty: the law remembers nothing.
    pulls : bool
        Whether the force can be negative at all.
    rigid : bool
        Whether it is a law of impacts, which has no force.
    joint : tuple of str
        Letters of the joint's own numbers that it takes: ``e``, its clearance, ``R``, its journal's radius.
    deepest : callable, optional
        Penetration at which the law ends, m, of the arguments; None: it holds at any.
    smooth : bool
        Whether F_n has no infinite curvature at u = 0 either, where contact begins and ends.
    """

    force: Callable | None
    slopes: Callable | None
    push: Callable | None = None
    coefficients: Callable = lambda *numbers: numbers
    floor: str = ""
    pulls: bool = True
    rigid: bool = False
    joint: tuple[str, ...] = ()
    deepest: Callable | None = None
    smooth: bool = False

    @property
    def letters(self) -> tuple[str, ...]:
        """Letters of its numbers, in order."""
        return tuple(each.letter for each in self.numbers.values())

    @property
    def arguments(self) -> tuple[str, ...]:
        """Letters of the arguments of its equations, in order: its coefficients, and numbers of the joint."""
        return self.letters + self.joint


# Kelvin-Voigt, the law of Chunmei et al. (2002), equation (17): F_n = K u + C_n v_n, stored K u^2 / 2. F_n
# jumps by C_n v_n at entry and may pull just before separation. Valid for small penetration; the restitution
# that it gives does not depend on the impact speed.
_kelvin_voigt = Law(
    force=lambda m, u, v_n, K, C: (K * u + C * v_n, K * u**2 / 2),
    slopes=lambda depth, K, C: (K, C),
    numbers={
        "stiffness": Quantity("K", "N/m", trial=1e7),
        "damping": Quantity("C", "N s/m", least=0.0, trial=200.0),
    },
    formula="K u + C_n v",
    references=("chunmei2002",),
    smooth=True,
)

# Power laws: F_n = K u^n (1 + chi v_n), stored K u^(n + 1) / (n + 1), n >= 1; n = 3/2 is that of Hertz for
# balls. F_n is continuous at entry, and pushes while 1 + chi v_n > 0. u^n is continued to u < 0 as an odd
# function and rounded off within ROUND of 0, so that its slope is finite and grows with |u| on both sides.


def _power(u, K, n):
    """K u^n, rounded off at u = 0, and its stored energy."""
    square = u**2 + ROUND**2
    return K * square ** ((n - 1) / 2) * u, K * square ** ((n + 1) / 2) / (n + 1)


def _damped(_, u, v_n, K, n, chi):
    spring, stored = _power(u, K, n)
    return spring * (1 + chi * v_n), stored


def _steepest(depth, K, n, chi):
    spring, _ = _power(depth + ROUND, K, n)
    return n * spring / (depth + ROUND), chi * spring


_POWER = {"stiffness": Quantity("K", "1", trial=2e9)}  # N/m^n, which files of results have no unit for
_EXPONENT = {"exponent": Quantity("n", "1", usual=1.5, least=1.0)}

# Hertz (1882): no damping, so a restitution of 1. Valid for elastic bodies whose contact is small beside
# their radii; a shaft in a bearing of nearly its own radius conforms more than that.
_hertz = Law(
    force=lambda m, u, v_n, K, n: _power(u, K, n),
    slopes=lambda depth, K, n: _steepest(depth, K, n, 0.0),
    numbers=_POWER | _EXPONENT,
    formula="K uⁿ",
    references=("hertz1882",),
    push=lambda v_n, K, n: 1,
    pulls=False,
)

# Hunt and Crossley (1975), with chi as a number of the material: restitution falls with the impact speed, as
# 1 - 2 chi v / 3 for slow impacts. Valid for chi v < 1.
_hunt_crossley = Law(
    force=_damped,
    slopes=_steepest,
    numbers=_POWER | _EXPONENT | {"dissipation": Quantity("chi", "s/m", least=0.0, trial=0.3)},
    formula="K uⁿ (1 + χ v)",
    references=("hunt_crossley1975",),
    push=lambda v_n, K, n, chi: 1 + chi * v_n,
)

# Laws with chi = d / v_0: a factor d, of the restitution e that is wanted, over the speed v_0 with which the
# contact began. The restitution that they give, whatever K, n and the mass, is the root e' of
#     d (1 + e') = ln[(1 + d) / (1 - d e')].
# Valid for impacts that end; in lasting contact v_0 is that of its beginning, however slow. Contacts that
# begin more slowly than `slowest` count as beginning with that speed: chi is bounded by d / slowest.
# Here each d(e), as it reads, and its reference.
FACTORS = {
    "hunt_crossley_restitution": (lambda e: 3 * (1 - e) / 2, "3 (1 − e)/2", "hunt_crossley1975"),
    "herbert_mcwhannell": (
        lambda e: 6 * (1 - e) / ((2 * e - 1) ** 2 + 3),
        "6 (1 − e)/((2e − 1)² + 3)",
        "herbert_mcwhannell1977",
    ),
    "lee_wang": (lambda e: 3 * (1 - e) / 4, "3 (1 − e)/4", "lee_wang1983"),
    "lankarani_nikravesh": (lambda e: 3 * (1 - e**2) / 4, "3 (1 − e²)/4", "lankarani_nikravesh1990"),
    "gonthier": (lambda e: (1 - e**2) / e, "(1 − e²)/e", "gonthier2004"),
    "zhiying_qishao": (
        lambda e: 3 * (1 - e**2) * exp(2 * (1 - e)) / 4,
        "3 (1 − e²) exp(2 (1 − e))/4",
        "zhiying_qishao2006",
    ),
    "flores": (lambda e: 8 * (1 - e) / (5 * e), "8 (1 − e)/(5 e)", "flores2011"),
    "hu_guo": (lambda e: 3 * (1 - e) / (2 * e), "3 (1 − e)/(2 e)", "hu_guo2015"),
}
_RESTITUTION = Quantity("dr", "1", least=0.0, most=1.0, trial=0.7)
_SLOWEST = {"slowest": Quantity("vmin", "m/s", usual=1e-3, trial=0.01)}


def _remembering(factor: Callable, formula: str, reference: str) -> Law:
    """A law whose damping depends on the speed at entry and the restitution wanted, by a factor d(e)."""
    try:
        factor(0.0)
        wanted = _RESTITUTION
    except ZeroDivisionError:
        wanted = replace(_RESTITUTION, least=None)
    return Law(
        force=lambda m, u, v_n, K, d, n, slowest, v_0: _damped(m, u, v_n, K, n, d / v_0),
        slopes=lambda depth, K, d, n, slowest: _steepest(depth, K, n, d / slowest),
        numbers=_POWER | {"restitution": wanted} | _EXPONENT | _SLOWEST,
        formula=f"K uⁿ (1 + d v/v₀), d = {formula}",
        references=(reference,),
        push=lambda v_n, K, d, n, slowest, v_0: 1 + d / v_0 * v_n,
        coefficients=lambda K, e, n, slowest: (K, factor(e), n, slowest),
        floor="vmin",
    )


# Cylinders in cylinders (equations.cylinders): published as springs, and joined with Lankarani and
# Nikravesh's damping, F_n = F(u) (1 + 3 (1 - e^2)/4 v/v_0), as Pereira, Ramalho and Ambrosio (2015) do; with
# a restitution e of 1 the spring alone. The restitution that this gives is that of the power laws, for it
# depends on d alone whatever the spring.
_MATERIALS = {"length": Quantity("Lc", "m", trial=0.02)}
for _side, _letter in (("journal", "j"), ("bearing", "b")):
    _MATERIALS |= {  # steel, if nothing else is said
        f"{_side}_modulus": Quantity(f"E{_letter}", "Pa", usual=2.07e11),
        f"{_side}_poisson_ratio": Quantity(f"nu{_letter}", "1", usual=0.3, above=-1.0, most=0.5),
    }


def _cylindrical(form: Callable, spring: Callable, bounds: Callable, reference: str) -> Law:
    """A law whose spring is that of a journal in its bearing, `form` giving the two numbers of the spring."""
    ends = spring is cylinders.logarithmic

    def of(L, E_j, nu_j, E_b, nu_b, d, slowest, e, R):
        return form(L, cylinders.modulus(E_j, nu_j, E_b, nu_b), R, e)

    def force(m, u, v_n, *given):
        *given, v_0 = given
        F, stored = spring(m, u, *of(*given))
        return F * (1 + given[5] / v_0 * v_n), stored

    def slopes(depth, *given):
        slope, most = bounds(depth, *of(*given))
        return slope, given[5] / given[6] * most

    return Law(
        force=force,
        slopes=slopes,
        numbers=_MATERIALS | {"restitution": replace(_RESTITUTION, usual=1.0)} | _SLOWEST,
        formula="F(u) (1 + d v/v₀): [a cylinder in a cylinder](#cylinders-in-cylinders)",
        references=(reference, "pereira2015"),
        push=lambda v_n, *given: 1 + given[5] / given[-1] * v_n,
        coefficients=lambda *n: (*n[:5], FACTORS["lankarani_nikravesh"][0](n[5]), n[6]),
        floor="vmin",
        joint=("e", "R"),
        deepest=(lambda *given: of(*given)[1]) if ends else None,
    )


# Rigid bodies (Newton, 1687): no force but an impulse, after which the gap opens e times as fast as it
# closed; rebounds that can no longer be told from rest end in lasting contact, held by the bearing. No
# friction. Valid where impacts are short beside all else that is of interest.
_restitution = Law(
    force=None,
    slopes=None,
    numbers={"restitution": replace(_RESTITUTION, letter="r")},
    formula="none: impacts",
    references=("leine_nijmeijer2004", "nordmark_piiroinen2009"),
    pulls=False,
    rigid=True,
    smooth=True,
)

_ROWS = {"kelvin_voigt": _kelvin_voigt, "hertz": _hertz, "hunt_crossley": _hunt_crossley}
_ROWS |= {name: _remembering(*each) for name, each in FACTORS.items()}
_ROWS |= {
    name: _cylindrical(getattr(cylinders, name), spring, bounds, reference)
    for name, spring, bounds, reference in (
        ("johnson", cylinders.logarithmic, cylinders.logarithmic_slope, "johnson1985"),
        (
            "dubowsky_freudenstein",
            cylinders.logarithmic,
            cylinders.logarithmic_slope,
            "dubowsky_freudenstein1971",
        ),
        ("liu", cylinders.conforming, cylinders.conforming_slope, "liu2007"),
    )
}
LAWS = Table("jointplay.laws", Law, _ROWS | {"restitution": _restitution})
