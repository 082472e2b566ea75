"""Tables of the laws of force, made from the laws.

The restitution that laws of the normal force give stands beside the one that is asked of them. A body of mass
m meets the contact with speed v_0, nothing else acts on it. Of F_n = K u^n (1 + chi v_n) with d = chi v_0 its
restitution e follows from d (1 + e) = ln[(1 + d) / (1 - d e)], whatever m, K and n.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import log, nextafter

from scipy.optimize import brentq

from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import FACTORS, LAWS
from jointplay.solver.equations.quantity import ForceLaw
from jointplay.study.cite import short
from pages.text import table

DAMPED = "K uⁿ (1 + d v/v₀), "  # of all laws of a restitution: stands above the table
WANTED = (0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.1)


def restitution(d: float) -> float:
    """Restitution that a damping factor d = chi v_0 gives."""
    if d < 1e-6:  # the equation is 0 = 0 to rounding; e = 1 - 2 d / 3 to order d^2
        return 1 - 2 * d / 3
    most = nextafter(min(1.0, 1 / d), 0.0)  # the force is 0 where 1 - d e is
    return brentq(lambda e: log((1 + d) / (1 - d * e)) - d * (1 + e), 1e-14, most, xtol=1e-15, rtol=1e-14)


def restitutions() -> str:
    """Restitution by law and by what is wanted."""
    rows = (
        (f"`{name}`", *(f"{restitution(factor(e)):.3f}" for e in WANTED))
        for name, (factor, *_) in FACTORS.items()
    )
    return table(("law", *(f"e = {e:g}" for e in WANTED)), rows)


def laws(title: str, named: Mapping[str, ForceLaw]) -> str:
    """Each law with its formula and sources; its numbers are on the generated page of keys."""

    def rows() -> Iterator[tuple[str, ...]]:
        for name, law in named.items():
            sources = "; ".join(map(short, law.references or ())) or "textbooks"
            yield f"`{name}`", law.formula.replace(DAMPED, "").replace("](#", "](../laws.md#"), sources

    return table(("law", title, "source"), rows())


def page() -> str:
    """The page of all laws of contact and of friction."""
    return (
        "# Formulas of the laws\n\n"
        "[Laws of contact](../laws.md) and [of friction](../friction-laws.md) say what the letters mean.\n"
        "Where the table gives d alone, F_n = K uⁿ (1 + d v/v₀).\n\n"
        f"{laws('F_n while u ≥ 0', LAWS)}\n"
        f"## Friction\n\n{laws('μ for v_t > 0', FRICTIONS)}\n"
        "## Restitution\n\n"
        "What laws of a restitution e give in an impact of a free body.\n\n"
        f"{restitutions()}"
    )
