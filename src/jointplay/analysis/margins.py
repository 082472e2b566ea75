"""What of each guard is zero to rounding or to the tolerance, so that neither makes an event."""

import math
from functools import lru_cache

import numpy as np

from jointplay.equations.laws import LAWS, Law
from jointplay.equations.structure import Linkage, Oscillator, parameter_names
from jointplay.mechanism.scene import SPEED_FLOOR, Scene

EPS = float(np.finfo(float).eps)
NOISE = 1e-12  # sliding speeds are known no better than this tolerance has them
ROUNDINGS = 64  # nor than so many roundings of the links' speeds, of which they are differences
APPROACH = 0.1  # of these: normal speeds, of which the rounding of the normal's direction makes sliding ones
FLAT = 1e-11  # rebounds are known no better than this tolerance has them
ROUNDED_GAP = 16  # roundings of the mechanism's reach within which a gap is zero


def _rounding(scene: Scene) -> float:
    """Rounding of a relative speed at a contact, m/s, at the nominal speed or that of the start."""
    turning = max((scene.reach / e for e in scene.clearances), default=0.0)
    speeds = scene.state[len(scene.turning) :][scene.turning > 0] if scene.reach else ()
    fastest = max(2 * math.pi / scene.period, float(np.max(np.abs(speeds), initial=0.0)))
    return EPS * scene.reach * fastest * (ROUNDINGS + APPROACH * turning)


def _play(scene: Scene) -> float:
    """Rounding of a gap, m."""
    return ROUNDED_GAP * EPS * scene.reach


def rest(scene: Scene, rtol: float) -> float:
    """Sliding speed that is within the tolerance of zero, or within rounding."""
    return max(max(rtol, NOISE) * scene.creep, _rounding(scene))


def rebound(rtol: float) -> float:
    """Height of a rebound from a rigid wall that is within the tolerance of zero."""
    return max(rtol, FLAT) * SPEED_FLOOR


def bushes(scene: Scene, n_contacts: int) -> np.ndarray:
    """Squares of the clearances, m^2; infinite of a contact that is no joint's."""
    found = np.full(n_contacts, np.inf)
    found[: len(scene.clearances)] = np.square(scene.clearances)
    return found


@lru_cache(maxsize=256)
def _laws(structure: Linkage | Oscillator) -> list[tuple[Law, list[int], int]]:
    """Law of each joint, and where its numbers and the friction coefficient stand among the parameters."""
    if isinstance(structure, Oscillator):
        return []
    place = {name: at for at, name in enumerate(parameter_names(structure))}
    return [
        (law, [place[f"{letter}_{joint.name}"] for letter in law.letters], place[f"f_{joint.name}"])
        for joint, law in ((joint, LAWS[joint.law]) for joint in structure.joints)
    ]


def _slopes(scene: Scene) -> list[tuple[float, float, float]]:
    """Of each joint: bounds of dF_n/du and dF_n/dv_n near zero, N/m and N s/m; the friction coefficient."""
    given = scene.numbers
    return [
        (*law.slopes(*given[places]), given[friction]) for law, places, friction in _laws(scene.structure)
    ]


def cones(scene: Scene) -> np.ndarray:
    """What rounding of a normal force F_n makes of (f F_n)^2 - F_t^2 near zero, over F_n, N."""
    found, play, speed = np.zeros(len(scene.joints)), _play(scene), _rounding(scene)
    for j, (K, C, f) in enumerate(_slopes(scene)):
        found[j] = 2 * f * (1 + f) * (K * play + C * speed)
    return found


def guards(scene: Scene, still: float, n_contacts: int, n_resets: int) -> np.ndarray:
    """What of each guard is within the tolerance of zero: gap, force, sliding speed; of others nothing."""
    found = np.zeros((n_contacts, 4))
    found[:, 2], play = still, _play(scene)
    for j, (K, _, _) in enumerate(_slopes(scene)):
        found[j, :2] = 2 * scene.clearances[j] * play, K * play
    return np.concatenate([found.ravel(), np.zeros(n_resets)])
