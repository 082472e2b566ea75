"""Handling of events at rigid walls, compiled only for structures that have some; called by address."""

from ..excited import look
from ..interface import SIGNATURES, inner
from ..memory import EVENT_ROW, EVENTS
from ..modes import REST
from ..record import note
from ..sections import count_event
from .sliding import rub, walls_of
from .walls import LOOK, START, STEP, begin, hold, stay, strike


@inner
def at_wall(f, guard, at, k, x, o):
    """Handle an event of a wall's guard at the base point, or the start, or the end of a step.

    Where friction elsewhere may excite vibrations, these are looked for here too.

    `at`: the event's row in the log, or -1.
    """
    if guard == START:
        begin(f, k, x, o)
        return
    if guard == STEP:
        stay(f, x)
        return
    if guard == LOOK:
        look(f, k, x, o)
        return
    j, time, lasting = guard - 4 * len(x.flags), x.s[0], -1.0
    if j < walls_of(x):
        kind, lasting = strike(f, j, k, x, o)
    else:
        j -= walls_of(x)
        kind = rub(f, j, k, x, o)
    contact = len(x.flags) + j
    if at >= 0:
        x.log[at, 1], x.log[at, 2] = contact, kind
    count_event(k, x, o, contact, kind, time)
    if lasting >= 0.0:
        hold(f, j, k, x, o)
        x.count[EVENTS] += 1
        if at >= 0:
            note(k, x, o, EVENT_ROW, float(contact), float(REST), time + lasting, 0.0)
        count_event(k, x, o, contact, REST, time + lasting)


UNIT = {"at_wall": SIGNATURES["at_wall"]}
