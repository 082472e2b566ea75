"""The motion that a linkage settles to: is contact lost in it, is its period other than 1, is it chaotic.

*Contact is lost* where a joint with clearance separates or flies at all; a motion is *other than of period 1*
where its section points, one a turn, do not all agree; it is *chaotic* where no period is found and the
largest exponent of its section map is above 0 by more than `ERRORS` standard errors, widened where batches
follow one another, and by more than ln N / N after N turns, since neighbours of a motion that neither settles
nor is chaotic part as N. What is neither is followed further, since motions settle slowly beside the edge of
their period. A motion carried on from a chaotic one is asked for its exponent at once, over fewer turns:
three of its errors say whether these were enough. Where they do not, it is followed further, and its exponent
measured over `SURE` times the turns.

Chaos may be transient: beyond a crisis, and in a periodic window, a motion is chaotic for some hundreds or
thousands of turns before it settles to an orbit (Grebogi, Ott, Yorke, Physica D 7, 1983). Chaos is *lasting*
where it has not died out after `LASTING` transients more; at an edge of chaos only that counts, and beside a
chaotic motion what has lasted the first of these. What has no period there, and an exponent that does not say
whether it is chaotic, is asked over `SURE` times the turns.

The present motion is not waited for where it can be found: its *orbit* is sought first, by Newton's method
from the mean of the last section points, which averages away what swings about it. The motion has to approach
it: its part along the least stable direction, by the left eigenvector of the largest multiplier, has to
shrink. So a journal that swings along its bearing for thousands of turns, as it does without friction, is
known by its orbit.
Validity: as of `bifurcation`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jointplay.analysis.exponents.batch_means import sure_growth
from jointplay.analysis.orbits import shooting
from jointplay.analysis.orbits.section_map import SectionMap, section_map
from jointplay.analysis.orbits.shooting import Orbit, at_phase, nearby, on_section
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import End, placed, state_names
from jointplay.analysis.sweeps.attractor import Plan, settle
from jointplay.jobs.job import key_of
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism

PATIENCE = (4, 8, 32)  # transients more, one after another, of a motion without the usual period
LASTING = (4, 16, 36)  # transients more, one after another, in which chaos must not die out
SURE = 4  # times the turns of an exponent
CHANGES = ("contact_loss", "doubling", "chaos")
SOUGHT = (20, 20, 40, 40)  # turns after which, one after another, an orbit is sought
LONGER = (*SOUGHT, 80, 80, 80)  # of what settles slowly with other contact data
MEAN = 20  # last section points from whose mean
APPROACH, STRETCHES = 10, 4  # turns in which the motion has to come nearer, each of so many times
SHARP = 1e-10  # tolerance of steps: multipliers near 1 need it
NEWTON = {"iterations": 12, "shortest": 0.25}  # what takes more is no orbit nearby
SLOW = 0.9  # largest multiplier above which a motion settles slowly
CLOSE = 1e-7  # of a distance, in units of the states' scales: it is reached


def log_distance(one: float, other: float = 1.0) -> float:
    """Distance of two values of a parameter, or of their ratio from 1, in the logarithm."""
    return abs(math.log(one / other))


class Unsettled(ArithmeticError):
    """A motion that was not followed to its end; `status` says why."""

    def __init__(self, status: int):
        super().__init__(STATUS[status])
        self.status = status


@dataclass(frozen=True)
class Remembering(Plan):
    """Settings of motions that are kept, so that a search that was cut short finds them again.

    Parameters
    ----------
    known : dict
        Motions by the hash of all that decides them, as `Settled.plain`; new ones are added.
    batched : bool
        Whether a motion is followed beside others, by another method.
    """

    known: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)
    batched: bool = False


@dataclass(frozen=True, eq=False)
class Settled:
    """A motion that a mechanism has settled to.

    Parameters
    ----------
    mechanism : Mechanism
        What moves.
    end : End
        Where it stands, at crank angle 0.
    values : dict
        As `attractor.settle` describes it.
    orbit : ndarray, optional
        State at crank angle 0 of the stable periodic orbit that it is.
    radius : float
        Largest modulus of the orbit's multipliers.
    """

    mechanism: Mechanism
    end: End
    values: dict[str, Any]
    orbit: np.ndarray | None = None
    radius: float = np.nan

    def value(self, name: str, missing: float = np.nan) -> Any:
        """A number of the description, or a list of them over joints."""
        given = self.values.get(name, ((), missing))[1]
        return given[0] if name.startswith("section_") and np.ndim(given) else given

    def plain(self) -> dict[str, Any]:
        """All but the mechanism, as the answer of a cell."""
        return {"end": self.end, "values": self.values, "orbit": self.orbit, "radius": self.radius}

    @classmethod
    def of(cls, mechanism: Mechanism, plain: Mapping[str, Any]) -> Settled:
        """The motion of a mechanism, from the answer of a cell."""
        return cls(mechanism, End.read(plain["end"]), plain["values"], plain["orbit"], plain["radius"])

    @property
    def period(self) -> int:
        """Turns after which the motion repeats; 0 for none."""
        return max(int(self.value("period")), 0)

    @property
    def traits(self) -> dict[str, bool]:
        """Answer of each of `CHANGES`."""
        exponent, error, correlation = (
            float(self.value(f"section_{name}"))
            for name in ("exponent_per_turn", "standard_error_per_turn", "batch_correlation")
        )
        least = sure_growth(error, correlation, self.value("exponent_turns"))
        lost = bool(np.any(np.asarray(self.value("contact_fraction", 1.0)) < 1.0))
        chaos = self.period == 0 and bool(exponent > least)
        return {"contact_loss": lost, "doubling": self.period != 1, "chaos": chaos}


def present(mechanism: Mechanism, start: Any, how: Plan) -> Settled:
    """The motion from a start as it is in the end: its orbit where it has one, else after a long time."""
    motion, last = _sought(mechanism, start, SOUGHT, how)
    if motion is not None:
        return motion
    motion = lasting(settled(mechanism, last, how), how)
    if motion.period:
        section = _sharp(mechanism, motion.end, how, motion.period)
        orbit = nearby(section, motion.end.state, **NEWTON)
        if not orbit.status and shooting.stable(shooting.multipliers(orbit.image.derivative)):
            return on_orbit(mechanism, orbit, how)
    return motion


def reached(mechanism: Mechanism, start: Any, how: Plan, waits: tuple[int, ...] = SOUGHT[:1]) -> Settled:
    """The motion from a start after some turns: its orbit where it has one, else as it is then."""
    motion, last = _sought(mechanism, start, waits, how)
    return motion or followed(mechanism, last, replace(how, transient=0))


def _sharp(mechanism: Mechanism, start: Any, how: Plan, turns: int = 1) -> SectionMap:
    """The map of turns from a start on, at a tolerance that tells multipliers near 1 apart."""
    return section_map(placed(mechanism, start, ONCE_A_TURN), ONCE_A_TURN, turns, SHARP, how.max_steps)


def _sought(
    mechanism: Mechanism, start: Any, waits: tuple[int, ...], how: Plan
) -> tuple[Settled | None, End]:
    """The stable orbit that a motion approaches, if one is found; and where the motion stands."""
    section = _sharp(mechanism, start, how)
    state, status = on_section(section)
    points = [state]
    for turns in waits:
        for _ in range(turns):
            image = section.image(points[-1], False)
            if status := status or image.status:
                raise Unsettled(status)
            points.append(image.state)
        orbit = nearby(section, np.mean(points[-MEAN:], axis=0), **NEWTON)
        if not orbit.status and approached(orbit, section, points[-1]):
            return on_orbit(mechanism, orbit, how), End((), state, 0.0)
    return None, End(state_names(section.model), points[-1], 0.0)


def on_orbit(mechanism: Mechanism, orbit: Orbit, how: Plan) -> Settled:
    """The motion on a stable periodic orbit."""
    state, multipliers = at_phase(orbit, 0.0)[0], shooting.multipliers(orbit.image.derivative)
    end = End(state_names(orbit.map.model), state, 0.0)
    motion = followed(mechanism, end, replace(how, transient=0))
    exponent = float(np.log(abs(multipliers[0])) / orbit.map.turns)
    values = motion.values | {"period": ((), orbit.map.turns), "section_exponent_per_turn": ((), exponent)}
    return replace(motion, end=end, values=values, orbit=state, radius=float(abs(multipliers[0])))


def approached(orbit: Orbit, section: SectionMap, point: np.ndarray) -> bool:
    """Whether an orbit is stable, and the motion from a point of the section comes nearer to it."""
    values, left = np.linalg.eig(orbit.image.derivative.T)
    largest = int(np.argmax(np.abs(values)))
    if not abs(values[largest]) < 1:
        return False
    there, eigenvector, expected = orbit.map, left[:, largest], abs(values[largest]) ** APPROACH
    ahead = (there.phase - section.phase) * there.direction % (2 * np.pi)
    state = section.moved(point, ahead)[1].state if ahead else point
    for _ in range(STRETCHES):
        image = there.image(state, False, APPROACH)
        if image.status:
            return False
        before, after = (abs(eigenvector @ there.differ(each, orbit.state)) for each in (state, image.state))
        if np.max(np.abs(there.differ(image.state, orbit.state))) < CLOSE:
            return True
        if not after < before * (1 + expected) / 2:
            return False
        state = image.state
    return True


def plan(transient: int, turns: int, exponent_turns: int, rtol: float, max_steps: int | None) -> Plan:
    """Settings of a motion that is followed for its traits."""
    lengths = {"turns": turns, "transient": transient, "keep": 1, "lyapunov_turns": exponent_turns}
    return Plan(section=ONCE_A_TURN, record=(), rtol=rtol, max_steps=max_steps, **lengths)


def settled(mechanism: Mechanism, start: Any, how: Plan, usual: int = 1) -> Settled:
    """Follow a motion until it has settled; `Unsettled` where that fails.

    A period other than the `usual` one counts if it is found again later: a motion that alternates about an
    orbit of period 1 as it decays seems to have period 2. If none is usual an exponent is measured at once.
    What still swings about such an orbit in the end, and approaches it, is that orbit.
    """
    motion = followed(mechanism, start, how if usual else replace(how, exponents=1))
    for more in PATIENCE:
        if (orbit := _about(motion, usual, how)) is not None:
            return orbit
        longer, before = replace(how, transient=max(more * how.transient, 1), exponents=1), motion.period
        if not before and np.isfinite(motion.value("section_exponent_per_turn")):  # and has not said it
            longer = replace(longer, lyapunov_turns=SURE * how.lyapunov_turns)
        motion = followed(mechanism, motion.end, longer)
        if before and motion.period == before:
            break
    return _about(motion, usual, how) or motion


def _about(motion: Settled, usual: int, how: Plan) -> Settled | None:
    """The motion, of the usual period or chaotic; else the orbit that it approaches, if there is one.

    It swings about one only where its exponent, once it is known, says that this hardly decays.
    """
    if motion.period == max(usual, 1) or motion.traits["chaos"]:
        return motion
    if not motion.value("section_exponent_per_turn") > np.log(SLOW):
        return None
    try:
        return _sought(motion.mechanism, motion.end, SOUGHT[:1], how)[0]
    except Unsettled:  # at the sharper tolerance: the motion stands as it was followed
        return None


def lasting(motion: Settled, how: Plan, waits: tuple[int, ...] = LASTING) -> Settled:
    """A motion as it is in the end: where its chaos is transient the one that it becomes."""
    if not (motion.period or motion.traits["chaos"]):
        longer = replace(how, transient=0, exponents=1, lyapunov_turns=SURE * how.lyapunov_turns)
        motion = followed(motion.mechanism, motion.end, longer)
    later = motion
    for more in waits if motion.traits["chaos"] else ():
        later = followed(motion.mechanism, later.end, replace(how, transient=max(more * how.transient, 1)))
        if later.period:
            return later
    return motion


def followed(mechanism: Mechanism, start: Any, how: Plan) -> Settled:
    """Follow a motion once; `Unsettled` where that fails."""
    known, key = {}, ""
    if isinstance(how, Remembering):
        known, key = how.known, key_of(mechanism, start, repr(how))
    if key not in known:
        answer = settle(mechanism, start, how)
        if answer["status"]:
            raise Unsettled(answer["status"])
        known[key] = Settled(mechanism, answer["end"], answer["values"]).plain()
    return Settled.of(mechanism, known[key])
