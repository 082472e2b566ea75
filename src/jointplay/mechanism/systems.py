"""Small systems with known answers: their record, and those of the catalog.

They are dimensionless, on the time scale on which their known answers are stated; each starts at time 0 from
the state that its docstring gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import Field

from jointplay.errors import refuse
from jointplay.mechanism.base import (
    Flag,
    Name,
    NonNegative,
    Number,
    Positive,
    Record,
    Several,
    measured,
    named,
)
from jointplay.mechanism.signature import checked

_State = tuple[float, ...]
_Restitution = Annotated[NonNegative, Field(le=1)]
_VALUE = {"accepts": "a table of finite numbers, or true and false for switches,"}


class TestSystem(Record):
    """A small system with known answers, to test the methods on; dimensionless.

    Parameters
    ----------
    name : str
        Name, for titles.
    system : str
        Which equations: a key of `jointplay.equations.oscillators`.
    parameters : dict of str to float
        By name; switches are true or false.
    initial : tuple of float
        State at time 0.
    period : float, optional
        Period of the forcing; None if there is none.
    """

    __test__ = False  # the name starts with Test, and pytest would collect it

    name: Name = named("name")
    system: Name = named("name of the equations")
    parameters: dict[Name, Flag | Number] = Field(json_schema_extra=_VALUE)
    initial: Several[Number] = measured("initial state", "1")
    period: Positive | None = measured("forcing period", "1", None)

    @checked()
    def replace(self, **changes: Any) -> TestSystem:
        """Give a copy with other parameters, or another `initial` state.

        Parameters
        ----------
        **changes
            Parameters by name, and `initial`; the default initial state and the period follow the parameters.

        Raises
        ------
        InputError
            Listing every parameter that does not exist or cannot have its value.
        """
        if self.system not in SYSTEMS:
            accepted = f"a system of the catalog is accepted: {', '.join(SYSTEMS)}"
            raise refuse(self.system, accepted, "system")
        initial = {"initial": changes.pop("initial")} if "initial" in changes else {}
        record = SYSTEMS[self.system](**self.parameters | changes)
        return TestSystem(**dict(record) | initial) if initial else record

    def summary(self) -> str:
        """Describe the system in one line of text."""
        values = ", ".join(f"{name} = {value:g}" for name, value in self.parameters.items())
        cycle = f"; period {self.period:.6g}" if self.period else ""
        return f"{self.name}: {values}{cycle}"

    def __repr__(self) -> str:
        return f"<TestSystem {self.summary()}>"

    __str__ = __repr__

    def __hash__(self) -> int:
        return hash((self.name, self.system, tuple(self.parameters.items()), self.initial, self.period))


def _system(name: str, initial: _State, period: float | None = None, **parameters: float) -> TestSystem:
    return TestSystem(name=name, system=name, parameters=parameters, initial=initial, period=period)


@checked()
def lorenz(sigma: Number = 10.0, rho: Number = 28.0, beta: Number = 8 / 3) -> TestSystem:
    """Lorenz's system: x' = σ(y − x), y' = x(ρ − z) − y, z' = x y − β z; starts at (1, 1, 1)."""
    return _system("lorenz", (1.0, 1.0, 1.0), sigma=sigma, rho=rho, beta=beta)


@checked()
def rossler(a: Number = 0.2, b: Number = 0.2, c: Number = 5.7) -> TestSystem:
    """Rössler's system: x' = −y − z, y' = x + a y, z' = b + z(x − c); starts at (1, 1, 0)."""
    return _system("rossler", (1.0, 1.0, 0.0), a=a, b=b, c=c)


@checked()
def jerk(damping: NonNegative = 0.6) -> TestSystem:
    """Jerk of Linz and Sprott: x‴ = −a x″ − x′ + |x| − 1, its rate bent at x = 0; starts at (−0.5, 0, 0).

    Parameters
    ----------
    damping : float
        a.
    """
    return _system("jerk", (-0.5, 0.0, 0.0), damping=damping)


@checked()
def duffing(
    amplitude: NonNegative = 0.3, damping: NonNegative = 0.2, frequency: Positive = 1.0
) -> TestSystem:
    """Duffing's two-well oscillator: x'' + δ x' − x + x³ = f cos ω t; starts at rest in a well, (1, 0).

    Parameters
    ----------
    amplitude, damping, frequency : float
        f, δ and ω.
    """
    period = 2 * math.pi / frequency
    return _system("duffing", (1.0, 0.0), period, amplitude=amplitude, damping=damping, frequency=frequency)


@checked()
def impact_pair(gap: Positive, restitution: _Restitution) -> TestSystem:
    """Rattling mass in a shaken frame: y'' = sin t, |y| ≤ d/2, y' → −r y' at a wall; starts at (0, 0).

    Parameters
    ----------
    gap : float
        d between the walls, in units of forcing amplitude over frequency squared.
    restitution : float
        r, from 0 to 1.
    """
    return _system("impact_pair", (0.0, 0.0), 2 * math.pi, gap=gap, restitution=restitution)


@checked()
def soft_impact_pair(
    gap: Positive, stiffness: Positive, damping: NonNegative, tension: Flag = True
) -> TestSystem:
    """Unit mass in a shaken frame with soft walls: y'' = sin t − F; starts at rest midway, (0, 0).

    Beyond a wall, |y| > d/2, F = k (|y| − d/2) + c d|y|/dt, away from the wall.

    Parameters
    ----------
    gap : float
        d.
    stiffness, damping : float
        k and c.
    tension : bool
        False: contact ends where the force reaches 0, and a wall never pulls.
    """
    numbers = {"gap": gap, "stiffness": stiffness, "damping": damping, "tension": tension}
    return _system("soft_impact_pair", (0.0, 0.0), 2 * math.pi, **numbers)


@checked()
def bouncing_ball(acceleration: Positive, restitution: _Restitution) -> TestSystem:
    """Ball on a table that moves as sin t: y'' = −1/Γ in flight, lengths in table amplitudes, time in 1/ω.

    Starts a hundredth above the motion of one bounce a period, where cos t₀ = π(1 − a)/(Γ(1 + a)) at a
    bounce; where there is none, with t₀ = 0: (0.01 + sin t₀ + t₀(2π − t₀)/(2Γ), (t₀ − π)/Γ), height and
    velocity in the fixed frame.

    Parameters
    ----------
    acceleration : float
        Γ = A ω²/g of the table.
    restitution : float
        a, from 0 to 1.
    """
    bounce = math.acos(min(1.0, math.pi * (1 - restitution) / (acceleration * (1 + restitution))))
    height = math.sin(bounce) + bounce * (2 * math.pi - bounce) / (2 * acceleration)
    start = (0.01 + height, (bounce - math.pi) / acceleration)
    return _system("bouncing_ball", start, 2 * math.pi, acceleration=acceleration, restitution=restitution)


@checked()
def gear_backlash(
    mean_load: Number, amplitude: NonNegative, frequency: Positive, damping: NonNegative
) -> TestSystem:
    """Gear pair with backlash: x'' + 2ζ x' + f(x) = F_m + F_a W² cos W t; starts at (0.5, 0).

    f is x − 1 above 1, 0 within ±1, x + 1 below −1.

    Parameters
    ----------
    mean_load, amplitude, frequency, damping : float
        F_m, F_a, W and ζ.
    """
    numbers = {"mean_load": mean_load, "amplitude": amplitude, "frequency": frequency, "damping": damping}
    return _system("gear_backlash", (0.5, 0.0), 2 * math.pi / frequency, **numbers)


_ALL = (lorenz, rossler, jerk, duffing, impact_pair, soft_impact_pair, bouncing_ball, gear_backlash)
SYSTEMS: dict[str, Callable[..., TestSystem]] = {system.__name__: system for system in _ALL}
