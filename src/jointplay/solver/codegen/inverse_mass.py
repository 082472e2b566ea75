"""The mass matrix solved straight-line, and small systems."""

from sympy import Add, Expr, Integer

from ..equations.system import System
from .tape import Tape


class InverseMass:
    """M = L D L^T written out, zeros skipped; calling it substitutes. The identity without a mass."""

    def __init__(self, tape: Tape, system: System):
        self.tape, self.n = tape, len(system.speeds)
        self.entries = {
            place: tape.let("M_{}_{}".format(*place), m) for place, m in (system.mass or {}).items()
        }
        self.L: dict[tuple[int, int], Expr] = {}
        self.pivot: list[Expr] = [Integer(1)] * self.n
        rest = dict(self.entries)
        for j in range(self.n if rest else 0):
            self.pivot[j] = tape.let(f"iD_{j}", 1 / rest[j, j])
            below = [i for i in range(j + 1, self.n) if (i, j) in rest]
            for i in below:
                self.L[i, j] = tape.let(f"L_{i}_{j}", rest[i, j] * self.pivot[j])
            for i, k in ((i, k) for i in below for k in below if k <= i):
                rest[i, k] = tape.let(
                    f"M_{i}_{k}_{j}", rest.get((i, k), Integer(0)) - self.L[i, j] * rest[k, j]
                )
        if not rest and system.mass is None:
            self.entries = {(k, k): Integer(1) for k in range(self.n)}

    def __call__(self, b: list[Expr], name: str) -> list[Expr]:
        x: list[Expr] = []
        for i, value in enumerate(b):
            below = Add(*[factor * x[c] for (r, c), factor in self.L.items() if r == i])
            x.append(self.tape.let(f"{name}_f{i}", value - below))
        x = [value * pivot for value, pivot in zip(x, self.pivot, strict=True)]
        for i in reversed(range(self.n)):
            above = Add(*[factor * x[r] for (r, c), factor in self.L.items() if c == i])
            x[i] = self.tape.let(f"{name}_{i}", x[i] - above)
        return x


def dot(row: tuple[Expr, ...], x: list[Expr]) -> Expr:
    """Sum of products."""
    return Add(*[entry * value for entry, value in zip(row, x, strict=True)])


def eliminate(tape: Tape, matrix: list[list[Expr]], right: list[Expr], name: str) -> list[Expr]:
    """Solve a small system by elimination without pivoting (near positive definite, or unit rows)."""
    A, b = [list(row) for row in matrix], list(right)
    n = len(b)
    for j in range(n):
        for i in range(j + 1, n):
            factor = tape.let(f"{name}_m{i}{j}", A[i][j] / A[j][j])
            A[i] = [tape.let(f"{name}_A{i}{k}{j}", A[i][k] - factor * A[j][k]) for k in range(n)]
            b[i] = tape.let(f"{name}_b{i}{j}", b[i] - factor * b[j])
    for i in reversed(range(n)):
        b[i] = tape.let(f"{name}{i}", (b[i] - sum(A[i][k] * b[k] for k in range(i + 1, n))) / A[i][i])
    return b
