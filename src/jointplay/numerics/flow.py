"""The event-driven flow: smooth pieces by the collocation method, joined at located events.

One loop for every structure. A piece runs until a guard leaves its side; the state is taken there, the mode
changes (or the state jumps), and the next piece starts from the new side. Numerical trouble is a status,
never an exception.
"""

import numpy as np
from numba import int64, typeof
from numba.core.types import none

from .control import ORDER, after_whole, bounded, learn_start, shorter
from .events import ROUNDING, aim, blur, first_event, locate, side_of, start_of, state_at, swings
from .interface import FUNCTIONS, entry, inlined, inner, spliced
from .memory import (
    CLOSE,
    CONTRACTION,
    EVALUATIONS,
    EVENT_ROW,
    EVENTS,
    FAILED,
    FRESH,
    H_LIMIT,
    H_PAST,
    H_REJECTED,
    H_START,
    H_VARIANT,
    LOGGED,
    REJECTED,
    SAMPLES,
    SECTIONS,
    SMOOTH,
    STARTED,
    STEP_ROW,
    STEPS,
    T_EVENT,
    T_SECTION,
    H,
    Options,
    trajectory,
    work,
)
from .misses import misses
from .modes import CONTACT, FREE, IMPACT, PULLS, RELEASED, follow, mask, touch, variant_of
from .record import gains, note, sample, work_at
from .saltation import leap, meet
from .sections import count_section, keep, sections
from .status import CHATTER, CHATTER_COUNT, DIVERGED, FULL, HUGE, NOT_CONVERGED, OK, STEP_LIMIT
from .step import attempt
from .tangent import ROWS, carry, mark

WORK = typeof(work(1, 1, 1, 1, 1, 1, 1))
TRAJECTORY = typeof(trajectory(np.zeros(1), np.zeros(1), 1, 1, 0, 0))
OPTIONS = typeof(Options(*(field(0) for field in Options.__annotations__.values())))

ROOM = 24  # log rows that one step may need
TOGETHER = 1e-6  # of a step that ends at an event: what happens within it is one event's


@inlined
def _new_base(f, weight, x, n_x):
    """Sines, masks and weights of a new base point."""
    f.trig(x.s, x.p)
    mask(x.modes, x.m)
    for r in range(n_x):
        weight[r] = 1.0 / (x.absolute[r] + x.relative[r] * abs(x.s[1 + r]))


@inlined
def _commit(w, s, gain, work, b, at, n_x, place, time):
    """Move the base point, and the work, to `place` of the step whose increments begin at w[at]."""
    state_at(w, at, s, n_x, place, b, s)
    work_at(gain, b, work, work)
    s[0] = time
    for i in range(8 * n_x):  # from here on the increments are of the new base point
        w[at + i] = 0.0
    for i in range(len(gain)):
        gain[i] = 0.0


@inner
def _event(f, k, x, o, guard):
    """Change mode, or jump, at the base point; count events that crowd."""
    count, real, time = x.count, x.real, x.s[0]
    f.trig(x.s, x.p)
    count[CLOSE] = count[CLOSE] + 1 if time - real[T_EVENT] < o.near else 0
    real[T_EVENT] = time
    count[EVENTS] += 1
    at, logged = count[LOGGED], o.log_events and time >= o.log_from
    if logged:
        note(k, x, o, EVENT_ROW, -1.0, 0.0, time, 0.0)
    j, kind = guard // 4, IMPACT
    if j < len(x.modes):
        kind = follow(f.contacts, j, guard % 4, x.flags, x.modes, x.fired, x.m, x.s, x.p, o.rest, k.contact)
    else:
        j = guard - 4 * len(x.modes)
        x.fired[guard] = 1
        f.reset(j, x.s, x.p)
    if logged:
        x.log[at, 1], x.log[at, 2] = j, kind
    if o.section == 2 and kind == o.section_event and (o.section_contact < 0 or o.section_contact == j):
        count_section(k, x, o, time, 0.0, float(j), float(kind))
    count[SMOOTH], real[CONTRACTION], real[H_LIMIT], real[H_REJECTED] = 0, 1.0, np.inf, 0.0
    variant = variant_of(x.modes)
    if real[H_VARIANT + variant] > 0.0:
        real[H] = real[H_VARIANT + variant]
    if real[H_START + variant] > 0.0:
        real[H] = min(real[H], real[H_START + variant])
    if o.log_steps and x.s[0] >= o.log_from:
        note(k, x, o, STEP_ROW, -1.0, 0.0, x.s[0], 0.0)


@inlined
def _reach(f, variant, k, x, o, h):
    """How far an accurate attempt may be taken.

    Its first event's guard (-1: none), the length of the step that ends there, the place of the event in it
    (0: at its start, 1: at its end to rounding), and whether that is sure: a long step may have promised
    another event than the short one to it shows.
    """
    if variant == 2:  # a contact sticks
        blur(k.w, o.guards, 7.0, x)
    guard, place = first_event(k.w, o.guards, x.modes, x.flags, x.fired, x.margin, 0.0, k.b, k.stack)
    if guard < 0:
        if len(x.work) > 0:
            f.rate(variant, k.w, x.s, x.p, x.m)
            x.count[EVALUATIONS] += 7
        return guard, h, 1.0, True
    instant = 1e-15 * max(abs(x.s[0]), o.near)
    if place * h <= instant:
        # a guard that has just fired leaves its root: a step that is too long shows it coming back at once
        return guard, h, 0.0, not (x.fired[guard] and h > 1e-3 * o.near)
    keep(k.w, 8 * (o.first + 1), k.whole)
    row, side = o.guards + guard, side_of(guard, x.modes, x.flags)
    multiplicity, level = start_of(k.w, 8 * row, guard, side, x.fired, x.margin)
    if level != 0.0:
        level = aim(k.w, 8 * row, side, place, multiplicity, level, x.margin[guard], k.b)
    length, root, solved = locate(f, variant, k, x, o, h, place, row, multiplicity, level, guard)
    _, earlier = first_event(k.w, o.guards, x.modes, x.flags, x.fired, x.margin, ROUNDING, k.b, k.stack)
    return guard, length, root, solved and (root - earlier) * length <= instant + TOGETHER * length


@spliced
def _advance(f, variant, k, x, o, guard, length, root):
    """Take the step in k.w up to its place `root`: sections, samples, then the new base point."""
    count, n_x, at = x.count, o.n_q + o.n, 8 * (o.first + 1)
    powers = o.guards + len(x.fired) + (1 if o.section == 1 else 0)
    gains(k.w, powers, length, k.gain)
    if o.section == 1:
        sections(f, variant, k, x, o, length, root)
    if o.log_misses:
        misses(k, x, o, length, root)
    end, done = x.s[0] + length * root, count[SAMPLES]
    if abs(o.t_end - end) <= 4e-16 * abs(o.t_end):  # a sum of lengths may miss the end by rounding
        end = o.t_end
    if done < len(x.at):
        count[SAMPLES] = sample(
            x.samples, x.at, done, length, end, k.w, at, x.s, n_x, k.b, x.modes, k.gain, x.work
        )
    for g in range(len(x.fired)):
        x.fired[g] = 0
    if guard < 0:
        keep(k.w, at, k.past)
    _commit(k.w, x.s, k.gain, x.work, k.b, at, n_x, root, end)
    if o.log_steps and x.s[0] >= o.log_from:
        note(k, x, o, STEP_ROW, -1.0, 0.0, x.s[0], 0.0)


@inner
def _trouble(s, n_x):
    """Why no step is short enough: the state grew beyond measure, or the iteration does not converge."""
    for r in range(1 + n_x):
        if not abs(s[r]) < HUGE:
            return DIVERGED
    return NOT_CONVERGED


@inner
def _start(f, x, rest, out):
    """Set the contact modes that belong to the initial state."""
    f.trig(x.s, x.p)
    for j in range(len(x.modes)):
        x.modes[j] = CONTACT
        mask(x.modes, x.m)
        f.contacts(1, x.s, x.p, x.m, out)
        closed, force = out[6 * j] >= 0.0, out[6 * j + 3]
        x.modes[j] = FREE
        if closed and (x.flags[j] & PULLS or force > 0.0):
            touch(f.contacts, j, x.flags, x.modes, x.m, x.s, x.p, rest, out)
        elif closed:
            x.modes[j] = RELEASED
    x.real[T_EVENT] = x.real[T_SECTION] = -np.inf
    x.real[H_LIMIT] = np.inf
    x.count[STARTED] = 1


@spliced
def _go_on(f, variant, k, x, o, g, y, h, error):
    """Take an accurate attempt up to its first event, tangents with it, or shorten the next one."""
    count, real = x.count, x.real
    guard, length, root, sure = _reach(f, variant, k, x, o, h)
    strain = 0.0
    if y is not None and sure and root > 0.0:
        strain = carry(f, g, variant, k, x, o, y, length, root)
    if not sure:
        count[FAILED] += 1
        real[H], count[SMOOTH] = 0.5 * h, 0
        return
    if strain > 1.0:
        count[REJECTED] += 1
        real[H] = length * max(0.2, 0.9 * strain ** (-1.0 / ORDER))
        return
    count[STEPS] += 1
    if root > 0.0:
        _advance(f, variant, k, x, o, guard, length, root)
    if guard < 0:
        after_whole(real, count, variant, h, error)
        if y is not None and strain > 0.0:
            real[H] = min(real[H], 0.9 * h * strain ** (-1.0 / ORDER))
    else:
        if y is not None:
            meet(f, g, variant, x, o, y, guard)
        _event(f, k, x, o, guard)
        if y is not None:
            leap(f, g, x, o, y, guard)
    if y is not None:
        mark(x, y)
    count[FRESH] = 0


def run(f, k, x, o, g, y):
    """Run until the end, a full log, or trouble; give back which (OK, FULL, …). Call again to go on.

    With tangents y, and a structure's derivatives g, these are carried along (numerics.tangent_flow); where
    both are None, nothing of that is compiled.
    """
    count, real = x.count, x.real
    if not count[STARTED]:
        _start(f, x, o.rest, k.contact)
    while True:
        if count[LOGGED] + ROOM > len(x.log):
            return FULL
        if y is not None and y.count[ROWS] >= len(y.rows):
            return FULL
        if x.s[0] >= o.t_end or (o.stop_after and count[SECTIONS] >= o.stop_after):
            return OK
        if count[STEPS] + count[REJECTED] + count[FAILED] >= o.max_steps:
            return STEP_LIMIT
        variant = variant_of(x.modes)
        if not count[FRESH]:
            _new_base(f, k.weight, x, o.n_q + o.n)
            count[FRESH] = 1
        h = bounded(x.s, x.turning, min(real[H], o.h_max), o.n_q, o.t_end)
        error = attempt(f, variant, k, x, o, h)
        if error < 0.0:
            count[FAILED] += 1
            real[H], real[H_LIMIT] = 0.5 * h, 0.75 * h
            count[SMOOTH] = 1 if count[SMOOTH] and h > 0.2 * real[H_PAST] else 0
        elif not error < 1.0:
            count[REJECTED] += 1
            real[H] = shorter(real, h, error)
        elif swings(k.w, o.guards, x):
            count[FAILED] += 1
            real[H], real[H_LIMIT], count[SMOOTH] = 0.5 * h, 0.75 * h, 0
        else:
            if x.s[0] == real[T_EVENT]:
                learn_start(real, variant, h, error)
            _go_on(f, variant, k, x, o, g, y, h, error)
            if count[CLOSE] >= CHATTER_COUNT:
                return CHATTER
        if not real[H] > 1e-15 * max(abs(x.s[0]), o.near):
            return _trouble(x.s, o.n_q + o.n)


flow = entry(int64(FUNCTIONS, WORK, TRAJECTORY, OPTIONS, none, none))(run)  # without tangents
