"""Springs with dampers between two points, or between the angles of two links.

With the stretch s, which is L - L_0 for the distance L = |r| of the points, or theta_p - theta_q - theta_0,

    F = k s + c s',     V = k s^2 / 2,     Q_z = -F ds/dz,     power taken in by the damper c s'^2.

Source: virtual work. Assumptions: no mass; linear in the stretch, pulling and pushing. Where the two points
meet, their line has no direction and the spring no force on that line: TINY keeps the division finite there.
"""

from dataclasses import dataclass

from sympy import Expr, Float, Integer, sqrt

from .coordinates import Coordinates, Freedom
from .loops import vectors
from .structure import Spring
from .system import number

TINY = Float(1e-200)


@dataclass(frozen=True)
class Action:
    """An action on a linkage: `amount` times `column` on the freedoms, `pulls` on the bodies of links.

    `energy` is what it stores, `lost` the power that it takes in, `power` the power that it brings.
    """

    amount: Expr
    column: dict[Freedom, Expr]
    pulls: tuple[tuple[str, vectors.Vector], ...] = ()
    energy: Expr = Integer(0)
    lost: Expr = Integer(0)
    power: Expr = Integer(0)


def action(spring: Spring, c: Coordinates) -> Action:
    """Action of a spring."""
    name, pulls = spring.span.name, ()
    if spring.twists:
        signs = dict(zip(spring.links, (1, -1), strict=True))
        entries = {k: Integer(sign) for k, sign in signs.items() if k != "ground"}
        stretch = sum(sign * c.angle[k].value for k, sign in entries.items()) - number(f"rest_{name}")
    else:
        x, y = (
            c.let(f"d{axis}_{name}", v) for axis, v in zip("xy", vectors.vector(spring.span, c), strict=True)
        )
        length = c.let(f"L_{name}", sqrt(x**2 + y**2 + TINY))
        unit = c.let(f"ux_{name}", x / length), c.let(f"uy_{name}", y / length)
        entries, stretch = vectors.column(spring.span, c, unit), length - number(f"rest_{name}")
    k, s = number(f"k_{name}"), c.let(f"stretch_{name}", stretch)
    speed = c.let(f"rate_{name}", vectors.rate(entries, c)) if spring.damped else Integer(0)
    damping = number(f"c_{name}") if spring.damped else Integer(0)
    F = c.let(f"F_{name}", k * s + damping * speed)
    if not spring.twists:
        pulls = tuple(
            (link, (sign * F * unit[0], sign * F * unit[1]))
            for link, sign in zip(spring.links, (-1, 1), strict=True)
        )
    return Action(-F, entries, pulls, k * s**2 / 2, damping * speed**2)
