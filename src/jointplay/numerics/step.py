"""One step of the collocation method: prediction, Newton's iteration in the eigenbasis, error estimate.

Unknown are only the stage increments Z of the speeds; those of the positions follow exactly,

    Z = h A F(q_0 + Z_q, z_0 + Z),     Z_q = h c z_0 + h A Z,

so that the systems to solve have the size of z. Reference: Hairer and Wanner (see radau), section IV.8. The
sums over stages and unknowns come written out for the structure's size (codegen.algebra); here is what is
done with them. The increments live in the lane buffer `w`, those of the last accepted step in `past`, from
where the next are extrapolated.
"""

from .interface import compiled, inlined
from .memory import CONTRACTION, EVALUATIONS, H_PAST, SMOOTH

ITERATIONS = 10
STALE = 0.1  # largest last update, in tolerated errors: guards are those of the iterate before it
ORDER = 8  # of the error estimate in h
TURN = 0.75  # largest increment of an angle in a step: where the structure's polynomials hold


@inlined
def converge(f, variant, k, x, h, tolerance, contraction):
    """Newton's iteration from the predicted increments, with the matrices factored for h.

    Gives back whether it converged, and the contraction that was observed (the next step's first guess at
    it).
    """
    w = k.w
    f.move(w, x.s, h)
    factor, before = max(contraction, 1e-16) ** 0.8, 1.0
    for iteration in range(1, ITERATIONS + 1):
        f.rate(variant, w, x.s, x.p, x.m)
        size = f.newton(variant, w, x.s, k.J, k.weight, h)
        x.count[EVALUATIONS] += 7
        if not size < 1e100:
            break
        if iteration > 1:
            theta = size / before
            if theta >= 0.99:
                break
            factor = theta / (1.0 - theta)
            if factor * size * theta ** (ITERATIONS - 1 - iteration) > tolerance:
                break
        if factor * size <= tolerance and size <= STALE:
            return True, factor
        before = max(size, 1e-300)
    return False, 1.0


@inlined
def attempt(f, variant, k, x, o, h):
    """Attempt a step of length h; its error in units of the tolerance, -1 if it did not converge."""
    w, s, real, first = k.w, x.s, x.real, 8 * o.first
    f.factor(variant, w, k.J, h)
    if x.count[SMOOTH]:
        f.extrapolate(w, k.past, 1.0, h / real[H_PAST])
    else:
        f.rest(w)
    solved, real[CONTRACTION] = converge(f, variant, k, x, h, o.newton, real[CONTRACTION])
    if not solved or _turned(w, x.turning, first + 8, o.n_q):
        return -1.0
    for r in range(o.n_q):
        k.error[r] = s[1 + o.n_q + r]
    for r in range(o.n):
        k.error[o.n_q + r] = w[first + 8 * (1 + o.n_q + o.n + r) + 7]
    size = f.estimate(variant, w, k.J, k.weight, k.error, h)
    if size >= 1.0 and not x.count[SMOOTH]:
        size = _estimate_again(f, variant, k, x, o, h)
    return size


@compiled
def _turned(w, turning, at, n_q):
    """Whether an angle turned further in the step than the structure's polynomials reach."""
    largest = 0.0
    for r in range(n_q):
        for i in range(7):
            largest = max(largest, turning[r] * abs(w[at + 8 * r + i]))
    return not largest <= TURN


@compiled
def _estimate_again(f, variant, k, x, o, h):
    """The estimate with f(x + error) in the place of f(x): sharper for stiff parts of a first step."""
    w, s, error, n_x, state = k.w, x.s, k.error, o.n_q + o.n, 8 * (o.first + 1)
    for r in range(n_x):
        w[state + 8 * r + 7] = error[r]
    f.rate(variant, w, s, x.p, x.m)
    x.count[EVALUATIONS] += 1
    for r in range(o.n_q):
        error[r] = s[1 + o.n_q + r] + w[state + 8 * (o.n_q + r) + 7]
    for r in range(o.n):
        error[o.n_q + r] = w[state + 8 * (n_x + r) + 7]
    for r in range(n_x):
        w[state + 8 * r + 7] = 0.0
    size = f.estimate(variant, w, k.J, k.weight, error, h)
    if size < 1.0:  # guards are looked at next: at the base point, not beside it
        f.rate(variant, w, s, x.p, x.m)
        x.count[EVALUATIONS] += 1
    return size


@compiled
def next_length(h, error, h_past, error_past, smooth):
    """Length of the next step by predictive control (Gustafsson) from the errors of two accepted steps."""
    factor = 0.9 * error ** (-1.0 / ORDER)
    if smooth:
        factor = min(factor, 0.9 * h / h_past * (error_past / (error * error)) ** (1.0 / ORDER))
    return h * min(max(factor, 0.2), 6.0)
