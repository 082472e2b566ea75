"""A block on a moving belt, held by a spring: the simplest body that rubs, for every law of friction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from scipy.special import lambertw
from sympy import Integer, Symbol, symbols

from jointplay.solver.equations import functions
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS as NORMAL
from jointplay.solver.equations.structure import Oscillator
from jointplay.solver.equations.system import Contact as Touch
from jointplay.solver.equations.system import System, number, traction
from jointplay.solver.equations.write import WRITERS
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.mechanism.parts.joints import Contact

NUMPY = SimpleNamespace(tanh=np.tanh, exp=np.exp, log=np.log, sqrt=np.sqrt, power=np.power)
NUMPY.side = lambda x: np.copysign(1.0, x)
NUMPY.lambert = lambda x: np.where(x < math.exp(-1), -lambertw(-x, -1).real, math.nan)
TRIED = {name: Friction(law=name, **law.trial) for name, law in FRICTIONS.items()}
LAWS = {name: friction for name, friction in TRIED.items() if not FRICTIONS[name].bristles}
LUGRE = TRIED["lugre"]
STICKING = [name for name in LAWS if FRICTIONS[name].limit]
REGULARISED = [name for name in LAWS if not FRICTIONS[name].limit]


def contact(law, **numbers):
    """The record of a law of the normal force with its trial numbers, or others."""
    numbers = NORMAL[law].trial | numbers
    own = {name: numbers.pop(name) for name in ("stiffness", "damping") if name in numbers}
    return Contact(law=law, parameters=numbers, **own)


def ratio(friction, v, m=NUMPY):
    """mu(v) of a record of friction."""
    law = FRICTIONS[friction.law]
    return law.ratio(m, v, *(friction.parameters[letter] for letter in law.letters))


def _system(law):
    """m x'' = load - k x - F_t, F_n = N, sliding at x' - V."""
    x, v, u, v_t = symbols("x v u_block vt_block", real=True)
    m, k, V, N, load = map(number, ("mass", "spring", "belt", "N", "load"))
    z = [Symbol("z", real=True)] * bool(law.bristles)
    given = functions, v_t, *z, *(number(f"{letter}_block") for letter in law.letters)
    mu, zeros = law.ratio(*given), [Integer(0)] * len(z)
    limit = number(f"{law.limit_letter}_block") if law.limit else None
    slip, drag = (mu, Integer(0)) if law.limit else (None, mu * N)
    rubbing = {"v_t": v_t, "tangential": (Integer(1), *zeros), "coulomb": slip, "drag": drag, "limit": limit}
    rubbing["rates"] = {each: law.bristles(*given) for each in z}
    block = Touch("block", u, Integer(0), N, (Integer(0), *zeros), **rubbing)
    return System(
        positions=(x,),
        speeds=(v, *z),
        parameters=(m, k, V, N, load, *(number(f"{letter}_block") for letter in law.letters)),
        definitions=((u, Integer(1)), (v_t, v - V)),
        mass={(0, 0): m} | dict.fromkeys([(1, 1)] * len(z), Integer(1)),
        force=(load - k * x, *zeros),
        contacts=(block,),
        outputs={"state:x": x, "state:v": v}
        | dict(zip(["state:z"], z, strict=False))
        | {"tangential_force:block": traction(block)[1]},
    )


@dataclass(frozen=True)
class Block(Oscillator):
    """The structure of a block with a law of friction."""

    law: str = ""


WRITERS[Block] = lambda block: _system(FRICTIONS[block.law])


def belt(friction, state, *, m=2.0, k=50.0, V=0.1, N=20.0, load=0.0):
    """The model of a block with this friction, at x, x'."""
    law = FRICTIONS[friction.law]
    rubbing = (friction.parameters[letter] for letter in law.letters)
    return Model(
        structure=Block((), (), (), (), law=friction.law),
        numbers=np.array([m, k, V, N, load, *rubbing]),
        state=np.array(state, dtype=float),
        absolute=np.array([1e-3, 1e-3, 1e-6])[: len(state)],
        relative=np.ones(len(state)),
        turning=np.zeros(1),
        fold=np.zeros(1),
        period=2 * math.pi * math.sqrt(m / k) if k else 1.0,
        h_max=math.inf,
        creep=1e-3,
        joints=("block",),
        states=("x", "v", "z")[: len(state)],
    )
