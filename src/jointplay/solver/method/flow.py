"""The event-driven flow: smooth pieces by the collocation method, joined at located events.

One loop for every structure. A piece runs until a guard leaves its side; the state is taken there, the mode
changes (or the state jumps), and the next piece starts from the new side. Numerical trouble is a status,
never an exception.
"""

import numpy as np

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
from .events import THERE, accept_until_event, begins_beyond, dead_centre, state_at, too_long
from .interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, WORK, Signature, inlined, inner, spliced
from .memory import (
    BASE_SET,
    CLOSE_EVENTS,
    CONTRACTION,
    EVENT_ROW,
    EVENTS,
    FAILED,
    FOLLOWED,
    GROWTH,
    H_EXCITED,
    H_LIMIT,
    H_PAST,
    H_REJECTED,
    H_START,
    H_VARIANT,
    IDLE_STEPS,
    JAMMED,
    LOGGED,
    REJECTED,
    SAMPLES,
    SECTIONS,
    SIMULTANEOUS,
    SMOOTH,
    STARTED,
    STEP_ROW,
    STEPS,
    T_EVENT,
    T_SECTION,
    H,
)
from .modes import FREE, IN_FLIGHT, REMEMBERS, follow, mask, start, variant_of
from .polynomial import interpolate
from .record import closest_approaches, count_event, gains, is_coarse, note, note_coarse, sample, sections
from .step import attempt, estimate, keep
from .tangents.saltation import before_event, begin_tangents, delays_known, jump, stay, stuck
from .tangents.tangent import NEUTRAL, ROWS, log_block, propagate, renew
from .walls.walls import SEEK_GROWTH, START, STEP, resting, walls_of

_, BY_LEVEL, _ = Section.numbers()
ROOM = 24  # log rows that one step may need


@inlined
def _new_base(functions, weight, motion, n_x):
    """Sines, masks and weights of a new base point."""
    functions.trig(motion.s, motion.p)
    mask(motion.modes, motion.m)
    for r in range(n_x):
        weight[r] = 1.0 / (motion.absolute[r] + motion.relative[r] * abs(motion.s[1 + r]))


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
def _at_wall(functions, guard, at, work, motion, options):
    functions.at_wall(functions, guard, at, work, motion, options)


@inner
def event(functions, work, motion, options, guard):
    """Change mode, or jump, at the base point; count events that crowd."""
    count, real, time = motion.count, motion.real, motion.s[0]
    functions.trig(motion.s, motion.p)
    count[CLOSE_EVENTS] = close_events(count[CLOSE_EVENTS], time - real[T_EVENT], options.chatter_time)
    real[T_EVENT] = time
    count[EVENTS] += 1
    at, logged = count[LOGGED], options.log_events and time >= options.log_from
    if logged:
        note(work, motion, options, EVENT_ROW, -1.0, 0.0, time, 0.0)
    j = guard // 4
    if j < len(motion.flags):
        flags, modes, s, p = motion.flags, motion.modes, motion.s, motion.p
        before, out, speed = modes[j], work.contact, options.speed_tolerance
        if before == FREE and flags[j] & REMEMBERS:
            functions.reset(2 * walls_of(motion) + j, s, p)
        kind = follow(
            functions.contacts, j, guard % 4, flags, modes, motion.fired, motion.m, s, p, speed, out
        )
        if before != FREE and modes[j] == FREE and flags[j] & REMEMBERS:
            functions.reset(2 * walls_of(motion) + len(flags) + j, s, p)
        if logged:
            motion.log[at, 1], motion.log[at, 2] = j, kind
        count_event(work, motion, options, j, kind, time)
    else:
        _at_wall(functions, guard, at if logged else -1, work, motion, options)
    count[SMOOTH], real[CONTRACTION], real[H_LIMIT], real[H_REJECTED] = 0, 1.0, np.inf, 0.0
    variant = variant_of(motion.modes)
    real[H] = restarted(real[H], real[H_VARIANT + variant], real[H_START + variant])
    if options.log_steps and motion.s[0] >= options.log_from:
        note(work, motion, options, STEP_ROW, -1.0, 0.0, motion.s[0], 0.0)


@spliced
def _advance(functions, variant, work, motion, options, guard, length, root, coarse):
    """Take the step in work.w up to its place `root`: sections, samples, then the new base point."""
    count, n_x, at = motion.count, options.n_q + options.n, 8 * (options.first + 1)
    recorded = count[SAMPLES] + count[SECTIONS]
    powers = options.guards + len(motion.fired) + (1 if options.section == BY_LEVEL else 0)
    gains(work.w, powers, length, work.gain)
    if options.section == BY_LEVEL:
        sections(functions, variant, work, motion, options, length, root)
    if options.log_misses:
        closest_approaches(work, motion, options, length, root)
    end, done = motion.s[0] + length * root, count[SAMPLES]
    if at_end(end, options.t_end):
        end = options.t_end
    if done < len(motion.sample_times):
        samples, times, s, modes = motion.samples, motion.sample_times, motion.s, motion.modes
        count[SAMPLES] = sample(
            samples, times, done, length, end, work.w, at, s, n_x, work.b, modes, work.gain, motion.work
        )
    followed = options.log_steps and end >= options.log_from
    if coarse and (followed or count[SAMPLES] + count[SECTIONS] > recorded):
        note_coarse(work, motion, options, end)
    for g in range(len(motion.fired)):
        motion.fired[g] = 0
    if guard < 0:
        keep(work.w, at, work.past)
    _commit(work.w, motion.s, work.gain, motion.work, work.b, at, n_x, root, end)
    if options.log_steps and motion.s[0] >= options.log_from:
        note(work, motion, options, STEP_ROW, -1.0, 0.0, motion.s[0], 0.0)


@inner
def initial_modes(functions, work, motion, options):
    """Set the contact modes that belong to the initial state."""
    flags, m, s, p = motion.flags, motion.m, motion.s, motion.p
    functions.trig(s, p)
    for j in range(len(flags)):
        start(functions.contacts, j, flags, motion.modes, m, s, p, options.speed_tolerance, work.contact)
    if walls_of(motion) > 0:
        _at_wall(functions, START, START, work, motion, options)
    motion.real[T_EVENT] = motion.real[T_SECTION] = -np.inf
    motion.real[H_LIMIT] = np.inf
    motion.count[STARTED] = 1


@spliced
def _take(functions, variant, work, motion, options, derivatives, tangents, h, error):
    """Take an accurate attempt up to its first event, tangents with it, or shorten the next one.

    The step to the event has to be accurate itself: its last stages see there what lay between two stages of
    the attempt, as the top that friction has at rest, which the motion beyond leaves at once.
    """
    count, real = motion.count, motion.real
    coarse = options.rate_tolerance > 0.0 and is_coarse(work, motion, options, h)
    guard, length, root, sure = accept_until_event(functions, variant, work, motion, options, h)
    strain = 0.0
    if sure and guard >= 0 and root > 0.0:
        short = estimate(functions, variant, work, motion, options, length)
        if not short < 1.0:
            count[REJECTED] += 1
            real[H] = shorter(real, length, short)
            return
    if tangents is not None and sure and root > 0.0:
        strain = propagate(functions, derivatives, variant, work, motion, options, tangents, length, root)
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
        _advance(functions, variant, work, motion, options, guard, length, root, coarse)
        if tangents is not None:
            if guard < 0 and stuck(motion.modes) + resting(motion) > 0:
                stay(functions, derivatives, motion, options, tangents)
            renew(functions, variant, motion, options, tangents, length * root)
    if guard < 0:
        if resting(motion) > 0:
            _at_wall(functions, STEP, STEP, work, motion, options)
        after_whole(real, count, variant, h, error)
        if tangents is not None and strain > 0.0:
            real[H] = min(real[H], 0.9 * h * strain ** (-1.0 / ORDER))
    else:
        follows = root == 0.0 and motion.s[0] == real[T_EVENT]
        follows = follows and begins_beyond(work.w, options.guards + guard)
        if tangents is not None:
            if follows and not delays_known(tangents, options):
                count[SIMULTANEOUS] += 1
            before_event(functions, derivatives, variant, motion, options, tangents, guard, follows)
        event(functions, work, motion, options, guard)
        count[FOLLOWED] += 1 if follows else 0
        if follows and guard // 4 < len(motion.flags):
            motion.fired[guard] = 0  # the event before has put it beyond zero
        if tangents is not None:
            jump(functions, derivatives, work, motion, options, tangents, guard)
    if tangents is not None:
        log_block(motion, tangents)
    count[BASE_SET] = 0


@inner
def run(functions, work, motion, options, derivatives, tangents):
    """Run until the end, a full log, or trouble; give back which (OK, FULL, …). Call again to go on.

    What these records are stands in method.memory. Tangents are carried along by the structure's derivatives
    (method.tangents.tangent_flow); where both are None, nothing of that is compiled.
    """
    count, real = motion.count, motion.real
    if not count[STARTED]:
        initial_modes(functions, work, motion, options)
        if tangents is not None:
            begin_tangents(functions, derivatives, motion, options, tangents)
            if tangents.count[NEUTRAL]:
                renew(functions, variant_of(motion.modes), motion, options, tangents, 0.0)
    while True:
        if count[LOGGED] + ROOM > len(motion.log):
            return FULL
        if tangents is not None and tangents.count[ROWS] >= len(tangents.rows):
            return FULL
        if motion.s[0] >= options.t_end or (options.stop_after and count[SECTIONS] >= options.stop_after):
            return OK
        if count[STEPS] + count[REJECTED] + count[FAILED] >= options.max_steps:
            return STEP_LIMIT
        variant = variant_of(motion.modes)
        if not count[BASE_SET]:
            _new_base(functions, work.weight, motion, options.n_q + options.n)
            count[BASE_SET] = 1
        h = bounded(
            min(real[H], options.h_max),
            fastest(motion.s, motion.turning, options.n_q),
            TURN,
            options.t_end - motion.s[0],
        )
        error = attempt(functions, variant, work, motion, options, h)
        excited = False
        if derivatives is not None:
            excited = real[GROWTH] > 0.0 and variant > IN_FLIGHT and 0.0 <= error < 1.0
            if excited:
                _at_wall(functions, SEEK_GROWTH, SEEK_GROWTH, work, motion, options)
        if error < 0.0:
            count[FAILED] += 1
            real[H], real[H_LIMIT] = 0.5 * h, 0.75 * h
            count[SMOOTH] = 1 if count[SMOOTH] and h > 0.2 * real[H_PAST] else 0
        elif not error < 1.0:
            count[REJECTED] += 1
            real[H] = shorter(real, h, error)
        elif excited and real[H_EXCITED] < h:
            count[FAILED] += 1
            real[H], real[H_LIMIT], count[SMOOTH] = real[H_EXCITED], 0.75 * real[H_EXCITED], 0
        elif too_long(work.w, motion, options, h):
            count[FAILED] += 1
            real[H], real[H_LIMIT], count[SMOOTH] = 0.5 * h, 0.75 * h, 0
        else:
            if motion.s[0] == real[T_EVENT]:
                kept = real[H_START + variant]
                real[H_START + variant] = learnt(kept, real[H_REJECTED] > 0.0, h, error)
            count[IDLE_STEPS] = idle_steps(
                count[IDLE_STEPS], h, options.chatter_time, work.w, 8 * (options.first + 1), work.weight
            )
            _take(functions, variant, work, motion, options, derivatives, tangents, h, error)
            if count[JAMMED] > 0:
                return WEDGED
            if count[IDLE_STEPS] >= IDLE_COUNT:
                return NOT_CONVERGED
            if tangents is not None and len(tangents.alive) > 0 and count[SIMULTANEOUS] > 0:
                return NO_DERIVATIVE
            if count[CLOSE_EVENTS] >= CHATTER_COUNT:
                return CHATTER
        if dead_centre(work.w, options) == THERE or not real[H] > instant(motion.s[0], options.chatter_time):
            return failure(motion.s, options.n_q + options.n)


flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, WORK, TRAJECTORY, OPTIONS, None, None))}  # without tangents
