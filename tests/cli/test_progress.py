"""Progress: a bar on a terminal, a few lines in a log, silence for what is short."""

import contextlib
import os
import re
import subprocess
import sys
import threading
from io import StringIO

import pytest

import jointplay as jp
from jointplay.display import terminal
from jointplay.solver.codegen import cache, place
from jointplay.solver.motion.progress import Stopped, reported, stop, stoppable, tick
from tests.support.program import jointplay


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
    assert lines[0] == "small: 10% done"
    assert lines[1] == "small: 20% done, about 48 s left"
    assert "\r" not in "".join(lines)


def test_a_short_run_is_silent_in_a_log(clock):
    assert report(clock, 1.0, StringIO()) == ""


def test_a_terminal_gets_a_bar(clock):
    left = []
    with terminal.Progress("small", stream := Terminal()) as follow:
        for step in range(1, 101):
            clock[0] = 0.6 * step
            follow(step / 100)
            left += [(step, follow.bar.postfix)]
    assert "\rsmall " in stream.getvalue()
    assert follow.bar.disable  # closed: it is drawn no more
    told = {step: float(re.match(r"about (.*) s left", words)[1]) for step, words in left if words}
    assert [*told] == [*range(11, 99)]  # and not the last 0.6 s
    assert all(abs(time - 60 * (1 - step / 100)) <= 1 for step, time in told.items())


def test_what_is_printed_meanwhile_stands_above_the_bar(clock):
    with terminal.Progress("small", stream := Terminal()) as follow:
        for step in range(1, 51):
            clock[0] = 0.6 * step
            follow.place("B, downward: 0.62 of present")
            follow(step / 100)
        assert follow.bar.postfix == "about 30 s left, B, downward: 0.62 of present"
        before = len(stream.getvalue())
        with follow.aside():
            cleared = stream.getvalue()[before:]
            stream.write("a part of the page\n")
    assert cleared.startswith("\r")
    assert not cleared.strip(), "the line is blank where the text begins"
    assert "\rsmall  50 %" in stream.getvalue().partition("a part of the page\n")[2]


def test_a_log_says_where_it_is(clock):
    with terminal.Progress("small", stream := StringIO()) as follow:
        for step in (0, 1, 2):
            clock[0] = 10.0 * step
            follow.place(f"value {step}")
            follow(step / 10)
    assert stream.getvalue().splitlines()[-1] == "small: 20% done, about 80 s left, value 2"


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal is made as on Unix")
def test_a_terminal_that_says_it_has_no_size_gets_a_bar():
    ours, theirs = os.openpty()
    code = "import time\nfrom jointplay.display.terminal import Progress\nwith Progress('small') as follow:\n"
    code += "    for step in range(3):\n        time.sleep(0.15)\n        follow(step / 3)\n"
    subprocess.run([sys.executable, "-c", code], stderr=theirs, check=True)
    assert b"\rsmall  67 % |" in os.read(ours, 10_000)
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("pace", [0.5, 1.0, 2.0])
def test_the_time_left_is_told_only_when_it_can_be_known(clock, pace):
    """A first part that is there at once, as of a journal, and a pace that changes, as of harder cells."""
    progress = terminal.Progress("small", StringIO())
    for fraction in (0.2, 0.21, 0.23):
        progress(fraction)
        assert progress._left(clock[0], fraction) == ""
    for step in range(1, 76):  # two thirds at 1 % a second, the last third at another pace
        clock[0] += 1.0 if step < 51 else pace
        progress(0.23 + 0.01 * step)
        told = re.match(r"about ([\d.]+) s left", progress._left(clock[0], 0.23 + 0.01 * step))
        assert bool(told) == (step >= 7)  # a tenth since the first report
        if told and step < 60:
            rest = (75 - max(step, 50)) * pace + max(50 - step, 0)
            assert rest / 2.05 <= float(told[1]) <= 2.05 * rest, step


def test_what_is_compiled_in_the_middle_does_not_count_for_the_time_left(clock):
    with terminal.Progress("small", said := StringIO()) as progress:
        for step in range(101):
            if step in (0, 5, 8):
                terminal.LOG.info("compiling")
                clock[0] += 60.0
            progress(0.01 * step)
            clock[0] += 1.0
    told = re.findall(r"(\d+)% done, about ([\d.]+) s left", said.getvalue())
    assert len(told) > 6
    assert all(float(left) == pytest.approx(100 - int(done), abs=2) for done, left in told)


def slow(clock, seconds, inner=None):
    @reported
    def analysis(*, progress=None):
        for step in range(1, 101):
            clock[0] += seconds / 100
            if inner:
                inner()
            if progress:
                progress(step / 100)

    return analysis


def test_a_call_that_lasts_has_a_bar_where_somebody_looks_on(clock, monkeypatch):
    monkeypatch.setattr(terminal.sys, "stderr", stream := Terminal())
    slow(clock, 2.9)()
    slow(clock, 60.0)(progress=False)
    slow(clock, 0.0, slow(clock, 10.0))(progress=lambda fraction: None)
    other = threading.Thread(target=slow(clock, 60.0))
    other.start()
    other.join()
    assert stream.getvalue() == ""
    slow(clock, 60.0, slow(clock, 10.0))()
    assert "\ranalysis " in stream.getvalue()
    assert stream.getvalue().count("analysis   0 %") <= 1
    monkeypatch.setattr(terminal.sys, "stderr", log := StringIO())
    slow(clock, 60.0)()
    assert log.getvalue() == ""


def test_a_run_that_was_cut_is_not_told_as_done():
    @reported
    def analysis(*, progress=None):
        progress(0.3)
        with contextlib.suppress(Stopped):
            tick()
            progress(0.6)
        return "what is there"

    for stopped, last in ((True, 0.3), (False, 1.0)):
        told = []
        with stoppable():
            assert not stopped or stop()
            assert analysis(progress=told.append) == "what is there"
        assert told[-1] == last


@pytest.fixture
def nothing_compiled(monkeypatch, tmp_path):
    """A cache of generated modules in which nothing is."""
    place.compiling.cache_clear()
    monkeypatch.setattr(cache.place, "read", lambda name: None)
    monkeypatch.setattr(cache.place, "write", lambda name, data: None)
    monkeypatch.setattr(cache.generated, "load", lambda name, method: name)
    monkeypatch.setattr(cache, "_text", lambda writer, structure: "x = 1")
    cache._module.cache_clear()
    yield
    cache._module.cache_clear()


@pytest.mark.parametrize("stream", [StringIO, Terminal])
def test_it_says_once_that_something_is_compiled(stream, nothing_compiled, caplog):
    said = stream()
    with caplog.at_level("INFO", "jointplay"), terminal.Progress("small", said) as progress:
        progress(0.0)
        for key in ("one structure", "another", "one structure"):
            cache._module("module", key)
    assert said.getvalue().count("small: compiling, once: later runs take seconds\n") == 1
    assert len(caplog.records) == 2, "each structure is logged"
    assert not terminal.LOG.handlers


def test_progress_is_asked_for_by_true(clock, capsys):
    system = jp.catalog.impact_pair(3.6, 0.8)
    shown = [jp.simulate(system, turns=5, progress=progress) for progress in (True, False, None)]
    assert shown[0].drop_vars("wall_time").identical(shown[1].drop_vars("wall_time"))
    over = {"gap": [3.5, 3.6]}
    jp.bifurcation(system, over=over, turns=5, transient=5, n_jobs=1, progress=True)
    with pytest.raises(jp.InputError, match="true, false, or a function"):
        jp.simulate(system, turns=5, progress=3)


@pytest.mark.nightly
def test_a_first_run_in_a_pipe_says_that_it_compiles(tmp_path):
    words = ["run", "studies/quickstart.toml", "--out", tmp_path, "--no-figure"]
    for first in (True, False):
        done = jointplay(*words, env=os.environ | {"JOINTPLAY_CACHE": str(tmp_path / "cache")})
        assert done.returncode == 0
        assert ("quickstart: compiling, once" in done.stderr) is first
