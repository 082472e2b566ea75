"""Knocks: sudden changes of a motion's state, of a size and in a direction.

- ``impulse:LINK``, an impulsive moment on a link, N m s: with the mass matrix M of the free speeds q', and
  the link's angular velocity w = b q', the speeds change by M^-1 b^T J. Both are exact from values: the
  kinetic energy is quadratic in the speeds, and w is linear. A crank whose speed is prescribed keeps it.
- ``shift:JOINT``, a displacement of the journal in its bearing, m; crank and other journals stay, and so do
  the speeds of journals in their bearings. It ends where the journal would leave the clearance.
- ``state:NAME``, of a test system: a change of one state, in its own units.

Sizes have a unit: what changes the link's speed by the nominal one; what gives the point the nominal speed
times the mechanism's reach; the clearance; 1. Validity: the knock is over before anything moves, and contacts
that are closed take no part of it.

Impulses at points of links: an impulse J on the point P of a link changes the free speeds by z+ - z = M^-1
V^T J, with V = dP'/dz = dP/dq and the mass matrix M, and so the velocity of P by W J, with W = V M^-1 V^T
(virtual work). The slopes of P are differences of order 4, to 1e-10 of themselves. Links that bend are
refused, since their modes would be excited too.

The smallest knock that throws a motion into another is searched over phases and directions, then confirmed.
At every section point of the motion, at even phases of a turn and in even directions, knocks of growing size
are tried. Where the first of them ends in another motion than one came from, the size is halved in; the
smallest is improved by turning direction and phase a little. Then shares of it are tried, from half to 1.2.
Where a smaller one tips, the search goes on below that. It is confirmed: at 0.99 of the size the motion
returns, at 1.01 it does not. Where boundaries are fractal that may fail however small the knock: both happen
in bands. What is known then is the largest size up to which every one tried there returned, where each share
leads, how many of even sizes up to 1.2 of it tip, and the smallest beginning of a band of these that is
confirmed. Validity: islands of another basin narrower than the steps of size, phase and direction are not
seen, so that the true smallest knock may be smaller.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator

from jointplay.analysis.coexisting.lasting import FAILED, NO_START, Motions
from jointplay.analysis.evaluate import mass_matrix, of_states
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.starts import Journals, free_states, state_names
from jointplay.analysis.states.start_plane import INSIDE, beyond_a_wall
from jointplay.display.errors import Problem, unknown
from jointplay.solver.mechanism.base import Angle, PartName, Record, measured, named
from jointplay.solver.mechanism.loops.positions import origins, pin_positions
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parts.joints import Pin, on_a_link
from jointplay.solver.mechanism.records import Mechanism, TestSystem

STEP = 1e-3  # of the differences, rad or of the mechanism's reach
WEIGHTS = ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12))

BEST, HALVINGS, ROUNDS = 6, 12, 5  # candidates halved in, how often; improvements of the best
NEARER = 0.98  # of the size, that a neighbour must beat
SHARES = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 1.0, 1.01, 1.02, 1.05, 1.1, 1.2)
BELOW, AT, ABOVE = (SHARES.index(share) for share in (0.99, 1.0, 1.01))
LARGER = np.linspace(1.0, SHARES[-1], 41)  # shares tried of a knock that is not confirmed
DESCENTS = 4  # how often the search goes on below an island of smaller sizes


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
        found = of_states(model, sorted(words), states)
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
            key = f"angle:{self.impulse.on.link}"
            angle += float(of_states(model, [key], model.state[None])[key][0])
        return np.array([math.cos(angle), math.sin(angle)])

    def mobility(self, model: Model, mass: np.ndarray) -> Any:
        """Largest speed that the point has, along the impulse, by one of 1 N s; m/s."""
        V = self.slopes(model)
        W = V @ np.linalg.solve(mass, V.T)
        if self.impulse.direction is None:
            return float(np.linalg.eigvalsh(W)[-1])
        d = self.aim(model, 0.0)
        return float(d @ W @ d)


def at_speeds(model: Model, speeds: np.ndarray) -> np.ndarray:
    """States of a linkage where it stands, with other speeds, shape (rows, states)."""
    n_q = len(model.turning)
    states = np.repeat(model.state[None, :], len(speeds), axis=0)
    states[:, n_q : 2 * n_q] = speeds
    return states


def masses(model: Model) -> np.ndarray:
    """The mass matrix where a linkage stands, symmetric to the last bit, shape (positions, positions)."""
    upper = np.triu(mass_matrix(model, model.state))
    return upper + np.triu(upper, 1).T


UNITS = {"impulse": "N m s", "blow": "N s", "shift": "m", "state": "1"}


@dataclass(frozen=True)
class Knock:
    """A kind of knock by its name, with the size that counts as one, in its units."""

    name: str
    unit: float
    blow: Blow | None = None

    @property
    def kind(self) -> str:
        """Kind of the knock: the first part of its name."""
        return self.name.partition(":")[0]

    @property
    def plane(self) -> bool:
        """Whether it has directions in a plane; else one and its opposite."""
        return self.kind == "shift" or (self.blow is not None and self.blow.impulse.direction is None)

    def applied(self, model: Model, direction: float, size: float) -> Model | None:
        """The model after a knock of a size, in units, in a direction, rad; None where it cannot be."""
        of, amount = self.name.partition(":")[2], size * self.unit
        if self.kind in ("impulse", "blow"):
            n_q, state = len(model.turning), model.state.copy()
            if self.blow is None:
                change = math.cos(direction) * speeds_by_moment(model, of)
            else:
                push = self.blow.slopes(model).T @ self.blow.aim(model, direction)
                change = np.linalg.solve(masses(model), push)
            state[n_q : 2 * n_q] += amount * change
            return replace(model, state=state)
        if self.kind == "state":
            state = model.state.copy()
            state[state_names(model).index(of)] += math.cos(direction) * amount
            moved = replace(model, state=state)
            return None if beyond_a_wall(moved) else moved
        return _shifted(model, of, amount * np.array([math.cos(direction), math.sin(direction)]))


def _shifted(model: Model, joint: str, shift: np.ndarray) -> Model | None:
    journals, at = Journals(model), 2 * model.joints.index(joint)
    states, before = model.state[None, :], journals.eccentricity_ratios(model.state[None, :])
    positions = journals.positions(states).copy()
    positions[:, at : at + 2] += shift
    put = journals.put(states, positions, journals.velocities(states))
    inside = journals.eccentricity_ratios(put) <= np.maximum(before, 1.0) * INSIDE
    return replace(model, state=put[0]) if inside.all() else None


def speeds_by_moment(model: Model, link: str) -> np.ndarray:
    """Change of the free speeds by a unit of an impulsive moment on a link, shape (coordinates,)."""
    n_q = len(model.turning)
    return np.linalg.solve(masses(model), np.diff(_link_speeds(model, link, np.eye(n_q)), axis=0)[0])


def _link_speeds(model: Model, link: str, changes: np.ndarray) -> np.ndarray:
    """Angular velocity of a link without free speeds, and with these, shape (2, changes)."""
    states = at_speeds(model, np.vstack([np.zeros(changes.shape[1]), changes]))
    key = f"angular_velocity:{link}"
    speeds = of_states(model, [key], states)[key]
    return np.stack([np.repeat(speeds[0], len(changes)), speeds[1:]])


def knocks(model: Model, mechanism: Mechanism | TestSystem, impulses: Sequence[Impulse] = ()) -> list[Knock]:
    """Kinds of knock that a model can have: all of each kind, and the given impulses on points."""
    if not model.links:
        return [Knock(f"state:{name}", 1.0) for name in free_states(model)]
    nominal, found = math.tau / model.period, []
    for link in model.links:
        change = speeds_by_moment(model, link)
        moved = float(np.diff(_link_speeds(model, link, change[None]), axis=0)[0, 0])
        if moved > 0:
            found.append(Knock(f"impulse:{link}", nominal / moved))
    for blow in (Blow(mechanism, each) for each in impulses):
        moved = blow.mobility(model, masses(model))
        if moved > 0:
            found.append(Knock(f"blow:{blow.impulse.name}", nominal * model.reach / moved, blow))
    bearings = [joint.name for joint in model.structure.joints if not joint.corner]
    return found + [Knock(f"shift:{name}", model.clearances[model.joints.index(name)]) for name in bearings]


class Place(NamedTuple):
    """Place of a knock: its section point, the phase ahead of that and the direction, rad."""

    point: int
    phase: float
    direction: float


@dataclass
class Knocked:
    """A motion that is knocked, and where that leads.

    Parameters
    ----------
    motions : Motions
        Those that are known.
    own : int
        Number of the motion that is knocked.
    points : ndarray
        Its states at the section.
    section : SectionMap or None
        Of one turn; None where nothing turns, and knocks are at section points alone.
    knock : Knock
        Its kind.
    """

    motions: Motions
    own: int
    points: np.ndarray
    section: SectionMap | None
    knock: Knock

    def start(self, place: Place, size: float) -> Model | None:
        """The motion after a knock, where it next comes to the section; None where there is no such knock."""
        base, state = self.motions.base, self.points[place.point]
        if self.section is None or not place.phase:
            return self.knock.applied(replace(base, state=state), place.direction, size)
        section, image = self.section.moved(state, place.phase)
        here = replace(base, state=image.state, crank_angle=section.phase)
        after = None if image.status else self.knock.applied(here, place.direction, size)
        if after is None:
            return None
        back, image = section.moved(after.state, math.tau - place.phase)
        if image.status:
            return None
        state = image.state.copy()
        if back.place is not None:
            state[back.place] = base.crank_angle
        return replace(base, state=state)

    def ends(self, tried: Sequence[tuple[Place, float]]) -> np.ndarray:
        """Numbers of the motions to which knocks lead."""
        return self.motions.sort([self.start(*each) for each in tried])

    def tips(self, tried: Sequence[tuple[Place, float]]) -> np.ndarray:
        """Whether knocks lead to another motion, or to one that does not settle."""
        return self.tipped(self.ends(tried))

    def tipped(self, labels: np.ndarray) -> np.ndarray:
        """Whether the numbers are of other motions, or of one that does not settle."""
        return (labels != self.own) & (labels != FAILED) & (labels != NO_START)

    def within(self, places: Sequence[Place], sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First of rising sizes that tips at each place, and the size before; infinite where none does."""
        table = self.tips([*product(places, sizes.tolist())]).reshape(len(places), len(sizes))
        first = np.where(table.any(axis=1), table.argmax(axis=1), len(sizes))
        return np.append(0.0, sizes)[first], np.append(sizes, np.inf)[first]

    def halved(self, places: Sequence[Place], low: np.ndarray, high: np.ndarray):
        """Closer bounds of the sizes at which knocks begin to tip."""
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            over = self.tips([*zip(places, middle.tolist(), strict=True)])
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return low, high


@dataclass(frozen=True)
class Smallest:
    """A knock that just tips: where, sizes below and above in units, and where `SHARES` of it lead.

    Every size up to `safe` that was tried there returned. `confirmed` is the smallest that is, or NaN. Where
    it is not this one, a `share` tips of the sizes up to 1.2 times it; else that is NaN.
    """

    place: Place
    low: float
    high: float
    ends: tuple[int, ...]
    safe: float
    confirmed: float
    share: float


def smallest(knocked: Knocked, phases: int, directions: int, sizes: np.ndarray) -> Smallest | None:
    """The smallest knock of a kind that tips a motion; None if none of the sizes does."""
    phases = 1 if knocked.section is None else phases
    count = directions if knocked.knock.plane else 2
    turns = [math.tau * k / phases for k in range(phases)]
    aims = [math.tau * k / count for k in range(count)]
    places = [Place(*each) for each in product(range(len(knocked.points)), turns, aims)]
    low, high = knocked.within(places, sizes)
    order = [n for n in np.argsort(high, kind="stable")[:BEST] if np.isfinite(high[n])]
    if not order:
        return None
    some = [places[n] for n in order]
    low, high = knocked.halved(some, low[order], high[order])
    n = int(np.argmin(high))
    best = some[n], float(low[n]), float(high[n])
    steps = math.tau / phases / 2 if phases > 1 else 0.0, math.tau / count / 2 if knocked.knock.plane else 0.0
    for _ in range(ROUNDS):
        best, steps = _improved(knocked, best, steps)
    return _checked(knocked, *best)


def _checked(knocked: Knocked, place: Place, low: float, high: float) -> Smallest:
    """Try shares of a knock, and go on below it where a smaller one tips."""
    shares = np.array(SHARES)
    for descent in range(DESCENTS + 1):
        ends = knocked.ends([(place, size) for size in shares * high])
        over = knocked.tipped(ends)
        first = int(over.argmax())
        if descent == DESCENTS or not over.any() or first >= AT:
            break
        below = shares[first - 1] * high if first else 0.0
        some_low, some_high = knocked.halved([place], np.array([below]), np.array([shares[first] * high]))
        low, high = float(some_low[0]), float(some_high[0])
    safe = low if first >= AT or not over.any() else shares[first - 1] * high if first else 0.0
    settled = ends[BELOW] == knocked.own and over[ABOVE] and ends[ABOVE] >= 0
    confirmed, share = (high, math.nan) if settled else _larger(knocked, place, high)
    return Smallest(place, low, high, tuple(ends.tolist()), float(safe), confirmed, share)


def _larger(knocked: Knocked, place: Place, size: float) -> tuple[float, float]:
    """The smallest larger knock that is confirmed, or NaN; and the share of knocks up to 1.2 that tips."""
    sizes = size * LARGER
    over = knocked.tips([(place, each) for each in sizes])
    begin = np.flatnonzero(~over[:-1] & over[1:])
    share = float(over.mean())
    if not begin.size:
        return math.nan, share
    _, edges = knocked.halved([place] * len(begin), sizes[begin], sizes[begin + 1])
    ends = knocked.ends([(place, share * edge) for edge in edges for share in (SHARES[BELOW], SHARES[ABOVE])])
    below, above = ends.reshape(-1, 2).T
    good = (below == knocked.own) & knocked.tipped(above) & (above >= 0)
    return (float(edges[good].min()) if good.any() else math.nan), share


def _improved(knocked: Knocked, best: tuple[Place, float, float], steps: tuple[float, float]):
    """A neighbouring phase or direction in which a smaller knock tips; else the same, with half the steps."""
    place, _, high = best
    moves = [(s * steps[0], 0.0) for s in (-1, 1) if steps[0]] + [
        (0.0, s * steps[1]) for s in (-1, 1) if steps[1]
    ]
    others = [Place(place.point, (place.phase + a) % math.tau, place.direction + b) for a, b in moves]
    if others:
        low, above = knocked.within(others, NEARER * high * np.linspace(1 / 3, 1.0, 3))
        n = int(np.argmin(above))
        if np.isfinite(above[n]):
            low, above = knocked.halved([others[n]], low[[n]], above[[n]])
            return (others[n], float(low[0]), float(above[0])), steps
    return best, (steps[0] / 2, steps[1] / 2)
