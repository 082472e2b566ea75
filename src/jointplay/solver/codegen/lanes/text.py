"""Lines of loops over eight lanes: where numbers lie, sums, choices.

What differs by lane is chosen, with both values loaded first, so that nothing is a branch; and no product
with a mask stands for a choice, since a finished lane's NaN would survive it.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from ...method.lanes import layout as rows
from ...method.lanes.radau import NODES, STAGES, A
from .. import source
from ..source import horner

SIN = [1.0, -1 / 6, 1 / 120, -1 / 5040]  # to rounding at usual lengths, to 1e-11 at the longest turn
LOOP = "for i in range(8):"
COS = [1.0, -1 / 2, 1 / 24, -1 / 720, 1 / 40320]


class Blocks(NamedTuple):
    """Rows of an unknown's stages: increments, these in the eigenbasis, rates times h, the last step's."""

    z: int
    w: int
    f: int
    past: int


STEP, TANGENT = (
    Blocks(rows.Z, rows.W, rows.F, rows.PAST),
    Blocks(rows.D_Z, rows.D_W, rows.D_F, rows.D_PAST),
)


def at(row: int, k: int = 0) -> str:
    """Lane i of a row, which may be a tangent's own."""
    return of("own", row, k) if row >= rows.OWN else f"w[{8 * (row + k)} + i]"


def of(array: str, row: int, k: int = 0) -> str:
    """Lane i of a tangent's own row."""
    return f"{array}[{8 * (row + k - rows.OWN)} + i]"


def stage(block: int, j: int, k: int) -> str:
    """Stage j of unknown k."""
    return at(block, rows.N * j + k)


def slope(k: int, i: int) -> str:
    """d rate k / d position i, or speed i - N."""
    return at(rows.JACOBIAN, 2 * rows.N * k + i)


def lanes(*lines: str) -> list[str]:
    """A loop over the lanes, in which `function` sees operations on whole rows."""
    return [f"    {LOOP}", *(f"        {line}" for line in lines)]


def total(factors: Iterable[float], names: Iterable[str]) -> str:
    """Sum of factor * name."""
    return " + ".join(f"{float(factor)!r} * {name}" for factor, name in zip(factors, names, strict=True))


def choose(place: str, value: str, condition: str) -> list[str]:
    """`place` becomes `value` in lanes where the condition holds."""
    return [f"old, value = {place}, {value}", f"{place} = value if {condition} else old"]


def rotation(s: str, c: str, k: int, d: str, phase: bool) -> list[str]:
    """Sine and cosine of angle k from the base point's, by `d`; a phase turns farther in a step."""
    sine, cosine = (source.SIN, source.COS) if phase else (SIN, COS)
    return [
        f"d = {d}",
        "dd = d * d",
        f"ds = d * ({horner(sine)})",
        f"dc = {horner(cosine)}",
        f"bs, bc = {at(rows.SINE, k)}, {at(rows.COSINE, k)}",
        f"{s}, {c} = bs * dc + bc * ds, bc * dc - bs * ds",
    ]


def moved(j: int, k: int, speed: str, of: Blocks = STEP) -> str:
    """Increment of position k at stage j, where its speed begins with `speed`."""
    gained = total(A[j], (stage(of.z, s, k) for s in range(STAGES)))
    return f"{at(rows.H)} * ({float(NODES[j])!r} * {speed} + {gained})"


def fetch(n: int, j: int, place: Callable[[int, int], str] = at) -> list[str]:
    """X and Y at stage j: increments of the positions, speeds; in their rows, or another `place`."""
    lines = []
    for k in range(n):
        lines.append(f"{place(rows.X, k)} = {moved(j, k, at(rows.SPEED, k))}")
        lines.append(f"{place(rows.Y, k)} = {at(rows.SPEED, k)} + {stage(rows.Z, j, k)}")
    return lines


def function(name: str, lines: list[str], head: str = "@compiled", arguments: str = "w") -> str:
    """A function that the loop calls; each of its loops over lanes is a function of its own."""
    loops, body, given = [], [], arguments.removesuffix(", j")
    for line in lines:
        indent = line[: len(line) - len(line.lstrip())]
        if line.strip() == LOOP:
            loops.append([indent])
            body.append(f"{indent}{name}_part{len(loops)}({given})")
        elif loops and len(indent) > len(loops[-1][0]) and body[-1].endswith(f"_part{len(loops)}({given})"):
            loops[-1].append(f"    {line.strip()}")
        else:
            body.append(line)
    heads = [f"def {name}_part{n + 1}({given}, i):" for n in range(len(loops))]
    texts = [["@lanewise", head, *loop[1:], "\n"] for head, loop in zip(heads, loops, strict=True)]
    return "\n".join([*(line for text in texts for line in text), head, f"def {name}({arguments}):", *body])
