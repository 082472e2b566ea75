"""A servo: the torque of a controller that makes the driven link follow an angle over time.

    T = K_p (phi - theta) + K_d (phi' - w) + T_f(t, theta, w, phi, phi', phi''),      phi = W t + f(nu t),

with a course f (equations.loads). T_f is fed forward, given as text: with what a model of the mechanism needs
for the wanted motion the whole is a computed torque. Reference: Slotine and Li, Applied Nonlinear Control
(1991), chapters 6 and 9. Assumption: the controller acts at once and without limit.
"""

from sympy import Expr, cos, sin

from . import loads
from .coordinates import Coordinates
from .drives import DRIVES, NAMES, WANTED
from .own import own
from .structure import Linkage
from .system import TIME, number


def torque(structure: Linkage, c: Coordinates) -> Expr:
    """The torque on the driven link."""
    angle, speed, W = c.angle[structure.driven], c.speed[structure.driven], number("W")
    value, slope, bend = loads.derivatives(structure.course, c, 2)
    wanted = [
        c.let(name, each) for name, each in zip(WANTED, (W * TIME + value, W + slope, bend), strict=True)
    ]
    names = dict(zip(NAMES, (TIME, angle.value, speed, *wanted), strict=True))
    known = {
        "sin": lambda x: angle.sin if x == angle.value else sin(x),
        "cos": lambda x: angle.cos if x == angle.value else cos(x),
        "tan": lambda x: known["sin"](x) / known["cos"](x),
    }
    for name, text in structure.fed:
        names[name] = c.let(f"fed_{name}", own.smooth(text, names, known).xreplace(own.NUMBERS))
    drive = DRIVES[structure.drive]
    lacking = wanted[0] - angle.value, wanted[1] - speed
    return drive.torque(*lacking, *map(number, drive.letters[:2])) + names.get("", 0)
