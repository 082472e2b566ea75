"""Progress: a bar on a terminal, a few lines in a log, silence for what is short."""

from io import StringIO

import pytest

from jointplay import terminal


class Terminal(StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(terminal.time, "monotonic", lambda: now[0])
    return now


def report(clock, seconds, stream):
    with terminal.Progress("small", stream) as follow:
        for step in range(1, 101):
            clock[0] = seconds * step / 100
            follow(step / 100)
    return stream.getvalue()


def test_a_log_gets_a_few_plain_lines(clock):
    lines = report(clock, 60.0, StringIO()).splitlines()
    assert 5 <= len(lines) <= 11
    assert lines[0] == "small: 10% done, about 54 s left"
    assert "\r" not in "".join(lines)


def test_a_short_run_is_silent_in_a_log(clock):
    assert report(clock, 1.0, StringIO()) == ""


def test_a_terminal_gets_a_bar(clock):
    said = report(clock, 60.0, Terminal())
    assert "\rsmall " in said
    assert "left" not in said
