"""The terminal: progress, and text that cannot steer it, as titles and names come from files of others."""

import re
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any, Self, TextIO

# control characters but tab and newline, marks that turn the direction of text, halves of characters
STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
STEP = 0.1  # of the run, between two plain lines
PATIENCE = 2.0  # s; a run shorter than this stays silent in a log


def harmless(text: str) -> str:
    """Return a text with every character that steers a terminal written out, such as ``\\x1b``."""
    return STEERING.sub(lambda match: ascii(match[0])[1:-1], text)


def one_line(text: str) -> str:
    """Return a text without line breaks, so that it cannot pass for further lines."""
    return " ".join(text.split())


class Harmless:
    """A text stream that writes to `inner` with steering characters written out; otherwise as `inner`."""

    def __init__(self, inner: TextIO) -> None:
        self.inner = inner

    def write(self, text: str) -> int:
        """Write a text."""
        return self.inner.write(harmless(text))

    def writelines(self, lines: Iterable[str]) -> None:
        """Write several texts."""
        self.inner.writelines(map(harmless, lines))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)


@contextmanager
def harmless_output() -> Iterator[None]:
    """Replace control characters in what the block or the function prints."""
    streams = ((redirect_stdout, sys.stdout), (redirect_stderr, sys.stderr))
    with ExitStack() as redirected:
        for redirect, stream in streams:
            if stream is not None:  # closed by the caller
                redirected.enter_context(redirect(Harmless(stream)))  # type: ignore[type-var]
        yield


class Progress:
    """How far a run is: a bar on a terminal, a few lines in a log. A callable, used in a ``with`` block.

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
        """Report the fraction done, 0 to 1."""
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
