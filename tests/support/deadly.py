"""Cells that end their worker, for workers to import."""

import os
import signal
from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class Deadly:
    """A cell that kills its worker so many times; each run leaves a line in a log."""

    key: str
    times: int
    log: str

    @property
    def keys(self):
        return (self.key,)

    def run(self, notes):
        notes.begin(self.key)
        _die(self.key, self.times, self.log)
        notes.put(self.key, {"status": 0, "worker": os.getpid()})

    def only(self, _):
        return self

    def left(self, done, _):
        return None if self.key in done else self


@dataclass(frozen=True)
class DeadlyChain:
    """A chain that counts on from where it is left, past cells that kill their worker so many times."""

    keys: tuple[str, ...]
    times: dict[str, int]
    log: str
    count: int = 0

    def run(self, notes):
        count = self.count
        for key in self.keys:
            notes.begin(key)
            _die(key, self.times.get(key, 0), self.log)
            notes.put(key, {"status": 0, "count": (count := count + 1)})

    def only(self, key):
        return replace(self, keys=self.keys[: self.keys.index(key) + 1])

    def left(self, done, answers):
        missing = [key for key in self.keys if key not in done]
        if not missing:
            return None
        keys = self.keys[self.keys.index(missing[0]) :]
        counts = [answers[key]["count"] for key in self.keys if "count" in answers.get(key, ())]
        return replace(self, keys=keys, count=max(counts, default=self.count))


def _die(key, times, log):
    with Path(log).open("a") as file:
        file.write(f"{key}\n")
    if Path(log).read_text().split().count(key) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
