"""Laws of the tangential force at a contact, each one object: a law in `FRICTIONS` can be used everywhere.

    F_t = mu(v_t) F_n + C_t v_t       against the sliding velocity v_t; C_t is the record's `viscous`

A regularised law is mu(v_t) itself: smooth or with kinks, odd, 0 at rest. It never sticks; under a load below
its limit it creeps at the speed where mu(v_t) F_n balances the load. A law with true sticking is a slip
coefficient mu(|v_t|) > 0, which takes the sign of the sliding, and a limit: at rest any |F_t| <= limit F_n
holds (Filippov; the numerics locate onset and end of sticking as roots). A law of bristles has a state of
its own, their deflection z, in the place of sticking: 0 in flight, and from where contact begins anew.

All of them are for dry contact at F_n >= 0. Where the normal force pulls, friction follows its sign and
drives. Stages of a step look beyond the surface (u < 0): F_n is continued there by its own law, and mu does
not know u. Kinks are not located: a step across one is of low order, and its error estimate shortens it
until the kink costs no more than the tolerance: more steps, not less accuracy.

No SymPy here: a law takes the functions that it needs (`tanh`, `exp`, `side`, `power` of equations.functions,
or those of NumPy) as its first argument.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..extensions import Table
from .quantity import ForceLaw, Quantity


@dataclass(frozen=True)
class FrictionLaw(ForceLaw):
    """A law of friction. Compiled equations are found by its name: one that changes needs another name.

    Its numbers are those beside ``coefficient`` and ``viscous``.

    Parameters
    ----------
    ratio : callable
        mu of the functions, v_t, the coefficient f and the law's further numbers in their order. It must be
        defined on both sides of v_t = 0: odd in v_t, or for a law that sticks even and positive.
    limit : str
        Of a law with true sticking, the name of the number f_s in |F_t| <= f_s F_n. It must be mu(0): the
        force does not jump where sticking ends.
    bristles : callable, optional
        Of a law with a state z, its rate; arguments as of `ratio`. Both then take z behind v_t.
    deflection : callable, optional
        Of such a law, the largest |z| in steady sliding, m, of the coefficient and further numbers.
    kinks : bool
        Whether its slope, or that of the bristles' rate, jumps at a sliding speed that no guard locates.
    rises : bool
        Whether it falls nowhere with the sliding speed, so that it excites no vibration.
    """

    ratio: Callable
    limit: str = ""
    bristles: Callable | None = None
    deflection: Callable | None = None
    kinks: bool = False
    rises: bool = False

    @property
    def trial(self) -> dict[str, float | None]:
        """Its coefficient and further numbers with which it is tried, by name."""
        return {"coefficient": COEFFICIENT} | super().trial

    @property
    def letters(self) -> tuple[str, ...]:
        """Letters of its coefficient and further numbers, in the order of `ratio`."""
        return ("f", *(each.letter for each in self.numbers.values()))

    @property
    def limit_letter(self) -> str:
        """Letter of the coefficient of the sticking limit, or of a regularised law of its coefficient."""
        return self.numbers[self.limit].letter if self.limit in self.numbers else "f"


COEFFICIENT = 0.3  # with which laws are tried
# Letters that every joint has: coefficient, smoothing velocity, viscous coefficient.
COMMON = ("f", "v", "Ct")


def parameter_letters(friction: str) -> tuple[str, ...]:
    """Letters of all parameters of a joint's friction, by the law's name (or "none")."""
    own = FRICTIONS[friction].letters if friction in FRICTIONS else ()
    return (*COMMON, *(letter for letter in own if letter not in COMMON))


def _beyond(m, x):
    """1 where x > 0, 0 where x < 0."""
    return (1 + m.side(x)) / 2


def _ramp(m, v_t, f, v_0):
    x = v_t / v_0
    full = _beyond(m, x * x - 1)
    return f * ((1 - full) * x + full * m.side(x))


def _ambrosio(m, v_t, f, v_0, v_1):
    x = (v_t * m.side(v_t) - v_0) / (v_1 - v_0)
    some, full = _beyond(m, x), _beyond(m, x - 1)
    return f * m.side(v_t) * (some * (1 - full) * x + full)


def _threlfall(m, v_t, f, v_0):
    x = v_t * m.side(v_t) / v_0
    full = _beyond(m, x - 1)
    return f * m.side(v_t) * (1 - m.exp(-3 * ((1 - full) * x + full)))


def _falling(m, v_t, f, f_s, v_s, delta):
    return f + (f_s - f) * m.exp(-m.power(v_t * m.side(v_t) / v_s, delta))


def _andersson(m, v_t, f, v_0, f_s, v_s, delta):
    return _falling(m, v_t, f, f_s, v_s, delta) * m.tanh(v_t / v_0)


def _brown_mcphee(m, v_t, f, v_0, f_s):
    x = v_t / v_0
    return f * m.tanh(4 * x) + (f_s - f) * x / (x**2 / 4 + 3 / 4) ** 2


def _bending(m, v_t, z, f, s_0, s_1, f_s, v_s, delta):
    return v_t - s_0 * v_t * m.side(v_t) / _falling(m, v_t, f, f_s, v_s, delta) * z


def _lugre(m, v_t, z, f, s_0, s_1, *further):
    return s_0 * z + s_1 * _bending(m, v_t, z, f, s_0, s_1, *further)


_VELOCITY = Quantity("v", "m/s", trial=0.02)  # v_0
_STATIC = Quantity("fs", "1", above="coefficient", or_equal=True, trial=0.5)  # f_s >= f
_STRIBECK = {
    "static_coefficient": _STATIC,
    "stribeck_velocity": Quantity("vs", "m/s", trial=0.1),
    "exponent": Quantity("delta", "1", usual=2.0, least=1.0, most=10.0),
}

_ROWS = {
    # Coulomb: mu = f, and true sticking up to f F_n.
    "coulomb": FrictionLaw(
        lambda m, v_t, f: f,
        formula="f",
        references=("filippov1988", "leine_nijmeijer2004"),
        limit="coefficient",
        rises=True,
    ),
    # Coulomb's smoothed, as many multibody codes have it: mu = f tanh(v_t/v_0). Valid while the sliding
    # speeds of interest are far above v_0: f - |mu| < 2 f exp(-2 |v_t|/v_0).
    "tanh": FrictionLaw(
        lambda m, v_t, f, v_0: f * m.tanh(v_t / v_0),
        numbers={"velocity": _VELOCITY},
        formula="f tanh(v_t/v_0)",
        references=(),
        rises=True,
    ),
    # Piecewise linear, as Rooney and Deravi (1982): mu = f v_t/v_0 up to |v_t| = v_0, then f. Kinks at
    # |v_t| = v_0.
    "ramp": FrictionLaw(
        _ramp,
        numbers={"velocity": _VELOCITY},
        formula="f v_t/v_0 up to v_0, then f",
        references=("rooney_deravi1982",),
        kinks=True,
        rises=True,
    ),
    # Ambrosio (2003): mu = f c(|v_t|) sign(v_t), where c is 0 up to v_0, 1 from v_1 on and linear between. No
    # force at all below v_0: the smallest load drives a body to that speed. Kinks at v_0 and v_1.
    "ambrosio": FrictionLaw(
        _ambrosio,
        numbers={"velocity": _VELOCITY, "full_velocity": Quantity("v1", "m/s", above="velocity", trial=0.07)},
        formula="0 up to v_0, f from v_1, linear between",
        references=("ambrosio2003",),
        kinks=True,
        rises=True,
    ),
    # Threlfall (1978): mu = f (1 - exp(-3 |v_t|/v_0)) sign(v_t) up to v_0. Certain is this exponential; how
    # the paper itself goes on beyond v_0 could not be checked (0.95 f is quoted, a jump of 2e-4 f). Here mu
    # keeps its value at v_0, f (1 - exp(-3)) = 0.9502 f: sliding never meets the full f. Its slope has a kink
    # at v_0, its curvature a jump at 0.
    "threlfall": FrictionLaw(
        _threlfall,
        numbers={"velocity": _VELOCITY},
        formula="f (1 − exp(−3 v_t/v_0)) up to v_0, then f (1 − exp(−3))",
        references=("threlfall1978",),
        kinks=True,
        rises=True,
    ),
    # Andersson, Soderberg and Bjorklund (2007): mu = (f + (f_s - f) exp(-(|v_t|/v_s)^delta)) tanh(v_t/v_0),
    # where f is the kinetic and f_s the static coefficient; theirs writes 1/v_0 as k_tanh. The largest mu
    # stays below f_s, the nearer to it the smaller v_0/v_s is. Valid for v_0 << v_s.
    "andersson": FrictionLaw(
        _andersson,
        numbers={"velocity": replace(_VELOCITY, trial=0.002), **_STRIBECK},
        formula="(f + (f_s − f) exp(−(v_t/v_s)^δ)) tanh(v_t/v_0)",
        references=("andersson2007",),
    ),
    # Brown and McPhee (2016), without its viscous term: mu = f tanh(4 x) + (f_s - f) x/(x^2/4 + 3/4)^2,
    # x = v_t/v_0. mu(v_0) misses f_s by f (1 - tanh 4) = 7e-4 f, and that is close to its peak.
    "brown_mcphee": FrictionLaw(
        _brown_mcphee,
        numbers={"velocity": _VELOCITY, "static_coefficient": _STATIC},
        formula="f tanh 4x + (f_s − f) x/(x²/4 + 3/4)², x = v_t/v_0",
        references=("brown_mcphee2016",),
    ),
    # Stribeck's curve as Bo and Pavelescu (1982) write it, with true sticking up to f_s F_n:
    # mu = f + (f_s - f) exp(-(|v_t|/v_s)^delta). Steady sliding is unstable where mu falls. With v_s -> 0
    # Coulomb's law of two coefficients.
    "stribeck": FrictionLaw(
        _falling,
        numbers=_STRIBECK,
        formula="f + (f_s − f) exp(−(v_t/v_s)^δ)",
        references=("bo_pavelescu1982",),
        limit="static_coefficient",
    ),
    # LuGre (Canudas de Wit, Olsson, Astrom and Lischinsky 1995), times the normal force, which there is
    # constant: mu = s_0 z + s_1 z', z' = v_t - s_0 |v_t| z/g(v_t), g being Stribeck's curve, theirs with
    # delta = 2. Steady sliding has |mu| = g, rest the stiffness s_0 F_n: a joint under load moves, and creeps
    # where the load changes. Valid for |z| far below the joint's size. s_1 takes energy for sure only where
    # C_t > s_1 F_n (f_s - f)/f (Barabanov and Ortega 2000).
    "lugre": FrictionLaw(
        _lugre,
        numbers={
            "bristle_stiffness": Quantity("s0", "1/m", trial=1e4),
            "bristle_damping": Quantity("s1", "s/m", usual=0.0, least=0.0, trial=3.0),
            **_STRIBECK,
        },
        formula="σ₀ z + σ₁ z′, z′ = v_t − σ₀ v_t z/g(v_t), g as `stribeck`",
        references=("canudas1995", "bo_pavelescu1982"),
        bristles=_bending,
        deflection=lambda f, s_0, s_1, f_s, v_s, delta: f_s / s_0,
        kinks=True,
    ),
}
FRICTIONS = Table("jointplay.frictions", FrictionLaw, _ROWS)
