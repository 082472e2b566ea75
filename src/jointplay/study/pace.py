"""How many strands make a task: as many as fill their time, however long one takes."""

from __future__ import annotations

from jointplay.study.worker import Done

FILL = 0.5  # s that a task is to last


class Pace:
    """Grows tasks from one strand on."""

    def __init__(self) -> None:
        self.done, self.seconds = 0, 0.0

    def learn(self, done: Done) -> None:
        """Note how long a task took."""
        self.done, self.seconds = self.done + done.strands, self.seconds + done.seconds

    def size(self, left: int, workers: int) -> int:
        """Strands of the next task; towards the end fewer, so that all workers end at once."""
        wanted = int(FILL * self.done / self.seconds) if self.seconds else 1
        return max(1, min(wanted, left // (4 * max(workers, 1))))
