"""Functions that laws are written with, besides arithmetic, and their form in generated code.

`side` is what laws of |x| and laws with kinks are made of: SymPy's own `Abs` and `Piecewise` would bring
delta functions into slopes, and branches into the loops over lanes.
"""

import sympy
from sympy import Expr, Float, Function, Integer, exp, log, sqrt

__all__ = ["exp", "lambert", "log", "power", "side", "sqrt", "tanh"]

TINY = Float(1e-300)  # its logarithm is a number


class side(Function):
    """The sign of x, with that of the zero at x = 0; its slope is 0 everywhere: kinks are not seen."""

    nargs = 1

    def fdiff(self, _argindex: int = 1) -> Expr:
        """No slope."""
        return Integer(0)

    def _eval_power(self, exponent: Expr) -> Expr | None:
        return Integer(1) if exponent.is_even else None


class tanh(sympy.tanh):
    """The hyperbolic tangent of a real number: SymPy's expands a quotient, without end, for its real part."""

    def _eval_is_real(self) -> bool | None:
        return self.args[0].is_real

    def _eval_is_finite(self) -> bool | None:
        return self.args[0].is_real


class power(Function):
    """x to the n for x >= 0 and n >= 1, whose slope n x^(n - 1) is finite at x = 0 too."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Expr:
        """Slope by x, or by n: x^n ln x, which is 0 at x = 0."""
        x, n = self.args
        return n * power(x, n - 1) if argindex == 1 else self * log(x + TINY)


class lambert(Function):
    """The root y > 1 of y exp(-y) = x, 0 < x < 1/exp(1): -W(-x) of Lambert's W on its lower branch."""

    nargs = 1

    def fdiff(self, _argindex: int = 1) -> Expr:
        """Slope, which is infinite at the branch's end."""
        (x,) = self.args
        return -self / (x * (self - 1))
