"""Tables of stiffness.md, made by the program: a worked pin, materials, and fits with their clearances.

python docs/drawing.py   # writes them anew
"""

from collections.abc import Iterator
from pathlib import Path

import jointplay as jp
from jointplay.solver.mechanism.parts.materials import TABLE, Spread

PAGE = Path(__file__).with_name("stiffness.md")
BEGIN, END = "<!-- {} -->\n", "<!-- end of {} -->"
FITS = ("G7/h6", "H7/g6", "F8/h7", "H7/f7", "H8/f7", "E9/h9", "H8/e8", "H9/d9", "D10/h9", "H11/c11")
DIAMETERS = (3, 5, 8, 12, 15, 20, 30, 40, 60, 80, 100)  # mm
PIN = {"radius": "7.5 mm", "pin": "steel", "length": "12 mm"}
FIT = jp.fit("H7/f7", "15 mm")
MARKS = "Marks' Standard Handbook for Mechanical Engineers, sliding friction"


def _table(*rows: tuple[str, ...]) -> str:
    head, *below = rows
    return "".join(f"| {' | '.join(row)} |\n" for row in (head, ("---",) * len(head), *below))


def pin() -> str:
    """The worked pin, printed."""
    return f"```text\n{jp.contact_data(clearance=FIT.clearance, bush='bronze', **PIN)}\n```\n"


def changes() -> str:
    """What the worked pin's numbers are with one thing changed."""
    base = {"clearance": FIT.clearance, "bush": "bronze"} | PIN
    rows = [
        ("as above", {}),
        ("least clearance of the fit", {"clearance": FIT.least}),
        ("largest clearance of the fit", {"clearance": FIT.most}),
        ("a tenth of the load", {"load": 90.0}),
        ("ten times the load", {"load": 9e3}),
        ("Ra 1.6 µm", {"roughness": "1.6 um"}),
        ("smooth", {"roughness": 0.0}),
        ("bush 24 mm long", {"length": "24 mm"}),
        ("bush of steel", {"bush": "steel"}),
        ("bush of POM", {"bush": "POM"}),
    ]
    found = [(name, jp.contact_data(**base | change)) for name, change in rows]
    return _table(
        ("", "N/m at the load", "between", "exponent", "method"),
        *(
            (name, f"{each.secant.value:.2g}", f"{each.secant.low:.2g} and {each.secant.high:.2g}",
             f"{each.exponent.value:.2f}", f"`{each.method}`")
            for name, each in found
        ),
    )  # fmt: skip


def materials() -> str:
    """Every material, with ranges; a handbook that many rows name stands in full above the table."""

    def told(spread: Spread, factor: float = 1.0) -> str:
        usual, low, high = (f"{each / factor:.3g}" for each in spread)
        return f"{usual} ({low}–{high})"

    def rows() -> Iterator[tuple[str, ...]]:
        for name, each in TABLE.items():
            numbers = (told(each.modulus, 1e9), f"{each.poisson_ratio:g}", f"{each.density:g}")
            yield (
                f"`{name}`",
                *numbers,
                told(each.dry),
                told(each.greased),
                told(each.restitution),
                each.sources.replace(MARKS, "Marks"),
            )

    head = ("material", "E, GPa", "ν", "ρ, kg/m³", "friction dry", "greased", "restitution", "source")
    return _table(head, *rows())


def fits() -> str:
    """Radial clearance of common fits by diameter, µm: least and largest."""

    def told(name: str, diameter: int) -> str:
        found = jp.fit(name, diameter / 1000)
        return f"{1e6 * found.least:g}–{1e6 * found.most:g}"

    rows = ((f"{each} mm", *(told(name, each) for name in FITS)) for each in DIAMETERS)
    return _table(("diameter", *FITS), *rows)


TABLES = {"pin": pin, "changes": changes, "fits": fits, "materials": materials}


def written(page: str) -> str:
    """The page with its tables anew."""
    for name, made in TABLES.items():
        before, rest = page.split(BEGIN.format(name))
        end = END.format(name)
        page = before + BEGIN.format(name) + made() + end + rest.split(end)[1]
    return page


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
