"""Small systems with known answers, written as anybody's own equations (`mechanism.own.own`).

They are dimensionless, on the time scale on which their known answers are stated; each starts at time 0 from
the state that its docstring gives. References: Lorenz (1963); Roessler (1976); jerk with |x| after Linz and
Sprott (1999); two-well Duffing after Holmes (1979); impact pair and soft impact pair (rattling frame) after
Dubowsky and Freudenstein (1971) with forcing y'' = sin t; bouncing ball after Holmes (1982) and Guckenheimer
and Holmes (1983); gear pair with backlash after Kahraman and Singh (1990), the stiffness of its mesh after
Kahraman and Singh (1991); relief valve after Hos and Champneys (2012). The cam and its follower, in SI units,
are after Osorio, di Bernardo and Santini (2007); the cam's arcs are those of Siconos' example `CamFollower`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field

from jointplay.solver.mechanism.base import Flag, NonNegative, Number, Positive, unit
from jointplay.solver.mechanism.own.own import CATALOG, System
from jointplay.solver.mechanism.signature import preset

TestSystem = System
_Restitution = Annotated[NonNegative, Field(le=1), unit("restitution", "1")]
_Share = Annotated[NonNegative, Field(lt=1), unit("share", "1")]
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
    rates = {"y": "v", "v": "-1/acceleration"}
    numbers = {"acceleration": acceleration, "restitution": restitution}
    return _system("bouncing_ball", numbers, start, rates=rates, forcing=_TAU, impacts=table)


@preset("kahraman_singh1990", "kahraman_singh1991", mean_load=0.1, amplitude=0.2, frequency=1.6, damping=0.05)
def gear_backlash(
    mean_load: Number, amplitude: NonNegative, frequency: Positive, damping: NonNegative, mesh: _Share = 0.0
) -> System:
    """Gear pair with backlash: x'' + 2ζ x' + (1 + κ cos W t) f(x) = F_m + F_a W² cos W t; starts at (0.5, 0).

    f is x − 1 above 1, 0 within ±1, x + 1 below −1. W is the frequency at which teeth come into mesh, with
    which their stiffness varies about its mean.

    Parameters
    ----------
    mean_load, amplitude, frequency, damping, mesh : float
        F_m, F_a, W, ζ and κ, from 0 to less than 1.
    """
    numbers = {"mean_load": mean_load, "amplitude": amplitude, "frequency": frequency, "damping": damping}
    force = "mean_load + amplitude*frequency**2*cos(frequency*t) - 2*damping*v"
    push = {"force": "(1 + mesh*cos(frequency*t))*depth"}
    flanks = ({"name": "drive", "depth": "y - 1"} | push, {"name": "coast", "depth": "-y - 1"} | push)
    parts = {"rates": {"y": "v", "v": force}, "forcing": "2*pi/frequency", "contacts": flanks}
    return _system("gear_backlash", numbers | {"mesh": mesh}, {"y": 0.5, "v": 0.0}, **parts)


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


_JOIN, _TOP = 1.050328174371336, 1.22173047639603  # rad, from where the cam begins to rise
_FAR = 0.45, 0.40393320723821  # m, centres of the flanks and of the nose's rounded edges from the axis
_CAM = {  # arcs in the order of a turn: radius in m, how far its centre is, the turn at its end in rad
    "rise": (0.85, _FAR[0], _JOIN),
    "nose_up": (0.15, _FAR[1], _TOP),
    "top": (_FAR[1] + 0.15, 0.0, math.pi - _TOP),
    "nose_down": (0.15, _FAR[1], math.pi - _JOIN),
    "fall": (0.85, _FAR[0], math.pi),
    "base": (0.4, 0.0, 0.0),
}


@preset("osorio2007")
def cam_follower(
    speed: Annotated[Positive, unit("speed", "rad/s")] = 37.49,
    restitution: _Restitution = 0.8,
    mass: Annotated[Positive, unit("mass", "kg")] = 1.221,
    stiffness: Annotated[Positive, unit("stiffness", "N/m")] = 1430.8,
    damping: Annotated[NonNegative, unit("damping", "N s/m")] = 0.0,
) -> System:
    """Follower with an edge, pressed on a turning cam by a spring; starts 0.3 m above it, rising at 0.4 m/s.

    Its height h ≥ 0 above the cam's radius r obeys m (h'' + r'') + c (h' + r') + k (h + r − 0.3 m) = 0, with
    rebounds h' → −e h'. The radius is 0.4 m on the base circle and 0.554 m at the top. Between are arcs: of
    the radius 0.85 m about points 0.45 m from the axis, and of 0.15 m. Where arcs meet, r'' jumps.

    Parameters
    ----------
    speed : float
        Of the cam, rad/s.
    restitution : float
        e, from 0 to 1.
    mass, stiffness, damping : float
        m in kg, k in N/m and c in N s/m.
    """
    # An arc of radius ρ about a point d from the axis, at the angle γ from the edge, has r = u + s, where
    # u = d cos γ, w = d sin γ and s² = ρ² − w². Over γ, r' = −w (1 + u/s) and r'' = ρ² (ρ² − d²)/s³ − r.
    names, modes = list(_CAM), {}
    for name, after in zip(names, [*names[1:], names[0]], strict=True):
        left = f"({_CAM[name][-1]!r} - speed*t)"  # until the arc ends: as a sine that 180 degrees do not end
        modes[name] = [{"to": after, "guard": f"1 + sin{left} - cos{left}"}]
    u, w = (
        f"({_FAR[0]!r}*(fall - rise)*{wave}(speed*t)"
        f" + {_FAR[1]!r}*(nose_up*{wave}(speed*t - {_TOP!r}) - nose_down*{wave}(speed*t + {_TOP!r})))"
        for wave in ("cos", "sin")
    )
    squares = "+".join(f"{rho**2!r}*{name}" for name, (rho, _, _) in _CAM.items())
    bends = "+".join(f"{rho**2 * (rho**2 - d**2)!r}*{name}" for name, (rho, d, _) in _CAM.items())
    s = f"sqrt({squares} - {w}**2)"
    spring = f"stiffness*(height + {u} + {s} - 0.3) + damping*(v - speed*{w}*(1 + {u}/{s}))"
    numbers = {"speed": f"{speed!r} rad/s", "restitution": restitution, "mass": f"{mass!r} kg"}
    numbers |= {"stiffness": f"{stiffness!r} N/m", "damping": f"{damping!r} N s/m"}
    parts = {
        "rates": {"height": "v", "v": f"-({spring})/mass - speed**2*(({bends})/{s}**3 - {u} - {s})"},
        "forcing": "2*pi/speed",
        "modes": modes,
        "impacts": ({"name": "cam", "gap": "height", "restitution": "restitution"},),
    }
    return _system("cam_follower", numbers, {"height": "0.3 m", "v": "0.4 m/s"}, **parts)


_ALL = (lorenz, rossler, jerk, duffing, impact_pair, soft_impact_pair, bouncing_ball, gear_backlash)
_ALL += (relief_valve, cam_follower)
SYSTEMS = {system.__name__: system for system in _ALL}
CATALOG.own |= SYSTEMS
