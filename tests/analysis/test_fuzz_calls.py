"""Drawn calls of public functions: an answer or an `InputError`. Three thousand of them: fuzz_calls.py."""

import subprocess
import sys
from pathlib import Path

import pytest

import jointplay as jp
from tests.analysis.fuzz_calls import CALLS, drawn, fault, found
from tests.analysis.fuzz_values import LOOSE

SLOW = (
    "basins",
    "assess",
    "stress",
    "readings",
    "claims",
    "waveform",
    "scheme_comparison",
    "work_precision",
    "sensitivity",
)


def test_every_public_name_is_called():
    assert set(jp.__all__) - {"__version__", "InputError", "ModelWarning", "catalog"} <= set(CALLS)
    assert {f"catalog.{name}" for name in jp.catalog.NAMES} <= set(CALLS)


@pytest.mark.parametrize("name", [name for name in CALLS if name.startswith("catalog.")])
def test_every_entry_of_the_catalog_is_made(name):
    assert fault(name, found(name)[0], [], CALLS[name]) == (None, "answered")


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
    command = [sys.executable, "-m", "tests.analysis.fuzz_calls", "3000", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert done.returncode == 0, done.stdout
