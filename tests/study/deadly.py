"""Cells that end their worker, for workers to import."""

import os
import signal
from dataclasses import dataclass
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
        with Path(self.log).open("a") as file:
            file.write(f"{self.key}\n")
        if Path(self.log).read_text().split().count(self.key) <= self.times:
            os.kill(os.getpid(), signal.SIGKILL)
        notes.put(self.key, {"status": 0, "worker": os.getpid()})

    def only(self, _):
        return self

    def left(self, done, _):
        return None if self.key in done else self
