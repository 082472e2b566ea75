"""What follows an attempt of eight trajectories: what may go on plainly, and how far next.

    judge(w)     error, guards, section; which lanes may go on plainly
    settle(w)    the next length, and the new base point where a step is TAKEN

References: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8 (the error);
numerics.control (lengths), numerics.events (margins of guards; what swings).
"""

from ...numerics.control import SAFETY
from ...numerics.ensemble import layout as r
from ...numerics.ensemble.radau import (
    ERROR,
    ERROR_A,
    ERROR_C,
    GAMMA,
    NODES,
    STAGES,
    TO_BERNSTEIN,
    A,
)
from ...numerics.events import SWING
from .text import at, choose, lanes, rotation, stage, total

N, S = range(r.N), range(STAGES)


def judge() -> list[str]:
    """Error, guards, section; whether the attempt is plain."""
    guards = ["low = 0.0", *(line for g in range(4) for line in _guard(g))]
    return lanes(*_error()) + lanes(*guards, f"{at(r.LOW)} = low") + lanes(*_ahead()) + lanes(*_plain())


def _guard(g: int) -> list[str]:
    """How low a guard goes at most beyond its level (numerics.ensemble.guards), by Bernstein coefficients."""
    margin = f"{at(r.CONE)} * abs({at(r.GUARD, 1)})" if g == 3 else at(r.MARGIN, g)
    lines = [
        f"start, side, margin = {at(r.GUARD, g)}, {at(r.SIDE, g)}, {margin}",
        f"level = level_of(start, side, {at(r.FIRED, g)}, margin)",
    ]
    names = [f"v{j}" for j in range(STAGES + 1)]
    values = ["start", *(at(r.WATCHES, 4 * j + g) for j in S)]
    lines += [f"{name} = {value}" for name, value in zip(names, values, strict=True)]
    lines += [f"b{n} = {total(TO_BERNSTEIN[n], names)}" for n in range(1, STAGES)]
    lines += [f"b0, b{STAGES} = v0, v{STAGES}"]
    lines += [f"low = min(low, side * (b{n} - level))" for n in range(STAGES + 1)]
    return lines + (_gap(names) if g == 0 else [])


def _gap(names: list[str]) -> list[str]:
    """Whether the gap may have a closest approach that is asked for, and whether a journal swings."""
    slopes = [f"b{n + 1} - b{n}" for n in range(STAGES)]
    return [
        f"passes = 1.0 if min({_nested('max', slopes)}, - {_nested('min', slopes)}) > 0.0 else 0.0",
        "flies = 1.0 if side < 0.0 else 0.0",
        f"{at(r.PASSES)} = passes * flies * {at(r.MISSES)}",
        f"least, most = {_nested('min', names)} + {at(r.BUSH)}, {_nested('max', names)} + {at(r.BUSH)}",
        f"swings = 1.0 if {SWING!r} * least < most else 0.0",
        f"{at(r.SWINGS)} = swings * {at(r.VARIANT)}",
    ]


def _nested(function: str, values: list[str]) -> str:
    """min or max of several, two by two."""
    found = values[0]
    for value in values[1:]:
        found = f"{function}({found}, {value})"
    return found


def _error() -> list[str]:
    """The embedded estimate, of order 5, in units of the tolerated error; the largest turn of an angle."""
    lines = [f"h = {at(r.H)}"]
    Z = [[stage(r.Z, j, k) for j in S] for k in N]
    lines += [f"q{k} = {1 + ERROR_C!r} * {at(r.SPEED, k)} + {total(ERROR_A, Z[k])}" for k in N]
    for k in N:
        pulled = " + ".join(f"{at(r.JACOBIAN, 2 * r.N * k + j)} * q{j}" for j in N)
        lines.append(
            f"z{k} = h * {at(r.ACCELERATION, k)} + {total(ERROR, Z[k])} + {1 / GAMMA!r} * h * h * ({pulled})"
        )
    lines += [f"ez{k} = " + " + ".join(f"{at(r.INVERSE, 3 * k + j)} * z{j}" for j in N) for k in N]
    lines += [f"eq{k} = h * {1 / GAMMA!r} * (q{k} + ez{k}) / {at(r.TOLERANCE)}" for k in N]
    lines += [f"ez{k} = ez{k} / ({at(r.FLOOR)} + {at(r.TOLERANCE)} * abs({at(r.Y, k)}))" for k in N]
    squares = " + ".join(f"eq{k} * eq{k} + ez{k} * ez{k}" for k in N)
    lines.append(f"{at(r.ERROR)} = sqrt(({squares}) * {1 / 6!r})")
    return [*lines, f"{at(r.TURNED)} = {_nested('max', [f'abs({at(r.X, k)})' for k in N])}"]


def _ahead() -> list[str]:
    """How far beyond the section's level the crank, the first angle, comes at any stage."""
    lines = ["most = -1e300"]
    for j in S:
        moved = total(A[j], (stage(r.Z, n, 0) for n in S))
        lines.append(f"x = {at(r.H)} * ({float(NODES[j])!r} * {at(r.SPEED)} + {moved})")
        lines.append(f"most = max(most, {at(r.DIRECTION)} * x)")
    return [*lines, f"{at(r.CROSSED)} = most - {at(r.DIRECTION)} * ({at(r.AHEAD)} - {at(r.POSITION)})"]


def _plain() -> list[str]:
    """Whether the attempt is taken with no more ado; what is not so goes through the loop's own code."""
    flags = [
        f"converged({at(r.SIZE)}, {at(r.SIZE_BEFORE)}, {at(r.TURNED)})",
        f"{at(r.ERROR)} < 1.0",
        f"{at(r.LOW)} >= 0.0",
        f"{at(r.T)} + {at(r.H)} < {at(r.END)} * 0.99999999999999",
        f"{at(r.CROSSED)} < 0.0",
        f"{at(r.LEFT)} > 1.5",
        f"max({at(r.ODD)}, max({at(r.PASSES)}, {at(r.SWINGS)})) == 0.0",
    ]
    lines = [f"g{k} = 1.0 if {flag} else 0.0" for k, flag in enumerate(flags)]
    lines += ["plain = " + " * ".join(f"g{k}" for k in range(len(flags)))]
    lines += [f"{at(row)} = plain" for row in (r.PLAIN, r.WHOLE, r.TAKEN, r.KEEP)]
    lines += [f"{at(r.WAS_JOINED)} = {at(r.JOINED)}", f"{at(r.JOINED)} = 0.0", f"{at(r.LATER)} = 0.0"]
    return [*lines, f"{at(r.H_NEXT)} = {at(r.H)}"]


def settle() -> list[str]:
    """Control; then the base point moves to the step's end, and LATER by Taylor's series."""
    moved = [f"taken, later = {at(r.TAKEN)}, {at(r.LATER)}"]
    values = {
        at(r.T): f"{at(r.T)} + ({at(r.H)} + later)",
        at(r.STEPS): f"{at(r.STEPS)} + 1.0",
        at(r.LEFT): f"{at(r.LEFT)} - 1.0",
    }
    for place, value in values.items():
        moved += choose(place, value, "taken > 0.0")
    for k in N:
        moved += _moved(k)
    for g in range(4):
        moved += choose(at(r.GUARD, g), at(r.WATCHED, g), "taken > 0.0")
        moved += choose(at(r.FIRED, g), "0.0", "taken > 0.0")
    kept = [f"keep = {at(r.KEEP)}", *choose(at(r.H_PAST), at(r.H), "keep > 0.0")]
    for k in range(r.N * STAGES):
        kept += choose(at(r.PAST, k), at(r.Z, k), "keep > 0.0")
    return lanes(*_control()) + lanes(*moved) + lanes(*kept, f"{at(r.H)} = {at(r.H_NEXT)}")


def _moved(k: int) -> list[str]:
    """Angle k at the new base point; its sine and cosine are kept on the unit circle."""
    lines = [
        f"a, z = {at(r.RATE, k)}, {at(r.Y, k)}",
        f"turn = {at(r.X, k)} + (z + 0.5 * a * later) * later",
        *rotation("sn", "cn", k, "turn"),
        "unit = 1.5 - 0.5 * (sn * sn + cn * cn)",
    ]
    values = {
        r.POSITION: f"{at(r.POSITION, k)} + turn",
        r.SPEED: "z + a * later",
        r.ACCELERATION: "a",
        r.SINE: "sn * unit",
        r.COSINE: "cn * unit",
    }
    for row, value in values.items():
        lines += choose(at(row, k), value, "taken > 0.0")
    return lines


def _control() -> list[str]:
    """Length after a whole step, as numerics.control has it: the power is 1/6, and a length is bounded."""
    lines = [
        f"whole, h, limit = {at(r.WHOLE)}, {at(r.H)}, {at(r.H_LIMIT)}",
        f"error = max({at(r.ERROR)}, 1e-8)",
        f"ratio = {at(r.H_BEFORE)} / h",
        "ratio = ratio * ratio",
        f"again = error * error / {at(r.ERROR_BEFORE)} * ratio * ratio * ratio",
        f"again = again if {at(r.REJECTION)} == 0.0 else 0.0",
        "r2 = sqrt(min(max(error, again), 1e30))",
        "r4 = sqrt(r2)",
        "r8 = sqrt(r4)",
        "r16 = sqrt(r8)",
        "r32 = sqrt(r16)",
        "r64 = sqrt(r32)",
        f"factor = {SAFETY!r} / (r8 * r32 * sqrt(r64))",
        f"most = 1.0 if {at(r.WAS_JOINED)} > 0.0 else 6.0",
        "new = min(h * min(max(factor, 0.2), most), limit)",
    ]
    lines += _served()
    changed = {
        r.H_LIMIT: "limit * 1.05",
        r.H_CONTROL: "new",
        r.H_BEFORE: "h",
        r.ERROR_BEFORE: "max(error, 1e-2)",
        r.REJECTION: "0.0",
        r.ODD: "0.0",
        r.OFFSET: "1.0",
        r.SMOOTH: "1.0",
    }
    for row, value in changed.items():
        lines += choose(at(row), value, "whole > 0.0")
    fast = _nested("max", [f"abs({at(r.Y, k)})" for k in N])
    lines += [
        f"new = bounded({at(r.H_CONTROL)}, {fast}, {at(r.END)} - ({at(r.T)} + h))",
        *choose(at(r.H_NEXT), "new", "whole > 0.0"),
    ]
    return lines


def _served() -> list[str]:
    """The length that served in flight or in contact, unless something but the error kept the step short."""
    return [
        f"variant, old0, old1 = {at(r.VARIANT)}, {at(r.H_VARIANT)}, {at(r.H_VARIANT, 1)}",
        "served = old1 if variant > 0.0 else old0",
        "up = 1.0 if error > 1e-3 else 0.0",
        "up = 1.0 if new > served else up",
        "up = up if whole > 0.0 else 0.0",
        "up0 = 0.0 if variant > 0.0 else up",
        "up1 = up if variant > 0.0 else 0.0",
        f"{at(r.H_VARIANT)} = new if up0 > 0.0 else old0",
        f"{at(r.H_VARIANT, 1)} = new if up1 > 0.0 else old1",
    ]
