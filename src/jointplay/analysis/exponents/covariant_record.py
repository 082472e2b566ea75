"""QR factors of a motion's tangents, block by block, with the frame at section points.

A block is a piece of the run in which the frame is carried as it is; at its end it is made orthonormal.
Blocks are so short that no direction is lost in the rounding of another. The last direction of a whole frame
may shrink faster than steps resolve (method.tangents.tangent): its growth is what the volume leaves for it.

Section points are those at the crank's first angle (at a forcing's first phase, at a constant speed once a
turn, and in a system that nothing turns once in its time scale); blocks end there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.exponents.covariant_vectors import factors
from jointplay.analysis.starts import crank_place
from jointplay.analysis.tangents import Bundle, scales
from jointplay.solver.method.tangents.frame import LOST

LONGEST = 1 / 50  # of a turn: a block
SPREAD = 6.0  # ln of the ratio of the largest to the smallest growth in a block that is aimed at
SHORTEST = 1e-3  # of the longest block
NEAR = 1e-6  # rad of the crank's angle: so near to a section point is there
TINY = 1e-100  # of the last direction's growth, that is as good as 0; its square is still a number
AIM = 0.98  # of the way to a section point, gone before the last block to it


@dataclass(frozen=True)
class Block:
    """A block of a run.

    Parameters
    ----------
    time : float
        Its end, s.
    R : ndarray
        Factor of the frame that was carried through it.
    below : float
        ln of the last direction's growth less that of R's last entry.
    state, frame, rate : ndarray, optional
        Where its end is a section point: state; frame of unit columns in units of the scales; rate of the
        state in these units.
    """

    time: float
    R: np.ndarray
    below: float
    state: np.ndarray | None = None
    frame: np.ndarray | None = None
    rate: np.ndarray | None = None

    @property
    def growth(self) -> np.ndarray:
        """ln of the growth of each direction of the frame."""
        logs = np.log(np.diag(self.R))
        logs[-1] += self.below
        return logs


class Recorder:
    """A run that goes on block by block, from where a bundle of tangents stands.

    Parameters
    ----------
    bundle : Bundle
        Its tangents, without the motion's own, are the frame.

    Attributes
    ----------
    status : int
        How the last block ended (method.flow); 0: well.
    lost : int
        How many directions the motion's events have taken away since.
    spread : float
        Largest ln of the ratio of two directions' growth in a block.
    """

    def __init__(self, bundle: Bundle):
        self.bundle, self.model, self.status, self.lost = bundle, bundle.model, 0, 0
        self.spread = 0.0
        self.scale, self.crank = scales(self.model), crank_place(self.model)
        bundle.tangents.count[bundle.at.HELD] = 1
        self.Q = factors(self._image())[0]
        self.whole = self.Q.shape[0] == self.Q.shape[1]
        bundle.tangents.alive[:] = np.arange(len(bundle.tangents.alive)) < self.Q.shape[1]
        self.longest = LONGEST * self.model.period
        passed = math.floor(bundle.time / self.model.period + NEAR)
        self.length, self.next = self.longest, self.model.period * (passed + 1)
        if self.crank is not None:
            turned = (self._angle - self.model.crank_angle) * self.model.forward / math.tau
            self.next = self.model.crank_angle + self.model.forward * math.tau * (math.floor(turned) + 1)

    @property
    def left(self) -> int:
        """Number of directions left."""
        return self.Q.shape[1]

    @property
    def _angle(self) -> float:
        return float(self.bundle.motion.s[1 + self.crank])

    def _image(self) -> np.ndarray:
        """The frame's image in units of the scales, shape (states, directions that are left)."""
        tangents = self.bundle.tangents
        return (self.bundle.vectors[tangents.alive.astype(bool)] / self.scale).T

    def blocks(self, until: float, tell: Callable[[], None] | None = None) -> Iterator[Block]:
        """Go on until a time, the run's end or the last direction's; give each block.

        `tell` as of `Bundle.advance`.
        """
        while self.status == 0 and self.left and self.bundle.time < until:
            block = self._block(until, tell)
            if self.status == 0 and self.left:
                yield block

    def _block(self, until: float, tell: Callable[[], None] | None) -> Block:
        bundle, real, at = self.bundle, self.bundle.tangents.real, self.bundle.at
        self._carry()
        real[at.TRACE] = real[at.VOLUME] = 0.0
        end, there = self._end(until)
        self.status = bundle.advance(end, tell)
        image, volume = self._image(), float(real[at.TRACE] + real[at.VOLUME])
        Q, R = factors(image)
        if volume == -math.inf:
            Q, R = self._without_lost(image, Q, R)
        self.Q, below = Q, 0.0
        if self.whole and self.lost == 0:
            R[-1, -1] = max(R[-1, -1], TINY)
            below = volume - float(np.log(np.diag(R)).sum())
        self._adapt(R)
        if not self._passed(there):
            return Block(bundle.time, R, below)
        return Block(bundle.time, R, below, bundle.state, Q, bundle.rate() / self.scale)

    def _carry(self) -> None:
        """Put the frame in place of its image."""
        d = self.bundle.tangents.d.reshape(len(self.bundle.tangents.alive), -1)
        d[: self.Q.shape[1], 1:] = (self.Q * self.scale[:, None]).T

    def _without_lost(self, image: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give up a direction that an event has left to rounding, and the directions after it."""
        gone = np.flatnonzero(np.diag(R) <= LOST * np.linalg.norm(image, axis=0))
        if not gone.size:
            return Q, R
        kept = int(gone[0])
        self.lost += len(R) - kept
        self.bundle.tangents.alive[kept:] = 0
        return Q[:, :kept], R[:kept, :kept]

    def _end(self, until: float) -> tuple[float, bool]:
        """End of the next block, and whether a section point is aimed at."""
        time, ahead = self.bundle.time, self._ahead()
        end = until if until - time < 1.001 * self.length else time + self.length
        if not 0.0 < ahead <= 1.001 * (end - time):
            return end, False
        if self.crank is not None and ahead > 0.05 * self.length:
            return time + AIM * ahead, True
        return until if abs(until - time - ahead) < NEAR * self.length else time + ahead, True

    def _ahead(self) -> float:
        """Time to the next section point, at the present speed."""
        if self.crank is None:
            return self.next - self.bundle.time
        speed = float(self.bundle.state[len(self.model.turning) + self.crank])
        return (self.next - self._angle) / speed if speed else math.inf

    def _passed(self, there: bool) -> bool:
        """Whether a section point is reached; the next one is aimed at then."""
        if self.crank is None:
            if there:
                self.next += self.model.period
            return there
        left = (self.next - self._angle) * self.model.forward
        if left > NEAR:
            return False
        self.next += self.model.forward * math.tau
        return True

    def _adapt(self, R: np.ndarray) -> None:
        """Fit the next block to the spread of growth in this one."""
        logs = np.log(np.diag(R))[: len(R) - (self.whole and self.lost == 0)]
        spread = float(np.ptp(logs)) if len(logs) else 0.0
        self.spread = max(self.spread, spread)
        wanted = self.length * min(2.0, SPREAD / max(spread, 1e-3))
        self.length = min(self.longest, max(wanted, SHORTEST * self.longest))
