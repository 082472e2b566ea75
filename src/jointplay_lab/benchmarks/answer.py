"""Answer of a benchmark: numbers as published, the same computed, and the run."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from jointplay.solver.motion.trajectory import Records


class Answer(NamedTuple):
    """A benchmark that was run.

    Parameters
    ----------
    published : mapping of str to (str, float)
        Units and published value of each quantity.
    computed : sequence of float
        Computed values, in that order.
    records : Records
        The run.
    """

    published: Mapping[str, tuple[str, float]]
    computed: Sequence[float]
    records: Records
