"""Handling of events at rigid walls, compiled only for structures that have some; called by address."""

from ..excited import find_excited
from ..interface import SIGNATURES, inner
from ..memory import EVENT_ROW, EVENTS
from ..modes import REST
from ..record import count_event, note
from .walls import SEEK_GROWTH, START, STEP, begin, hold, rub, stay, strike, walls_of


@inner
def at_wall(functions, guard, at, work, motion, options):
    """Handle an event of a wall's guard at the base point, or the start, or the end of a step.

    Where friction elsewhere may excite vibrations, these are looked for here too.

    `at`: the event's row in the log, or -1.
    """
    if guard == START:
        begin(functions, work, motion, options)
        return
    if guard == STEP:
        stay(functions, work, motion, options)
        return
    if guard == SEEK_GROWTH:
        find_excited(functions, work, motion, options)
        return
    j, time, lasting = guard - 4 * len(motion.flags), motion.s[0], -1.0
    if j < walls_of(motion):
        kind, lasting = strike(functions, j, work, motion, options)
    else:
        j -= walls_of(motion)
        kind = rub(functions, j, work, motion, options)
    contact = len(motion.flags) + j
    if at >= 0:
        motion.log[at, 1], motion.log[at, 2] = contact, kind
    count_event(work, motion, options, contact, kind, time)
    if lasting >= 0.0:
        hold(functions, j, work, motion, options)
        motion.count[EVENTS] += 1
        if at >= 0:
            note(work, motion, options, EVENT_ROW, float(contact), float(REST), time + lasting, 0.0)
        count_event(work, motion, options, contact, REST, time + lasting)


UNIT = {"at_wall": SIGNATURES["at_wall"]}
