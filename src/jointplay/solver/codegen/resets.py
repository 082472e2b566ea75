"""Jumps of the state in a structure's module: impacts, coming to rest, memories of laws, unit impulses."""

from sympy import Expr, Integer, Symbol

from ..equations.system import System
from .dynamics import Dynamics
from .source import Layout, Program, dispatch, point
from .tape import Tape


def text(layout: Layout) -> str:
    """Source of `reset`, as codegen.module has it."""
    parts, resets = [], layout.system.resets
    programs = [_jumping(layout.system, k) for k in range(len(resets))]
    programs = dict(enumerate(programs + [_settling(layout.system, k) for k in range(len(resets))]))
    programs |= {k: _remembering(layout.system, jump) for k, jump in remembered(layout.system).items()}
    programs |= {k: _pushing(layout.system, *push) for k, push in pushes(layout.system).items()}
    for k, program in programs.items():
        stores = {f"new_{z}": place for z, place in layout.base.items()}
        own = {str(symbol): stores[str(symbol)] for symbol, _ in program if str(symbol) in stores}
        parts.append("@compiled\n" + point(f"reset_{k}", layout, program, own, "s, p", "s") + "\n")
    return "\n".join([*parts, dispatch("reset", "k, s, p", {k: f"reset_{k}" for k in programs})])


def _jumping(system: System, k: int) -> Program:
    """Speeds after the k-th reset; of a rough wall method.walls.impacts finds them."""
    if system.resets[k].rough:
        return []
    if system.resets[k].restitution is None:
        return [(Symbol(f"new_{z}"), value) for z, value in system.resets[k].speeds.items()]
    dynamics = Dynamics(system, "free")
    return dynamics.tape.program({f"new_{z}": value for z, value in jumped(dynamics, k).items()})


def pushes(system: System) -> dict[int, tuple[int, bool]]:
    """Walls that need unit impulses, and whether along T, by their numbers: several, and rough ones."""
    first, walls = 2 * len(system.resets) + 2 * len(system.contacts), [*enumerate(system.resets)]
    newton = [k for k, wall in walls if wall.restitution is not None]
    found = {first + k: (k, False) for k in newton if len(newton) > 1 or system.resets[k].rough}
    return found | {first + len(walls) + k: (k, True) for k, wall in walls if wall.rough}


def _pushing(system: System, k: int, across: bool) -> Program:
    """Speeds after a unit impulse on the k-th wall."""
    dynamics = Dynamics(system, "free")
    return dynamics.tape.program({f"new_{z}": v for z, v in pushed(dynamics, k, across).items()})


def pushed(dynamics: Dynamics, k: int, across: bool) -> dict[Symbol, Expr]:
    """New speeds after a unit impulse on the k-th wall along N, or T."""
    wall = dynamics.contacts[len(dynamics.system.contacts) + k]
    row = (dynamics.system.resets[k] if across else wall).tangential
    column = dynamics.inverse_mass(list(row), f"unit{k}_{across}")
    return {z: z + w for z, w in zip(dynamics.system.speeds, column, strict=True) if w != 0}


def _settling(system: System, k: int) -> Program:
    """Positions and speeds at rest on the k-th wall."""
    dynamics = Dynamics(system, "free")
    return dynamics.tape.program({f"new_{x}": value for x, value in settled(dynamics, k).items()})


def jumped(dynamics: Dynamics, k: int) -> dict[Symbol, Expr]:
    """New speeds of the k-th reset."""
    reset = dynamics.system.resets[k]
    if reset.restitution is None:
        return reset.speeds
    return _pushed(dynamics.system.speeds, 1 + reset.restitution, *impulse(dynamics, k))


def _remembering(system: System, jump: dict[Symbol, Expr]) -> Program:
    """Program of the values that a law remembers from here on."""
    return Tape(system).program({f"new_{z}": value for z, value in jump.items()})


def remembered(system: System) -> dict[int, dict[Symbol, Expr]]:
    """Jumps where contacts begin, then where they end, that a law remembers, by their number."""
    contacts, first = system.contacts, 2 * len(system.resets)
    jumps = [contact.entry for contact in contacts] + [contact.exit for contact in contacts]
    return {first + j: jump for j, jump in enumerate(jumps) if jump}


def settled(dynamics: Dynamics, k: int) -> dict[Symbol, Expr]:
    """New positions and speeds of a body that comes to rest on the k-th wall: gap and rate are taken away."""
    system = dynamics.system
    if system.resets[k].moves:
        return {}
    column, weight, rate = impulse(dynamics, k)
    moved = _pushed(system.positions, Integer(1), column, weight, system.resets[k].gap)
    return moved | _pushed(system.speeds, Integer(1), column, weight, rate)


def impulse(dynamics: Dynamics, k: int) -> tuple[list[Expr], Expr, Expr]:
    """Column M^-1 N of an impulse of the k-th wall, the weight N.M^-1 N, the rate of the gap."""
    wall = dynamics.contacts[len(dynamics.system.contacts) + k]
    column = dynamics.inverse_mass(list(wall.tangential), f"way{k}")
    weight = sum((a * b for a, b in zip(wall.tangential, column, strict=True)), Integer(0))
    return column, dynamics.tape.let(f"weight{k}", weight), wall.v_t


def drawn(dynamics: Dynamics, k: int, across: bool = False) -> Expr:
    """Work of a drive that imposes a speed, per impulse on the k-th wall along N, or T."""
    system, moved = dynamics.system, pushed(dynamics, k, across) if any(dynamics.system.draws) else {}
    changes = (
        draw * (moved[z] - z) for z, draw in zip(system.speeds, system.draws, strict=False) if z in moved
    )
    return sum(changes, -system.resets[k].drawn[across])


def drive_work(dynamics: Dynamics, k: int) -> Expr:
    """Work of a drive that imposes a speed in the k-th jump, as `reset` counts them."""
    system, push = dynamics.system, pushes(dynamics.system).get(k)
    if push:
        return drawn(dynamics, *push)
    wall, rests = k % max(1, len(system.resets)), k >= len(system.resets)
    if k >= 2 * len(system.resets) or system.resets[wall].restitution is None:
        return Integer(0)
    _, weight, rate = impulse(dynamics, wall)
    share = Integer(1) if rests else 1 + system.resets[wall].restitution
    return -share * rate / weight * drawn(dynamics, wall)


def _pushed(
    symbols: tuple[Symbol, ...], share: Expr, column: list[Expr], weight: Expr, amount: Expr
) -> dict[Symbol, Expr]:
    """Positions or speeds after a push along the column that takes that share of `amount` away."""
    return {x: x - share * y * amount / weight for x, y in zip(symbols, column, strict=False) if y != 0}
