"""Drives of the crank, each one object: an entry of `DRIVES` can be the `drive` of a structure.

No SymPy here before equations are written: arithmetic alone takes symbols as well as numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Drive:
    """A drive of the crank.

    Parameters
    ----------
    letters : tuple of str
        Its numbers, in order.
    torque : callable, optional
        Torque as a law of the crank's speed, or of what `follows`, and the numbers; None where it is another
        law or an outcome.
    acceleration : callable, optional
        Acceleration that is imposed on the crank, of the time and the numbers.
    imposed : bool
        Whether the motion is imposed, and the torque an outcome.
    follows : bool
        Whether the torque is of how much the crank's angle and speed lack of those of a course over time.
    """

    letters: tuple[str, ...] = ()
    torque: Callable | None = None
    acceleration: Callable | None = None
    imposed: bool = False
    follows: bool = False


WANTED = ("wanted_angle", "wanted_velocity", "wanted_acceleration")
NAMES = ("t", "angle", "angular_velocity", *WANTED)  # what a servo's feedforward may depend on


def _run_up(t, w_0, w_1, T):
    """Acceleration of w = w_0 + (w_1 - w_0) S(t/T), S = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7 up to x = 1.

    S' = 140 x^3 (1 - x)^3 joins its end three times differentiably. With |1 - x| as a root, what is left to
    go, (1 - x + |1 - x|)/2, is 0 to the last bit beyond the end.
    """
    from sympy import Float, sqrt

    x = t / T
    left = (1 - x + sqrt((1 - x) ** 2 + Float(1e-200))) / 2
    return 140 * (w_1 - w_0) / T * ((1 - left) * left) ** 3


# Motor line: T(w) = a - b w, equations (1) and (2) of Chunmei et al. (2002). It is stiff: b/J reaches 1e6
# 1/s. A prescribed speed makes the crank's angle a phase, Omega t + theta_0, and its torque an outcome; so
# does a profile, whose angle and speed are states with a given acceleration. A prescribed torque is a course
# (equations.linkage) over the crank's angle; the speed of a cycle is one over time, and its slope is imposed.
# A servo pulls the crank towards an angle over time, W t and a course (equations.linkage).
DRIVES = {
    "none": Drive(),
    "motor": Drive(("a", "b"), torque=lambda w, a, b: a - b * w),
    "speed": Drive(("Omega", "theta_0"), imposed=True),
    "torque": Drive(),
    "cycle": Drive(imposed=True),
    "profile": Drive(("w_0", "w_1", "T"), acceleration=_run_up, imposed=True),
    "servo": Drive(("K_p", "K_d", "W"), lambda off, late, K_p, K_d: K_p * off + K_d * late, follows=True),
}
