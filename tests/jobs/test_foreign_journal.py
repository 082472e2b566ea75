"""Journals that others wrote, damaged or meant: no code of theirs runs, and no number of theirs is taken."""

import os
import pickle
import random
import shutil

import numpy as np
import pytest

from jointplay import cli
from jointplay.display.errors import InputError
from jointplay.jobs import origin, values
from jointplay.jobs.journal import FORMAT, HEAD, MAGIC, Journal, head_of, new_part
from jointplay.jobs.pool import Pool
from jointplay.study import plan
from jointplay.study.execute import complete, journal_of
from jointplay.study.results import provenance
from tests.support.sweep_samples import CELLS, CHAINS, PLANE, loaded, ran, same

QUICK = ("--no-figure", "--jobs", "1")
STUDIES = {"cells": CELLS, "chains": CHAINS, "plane": PLANE}


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Journals of several parts, by the name of the study, and what came of the runs."""
    out, found = tmp_path_factory.mktemp("kept"), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("jointplay.jobs.worker.BATCH", 0.0)
        patch.setattr(Journal, "compact", lambda _: None)
        for name, text in STUDIES.items():
            found[name] = journal_of(out, name), ran(loaded(text), out)
    return found


def copy(journal, out):
    """A copy in another folder of results."""
    out.mkdir(exist_ok=True)
    shutil.copytree(journal.folder, out / journal.folder.name)
    return Journal(out / journal.folder.name)


class Malice:
    """Touches a file when it is unpickled."""

    def __init__(self, canary):
        self.canary = canary

    def __reduce__(self):
        return os.system, (f"touch {self.canary}",)


def old_frame(body):
    """A frame of the format that held pickles."""
    magic = b"jointplay journal part 2\n"
    return head_of(body).replace(MAGIC, magic)[: len(magic) + 8] + head_of(body)[-32:] + body


@pytest.mark.parametrize("form", ["old", "new", "index", "answers", "header"])
def test_a_pickle_in_a_journal_does_not_run(form, kept, tmp_path, capsys):
    out, canary = tmp_path / "out", tmp_path / "canary"
    journal = copy(kept["cells"][0], out)
    pickled = pickle.dumps(Malice(canary)) * 2
    part = journal.parts()[0]
    sound = part.read_bytes()[HEAD:]
    body = {"index": pickled + sound, "answers": sound[: values.length(sound)] + pickled}.get(form, pickled)
    part.write_bytes(old_frame(body) if form == "old" else head_of(body) + body)
    if form == "header":
        (journal.folder / "journal.json").write_bytes(pickled)
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    for verb, more in (("status", ()), ("plan", ()), ("merge", QUICK[:1]), ("run", QUICK)):
        cli.main([verb, str(path), "--out", str(out), *more])
        assert not canary.exists()
    assert "Traceback" not in "".join(capsys.readouterr())


def test_answers_that_fit_their_checksum_and_make_no_sense_are_told(kept, tmp_path, capsys):
    journal = copy(kept["cells"][0], tmp_path)
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    part = journal.parts()[0]
    sound = part.read_bytes()[HEAD:]
    index = sound[: values.length(sound)]
    for told in ([], [[{"status": 3}], []], [[{"status": 0}], [[[0], np.zeros(3, np.uint8), []]]], {"": "x"}):
        body = index + values.written(told)
        part.write_bytes(head_of(body) + body)
        assert cli.main(["status", str(path), "--out", str(tmp_path)]) == 0
        assert cli.main(["run", str(path), "--out", str(tmp_path), *QUICK]) == 1
        assert "holds no answers of cells; `jointplay run --fresh` drops it" in capsys.readouterr().err


ARRAY = {"": "array", "kind": "<f8", "shape": [1], "at": 0}


@pytest.mark.parametrize("told", [
    {"": "code"}, {"": "end", "names": [], "state": 1, "crank_angle": 0},
    ARRAY | {"": "number", "kind": "<i3"},
    ARRAY | {"kind": "|O"}, ARRAY | {"kind": "V8"}, ARRAY | {"kind": "<U1"}, ARRAY | {"at": 10**30},
    *(ARRAY | {"shape": shape} for shape in ([-1], [10**30], ["a"], [0, 10**30], [3])),
])  # fmt: skip
def test_values_that_no_journal_holds_are_refused(told):
    sound = values.written([told, np.full(3, 0xFFFFFFFF, np.uint32)])
    with pytest.raises(ValueError, match=r"journal|buffer|dimension"):
        values.read(sound)


def test_bytes_that_are_no_value_are_refused_whatever_they_are():
    sound = values.written([1.0, np.arange(5.0), {"a": np.int8(3)}])
    dice = random.Random(1)
    for _ in range(300):
        bad = bytearray(sound)
        for _ in range(dice.randint(1, 8)):
            bad[dice.randrange(len(bad))] = dice.randrange(256)
        try:
            values.read(bad[: dice.randint(0, len(bad))])
        except ValueError:
            continue
    with pytest.raises(ValueError, match="recursion"):
        values.read(bytes(8) + (200_000).to_bytes(8, "big") + b"[" * 200_000)


@pytest.mark.parametrize("value", [object(), 1j, b"a", np.array([object()]), np.array([(1, 2.0)], "i4,f8"),
                                   np.datetime64("2000-01-01"), {1, 2}])  # fmt: skip
def test_what_could_hold_more_than_numbers_and_texts_is_not_written(value):
    with pytest.raises(TypeError):
        values.written([value])


def test_values_come_back_with_their_types_and_bits():
    end = (["q", "v"], np.array([-0.0, np.nextafter(1, 2)]), 0.1)
    arrays = [np.array(0.5), np.zeros((0, 3), np.float32), np.array(["ä", ""]), np.arange(6).reshape(2, 3).T]
    arrays += [np.array([True]), np.array([1 + 2j]), np.array([np.nan]), np.arange(3, dtype=">i2")]
    plain = [np.int8(3), np.bool_(True), 5e-324, float("inf"), "\ud800", None]
    found = values.read(values.written([end, arrays, *plain]))
    assert [found[0][0], found[0][2]] == [end[0], end[2]]
    assert found[0][1].tobytes() == end[1].tobytes()
    for one, other in zip(arrays, found[1], strict=True):
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
    assert [type(each) for each in found[2:4]] == [np.int8, np.bool_]
    assert found[2:] == plain


def test_strange_files_in_a_journal_are_ignored_kept_and_named(kept, tmp_path, capsys):
    journal = copy(kept["cells"][0], tmp_path)
    names = ["notes.txt", "x.part", "7.part", "a-b.part", "note.at", ".mine.tmp", "journal.json.bak"]
    for name in names:
        (journal.folder / name).write_bytes(b"\xff\x00 mine")
    hexadecimal = "0" * 32
    (journal.folder / f"3-{hexadecimal}.part").mkdir()
    (journal.folder / "9-00000000.at").mkdir()
    os.mkfifo(journal.folder / f"4-{hexadecimal}.part")
    strange = sorted([*names, f"3-{hexadecimal}.part", f"4-{hexadecimal}.part", "9-00000000.at"])
    assert journal.unknown_files() == strange
    study, said = loaded(CELLS), []
    assert any(
        f"{len(strange)} file(s) ignored" in line and ".mine.tmp" in line
        for line in plan.status(study, tmp_path)
    )
    assert same(ran(study, tmp_path, say=said.append), kept["cells"][1])
    assert any("ignored" in line and ".mine.tmp, 3-0" in line for line in said)
    assert journal.unknown_files() == strange
    assert len(journal.parts()) == 1


def test_parts_of_other_code_among_the_own_are_left_aside_and_named(kept, tmp_path, monkeypatch):
    journal = copy(kept["cells"][0], tmp_path)
    answers = journal.load(journal.index())
    key = next(iter(answers))
    right = answers[key]["dataset"]
    false = right._replace(values=[0 * each if each.dtype.kind == "f" else each for each in right.values])
    for path in journal.parts():
        path.unlink()
    monkeypatch.setattr(origin, "code", lambda: "another")
    journal.write({key: {"status": 0, "dataset": false}})
    monkeypatch.undo()
    (part,) = journal.parts()
    said = []
    assert same(ran(loaded(CELLS), tmp_path, say=said.append), kept["cells"][1])
    assert any("of other code" in line and part.name in line for line in said)
    assert part.exists()
    assert any("of other code" in line for line in plan.status(loaded(CELLS), tmp_path))


def test_an_old_journal_is_told_by_status_and_plan_and_refused_by_run(kept, tmp_path, capsys):
    journal = copy(kept["cells"][0], tmp_path)
    header = journal.folder / "journal.json"
    header.write_text(header.read_text().replace(f'"format": {FORMAT}', '"format": 2'))
    for path in journal.parts():
        path.write_bytes(old_frame(pickle.dumps([]) * 2))
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    for verb, code in (("status", 0), ("plan", 0), ("run", 2), ("merge", 2)):
        assert cli.main([verb, str(path), "--out", str(tmp_path)]) == code
        said = "".join(capsys.readouterr())
        assert "format 2" in said
        assert "--fresh" in said
        assert "damaged" not in said


def test_cells_of_several_kinds_of_processors_are_told(kept, tmp_path, monkeypatch):
    study, said = loaded(CELLS), []
    journal = copy(kept["cells"][0], tmp_path)
    here = provenance.processor()
    journal.parts()[0].unlink()
    monkeypatch.setattr(origin, "processor", lambda: "abacus 0123")
    monkeypatch.setattr("jointplay.study.execute.processor", lambda: "abacus 0123")
    found = ran(study, tmp_path, say=said.append)
    monkeypatch.undo()
    assert any(f"another kind of processor (abacus 0123) than theirs: {here}" in line for line in said)
    assert any(line.startswith("result  computed on 2 kinds of processors (abacus 0123, ") for line in said)
    assert provenance.read(found)["environment"]["processor"] == f"abacus 0123, {here}"
    assert any("2 kinds of processors" in line for line in plan.status(study, tmp_path))
    said.clear()
    assert provenance.read(ran(study, tmp_path / "anew", say=said.append))["environment"]["processor"] == here
    assert not any("processor" in line for line in said)


def test_the_kind_of_processor_is_what_kernels_are_compiled_for(monkeypatch):
    def kind(*told):
        monkeypatch.setattr("jointplay.solver.codegen.place.target", lambda: told)
        return provenance.processor.__wrapped__()

    native = kind("linux", "zen", "+avx")
    assert native.startswith("zen ")
    assert (
        len({native, kind("linux", "zen", ""), kind("linux", "generic", "+avx"), kind("mac", "zen", "+avx")})
        == 4
    )


HARMS = (
    "flip",
    "cut",
    "grow",
    "foreign",
    "pickle",
    "swap",
    "double",
    "lose",
    "name",
    "header",
    "of another study",
)


def harm(journal, other, dice, canary):
    """Do something to a journal."""
    what, parts = dice.choice(HARMS), journal.parts()
    if not parts:
        return
    part = dice.choice(parts)
    content = bytearray(part.read_bytes())
    if what == "flip" and content:
        for _ in range(dice.choice([1, 1, 5])):
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
        part.write_bytes(content)
    elif what == "cut":
        at = dice.randrange(len(content) + 1)
        part.write_bytes(dice.choice([content[:at], content[at:]]))
    elif what == "grow":
        part.write_bytes(content + dice.choice([MAGIC, dice.randbytes(99), content]))
    elif what == "foreign":
        part.write_bytes(dice.randbytes(dice.choice([0, 7, 4096])))
    elif what == "pickle":
        body = pickle.dumps(Malice(canary)) * 2
        part.write_bytes(dice.choice([old_frame(body), head_of(body) + body, body]))
    elif what == "swap":
        rest = dice.choice(parts)
        part.write_bytes(rest.read_bytes())
    elif what == "double":
        new_part(journal.folder, 1).write_bytes(content)
    elif what == "lose":
        part.unlink()
    elif what == "name":
        part.rename(
            dice.choice([part.with_suffix(".bak"), part.with_name("part.part"), new_part(journal.folder, 99)])
        )
    elif what == "header":
        header = journal.folder / "journal.json"
        text = header.read_bytes()
        header.write_bytes(
            dice.choice([text[: dice.randrange(len(text) + 1)], b"[" * 100_000, b"\xff", b"3"])
        )
    else:
        shutil.copy(dice.choice(other.parts()), journal.folder)


def attacked(kept, tmp_path, numbers):
    """Harm copies of journals and look at them, run what is missing, and compare."""
    names, canary = list(STUDIES), tmp_path / "canary"
    sound = {key: status for journal, _ in kept.values() for key, status in journal.index().items()}
    for number in numbers:
        dice, out = random.Random(number), tmp_path / str(number)
        name = names[number % len(names)]
        study, (journal, whole) = loaded(STUDIES[name]), kept[name]
        mine = copy(journal, out)
        for _ in range(dice.choice([1, 1, 2, 4])):
            harm(mine, kept[dice.choice(names)][0], dice, canary)
        assert list(plan.status(study, out))
        assert mine.index().items() <= sound.items()
        try:
            found = complete(study, out, Pool(1)).dataset
        except InputError:  # the header was harmed
            found = complete(study, out, Pool(1), fresh=True).dataset
        assert same(found, whole), number
        assert not canary.exists(), number
        assert mine.index().keys() >= journal.index().keys()
        shutil.rmtree(out)


@pytest.mark.long
def test_damaged_journals_never_run_code_nor_give_a_wrong_number(kept, tmp_path):
    attacked(kept, tmp_path, range(24))


@pytest.mark.nightly
def test_many_damaged_journals_never_run_code_nor_give_a_wrong_number(kept, tmp_path):
    attacked(kept, tmp_path, range(24, 400))
