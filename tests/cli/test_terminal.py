"""What commands print cannot steer the terminal, whatever a study, a result or a journal is called."""

import sys

import pytest

from jointplay import cli
from jointplay.display.terminal import STEERING, Progress, harmless
from jointplay.study.execute import journal_of
from jointplay.study.results.store import open_result, write_result
from tests.support.sweep_samples import CELLS, loaded, ran

EVIL = "red \x1b[31m title \x1b]0;owned\x07\x9b2J\r\x08\u202egnp.\u2028end\nresult  /etc/passwd"
TITLE = "".join(f"\\u{ord(letter):04x}" for letter in EVIL)  # as TOML writes it


@pytest.fixture
def evil(tmp_path):
    """A study whose title steers the terminal, and its result, whose names and attributes do."""
    path = tmp_path / "cells.toml"
    path.write_text(CELLS.replace("turns = 5", "turns = 3").replace("\n[mech", f'title = "{TITLE}"\n\n[mech'))
    ran(loaded(path.read_text()), tmp_path / "out")
    found = open_result(tmp_path / "out" / "cells.nc")
    told = {"kind": EVIL.replace("/", ""), "swept": EVIL}
    write_result(found.rename(n_steps="\u202en").assign_attrs(told), tmp_path / "out" / "evil.nc")
    (journal_of(tmp_path / "out", "cells").folder / "a\x1b[2Jb").touch()
    return path


def shown(capsys, *words):
    """What a command prints; nothing in it steers."""
    cli.main([str(word) for word in words])
    said = "".join(capsys.readouterr())
    assert said
    assert not STEERING.search(said)
    return said


def test_no_command_passes_on_what_steers_a_terminal(evil, capsys):
    out = evil.parent / "out"
    for verb in ("check", "plan", "status", "merge", "run"):
        said = shown(capsys, verb, evil, *(() if verb == "check" else ("--out", out)))
        assert "\n" + "result  /etc/passwd" not in said
        assert (r"red \x1b[31m title \x1b]0;owned\x07\x9b2J" in said) == (verb in ("check", "run"))
        assert (r"a\x1b[2Jb" in said) == (verb != "check")
    assert r"\x1b[31m title" in shown(capsys, "list", evil.parent, "--out", out)


def test_no_error_passes_on_what_steers_a_terminal(evil, capsys):
    out, bad = evil.parent / "out", evil.parent / "b\x1b[2Jad.toml"
    bad.write_text(evil.read_text().replace("turns = 3", f'"{TITLE}" = 1\nturns = "{TITLE}"'))
    assert r"\x1b" in shown(capsys, "check", bad)
    assert r"\x1b" in shown(capsys, "check", evil, "--set", f"mechanism.{EVIL.split()[1]}=1")
    assert r"\x1b" in shown(capsys, "figure", out / "evil.nc")
    assert r"\x1b" in shown(capsys, "export", out / "evil.nc", "--out", out / "a.csv", "--over", "\x1b[2J")
    assert r"\x1b" in shown(capsys, "check", "no\x1b[2J.toml")


def test_what_is_said_stays_as_it_is_where_it_steers_nothing():
    plain = "clearance 0.29 mm, ±3 µm\tχ²\nДжеффкотт 振動 🙂"
    assert harmless(plain) == plain
    assert harmless("a\udcffb") == r"a\udcffb"


def test_a_bar_is_drawn_where_it_can_be(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(cli, "build_parser", lambda: _Words(capsys))
    assert cli.main([]) == 0
    assert "\r" in capsys.readouterr().err


class _Words:
    """A verb that shows how far it is."""

    def __init__(self, _):
        pass

    def parse_args(self, _):
        return self

    def verb(self, _):
        with Progress("name") as progress:
            progress(0.5)
        return 0
