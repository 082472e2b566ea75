"""The methods and tolerances of a comparison, and their validation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator

from jointplay.analysis.keywords import RTOL, Rtol, several
from jointplay.display.errors import Problem, refuse, unknown
from jointplay_lab.precision.contenders import Cvode, Dop853, Lsoda, Peer, Radau
from jointplay_lab.precision.taylor import Heyoka

PEERS: dict[str, type[Peer]] = {peer.name: peer for peer in (Heyoka, Cvode, Lsoda, Radau, Dop853)}


@dataclass(frozen=True)
class Plan:
    """The tolerances and solvers that `work_precision` compares."""

    tolerances: tuple[float, ...]
    peers: tuple[str, ...]

    @property
    def installed(self) -> tuple[str, ...]:
        """The peers that are installed."""
        return tuple(name for name in self.peers if find_spec(PEERS[name].package))

    @property
    def absent(self) -> tuple[str, ...]:
        """The peers that are not installed."""
        return tuple(name for name in self.peers if name not in self.installed)


def _falling(tolerances: tuple[float, ...]) -> tuple[float, ...]:
    if not tolerances or any(a <= b for a, b in pairwise(tolerances)):
        raise refuse(tolerances, f"falling relative tolerances from {RTOL[1]:g} to {RTOL[0]:g} are accepted")
    return tolerances


Tolerances = Annotated[
    several(Rtol, f"a list of falling relative tolerances from {RTOL[1]:g} to {RTOL[0]:g}"),
    AfterValidator(_falling),
]
Peers = several(str, f"a list of peers: {', '.join(PEERS)}")


def unknown_peers(peers: tuple[str, ...]) -> Iterator[Problem]:
    """Yield the problems of peers: unknown, or named twice."""
    for i, name in enumerate(peers):
        if name not in PEERS:
            yield unknown(f"peers[{i}]", name, name, PEERS, "peer")
        elif name in peers[:i]:
            yield Problem(f"peers[{i}]", name, "each peer is accepted once")
