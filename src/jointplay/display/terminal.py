"""The terminal: progress, and text that cannot steer it, as titles and names come from files of others."""

import logging
import multiprocessing
import re
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext, redirect_stderr, redirect_stdout
from contextvars import ContextVar
from shutil import get_terminal_size
from typing import Any, Self, TextIO, TypeVar

from jointplay.display.number_text import duration

# control characters but tab and newline, marks that turn the direction of text, halves of characters
STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
LOG = logging.getLogger("jointplay")
STEP = 0.1  # of the run: between two plain lines, and until the time that is left is known
PATIENCE = 2.0  # s; a run shorter than this stays silent in a log
LEAST = 1.0  # s that are worth saying that they are left
WAIT = 3.0  # s; a call of which nobody asked for progress is not shown before
T = TypeVar("T")
_telling: ContextVar[bool] = ContextVar("telling", default=False)  # whether a call around this one tells it


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


@contextmanager
def held(variable: ContextVar[T], value: T) -> Iterator[None]:
    """A variable of the context with this value, inside the block."""
    before = variable.set(value)
    try:
        yield
    finally:
        variable.reset(before)


@contextmanager
def requested_progress(progress: Any, name: str) -> Iterator[Any]:
    """The progress that a caller wants, as a ``with`` block: True shows it under a name, False does not.

    Left out (None), it is shown where somebody looks on and the block lasts; within the block of another
    call, whose progress that call tells, it is not.
    """
    left_out = progress is None and not _telling.get() and _looked_on()
    shown = Progress(name, patience=WAIT if left_out else 0.0) if left_out or progress is True else None
    with held(_telling, True), shown or nullcontext(None if isinstance(progress, bool) else progress) as hook:
        yield hook


def _looked_on() -> bool:
    """Whether a terminal or a notebook shows the output of this thread, which is no worker's."""
    main = threading.current_thread() is threading.main_thread()
    return main and multiprocessing.current_process().name == "MainProcess" and _live(sys.stderr)


def _live(stream: TextIO | None) -> bool:
    """Whether a bar can be drawn on a stream: a terminal, or that of a notebook."""
    kernel = getattr(sys.modules.get("ipykernel.zmqshell"), "ZMQInteractiveShell", None)
    notebook = kernel is not None and kernel.initialized() and stream is sys.stderr
    return stream is not None and (stream.isatty() or notebook)


class Progress(logging.Handler):
    """Progress of a run: a bar on a terminal, a few lines in a log. A callable, used in a ``with`` block.

    What the package logs meanwhile, as that something is compiled, is shown too, the same line once.

    Parameters
    ----------
    name : str
        What runs.
    stream : text stream, optional
        Where to report; standard error by default.
    patience : float
        Seconds after which a bar appears.
    """

    def __init__(self, name: str, stream: TextIO | None = None, patience: float = 0.0):
        super().__init__(logging.INFO)
        self.name = name
        self.stream = sys.stderr if stream is None else stream
        self.bar: Any = None
        self.live = False
        self.patience, self.entered = patience, time.monotonic()
        self.said, self.last, self.lines = 0.0, time.monotonic(), set[str]()
        self.began: tuple[float, float] | None = None  # when the first fraction came, and which
        self.at = ""

    def __enter__(self) -> Self:
        self.live, self.entered = _live(self.stream), time.monotonic()
        if not self.patience:
            self._draw()
        self.level_before = LOG.level
        LOG.setLevel(min(LOG.getEffectiveLevel(), logging.INFO))
        LOG.addHandler(self)
        return self

    def _draw(self) -> None:
        """Begin the bar where one can be drawn, once it is time."""
        if self.live and self.bar is None and time.monotonic() - self.entered >= self.patience:
            from tqdm import tqdm

            stream = getattr(self.stream, "inner", self.stream)  # a bar steers the terminal
            shape = "{desc} {percentage:3.0f} % |{bar}| {elapsed}{postfix}"
            wide, high = get_terminal_size()  # also of a terminal that says 0
            size = {"ncols": wide - 1, "nrows": high}
            self.bar = tqdm(total=1.0, desc=self.name, file=stream, bar_format=shape, leave=False, **size)
            self.bar.start_t -= time.monotonic() - self.entered

    def emit(self, record: logging.LogRecord) -> None:
        """Show a logged message."""
        line = record.getMessage()
        self.began = None  # what is compiled in the middle of a run tells nothing of the rest either
        if line in self.lines or self.stream is None:
            return
        self.lines.add(line)
        if self.bar is not None:
            self.bar.write(f"{self.name}: {line}", file=self.bar.fp)
        else:
            print(f"{self.name}: {line}", file=self.stream, flush=True)

    def place(self, text: str) -> None:
        """Say from now on where the run is."""
        self.at = text

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Clear the bar while the block prints, and draw it below that."""
        with self.bar.external_write_mode(self.bar.fp) if self.bar is not None else nullcontext():
            yield

    def __exit__(self, *_: object) -> None:
        LOG.removeHandler(self)
        LOG.setLevel(self.level_before)
        if self.bar is not None:
            self.bar.close()

    def __call__(self, fraction: float) -> None:
        """Report the fraction done, 0 to 1."""
        now = time.monotonic()
        if self.began is None:  # what went before was compiling, and tells nothing of the rest
            self.began = now, fraction
        self._draw()
        if self.bar is not None:
            words = ", ".join(filter(None, (self._left(now, fraction), self.at)))
            self.bar.set_postfix_str(words, refresh=False)
            self.bar.update(fraction - self.bar.n)
        elif (
            self.stream is not None
            and not self.live
            and fraction > self.began[1]
            and fraction - self.said >= STEP
            and now - self.last >= PATIENCE
        ):
            self.said, self.last = fraction, now
            words = ", ".join(filter(None, (f"{fraction:.0%} done", self._left(now, fraction), self.at)))
            print(f"{self.name}: {words}", file=self.stream, flush=True)

    def _left(self, now: float, fraction: float) -> str:
        """How long it still takes, at the mean pace so far; empty until enough is done to say so."""
        start, first = self.began or (now, fraction)
        if fraction - first < STEP or now - start < PATIENCE:
            return ""
        left = (now - start) * (1 - fraction) / (fraction - first)
        return f"about {duration(left)} left" if left >= LEAST else ""
