"""What else begins to slip after an event: one contact's change may be the reason of another's."""

import numpy as np

from jointplay.solver.method import modes


def leaning(variant, s, p, m, out):
    """Contacts in a row with friction 1: what slips pulls with 2 at the one before it; the last is pulled."""
    for j in range(4):
        pulled = 2.0 if j == 3 or m[3 * (j + 1) + 2] == 0.0 else 0.0
        out[6 * j + 5] = pulled - m[3 * j + 1]


def test_a_row_of_contacts_slips_one_after_the_other():
    """The first contact's own event is decided already."""
    flags, fired = np.full(4, modes.STICKS), np.zeros(16, dtype=int)
    held, m, out = np.full(4, modes.STICK), np.zeros(12), np.zeros(24)
    modes._loosen(leaning, 0, flags, held, fired, m, np.zeros(1), np.zeros(0), 0.0, out)
    assert [*held] == [modes.STICK] + 3 * [modes.SLIP_POSITIVE]
    assert [*np.flatnonzero(fired)] == [4 * j + modes.SLIDE for j in (1, 2, 3)]
