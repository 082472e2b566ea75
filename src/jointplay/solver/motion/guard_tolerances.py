"""Values of guards that are zero to rounding or to the tolerance, so that neither makes an event."""

import math
from functools import lru_cache

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


def _rounding(model: Model) -> float:
    """Rounding of a relative speed at a contact, m/s, at the nominal speed or that of the start."""
    turning = max((model.reach / e for e in model.clearances), default=0.0)
    n_q = len(model.turning)
    speeds = model.state[n_q : 2 * n_q][model.turning > 0] if model.reach else ()
    fastest = max(2 * math.pi / model.period, float(np.max(np.abs(speeds), initial=0.0)))
    return EPS * model.reach * fastest * (ROUNDINGS + APPROACH * turning)


def gap_rounding(model: Model) -> float:
    """Rounding of a gap, m."""
    return GAP_ROUNDINGS * EPS * model.reach


def speed(model: Model, rtol: float) -> float:
    """Sliding speed that is within the tolerance of zero, or within rounding."""
    return max(max(rtol, NOISE) * model.creep, _rounding(model))


def height(model: Model, rtol: float) -> float:
    """Height of a rebound from a rigid wall that is within the tolerance of zero, or of rounding; in m.

    Also within that of what bends: rebounds that are left out shake it by as much.
    """
    lengths = model.absolute[: len(model.turning)][model.turning == 0] if model.links else ()
    height = min(SPEED_FLOOR * (model.reach or 1.0), np.min(lengths, initial=np.inf))
    return max(max(rtol, FLAT) * height, FLIGHT * gap_rounding(model))


def rebound_error(model: Model, still: float) -> float:
    """Speed by which rebounds left out may be wrong, m/s, of that which counts as rest; inf if links bend.

    There the force of a wall that holds a body is not steady, however low the rebounds are.
    """
    return np.inf if model.bending else REBOUND_ERROR * still


def clearances_squared(model: Model, n_contacts: int) -> np.ndarray:
    """Squares of the clearances, m^2; infinite of a contact that is no joint's."""
    squares = np.full(n_contacts, np.inf)
    for j, centred in enumerate(_centred(model)[:n_contacts]):
        squares[j] = model.clearances[j] ** 2 if centred else np.inf
    return squares


def _centred(model: Model) -> list[bool]:
    """Whether each contact's gap is watched by the square of a distance from a centre, as a bearing's is."""
    return [joint.corner is None for joint in model.structure.joints] if model.links else []


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


def _turning(law: Law, given: np.ndarray, model: Model) -> float:
    """Rounding of the push of a law whose force vanishes with the penetration."""
    slowest = [given[law.letters.index(law.floor)]] if law.floor else []
    still, moving = (law.push(v_n, *given, *slowest) for v_n in (0.0, _rounding(model)))
    return EPS + moving - still


def cones(model: Model) -> np.ndarray:
    """Error of (f_s F_n)^2 - F_t^2 near zero by the rounding of the normal force F_n, over F_n, N.

    Of a rough wall, whose push is solved for and is known to HELD of itself, over its square.
    """
    errors, play, speed = np.zeros(len(model.touching)), gap_rounding(model), _rounding(model)
    for j, f in enumerate(_rough(model), start=len(model.touching) - len(model.walls)):
        errors[j] = 2 * f * (1 + f) * HELD
    for j, (law, places, friction) in enumerate(_laws(model.structure)):
        (K, C), f = law.slopes(model.clearances[j], *model.numbers[places]), model.numbers[friction]
        errors[j] = 2 * f * (1 + f) * (K * play + C * speed)
    return errors


def _rough(model: Model) -> list[float]:
    """Friction coefficient of each rigid wall; 0 of a smooth one."""
    if not model.links:
        return [0.0] * len(model.resets)
    numbers = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
    rough = [(joint, FRICTIONS.get(joint.friction)) for joint in model.structure.rigid_joints]
    return [numbers[f"{law.limit_letter}_{joint.owner}"] if law else 0.0 for joint, law in rough]


def guards(model: Model, still: float, n_contacts: int, n_resets: int, n_rubs: int = 0) -> np.ndarray:
    """Tolerance of each contact's guards: gap, force, sliding speed; of walls' sliding speeds; else 0."""
    tolerances = np.zeros((n_contacts, 4))
    tolerances[:, 2], play = still, gap_rounding(model)
    for j, (law, places, _) in enumerate(_laws(model.structure)):
        given = model.numbers[places]
        force = law.slopes(play, *given)[0] * play if law.push is None else _turning(law, given, model)
        tolerances[j, :2] = (2 * model.clearances[j] if _centred(model)[j] else 1.0) * play, force
    return np.concatenate([tolerances.ravel(), np.zeros(n_resets), np.full(n_rubs, still)])
