"""The verb selftest: its truths are those of other tests, and a wrong one is said."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jointplay import cli
from jointplay.cli import selftest
from tests.analysis.exact_maps import TAU, Symmetric, Walls

JOURNAL, FOLD, CHAOS, MULTIPLIER, STICKING = range(5)


def said(capsys, code):
    assert cli.main(["selftest"]) == code
    return capsys.readouterr().out.splitlines()


def test_all_answers_of_this_installation_are_right(capsys):
    lines = said(capsys, 0)
    assert sum(line.startswith("  right: ") for line in lines) == len(selftest.KNOWN) == 5
    assert lines[-1] == "all 5 answers are right"


@pytest.mark.nightly
@pytest.mark.parametrize("place", range(5))
def test_a_truth_that_is_broken_is_named(place, capsys, monkeypatch):
    """As is an error in its place; what is far beyond the error of a stored value is wrong."""
    rows = list(selftest.KNOWN)
    rows[place] = replace(rows[place], value=rows[place].value * (1.2 if place == CHAOS else 1 + 1e-5))
    broken, failing = rows[place], replace(rows[place - 1], compute=lambda: 1 / 0)
    monkeypatch.setattr(selftest, "KNOWN", (broken, failing))
    lines = said(capsys, 1)
    assert lines[1] == broken.what
    assert lines[2].startswith("  wrong: ")
    assert broken.origin in lines[2]
    assert lines[3:5] == [failing.what, "  wrong: ZeroDivisionError: division by zero"]
    assert lines[5].startswith("2 of 2 answers are wrong")


def test_stored_truths_are_what_their_origins_give():
    rows = selftest.KNOWN
    truth = json.loads((Path(__file__).parents[1] / "reference" / "truth.json").read_text())["C"]
    assert rows[JOURNAL].value == truth["joints"]["B"][0][0]
    assert rows[FOLD].value == pytest.approx(Symmetric(28.0, 0.8).fold, rel=1e-14)
    swing, lost = 1.0, 2 * 0.15
    while abs(swing) > 0.15:
        swing = -math.copysign(abs(swing) - lost, swing)
    assert rows[STICKING].value == pytest.approx(swing, abs=1e-15)


def test_the_gears_settle_at_the_rate_of_their_exact_motion():
    """Differences of states two periods of the forcing apart shrink by the multiplier."""
    frequency, rate = 0.8, selftest.KNOWN[MULTIPLIER].value
    gears = Walls(1.0, 1.0, 0.0, W=frequency, cos=0.2 * frequency**2, mean=0.1, drag=0.1)
    every = 2 * TAU / frequency
    _, states = gears.run(0.5, 0.0, 60.5 * every, at=every * np.arange(30, 60))
    apart = np.linalg.norm(np.diff(states, axis=0), axis=1)
    assert np.log(apart[-1] / apart[-6]) / (5 * every) == pytest.approx(rate, abs=1e-6)
