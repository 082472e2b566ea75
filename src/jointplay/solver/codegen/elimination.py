"""Plans of the sparse algebra: which entries Newton's matrix has, and the order of its elimination.

The Jacobian of a structure with many unknowns is written as that of the residual Q - M a (see
method.sparse). What can differ from zero is known from the expressions, so elimination and substitution are
worked out here, on symbols, once: without pivoting, in the order of the unknowns, which the equations choose
so that little is filled in (elastic modes first, then angles, then bases).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from sympy import Expr

from jointplay.solver.codegen.dynamics import Dynamics
from jointplay.solver.codegen.source import entry
from jointplay.solver.method.sparse import AHEAD, INVERSE, NOTHING

LARGEST_DENSE = 5  # unknowns up to which the algebra is written out (codegen.algebra)

Entry = tuple[int, int]


@dataclass
class Plan:
    """Places in the compact Jacobian (`values` by place) and operations on the lane buffer."""

    n: int
    values: list[Expr] = field(default_factory=list)
    mass: dict[Entry, int] = field(default_factory=dict)
    pull: dict[Entry, int] = field(default_factory=dict)
    rate: dict[Entry, int] = field(default_factory=dict)

    @classmethod
    def of(cls, dynamics: Dynamics) -> Plan:
        """The plan of a system solved in one variant."""
        plan = cls(len(dynamics.system.speeds))
        B_q, B_z = dynamics.residual_jacobian()
        for (i, j), value in dynamics.inverse_mass.entries.items():
            plan.mass[i, j] = plan.mass[j, i] = plan._place(value)
        plan.pull = {place: plan._place(value) for place, value in B_q.items()}
        plan.rate = {place: plan._place(value) for place, value in B_z.items()}
        return plan

    def _place(self, value: Expr) -> int:
        self.values.append(value)
        return len(self.values) - 1

    def filled(self) -> list[Entry]:
        """Entries of the factors."""
        found = {*self.mass, *self.pull, *self.rate}
        for j in range(self.n):
            below = [i for i in range(j + 1, self.n) if (i, j) in found]
            right = [i for i in range(j + 1, self.n) if (j, i) in found]
            found |= {(r, k) for r in below for k in right}
        return sorted(found)

    @property
    def rows(self) -> int:
        """Rows of the lane buffer that the algebra takes."""
        return 3 * self.n + AHEAD + len(self.filled())

    def lists(self) -> dict[str, list[int]]:
        """The integers that method.sparse works by."""
        E = {place: 8 * (3 * self.n + AHEAD + k) for k, place in enumerate(self.filled())}
        X = [8 * (2 * self.n + r) for r in range(self.n)]
        given = [(E[p], *(d.get(p, -1) for d in (self.mass, self.rate, self.pull))) for p in E]
        return {
            "entries": _flat(given),
            "eliminate": _flat(self._elimination(E)),
            "solve": _flat(self._substitution(E, X)),
            "masses": _flat(self._weighing()),
            "pulls": _flat((*place, at) for place, at in sorted(self.pull.items())),
            "rates": _flat((*place, at) for place, at in sorted(self.rate.items())),
        }

    def _elimination(self, E: dict[Entry, int]) -> Iterator[list[int]]:
        """Row by row: E_rk less the sum of E_rj E_jk, and below the diagonal times the pivot's inverse."""
        for r, k in sorted(E):
            pairs = [E[p] for j in range(min(r, k)) if (r, j) in E and (j, k) in E for p in ((r, j), (j, k))]
            then = E[k, k] if k < r else INVERSE if k == r else NOTHING
            yield [E[r, k], len(pairs) // 2, then, *pairs]

    def _substitution(self, E: dict[Entry, int], X: list[int]) -> Iterator[list[int]]:
        """Forward with unit diagonal, then backward."""
        for r in range(self.n):
            pairs = [at for j in range(r) if (r, j) in E for at in (E[r, j], X[j])]
            yield [X[r], len(pairs) // 2, NOTHING, *pairs]
        for r in reversed(range(self.n)):
            pairs = [at for j in range(r + 1, self.n) if (r, j) in E for at in (E[r, j], X[j])]
            yield [X[r], len(pairs) // 2, E[r, r], *pairs]

    def _weighing(self) -> Iterator[list[int]]:
        """Rows of M: number of entries, then of each its place in J and that of R's row in the buffer."""
        for r in range(self.n):
            row = [(at, 8 * (self.n + j)) for (i, j), at in sorted(self.mass.items()) if i == r]
            yield [len(row), *(value for pair in row for value in pair)]


def _flat(rows: Iterable[Iterable[int]]) -> list[int]:
    return [int(value) for row in rows for value in row]


HEADER = """
from numpy import array, int64

from jointplay.solver.method import sparse
"""
CALLS = {  # arguments of each function, and what its method.sparse namesake takes; # is the variant
    "extrapolate": ("w, source, start, ratio", "w, source, start, ratio, SIZE"),
    "rest": ("w", "w, SIZE"),
    "move": ("w, s, h", "w, s, h, SIZE"),
    "factor": ("variant, w, J, h", "w, J, h, SIZE, ENTRIES_#, ELIMINATE_#"),
    "linearised": ("variant, J, out", "J, out, SIZE, MASSES_#, RATES_#, PULLS_#"),
    "newton": ("variant, w, s, J, weight, h", "w, s, J, weight, h, SIZE, MASSES_#, SOLVE_#"),
    "estimate": (
        "variant, w, J, weight, error, h",
        "w, J, weight, error, h, SIZE, MASSES_#, PULLS_#, SOLVE_#",
    ),
}


def text(plans: list[Plan], n_q: int, first: int) -> str:
    """Source of the algebra's functions for the plans of the variants, `first` the lane row of time."""
    # Numbers in arrays: an integer written out in a call would compile a version for itself (see interface).
    parts = [HEADER, f"SIZE = array({[n_q, plans[0].n, first]!r}, dtype=int64)"]
    for v, plan in enumerate(plans):
        lists = plan.lists().items()
        parts += [f"{name.upper()}_{v} = array({values!r}, dtype=int64)" for name, values in lists]
    for name, (arguments, passed) in CALLS.items():
        parts += ["", "", *entry(name, arguments)]
        for v in range(1, len(plans) if "#" in passed else 1):
            call = f"sparse.{name}({passed.replace('#', str(v))})"
            parts += [f"    if variant == {v}:", f"        return {call}"]
        parts.append(f"    return sparse.{name}({passed.replace('#', '0')})")
    return "\n".join(parts) + "\n"
