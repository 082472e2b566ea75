"""The event-driven flow: smooth pieces by the collocation method, joined at located events.

One loop for every structure. A piece runs until a guard leaves its side; the state is taken there, the mode
changes (or the state jumps), and the next piece starts from the new side. Numerical trouble is a status,
never an exception.
"""

import numpy as np

from .coarse_steps import doubt, doubtful
from .codes import Section
from .control import (
    CHATTER,
    CHATTER_COUNT,
    FULL,
    IDLE_COUNT,
    NO_DERIVATIVE,
    NOT_CONVERGED,
    OK,
    ORDER,
    STEP_LIMIT,
    TURN,
    WEDGED,
    after_whole,
    at_end,
    bounded,
    close_events,
    failure,
    fastest,
    idle_steps,
    instant,
    learnt,
    restarted,
    shorter,
)
from .events import AWAY, THERE, accept_until_event, begins_beyond, dead_centre, passes_centre, state_at
from .interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, WORK, Signature, inlined, inner, spliced
from .memory import (
    CLOSE,
    CONTRACTION,
    EVENT_ROW,
    EVENTS,
    FAILED,
    FOLLOWED,
    FRESH,
    GROWTH,
    H_LIMIT,
    H_PAST,
    H_REJECTED,
    H_START,
    H_VARIANT,
    IDLE,
    JAMMED,
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
    TOGETHER,
    H,
)
from .modes import FREE, IN_FLIGHT, REMEMBERS, follow, mask, start, variant_of
from .polynomial import interpolate
from .record import closest_approaches, gains, note, sample
from .sections import count_event, sections
from .step import attempt, estimate, keep
from .tangents.saltation import before_event, begin_tangents, jump
from .tangents.tangent import NEUTRAL, ROWS, log_block, propagate, renew
from .walls.sliding import walls_of
from .walls.walls import LOOK, START, STEP, resting

_, BY_LEVEL, _ = Section.numbers()
ROOM = 24  # log rows that one step may need


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
    start = 0 * n_x  # a variable, for the reason that interface gives
    interpolate(gain, start, work, start, len(work), b, work)
    s[0] = time
    for i in range(8 * n_x):  # from here on the increments are of the new base point
        w[at + i] = 0.0
    for i in range(len(gain)):
        gain[i] = 0.0


@inlined
def _at_wall(f, guard, at, k, x, o):
    f.at_wall(f, guard, at, k, x, o)


@inner
def event(f, k, x, o, guard):
    """Change mode, or jump, at the base point; count events that crowd."""
    count, real, time = x.count, x.real, x.s[0]
    f.trig(x.s, x.p)
    count[CLOSE] = close_events(count[CLOSE], time - real[T_EVENT], o.near)
    real[T_EVENT] = time
    count[EVENTS] += 1
    at, logged = count[LOGGED], o.log_events and time >= o.log_from
    if logged:
        note(k, x, o, EVENT_ROW, -1.0, 0.0, time, 0.0)
    j = guard // 4
    if j < len(x.flags):
        before = x.modes[j]
        if before == FREE and x.flags[j] & REMEMBERS:
            f.reset(2 * walls_of(x) + j, x.s, x.p)
        kind = follow(f.contacts, j, guard % 4, x.flags, x.modes, x.fired, x.m, x.s, x.p, o.rest, k.contact)
        if before != FREE and x.modes[j] == FREE and x.flags[j] & REMEMBERS:
            f.reset(2 * walls_of(x) + len(x.flags) + j, x.s, x.p)
        if logged:
            x.log[at, 1], x.log[at, 2] = j, kind
        count_event(k, x, o, j, kind, time)
    else:
        _at_wall(f, guard, at if logged else -1, k, x, o)
    count[SMOOTH], real[CONTRACTION], real[H_LIMIT], real[H_REJECTED] = 0, 1.0, np.inf, 0.0
    variant = variant_of(x.modes)
    real[H] = restarted(real[H], real[H_VARIANT + variant], real[H_START + variant])
    if o.log_steps and x.s[0] >= o.log_from:
        note(k, x, o, STEP_ROW, -1.0, 0.0, x.s[0], 0.0)


@spliced
def _advance(f, variant, k, x, o, guard, length, root, doubts):
    """Take the step in k.w up to its place `root`: sections, samples, then the new base point."""
    count, n_x, at = x.count, o.n_q + o.n, 8 * (o.first + 1)
    recorded = count[SAMPLES] + count[SECTIONS]
    powers = o.guards + len(x.fired) + (1 if o.section == BY_LEVEL else 0)
    gains(k.w, powers, length, k.gain)
    if o.section == BY_LEVEL:
        sections(f, variant, k, x, o, length, root)
    if o.log_misses:
        closest_approaches(k, x, o, length, root)
    end, done = x.s[0] + length * root, count[SAMPLES]
    if at_end(end, o.t_end):
        end = o.t_end
    if done < len(x.at):
        count[SAMPLES] = sample(
            x.samples, x.at, done, length, end, k.w, at, x.s, n_x, k.b, x.modes, k.gain, x.work
        )
    followed = o.log_steps and end >= o.log_from
    if doubts and (followed or count[SAMPLES] + count[SECTIONS] > recorded):
        doubt(k, x, o, end)
    for g in range(len(x.fired)):
        x.fired[g] = 0
    if guard < 0:
        keep(k.w, at, k.past)
    _commit(k.w, x.s, k.gain, x.work, k.b, at, n_x, root, end)
    if o.log_steps and x.s[0] >= o.log_from:
        note(k, x, o, STEP_ROW, -1.0, 0.0, x.s[0], 0.0)


@inner
def initial_modes(f, k, x, o):
    """Set the contact modes that belong to the initial state."""
    f.trig(x.s, x.p)
    for j in range(len(x.flags)):
        start(f.contacts, j, x.flags, x.modes, x.m, x.s, x.p, o.rest, k.contact)
    if walls_of(x) > 0:
        _at_wall(f, START, START, k, x, o)
    x.real[T_EVENT] = x.real[T_SECTION] = -np.inf
    x.real[H_LIMIT] = np.inf
    x.count[STARTED] = 1


@spliced
def _take(f, variant, k, x, o, g, y, h, error):
    """Take an accurate attempt up to its first event, tangents with it, or shorten the next one.

    The step to the event has to be accurate itself: its last stages see there what lay between two stages of
    the attempt, as the top that friction has at rest, which the motion beyond leaves at once.
    """
    count, real = x.count, x.real
    doubts = o.sharp > 0.0 and doubtful(k, x, o, h)
    guard, length, root, sure = accept_until_event(f, variant, k, x, o, h)
    strain = 0.0
    if sure and guard >= 0 and root > 0.0:
        short = estimate(f, variant, k, x, o, length)
        if not short < 1.0:
            count[REJECTED] += 1
            real[H] = shorter(real, length, short)
            return
    if y is not None and sure and root > 0.0:
        strain = propagate(f, g, variant, k, x, o, y, length, root)
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
        _advance(f, variant, k, x, o, guard, length, root, doubts)
        if y is not None:
            renew(f, variant, x, o, y, length * root)
    if guard < 0:
        if resting(x) > 0:
            _at_wall(f, STEP, STEP, k, x, o)
        after_whole(real, count, variant, h, error)
        if y is not None and strain > 0.0:
            real[H] = min(real[H], 0.9 * h * strain ** (-1.0 / ORDER))
    else:
        if y is not None:
            follows = len(y.alive) > 0 and root == 0.0 and x.s[0] == real[T_EVENT]
            if follows and begins_beyond(k.w, o.guards + guard):
                count[TOGETHER] += 1
            before_event(f, g, variant, x, o, y, guard)
        event(f, k, x, o, guard)
        if y is not None:
            jump(f, g, k, x, o, y, guard)
    if y is not None:
        log_block(x, y)
    count[FRESH] = 0


@inner
def run(f, k, x, o, g, y):
    """Run until the end, a full log, or trouble; give back which (OK, FULL, …). Call again to go on.

    What f, k, x, o, g and y are stands in method.memory. With tangents y, and a structure's derivatives g,
    these are carried along (method.tangents.tangent_flow); where both are None, nothing of that is compiled.
    """
    count, real = x.count, x.real
    if not count[STARTED]:
        initial_modes(f, k, x, o)
        if y is not None:
            begin_tangents(f, g, x, o, y)
            if y.count[NEUTRAL]:
                renew(f, variant_of(x.modes), x, o, y, 0.0)
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
        h = bounded(min(real[H], o.h_max), fastest(x.s, x.turning, o.n_q), TURN, o.t_end - x.s[0])
        error = attempt(f, variant, k, x, o, h)
        excited = False
        if g is not None:
            excited = real[GROWTH] > 0.0 and variant > IN_FLIGHT and 0.0 <= error < 1.0
            if excited:
                _at_wall(f, LOOK, LOOK, k, x, o)
        if error < 0.0:
            count[FAILED] += 1
            real[H], real[H_LIMIT] = 0.5 * h, 0.75 * h
            count[SMOOTH] = 1 if count[SMOOTH] and h > 0.2 * real[H_PAST] else 0
        elif not error < 1.0:
            count[REJECTED] += 1
            real[H] = shorter(real, h, error)
        elif excited and real[FOLLOWED] < h:
            count[FAILED] += 1
            real[H], real[H_LIMIT], count[SMOOTH] = real[FOLLOWED], 0.75 * real[FOLLOWED], 0
        elif passes_centre(k.w, o.guards, x) or dead_centre(k.w, o) != AWAY:
            count[FAILED] += 1
            real[H], real[H_LIMIT], count[SMOOTH] = 0.5 * h, 0.75 * h, 0
        else:
            if x.s[0] == real[T_EVENT]:
                kept = real[H_START + variant]
                real[H_START + variant] = learnt(kept, real[H_REJECTED] > 0.0, h, error)
            count[IDLE] = idle_steps(count[IDLE], h, o.near, k.w, 8 * (o.first + 1), k.weight)
            _take(f, variant, k, x, o, g, y, h, error)
            if count[JAMMED] > 0:
                return WEDGED
            if count[IDLE] >= IDLE_COUNT:
                return NOT_CONVERGED
            if y is not None and count[TOGETHER] > 0:
                return NO_DERIVATIVE
            if count[CLOSE] >= CHATTER_COUNT:
                return CHATTER
        if dead_centre(k.w, o) == THERE or not real[H] > instant(x.s[0], o.near):
            return failure(x.s, o.n_q + o.n)


flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, WORK, TRAJECTORY, OPTIONS, None, None))}  # without tangents
