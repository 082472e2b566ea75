"""Contact modes: the guards watched in each, the changes when a guard fires, and sticking.

Per contact: free; released (gap still closed, force gone: laws that do not pull); slipping + or -;
sticking; or just in contact (no Coulomb friction). Per rigid wall: free; or resting, where it is rough
slipping + or - or sticking (method.walls.walls). At
v_t = 0 the two one-sided accelerations of v_t decide (Filippov): with a_+ that of slipping + and a_- that of
slipping -, both pushing towards v_t = 0 (a_+ < 0 < a_-) means sticking. Where the force pulls (F_n < 0)
friction drives, the sector repels, and the motion keeps its direction.

A switch that slides does so along a force that changes v_t the other way (equations.own.own). Where it
no longer does, |F| <= 1 means that both sides lead away, and any time at which the motion leaves is a
solution: it is kept where it is, so that the run ends there.

Reference: Filippov, Differential Equations with Discontinuous Righthand Sides (1988); Leine and Nijmeijer
(2004).
"""

from .codes import Event, Mode, Variant
from .interface import compiled, inner

FREE, RELEASED, SLIP_POSITIVE, SLIP_NEGATIVE, STICK, CONTACT, RESTING = Mode.numbers()
IN_FLIGHT, SLIPPING, STICKING = Variant.numbers()
ENTRY, SEPARATION, REOPENING, SLIP_REVERSAL, STICK_ONSET, SLIP_ONSET, IMPACT, REST = Event.numbers()
GAP, FORCE, SLIDE, CONE = range(4)
BALANCED = 1e-14  # of the distance of both accelerations: rounding of one that is 0
PULLS, STICKS, REMEMBERS, SHARES, SWITCHES, FORCELESS = 1, 2, 4, 8, 16, 32


@compiled
def variant_of(modes):
    """Variant of the structure's equations (codes.Variant) that belongs to these modes."""
    variant = IN_FLIGHT
    for mode in modes:
        if mode == STICK:
            return STICKING
        if mode > RELEASED:
            variant = SLIPPING
    return variant


@compiled
def mask(modes, m):
    """Write the modes as the numbers touch, slip, stick of every contact."""
    for j in range(len(modes)):
        mode = modes[j]
        m[3 * j] = 1.0 if mode > RELEASED else 0.0
        m[3 * j + 1] = 1.0 if mode == SLIP_POSITIVE else (-1.0 if mode == SLIP_NEGATIVE else 0.0)
        m[3 * j + 2] = 1.0 if mode == STICK else 0.0


@inner
def inside(mode, guard, pulls):
    """The side (+1, -1) on which a guard stays in this mode; 0 if it is not watched."""
    if mode == FREE:
        return -1 if guard == GAP else 0
    if mode == RELEASED:
        return 1 if guard == GAP else (-1 if guard == FORCE else 0)
    if guard == GAP:  # also where the force goes first: past the bearing's centre it turns unseen
        return 1
    if guard == FORCE:  # nothing that pulls sticks
        return 1 if mode == STICK or not pulls else 0
    if guard == SLIDE:
        return 1 if mode == SLIP_POSITIVE else (-1 if mode == SLIP_NEGATIVE else 0)
    return 1 if mode == STICK else 0


@inner
def contact_numbers(contacts, modes, m, s, p, out):
    """Six numbers a contact, and a rigid wall (codegen.module), with `modes` in force."""
    mask(modes, m)
    contacts(max(variant_of(modes), SLIPPING), s, p, m, out)


@inner
def _settle(contacts, j, modes, m, s, p, out):
    """Decide the mode of contact j, which touches with v_t = 0, from both one-sided accelerations."""
    before = modes[j]
    modes[j] = SLIP_POSITIVE
    contact_numbers(contacts, modes, m, s, p, out)
    plus = out[6 * j + 5]
    modes[j] = SLIP_NEGATIVE
    contact_numbers(contacts, modes, m, s, p, out)
    modes[j] = balance(plus, out[6 * j + 5], before)


@inner
def balance(plus, minus, before):
    """Mode at v_t = 0, by the accelerations of slipping + and -, and the mode before.

    What begins at the limit, to rounding, sticks: if the load grows, it leaves at once.
    """
    limit = BALANCED * (minus - plus) if before == CONTACT else 0.0
    if plus < limit and minus > -limit:
        return STICK
    if plus > 0.0 and (minus >= 0.0 or before == SLIP_POSITIVE):
        return SLIP_POSITIVE
    if minus < 0.0 and (plus <= 0.0 or before == SLIP_NEGATIVE):
        return SLIP_NEGATIVE
    return SLIP_POSITIVE if plus > 0.0 else SLIP_NEGATIVE


@inner
def touch(contacts, j, flags, modes, m, s, p, speed_tolerance, out):
    """Contact j begins: slip direction by the sign of v_t, or by its acceleration where v_t is at rest."""
    modes[j] = CONTACT
    if flags[j] & STICKS:
        contact_numbers(contacts, modes, m, s, p, out)
        v_t = out[6 * j + 2]
        if abs(v_t) <= speed_tolerance:
            _settle(contacts, j, modes, m, s, p, out)
        else:
            modes[j] = SLIP_POSITIVE if v_t > 0.0 else SLIP_NEGATIVE


@inner
def start(contacts, j, flags, modes, m, s, p, speed_tolerance, out):
    """Set the mode of contact j that belongs to an initial state."""
    touches = SLIPPING + 0 * j  # a variable, for the reason that interface gives
    modes[j] = CONTACT
    mask(modes, m)
    contacts(touches, s, p, m, out)
    closed, force = out[6 * j] >= 0.0, out[6 * j + 3]
    modes[j] = FREE
    if closed and (flags[j] & PULLS or force > 0.0):
        touch(contacts, j, flags, modes, m, s, p, speed_tolerance, out)
    elif closed:
        modes[j] = RELEASED


@inner
def _loosen(contacts, except_for, flags, modes, fired, m, s, p, speed_tolerance, out):
    """Sticking contacts whose cone was left by a jump elsewhere begin to slip.

    Of those that share a face, one may stick from here on as another does; its v_t has no root of its own.
    """
    for _ in range(len(modes)):
        changed = False
        contact_numbers(contacts, modes, m, s, p, out)
        for j in range(len(flags)):
            slips = modes[j] == SLIP_POSITIVE or modes[j] == SLIP_NEGATIVE
            still = flags[j] & SHARES and slips and abs(out[6 * j + 2]) <= speed_tolerance
            if (modes[j] == STICK or still) and j != except_for:
                held = modes[j]
                _settle(contacts, j, modes, m, s, p, out)
                if modes[j] != held:
                    fired[4 * j + SLIDE] = 1
                    changed = True
        if not changed:
            return


@inner
def follow(contacts, j, guard, flags, modes, fired, m, s, p, speed_tolerance, out):
    """Change modes after a guard of contact j fired at the base point; give back the kind of event.

    `fired` takes the multiplicity with which guards start at zero.
    """
    before, kind = modes[j], SEPARATION
    fired[4 * j + guard] = 1
    gone = not flags[j] & PULLS and guard in (GAP, FORCE)
    if gone and guard == GAP:  # the force may end with the gap
        contact_numbers(contacts, modes, m, s, p, out)
        gone = out[6 * j + 3] <= 0.0
    if before == FREE or (before == RELEASED and guard == FORCE):
        kind = ENTRY
        touch(contacts, j, flags, modes, m, s, p, speed_tolerance, out)
        contact_numbers(contacts, modes, m, s, p, out)
        if not (flags[j] & PULLS) and out[6 * j + 3] <= 0.0:
            fired[4 * j + FORCE] = 1
    elif before == RELEASED:
        kind = REOPENING
        modes[j] = FREE
    elif gone:
        modes[j] = RELEASED
        fired[4 * j + FORCE] = 1
    elif guard == GAP:
        modes[j] = FREE
    elif guard == SLIDE:
        _settle(contacts, j, modes, m, s, p, out)
        kind = STICK_ONSET if modes[j] == STICK else SLIP_REVERSAL
    elif guard == FORCE and flags[j] & SWITCHES:
        kind = SLIP_ONSET
    else:
        kind = SLIP_ONSET
        contact_numbers(contacts, modes, m, s, p, out)
        modes[j] = SLIP_POSITIVE if out[6 * j + 4] > 0.0 else SLIP_NEGATIVE
        fired[4 * j + SLIDE] = 2
    _loosen(contacts, j, flags, modes, fired, m, s, p, speed_tolerance, out)
    contact_numbers(contacts, modes, m, s, p, out)
    return kind
