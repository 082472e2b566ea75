"""The terminal: progress, and text that cannot steer it, as titles and names come from files of others."""

import logging
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import (
    AbstractContextManager,
    ExitStack,
    contextmanager,
    nullcontext,
    redirect_stderr,
    redirect_stdout,
)
from typing import Any, Self, TextIO

# control characters but tab and newline, marks that turn the direction of text, halves of characters
STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
LOG = logging.getLogger("jointplay")
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
    """Replace control characters in the output of the block or the function."""
    streams = ((redirect_stdout, sys.stdout), (redirect_stderr, sys.stderr))
    with ExitStack() as redirected:
        for redirect, stream in streams:
            if stream is not None:  # closed by the caller
                redirected.enter_context(redirect(Harmless(stream)))  # type: ignore[type-var]
        yield


def requested_progress(
    progress: bool | Callable[[float], None] | None, name: str
) -> AbstractContextManager[Callable[[float], None] | None]:
    """The progress that a caller wants, as a ``with`` block: True shows it under a name; None: none."""
    return Progress(name) if progress is True else nullcontext(progress or None)


class Progress(logging.Handler):
    """Progress of a run: a bar on a terminal, a few lines in a log. A callable, used in a ``with`` block.

    What the package logs meanwhile, as that something is compiled, is shown too, the same line once.

    Parameters
    ----------
    name : str
        What runs.
    stream : text stream, optional
        Where to report; standard error by default.
    """

    def __init__(self, name: str, stream: TextIO | None = None):
        super().__init__(logging.INFO)
        self.name = name
        self.stream = sys.stderr if stream is None else stream
        self.bar: Any = None
        self.said, self.last, self.lines = 0.0, time.monotonic(), set[str]()
        self.began: tuple[float, float] | None = None  # when the first fraction came, and which

    def __enter__(self) -> Self:
        if self.stream is not None and self.stream.isatty():
            from tqdm import tqdm

            stream = getattr(self.stream, "inner", self.stream)  # a bar steers the terminal
            shape = "{desc} {percentage:3.0f} % |{bar}| {elapsed} < {remaining}"
            self.bar = tqdm(total=1.0, desc=self.name, file=stream, bar_format=shape, leave=False)
        self.level_before = LOG.level
        LOG.setLevel(min(LOG.getEffectiveLevel(), logging.INFO))
        LOG.addHandler(self)
        return self

    def emit(self, record: logging.LogRecord) -> None:
        """Show a logged message."""
        line = record.getMessage()
        if line in self.lines or self.stream is None:
            return
        self.lines.add(line)
        if self.bar is not None:
            self.bar.write(f"{self.name}: {line}", file=self.bar.fp)
        else:
            print(f"{self.name}: {line}", file=self.stream, flush=True)

    def __exit__(self, *_: object) -> None:
        LOG.removeHandler(self)
        LOG.setLevel(self.level_before)
        if self.bar is not None:
            self.bar.close()

    def __call__(self, fraction: float) -> None:
        """Report the fraction done, 0 to 1."""
        if self.began is None:  # what went before was compiling, and tells nothing of the rest
            self.began = time.monotonic(), fraction
        if self.bar is not None:
            self.bar.update(fraction - self.bar.n)
        elif (
            self.stream is not None
            and fraction > self.began[1]
            and fraction - self.said >= STEP
            and time.monotonic() - self.last >= PATIENCE
        ):
            self.said, self.last = fraction, time.monotonic()
            start, first = self.began
            left = (self.last - start) * (1 - fraction) / (fraction - first)
            print(f"{self.name}: {fraction:.0%} done, about {left:.0f} s left", file=self.stream, flush=True)
