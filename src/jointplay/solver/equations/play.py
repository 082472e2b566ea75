"""A joint with play in the equations: laws of contact and friction, or impacts, and recorded quantities."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from sympy import Expr, Integer, Max, Symbol, sympify

from . import functions
from .contact import TINY, Geometry
from .coordinates import Coordinates, approach, bristle
from .friction import FRICTIONS
from .laws import LAWS
from .structure import Clearance
from .system import Contact, Reset, number, rubbing, traction


def definitions(joints: Iterable[Geometry]) -> tuple[tuple[Symbol, Expr], ...]:
    """Definitions of the geometries, each once: the corners of a slider share some."""
    return tuple(dict.fromkeys(each for g in joints for each in g.definitions))


def contact(joint: Clearance, g: Geometry, c: Coordinates) -> Contact:
    """The contact of a bearing that gives, under its laws."""
    law = LAWS[joint.law]
    own = joint.owner
    numbers = [number(f"{letter}_{own}") for letter in law.arguments]
    remembered, floor = [approach(joint.name)] * joint.remembers, number(f"{law.floor}_{own}")
    F_n, stored = law.force(functions, g.u, g.v_n, *numbers, *remembered)
    push = None if law.push is None else sympify(law.push(g.v_n, *numbers, *remembered))
    drag = number(f"Ct_{own}") * g.v_t if joint.viscous else Integer(0)
    friction, slip, limit = FRICTIONS.get(joint.friction), None, None
    z = [bristle(joint.name)] * joint.bends
    if friction:
        given = functions, g.v_t, *z, *(number(f"{x}_{own}") for x in friction.letters)
        slip = friction.ratio(*given)
    if friction and friction.limit:
        limit = number(f"{friction.limit_letter}_{own}")
    elif friction:
        drag, slip = drag + slip * F_n, None
    return Contact(
        joint.name,
        g.u,
        g.v_n,
        F_n,
        g.normal,
        joint.tension or not law.pulls,
        g.v_t,
        g.tangential,
        slip,
        drag,
        stored,
        g.gap,
        _drift(g, c),
        limit,
        push,
        {v_0: Max(g.v_n, floor) for v_0 in remembered} | dict.fromkeys(z, Integer(0)),
        dict.fromkeys(remembered, floor) | dict.fromkeys(z, Integer(0)),
        {each: friction.bristles(*given) for each in z},
        joint.face,
    )


def wall(joint: Clearance, g: Geometry, c: Coordinates, drawing: Expr) -> Reset:
    """A rigid bearing, or face of a guide; `drawing` is the speed of a drive whose impulses do work."""
    own, (N, T) = joint.owner, g.on_drive
    drawn = -g.steep * N * drawing, T * drawing
    plain = Reset(joint.name, g.wall, restitution=number(f"r_{own}"), drawn=drawn)
    if joint.friction not in FRICTIONS:
        return plain
    f = number(f"{FRICTIONS[joint.friction].limit_letter}_{own}")
    rubs = {"v_t": g.v_t, "tangential": g.tangential, "drift": _drift(g, c)}
    return replace(plain, coulomb=f, guide=joint.joint, **rubs)


def _drift(g: Geometry, c: Coordinates) -> Expr:
    """The part of dv_t/dt that prescribed accelerations make."""
    return sum((entry * c.drift[freedom] for freedom, entry in g.spun.items()), Integer(0))


def held(joint: Clearance, g: Geometry, walls: Iterable[Clearance]) -> tuple[Expr, Expr]:
    """Push and friction of a rigid joint; corners of one face divide their friction by their loads."""
    push = -traction(joint)[1] * g.steep
    if joint.friction not in FRICTIONS:
        return push, Integer(0)
    if not joint.face:
        return push, rubbing(joint)
    face = [other for other in walls if other.face == joint.face]
    total, load = (sum(parts) for parts in zip(*((rubbing(o), traction(o)[1]) for o in face), strict=True))
    return push, total * traction(joint)[1] / (load - TINY)


def outputs(
    joint: Clearance, g: Geometry, force: tuple[Expr, Expr], stored: Expr
) -> Iterator[tuple[str, Expr]]:
    """Recorded quantities of a joint with play, as word:label."""
    name = joint.name
    yield f"journal_x:{name}", g.r[0]
    yield f"journal_y:{name}", g.r[1]
    yield f"eccentricity:{name}", g.rho
    yield f"eccentricity_ratio:{name}", g.rho / number(f"e_{joint.owner}")
    yield f"penetration:{name}", g.u
    yield f"normal_velocity:{name}", g.v_n
    yield f"tangential_velocity:{name}", g.v_t
    yield f"contact_angle:{name}", g.angle
    yield f"normal_force:{name}", force[0]
    yield f"tangential_force:{name}", force[1]
    yield f"stored_energy:{name}", stored
    if g.slide is not None:
        yield f"slide_position:{name}", g.slide[0]
        yield f"slide_velocity:{name}", g.slide[1]
