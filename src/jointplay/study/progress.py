"""How far a run is: a bar on a terminal, a few plain lines in a log."""

import sys
import time
from typing import Any, Self, TextIO

STEP = 0.1  # of the run, between two plain lines
PATIENCE = 2.0  # s; a run shorter than this stays silent in a log


class Progress:
    """A callable that takes the fraction done (0 to 1), to be used in a ``with`` block.

    Parameters
    ----------
    name : str
        What runs.
    stream : text stream, optional
        Where to report; standard error by default.
    """

    def __init__(self, name: str, stream: TextIO | None = None):
        self.name = name
        self.stream = sys.stderr if stream is None else stream
        self.bar: Any = None
        self.said = 0.0
        self.start = self.last = time.monotonic()

    def __enter__(self) -> Self:
        if self.stream is not None and self.stream.isatty():
            from tqdm import tqdm

            stream = getattr(self.stream, "inner", self.stream)  # a bar steers the terminal

            shape = "{desc} {percentage:3.0f} % |{bar}| {elapsed} < {remaining}"
            self.bar = tqdm(total=1.0, desc=self.name, file=stream, bar_format=shape, leave=False)
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()

    def __call__(self, fraction: float) -> None:
        """Report that `fraction` of the run is done."""
        if self.bar is not None:
            self.bar.update(fraction - self.bar.n)
        elif (
            self.stream is not None
            and fraction - self.said >= STEP
            and time.monotonic() - self.last >= PATIENCE
        ):
            self.said, self.last = fraction, time.monotonic()
            left = (self.last - self.start) * (1 - fraction) / fraction
            print(f"{self.name}: {fraction:.0%} done, about {left:.0f} s left", file=self.stream, flush=True)
