"""Events of orbits: which of them begins beyond a grazing."""

import numpy as np
import pytest

from jointplay.analysis.orbits.section_map import changed_event
from jointplay.solver.method.codes import Event

PLAIN = [(0, Event.SLIP_REVERSAL, 0.1), (0, Event.SEPARATION, 0.4), (0, Event.CONTACT, 0.6)]


def rows(events):
    return np.array([(*event, 0.0) for event in sorted(events, key=lambda event: event[2])])


@pytest.mark.parametrize(
    ("more", "event"),
    [
        ([(0, Event.SEPARATION, 0.8), (0, Event.CONTACT, 0.801)], Event.SEPARATION),
        ([(0, Event.CONTACT, 0.5), (0, Event.SEPARATION, 0.501)], Event.CONTACT),
        ([(0, Event.SEPARATION, 0.9995), (0, Event.CONTACT, 0.0002)], Event.SEPARATION),
        ([(0, Event.STICK_ONSET, 0.3), (0, Event.SLIP_ONSET, 0.31)], Event.STICK_ONSET),
        ([(0, Event.IMPACT, 0.5)], Event.IMPACT),
    ],
)
def test_the_first_of_what_begins(more, event):
    one, other = rows(PLAIN), rows(PLAIN + more)
    assert changed_event(one, other) == changed_event(other, one) == (0, event)


def test_nothing_changes():
    assert changed_event(rows(PLAIN), rows(PLAIN)) == (-1, -1)
