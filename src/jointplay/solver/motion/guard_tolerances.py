"""Values of guards that are zero to rounding or to the tolerance, so that neither makes an event."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS, Law
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model

EPS = float(np.finfo(float).eps)
NOISE = 1e-12  # sliding speeds are known no better than this tolerance has them
ROUNDINGS = 64  # nor than so many roundings of the links' speeds, of which they are differences
APPROACH = 0.1  # of these: normal speeds, of which the rounding of the normal's direction makes sliding ones
FLAT = 1e-11  # rebounds are known no better than this tolerance has them
FLIGHT = 1000  # roundings of a gap in a flight that can be told from rest
REBOUND_ERROR = 100.0  # of sliding speeds within the tolerance of zero: with SPEED_FLOOR, of the nominal one
HELD = 1e-12  # share of a held force within which it is known
GAP_ROUNDINGS = 16  # roundings of the mechanism's reach within which a gap is zero


class Tolerances(NamedTuple):
    """Sizes up to which what decides events is zero; a `rebound_error` of inf: no rebound is left out."""

    speed: float  # of sliding, m/s: within the tolerance, or within rounding
    height: float  # of a rebound from a rigid wall, m
    rebound_error: float  # by which rebounds left out may be wrong, m/s, of the speed that counts as rest
    gap_rounding: float  # m
    margin: np.ndarray  # of each contact's guards: gap, force, sliding speed, cone; of walls'; 0: none
    clearance_squared: np.ndarray  # of each contact, m^2; inf: it has no centre
    cone: np.ndarray  # error of (f_s F_n)^2 - F_t^2 near zero, over F_n, N; of a rough wall, over F_n^2


def tolerances(model: Model, rtol: float, n_contacts: int, n_resets: int, n_rubs: int = 0) -> Tolerances:
    """What is zero to the motion of a model with so many contacts, rigid walls, and rough ones of these."""
    gap, rounding = GAP_ROUNDINGS * EPS * model.reach, _rounding(model)
    still = max(max(rtol, NOISE) * model.creep, rounding)
    squares, guards = clearances_squared(model, n_contacts), np.zeros((n_contacts, 4))
    guards[:, 2] = still
    # the push of a rough wall is solved for, and known to HELD of itself
    cone = np.array([*np.zeros(n_contacts), *(2 * f * (1 + f) * HELD for f in _rough(model))])
    for j, (law, places, friction) in enumerate(_laws(model.structure)):
        given, f, clearance = model.numbers[places], model.numbers[friction], model.clearances[j]
        force = law.slopes(gap, *given)[0] * gap if law.push is None else _turning(law, given, rounding)
        guards[j, :2] = (2 * clearance if squares[j] < np.inf else 1.0) * gap, force
        K, C = law.slopes(clearance, *given)
        cone[j] = 2 * f * (1 + f) * (K * gap + C * rounding)
    height = max(max(rtol, FLAT) * _height(model), FLIGHT * gap)
    # where links bend the force of a wall that holds a body is not steady, however low the rebounds are
    error = np.inf if model.bending else REBOUND_ERROR * still
    margin = np.concatenate([guards.ravel(), np.zeros(n_resets), np.full(n_rubs, still)])
    return Tolerances(still, height, error, gap, margin, squares, cone)


def _rounding(model: Model) -> float:
    """Rounding of a relative speed at a contact, m/s, at the nominal speed or that of the start."""
    turning = max((model.reach / e for e in model.clearances), default=0.0)
    n_q = len(model.turning)
    speeds = model.state[n_q : 2 * n_q][model.turning > 0] if model.reach else ()
    fastest = max(2 * math.pi / model.period, float(np.max(np.abs(speeds), initial=0.0)))
    return EPS * model.reach * fastest * (ROUNDINGS + APPROACH * turning)


def _height(model: Model) -> float:
    """Scale of the tolerated error of a rebound's height, m: also that of what bends, which it shakes."""
    lengths = model.absolute[: len(model.turning)][model.turning == 0] if model.links else ()
    return min(SPEED_FLOOR * (model.reach or 1.0), np.min(lengths, initial=np.inf))


def clearances_squared(model: Model, n_contacts: int) -> np.ndarray:
    """Squares of the clearances, m^2; infinite of a contact that is no joint's."""
    squares = np.full(n_contacts, np.inf)
    for j, joint in enumerate(model.structure.joints[:n_contacts] if model.links else ()):
        squares[j] = model.clearances[j] ** 2 if joint.corner is None else np.inf
    return squares


@lru_cache(maxsize=256)
def _laws(structure: Linkage | Oscillator) -> list[tuple[Law, list[int], int]]:
    """Law of each joint, and where its numbers and the limit of sticking stand among the parameters."""
    if isinstance(structure, Oscillator):
        return []
    place = {name: at for at, name in enumerate(parameter_names(structure))}
    found = []
    for joint in structure.soft_joints:
        law, friction = LAWS[joint.law], FRICTIONS.get(joint.friction, FRICTIONS["coulomb"])
        numbers = [place[f"{letter}_{joint.owner}"] for letter in law.arguments]
        found.append((law, numbers, place[f"{friction.limit_letter}_{joint.owner}"]))
    return found


def ends(model: Model) -> np.ndarray:
    """Penetration at which the law of each joint ends, m; infinite of one that holds at any."""
    found = np.full(len(model.joints), np.inf)
    for j, (law, places, _) in enumerate(_laws(model.structure)):
        found[j] = law.deepest(*model.numbers[places]) if law.deepest else np.inf
    return found


def _turning(law: Law, given: np.ndarray, rounding: float) -> float:
    """Rounding of the push of a law whose force vanishes with the penetration."""
    slowest = [given[law.letters.index(law.floor)]] if law.floor else []
    still, moving = (law.push(v_n, *given, *slowest) for v_n in (0.0, rounding))
    return EPS + moving - still


def _rough(model: Model) -> list[float]:
    """Friction coefficient of each rigid wall; 0 of a smooth one."""
    if not model.links:
        return [0.0] * len(model.resets)
    numbers = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
    rough = [(joint, FRICTIONS.get(joint.friction)) for joint in model.structure.rigid_joints]
    return [numbers[f"{law.limit_letter}_{joint.owner}"] if law else 0.0 for joint, law in rough]
