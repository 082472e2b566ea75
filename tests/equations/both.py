"""One mechanism twice: the reference's bodies, and the package's generated functions."""

from __future__ import annotations

import numpy as np

from jointplay.solver.mechanism.assemble import assemble
from tests.support.linkages import SMALL, SOFT, bending, mechanism, own_state, start
from tests.support.multibody_beams import row
from tests.support.plain import Point, plain

from ..reference.four_bar import FourBar, Parameters


def pair(joints, links="", drive="motor", order="consistent", smooth=None, **changes):
    """The bodies and the package's model of a mechanism, with soft links, words in `links`.

    `smooth` is the velocity of friction by tanh.
    """
    p = Parameters(i=3.0, drive=drive, **{"f": 0.2, "C_t": 1.5 if links else 0.0} | changes)
    clearance = dict.fromkeys(joints, SMALL)
    bent = bending(mechanism(p, clearance, smooth), {name: SOFT[name] for name in links.split()}, order)
    rows = {link.name: row(link, order) for link in bent.links if link.elastic}
    return FourBar(p, clearance, rows, smooth), assemble(bent, start(p) if drive == "none" else None)


def numbers(system, model, y):
    """The package's numbers; a prescribed crank is at the reference's angle at time 0."""
    found = dict(zip(plain(model.structure).PARAMETERS, model.numbers, strict=True))
    return found | {"theta_0": y[0]} if system.p.drive == "speed" else found


def point(system, model, y, modes):
    """The package's functions at the reference's state y."""
    values = list(numbers(system, model, y).values())
    return Point(plain(model.structure), values, own_state(system, y), modes)


def accelerations(system, y, modes):
    """The bodies' accelerations of the package's unknowns, in its order."""
    return np.split(own_state(system, system.rate(y, modes)), 2)[1]
