"""Restitution that laws of the normal force give, beside the one that is asked of them: the table of laws.md.

    python docs/laws.py   # writes the table anew

A body of mass m meets the contact with speed v_0, nothing else acts on it. Of F_n = K u^n (1 + chi v_n) with
d = chi v_0 its restitution e follows from d (1 + e) = ln[(1 + d) / (1 - d e)], whatever m, K and n.
"""

from math import log, nextafter
from pathlib import Path

from scipy.optimize import brentq

from jointplay.solver.equations.laws import FACTORS

PAGE = Path(__file__).with_name("laws.md")
BEGIN, END = "<!-- table -->\n", "<!-- end -->"
WANTED = (0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.1)


def restitution(d: float) -> float:
    """Restitution that a damping factor d = chi v_0 gives."""
    if d < 1e-6:  # the equation is 0 = 0 to rounding; e = 1 - 2 d / 3 to order d^2
        return 1 - 2 * d / 3
    most = nextafter(min(1.0, 1 / d), 0.0)  # the force is 0 where 1 - d e is
    return brentq(lambda e: log((1 + d) / (1 - d * e)) - d * (1 + e), 1e-14, most, xtol=1e-15, rtol=1e-14)


def table() -> str:
    """Restitution by law and by what is wanted."""
    head = ["law", "d(e)", *(f"e = {e:g}" for e in WANTED)]
    rows = [head, ["---"] * len(head)]
    for name, (factor, _) in FACTORS.items():
        rows.append([f"`{name}`", FORMULAS[name], *(f"{restitution(factor(e)):.3f}" for e in WANTED)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n"


FORMULAS = {
    "hunt_crossley_restitution": "3 (1 − e)/2",
    "herbert_mcwhannell": "6 (1 − e)/((2e − 1)² + 3)",
    "lee_wang": "3 (1 − e)/4",
    "lankarani_nikravesh": "3 (1 − e²)/4",
    "gonthier": "(1 − e²)/e",
    "zhiying_qishao": "3 (1 − e²) exp(2 (1 − e))/4",
    "flores": "8 (1 − e)/(5 e)",
    "hu_guo": "3 (1 − e)/(2 e)",
}


def written(page: str) -> str:
    """The page with the table anew."""
    before, rest = page.split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
