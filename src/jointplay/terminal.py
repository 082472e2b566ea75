"""Output without control characters: titles and names from files of others cannot steer the terminal."""

import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any, TextIO

# control characters but tab and newline, marks that turn the direction of text, halves of characters
STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def harmless(text: str) -> str:
    """Give a text with every character that steers a terminal written out, such as ``\\x1b``."""
    return STEERING.sub(lambda match: ascii(match[0])[1:-1], text)


def one_line(text: str) -> str:
    """Give a text without line breaks, so that it cannot pass for further lines."""
    return " ".join(text.split())


class Harmless:
    """Text stream that writes to `inner` without control characters, and else behaves as it."""

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
