"""The method's algebra for given sizes, written out: straight-line bodies in one loop over lanes.

The step (method.step) says what is done; here its sums over stages, its small complex systems and its
norms are unrolled for n_q positions and n speeds, because loops whose bounds are not constants do not
vectorise. The text depends on the two sizes alone, so all structures of a size share one module. Lanes and
constants are those of method.radau.

    extrapolate(w, source, start, ratio)   stage increments from the polynomial in `source`
    rest(w)                                no change of the speeds
    move(w, s, h)                          increments of time and positions from those of the speeds
    factor(variant, w, J, h)               L U of (lambda/h) I - J_z - (h/lambda) J_q in four lanes
    newton(variant, w, s, J, weight, h)    one Newton update; its size
    estimate(variant, w, J, weight, error, h)  error estimate; its size
    linearised(variant, J, out)            J itself, which a plan's algebra has to work out (method.sparse)

Everything that a lane loop writes lies in the one buffer `w` (a loop of eight turns is not vectorised if it
takes a check that two arrays do not overlap): first the method's rows, then the structure's. A complex
number is eight doubles: four real parts (lane 0 is the real eigenvalue's), four imaginary parts.
"""

from ..method.memory import method_rows
from .source import entry

HEADER = '''"""Generated for {n_q} positions and {n} speeds; do not edit."""
from math import sqrt

from jointplay.solver.method.interface import compiled
from jointplay.solver.method.polynomial import BARYCENTRIC
from jointplay.solver.method.radau import EIGEN_IM, EIGEN_RE, ERROR, GAMMA, NODES
from jointplay.solver.method.radau import TO_EIGEN, TO_MOVED, TO_STAGE

'''

REAL_LANES = (0, 1, 2, 3, 5, 6, 7)  # of the eigenbasis: lane 4 is empty


class Rows:
    """Rows of the lane buffer for n_q positions and n speeds; the first blocks are in the eigenbasis."""

    def __init__(self, n_q: int, n: int) -> None:
        self.n_q, self.n, self.time = n_q, n, method_rows(n)
        # stage increments of the speeds, their rates, Newton's update and its squared size by lane
        self.W, self.R, self.X, self.squares = range(n), range(n, 2 * n), range(2 * n, 3 * n), 3 * n
        self.state = range(self.time + 1, self.time + 1 + n_q + n)
        self.speeds = self.state[n_q:]
        self.rate = range(self.state.stop, self.state.stop + n)

    def E(self, k: int, j: int) -> int:
        """Entry of the factored matrices."""
        return 3 * self.n + 1 + k * self.n + j


def text(n_q: int, n: int) -> str:
    """Source of the module for n_q positions and n speeds."""
    rows = Rows(n_q, n)
    parts = [part(rows) for part in (_extrapolate, _rest, _move, _factor, _newton, _estimate, _linearised)]
    return HEADER.format(n_q=n_q, n=n) + "\n\n".join(parts)


def _function(name: str, arguments: str, *blocks: list[str]) -> str:
    return "\n".join([*entry(name, arguments), *(f"    {line}" for block in blocks for line in block)]) + "\n"


def _lanes(count: int, body: list[str]) -> list[str]:
    return [f"for i in range({count}):", *(f"    {line}" for line in body)]


def _at(row: int, half: int = 0) -> str:
    """Lane i of a row; `half` 4 is the imaginary part."""
    return f"w[{8 * row + half} + i]"


def _load(name: str, array: str, rows, columns) -> list[str]:
    """Scalars name_r_j = array[8 row + j], r counted from 0."""
    return [f"{name}_{r}_{j} = {array}[{8 * row + j}]" for r, row in enumerate(rows) for j in columns]


def _mapped(name: str, r: int, matrix: str, columns) -> str:
    """Lane i of a lane-to-lane matrix times the scalars name_r_j."""
    return " + ".join(f"{name}_{r}_{j} * {matrix}[{8 * j} + i]" for j in columns)


def _extrapolate(rows: Rows) -> str:
    """Lagrange basis at start + ratio c_i by products from both sides; then to the eigenbasis."""
    body = ["x = start + ratio * NODES[i]", "l0 = 1.0"]
    body += [f"l{j + 1} = l{j} * (x - NODES[{j}])" for j in range(7)]
    body += ["r = 1.0"]
    for j in range(7, -1, -1):
        body += [f"l{j} = l{j} * r * BARYCENTRIC[{j}]", f"r = r * (x - NODES[{j}])"]
    for r, row in enumerate(rows.speeds):
        value = " + ".join(f"z_{r}_{j} * l{j}" for j in range(7))
        body.append(f"{_at(row)} = {value} - begin * z_{r}_6")
    eigen = [f"{_at(row)} = {_mapped('y', r, 'TO_EIGEN', range(7))}" for r, row in enumerate(rows.W)]
    return _function(
        "extrapolate",
        "w, source, start, ratio",
        ["begin = 1.0 if start == 1.0 else 0.0"],
        _load("z", "source", range(rows.n_q, rows.n_q + rows.n), range(7)),
        _lanes(8, body),
        _load("y", "w", rows.speeds, range(7)),
        _lanes(8, eigen),
    )


def _rest(rows: Rows) -> str:
    return _function("rest", "w", _lanes(8, [f"{_at(row)} = 0.0" for row in (*rows.speeds, *rows.W)]))


def _moved(rows: Rows) -> list[str]:
    """Body lines: time and positions."""
    lines = [f"{_at(rows.time)} = h * NODES[i]"]
    for r in range(rows.n_q):
        lines.append(
            f"{_at(rows.state[r])} = h * (NODES[i] * v_{r} + {_mapped('W', r, 'TO_MOVED', REAL_LANES)})"
        )
    return lines


def _move(rows: Rows) -> str:
    speeds = [f"v_{r} = s[{1 + rows.n_q + r}]" for r in range(rows.n_q)]
    return _function(
        "move", "w, s, h", speeds, _load("W", "w", range(rows.n_q), REAL_LANES), _lanes(8, _moved(rows))
    )


def _factor(rows: Rows) -> str:
    """Elimination without pivoting; the inverse of each pivot stays on the diagonal."""
    n_q, n, width = rows.n_q, rows.n, rows.n_q + rows.n
    head = [f"J_{k}_{i} = J[{k * width + i}]" for k in range(n) for i in range(width)]
    body = ["size = 1.0 / (EIGEN_RE[i] * EIGEN_RE[i] + EIGEN_IM[i] * EIGEN_IM[i])"]
    body += [
        "re, im = EIGEN_RE[i] / h, EIGEN_IM[i] / h",
        "qr, qi = h * EIGEN_RE[i] * size, h * EIGEN_IM[i] * size",
    ]
    for k, j in ((k, j) for k in range(n) for j in range(n)):
        real, imaginary = (["re"], ["im"]) if j == k else ([], [])
        real.append(f"- J_{k}_{n_q + j}")
        if j < n_q:
            real.append(f"- qr * J_{k}_{j}")
            imaginary.append(f"+ qi * J_{k}_{j}")
        body += [f"x{k}_{j} = {' '.join(real)}", f"y{k}_{j} = {' '.join(imaginary) or '0.0'}"]
    body += _eliminated(n)
    for k, j in ((k, j) for k in range(n) for j in range(n)):
        body += [f"{_at(rows.E(k, j))} = x{k}_{j}", f"{_at(rows.E(k, j), 4)} = y{k}_{j}"]
    return _function("factor", "variant, w, J, h", head, _lanes(4, body))


def _eliminated(n: int) -> list[str]:
    """Body lines: L U of the n by n complex x + iy."""
    body = []
    for j in range(n):
        body += [f"d = 1.0 / (x{j}_{j} * x{j}_{j} + y{j}_{j} * y{j}_{j})"]
        body += [f"x{j}_{j} = x{j}_{j} * d", f"y{j}_{j} = -y{j}_{j} * d"]
        for r in range(j + 1, n):
            body += _times(f"x{r}_{j}", f"y{r}_{j}", f"x{j}_{j}", f"y{j}_{j}")
            for k in range(j + 1, n):
                body += _less(f"x{r}_{k}", f"y{r}_{k}", f"x{r}_{j}", f"y{r}_{j}", f"x{j}_{k}", f"y{j}_{k}")
    return body


def _times(a: str, b: str, c: str, d: str) -> list[str]:
    """(a + ib) *= (c + id)."""
    return [f"t = {a} * {c} - {b} * {d}", f"{b} = {a} * {d} + {b} * {c}", f"{a} = t"]


def _less(a: str, b: str, c: str, d: str, e: str, f: str) -> list[str]:
    """(a + ib) -= (c + id) (e + if)."""
    return [f"{a} = {a} - ({c} * {e} - {d} * {f})", f"{b} = {b} - ({c} * {f} + {d} * {e})"]


def _substitution(rows: Rows) -> list[str]:
    """Body lines: X = E^-1 (R - (lambda/h) W) in four complex lanes."""
    n, lines = rows.n, ["re, im = EIGEN_RE[i] / h, EIGEN_IM[i] / h"]
    for r in range(n):
        W = _at(rows.W[r]), _at(rows.W[r], 4)
        lines += [f"x{r} = {_at(rows.R[r])} - (re * {W[0]} - im * {W[1]})"]
        lines += [f"y{r} = {_at(rows.R[r], 4)} - (re * {W[1]} + im * {W[0]})"]
    order = [(r, range(r)) for r in range(n)] + [(r, range(r + 1, n)) for r in reversed(range(n))]
    for step, (r, others) in enumerate(order):
        for j in others:
            lines += _less(f"x{r}", f"y{r}", _at(rows.E(r, j)), _at(rows.E(r, j), 4), f"x{j}", f"y{j}")
        if step >= n:
            lines += _times(f"x{r}", f"y{r}", _at(rows.E(r, r)), _at(rows.E(r, r), 4))
    for r in range(n):
        lines += [f"{_at(rows.X[r])} = x{r}", f"{_at(rows.X[r], 4)} = y{r}"]
    return lines


def _newton(rows: Rows) -> str:
    n_q, n = rows.n_q, rows.n
    eigen = [f"{_at(row)} = {_mapped('F', r, 'TO_EIGEN', range(7))}" for r, row in enumerate(rows.R)]
    head = [f"v_{r} = s[{1 + n_q + r}]" for r in range(n_q)] + [f"g{r} = weight[{n_q + r}]" for r in range(n)]
    sums = [f"W_{r}_{j} = w[{8 * rows.W[r] + j}] + X_{r}_{j}" for r in range(n_q) for j in REAL_LANES]
    body = [f"z{r} = {_mapped('X', r, 'TO_STAGE', REAL_LANES)}" for r in range(n)]
    body += [f"{_at(row)} += z{r}" for r, row in enumerate(rows.speeds)]
    body += [f"{_at(rows.W[r])} += {_at(rows.X[r])}" for r in range(n)]
    body += [f"z{r} = z{r} * g{r}" for r in range(n)]
    body += [f"{_at(rows.squares)} = " + " + ".join(f"z{r} * z{r}" for r in range(n)), *_moved(rows)]
    total = " + ".join(f"w[{8 * rows.squares + j}]" for j in range(7))
    return _function(
        "newton",
        "variant, w, s, J, weight, h",
        _load("F", "w", rows.rate, range(7)),
        _lanes(8, eigen),
        _lanes(4, _substitution(rows)),
        _load("X", "w", rows.X, REAL_LANES),
        sums + head,
        _lanes(8, body),
        [f"return sqrt(({total}) / {7 * n}.0)"],
    )


def _estimate(rows: Rows) -> str:
    """Error = (I - span J)^-1 (error + sum e_i Z_i), where `error` comes in as f at the base point."""
    n_q, n, width = rows.n_q, rows.n, rows.n_q + rows.n
    body = ["span = h / GAMMA"]
    for r, row in enumerate(rows.state):
        stages = " + ".join(f"ERROR[{i}] * w[{8 * row + i}]" for i in range(7))
        body.append(f"e{r} = span * error[{r}] + {stages}")
    for k in range(n):
        pulled = "".join(f" + J[{k * width + j}] * e{j}" for j in range(n_q))
        body.append(f"x{k} = e{n_q + k} / span{pulled}")
    for r in range(n):
        body += [f"x{r} -= w[{8 * rows.E(r, j)}] * x{j}" for j in range(r)]
    for r in reversed(range(n)):
        body += [f"x{r} -= w[{8 * rows.E(r, j)}] * x{j}" for j in range(r + 1, n)]
        body += [f"x{r} *= w[{8 * rows.E(r, r)}]"]
    body += [f"error[{r}] = e{r} + span * x{r}" for r in range(n_q)]
    body += [f"error[{n_q + r}] = x{r}" for r in range(n)]
    total = " + ".join(f"(error[{r}] * weight[{r}]) ** 2" for r in range(width))
    return _function(
        "estimate", "variant, w, J, weight, error, h", body, [f"return sqrt(({total}) / {width}.0)"]
    )


def _linearised(rows: Rows) -> str:
    body = [f"for i in range({rows.n * (rows.n_q + rows.n)}):", "    out[i] = J[i]"]
    return _function("linearised", "variant, J, out", body)
