"""Small systems with known answers, on the same form as the linkages.

Each function gives the equations of one system; parameters keep the names of the catalog. References: Lorenz
(1963); Roessler (1976); jerk with |x| after Linz and Sprott (1999); two-well Duffing after Holmes (1979);
impact pair and soft impact pair (rattling frame) after Dubowsky and Freudenstein (1971) with forcing y'' =
sin t; bouncing ball after Holmes (1982) and Guckenheimer and Holmes (1983); gear pair with backlash after
Kahraman and Singh (1990).
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from inspect import signature

from sympy import Expr, Integer, symbols

from ..errors import InputError, unknown
from .structure import Oscillator
from .system import Angle, Contact, Reset, System, number

y, v = symbols("y v", real=True)


def _first_order(states: str, parameters: str, rates: Callable) -> System:
    z = symbols(states, real=True)
    p = tuple(number(name) for name in parameters.split())
    return System((), z, p, (), None, tuple(rates(*z, *p)), outputs={f"state:{s}": s for s in z})


def _oscillator(parameters: str, force: Expr, phase: Angle, **parts) -> System:
    """One degree of freedom y with speed v and acceleration `force`."""
    p = tuple(number(name) for name in parameters.split())
    outputs = {"state:y": y, "state:v": v, "phase": phase.value}
    outputs |= {f"gap:{reset.name}": reset.guard for reset in parts.get("resets", ())}
    angles = (phase,)
    return System((y,), (v,), p, (), None, (force,), angles, outputs=outputs, **parts)


def _wall(name: str, side: int, gap: Expr, K: Expr, C: Expr, pulls: bool) -> Contact:
    """A wall at side * gap: pushes back along -side."""
    u, v_n = side * y - gap, side * v
    return Contact(name, u, v_n, K * u + C * v_n, (Integer(side),), pulls, stored=K * u**2 / 2)


def lorenz() -> System:
    """x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z."""

    def rates(x, y, z, sigma, rho, beta):
        return sigma * (y - x), x * (rho - z) - y, x * y - beta * z

    return _first_order("x y z", "sigma rho beta", rates)


def rossler() -> System:
    """x' = -y - z, y' = x + a y, z' = b + z (x - c)."""
    return _first_order("x y z", "a b c", lambda x, y, z, a, b, c: (-y - z, x + a * y, b + z * (x - c)))


def jerk() -> System:
    """x' = y, y' = z, z' = -a z - y + |x| - 1: above 0, the difference |x| + x is a contact's force."""
    x, y, z = state = symbols("x y z", real=True)
    a = number("damping")
    fold = Contact("fold", x, y, x, (Integer(0), Integer(0), Integer(-2)), True)
    outputs = {f"state:{s}": s for s in state}
    return System((), state, (a,), (), None, (y, z, -a * z - y - x - 1), contacts=(fold,), outputs=outputs)


def duffing() -> System:
    """y'' + delta y' - y + y^3 = f cos(omega t)."""
    f, delta, omega = map(number, ("amplitude", "damping", "frequency"))
    phase = Angle("phase", None, omega)
    return _oscillator("amplitude damping frequency", f * phase.cos - delta * v + y - y**3, phase)


def impact_pair() -> System:
    """y'' = sin t between walls |y| <= gap/2 with restitution r: v -> -r v."""
    d, r = number("gap"), number("restitution")
    phase = Angle("phase", None, Integer(1))
    walls = tuple(Reset(name, d / 2 - side * y, {v: -r * v}) for name, side in (("upper", 1), ("lower", -1)))
    return _oscillator("gap restitution", phase.sin, phase, resets=walls)


def soft_impact_pair(tension: bool = True) -> System:
    """y'' = sin t with Kelvin-Voigt walls: contact force k(|y| - d/2) + c v outwards."""
    d, K, C = map(number, ("gap", "stiffness", "damping"))
    phase = Angle("phase", None, Integer(1))
    walls = _wall("upper", 1, d / 2, K, C, tension), _wall("lower", -1, d / 2, K, C, tension)
    return _oscillator("gap stiffness damping", phase.sin, phase, contacts=walls)


def bouncing_ball() -> System:
    """A ball at height y over a table at A sin t, in table periods: y'' = -1/Gamma, table sin t.

    Lengths in table amplitudes and time in 1/omega, so that Gamma = A omega^2/g is the only number besides
    the restitution a: relative speed w -> -a w, that is v -> -a v + (1 + a) cos t.
    """
    gamma, a = number("acceleration"), number("restitution")
    phase = Angle("phase", None, Integer(1))
    table = Reset("table", y - phase.sin, {v: -a * v + (1 + a) * phase.cos})
    return _oscillator("acceleration restitution", -1 / gamma, phase, resets=(table,))


def gear_backlash() -> System:
    """x'' + 2 zeta x' + f(x) = F_m + F_a W^2 cos(W t), f with a dead zone |x| < 1 and unit slope outside."""
    load, amplitude, W, zeta = map(number, ("mean_load", "amplitude", "frequency", "damping"))
    phase = Angle("phase", None, W)
    one = Integer(1)
    flanks = tuple(
        _wall(name, side, one, one, Integer(0), True) for name, side in (("drive", 1), ("coast", -1))
    )
    force = load + amplitude * W**2 * phase.cos - 2 * zeta * v
    return _oscillator("mean_load amplitude frequency damping", force, phase, contacts=flanks)


SYSTEMS: dict[str, Callable[..., System]] = {
    f.__name__: f
    for f in (lorenz, rossler, jerk, duffing, impact_pair, soft_impact_pair, bouncing_ball, gear_backlash)
}


def system(structure: Oscillator) -> System:
    """Write the equations of a test system, and the quantity that is watched.

    Raises
    ------
    InputError
        If there is no such system, or it has no such quantity.
    """
    _known("system", structure.name, SYSTEMS, "system")
    write = SYSTEMS[structure.name]
    for name, _ in structure.switches:
        _known(f"parameters.{name}", name, signature(write).parameters, "switch")
    plain = write(**dict(structure.switches))
    if structure.section is None:
        return plain
    states = {name.removeprefix("state:"): name for name in plain.outputs}
    _known("section.quantity", structure.section, states, "quantity")
    return replace(plain, section=plain.outputs[states[structure.section]])


def _known(key: str, name: str, known: Iterable[str], what: str) -> None:
    if name not in known:
        raise InputError([unknown(key, name, name, known, what)])
