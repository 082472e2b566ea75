"""Tangents with each of eight trajectories: their linear collocation equations, written out.

    point(w, j)      the point of stage j, of the step
    keep(w, j)       d rate / d state that was found there
    advance(w)       slopes at the new base point, where a step is TAKEN, and the trace's sum
    base(w)          d rate / d state at the base point, for lanes with NEW_SLOPES

and of one tangent, whose numbers are `own`

    start(w, own)    its stages predicted; ACTIVE: its step may be accepted
    vary(w, own)     its rates at all stages, times h
    improve(w, own)  one update of its stages with the step's own matrices, until it has converged
    check(w, own)    its error; who may go on plainly
    follow(w, own)   it at the new base point
    due(w, own)      who has to be rid of its part along the rate there

and of a frame, where a step is TAKEN

    rate(w, own)           the first: the rate itself
    remove(w, own, other)  the part along another, of unit length, taken away
    shorten(w, own)        unit length, and the growth's logarithm
    complete(w, own)       the last one's growth by the volume (method.tangents.tangent)

The equations Z = h A J (d + Z) are those of method.tangents.tangent, stages those of codegen.lanes.algebra.
One text for structures of one size. Rows: method.lanes.layout.
"""

from ...method.lanes import layout as rows
from ...method.lanes.radau import A_INVERSE, ERROR, ERROR_A, ERROR_C, GAMMA, LATE, STAGES, A
from ...method.tangents.tangent import RESOLVED
from .algebra import predict, solve
from .text import TANGENT, at, choose, fetch, function, lanes, moved, of, stage, total

HEADER = '''"""Generated: tangents beside each of eight trajectories; do not edit."""
from math import inf, log, sqrt

from jointplay.solver.method.lanes.attempts import solved
from jointplay.solver.method.interface import compiled
from jointplay.solver.method.lanes.lanewise import lanewise

'''
S = range(STAGES)
BASE, END = 0, STAGES  # blocks of slopes; that of stage j is 1 + j
NOTHING = 1e-3  # of the tolerance: an update of this size ends the iteration whatever came before
HOPELESS = 1e100
REPEAT = 30.0  # error of an iteration that does not converge: half the length is tried
ALONG = 0.999  # share of a tangent's square along the motion's own rate, from which on it is taken away


def text(n: int) -> str:
    """Source of the module, for n positions."""
    N = range(n)
    own = {"start": _start(N), "vary": _vary(N), "improve": _improve(N), "check": _check(N)}
    own |= {
        "follow": _follow(N),
        "due": lanes(*_due(N)),
        "rate": _rate(N),
        "shorten": _shorten(N),
        "complete": _complete(),
    }
    bodies = [function(*each, arguments="w, own") for each in own.items()]
    bodies.append(function("remove", _remove(N), arguments="w, own, other"))
    new = lanes(*_slopes(N, BASE, at(rows.NEW_SLOPES), "new"), *_known())
    bodies += [function("advance", _advance(N)), function("base", new)]
    kept = [lanes(*_slopes(N, 1 + j, at(rows.STASHED), "old")) for j in S]
    staged = {"point": [lanes(*fetch(n, j)) for j in S], "keep": kept}
    bodies += [_by_stage(name, each) for name, each in staged.items()]
    return HEADER + "\n\n" + "\n\n\n".join(bodies) + "\n"


def _by_stage(name: str, bodies: list[list[str]]) -> str:
    """A function of the stage's number."""
    lines = []
    for j, body in enumerate(bodies):
        lines += [f"    if j == {j}:", *(f"    {line}" for line in body)]
    return function(name, lines, arguments="w, j")


def _slope(block: int, k: int, i: int) -> str:
    """D rate k / d position i, or speed i - N, of a block."""
    return at(rows.SLOPES + 2 * rows.N * (rows.N * block + k) + i)


def _entries(N: range) -> list[tuple[int, int]]:
    return [(k, i) for k in N for i in (*N, *(rows.N + j for j in N))]


def _slopes(N: range, block: int, flag: str, which: str) -> list[str]:
    """Take the slopes just found for a block; 'new': where the flag is set, 'old': where it is not."""
    lines = [f"flag = {flag}"]
    for k, i in _entries(N):
        found = at(rows.JACOBIAN + 2 * rows.N * k + i)
        lines += choose(_slope(block, k, i), found, "flag > 0.0" if which == "new" else "flag == 0.0")
    return lines


def _known() -> list[str]:
    return [f"{at(rows.NEW_SLOPES)} = 0.0"]


def _pulled(N: range, block: int, k: int, position: str, speed: str) -> str:
    """Slopes of rate k times (position, speed): names with the number of the unknown appended."""
    terms = [f"{_slope(block, k, j)} * {position}{j}" for j in N]
    return " + ".join(terms + [f"{_slope(block, k, rows.N + j)} * {speed}{j}" for j in N])


def _size(N: range, position: str, speed: str) -> str:
    """Square of the length of a tangent of these names, in units of the scales."""
    pairs = [(position, rows.WEIGHT_POSITION), (speed, rows.WEIGHT)]
    squares = [f"({name}{k} * {at(row, k)})" for name, row in pairs for k in N]
    return " + ".join(f"{each} * {each}" for each in squares)


def _tangent(N: range) -> list[str]:
    return [f"d{k} = {at(rows.D_POSITION, k)}" for k in N] + [f"v{k} = {at(rows.D_SPEED, k)}" for k in N]


def _start(N: range) -> list[str]:
    follows = f"min({at(rows.SMOOTH)}, {at(rows.FOLLOWS)})"
    out = predict(N, TANGENT, follows, at(rows.STASHED))
    flags = [
        f"solved({at(rows.SIZE)}, {at(rows.SIZE_BEFORE)}, {at(rows.TURNED)})",
        f"min({at(rows.ERROR)}, 2.0 - {at(rows.SPECIAL)} * 2.0) < 1.0",
        f"{at(rows.STASHED)} == 0.0",
    ]
    lines = [*_tangent(N), f"{at(rows.D_LENGTH)} = sqrt({_size(N, 'd', 'v')})"]
    lines += [f"g{n} = 1.0 if {flag} else 0.0" for n, flag in enumerate(flags)]
    lines += [f"{at(rows.ACTIVE)} = g0 * g1 * g2", f"{at(rows.LEFT_OVER)} = g0 * g1 * g2"]
    lines.append(f"{at(rows.STRAINED)} = 0.0")
    return out + lanes(*lines, f"{at(rows.D_SIZE)} = 0.0", f"{at(rows.D_RATIO)} = 0.0")


def _vary(N: range) -> list[str]:
    out = []
    for j in S:
        lines = [*_tangent(N), f"h = {at(rows.H)}"]
        lines += [f"q{k} = d{k} + {moved(j, k, f'v{k}', TANGENT)}" for k in N]
        lines += [f"z{k} = v{k} + {stage(rows.D_Z, j, k)}" for k in N]
        lines += [f"{stage(rows.D_F, j, k)} = h * ({_pulled(N, 1 + j, k, 'q', 'z')})" for k in N]
        out += lanes(*lines)
    return out


def _improve(N: range) -> list[str]:
    """Converged: as method.tangents.tangent has it, by the slowest ratio of updates that was seen."""
    lines = [f"active = {at(rows.ACTIVE)}"]
    for k in N:
        squares = " + ".join(f"{stage(rows.D_F, j, k)} * {stage(rows.D_F, j, k)}" for j in S)
        lines.append(f"n{k} = ({squares}) * {at(rows.WEIGHT, k)} * {at(rows.WEIGHT, k)}")
    lines += [
        f"size = sqrt(({' + '.join(f'n{k}' for k in N)}) * {1 / (len(N) * STAGES)!r})",
        f"before, slowest = {at(rows.D_SIZE)}, {at(rows.D_RATIO)}",
        "ratio = size / before if before > 0.0 else 0.0",
        "slowest = max(ratio, slowest)",
        f"length, tolerance = {at(rows.D_LENGTH)}, {at(rows.D_TOLERANCE)}",
        "left = slowest * size / (1.0 - slowest) if slowest < 1.0 else 1e300",
        "left = left if slowest > 0.0 else 1e300",
        f"left = left if size > {NOTHING!r} * tolerance * length else 0.0",
        "go = 0.0 if left <= tolerance * length else 1.0",
        f"go = go if size < {HOPELESS!r} else 0.0",
        "fine = 1.0 if left <= tolerance * length else 0.0",
        f"{at(rows.D_SIZE)} = size",
        f"{at(rows.D_RATIO)} = slowest",
        f"{at(rows.LEFT_OVER)} = {at(rows.LEFT_OVER)} - active * fine",
        f"{at(rows.ACTIVE)} = active * go",
    ]
    return solve(N, TANGENT, at(rows.ACTIVE)) + lanes(*lines)


def _check(N: range) -> list[str]:
    """The estimate of codegen.lanes.control, of the tangent; the trace's integral over the step."""
    lines = [*_tangent(N), f"h = {at(rows.H)}"]
    Z = [[stage(rows.D_Z, j, k) for j in S] for k in N]
    lines += [f"q{k} = {1 + ERROR_C!r} * v{k} + {total(ERROR_A, Z[k])}" for k in N]
    for k in N:
        pulled = " + ".join(f"{_slope(1 + LATE, k, j)} * q{j}" for j in N)
        lines.append(f"z{k} = h * ({_pulled(N, BASE, k, 'd', 'v')}) + {total(ERROR, Z[k])}")
        lines[-1] += f" + {1 / GAMMA!r} * h * h * ({pulled})"
    inverse = [[at(rows.INVERSE, rows.N * k + j) for j in N] for k in N]
    lines += [f"ez{k} = " + " + ".join(f"{inverse[k][j]} * z{j}" for j in N) for k in N]
    lines += [f"eq{k} = h * {1 / GAMMA!r} * (q{k} + ez{k})" for k in N]
    lines += [f"nd{k} = d{k} + {moved(END - 1, k, f'v{k}', TANGENT)}" for k in N]
    lines += [f"nv{k} = v{k} + {stage(rows.D_Z, END - 1, k)}" for k in N]
    traces = [" + ".join(_slope(1 + j, k, rows.N + k) for k in N) for j in S]
    lines += [f"gain = h * ({total(A[END - 1], (f'({trace})' for trace in traces))})"]
    lines += choose(at(rows.GAIN), "gain", f"{at(rows.STASHED)} == 0.0")
    plain = [at(row) for row in (rows.PLAIN, rows.WHOLE, rows.TAKEN, rows.KEEP)]
    return lanes(
        *lines,
        f"end = sqrt({_size(N, 'nd', 'nv')})",
        f"error = sqrt(({_size(N, 'eq', 'ez')}) * {1 / (2 * len(N))!r})",
        f"error = error / ({at(rows.D_LIMIT)} * min({at(rows.D_LENGTH)}, end) + 1e-300)",
        f"strained, within = {at(rows.LEFT_OVER)}, {at(rows.STASHED)}",
        f"{at(rows.STRAINED)} = max({at(rows.STRAINED)}, strained)",
        f"error = {REPEAT!r} if strained > 0.0 else error",
        "error = error if within == 0.0 else 0.0",
        f"{at(rows.ERROR)} = max({at(rows.ERROR)}, error)",
        f"plain = {at(rows.PLAIN)} if error < 1.0 else 0.0",
        *(f"{place} = plain" for place in plain),
    )


def _follow(N: range) -> list[str]:
    """The tangent at the step's end, and LATER by its rate."""
    lines = [*_tangent(N), f"taken, later = {at(rows.TAKEN)}, {at(rows.LATER)}"]
    lines += [f"q{k} = d{k} + {moved(END - 1, k, f'v{k}', TANGENT)}" for k in N]
    lines += [f"z{k} = v{k} + {stage(rows.D_Z, END - 1, k)}" for k in N]
    lines += [f"r{k} = z{k} + later * ({_pulled(N, END, k, 'q', 'z')})" for k in N]
    lines += [f"p{k} = q{k} + later * z{k}" for k in N]
    for k in N:
        for row, value in ((rows.D_POSITION, f"p{k}"), (rows.D_SPEED, f"r{k}")):
            lines += choose(at(row, k), value, "taken > 0.0")
    kept = [f"keep = {at(rows.KEEP)}"]
    for k in N:
        for j in S:
            kept += choose(stage(rows.D_PAST, j, k), stage(rows.D_Z, j, k), "keep > 0.0")
    kept += choose(at(rows.FOLLOWS), "1.0", "keep > 0.0")
    return lanes(*lines) + lanes(*kept)


def _advance(N: range) -> list[str]:
    """Lines for the rate, LATER than the step's end; and for what else is of the new base point."""
    lines = [f"taken, later = {at(rows.TAKEN)}, {at(rows.LATER)}"]
    lines += [f"y{k}, a{k} = {at(rows.Y, k)}, {at(rows.RATE, k)}" for k in N]
    lines += [f"b{k} = a{k} + later * ({_pulled(N, END, k, 'y', 'a')})" for k in N]
    for k in N:
        lines += choose(at(rows.RATE_BEFORE, k), f"b{k}", "taken > 0.0")
    lines += choose(at(rows.TRACE), f"{at(rows.TRACE)} + {at(rows.GAIN)}", "taken > 0.0")
    for k, i in _entries(N):
        lines += choose(_slope(BASE, k, i), _slope(END, k, i), "taken > 0.0")
    lines += [f"span = {at(rows.H)} + later", f"{at(rows.SPAN)} = span"]
    late = f"1.0 if {at(rows.T)} + span >= {at(rows.NEXT_ROW)} else 0.0"
    return lanes(*lines, f"late = {late}", f"{at(rows.DUE)} = late if taken > 0.0 else 0.0")


def _due(N: range) -> list[str]:
    """DUE is 2 where the tangent has grown far, or lies along the rate."""
    both = [f"d{k} * {at(rows.WEIGHT_POSITION, k)} * y{k} * {at(rows.WEIGHT_POSITION, k)}" for k in N]
    both += [f"v{k} * {at(rows.WEIGHT, k)} * b{k} * {at(rows.WEIGHT, k)}" for k in N]
    return [
        *_tangent(N),
        *(f"y{k}, b{k} = {at(rows.Y, k)}, {at(rows.RATE_BEFORE, k)}" for k in N),
        f"size, rate = {_size(N, 'd', 'v')}, {_size(N, 'y', 'b')}",
        f"both = {' + '.join(both)}",
        "far = 1.0 if max(size, 1.0 / (size + 1e-300)) > 1e6 else 0.0",
        f"along = 1.0 if both * both > {ALONG!r} * size * rate else 0.0",
        f"again = 2.0 * max(far, along) if {at(rows.TAKEN)} > 0.0 else 0.0",
        f"{at(rows.DUE)} = max({at(rows.DUE)}, again)",
    ]


def _rate(N: range) -> list[str]:
    """Its stages are increments of A^-1 Z / h; PAST is in units of its length, D_SIZE, once that is known."""
    lines = [f"keep, taken, h = {at(rows.KEEP)}, {at(rows.TAKEN)}, {at(rows.H)}"]
    for k in N:
        lines.append(f"a{k} = {at(rows.ACCELERATION, k)}")
        Z = [stage(rows.Z, s, k) for s in S]
        for j in S:
            lines += choose(stage(rows.D_PAST, j, k), f"({total(A_INVERSE[j], Z)}) / h - a{k}", "keep > 0.0")
    lines += choose(at(rows.D_SIZE), "1.0", "keep > 0.0")
    again = [f"taken, size = {at(rows.TAKEN)}, {at(rows.D_SIZE)}"]
    for k in N:
        for j in S:
            again += choose(stage(rows.D_PAST, j, k), f"{stage(rows.D_PAST, j, k)} * size", "taken > 0.0")
    new = [f"taken, later = {at(rows.TAKEN)}, {at(rows.LATER)}"]
    new += choose(at(rows.GROWN), f"0.0 - {at(rows.D_LOG)}", "taken > 0.0")
    new += choose(at(rows.D_LOG), "0.0", "taken > 0.0")
    for k in N:
        speed = f"{at(rows.Y, k)} + later * {at(rows.RATE, k)}"
        for row, value in ((rows.D_POSITION, speed), (rows.D_SPEED, at(rows.RATE_BEFORE, k))):
            new += choose(at(row, k), value, "taken > 0.0")
    return lanes(*lines) + lanes(*again) + lanes(*new)


def _remove(N: range) -> list[str]:
    pairs = [(rows.D_POSITION + k, rows.WEIGHT_POSITION + k) for k in N]
    pairs += [(rows.D_SPEED + k, rows.WEIGHT + k) for k in N]
    both = " + ".join(f"({at(row)} * {at(w)}) * ({of('other', row)} * {at(w)})" for row, w in pairs)
    lines = [f"along = {both}", f"along = along if {at(rows.TAKEN)} > 0.0 else 0.0"]
    places = [row for row, _ in pairs] + [rows.D_PAST + rows.N * j + k for j in S for k in N]
    return lanes(*lines, *(f"{at(row)} = {at(row)} - along * {of('other', row)}" for row in places))


def _shorten(N: range) -> list[str]:
    lines = [*_tangent(N), f"taken, size = {at(rows.TAKEN)}, sqrt({_size(N, 'd', 'v')})"]
    lines += ["factor = 1.0 / size if size > 0.0 else 0.0", "factor = factor if taken > 0.0 else 1.0"]
    places = [row + k for row in (rows.D_POSITION, rows.D_SPEED) for k in N]
    places += [rows.D_PAST + rows.N * j + k for j in S for k in N]
    lines += [f"{at(row)} = {at(row)} * factor" for row in places]
    lines += choose(at(rows.D_SIZE), "size", "taken > 0.0")
    lines += ["grown = log(size) if size > 0.0 else -inf"]
    for row in (rows.D_LOG, rows.GROWN):
        lines += choose(at(row), f"{at(row)} + grown", "taken > 0.0")
    return lanes(*lines)


def _complete() -> list[str]:
    lines = [
        f"gain, grown = {at(rows.GAIN)}, {at(rows.GROWN)}",
        f"damped = {at(rows.TAKEN)} if gain <= {RESOLVED!r} else 0.0",
        "damped = damped if grown > -inf else 0.0",  # its direction was lost
    ]
    lines += choose(at(rows.D_LOG), f"{at(rows.D_LOG)} + (gain - grown)", "damped > 0.0")
    longer = f"{at(rows.UNRESOLVED)} + {at(rows.SPAN)}"
    return lanes(*lines, *choose(at(rows.UNRESOLVED), longer, "damped > 0.0"))
