"""Drives of a crank.

Motor line: T(w) = a - b w, equations (1) and (2) of Chunmei et al. (2002); a and b are numbers of the
mechanism. It is stiff: b/J reaches 1e6 1/s. A prescribed speed makes the crank's angle a phase,
Omega t + theta_0, and its torque an outcome. Without a drive the crank turns freely.
"""

from sympy import Expr, Integer

from .system import number


def torque(drive: str, w: Expr) -> Expr:
    """Torque of the drive on the crank as a law of its speed; 0 where the torque is no law but an outcome."""
    return number("a") - number("b") * w if drive == "motor" else Integer(0)
