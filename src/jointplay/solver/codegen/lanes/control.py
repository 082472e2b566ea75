"""Error, guards and step control of eight trajectories: lanes that may go on plainly, and next lengths.

    judge(w)     error, guards, section; which lanes may go on plainly
    settle(w)    the next length, and the new base point where a step is TAKEN

References: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8 (the error);
method.control (lengths), method.events (margins of guards; passing the bearing's centre).
"""

from ...method.control import SAFETY
from ...method.events import AT_FOLD, AWAY, NEAR_FOLD, NEARING, SQUARES, THERE
from ...method.lanes import PHASE
from ...method.lanes import layout as rows
from ...method.lanes.radau import ERROR, ERROR_A, ERROR_C, GAMMA, MAX_TURN, STAGES, TO_BERNSTEIN
from ...method.modes import CONE, FORCE, GAP
from .text import at, choose, lanes, moved, rotation, slope, stage, total

S = range(STAGES)
# Where Newton's iteration needs a second attempt, which costs as much as a step: what is left of the length;
# before it does, what an error of the last update's size is worth
AGAIN, SLOW = 0.85, 2.0
Turning = tuple[float, ...]  # 1 where a position is an angle, 0 where it is none; PHASE of a phase


def judge(turning: Turning, contacts: int, jumps: int, folds: int, crank: int) -> list[str]:
    """Error, guards, dead centres, section at the position `crank`; whether the attempt is plain."""
    guards = ["low = 0.0", "approach = 0.0", "through = 0.0"]
    guards += [line for g in range(4 * contacts + jumps) for line in _guard(g, g < 4 * contacts)]
    guards += [line for g in range(rows.FOLD, rows.FOLD + folds) for line in _dead_centre(g)]
    stores = {rows.LOW: "low", rows.PASSES: "approach", rows.CENTRE: "through"}
    guards += [f"{at(row)} = {value}" for row, value in stores.items()]
    return lanes(*_error(turning)) + lanes(*guards) + lanes(*_ahead(crank)) + lanes(*_plain())


def _guard(g: int, touches: bool) -> list[str]:
    """Lines that bound a guard's fall beyond its level (method.events), by Bernstein coefficients."""
    j, place = divmod(g, 4)
    force = at(rows.GUARD, 4 * j + FORCE)
    margin = f"{at(rows.CONE, j)} * abs({force})" if place == CONE and touches else at(rows.MARGIN, g)
    lines = [
        f"start, side, margin = {at(rows.GUARD, g)}, {at(rows.SIDE, g)}, {margin}",
        f"level = level_of(start, side, {at(rows.FIRED, g)}, margin)",
    ]
    names, loads = _values(g)
    lines += loads
    lines += [f"b{n} = {total(TO_BERNSTEIN[n], names)}" for n in range(1, STAGES)]
    lines += [f"b0, b{STAGES} = v0, v{STAGES}"]
    lines += [f"low = min(low, side * (b{n} - level))" for n in range(STAGES + 1)]
    lines += _approach(touches) if place == GAP or not touches else []
    return lines + (_centre(names, j) if place == GAP and touches else [])


def _values(g: int) -> tuple[list[str], list[str]]:
    """Names of the watched value, at the base point and at the stages; the lines that load it."""
    names = [f"v{j}" for j in range(STAGES + 1)]
    places = [at(rows.GUARD, g), *(at(rows.WATCHES, rows.GUARDS * n + g) for n in S)]
    return names, [f"{name} = {place}" for name, place in zip(names, places, strict=True)]


def _dead_centre(g: int) -> list[str]:
    """Whether the step may lead across a loop's dead centre, or one is met (method.events)."""
    names, loads = _values(g)
    return [
        *loads,
        f"least, most = {_nested('min', names)}, {_nested('max', names)}",
        f"near = {float(NEARING)!r} if {SQUARES!r} * least < most else {float(AWAY)!r}",
        f"near = near if least < {NEAR_FOLD!r} else {float(AWAY)!r}",
        f"through = max(through, {float(THERE)!r} if least < {AT_FOLD!r} else near)",
    ]


def _approach(touches: bool) -> list[str]:
    """Lines that find whether the gap may have a closest approach."""
    slopes = [f"b{n + 1} - b{n}" for n in range(STAGES)]
    return [
        f"passes = 1.0 if min({_nested('max', slopes)}, - {_nested('min', slopes)}) > 0.0 else 0.0",
        "flies = 1.0 if side < 0.0 else 0.0" if touches else "flies = 1.0",
        f"approach = max(approach, passes * flies * {at(rows.MISSES)})",
    ]


def _centre(names: list[str], contact: int) -> list[str]:
    """Whether the journal passes the bearing's centre."""
    return [
        f"square = {at(rows.CLEARANCE_SQUARED, contact)}",
        f"least, most = {_nested('min', names)} + square, {_nested('max', names)} + square",
        f"centre = 1.0 if {SQUARES!r} * least < most else 0.0",
        f"through = max(through, centre * {at(rows.MASK, 3 * contact)})",
    ]


def _nested(function: str, values: list[str]) -> str:
    """min or max of several, two by two."""
    found = values[0]
    for value in values[1:]:
        found = f"{function}({found}, {value})"
    return found


def _error(turning: Turning) -> list[str]:
    """The embedded estimate, of order 5, in units of the tolerated error; the largest turn of an angle."""
    lines, N = [f"h = {at(rows.H)}"], range(len(turning))
    Z = [[stage(rows.Z, j, k) for j in S] for k in N]
    lines += [f"q{k} = {1 + ERROR_C!r} * {at(rows.SPEED, k)} + {total(ERROR_A, Z[k])}" for k in N]
    for k in N:
        pulled = " + ".join(f"{slope(k, j)} * q{j}" for j in N)
        lines.append(f"z{k} = h * {at(rows.ACCELERATION, k)} + {total(ERROR, Z[k])}")
        lines[-1] += f" + {1 / GAMMA!r} * h * h * ({pulled})"
    lines += [f"ez{k} = " + " + ".join(f"{at(rows.INVERSE, rows.N * k + j)} * z{j}" for j in N) for k in N]
    for k in N:
        floor = at(rows.FLOOR_POSITION, k)
        if 1.0 not in turning:  # of a system of somebody's own, whose positions may be of any size
            floor = f"({floor} + {at(rows.TOLERANCE)} * abs({at(rows.POSITION, k)} + {at(rows.X, k)}))"
        lines.append(f"eq{k} = h * {1 / GAMMA!r} * (q{k} + ez{k}) / {floor}")
    for k in N:
        lines.append(f"ez{k} = ez{k} / ({at(rows.FLOOR, k)} + {at(rows.TOLERANCE)} * abs({at(rows.Y, k)}))")
    squares = " + ".join(f"eq{k} * eq{k} + ez{k} * ez{k}" for k in N)
    lines.append(f"{at(rows.ERROR)} = sqrt(({squares}) * {1 / (2 * free(turning))!r})")
    return [*lines, f"{at(rows.TURNED)} = {_largest(rows.X, turning)}"]


def free(turning: Turning) -> int:
    """Number of positions that are no phases, which have no error."""
    return sum(turns != PHASE for turns in turning)


def _largest(row: int, turning: Turning) -> str:
    """Largest size of a row of the angles, a phase's as a share."""
    sizes = [
        f"abs({at(row, k)})" + f" * {PHASE!r}" * (turns == PHASE) for k, turns in enumerate(turning) if turns
    ]
    return _nested("max", sizes)


def _ahead(crank: int) -> list[str]:
    """Lines for the largest advance of the crank's angle, or a phase, beyond the section's level."""
    lines = ["most = -1e300"]
    for j in S:
        lines.append(f"x = {moved(j, crank, at(rows.SPEED, crank))}")
        lines.append(f"most = max(most, {at(rows.DIRECTION)} * x)")
    return [
        *lines,
        f"{at(rows.CROSSED)} = most - {at(rows.DIRECTION)} * ({at(rows.AHEAD)} - {at(rows.POSITION, crank)})",
    ]


def _plain() -> list[str]:
    """Whether the attempt is accepted here; any other goes through the loop's own code (attempts)."""
    flags = [
        f"solved({at(rows.SIZE)}, {at(rows.SIZE_BEFORE)}, {at(rows.TURNED)})",
        f"{at(rows.ERROR)} < 1.0",
        f"{at(rows.LOW)} >= 0.0",
        f"{at(rows.T)} + {at(rows.H)} < {at(rows.END)} * 0.99999999999999",
        f"{at(rows.CROSSED)} < 0.0",
        f"{at(rows.LEFT)} > 1.5",
        f"max({at(rows.SPECIAL)}, max({at(rows.PASSES)}, {at(rows.CENTRE)})) == 0.0",
    ]
    lines = [f"g{k} = 1.0 if {flag} else 0.0" for k, flag in enumerate(flags)]
    lines += ["plain = " + " * ".join(f"g{k}" for k in range(len(flags)))]
    lines += [f"{at(row)} = plain" for row in (rows.PLAIN, rows.WHOLE, rows.TAKEN, rows.KEEP)]
    lines += [
        f"{at(rows.CONTINUED)} = {at(rows.CONTINUES)}",
        f"{at(rows.CONTINUES)} = 0.0",
        f"{at(rows.LATER)} = 0.0",
    ]
    return [*lines, f"{at(rows.H_NEXT)} = {at(rows.H)}"]


def settle(turning: Turning, contacts: int, jumps: int, folds: int) -> list[str]:
    """Control; then the base point moves to the step's end, and LATER by Taylor's series."""
    moved = [f"taken, later = {at(rows.TAKEN)}, {at(rows.LATER)}"]
    values = {
        at(rows.T): f"{at(rows.T)} + ({at(rows.H)} + later)",
        at(rows.STEPS): f"{at(rows.STEPS)} + 1.0",
        at(rows.LEFT): f"{at(rows.LEFT)} - 1.0",
    }
    for place, value in values.items():
        moved += choose(place, value, "taken > 0.0")
    for k, turns in enumerate(turning):
        moved += _moved(k, turns)
    for g in range(4 * contacts + jumps):
        moved += choose(at(rows.GUARD, g), at(rows.WATCHED, g), "taken > 0.0")
        moved += choose(at(rows.FIRED, g), "0.0", "taken > 0.0")
    for g in range(rows.FOLD, rows.FOLD + folds):
        moved += choose(at(rows.GUARD, g), at(rows.WATCHED, g), "taken > 0.0")
    kept = [f"keep = {at(rows.KEEP)}", *choose(at(rows.H_PAST), at(rows.H), "keep > 0.0")]
    for k in range(len(turning)):
        for j in S:
            kept += choose(stage(rows.PAST, j, k), stage(rows.Z, j, k), "keep > 0.0")
    return lanes(*_control(turning)) + lanes(*moved) + lanes(*kept, f"{at(rows.H)} = {at(rows.H_NEXT)}")


def _moved(k: int, turns: float) -> list[str]:
    """Position k at the new base point; an angle's sine and cosine are kept on the unit circle."""
    lines = [
        f"a, z = {at(rows.RATE, k)}, {at(rows.Y, k)}",
        f"turn = {at(rows.X, k)} + (z + 0.5 * a * later) * later",
    ]
    values = {
        rows.POSITION: f"{at(rows.POSITION, k)} + turn",
        rows.SPEED: "z + a * later",
        rows.ACCELERATION: "a",
    }
    if turns:
        lines += [*rotation("sn", "cn", k, "turn", turns == PHASE), "unit = 1.5 - 0.5 * (sn * sn + cn * cn)"]
        values |= {rows.SINE: "sn * unit", rows.COSINE: "cn * unit"}
    for row, value in values.items():
        lines += choose(at(row, k), value, "taken > 0.0")
    return lines


def _control(turning: Turning) -> list[str]:
    """Length after a whole step, as method.control has it: the power is 1/6, and a length is bounded.

    It is the shorter, the more the iteration has left to do.
    """
    lines = [
        f"whole, h, limit = {at(rows.WHOLE)}, {at(rows.H)}, {at(rows.H_LIMIT)}",
        f"error = max({at(rows.ERROR)}, 1e-8)",
        f"ratio = {at(rows.H_BEFORE)} / h",
        "ratio = ratio * ratio",
        f"again = error * error / {at(rows.ERROR_BEFORE)} * ratio * ratio * ratio",
        f"again = again if {at(rows.REJECTION)} == 0.0 else 0.0",
        f"slow = {SLOW!r} * {at(rows.SIZE)} if {at(rows.CONTINUED)} == 0.0 else 0.0",
        "r2 = sqrt(min(max(max(error, again), slow), 1e30))",
        "r4 = sqrt(r2)",
        "r8 = sqrt(r4)",
        "r16 = sqrt(r8)",
        "r32 = sqrt(r16)",
        "r64 = sqrt(r32)",
        f"factor = {SAFETY!r} / (r8 * r32 * sqrt(r64))",
        f"most = {AGAIN!r} if {at(rows.CONTINUED)} > 0.0 else 6.0",
        "new = min(h * min(max(factor, 0.2), most), limit)",
    ]
    lines += _served()
    changed = {
        rows.H_LIMIT: "limit * 1.05",
        rows.H_CONTROL: "new",
        rows.H_BEFORE: "h",
        rows.ERROR_BEFORE: "max(error, 1e-2)",
        rows.REJECTION: "0.0",
        rows.SPECIAL: "0.0",
        rows.OFFSET: "1.0",
        rows.SMOOTH: "1.0",
    }
    for row, value in changed.items():
        lines += choose(at(row), value, "whole > 0.0")
    fast = f"max({at(rows.TURN_SPEED)}, {_largest(rows.Y, turning)})"
    lines += [
        f"new = bounded({at(rows.H_CONTROL)}, {fast}, {MAX_TURN!r}, {at(rows.END)} - ({at(rows.T)} + h))",
        *choose(at(rows.H_NEXT), "new", "whole > 0.0"),
    ]
    return lines


def _served() -> list[str]:
    """The length that served in flight or in contact, unless something but the error kept the step short."""
    return [
        f"variant, old0, old1 = {at(rows.VARIANT)}, {at(rows.H_VARIANT)}, {at(rows.H_VARIANT, 1)}",
        "served = old1 if variant > 0.0 else old0",
        "up = 1.0 if error > 1e-3 else 0.0",
        "up = 1.0 if new > served else up",
        "up = up if whole > 0.0 else 0.0",
        "up0 = 0.0 if variant > 0.0 else up",
        "up1 = up if variant > 0.0 else 0.0",
        f"{at(rows.H_VARIANT)} = new if up0 > 0.0 else old0",
        f"{at(rows.H_VARIANT, 1)} = new if up1 > 0.0 else old1",
    ]
