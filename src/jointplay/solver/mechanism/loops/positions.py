"""Positions of links at given angles: their origins by linear least squares on every joint, for many samples.

With all angles known the joints are linear in the origins o: a revolute one asks for

    P_journal - P_bearing = r,    P = o + at (cos theta, sin theta),

r its recorded eccentricity or 0; a prismatic one for n.(P_journal - P_bearing) = 0, if it has no clearance,
and along the guide for its recorded slide. What is not recorded is taken as closed; where that contradicts,
as of unrecorded play, it is shared out among the joints. Where slides that were not recorded leave a link
free to move, as of a carriage on a spring, there is no answer. Units: m, rad.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jointplay.display.errors import refuse
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

Values = Mapping[str, np.ndarray]


def origins(
    mechanism: Mechanism, angles: Values, eccentricities: Values | None = None, slides: Values | None = None
) -> dict[str, np.ndarray]:
    """Give the origins of all links.

    Parameters
    ----------
    mechanism : Mechanism
        Rigid or elastic; elastic links are taken as straight.
    angles : mapping of str to ndarray, shape (samples,)
        Of every link, rad.
    eccentricities : mapping of str to ndarray, shape (samples, 2)
        By joint: the journal's centre relative to the bearing's, m, in fixed axes.
    slides : mapping of str to ndarray, shape (samples,)
        By prismatic joint: how far along its guide the slider is, m.

    Returns
    -------
    dict of str to ndarray, shape (samples, 2)
        By link, m.

    Raises
    ------
    InputError
        If a place hangs on a slide that was not recorded.
    """
    names = [link.name for link in mechanism.links]
    rows, right = [], []
    for joint in mechanism.joints:
        slope, known = _difference(names, angles, joint)
        if joint.prismatic:
            along, axes = (slides or {}).get(joint.name), _guide(angles, joint)
            axes = axes[:, 0 if along is not None else 1 : 2 if joint.ideal else 1]
            wanted = np.zeros(axes.shape[:2])
            if along is not None:
                wanted[:, 0] = along
            rows.append(axes @ slope)
            right.append(wanted - (axes @ known[..., None])[..., 0])
        else:
            rows.append(np.broadcast_to(slope, (len(known), *slope.shape)))
            right.append((eccentricities or {}).get(joint.name, 0.0) - known)
    slopes = np.concatenate(rows, 1)
    if np.linalg.matrix_rank(slopes).max() < slopes.shape[2]:
        raise refuse("no slide_position", "a response that records slide_position is accepted", "motion")
    found = np.linalg.pinv(slopes) @ np.concatenate(right, 1)[..., None]
    return {name: found[:, 2 * i : 2 * i + 2, 0] for i, name in enumerate(names)}


def pin_positions(pin: Pin, angles: Values, places: Values) -> np.ndarray:
    """Position of a pin, m, shape (samples, 2), from the result of `origins`."""
    if pin.link == GROUND:
        return np.broadcast_to(np.array(pin.point, dtype=float), next(iter(places.values())).shape)
    return places[pin.link] + _arm(pin, angles)


def gap(mechanism: Mechanism, angles: Values, places: Values, eccentricities: Values) -> float:
    """Widest gap in any joint beyond its recorded eccentricity, of a guide across it beyond its play, m."""
    widest = 0.0
    for joint in mechanism.joints:
        ends = (pin_positions(pin, angles, places) for pin in (joint.journal, joint.bearing))
        apart = np.subtract(*ends)
        if joint.prismatic:
            across = (_guide(angles, joint)[:, 1:] @ apart[..., None])[:, 0]
            missed = np.abs(across) - joint.clearance
        else:
            missed = np.linalg.norm(apart - eccentricities.get(joint.name, 0.0), axis=1)
        widest = max(widest, float(missed.max()))
    return widest


def _arm(pin: Pin, angles: Values) -> np.ndarray:
    angle = np.asarray(angles[pin.link])
    return pin.at * np.stack([np.cos(angle), np.sin(angle)], -1)


def _difference(names: list[str], angles: Values, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """P_journal - P_bearing: its derivative by the origins, shape (2, 2 links), and the rest of it."""
    slope, known = np.zeros((2, 2 * len(names))), np.zeros((len(angles[names[0]]), 2))
    for pin, sign in ((joint.journal, 1.0), (joint.bearing, -1.0)):
        if pin.link == GROUND:
            known += sign * np.array(pin.point)
        else:
            i = 2 * names.index(pin.link)
            slope[:, i : i + 2] += sign * np.eye(2)
            known += sign * _arm(pin, angles)
    return slope, known


def _guide(angles: Values, joint: Joint) -> np.ndarray:
    """Unit vectors along and across a guide, shape (samples, 2, 2)."""
    pin = joint.bearing
    angle = pin.direction + (0.0 if pin.link == GROUND else np.asarray(angles[pin.link]))
    angle = np.broadcast_to(angle, np.shape(next(iter(angles.values()))))
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], 1)
