"""Drawn calls: an answer or an `InputError`. Three thousand of them: `python -m tests.fuzz calls`."""

import random
import subprocess
import sys
from pathlib import Path

import pytest

import jointplay as jp
from tests.fuzz.calls import CALLS, LOOSE, NO_CALLS, drawn, fault, found
from tests.fuzz.loop import within
from tests.fuzz.values import accepted, schemas

SLOW = ("basins", "assess", "stress", "readings", "claims", "waveform", "scheme_comparison")
SLOW += ("work_precision", "sensitivity", "report", "tipping")


def test_every_public_name_is_called():
    assert set(jp.__all__) - NO_CALLS <= set(CALLS)
    assert {f"catalog.{name}" for name in jp.catalog.NAMES} <= set(CALLS)


@pytest.mark.parametrize("name", [name for name in CALLS if name.startswith("catalog.")])
def test_every_entry_of_the_catalog_is_made(name):
    assert fault(name, found(name)[0], [], CALLS[name]) == (None, "answered")


@pytest.mark.long
def test_a_hundred_drawn_calls():
    """Of those that compile nothing of their own."""
    numbers = (number for number in range(1000) if drawn(number, 3)[0] not in SLOW)
    calls = [call for _, number in zip(range(100), numbers, strict=False) if _plain(call := drawn(number, 3))]
    assert len(calls) > 80
    assert [wrong for wrong, _ in (fault(*call) for call in calls) if wrong] == []


def _plain(call):
    name, _, _, given = call
    moving = given.get("mechanism")
    own = isinstance(moving, jp.Mechanism) and moving != LOOSE
    return name[0].isupper() or not own


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [0, 3])
def test_three_thousand_drawn_calls(seed):
    command = [sys.executable, "-m", "tests.fuzz", "calls", "3000", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert done.returncode == 0, done.stdout


def test_a_function_that_hangs_or_raises_is_told():
    """What both doors count on."""

    def hangs():
        while True:
            pass

    assert "Hang" in within(0.05, hangs)[1]
    assert "ZeroDivisionError" in within(1.0, lambda: 1 / 0)[1]
    assert within(1.0, lambda: 3) == (3, None)


def test_what_a_schema_accepts_is_drawn_from_it():
    """A count small, or beyond its bounds; a word of those that are accepted."""
    dice = random.Random(1)
    count = {"type": "integer", "minimum": 2, "maximum": 10**9}
    drawn = {accepted(count, dice) for _ in range(200)}
    assert drawn == {1, 2, 3, 4, 5, 2 * 10**9 + 1}
    assert {accepted({"enum": ["a", "b"]}, dice) for _ in range(50)} == {"a", "b"}
    beams = [jp.Beam(**{key: accepted(schemas(jp.Beam)[key], dice)}) for key in ("shapes", "axial") * 9]
    assert {(beam.shapes, beam.axial) for beam in beams} >= {("sine", False), ("hermite", True)}
