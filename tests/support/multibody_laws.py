"""Laws of contact and friction for the bodies of `tests.support.multibody`, from their publications.

They are written by cases and as they were printed, without the package's rounding-off, common factors or
generated text. A law that stands here nowhere is taken from its object: then only the bodies are independent.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.special import lambertw

from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from tests.support.belt import NUMPY

DAMPING = {  # d of chi = d / v_0, by the restitution e that is wanted
    "hunt_crossley_restitution": lambda e: 1.5 * (1 - e),
    "herbert_mcwhannell": lambda e: 6 * (1 - e) / ((2 * e - 1) ** 2 + 3),
    "lee_wang": lambda e: 0.75 * (1 - e),
    "lankarani_nikravesh": lambda e: 0.75 * (1 - e * e),
    "gonthier": lambda e: (1 - e * e) / e,
    "zhiying_qishao": lambda e: 0.75 * (1 - e * e) * math.exp(2 - 2 * e),
    "flores": lambda e: 1.6 * (1 - e) / e,
    "hu_guo": lambda e: 1.5 * (1 - e) / e,
}


def power(K: float, n: float) -> Callable[[float], float]:
    """K u^n, odd; infinite where only trial steps that fail get to."""
    return lambda u: math.copysign(K * abs(u) ** n if abs(u) < 1.0 else math.inf, u)


def _modulus(numbers) -> float:
    """E* of two materials."""
    sides = (
        (1 - numbers[f"{x}_poisson_ratio"] ** 2) / numbers[f"{x}_modulus"] for x in ("journal", "bearing")
    )
    return 1 / sum(sides)


def logarithmic(S: float, b: float) -> Callable[[float], float]:
    """F of u = F/S ln(b/F), the branch that begins at 0."""

    def force(u: float) -> float:
        if u <= 0:
            return 0.0 if u == 0 else -force(-u)
        return -S * u / lambertw(-S * u / b, -1).real

    return force


def cylinders(law: str, numbers, clearance: float, radius: float) -> Callable[[float], float]:
    """The spring of a journal in a bearing."""
    L, S = numbers["length"], math.pi * _modulus(numbers) * numbers["length"]
    if law == "johnson":  # u = F/S (ln(4 S e/F) − 1)
        return logarithmic(S, 4 * S * clearance / math.e)
    if law == "dubowsky_freudenstein":  # u = F/S (ln(S L² e/(R (R + e) F)) + 1)
        return logarithmic(S, S * L * L * clearance / (radius * (radius + clearance)) * math.e)
    return lambda u: S / 2 * u * math.sqrt(abs(u) / (2 * (clearance + abs(u))))


def normal(contact, clearance: float, radius: float) -> tuple[Callable[..., float] | None, dict]:
    """F_n = law(u, v_n) or law(u, v_n, v_0) of a record, and what else a `Play` is given."""
    law, numbers = contact.law, contact.numbers
    if law == "restitution":
        return None, {"restitution": numbers["restitution"]}
    if law == "kelvin_voigt":
        K, C = contact.stiffness, contact.damping
        return lambda u, v_n: K * u + C * v_n, {"stored": lambda u: 0.5 * K * u * u}
    if law in ("hertz", "hunt_crossley"):
        spring, chi = power(contact.stiffness, numbers["exponent"]), numbers.get("dissipation", 0.0)
        return lambda u, v_n: spring(u) * (1 + chi * v_n), {}
    if law in DAMPING:
        spring, d = power(contact.stiffness, numbers["exponent"]), DAMPING[law](numbers["restitution"])
    elif law in ("johnson", "dubowsky_freudenstein", "liu"):
        spring = cylinders(law, numbers, clearance, radius)
        d = DAMPING["lankarani_nikravesh"](numbers["restitution"])
    else:
        return _by_object(contact, {"e": clearance, "R": radius})
    return lambda u, v_n, v_0: spring(u) * (1 + d * v_n / v_0), {"slowest": numbers["slowest"]}


def _by_object(contact, joint: dict[str, float]) -> tuple[Callable[..., float], dict]:
    """F_n by the law's object, and what else a `Play` is given."""
    law, numbers = LAWS[contact.law], contact.coefficients
    given = *numbers.values(), *(joint[letter] for letter in law.joint)
    more = {"slowest": numbers[law.floor]} if law.floor else {}
    return lambda u, v_n, *v_0: float(law.force(NUMPY, u, v_n, *given, *v_0)[0]), more


def ratio(f, v: float) -> float:
    """mu of a record at a sliding speed; of laws that stick, for v ≥ 0."""
    x, sign, mu = abs(v), math.copysign(1.0, v), f.coefficient
    if f.law == "coulomb":
        return mu
    if f.law == "tanh":
        return mu * math.tanh(v / f.velocity)
    if f.law == "ramp":
        return mu * (v / f.velocity if x < f.velocity else sign)
    if f.law == "ambrosio":
        between = (x - f.velocity) / (f.full_velocity - f.velocity)
        return mu * sign * (0.0 if x < f.velocity else min(between, 1.0))
    if f.law == "threlfall":
        return mu * sign * (1 - math.exp(-3 * x / f.velocity) if x < f.velocity else 1 - math.exp(-3))
    if f.law == "brown_mcphee":
        hump = (v / f.velocity) / ((v / (2 * f.velocity)) ** 2 + 0.75) ** 2
        return mu * math.tanh(4 * v / f.velocity) + (f.static_coefficient - mu) * hump
    if f.law not in ("andersson", "stribeck", "lugre"):
        law = FRICTIONS[f.law]
        return float(law.ratio(NUMPY, v, *(f.parameters[letter] for letter in law.letters)))
    falling = mu + (f.static_coefficient - mu) * math.exp(-((x / f.stribeck_velocity) ** f.exponent))
    return falling * math.tanh(v / f.velocity) if f.law == "andersson" else falling


def tangential(friction) -> dict:
    """What a `Play` is given of a record of friction."""
    f = friction
    if FRICTIONS[f.law].limit:
        return {"dry": lambda v: ratio(f, v), "viscous": f.viscous}
    if f.law == "lugre":

        def bent(v, z):
            rate = v - f.bristle_stiffness * abs(v) * z / ratio(f, v)
            return f.bristle_stiffness * z + f.bristle_damping * rate, rate

        return {"bristles": bent, "viscous": f.viscous}
    return {"friction": lambda F_n, v_t: ratio(f, v_t) * F_n + f.viscous * v_t}
