"""Tables of stiffness.md, made by the program: a worked pin, and what changes it.

python docs/drawing.py   # writes them anew
"""

from pathlib import Path

import jointplay as jp

PAGE = Path(__file__).with_name("stiffness.md")
BEGIN, END = "<!-- {} -->\n", "<!-- end of {} -->"
PIN = {"radius": "7.5 mm", "pin": "steel", "length": "12 mm"}
FIT = jp.fit("H7/f7", "15 mm")


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


TABLES = {"pin": pin, "changes": changes}


def written(page: str) -> str:
    """The page with its tables anew."""
    for name, made in TABLES.items():
        before, rest = page.split(BEGIN.format(name))
        end = END.format(name)
        page = before + BEGIN.format(name) + made() + end + rest.split(end)[1]
    return page


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
