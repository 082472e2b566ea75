"""Impulses at points of links, and the changes of speed by them.

An impulse J on the point P of a link changes the free speeds by z+ - z = M^-1 V^T J, with V = dP'/dz = dP/dq
and the mass matrix M, and so the velocity of P by W J, with W = V M^-1 V^T (virtual work). The slopes of P
are differences of order 4, to 1e-10 of themselves. Links that bend are refused, since their modes would be
excited too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator

from jointplay.analysis.states.mass_matrix import evaluated
from jointplay.display.errors import Problem, unknown
from jointplay.solver.mechanism.base import Angle, PartName, Record, measured, named
from jointplay.solver.mechanism.loops.positions import origins, pin_positions
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parts.joints import Pin, on_a_link
from jointplay.solver.mechanism.records import Mechanism, TestSystem

STEP = 1e-3  # of the differences, rad or of the mechanism's reach
WEIGHTS = ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12))


class Impulse(Record):
    """An impulse on a point of a link, N s.

    Parameters
    ----------
    name : str
        Name.
    on : Pin
        Link and place on which it acts.
    direction : float, optional
        Its direction, rad anticlockwise from x, or from the link's line; each is tried if left out.
    fixed : {'ground', 'link'}
        What the direction is fixed in.
    """

    name: PartName = named("impulse name")
    on: Annotated[Pin, AfterValidator(on_a_link)]
    direction: Angle | None = measured("direction", "rad", None)
    fixed: Literal["ground", "link"] = "ground"


def impulses_fit(mechanism: Mechanism | TestSystem, impulses: Sequence[Impulse]) -> Iterator[Problem]:
    """Yield the problems of impulses on a mechanism."""
    links = {link.name: link for link in mechanism.links} if isinstance(mechanism, Mechanism) else {}
    names, loose = [each.name for each in impulses], impulses and _loose(mechanism)
    if loose:
        yield Problem("impulses", names, f"guides without clearance are accepted, unlike {', '.join(loose)}")
    for n, each in enumerate(impulses):
        key = f"impulses[{n}]"
        if each.on.link not in links:
            yield unknown(f"{key}.on.link", each.on.link, each.on.link, links, "link")
        elif links[each.on.link].elastic:
            yield Problem(f"{key}.on.link", each.on.link, "a link that does not bend is accepted")
        if each.name in names[:n] or each.name in links:
            yield Problem(
                f"{key}.name", each.name, "a name that no link and no other impulse has is accepted"
            )


def _loose(mechanism: Mechanism | TestSystem) -> list[str]:
    """Guides with play, of which links do not say where they are."""
    joints = mechanism.joints if isinstance(mechanism, Mechanism) else ()
    return [joint.name for joint in joints if joint.prismatic and not joint.ideal]


@dataclass(frozen=True)
class Blow:
    """An impulse on a mechanism."""

    mechanism: Mechanism
    impulse: Impulse

    def point(self, model: Model, states: np.ndarray) -> np.ndarray:
        """Position of the point at some states, m, shape (rows, 2)."""
        joints = {j.name: j for j in self.mechanism.joints}
        words = {f"angle:{link}" for link in model.links}
        words |= {f"journal_{axis}:{name}" for name in model.joints if name in joints for axis in "xy"}
        words |= {f"slide_position:{name}" for name in model.guides}
        found = evaluated(model, states, sorted(words))
        angles = {link: found[f"angle:{link}"] for link in model.links}
        played = [name for name in model.joints if f"journal_x:{name}" in found]
        apart = {
            name: np.stack([found[f"journal_x:{name}"], found[f"journal_y:{name}"]], -1) for name in played
        }
        slides = {name: found[f"slide_position:{name}"] for name in model.guides}
        return pin_positions(self.impulse.on, angles, origins(self.mechanism, angles, apart, slides))

    def slopes(self, model: Model) -> np.ndarray:
        """Derivatives of the point's place by the positions, shape (2, positions)."""
        n_q = len(model.turning)
        steps = np.where(model.turning > 0, STEP, STEP * (model.reach or 1.0))
        moved = np.repeat(model.state[None], len(WEIGHTS) * n_q, axis=0)
        for row, (share, _) in enumerate(WEIGHTS):
            moved[row * n_q + np.arange(n_q), np.arange(n_q)] += share * steps
        places = self.point(model, moved).reshape(len(WEIGHTS), n_q, 2)
        weights = np.array([weight for _, weight in WEIGHTS])
        return (np.tensordot(weights, places, 1) / steps[:, None]).T

    def aim(self, model: Model, direction: float) -> np.ndarray:
        """Unit vector of the impulse; `direction` is its sense, or an angle where none is fixed."""
        given, angle = self.impulse.direction, direction
        if given is not None:
            angle += given
        if self.impulse.fixed == "link":
            angle += float(
                evaluated(model, model.state[None], [key := f"angle:{self.impulse.on.link}"])[key][0]
            )
        return np.array([math.cos(angle), math.sin(angle)])

    def mobility(self, model: Model, mass: np.ndarray) -> Any:
        """Largest speed that the point has, along the impulse, by one of 1 N s; m/s."""
        V = self.slopes(model)
        W = V @ np.linalg.solve(mass, V.T)
        if self.impulse.direction is None:
            return float(np.linalg.eigvalsh(W)[-1])
        d = self.aim(model, 0.0)
        return float(d @ W @ d)
