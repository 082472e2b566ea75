"""What laws of contact and friction remember, of a mechanism that starts."""

from __future__ import annotations

import numpy as np

from jointplay.equations.friction import FRICTIONS
from jointplay.equations.laws import LAWS
from jointplay.mechanism.bases import Bases


def approaches(bases: Bases) -> np.ndarray:
    """Give what laws remember at the start: speeds with which contacts began, then deflections of bristles.

    A joint that starts in contact has no beginning to remember: it counts as begun with the size of the
    normal speed that it has there, or with the smallest speed of its law, whichever is larger; one that
    starts in flight has the smallest speed. Bristles are straight.

    Returns
    -------
    ndarray, shape (laws that remember, 2)
        The speed, and the law's smallest one, m/s; the deflection, and that of steady sliding, m.
    """
    rows = []
    for joint in bases.mechanism.clearance_joints:
        if LAWS[joint.contact.law].floor:
            slowest = joint.contact.coefficients[LAWS[joint.contact.law].floor]
            for u, v_n in bases.penetrations(joint):
                rows.append((max(abs(v_n) if u >= 0 else 0.0, slowest), slowest))
    for joint in bases.mechanism.clearance_joints:
        friction = joint.friction
        if friction and friction.rubs and (size := FRICTIONS[friction.law].deflection):
            row = (0.0, size(friction.coefficient, *friction.numbers.values()))
            rows += [row] * len(bases.penetrations(joint))
    return np.array(rows, dtype=float).reshape(-1, 2)
