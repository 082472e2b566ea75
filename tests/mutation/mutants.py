"""Lines broken on purpose: which there are, a fair draw of them, and a source file with one of them in it.

The operators are Cosmic Ray's, without those whose mutants hardly run at all (a shift in place of a sum), and
one more that leaves a statement out. What stands in annotations is let alone: nothing runs it.
"""

from __future__ import annotations

import ast
import random
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import ndiff
from itertools import chain
from pathlib import Path

import parso
from cosmic_ray.ast import Visitor, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator

SWAPS = {
    "ReplaceBinaryOperator": [
        "Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_FloorDiv", "Pow_Mul", "BitOr_BitAnd",
        "BitAnd_BitOr", "BitXor_BitAnd", "LShift_RShift", "RShift_LShift",
    ],
    "ReplaceComparisonOperator": [
        "Eq_NotEq", "NotEq_Eq", "Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt",
        "GtE_Lt", "Is_IsNot", "IsNot_Is",
    ],
    "ReplaceUnaryOperator": ["Delete_USub", "Delete_Not", "Delete_Invert"],
}  # fmt: skip
OTHERS = [
    "AddNot", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ExceptionReplacer", "NumberReplacer",
    "RemoveDecorator", "ZeroIterationForLoop",
]  # fmt: skip


class LeaveOut(Operator):
    """Leaves out a call, a raise, or what is added or written to a part of something."""

    def mutation_positions(self, node):
        if node.type == "simple_stmt" and self._acts(node.children[0]):
            yield node.start_pos, node.end_pos

    @staticmethod
    def _acts(node):
        if node.type == "expr_stmt":
            target, sign = node.children[:2]
            return target.type == "atom_expr" or (sign.type == "operator" and sign.value != "=")
        return node.type in ("raise_stmt", "atom_expr")

    def mutate(self, node, index):
        first, last = node.get_first_leaf(), node.get_last_leaf()
        return parso.parse(f"{first.prefix}pass{last.prefix}\n")

    @classmethod
    def examples(cls):
        return ()


OPERATORS = {
    name: get_operator(f"core/{name}")()
    for name in chain((f"{kind}_{swap}" for kind, swaps in SWAPS.items() for swap in swaps), OTHERS)
} | {"LeaveOut": LeaveOut()}


@dataclass(frozen=True)
class Mutant:
    """A line of a file before and after; `occurrence` counts the places where the operator fits."""

    file: str
    line: int
    operator: str
    occurrence: int
    before: str
    after: str


class _Places(Visitor):
    """First lines of the places where an operator fits, in the order in which it counts them."""

    def __init__(self, operator):
        self.operator, self.found = operator, []

    def visit(self, node):
        self.found += [start for start, _ in self.operator.mutation_positions(node)]
        return node


def places(source: str, operators: Iterable[str] = OPERATORS) -> dict[int, list[tuple[str, int]]]:
    """Operators and occurrences by line."""
    tree, idle = get_ast(source), annotated(source)
    found = defaultdict(list)
    for name in operators:
        visitor = _Places(OPERATORS[name])
        visitor.walk(tree)
        for occurrence, start in enumerate(visitor.found):
            if not any(first <= start < last for first, last in idle):
                found[start[0]].append((name, occurrence))
    return found


def annotated(source: str) -> list[tuple]:
    """Spans of the annotations."""
    spans = []
    for node in ast.walk(ast.parse(source)):
        for name in ("annotation", "returns"):
            if part := getattr(node, name, None):
                spans.append(((part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset)))
    return spans


def mutated(source: str, operator: str, occurrence: int) -> str | None:
    """The source with one place changed; None where there is no such place or the change says nothing."""
    changed = mutate_code(source, OPERATORS[operator], occurrence)
    if changed is None or _parsed(changed) in (None, _parsed(source)):
        return None
    return changed


def _parsed(source):
    try:
        return ast.dump(ast.parse(source))
    except SyntaxError:
        return None


def described(file: str, source: str, operator: str, occurrence: int) -> Mutant | None:
    """A mutant with the line that it changes."""
    changed = mutated(source, operator, occurrence)
    if changed is None:
        return None
    lines, number = {"-": [], "+": []}, 0
    for row in ndiff(source.splitlines(), changed.splitlines()):
        if row[0] in lines:
            lines[row[0]].append(row[2:].strip())
        number += row[0] in "- " and not lines["-"]
    before, after = (" ".join(lines[sign]) for sign in "-+")
    return Mutant(file, number + 1, operator, occurrence, before, after)


def found_again(mutant: Mutant, source: str) -> str | None:
    """The source with a mutant that an earlier version was drawn with; None where its line is no more.

    Lines that begin as the one before are tried first: to look at a place takes a tenth of a second.
    """
    lines = enumerate(map(str.strip, source.splitlines()), 1)
    alike = {number for number, text in lines if text and mutant.before.lstrip().startswith(text)}
    if not alike:
        return None
    found = places(source, [mutant.operator]).items()
    near = sorted(found, key=lambda item: (item[0] not in alike, abs(item[0] - mutant.line)))
    for operator, occurrence in chain.from_iterable(ways for _, ways in near):
        other = described(mutant.file, source, operator, occurrence)
        if other and (other.before, other.after) == (mutant.before, mutant.after):
            return mutated(source, operator, occurrence)
    return None


def room(file: Path, sources: Path) -> str:
    """The room that a file belongs to, those of the solver by themselves; another package is one."""
    package, *inside = (part for part in file.relative_to(sources).parts if part != "solver")
    return inside[0] if package == "jointplay" and len(inside) > 1 else package


def draw(sources: Path, size: int, seed: int, within: Iterable[Path] = ()) -> list[Mutant]:
    """Draw lines from every room in proportion to its length, and of each line one mutant.

    `within` are files and folders to draw from in place of the sources; each is a room of its own then.
    Whichever number of them is taken from the beginning is a fair sample as well.
    """
    dice, rooms = random.Random(seed), defaultdict(list)
    for place in within:
        rooms[str(place)] = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    for file in [] if rooms else sorted(sources.rglob("*.py")):
        rooms[room(file, sources)].append(file)
    length = {name: sum(len(f.read_text().splitlines()) for f in files) for name, files in rooms.items()}
    lines = {name: _shuffled(files, dice) for name, files in sorted(rooms.items())}
    taken, sample, whole = dict.fromkeys(lines, 0), [], sum(length.values())
    while len(sample) < size:
        name = max(lines, key=lambda n: length[n] / whole * (len(sample) + 1) - taken[n])
        sample.append(next(lines[name]))
        taken[name] += 1
    return sample


def _shuffled(files, dice):
    """Mutants of lines drawn from files, without end before the lines have one."""
    lines = [(file, n, ways) for file in files for n, ways in sorted(places(file.read_text()).items())]
    dice.shuffle(lines)
    for file, _, ways in lines:
        name = str(file.relative_to(file.parents[_depth(file)]))
        operator, occurrence = dice.choice(ways)
        if mutant := described(name, file.read_text(), operator, occurrence):
            yield mutant


def _depth(file: Path) -> int:
    """How many folders a file lies below the repository."""
    return next(k for k, place in enumerate(file.parents) if (place / "pyproject.toml").exists())
