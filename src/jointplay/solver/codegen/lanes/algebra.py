"""The method for eight trajectories at once, written out: one text for structures of one size.

    predict(w)   stages from the last step's polynomial, or as they are where an iteration goes on; X and Y
                 at the late stage
    factor(w)    inverses of lambda I - h J_z - (h^2/lambda) J_q, the real one and the complex ones
    solve(w)     one update of Newton's iteration in the eigenbasis
    judge(w)     error, guards, section; which lanes may go on plainly
    settle(w)    the next length, and the new base point where a step is TAKEN

Rows: method.lanes.layout. Reference: Hairer and Wanner, Solving Ordinary Differential Equations II,
section IV.8.
"""

from ...method.lanes import layout as rows
from ...method.lanes.radau import EIGEN, GAMMA, LATE, MONOMIAL, NODES, STAGES, TO_EIGEN, TO_STAGE
from .control import Turning, free, judge, settle
from .text import STEP, Blocks, at, fetch, function, lanes, slope, stage, total

HEADER = '''"""Generated: the method for eight trajectories at once; do not edit."""
from math import sqrt

from jointplay.solver.method.control import bounded
from jointplay.solver.method.lanes.attempts import solved
from jointplay.solver.method.events import level_of
from jointplay.solver.method.interface import compiled
from jointplay.solver.method.lanes.lanewise import lanewise

'''
S = range(STAGES)


def text(turning: Turning, contacts: int, jumps: int = 0, folds: int = 0, crank: int = 0) -> str:
    """Source of the module: turning positions, and the cut one; counts of contacts, jumps, loops (folds)."""
    N = range(len(turning))
    late, size = lanes(*fetch(len(N), LATE)), lanes(*_size(N, free(turning)))
    parts = {"predict": predict(N) + late, "factor": _factor(N), "solve": solve(N) + size}
    parts |= {"judge": judge(turning, contacts, jumps, folds, crank)}
    parts |= {"settle": settle(turning, contacts, jumps, folds)}
    return HEADER + "\n\n" + "\n\n\n".join(function(*part) for part in parts.items()) + "\n"


def predict(
    N: range, of: Blocks = STEP, smooth: str = at(rows.SMOOTH), kept: str = at(rows.CONTINUES)
) -> list[str]:
    """The last step's polynomial beyond its end (OFFSET 1), or within it (0); else no change.

    Nothing changes either where not all was `smooth`; what is `kept` (1) stays as it is.
    """
    out = []
    for k in N:
        lines = [f"p{j} = {stage(of.past, j, k)}" for j in S]
        lines += [f"m{n} = {total(MONOMIAL[n], (f'p{j}' for j in S))}" for n in S]
        lines += [f"ratio, off = {at(rows.H)} / {at(rows.H_PAST)}, {at(rows.OFFSET)}"]
        for j in S:
            value = f"m{STAGES - 1}"
            for n in reversed(S[:-1]):
                value = f"m{n} + x * ({value})"
            lines += [f"x = {float(NODES[j])!r} * ratio + off", f"new = x * ({value}) - off * p{STAGES - 1}"]
            lines += [f"new = new if {smooth} > 0.0 else 0.0", f"old = {stage(of.z, j, k)}"]
            lines += [f"z{j} = old if {kept} > 0.0 else new", f"{stage(of.z, j, k)} = z{j}"]
        names = [f"z{j}" for j in S]
        lines += [f"{stage(of.w, j, k)} = {total(TO_EIGEN[j], names)}" for j in S]
        out += lanes(*lines)
    return out


def _entries(N: range) -> list[str]:
    """h J_z and h^2 J_q."""
    lines = [f"h = {at(rows.H)}"]
    for k in N:
        for j in N:
            lines += [
                f"q{k}{j} = h * h * {slope(k, j)}",
                f"v{k}{j} = h * {slope(k, rows.N + j)}",
            ]
    return lines


def _minor(i: int, j: int) -> tuple[list[int], list[int]]:
    """Rows and columns of the signed minor that entry (i, j) of the adjugate of three by three is."""
    rows, columns = [x for x in range(3) if x != j], [x for x in range(3) if x != i]
    return rows, (columns if (i + j) % 2 == 0 else columns[::-1])


def _factor(N: range) -> list[str]:
    """Inverses of the real matrix and of the complex ones: of three unknowns by cofactors."""
    lines = _entries(N)
    for k in N:
        for j in N:
            diagonal = f"{GAMMA!r} " if k == j else ""
            lines.append(f"e{k}{j} = {diagonal}- v{k}{j} - {1 / GAMMA!r} * q{k}{j}")
    if len(N) == 3:
        for i in N:
            for j in N:
                (a, b), (c, d) = _minor(i, j)
                lines.append(f"a{i}{j} = e{a}{c} * e{b}{d} - e{a}{d} * e{b}{c}")
        lines.append("det = 1.0 / (" + " + ".join(f"e0{k} * a{k}0" for k in N) + ")")
        lines += [f"{at(rows.INVERSE, _place(i, j))} = a{i}{j} * det" for i in N for j in N]
    else:
        names, more = _eliminated(N)
        lines += more + [f"{at(rows.INVERSE, _place(i, j))} = {names[i, j]}" for i in N for j in N]
    out = lanes(*lines)
    for n, (re, im) in enumerate(EIGEN[1:]):
        out += lanes(*_entries(N), *_complex(N, n, re, im))
    return out


def _place(i: int, j: int) -> int:
    """Place of an entry of an inverse."""
    return rows.N * i + j


def _eliminated(N: range) -> tuple[dict[tuple[int, int], str], list[str]]:
    """The inverse of e by elimination without pivoting: names of its entries, and the lines for them."""
    names, lines = {(i, j): f"e{i}{j}" for i in N for j in N}, []

    def let(place: tuple[int, int], value: str) -> None:
        name = f"i{k}_{place[0]}{place[1]}"
        lines.append(f"{name} = {value}")
        new[place] = name

    for k in N:
        new: dict[tuple[int, int], str] = {}
        let((k, k), f"1.0 / {names[k, k]}")
        for j in (j for j in N if j != k):
            let((k, j), f"{names[k, j]} * {new[k, k]}")
        for i in (i for i in N if i != k):
            let((i, k), f"- {names[i, k]} * {new[k, k]}")
            for j in (j for j in N if j != k):
                let((i, j), f"{names[i, j]} - {names[i, k]} * {new[k, j]}")
        names = new
    return names, lines


def _times(a: str, b: str) -> tuple[str, str]:
    """Real and imaginary part of a product."""
    return f"{a}r * {b}r - {a}i * {b}i", f"{a}r * {b}i + {a}i * {b}r"


def _complex(N: range, n: int, re: float, im: float) -> list[str]:
    """The inverse for the pair of eigenvalues re +- i im."""
    lines, size = [], re * re + im * im
    for k in N:
        for j in N:
            real, imaginary = (f"{re!r} ", f"{im!r} + ") if k == j else ("", "")
            lines += [
                f"e{k}{j}r = {real}- v{k}{j} - {re / size!r} * q{k}{j}",
                f"e{k}{j}i = {imaginary}{im / size!r} * q{k}{j}",
            ]
    found, more = _cofactors() if len(N) == 3 else _complex_elimination(N)
    lines += more
    for i in N:
        for j in N:
            lines += [f"{_pair_at(n, i, j, p)} = {value}" for p, value in enumerate(found[i, j])]
    return lines


def _pair_at(n: int, i: int, j: int, part: int) -> str:
    """Real or imaginary part of an entry of the inverse of the n-th pair."""
    return at(rows.PAIRS + 2 * (rows.N * rows.N * n + _place(i, j)) + part)


def _cofactors() -> tuple[dict[tuple[int, int], tuple[str, str]], list[str]]:
    """The inverse of the complex e of three by three."""
    lines, N = [], range(3)
    for i in N:
        for j in N:
            (a, b), (c, d) = _minor(i, j)
            first, second = _times(f"e{a}{c}", f"e{b}{d}"), _times(f"e{a}{d}", f"e{b}{c}")
            lines += [f"a{i}{j}{part} = {x} - ({y})" for part, x, y in zip("ri", first, second, strict=True)]
    terms = [_times(f"e0{k}", f"a{k}0") for k in N]
    lines += [f"d{part} = " + " + ".join(f"({term[p]})" for term in terms) for p, part in enumerate("ri")]
    lines += ["size = 1.0 / (dr * dr + di * di)", "dr, di = dr * size, - di * size"]
    return {(i, j): _times(f"a{i}{j}", "d") for i in N for j in N}, lines


def _complex_elimination(N: range) -> tuple[dict[tuple[int, int], tuple[str, str]], list[str]]:
    """The inverse of the complex e by elimination, as `_eliminated`."""
    names, lines = {(i, j): f"e{i}{j}" for i in N for j in N}, []

    def let(place: tuple[int, int], values: tuple[str, str]) -> None:
        new[place] = f"i{k}_{place[0]}{place[1]}"
        lines.extend(f"{new[place]}{part} = {value}" for part, value in zip("ri", values, strict=True))

    for k in N:
        new: dict[tuple[int, int], str] = {}
        d = names[k, k]
        lines.append(f"size{k} = 1.0 / ({d}r * {d}r + {d}i * {d}i)")
        let((k, k), (f"{d}r * size{k}", f"- {d}i * size{k}"))
        for j in (j for j in N if j != k):
            let((k, j), _times(names[k, j], new[k, k]))
        for i in (i for i in N if i != k):
            x, y = _times(names[i, k], new[k, k])
            let((i, k), (f"- ({x})", f"- ({y})"))
            for j in (j for j in N if j != k):
                x, y = _times(names[i, k], new[k, j])
                let((i, j), (f"{names[i, j]}r - ({x})", f"{names[i, j]}i - ({y})"))
        names = new
    return {place: (f"{name}r", f"{name}i") for place, name in names.items()}, lines


def solve(N: range, of: Blocks = STEP, active: str = "") -> list[str]:
    """Residuals in the eigenbasis (in the place of F), the three systems, the update (where `active`)."""
    out = [line for k in N for line in lanes(*_residual(k, of))]
    real = [f"r{k} = {stage(of.f, 0, k)}" for k in N]
    for k in N:
        row = " + ".join(f"{at(rows.INVERSE, _place(k, j))} * r{j}" for j in N)
        real.append(f"{stage(of.f, 0, k)} = {row}")
    out += lanes(*real, *_pair(N, 0, of)) + lanes(*_pair(N, 1, of))
    return out + [line for k in N for line in lanes(*_updated(k, of, active))]


def _residual(k: int, of: Blocks) -> list[str]:
    """T F - Lambda W of unknown k, T the way to the eigenbasis."""
    F = [f"f{j}" for j in S]
    lines = [f"f{j} = {stage(of.f, j, k)}" for j in S] + [f"w{j} = {stage(of.w, j, k)}" for j in S]
    sums = [total(TO_EIGEN[j], F) for j in S]
    lines.append(f"{stage(of.f, 0, k)} = {sums[0]} - {GAMMA!r} * w0")
    for n, (re, im) in enumerate(EIGEN[1:]):
        a, b = 1 + 2 * n, 2 + 2 * n
        lines.append(f"{stage(of.f, a, k)} = {sums[a]} - {re!r} * w{a} + {im!r} * w{b}")
        lines.append(f"{stage(of.f, b, k)} = {sums[b]} - {re!r} * w{b} - {im!r} * w{a}")
    return lines


def _pair(N: range, n: int, of: Blocks) -> list[str]:
    """One complex system."""
    a, b = 1 + 2 * n, 2 + 2 * n
    lines = [f"r{k}, i{k} = {stage(of.f, a, k)}, {stage(of.f, b, k)}" for k in N]
    for k in N:
        row = [[_pair_at(n, k, j, part) for part in (0, 1)] for j in N]
        real = " + ".join(f"{c} * r{j} - {s} * i{j}" for j, (c, s) in enumerate(row))
        imaginary = " + ".join(f"{c} * i{j} + {s} * r{j}" for j, (c, s) in enumerate(row))
        lines += [f"{stage(of.f, a, k)} = {real}", f"{stage(of.f, b, k)} = {imaginary}"]
    return lines


def _updated(k: int, of: Blocks, active: str) -> list[str]:
    """W and Z of unknown k after the update, which stays in the place of F, by stages."""
    lines = [f"d{j} = {stage(of.f, j, k)}" for j in S]
    lines += [f"d{j} = d{j} if {active} > 0.0 else 0.0" for j in S if active]
    lines += [f"{stage(of.w, j, k)} = {stage(of.w, j, k)} + d{j}" for j in S]
    lines += [f"u{j} = {total(TO_STAGE[j], (f'd{n}' for n in S))}" for j in S]
    lines += [f"{stage(of.z, j, k)} = {stage(of.z, j, k)} + u{j}" for j in S]
    return [*lines, *(f"{stage(of.f, j, k)} = u{j}" for j in S)]


def _size(N: range, count: int) -> list[str]:
    """Size of the update in units of the tolerated error, of which so many are free."""
    lines = []
    for k in N:
        squares = " + ".join(f"{stage(rows.F, j, k)} * {stage(rows.F, j, k)}" for j in S)
        lines.append(f"e = {at(rows.FLOOR, k)} + {at(rows.TOLERANCE)} * abs({at(rows.SPEED, k)})")
        lines.append(f"n{k} = ({squares}) / (e * e)")
    mean = f"({' + '.join(f'n{k}' for k in N)}) * {1 / (count * STAGES)!r}"
    return [*lines, f"{at(rows.SIZE_BEFORE)} = {at(rows.SIZE)}", f"{at(rows.SIZE)} = sqrt({mean})"]
