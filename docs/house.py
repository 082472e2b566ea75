"""The rooms of the sources and which imports which, drawn from the imports themselves.

    python docs/house.py   # draws the picture anew: images/house.svg

A room stands above those that it imports, the solver's rooms on the right. Of two ways between rooms the
longer one is drawn, so that an arrow says what no others say already.
"""

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

SOURCES = Path(__file__).parents[1] / "src"
PICTURE = Path(__file__).with_name("images") / "house.svg"
ALONE = ("__init__", "__main__")  # files that are no room
DOORS = ("jointplay", "solver", "solver/extensions")  # what stands in no room: doors, and a file of one class
WIDTH, HEIGHT = 1.0, 0.5  # of a room; floors and places are 1.0 and 1.3 apart


def room(module: str) -> str:
    """Room of a module: a folder of the suite, one of the solver's, or another package."""
    package, *rest = module.split(".")
    if package != "jointplay":
        return package
    rest = [part for part in rest if part not in ALONE]
    inner = rest[1:2] if rest[:1] == ["solver"] else []
    return "/".join(rest[:1] + inner) if rest else package


@cache
def arrows() -> set[tuple[str, str]]:
    """Pairs of rooms of which the first imports from the second, wherever in a file."""
    files = {
        ".".join(path.relative_to(SOURCES).with_suffix("").parts).removesuffix(".__init__"): path
        for path in SOURCES.glob("jointplay*/**/*.py")
    }
    found = set()
    for module, path in files.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += (
                [f"{names[0]}.{alias.name}" for alias in node.names]
                if isinstance(node, ast.ImportFrom) and names
                else []
            )
            found |= {(room(module), room(name)) for name in names if name in files}
    return {(one, other) for one, other in found if one != other and not {one, other} & {*DOORS}}


def floors(pairs: set[tuple[str, str]]) -> dict[str, int]:
    """Floor of each room: one above the highest that it imports."""
    below: dict[str, set[str]] = {}
    for one, other in pairs:
        below.setdefault(one, set()).add(other)
    found: dict[str, int] = {}
    for name in TopologicalSorter(below).static_order():
        found[name] = max((found[other] + 1 for other in below.get(name, ())), default=0)
    return found


def needed(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Arrows between which there is no other way."""
    return {
        (a, c)
        for a, c in pairs
        if not any((a, b) in pairs and _leads(b, c, pairs) for b in {y for _, y in pairs} - {a, c})
    }


def _leads(one: str, other: str, pairs: set[tuple[str, str]]) -> bool:
    return (one, other) in pairs or any(_leads(b, other, pairs) for a, b in pairs if a == one)


def drawn(pairs: set[tuple[str, str]]) -> Figure:
    """Picture of rooms on their floors."""
    level = floors(pairs)
    place = {}
    for floor in sorted(set(level.values())):
        here = sorted(name for name in level if level[name] == floor)
        for right in (False, True):
            side = [name for name in here if name.startswith("solver/") == right]
            place |= {name: (1.3 * (k + 1 if right else -k), floor) for k, name in enumerate(side)}
    figure = Figure(figsize=(6.0, 0.7 * (1 + max(level.values()))))
    ax = figure.add_axes((0, 0, 1, 1))
    for one, other in sorted(needed(pairs)):
        (x, y), (u, v) = place[one], place[other]
        bend = (y - v > 1) * (1.25 if x == u else 0.15)
        ax.annotate(
            "",
            (u, v + HEIGHT / 2),
            (x, y - HEIGHT / 2),
            arrowprops={
                "arrowstyle": "->",
                "color": "0.55",
                "lw": 0.8,
                "connectionstyle": f"arc3,rad={bend}",
            },
        )
    for name, (x, y) in place.items():
        face = (
            "#dcebf7"
            if name.startswith("solver/")
            else "#f7ecd9"
            if name.startswith("jointplay_")
            else "#f2f2f2"
        )
        box = FancyBboxPatch(
            (x - WIDTH / 2, y - HEIGHT / 2),
            WIDTH,
            HEIGHT,
            boxstyle="round,pad=0.02",
            fc=face,
            ec="0.3",
            zorder=2,
            lw=0.8,
        )
        ax.add_patch(box)
        ax.text(x, y, name.replace("/", "/\n"), ha="center", va="center", fontsize=8, zorder=3)
    ax.set_xlim(min(x for x, _ in place.values()) - 0.8, max(x for x, _ in place.values()) + 0.8)
    ax.set_ylim(-0.5, max(level.values()) + 0.5)
    ax.axis("off")
    return figure


def said(pairs: set[tuple[str, str]]) -> str:
    """The arrows as text, which the picture carries."""
    return ", ".join(f"{one} > {other}" for one, other in sorted(pairs))


if __name__ == "__main__":
    drawn(arrows()).savefig(PICTURE, metadata={"Date": None, "Description": said(arrows())})
