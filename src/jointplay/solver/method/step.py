"""One step of the collocation method: prediction, Newton's iteration in the eigenbasis, error estimate.

Unknown are only the stage increments Z of the speeds; those of the positions follow exactly,

    Z = h A F(q_0 + Z_q, z_0 + Z),     Z_q = h c z_0 + h A Z,

so that the systems to solve have the size of z. Reference: Hairer and Wanner (see radau), section IV.8. The
sums over stages and unknowns come written out for the structure's size (codegen.algebra); here is what is
done with them. The increments live in the lane buffer `w`, those of the last accepted step in `past`, from
where the next are extrapolated.
"""

from .control import TURN, converged, error_ratio
from .interface import inlined, inner
from .memory import CONTRACTION, EVALUATIONS, H_PAST, SMOOTH

ITERATIONS = 10
ROUNDED = 0.5  # updates that stop shrinking below this many tolerated errors: what is left is rounding
STALE = 0.1  # largest last update, in tolerated errors: guards are those of the iterate before it
LATE = 4  # stage whose Jacobian serves the iteration: it is the late stages that are far from the base point


@inlined
def converge(functions, variant, work, motion, h, tolerance, contraction):
    """Newton's iteration from the predicted increments (moved), with the matrices factored for h.

    Gives back whether it converged, and the contraction that was observed (the next step's first guess at
    it).
    """
    w = work.w
    factor, before = max(contraction, 1e-16) ** 0.8, 1.0
    for iteration in range(1, ITERATIONS + 1):
        functions.rate(variant, w, motion.s, motion.p, motion.m)
        size = functions.newton(variant, w, motion.s, work.J, work.weight, h)
        motion.count[EVALUATIONS] += 7
        if not size < 1e100:
            break
        if iteration > 1:
            theta = size / before
            factor = error_ratio(theta)
            left = ITERATIONS - 1 - iteration
            ahead = _power(theta, left) if left >= 0 else 1.0 / max(theta, 1e-300)
            hopeless = factor * size * ahead > tolerance
            if hopeless and (iteration > 2 or theta > 1.0):  # two updates may be of different components
                return size < ROUNDED, 1.0
        if converged(size, factor, tolerance, STALE):
            return True, factor
        before = max(size, 1e-300)
    return False, 1.0


@inner
def _power(x, n):
    """Power of x, n a whole number from 0 on; a negative one, as ** has it, would raise an error at 0."""
    found = 1.0
    while n > 0:
        if n % 2 == 1:
            found *= x
        x *= x
        n //= 2
    return found


@inlined
def attempt(functions, variant, work, motion, options, h):
    """Attempt a step of length h; its error in units of the tolerance, -1 if it did not converge."""
    w, s, real, first = work.w, motion.s, motion.real, 8 * options.first
    if motion.count[SMOOTH]:
        functions.extrapolate(w, work.past, 1.0, h / real[H_PAST])
    else:
        functions.rest(w)
    functions.move(w, s, h)
    for r in range(1 + options.n_q + options.n):
        work.predicted[r] = s[r] + w[first + 8 * r + LATE]
    functions.trig(work.predicted, motion.p)
    functions.jacobian(variant, work.predicted, motion.p, motion.m, work.J)
    functions.factor(variant, w, work.J, h)
    solved, real[CONTRACTION] = converge(
        functions, variant, work, motion, h, options.newton, real[CONTRACTION]
    )
    if not solved or _turned(w, motion.turning, first + 8, options.n_q):
        return -1.0
    return estimate(functions, variant, work, motion, options, h)


@inner
def estimate(functions, variant, work, motion, options, h):
    """Error of the step of length h in work, whose matrices are factored, in units of the tolerance."""
    for r in range(options.n_q):
        work.error[r] = motion.s[1 + options.n_q + r]
    for r in range(options.n):
        work.error[options.n_q + r] = work.w[8 * (options.first + 1 + options.n_q + options.n + r) + 7]
    size = functions.estimate(variant, work.w, work.J, work.weight, work.error, h)
    if size >= 1.0 and not motion.count[SMOOTH]:
        size = _estimate_again(functions, variant, work, motion, options, h)
    return size


@inlined
def _turned(w, turning, at, n_q):
    """Whether an angle turned further in the step than the structure's polynomials reach."""
    largest = 0.0
    for r in range(n_q):
        for i in range(7):
            largest = max(largest, turning[r] * abs(w[at + 8 * r + i]))
    return not largest <= TURN


@inner
def _estimate_again(functions, variant, work, motion, options, h):
    """The estimate with f(x + error) in the place of f(x): sharper for stiff parts of a first step."""
    w, s, error, n_x, state = work.w, motion.s, work.error, options.n_q + options.n, 8 * (options.first + 1)
    for r in range(n_x):
        w[state + 8 * r + 7] = error[r]
    functions.rate(variant, w, s, motion.p, motion.m)
    motion.count[EVALUATIONS] += 1
    for r in range(options.n_q):
        error[r] = s[1 + options.n_q + r] + w[state + 8 * (options.n_q + r) + 7]
    for r in range(options.n):
        error[options.n_q + r] = w[state + 8 * (n_x + r) + 7]
    for r in range(n_x):
        w[state + 8 * r + 7] = 0.0
    size = functions.estimate(variant, w, work.J, work.weight, error, h)
    if size < 1.0:  # guards are looked at next: at the base point, not beside it
        functions.rate(variant, w, s, motion.p, motion.m)
        motion.count[EVALUATIONS] += 1
    return size


@inner
def keep(w, at, target):
    """Copy increments out of the lane buffer."""
    for i in range(len(target)):
        target[i] = w[at + i]
