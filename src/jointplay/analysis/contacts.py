"""Statistics of a motion's contacts: their rate, duration, speed and order, and near misses.

A contact begins with an event `contact` and ends with a `separation`; a rigid wall's `impact` is both at
once, and where impacts end in `rest` on it, that lasts until a `separation`. Events are recorded with the
state and the modes just before them.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from jointplay.analysis.evaluate import Quantities, of_states
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event, Mode
from jointplay.solver.motion.trajectory import Records

CONTACT, SEPARATION, IMPACT, REST = map(int, (Event.CONTACT, Event.SEPARATION, Event.IMPACT, Event.REST))
JOINT, KIND, TIME = 0, 1, 2  # columns of an event's row; positions, speeds, modes, work follow
ROW = 2  # where that part of it begins which all rows have
LETTERS = {  # of modes in the word of a turn
    Mode.FREE: "f",
    Mode.RELEASED: "r",
    Mode.SLIP_POSITIVE: "+",
    Mode.SLIP_NEGATIVE: "-",
    Mode.STICK: "s",
    Mode.CONTACT: "c",
    Mode.REST: "h",
}
LONGEST, TURNS = 24, 4  # letters of a turn's word, and turns of a period's, that are kept
CUT = "~"  # the end of a word that was longer
STEP = 1e-6  # of the period, for the rate of a gap


def counts(
    events: np.ndarray, end: float, turns: float, closed_at_end: bool, joint: int | None = None
) -> dict[str, float]:
    """Impacts and separations a turn, and the fraction of time in contact, of one joint or of all.

    The record of events ends at `end` s, after `turns` turns; without events, the motion is in contact all
    the time or never, as `closed_at_end`.
    """
    rows = events[np.isin(events[:, KIND], (CONTACT, SEPARATION, IMPACT, REST)) & (events[:, TIME] <= end)]
    rows = rows if joint is None else rows[rows[:, JOINT] == joint]
    hits, rows = np.sum(rows[:, KIND] == IMPACT), rows[rows[:, KIND] != IMPACT]
    begins, times = rows[:, KIND] != SEPARATION, rows[:, TIME]
    hits -= np.sum(rows[:, KIND] == REST)  # it begins by impacts
    # a motion that begins in contact separates first
    closed = not begins[0] if len(rows) else closed_at_end
    switches = np.concatenate([[0.0] * int(closed), times, [end]])
    inside = np.diff(switches[: len(switches) // 2 * 2])[::2].sum()
    return {
        "separations": float((np.sum(~begins) + hits) / turns),
        "impacts": float((np.sum(begins) + hits) / turns),
        "contact_fraction": float(inside / end),
    }


def of_gaps(model: Model, events: np.ndarray) -> np.ndarray:
    """Events of contacts and walls alone: a jump of states is recorded as an impact, but closes no gap."""
    return events[np.isin(events[:, JOINT], model.gaps)]


def begun(model: Model, events: np.ndarray) -> np.ndarray:
    """Events with which contact begins, or a rigid wall is hit."""
    return of_gaps(model, events[np.isin(events[:, KIND], (CONTACT, IMPACT))])


def closed(model: Model, records: Records, row: np.ndarray) -> np.ndarray:
    """Whether each contact transmits force at a row (time, positions, speeds, modes)."""
    return Quantities(model, row[None, :], records.start).modes[0] > Mode.RELEASED


def smallest_impact_speed(model: Model, records: Records) -> np.ndarray:
    """Smallest speed, m/s, at which each contact began; NaN where none did."""
    rows = begun(model, records.events)
    return _smallest(rows[:, JOINT], approach(model, records, rows[:, ROW:])[1], len(model.touching))


def smallest_missed_gap(model: Model, records: Records) -> np.ndarray:
    """Smallest gap, m, at which each contact was approached and missed; NaN where none was."""
    rows = records.misses
    return _smallest(rows[:, JOINT], approach(model, records, rows[:, ROW:])[0], len(model.touching))


def _smallest(joints: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Smallest absolute value of each contact's own rows."""
    own = (np.abs(values[joints == j, j]) for j in range(count))
    return np.array([np.min(each) if len(each) else np.nan for each in own])


def approach(model: Model, records: Records, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gap (m) and closing speed (m/s) of each contact, at rows of states; shapes (rows, contacts)."""
    if model.links and model.joints:
        names = ("penetration", "normal_velocity")
        own = Quantities(model, rows, records.start).variables(names, "event")
        return -own["penetration"][1], own["normal_velocity"][1]
    if model.resets:
        first = [each[:, : len(model.joints)] for each in _walls(model, rows)]
        h, n_q = STEP * model.period, len(model.turning)
        step = np.zeros_like(rows)
        step[:, 0], step[:, 1 : 1 + n_q] = h, h * rows[:, 1 + n_q : 1 + 2 * n_q]
        now, before, after = (_gaps(model, each) for each in (rows, rows - step, rows + step))
        return tuple(map(np.hstack, zip(first, (now, (before - after) / (2 * h)), strict=True)))
    return _walls(model, rows)


def _gaps(model: Model, rows: np.ndarray) -> np.ndarray:
    keys, states = [f"gap:{name}" for name in model.resets], rows[:, 1 : 1 + len(model.state)]
    return np.stack([*of_states(model, keys, states, rows[:, 0]).values()], -1)


def _walls(model: Model, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gaps and closing speeds of a test system's soft walls, by the structure's own function."""
    module, count = cache.structure_module(model.structure), len(model.touching)
    n_x, numbers = len(model.state), np.array(model.numbers, dtype=float)
    out, masks = np.zeros((len(rows), count, 6)), np.zeros(3 * count)
    state = np.zeros(1 + n_x + 2 * module.SIZES["angles"])
    for row, values in zip(rows, out, strict=True):
        state[: 1 + n_x] = row[: 1 + n_x]
        module.trig(state, numbers)
        module.contacts(1, state, numbers, masks, values.ravel())
    return -out[:, :, 0], out[:, :, 1]


def words(model: Model, records: Records, last: np.ndarray, bounds: np.ndarray, period: int) -> list[str]:
    """Sequences of contact modes, as letters, in the last turn or in the turns of the last period.

    Of a linkage a word for each joint: its modes one after another, f free, r released (touching without
    force), + and - slip, s stick, c contact. Of a test system one word: the walls in the order in which
    contact with them began, by the first letters of their names; ``.`` where there was none. A turn's word
    keeps 24 letters (a longer one ends in ~). The words of a period of up to 4 turns follow one another,
    beginning with that turn which makes the whole come first in the alphabet: one motion has one word.

    `last` is the row at the end of the run, `bounds` the times between turns up to there; a `period` (turns)
    of 0 or less is none.
    """
    turns = min(period if 0 < period <= TURNS else 1, len(bounds) - 1)
    if turns < 1 or not len(model.touching):
        return [""] * (len(model.joints) if model.links else 1)
    kept = bounds[-turns - 1 :]
    if not model.links:
        return [_turned([_walls_met(model, records, *pair) for pair in pairwise(kept)])]
    rows = np.concatenate([records.events[:, ROW:], last[None, :]])
    modes = Quantities(model, rows, records.start).modes
    places = np.searchsorted(records.events[:, TIME], kept, side="right")
    return [
        _turned([_modes(modes[a : b + 1, j]) for a, b in pairwise(places)]) for j in range(len(model.joints))
    ]


def _turned(turns: list[str]) -> str:
    return min(" ".join(turns[i:] + turns[:i]) for i in range(len(turns)))


def _modes(codes: np.ndarray) -> str:
    """Letters of modes, each change once."""
    kept = codes[np.concatenate([[True], codes[1:] != codes[:-1]])]
    return _cut("".join(LETTERS[code] for code in kept[: LONGEST + 1]))


def _walls_met(model: Model, records: Records, begin: float, end: float) -> str:
    rows = records.events[(records.events[:, TIME] > begin) & (records.events[:, TIME] <= end)]
    rows, names = rows[np.isin(rows[:, KIND], (CONTACT, IMPACT))], model.touching
    return _cut("".join(names[int(j)][0] for j in rows[:, JOINT])) or "."


def _cut(word: str) -> str:
    return word if len(word) <= LONGEST else word[: LONGEST - 1] + CUT
