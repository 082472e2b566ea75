"""The closed four-bar: coupler and rocker follow the crank.

Reference: closure d_1 e_1 + d_2 e_2 = c + d_3 e_3 (crank, coupler, rocker; c from the crank's pivot to the
rocker's), solved by intersecting two circles, and its derivatives

    d_1 w_1 n_1 + d_2 w_2 n_2 = d_3 w_3 n_3,     w_2 = G_2 w_1,  w_3 = G_3 w_1,
    d_2 a_2 n_2 - d_3 a_3 n_3 = -d_1 a_1 n_1 + b,     b = d_1 w_1^2 e_1 + d_2 w_2^2 e_2 - d_3 w_3^2 e_3,

projected on e_3 and e_2. It is cut at the joint between coupler and rocker; the force F that its bearing
takes closes the equations of those two links: R_k = -D_k n_k.F, with R_k inertia less applied forces.
Singular where coupler and rocker lie in one line. Deflections do not move the joints: the closure is rigid.
"""

from sympy import Expr, Symbol, sqrt

from .coordinates import Coordinates, Direction, dot
from .structure import Linkage
from .system import number


def close(structure: Linkage, c: Coordinates) -> None:
    """Add angles, speeds and accelerations of coupler and rocker as functions of the crank's."""
    crank, coupler, rocker = structure.loop.links
    d = [number(f"d_{k}") for k in (crank, coupler, rocker)]
    c.angle.update(_directions(structure, c, d))
    e, n = ({k: form(k) for k in (crank, coupler, rocker)} for form in (c.e, c.n))
    fold = c.let("fold", dot(n[coupler], e[rocker]))
    ratio = {
        coupler: c.let(f"G_{coupler}", -d[0] * dot(n[crank], e[rocker]) / (d[1] * fold)),
        rocker: c.let(f"G_{rocker}", -d[0] * dot(n[crank], e[coupler]) / (d[2] * fold)),
    }
    w, b = c.speed[crank], []
    for axis in (0, 1):
        along = d[0] * e[crank][axis] + d[1] * ratio[coupler] ** 2 * e[coupler][axis]
        b.append(along - d[2] * ratio[rocker] ** 2 * e[rocker][axis])
    bias = {
        coupler: c.let(f"gamma_{coupler}", dot(b, e[rocker]) / (d[1] * fold)),
        rocker: c.let(f"gamma_{rocker}", dot(b, e[coupler]) / (d[2] * fold)),
    }
    for k in (coupler, rocker):
        c.follow(k, crank, ratio[k], bias[k] * w**2)


def _directions(structure: Linkage, c: Coordinates, d: list[Symbol]) -> dict[str, Direction]:
    """Sines and cosines of coupler and rocker: the circles about the crank's end and the rocker's pivot."""
    crank, coupler, rocker = structure.loop.links
    x, y = (c.let(f"far_{a}", number(f"c{a}") - d[0] * c.e(crank)[i]) for i, a in enumerate("xy"))
    gap2 = c.let("far2", x**2 + y**2)
    gap = c.let("far", sqrt(gap2))
    along = c.let("along", (gap2 + (d[1] - d[2]) * (d[1] + d[2])) / (2 * gap))
    # Heron's product keeps digits where the triangle is nearly flat
    one, two = (c.let(f"side_{i}", number(f"span_{i}")) for i in (2, 3))
    heron = (one + two - gap) * (gap - one + two) * (gap + one - two) * (gap + one + two)
    across = c.let("across", number("side") * sqrt(heron) / (2 * gap))
    bx = c.let("reach_x", (along * x - across * y) / gap)
    by = c.let("reach_y", (along * y + across * x) / gap)
    found = {}
    for k, span, (px, py) in ((coupler, d[1], (bx, by)), (rocker, d[2], (bx - x, by - y))):
        found[k] = Direction(c.let(f"s_{k}", py / span), c.let(f"c_{k}", px / span))
    return found


def closing_force(structure: Linkage, c: Coordinates, residual: dict[str, Expr]) -> tuple[Expr, Expr]:
    """Force on the bearing of the joint at which the loop is cut, by the residuals of the moved links."""
    _, coupler, rocker = structure.loop.links
    pull = {k: -residual[k] / number(f"D_{structure.loop.name}_{k}") for k in (coupler, rocker)}
    along_rocker = pull[coupler] / dot(c.n(coupler), c.e(rocker))
    along_coupler = pull[rocker] / dot(c.n(rocker), c.e(coupler))
    return tuple(along_rocker * c.e(rocker)[axis] + along_coupler * c.e(coupler)[axis] for axis in (0, 1))
