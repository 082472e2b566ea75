"""The journal: finished cells survive, damaged ones are seen, two runs do not write at once."""

import json
import os
import signal
import sys
import time
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from jointplay.display.errors import InputError
from jointplay.jobs import journal as journals
from jointplay.jobs import origin
from jointplay.jobs.files import Busy
from jointplay.jobs.job import CRASHED, key_of
from jointplay.jobs.journal import MAGIC, Journal, write_part
from jointplay.jobs.worker import Notes
from jointplay.kinds import KINDS
from jointplay.solver import extensions
from jointplay.solver.extensions import packages
from jointplay.solver.motion.progress import stands
from tests.support import windows
from tests.support.sweep_samples import die, forked


def entries(*keys, status=0):
    return {key: {"status": status, "values": np.arange(3.0) + len(key)} for key in keys}


@pytest.fixture
def journal(tmp_path):
    made = Journal(tmp_path / "a.journal")
    with made.held():
        made.write(entries("a", "bb"))
        made.write(entries("ccc", status=CRASHED))
    return made


def test_what_is_written_is_there_with_its_status(journal):
    assert journal.index() == {"a": 0, "bb": 0, "ccc": CRASHED}
    assert journal.count() == 3
    found = journal.load(["bb", "ccc", "d"])
    assert found.keys() == {"bb", "ccc"}
    assert np.array_equal(found["bb"]["values"], [2.0, 3.0, 4.0])


def test_workers_say_how_far_their_cells_are_and_where(journal):
    with journal.held(), Notes(journal.folder, marks=journal.folder) as notes:
        assert list(journal.places()) == []
        notes.begin("a" * 32)
        assert list(journal.places()) == [(0.0, "")]
        stands(0.25, "B, downward: " + 80 * "0")
        stands(0.5, "B, downward: 0.62 of present")
        assert list(journal.places()) == [(0.5, "B, downward: 0.62 of present")]
        notes.begin("b" * 32)
        assert list(journal.places()) == [(0.0, "")]
        stands(0.5, "C")
        assert journal.in_flight() == ["b" * 32]
    stands(0.5, "nobody hears this")
    assert list(journal.places()) == []


@pytest.mark.parametrize("harm", ["empty", "cut", "one byte", "foreign"])
def test_a_damaged_part_is_left_aside_and_named(journal, harm):
    path = next(path for path in journal.parts() if path.name.startswith("2-"))
    whole = path.read_bytes()
    for at in (len(whole) - 1, len(whole) // 2, 40, 3):
        flipped = whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]
        path.write_bytes({"empty": b"", "cut": whole[:at], "one byte": flipped, "foreign": b"x" * at}[harm])
        again = Journal(journal.folder)
        assert again.index() == {"ccc": CRASHED}
        assert again.load(["a", "bb", "ccc"]).keys() == {"ccc"}
        assert again.damaged == {path.name}
    again.compact()
    assert len(again.parts()) == 1
    assert Journal(journal.folder).index() == {"ccc": CRASHED}


def test_a_part_is_there_whole_or_not_at_all(journal, monkeypatch):
    before = journal.parts()
    monkeypatch.setattr(os, "replace", lambda *_: die())
    assert forked(lambda: write_part(journal.folder, entries("d"))) == signal.SIGKILL
    monkeypatch.undo()
    assert journal.parts() == before
    assert list(journal.folder.glob(".*.tmp"))
    with journal.held():
        assert not list(journal.folder.glob(".*.tmp"))
    assert journal.index().keys() == {"a", "bb", "ccc"}


def test_rewriting_keeps_what_is_wanted_even_if_killed_halfway(journal, monkeypatch):
    journal.compact()
    assert len(journal.parts()) == 1
    journal.write(entries("d"))
    monkeypatch.setattr(type(journal.folder), "unlink", lambda *_, **__: die())
    assert forked(journal.compact) == signal.SIGKILL
    monkeypatch.undo()
    assert journal.index() == {"a": 0, "bb": 0, "ccc": CRASHED, "d": 0}
    journal.keep_only(["a", "d"])
    assert journal.index() == {"a": 0, "d": 0}


def test_joining_parts_joins_their_bytes(journal):
    journal.write(entries("dddd"))
    parts = [path.read_bytes() for path in journal.parts()]
    before, keys = journal.index(), ["a", "bb", "ccc", "dddd", "e"]
    answers = journal.load(keys)
    journal.compact()
    (joined,) = journal.parts()
    assert joined.read_bytes() == b"".join(parts)
    assert joined.name.startswith("4-")
    assert journal.index() == before
    again = journal.load(keys)
    assert list(again) == list(answers)
    assert all(np.array_equal(again[key]["values"], answers[key]["values"]) for key in answers)


@pytest.mark.parametrize("place", [0, len(MAGIC) + 1, len(MAGIC) + 7, len(MAGIC) + 20, -1])
def test_damage_in_a_joined_part_costs_that_frame_only(journal, place):
    journal.write(entries("d", "ee"))
    journal.compact()
    (path,) = journal.parts()
    whole = path.read_bytes()
    starts = [i for i in range(len(whole)) if whole.startswith(MAGIC, i)]
    assert len(starts) == 3
    lost = []
    for start, end in zip(starts, [*starts[1:], len(whole)], strict=True):
        at = end - 1 if place < 0 else start + place
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x81]) + whole[at + 1 :])
        again = Journal(journal.folder)
        lost.append(journal.index().keys() ^ {"a", "bb", "ccc", "d", "ee"})
        assert again.load(["a", "bb", "ccc", "d", "ee"]).keys() == again.index().keys()
        assert again.damaged == {path.name}
    assert sorted(map(sorted, lost)) == [["a", "bb"], ["ccc"], ["d", "ee"]]
    again.compact()
    assert Journal(journal.folder).index().keys() == {"a", "bb", "ccc", "d", "ee"} - lost[-1]


def test_cells_are_taken_from_another_journal_once(journal, tmp_path):
    other = Journal(tmp_path / "b.journal")
    with other.held():
        assert other.take(journal, ["bb", "ccc", "x"]) == {"bb", "ccc"}
    assert other.index() == {"bb": 0, "ccc": CRASHED}
    assert other.count() == 2
    assert np.array_equal(other.load(["bb"])["bb"]["values"], [2.0, 3.0, 4.0])
    assert other.take(journal, ["x"]) == set()
    assert len(other.parts()) == 1
    other.write(entries("bb"))  # as when a run is killed while it joins parts
    assert [key for key, _ in other.answers(["bb", "ccc"])].count("bb") == 1
    other.compact()
    assert other.count() == sum(len(frame.index) for frame in other._sound()) == 2


def test_a_journal_of_another_format_is_refused(journal):
    path = journal.folder / journals.HEADER
    path.write_text(json.dumps(json.loads(path.read_text()) | {"format": 1}))
    with pytest.raises(InputError, match="format 1") as error, journal.held():
        pass
    assert "--fresh" in error.value.problems[0].expected
    old = next(iter(journal.parts()))
    old.write_bytes(old.read_bytes().replace(MAGIC, b"jointplay journal part 1\n"))
    assert len(Journal(journal.folder).index()) < 3


@pytest.mark.parametrize("module", ["fcntl", "msvcrt"])
def test_one_run_at_a_time_and_a_dead_one_holds_nothing(journal, module, monkeypatch):
    if module == "msvcrt":  # of Windows: a stand-in, which locks a byte as it does
        monkeypatch.setitem(sys.modules, "msvcrt", windows.msvcrt())
        monkeypatch.setitem(sys.modules, "fcntl", None)
    child = os.fork()
    if not child:
        with journal.held():
            (journal.folder / "begun").touch()
            time.sleep(60)
        os._exit(0)
    while not (journal.folder / "begun").exists():
        time.sleep(0.01)
    try:
        with pytest.raises(Busy, match=f"process {child} "), journal.held():
            pass
        with pytest.raises(InputError), journal.held(fresh=True):
            pass
        assert journal.index().keys() == {"a", "bb", "ccc"}
        assert journal.writer().startswith(f"{child} ")
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    assert journal.writer() is None
    with journal.held():
        journal.write(entries("d"))
    assert "d" in journal.index()


@pytest.mark.parametrize("harm", ["kernels", "unreadable", "lost"])
def test_cells_of_other_code_are_not_mixed(journal, harm, monkeypatch):
    path = journal.folder / journals.HEADER
    if harm == "kernels":
        monkeypatch.setattr(origin, "code", lambda: "another")
    elif harm == "unreadable":
        path.write_text("{")
    else:
        path.unlink()
    with pytest.raises(InputError, match="--fresh") as error, journal.held():
        pass
    assert error.value.problems[0].given == str(journal.folder)
    assert journal.count() == 3
    with journal.held(fresh=True):
        assert journal.index() == {}
    assert json.loads(path.read_text())["code"] == origin.code()


def test_the_code_counts_every_folder_with_a_kind_of_study():
    places = {row.function.__module__ for row in KINDS.values()}
    counted = (*(folder.replace("/", ".") for folder in origin.FOLDERS), *packages(*origin.DECIDING))
    assert all(place.startswith(counted) for place in places)


def test_the_code_counts_analyses_mechanisms_and_packages_of_others_beside_kernels(tmp_path, monkeypatch):
    rooms = [*origin.FOLDERS, "figures", "stranger/inner", "shared/part"]
    for room in rooms:
        (tmp_path / room).mkdir(parents=True)
        (tmp_path / room / "a.py").write_text("1")
    for name in ("stranger/__init__.py", "shared/part/__init__.py", "alone.py"):
        (tmp_path / name).write_text("raise SystemExit")  # nothing of them is imported
    points = [("jointplay.laws", "stranger.no:LAW"), ("jointplay.kinds", "alone:ROW")]
    points += [("jointplay.mechanisms", "shared.part.b:a"), ("jointplay.frictions", "missing.b:a")]
    entries = {group: [EntryPoint("a", value, group)] for group, value in points}
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(origin, "PACKAGE", tmp_path / "jointplay")
    monkeypatch.setattr(extensions, "published", lambda group: entries[group])
    digest = origin.code.__wrapped__
    first = digest()
    (tmp_path / "figures" / "a.py").write_text("2")
    assert digest() == first
    for place in [*(f"{room}/a.py" for room in rooms if room != "figures"), "alone.py"]:
        (tmp_path / place).write_text("2")
        assert digest() not in (first, None), place
        first = digest()


def test_a_key_is_of_the_values_to_the_last_bit():
    assert key_of({"a": 1.0, "b": 2}) == key_of({"b": 2, "a": 1.0})
    assert key_of(np.float64(0.1)) == key_of(0.1)
    given = [0.1, np.nextafter(0.1, 1), 0.2, 1, 1.0, "1", [0.1], {"a": 0.1}, None]
    assert len({key_of(each) for each in given}) == len(given)
