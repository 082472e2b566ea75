"""Parts of a system of somebody's own equations, as text (equations.own.grammar): its structure.

As with a linkage's, no number stands here that a sweep could vary, and no SymPy is needed to compare two.
"""

from dataclasses import dataclass

Jump = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Wall:
    """A rigid wall: `gap` of positions, and after an impact a `restitution`, or new speeds by `jump`."""

    name: str
    gap: str
    restitution: str = ""
    jump: Jump = ()


@dataclass(frozen=True)
class Trigger:
    """A trigger: where `guard` falls through zero, states take new values."""

    name: str
    guard: str
    jump: Jump


@dataclass(frozen=True)
class Touch:
    """A contact with a `force` of ``depth`` and ``speed``, against the depth's growth."""

    name: str
    depth: str
    force: str
    pulls: bool = True


@dataclass(frozen=True)
class Rubbing:
    """Dry friction against a sliding `speed`, pressed together by `normal`."""

    name: str
    speed: str
    normal: str
    coefficient: str
    static: str = ""


@dataclass(frozen=True)
class Switch:
    """A number, `name`, that is 1 where `on` is above zero; else 0.

    One that `slides` is between them where both push towards the zero of `on`.
    """

    name: str
    on: str
    slides: bool = False


@dataclass(frozen=True)
class Oscillator:
    """A system of first and second order: rates of `speeds`, the first of which belong to `positions`.

    `mass` has entries (i, j, text), j <= i; `period` is that of the forcing. `section` names a quantity whose
    level crossings are wanted: a state, an output, or the phase of the forcing.
    """

    positions: tuple[str, ...]
    speeds: tuple[str, ...]
    parameters: tuple[str, ...]
    rates: tuple[str, ...]
    mass: tuple[tuple[int, int, str], ...] = ()
    period: str = ""
    contacts: tuple[Touch, ...] = ()
    friction: tuple[Rubbing, ...] = ()
    switches: tuple[Switch, ...] = ()
    impacts: tuple[Wall, ...] = ()
    jumps: tuple[Trigger, ...] = ()
    outputs: tuple[tuple[str, str], ...] = ()
    section: str | None = None
