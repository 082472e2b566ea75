"""What a comparison of methods is asked for, and whether that makes sense."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from jointplay.analysis.checks import refused, together, whole
from jointplay.analysis.request import RTOL, check
from jointplay.errors import Problem, unknown
from jointplay.mechanism.assemble import assemble

PEERS = {
    "heyoka": "heyoka",
    "CVODE": "sksundae",
    "LSODA": "scipy",
    "Radau": "scipy",
    "DOP853": "scipy",
}  # and the package that each comes from


@dataclass(frozen=True)
class Plan:
    """The keywords of `work_precision` that say what is compared."""

    tolerances: tuple[float, ...]
    peers: tuple[str, ...]
    rounds: int
    budget: float

    @classmethod
    def of(cls, keywords: Mapping[str, Any]) -> Plan:
        """Take what a comparison is asked for; one tolerance or peer may stand for a list."""
        return cls(
            several(keywords["tolerances"]),
            several(keywords["peers"]),
            keywords["rounds"],
            keywords["budget"],
        )

    @property
    def installed(self) -> tuple[str, ...]:
        """The peers that are there."""
        return tuple(name for name in self.peers if find_spec(PEERS[name]))

    @property
    def absent(self) -> tuple[str, ...]:
        """The peers that are not."""
        return tuple(name for name in self.peers if name not in self.installed)

    def problems(self) -> Iterator[Problem]:
        """Say what makes no sense by itself."""
        falling = all(a > b for a, b in zip(self.tolerances, self.tolerances[1:], strict=False))
        if not (self.tolerances and all(map(_tolerance, self.tolerances)) and falling):
            expected = f"falling relative tolerances from {RTOL[1]:g} to {RTOL[0]:g} are accepted"
            yield Problem("tolerances", self.tolerances, expected)
        for i, name in enumerate(self.peers):
            if name not in PEERS:
                yield unknown(f"peers[{i}]", name, name, PEERS, "peer")
            elif name in self.peers[:i]:
                yield Problem(f"peers[{i}]", name, "each peer is accepted once")
        yield from whole("rounds", self.rounds, 0)
        if not (_number(self.budget) and 0 < self.budget < float("inf")):
            yield Problem("budget", self.budget, "a finite number greater than 0 is accepted, s")


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _tolerance(value: Any) -> bool:
    return _number(value) and RTOL[0] <= value <= RTOL[1]


def several(given: Any) -> tuple[Any, ...]:
    """One value, or a sequence of them, as a tuple."""
    alone = isinstance(given, str) or not isinstance(given, Sequence)
    return (given,) if alone else tuple(given)


def wrong(
    mechanism: Any, *, turns: Any, rtol: Any, initial: Any = None, max_steps: Any = None, **plan: Any
) -> None:
    """Refuse keywords of `work_precision` that make no sense, all at once, before anything is followed.

    Raises
    ------
    InputError
        Listing every problem.
    """
    together(
        lambda: check(mechanism, turns, None, 0, rtol, max_steps),
        lambda: refused(Plan.of(plan).problems()),
        lambda: assemble(mechanism, initial),
    )
