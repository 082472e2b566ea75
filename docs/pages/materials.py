"""Materials with their ranges, fits with the clearances that they give, and a worked pin."""

from __future__ import annotations

from collections.abc import Iterator

import jointplay as jp
from jointplay.solver.mechanism.parts.materials import TABLE, Spread
from pages.text import table

FITS = ("G7/h6", "H7/g6", "F8/h7", "H7/f7", "H8/f7", "E9/h9", "H8/e8", "H9/d9", "D10/h9", "H11/c11")
DIAMETERS = (3, 5, 8, 12, 15, 20, 30, 40, 60, 80, 100)  # mm
PIN = {"radius": "7.5 mm", "pin": "steel", "length": "12 mm"}
FIT = jp.fit("H7/f7", "15 mm")
MARKS = "Marks' Standard Handbook for Mechanical Engineers, sliding friction"


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
    return table(head, rows())


def fits() -> str:
    """Radial clearance of common fits by diameter, µm: least and largest."""

    def told(name: str, diameter: int) -> str:
        found = jp.fit(name, diameter / 1000)
        return f"{1e6 * found.least:g}–{1e6 * found.most:g}"

    rows = ((f"{each} mm", *(told(name, each) for name in FITS)) for each in DIAMETERS)
    return table(("diameter", *FITS), rows)


def pin() -> str:
    """A worked pin, printed."""
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
    return table(
        ("", "N/m at the load", "between", "exponent", "method"),
        (
            (name, f"{each.secant.value:.2g}", f"{each.secant.low:.2g} and {each.secant.high:.2g}",
             f"{each.exponent.value:.2f}", f"`{each.method}`")
            for name, each in found
        ),
    )  # fmt: skip


def page() -> str:
    """The page of materials and fits."""
    return (
        "# Materials, fits, a worked pin\n\n"
        "Values with their ranges, friction on steel, restitution of a blow at 0.1 m/s. “Marks” is\n"
        "Marks' Standard Handbook for Mechanical Engineers, sliding friction.\n\n"
        f"{materials()}\n"
        "## Fits\n\n"
        "Least and largest *radial* clearance in µm, half the difference of the diameters, by ISO 286-1.\n"
        "A joint with `fit` gets the middle of the two.\n\n"
        f"{fits()}\n"
        "`H7/g6` slides, `H7/f7` and `H8/f7` run, `H8/e8`, `H9/d9` run loosely, `H11/c11` rattles\n"
        "by design. Sintered and plastic bushes shrink when pressed in: their makers state the fit then.\n\n"
        "## A worked pin\n\n"
        "A pin 15 f7 of steel in a bush H7 of bronze, 12 mm long, as `jp.contact_data` prints it, and its\n"
        f"numbers with one thing changed.\n\n{pin()}\n{changes()}"
    )
