"""Digits to compare other programs with, from the stored table."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

from pages.text import table

STORED = Path(__file__).parents[2] / "results" / "reference" / "reference.csv"
DIGITS = 12  # the most that are printed


def stored() -> list[dict[str, str]]:
    """The rows of the table."""
    with STORED.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def told(value: float, error: float) -> str:
    """A number with its standard error in the last digits, or with as many digits as may be relied on."""
    if not value:
        return "0"
    ahead = math.floor(math.log10(abs(value)))
    known = DIGITS if error <= 0 else min(DIGITS, max(1, ahead - math.floor(math.log10(error)) + 2))
    text = f"{value:.{known - 1}e}"
    mantissa, power = text.split("e")
    size = abs(int(power))
    if -5 < int(power) < 6:
        mantissa, power = f"{value:.{max(known - 1 - int(power), 0)}f}", ""
    last = error / 10 ** (ahead - known + 1)
    sure = f"({last:.0f})" if known < DIGITS and last >= 1 else ""
    return (
        mantissa
        + sure
        + (f"·10{'⁻' if power.startswith('-') else ''}{str(size).translate(RAISED)}" if power else "")
    )


RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def page() -> str:
    """The page of reference values."""
    rows = stored()
    systems = list(dict.fromkeys(row["system"] for row in rows))
    lines, parts, before = [], [], ""
    for row in rows:
        value, error = (float(row[name]) for name in ("value", "error"))
        other, unsure = (float(row[name]) for name in ("confirmed", "confirmed_error"))
        units = "" if row["units"] == "1" else f", {row['units']}"
        lines.append(
            (
                "" if row["system"] == before else f"{systems.index(row['system']) + 1}. {row['system']}",
                row["quantity"] + units,
                told(value, error),
                f"`{row['method']}`",
                told(other, max(unsure, error)),
                row["confirmed_by"],
            )
        )
        before = row["system"]
    for number, name in enumerate(systems, 1):
        text = next(row["mechanism"] for row in rows if row["system"] == name)
        told_in_full = json.dumps(json.loads(text), indent=1, ensure_ascii=False)
        parts.append(f"### {number}. {name}\n\n```json\n{told_in_full}\n```\n")
    head = ("system", "quantity", "value", "by", "confirmed", "by")
    return (
        "# Reference values\n\n"
        f"{len(rows)} quantities of {len(systems)} systems with play, impacts, friction and switches, to\n"
        "compare programs with. A number in brackets is the error of the last digits: the standard error\n"
        "of a statistic, the accuracy of a located point, or how far a run at a hundred times the\n"
        f"tolerance is away. At most {DIGITS} digits are printed; `results/reference` has all of them, as\n"
        "netCDF and CSV. Systems stand in full below the table. It has no DOI yet.\n\n"
        f"{table(head, lines)}\n"
        "Siconos' stored motion of a cam follower (`CamFollower-Rheonomous.ref`) is that of a follower on\n"
        "a stop at rest: its constraint leaves out the cam, which moves in columns of its own. It stands\n"
        "here as what it is; the cam is compared with exact flights.\n\n"
        "`python -m tests.reference.values` makes the table anew in a quarter of an hour on two cores, and\n"
        "stops where a value and its confirmation are further apart than three times both errors.\n\n"
        "## The systems\n\n" + "\n".join(parts)
    )
