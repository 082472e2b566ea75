"""Answers of assessments: one page of plain text, and its three lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import plain, signed, with_error
from jointplay.display.units import measure, shown

if TYPE_CHECKING:
    from xarray import Dataset

BEGINS = {  # what the change is, where the present motion does not have the trait
    "contact_loss": "contact is lost",
    "doubling": "period 1 is lost",
    "chaos": "chaos begins",
}
JUMPS = "the motion ends in a fold and jumps to another"  # of period 1, where that was lost so
ENDS = {"contact_loss": "contact is kept", "doubling": "period 1 is reached", "chaos": "chaos ends"}
FOUND = {
    "bracketed": "settled motions",
    "fold": "fold of the orbit",
    "grazing": "grazing of the orbit",
    "irregular": "now and then, in a motion without a period",
}
NONE = "\N{EN DASH}"
UNEQUAL = 1e-3  # difference of works, over them, that is told
PLACES = 41  # values of the diagram that shows a change by brute force
NARROW = 3  # distances of the values looked at: a change that is taken back within them is a narrow window


def answer(dataset: Dataset) -> str:
    """Return the hardest worked joint, the present motion, and the nearest change of it."""
    ratio = dataset["force_ratio"].values
    if not np.isfinite(ratio).any():
        return "no forces known"
    i = int(np.nanargmax(ratio))
    force = measure(float(dataset["peak_force"][i]), "N", 3)
    name = _joints(dataset)[i]
    first = f"joint forces up to {plain(ratio[i], 3)} times the ideal mechanism's: joint {name}, {force}"
    return "\n".join([first, _motion(dataset), _nearest(dataset)])


def page(dataset: Dataset, source: str = "MECHANISM.toml") -> str:
    """Return the whole assessment as a page of plain text; `source` is the file in its commands."""
    name = str(dataset.attrs.get("title") or dataset.attrs.get("study") or "assessment")
    lines = [name, "=" * len(name), "", f"Motion: {_motion(dataset)}.", ""]
    lines += [*_forces(dataset), "", *_contacts(dataset), "", *_changes(dataset), ""]
    lines += [
        "Reproduce",
        f"  jointplay assess {source}",
        "Check by brute force: a diagram across each change",
    ]
    lines += [f"  {command}" for command in commands(dataset, source)]
    return "\n".join(lines) + "\n"


def _joints(dataset: Dataset) -> list[str]:
    return [str(name) for name in dataset["joint"].values]


def _motion(dataset: Dataset) -> str:
    """The present motion: its speed and period, or its exponent."""
    speed = float(dataset["crank_speed"])
    turning = f"crank at {plain(speed, 4)} rad/s ({plain(speed * 30 / math.pi, 4)} rpm)"
    period = float(dataset["period"])
    if not period > 0:
        value, error = (float(dataset[f"section_{n}_per_turn"]) for n in ("exponent", "standard_error"))
        chaotic = _present(dataset)["chaos"] == "yes"
        what = "chaotic" if chaotic else "no period found, undecided"
        return f"{turning}; {what}, largest exponent of the section map {signed(value, error)} per turn"
    lost = {"yes": "contact is lost in each", "no": "contact is never lost"}
    return f"{turning}; repeats every {_turns(period)}, {lost[_present(dataset)['contact_loss']]}"


def _turns(period: float) -> str:
    return "turn" if period == 1 else f"{int(period)} turns"


def _present(dataset: Dataset) -> dict[str, str]:
    return dict(zip(dataset["change"].values, codes.words(dataset["present"]).values, strict=True))


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows in columns; the first on the left, numbers on the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  " + "  ".join(_cells(row, widths)).rstrip() for row in rows]


def _cells(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    for i, (cell, width) in enumerate(zip(row, widths, strict=True)):
        yield cell.ljust(width) if i == 0 else cell.rjust(width)


def _number(value: float, error: float, factor: float = 1.0) -> str:
    """A number with its error; to four digits where that is smaller still."""
    value, error = factor * value, factor * error
    if math.isnan(value):
        return NONE
    return with_error(value, error) if error > 1e-4 * abs(value) else f"{plain(value, 5)} ± <0.01 %"


def _forces(dataset: Dataset) -> list[str]:
    rows = [("joint", "clearance", "largest force (N)", "ideal mechanism (N)", "ratio")]
    for name in _joints(dataset):
        one = dataset.sel(joint=name)
        pairs = [_number(float(one[n]), float(one[f"{n}_error"])) for n in ("peak_force", "ideal_peak_force")]
        loose = float(one["clearance"]) > 0
        clearance = measure(float(one["clearance"]), "m", 4) if loose else "ideal"
        rows.append((name, clearance, *pairs, plain(float(one["force_ratio"]), 3)))
    return ["Largest joint forces", *_table(rows)]


def _contacts(dataset: Dataset) -> list[str]:
    loose = dataset.isel(joint=dataset["clearance"].values > 0)
    unit = shown(loose["sliding_work"].values, "J")
    factor, symbol = (1e3, "mJ") if np.nanmax(loose["sliding_work"].values, initial=0.0) < 1 else unit[1::-1]
    head = ("joint", "separations", "in contact", "impact speed", f"normal contact ({symbol})")
    rows = [(*head, f"friction ({symbol})", f"sliding work ({symbol})")]
    for name in _joints(loose):
        one = loose.sel(joint=name)
        share = f"{plain(100 * float(one['contact_fraction']), 4)} %"
        count, hit = plain(float(one["separations"]), 3), float(one["impact_speed"])
        speed = measure(hit, "m s-1", 3) if hit > 0 else NONE
        losses = ("impact_loss", "friction_loss", "sliding_work")
        each = (_number(float(one[n]), float(one[f"{n}_error"]), factor) for n in losses)
        rows.append((name, count, share, speed, *each))
    losses = _number(float(dataset["joint_loss"]), float(dataset["joint_loss_error"]), factor)
    taken, given = (float(dataset[name]) for name in ("joint_work", "drive_work"))
    whole = (f"{plain(factor * work, 5)} {symbol}" for work in (taken, given))
    check = "  check: losses together {} {}; integrated along, the joints take {}, the drive gives {}"
    check = check.format(losses, symbol, *whole)
    if abs(given - taken) > UNEQUAL * abs(taken):
        check += " (the difference is stored, or goes elsewhere)"
    title = "Contact, per turn: separations, energy lost, and normal force times sliding distance"
    return [title, *_table(rows), check]


def _value(dataset: Dataset, key: str, ratio: float, digits: int = 6) -> str:
    one = dataset.sel(parameter=key)
    return measure(ratio * float(one["present_value"]), str(one["parameter_units"].values), digits)


def _changes(dataset: Dataset) -> list[str]:
    lines = ["Where the motion changes, outward from the present value of one parameter at a time"]
    for key in map(str, dataset["parameter"].values):
        one = dataset.sel(parameter=key)
        now = f"now {_value(dataset, key, 1.0, 4)}"
        rows = [(f"{one['parameter_name'].values}, {now}", "at", "away", "between motions at", "found by")]
        unmet = []
        for side in ("below", "above"):
            rows += _met(dataset, key, side)
            unmet += [*_not_met(dataset, key, side), *_in_chaos(dataset, key, side)]
            unmet += _windows(dataset, key, side)
        lines += [*_table(rows), *(f"    {line}" for line in [*unmet, _looked(one)])]
    return [*lines, "  what begins and ends between two neighbouring values is not seen"]


def _looked(one: Dataset) -> str:
    """Words on the number of values of a parameter that were followed, and their relative distance."""
    parts = []
    for side in ("below", "above"):
        here = one.sel(side=side)
        count = int(here["values_looked_at"])
        apart = f", {plain(100 * _apart(here), 2)} % apart on average" if count else ""
        parts.append(f"{count} {'value' if count == 1 else 'values'} {side}{apart}")
    return f"motions looked at: {'; '.join(parts)}"


def _apart(here: Dataset) -> float:
    """Mean distance of the values followed on one side, in the logarithm."""
    return abs(math.log(float(here["limit_ratio"]))) / max(int(here["values_looked_at"]), 1)


def widths(here: Dataset) -> np.ndarray:
    """Widest that each change's window can be, on one side, in the logarithm; NaN where it is not narrow."""
    width = np.abs(np.log(here["return_ratio"].values / here["edge_ratio"].values))
    return np.where(width <= NARROW * _apart(here), width, np.nan)


def _windows(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on the changes that are taken back at once: others like them may have been missed."""
    width = widths(dataset.sel(parameter=key, side=side))
    if (narrow := np.isfinite(width)).any():
        names = ", ".join(_words(dataset, str(name)) for name in dataset["change"].values[narrow])
        wide = f"{plain(100 * np.nanmax(width), 2)} % at most"
        yield f"{side}: windows of {wide} ({names}); others may lie between the values looked at"


def _in_chaos(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on each window in chaos that was met, and is no end of it."""
    if "window_low" not in dataset:
        return
    one, share = dataset.sel(parameter=key, side=side), plain(100 * float(dataset["lasting_share"]), 2)
    for ends in zip(*(one[f"window_{name}"].values for name in ("low", "high", "period")), strict=True):
        if not np.isnan(ends).any():
            low, high = (_value(dataset, key, float(end), 7) for end in ends[:2])
            what = f"period {int(ends[2])}" if ends[2] else "no period, and no chaos"
            yield f"{side}: a window in chaos from {low} to {high} ({what}): an end would last {share} %"


def _met(dataset: Dataset, key: str, side: str) -> Iterator[tuple[str, ...]]:
    """Rows of the changes found on one side."""
    for name in map(str, dataset["change"].values):
        found = dataset.sel(parameter=key, side=side, change=name)
        how = str(codes.words(found["found_by"]).values)
        if how != "not_met":
            kind = FOUND.get(how, how.replace("_", " "))
            if math.isfinite(back := float(found["return_ratio"])):
                kind += f"; as at present again at {_value(dataset, key, back, 4)}"
            yield f"  {side}: {_words(dataset, name, how)}", *_place(dataset, key, found), kind


def _not_met(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on the changes that were not met on one side, and on the reach of the search."""
    one = dataset.sel(parameter=key, side=side)
    unmet = list(map(str, dataset["change"].values[one["found_by"].values == 0]))
    status = str(codes.words(one["side_status"]).values)
    why = "" if status == "ok" else f", where it stopped: {status}"
    end = _value(dataset, key, float(one["limit_ratio"]), 4)
    if "chaos" in unmet and _present(dataset)["chaos"] == "yes":
        unmet.remove("chaos")
        count, turns = int(one["values_looked_at"]), int(dataset["lasting_turns"])
        windows = int(np.isfinite(one["window_period"]).sum()) if "window_period" in one else 0
        at = f"at {count - windows} of the" if windows else "at each of the"
        yield f"{side}: chaotic {at} {count} values up to {end}{why}, {turns} turns later too"
    if unmet:
        yield f"{side}: not met up to {end}{why}: {', '.join(_words(dataset, name) for name in unmet)}"


def _words(dataset: Dataset, name: str, how: str = "") -> str:
    """Words for a change, from the present motion."""
    if _present(dataset)[name] == "yes":
        return ENDS[name]
    return JUMPS if how == "fold" else BEGINS[name]


def _place(dataset: Dataset, key: str, found: Dataset) -> tuple[str, str, str]:
    """Value of an edge with its error, its distance, and its bracket."""
    ratio, error = float(found["edge_ratio"]), float(found["edge_ratio_error"])
    value = float(found["present_value"])
    unit = shown(ratio * value, str(found["parameter_units"].values))
    symbol = "" if unit.symbol == NONE else f" {unit.symbol}"
    text = f"{_sharp(ratio * value * unit.factor, error * abs(value) * unit.factor)}{symbol}"
    if key in ("gear_ratio", "speed"):
        text += f" ({plain(abs(float(found['edge_speed'])) * 30 / math.pi, 4)} rpm)"
    low, high = (_value(dataset, key, float(found[f"bracket_{end}"]), 5) for end in ("low", "high"))
    return text, f"{plain(100 * abs(ratio - 1), 3)} %", f"{low} and {high}"


def _sharp(value: float, error: float) -> str:
    """An edge with its error, or to six digits where that is smaller."""
    return with_error(value, error) if error > 1e-6 * abs(value) else plain(value, 6)


def commands(dataset: Dataset, source: str) -> list[str]:
    """Commands that run a bifurcation diagram across the changes on each side, from the present value."""
    lines = []
    for key in map(str, dataset["parameter"].values):
        for side in ("below", "above"):
            ends = dataset["edge_ratio"].sel(parameter=key, side=side).values
            if np.isfinite(ends).any():
                farthest = float((np.nanmin if side == "below" else np.nanmax)(ends))
                lines.append(_command(dataset, key, side, farthest, source))
    return lines


def _command(dataset: Dataset, key: str, side: str, ratio: float, source: str) -> str:
    value = float(dataset["present_value"].sel(parameter=key))
    low, high = sorted((value, value * (1 + 1.1 * (ratio - 1))))
    span = f"{{start={low:.6g},stop={high:.6g},num={PLACES}}}"
    way = "down" if (side == "below") == (value > 0) else "up"
    name = f"name={key.replace('.', '_')}_{side}"
    settings = f"kind=bifurcation {name} figure={{}} 'analysis={{direction=\"{way}\",exponents=1}}'"
    return f"jointplay run {source} --set {settings} 'vary.{key}={span}'"


def _nearest(dataset: Dataset) -> str:
    """The change nearest to the present value of its parameter."""
    ratio = dataset["edge_ratio"].values
    if not np.isfinite(ratio).any():
        return "no change of the motion was met"
    p, s, c = np.unravel_index(np.nanargmin(np.abs(ratio - 1)), ratio.shape)
    name, key = str(dataset["change"].values[c]), str(dataset["parameter"].values[p])
    found = dataset.isel(parameter=p, side=s, change=c)
    words = _words(dataset, name, str(codes.words(found["found_by"]).values))
    away = f"{plain(100 * abs(float(ratio[p, s, c]) - 1), 3)} % away"
    at = f"{found['parameter_name'].values} {_value(dataset, key, float(ratio[p, s, c]))}"
    return f"nearest change: {words} at {at}, {away}"
