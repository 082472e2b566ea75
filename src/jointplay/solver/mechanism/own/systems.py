"""Small systems with known answers, written as anybody's own equations (`mechanism.own.own`).

They are dimensionless, on the time scale on which their known answers are stated; each starts at time 0 from
the state that its docstring gives. References: Lorenz (1963); Roessler (1976); jerk with |x| after Linz and
Sprott (1999); two-well Duffing after Holmes (1979); impact pair and soft impact pair (rattling frame) after
Dubowsky and Freudenstein (1971) with forcing y'' = sin t; bouncing ball after Holmes (1982) and Guckenheimer
and Holmes (1983); gear pair with backlash after Kahraman and Singh (1990); relief valve after Hos and
Champneys (2012).
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field

from jointplay.solver.mechanism.base import Flag, NonNegative, Number, Positive
from jointplay.solver.mechanism.own.own import CATALOG, System
from jointplay.solver.mechanism.signature import preset

TestSystem = System
_Restitution = Annotated[NonNegative, Field(le=1)]
_TAU = "2*pi"
_SHAKEN = {"y": "v", "v": "sin(t)"}


def _system(name: str, parameters: dict[str, Any], states: dict[str, Any], **parts: Any) -> System:
    return System(name=name, system=name, parameters=parameters, states=states, **parts)


@preset("lorenz1963")
def lorenz(sigma: Number = 10.0, rho: Number = 28.0, beta: Number = 8 / 3) -> System:
    """Lorenz's system: x' = σ(y − x), y' = x(ρ − z) − y, z' = x y − β z; starts at (1, 1, 1)."""
    numbers, start = {"sigma": sigma, "rho": rho, "beta": beta}, dict.fromkeys("xyz", 1.0)
    rates = {"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"}
    return _system("lorenz", numbers, start, rates=rates)


@preset("roessler1976")
def rossler(a: Number = 0.2, b: Number = 0.2, c: Number = 5.7) -> System:
    """Rössler's system: x' = −y − z, y' = x + a y, z' = b + z(x − c); starts at (1, 1, 0)."""
    rates = {"x": "-y - z", "y": "x + a*y", "z": "b + z*(x - c)"}
    return _system("rossler", {"a": a, "b": b, "c": c}, {"x": 1.0, "y": 1.0, "z": 0.0}, rates=rates)


@preset("linz_sprott1999")
def jerk(damping: NonNegative = 0.6) -> System:
    """Jerk of Linz and Sprott: x‴ = −a x″ − x′ + |x| − 1, its rate bent at x = 0; starts at (−0.5, 0, 0).

    Parameters
    ----------
    damping : float
        a.
    """
    rates = {"x": "y", "y": "z", "z": "-damping*z - y + abs(x) - 1"}
    return _system("jerk", {"damping": damping}, {"x": -0.5, "y": 0.0, "z": 0.0}, rates=rates)


@preset("holmes1979")
def duffing(amplitude: NonNegative = 0.3, damping: NonNegative = 0.2, frequency: Positive = 1.0) -> System:
    """Duffing's two-well oscillator: x'' + δ x' − x + x³ = f cos ω t; starts at rest in a well, (1, 0).

    Parameters
    ----------
    amplitude, damping, frequency : float
        f, δ and ω.
    """
    numbers = {"amplitude": amplitude, "damping": damping, "frequency": frequency}
    rates = {"y": "v", "v": "amplitude*cos(frequency*t) - damping*v + y - y**3"}
    return _system("duffing", numbers, {"y": 1.0, "v": 0.0}, rates=rates, forcing="2*pi/frequency")


@preset("dubowsky_freudenstein1971", gap=3.6, restitution=0.8)
def impact_pair(gap: Positive, restitution: _Restitution) -> System:
    """Rattling mass in a shaken frame: y'' = sin t, |y| ≤ d/2, y' → −r y' at a wall; starts at (0, 0).

    Parameters
    ----------
    gap : float
        d between the walls, in units of forcing amplitude over frequency squared.
    restitution : float
        r, from 0 to 1.
    """
    jump = {"v": "-restitution*v"}
    walls = (
        {"name": "upper", "gap": "gap/2 - y", "jump": jump},
        {"name": "lower", "gap": "gap/2 + y", "jump": jump},
    )
    numbers, start = {"gap": gap, "restitution": restitution}, {"y": 0.0, "v": 0.0}
    return _system("impact_pair", numbers, start, rates=_SHAKEN, forcing=_TAU, impacts=walls)


@preset("dubowsky_freudenstein1971", gap=3.6, stiffness=50.0, damping=2.0)
def soft_impact_pair(
    gap: Positive, stiffness: Positive, damping: NonNegative, tension: Flag = True
) -> System:
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
    force = {"force": "stiffness*depth + damping*speed", "tension": "tension"}
    walls = (
        {"name": "upper", "depth": "y - gap/2"} | force,
        {"name": "lower", "depth": "-y - gap/2"} | force,
    )
    start = {"y": 0.0, "v": 0.0}
    return _system("soft_impact_pair", numbers, start, rates=_SHAKEN, forcing=_TAU, contacts=walls)


@preset("holmes1982", "guckenheimer_holmes1983", acceleration=1.2, restitution=0.5)
def bouncing_ball(acceleration: Positive, restitution: _Restitution) -> System:
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
    start = {"y": 0.01 + height, "v": (bounce - math.pi) / acceleration}
    jump = {"v": "-restitution*v + (1 + restitution)*cos(t)"}
    table = ({"name": "table", "gap": "y - sin(t)", "jump": jump},)
    rates, numbers = (
        {"y": "v", "v": "-1/acceleration"},
        {"acceleration": acceleration, "restitution": restitution},
    )
    return _system("bouncing_ball", numbers, start, rates=rates, forcing=_TAU, impacts=table)


@preset("kahraman_singh1990", mean_load=0.1, amplitude=0.2, frequency=1.6, damping=0.05)
def gear_backlash(
    mean_load: Number, amplitude: NonNegative, frequency: Positive, damping: NonNegative
) -> System:
    """Gear pair with backlash: x'' + 2ζ x' + f(x) = F_m + F_a W² cos W t; starts at (0.5, 0).

    f is x − 1 above 1, 0 within ±1, x + 1 below −1.

    Parameters
    ----------
    mean_load, amplitude, frequency, damping : float
        F_m, F_a, W and ζ.
    """
    numbers = {"mean_load": mean_load, "amplitude": amplitude, "frequency": frequency, "damping": damping}
    force = "mean_load + amplitude*frequency**2*cos(frequency*t) - 2*damping*v"
    flanks = (
        {"name": "drive", "depth": "y - 1", "force": "depth"},
        {"name": "coast", "depth": "-y - 1", "force": "depth"},
    )
    parts = {"rates": {"y": "v", "v": force}, "forcing": "2*pi/frequency", "contacts": flanks}
    return _system("gear_backlash", numbers, {"y": 0.5, "v": 0.0}, **parts)


@preset("hos_champneys2012")
def relief_valve(
    flow: NonNegative = 5.0,
    restitution: _Restitution = 0.8,
    kappa: NonNegative = 1.25,
    delta: NonNegative = 10.0,
    beta: Positive = 20.0,
) -> System:
    """Relief valve: x'' = −κ x' − (x + δ) + p, p' = β(q − x √p); x ≥ 0, on the seat x' → −r x'.

    Starts at rest at lift 0.2, with the pressure that the spring bears without lift (if that is not 0).

    Parameters
    ----------
    flow, restitution, kappa, delta, beta : float
        q, r, κ, δ and β.
    """
    numbers = {"flow": flow, "restitution": restitution, "kappa": kappa, "delta": delta, "beta": beta}
    rates = {"x": "v", "v": "-kappa*v - (x + delta) + p", "p": "beta*(flow - x*sqrt(p))"}
    seat = ({"name": "seat", "gap": "x", "restitution": "restitution"},)
    start = {"x": 0.2, "v": 0.0, "p": delta or 0.2}
    return _system("relief_valve", numbers, start, rates=rates, impacts=seat)


_ALL = (lorenz, rossler, jerk, duffing, impact_pair, soft_impact_pair, bouncing_ball, gear_backlash)
_ALL += (relief_valve,)
SYSTEMS = {system.__name__: system for system in _ALL}
CATALOG.own |= SYSTEMS
