"""The assembled model: the structure of the equations, their numbers, initial state, scales and names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jointplay.solver.equations.structure import Linkage, Oscillator

SPEED_FLOOR = 0.01  # of the nominal speed: below it, errors of a speed count as absolute
DEEP = 10  # clearances: a journal as far out is hardly meant to be there
DEFLECTION = 1e-4  # of the longest link: the deflection relative to which errors of deflections count


@dataclass(frozen=True)
class Model:
    """A mechanism or test system, assembled.

    Parameters
    ----------
    structure : Linkage or Oscillator
        Which equations.
    numbers : ndarray
        Values of their parameters, in order.
    state : ndarray
        Positions, then speeds, at time 0.
    absolute, relative : ndarray
        Scales of the tolerated error of each state: rtol * (absolute + relative * abs(state)).
    turning : ndarray
        1 where a position is an angle.
    fold : ndarray
        1 where whole turns of a position change nothing.
    period : float
        Nominal period of the drive or forcing, s; a time scale where there is none.
    h_max : float
        Longest step, s.
    creep : float
        Scale of the tolerated error of a sliding speed, m/s.
    reach : float
        Length whose rounding is that of a gap, m.
    links, joints, clearances, pins, guides, states, resets : tuple
        Names of links, of joints with clearance (or contacts), their clearances (m), of ideal joints, of
        prismatic ones; of the states and of the resets of a test system.
    bending : tuple of str
        The links, where at least one bends.
    memories, guesses : int
        How many of the last speeds are what laws of contact and groups of loops remember; the groups alone.
    modes : tuple of str
        States that are 1 or 0 (mechanism.own.own), of which nothing near the motion has others.
    crank, crank_angle, crank_speed
        Name of the driven link, its angle and speed at time 0.
    forward : int
        Sense in which it turns, 1 or -1: at time 0 or, where it is at rest then, as it is driven.
    """

    structure: Linkage | Oscillator
    numbers: np.ndarray
    state: np.ndarray
    absolute: np.ndarray
    relative: np.ndarray
    turning: np.ndarray
    fold: np.ndarray
    period: float
    h_max: float
    creep: float = 0.0
    reach: float = 0.0
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    clearances: tuple[float, ...] = ()
    pins: tuple[str, ...] = ()
    guides: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    crank: str | None = None
    crank_angle: float = 0.0
    crank_speed: float = 0.0
    forward: int = 1
    resets: tuple[str, ...] = ()
    bending: tuple[str, ...] = ()
    memories: int = 0
    modes: tuple[str, ...] = ()
    guesses: int = 0

    @property
    def followers(self) -> int:
        """How many of the last states no tangent has a part in: memories of laws, and modes."""
        return self.memories + len(self.modes)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs of a test system, which are recorded beside its own states."""
        return self.states[len(self.state) :]

    @property
    def touching(self) -> tuple[str, ...]:
        """Names of all that have a mode: contacts, then the resets of a test system."""
        return (*self.joints, *self.resets)

    @property
    def gaps(self) -> list[int]:
        """Which of `touching` have a gap that closes; the others are friction, switches, jumps of states."""
        own = () if self.links else (*self.structure.contacts, *self.structure.impacts)
        named = self.touching if self.links else {each.name for each in own}
        return [i for i, name in enumerate(self.touching) if name in named]

    @property
    def walls(self) -> tuple[str, ...]:
        """Names of the walls met in impacts: rigid walls, and joints whose law is one of impacts."""
        return tuple(joint.name for joint in self.structure.rigid_joints) if self.links else self.resets
