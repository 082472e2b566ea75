"""Ideal loops and slides: the coordinates that follow from the free ones, group by group.

Reference: a loop cut at a revolute joint closes if the vector from bearing to journal vanishes,

    r = r0 + sum_k D_k e_k + sum_s sigma s d = 0             (links k, slides s along guides d).

Two scalar equations for two unknowns u, v: a dyad (equations.loops.dyads), or several such closures at once
for two unknowns of each (equations.loops.groups). Speeds and accelerations of the unknowns solve J_u u' + J_v
v' + ... = -J_known z and the same with centripetal terms. Forces on the bearings of cut joints close their
equations, J_u.F = -R_u, J_v.F = -R_v, R what these lack.

A link on a guide has the guide's angle but for a constant; its chain's base is the same kind of sum.
Deflections do not move the joints. A link that stretches (equations.stretch) does, by modes that are among
the known freedoms.
"""

from collections.abc import Callable

from sympy import Expr, Integer, Symbol

from ..coordinates import Coordinates, Freedom, dot
from ..drives import DRIVES
from ..structure import Linkage, Slide
from ..system import Root
from . import dyads, groups
from .groups import NOTHING
from .vectors import ZERO, Vector, Vectors, plus, turn


def complete(structure: Linkage, c: Coordinates) -> None:
    """Add all that follows: links on guides, bases of their chains, and the unknowns of the closures."""
    _settle(structure, c)
    for closures in structure.loops:
        if len(closures) > 1:
            groups.position(structure, closures, c)
        else:
            dyads.position(structure, *closures, c)
        _settle(structure, c)
        _motion([Vectors(structure, c, closure) for closure in closures], c)
        _settle(structure, c)
        groups.remember(closures, c)


def _settle(structure: Linkage, c: Coordinates) -> None:
    """Add directions, speeds and bases of links on guides, as far as their guides are known."""
    for slide in structure.slides:
        fixed, frame = slide.guide == "ground", structure.frame(slide.link)
        if slide.link not in c.angle and (fixed or slide.guide in c.angle):
            turn(slide, c)
        if slide.link not in c.speed and (frame == "ground" or frame in c.speed):
            c.follow(slide.link, {} if frame == "ground" else {frame: Integer(1)}, Integer(0))
        ready = {slide.link, slide.freedom, *slide.arms} | ({(slide.inner, 0)} - {(None, 0)})
        if (slide.chain, 0) not in c.speed and ready <= c.speed.keys():
            _base(Vectors(structure, c, slide), c)


def _base(r: Vectors, c: Coordinates) -> None:
    """Position and motion of the base of a sliding link's chain."""
    slide, columns, value, bend = r.of, r.columns(), r.value(), r.centripetal()
    for axis, x in enumerate("xy"):
        below = (slide.inner, axis)
        started = c.position[below] if slide.inner is not None else Integer(0)
        base = (slide.chain, axis)
        c.position[base] = c.let(f"{x}_{slide.chain}", started + value[axis])
        ratios = {k: c.let(f"{x}_{slide.chain}_{_word(k)}", column[axis]) for k, column in columns.items()}
        ratios |= {below: Integer(1)} if slide.inner is not None else {}
        c.follow(base, ratios, c.let(f"gamma_{x}_{slide.chain}", bend[axis]))


def _word(freedom: Freedom) -> str:
    return (
        freedom if isinstance(freedom, str) else "_".join(str(part) for part in freedom if part is not None)
    )


def _motion(loop: list[Vectors], c: Coordinates) -> None:
    """Speeds and accelerations of the unknowns of closures that close together."""
    unknowns, led = loop[0].of.unknowns, {}
    solve = groups.Inverse(loop, c) if len(loop) > 1 else dyads.Cramer(*loop, c)
    rest = [ZERO] * len(loop)
    for place, r in enumerate(loop):
        for k, column in r.columns().items():
            if k in unknowns:
                continue
            rest[place] = plus(rest[place], column, c.own[k])
            for leader, lead in c.leads[k].items():
                row = led.setdefault(leader, [ZERO] * len(loop))
                row[place] = plus(row[place], column, lead)
    ratios: dict[Freedom, dict[Freedom, Expr]] = {k: {} for k in unknowns}
    for leader, column in led.items():
        for k, ratio in zip(unknowns, solve.less(column), strict=True):
            ratios[k][leader] = c.let(f"G_{_word(k)}_{_word(leader)}", ratio)
    for k in unknowns:
        c.speed[k] = sum((ratio * c.speed[leader] for leader, ratio in ratios[k].items()), Integer(0))
    bend = [plus(one, r.centripetal()) for one, r in zip(rest, loop, strict=True)]
    for k, value in zip(unknowns, solve.less(bend), strict=True):
        c.follow(k, ratios[k], c.let(f"gamma_{_word(k)}", value), closes=True)


def watched(structure: Linkage, c: Coordinates) -> Expr:
    """Nothing, or no number where a dyad does not close: no other rate of an imposed motion shows it."""
    alone = DRIVES[structure.drive].imposed and not structure.joints and not structure.beams
    folds = [Symbol(f"fold_{loop[0].name}", real=True) for loop in structure.loops if len(loop) == 1]
    seen = Symbol("closes", real=True)
    if alone and folds and seen not in dict(c.definitions):
        c.definitions.append((seen, NOTHING * sum(folds)))
        c.roots.append(Root({}, (), (), (seen,)))
    return seen if alone and folds else Integer(0)


def closing_forces(loop: list[Vectors], needed: dict[Freedom, Expr]) -> list[Vector]:
    """Forces on the bearings of cut joints, by the needs of their unknowns' equations."""
    return groups.forces(loop, needed) if len(loop) > 1 else [dyads.force(*loop, needed)]


def moment(
    structure: Linkage,
    slide: Slide,
    c: Coordinates,
    needed: Callable[[Freedom], Expr],
    closing: list[tuple[Vectors, Vector]],
) -> Expr:
    """Moment that a guide must give to its link, about the base, to turn it with all it carries.

    `needed` is what joints must supply on each freedom, `closing` are the closures with their forces.
    """
    turned = [k for k in structure.links if structure.turns_with(k, slide.link)]

    def moved(r: Vectors) -> Vector:
        columns, total = r.columns(frames=False), ZERO
        for k in turned:
            total = plus(total, columns.get(k, ZERO))
        return total

    total, bases = sum((needed(k) for k in turned), Integer(0)), {}
    for each in structure.slides:
        bases[each.chain] = plus(bases.get(each.inner, ZERO), moved(Vectors(structure, c, each)))
    for chain, column in bases.items():
        total += dot(column, (needed((chain, 0)), needed((chain, 1)))) if column != ZERO else 0
    return total + sum((dot(moved(r), F) for r, F in closing), Integer(0))
