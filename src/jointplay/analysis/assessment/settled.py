"""The motion that a linkage settles to: is contact lost in it, is its period other than 1, is it chaotic.

*Contact is lost* where a joint with clearance separates or flies at all; a motion is *other than of period 1*
where its section points, one a turn, do not all agree; it is *chaotic* where no period is found and the
largest exponent of its section map is above 0 by more than `ERRORS` standard errors whose batches do not
follow one another. What is neither is followed further, since motions settle slowly beside the edge of their
period. A motion carried on from a chaotic one is asked for its exponent at once, over fewer turns: three of
its errors say whether these were enough, and it is followed further where they do not.

Chaos may be transient: beyond a crisis, and in a periodic window, a motion is chaotic for some hundreds or
thousands of turns before it settles to an orbit (Grebogi, Ott, Yorke, Physica D 7, 1983). Chaos is *lasting*
where it has not died out after `LASTING` transients more; at an edge of chaos only that counts, and beside a
chaotic motion what has lasted the first of these. What has no period there, and an exponent that does not say
whether it is chaotic, is asked over `SURE` times the turns.
Validity: as of `bifurcation`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import End
from jointplay.analysis.sweeps.attractor import Plan, settle
from jointplay.solver.mechanism.records import CrankAngle, Mechanism

PATIENCE = (4, 8, 32)  # transients more, one after another, of a motion without the usual period
LASTING = (4, 16, 36)  # transients more, one after another, in which chaos must not die out
SURE = 4  # times the turns of an exponent
ERRORS = 3  # standard errors by which an exponent must be above 0
FOLLOWING = 0.32  # correlation of batch means from which their error is too small
CHANGES = ("contact_loss", "doubling", "chaos")
ONCE_A_TURN = CrankAngle()


class Unsettled(ArithmeticError):
    """A motion that was not followed to its end; `status` says why."""

    def __init__(self, status: int):
        super().__init__(STATUS[status])
        self.status = status


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
    slow : bool
        Whether it did not repeat soon.
    """

    mechanism: Mechanism
    end: End
    values: dict[str, Any]
    slow: bool = False

    def value(self, name: str, missing: float = np.nan) -> Any:
        """A number of the description, or a list of them over joints."""
        given = self.values.get(name, ((), missing))[1]
        return given[0] if name.startswith("section_") and np.ndim(given) else given

    @property
    def period(self) -> int:
        """Turns after which the motion repeats; 0 for none."""
        return max(int(self.value("period")), 0)

    @property
    def traits(self) -> dict[str, bool]:
        """Answer of each of `CHANGES`."""
        exponent, error, follows = (
            float(self.value(f"section_{name}"))
            for name in ("exponent_per_turn", "standard_error_per_turn", "batch_correlation")
        )
        sure = exponent > ERRORS * error and not follows > FOLLOWING
        lost = bool(np.any(np.asarray(self.value("contact_fraction", 1.0)) < 1.0))
        return {"contact_loss": lost, "doubling": self.period != 1, "chaos": self.period == 0 and sure}


def plan(transient: int, turns: int, exponent_turns: int, rtol: float, max_steps: int | None) -> Plan:
    """Settings of a motion that is followed for its traits."""
    lengths = {"turns": turns, "transient": transient, "keep": 1, "lyapunov_turns": exponent_turns}
    return Plan(section=ONCE_A_TURN, record=(), rtol=rtol, max_steps=max_steps, **lengths)


def settled(mechanism: Mechanism, start: Any, how: Plan, usual: int = 1) -> Settled:
    """Follow a motion until it has settled; `Unsettled` where that fails.

    A period other than the `usual` one counts if it is found again later: a motion that alternates about an
    orbit of period 1 as it decays seems to have period 2. If none is usual an exponent is measured at once.
    """
    motion = followed(mechanism, start, how if usual else replace(how, exponents=1))
    for more in PATIENCE:
        if motion.period == max(usual, 1) or motion.traits["chaos"]:
            break
        longer, before = replace(how, transient=max(more * how.transient, 1), exponents=1), motion.period
        motion = followed(mechanism, motion.end, longer)
        if before and motion.period == before:
            break
    return motion


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
    answer = settle(mechanism, start, how)
    if answer["status"]:
        raise Unsettled(answer["status"])
    return Settled(mechanism, answer["end"], answer["values"])
