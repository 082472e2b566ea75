"""Damaged, swapped and foreign files of the kernel cache: made anew with a line, and never a wrong number."""

import errno
import os
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

from jointplay.solver.codegen import cache, place
from tests.support.program import ended_process

CACHE = "from jointplay.solver.codegen import cache"
TEXT = """
SHIFT = 0.3125


def twice(h):
    return 2.0 * h + SHIFT


def thrice(h):
    return 3.0 * h + 0.3125
"""
TEXTS = {"right": TEXT, "other": TEXT.replace("0.3125", "0.8125")}
RIGHT, WRONG = (4.3125, 6.3125), (4.8125, 6.8125)
NOBODY = 65534
SMALL = "modal_response"  # a loop that compiles fast


KINDS = ("py", "constants", "name", "o")


def load(writer="right"):
    """What the functions give in a module loaded afresh, and how many times code had to be compiled."""
    cache._module.cache_clear()
    before = len(EMITTED)
    module = cache._module(writer)
    return tuple(f(2.0) for f in (module.twice, module.thrice)), len(EMITTED) - before


EMITTED = []


@pytest.fixture(autouse=True, scope="module")
def _written():
    """Note what is compiled to machine code, of texts that two writers give."""
    emit = place.emit
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cache, "_text", TEXTS.__getitem__)
        patch.setattr(place, "emit", lambda *given: EMITTED.append(None) or emit(*given))
        yield


def fresh(monkeypatch, root):
    """A cache of its own, as a process finds it that starts."""
    monkeypatch.setenv("JOINTPLAY_CACHE", str(root))
    monkeypatch.delenv(place.HANDED, raising=False)
    for known in (place.folder, cache._module, place.say):
        known.cache_clear()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A cache with two modules in it."""
    with pytest.MonkeyPatch.context() as patch:
        root = tmp_path_factory.mktemp("whole") / "cache"
        fresh(patch, root)
        load("other")
        load()
    return root


@pytest.fixture
def here(whole, tmp_path, monkeypatch):
    """A copy of that cache, in use: the folder of the digest."""
    shutil.copytree(whole, tmp_path / "cache")
    fresh(monkeypatch, tmp_path / "cache")
    yield place.folder()
    place.settle()
    place._pending.clear()
    for known in (place.folder, cache._module, place.say):
        known.cache_clear()


def file(here, kind):
    """The file of a kind that belongs to the module."""
    name = here / f"{cache._short('right ()')}.name"
    return name if kind == "name" else next(here.glob(f"{place.content(name).decode()}*.{kind}"))


def other(path):
    """A file of the same kind that belongs to the other module."""
    return next(p for p in path.parent.glob(f"*{path.suffix}") if p != path and SMALL not in p.name)


def cut(path):
    path.write_bytes(path.read_bytes()[:-9])


def empty(path):
    path.write_bytes(b"")


def flip(path):
    data = bytearray(path.read_bytes())
    data[-20] ^= 4
    path.write_bytes(data)


def digit(path):
    path.write_text(path.read_text().replace("0.3125", "0.8125"))


def swap(path):
    shutil.copy(other(path), path)


def rename(path):
    """What a wrong name looked like when names had no seal."""
    path.write_bytes(place.content(other(path)))


def junk(path):
    """As if it had been written so: what is sealed need not load, on another machine."""
    place.write(path.name, b"no code")
    place.settle()


def make_folder(path):
    path.unlink()
    (path / "inside").mkdir(parents=True)


def make_link(path):
    shutil.move(path, path.parents[2] / path.name)
    path.symlink_to(path.parents[2] / path.name)


def make_pipe(path):
    path.unlink()
    os.mkfifo(path)


def give_away(path):
    if os.geteuid():
        pytest.skip("only root gives files away")
    os.chown(path, NOBODY, NOBODY)


def open_up(path):
    path.chmod(0o666)


ATTACKS = [
    *((kind, attack) for kind in KINDS for attack in (cut, empty, flip, swap)),
    *((kind, attack) for kind in ("py", "o") for attack in (make_folder, make_link, give_away, open_up)),
    *(("py", digit), ("name", rename), ("o", make_pipe), ("o", junk), ("constants", junk)),
]


@pytest.mark.parametrize(("kind", "attack"), ATTACKS, ids=lambda x: getattr(x, "__name__", x))
def test_a_file_that_is_not_as_it_was_written_is_made_anew(here, capsys, kind, attack):
    path = file(here, kind)
    attack(path)
    assert load()[0] == RIGHT
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert told.startswith(f"kernel cache: {path} ")
    place.say.cache_clear()
    assert load() == (RIGHT, 0), "healed: nothing to compile"
    assert capsys.readouterr().err == ""
    assert place.verify()[1] == 0


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_that_is_gone_is_made_anew(here, kind):
    file(here, kind).unlink()
    assert load()[0] == RIGHT
    assert load() == (RIGHT, 0)


def test_what_is_whole_is_compiled_no_more(here, capsys):
    assert load() == (RIGHT, 0)
    assert load("other") == (WRONG, 0)
    assert capsys.readouterr().err == ""


def open_folder(here):
    here.chmod(0o777)


def give_folder_away(here):
    give_away(here)


def link_folder(here):
    here.rename(here.parent / "elsewhere")
    here.symlink_to(here.parent / "elsewhere")


def no_folder(here):
    shutil.rmtree(here)
    here.write_text("")


@pytest.mark.parametrize("attack", [open_folder, give_folder_away, link_folder, no_folder])
def test_a_folder_that_others_can_change_is_emptied(here, capsys, attack):
    attack(here)
    place.folder.cache_clear()
    assert load() == (RIGHT, 1), "nothing that lay there is believed"
    assert here.stat().st_mode & 0o777 == 0o700
    assert here.stat().st_uid == os.geteuid()
    assert capsys.readouterr().err.count("\n") == 1
    assert load() == (RIGHT, 0)


def file_above(root):
    root.write_text("")


def open_above(root):
    root.mkdir()
    root.chmod(0o777)


def anothers_above(root):
    root.mkdir()
    give_away(root)


@pytest.mark.parametrize("attack", [file_above, open_above, anothers_above])
def test_a_cache_that_cannot_be_used_is_told_and_leaves_nothing_behind(tmp_path, attack):
    root, temporary = tmp_path / "cache", tmp_path / "temporary"
    attack(root)
    temporary.mkdir()
    told = compiled_apart(root, TMPDIR=str(temporary))
    assert told.count("\n") == 1
    assert str(root) in told
    assert "for this run alone" in told
    assert not list(temporary.iterdir())
    assert not root.is_dir() or not list(root.iterdir())


def test_the_folder_of_a_run_that_was_killed_goes_with_the_next(tmp_path):
    root, temporary = tmp_path / "cache", tmp_path / "temporary"
    file_above(root)
    temporary.mkdir()
    left, mine, other = (f"jointplay-kernels-{maker}-x" for maker in (ended_process(), os.getpid(), "mine"))
    for name in (left, mine, other):
        (temporary / name / "0").mkdir(parents=True)
        (temporary / name).chmod(0o700)
    compiled_apart(root, TMPDIR=str(temporary))
    assert {path.name for path in temporary.iterdir()} == {mine, other}


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="children of a process, as Linux lists them")
def test_a_process_that_compiles_and_is_not_waited_for_is_not_left_defunct(unloaded, monkeypatch):
    monkeypatch.setattr(cache, "CHILD", "")
    cache.prepare(unloaded)
    child = cache._compiling.pop(unloaded)[0]
    for _ in range(600):
        if not os.path.exists(f"/proc/{child.pid}"):
            break
        time.sleep(0.1)
    assert not os.path.exists(f"/proc/{child.pid}")
    assert child.returncode == 0


def compiled_apart(root, **variables):
    """What a process tells that compiles with this cache; its answers are right."""
    code = f"{CACHE}; cache._text = {TEXTS!r}.get; print(cache._module('right').twice(2.0))"
    environment = os.environ | {"JOINTPLAY_CACHE": str(root)} | variables
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=300, check=True
    )
    assert float(done.stdout) == RIGHT[0]
    return done.stderr


def test_a_full_disk_is_told_and_costs_only_time(here, monkeypatch, capsys):
    shutil.rmtree(here)

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    place.folder.cache_clear()
    assert load() == (RIGHT, 1)
    assert load() == (RIGHT, 0), "kept in memory"
    told = capsys.readouterr().err
    assert "No space left" in told
    assert told.count("\n") == 1
    assert not list(here.iterdir()), "nothing unfinished is left"


def test_a_folder_that_is_removed_meanwhile_is_made_again(here):
    assert load() == (RIGHT, 0)
    assert place.prune(everything=True) == [here.name]
    assert load() == (RIGHT, 1)
    assert load() == (RIGHT, 0)
    assert place.folder() == here


def test_what_a_killed_writer_left_goes_with_verification_once_it_is_old(here, capsys):
    for name, age in (("tmpold.tmp", 7200), ("tmpnew.tmp", 0)):
        (here / name).write_text("half")
        os.utime(here / name, (time.time() - age,) * 2)
    sound = len(list(here.iterdir())) - 2
    assert place.verify() == (sound, 0)
    assert [path.name for path in here.glob("*.tmp")] == ["tmpnew.tmp"]


def test_a_file_shows_only_when_it_is_on_the_disk(here, monkeypatch):
    order = []
    sync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda *a: (order.append("sync"), sync(*a)))
    monkeypatch.setattr(os, "replace", lambda *a: (order.append("show"), replace(*a)))
    place.write("some.name", b"some")
    place.settle()
    assert order == ["sync", "show", "sync"]
    assert place.content(here / "some.name") == b"some"


@pytest.fixture
def unloaded(here, monkeypatch):
    """The name of a loop of the method that this process has not loaded yet, and that it may not compile."""
    monkeypatch.setattr(cache, "_loops", {})
    monkeypatch.setattr(cache, "build", lambda name: pytest.fail(f"{name} is compiled in this process"))
    return SMALL


def answers(loop):
    """Whether a loop answers rightly."""
    step, rows = np.zeros((1, 2, 4)), np.zeros((3, 2, 1))
    step[0, 0, 2], rows[2] = 0.5, [[7.0], [9.0]]
    rows[0, 1], rows[1, 1] = np.nan, np.nan
    loop.respond(step, rows[2], rows[0], rows[1])
    return rows[0, 1, 0] == 3.5 and rows[1, 1, 0] == 0.0


def made(here):
    """The file of the loop."""
    cache._loops.clear()
    assert answers(cache.method(SMALL))
    place.settle()
    (path,) = here.glob(f"{SMALL}.*.o")
    return path


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """The file of the loop, in the cache in which it was compiled."""
    with pytest.MonkeyPatch.context() as patch:
        fresh(patch, tmp_path_factory.mktemp("once") / "cache")
        patch.setattr(cache, "_loops", {})
        return made(place.folder())


def test_the_code_of_a_loop_is_kept_where_it_is_compiled(here, monkeypatch):
    monkeypatch.setattr("jointplay.solver.method.compiler.object_code", lambda *_: b"machine code")
    assert cache.build(SMALL) == b"machine code"
    place.settle()
    (path,) = here.glob(f"{SMALL}.*.o")
    assert place.read(path.name) == b"machine code"


@pytest.mark.nightly
def test_a_loop_is_made_once_and_in_a_process_of_its_own(unloaded, here, monkeypatch, capsys):
    path = made(here)
    before = path.stat().st_mtime_ns
    monkeypatch.setattr(cache, "_start", lambda name: pytest.fail(f"{name} is compiled again"))
    assert made(here).stat().st_mtime_ns == before
    assert capsys.readouterr().err == ""


@pytest.mark.nightly
@pytest.mark.parametrize("attack", [cut, empty, flip, make_folder, make_link, make_pipe, give_away, open_up])
def test_a_loop_that_is_not_as_it_was_written_is_made_anew(once, unloaded, here, capsys, attack):
    path = here / shutil.copy(once, here)
    attack(path)
    assert made(here) == path
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert told.startswith(f"kernel cache: {path} ")
    assert place.verify()[1] == 0


@pytest.mark.nightly
def test_no_file_of_the_current_folder_is_imported_where_kernels_compile(
    unloaded, tmp_path, monkeypatch, capsys
):
    study = tmp_path / "study"
    study.mkdir()
    for name in ("random", "platform", "tempfile", "numba"):
        (study / f"{name}.py").write_text("open('ran', 'w')\n")
    monkeypatch.chdir(study)
    monkeypatch.setenv("PYTHONPATH", os.pathsep + os.environ.get("PYTHONPATH", ""))
    assert answers(cache.method(unloaded))
    assert capsys.readouterr().err == ""
    assert not (study / "ran").exists()


def test_a_process_that_fails_to_compile_says_so(here, monkeypatch, capsys):
    monkeypatch.setattr(cache, "_loops", {})
    monkeypatch.setattr(cache, "CHILD", "raise RuntimeError('no such luck')")
    assert answers(cache.method(SMALL))
    told = capsys.readouterr().err.splitlines()
    assert told == [
        "kernel cache: a process that compiles failed, exit code 1: RuntimeError: no such luck",
        f"kernel cache: {SMALL} of the method is compiled in this process",
    ]


@pytest.mark.long
def test_processes_that_heal_the_same_cache_at_once_do_not_disturb_each_other(here):
    for path in [file(here, kind) for kind in KINDS]:
        cut(path)
    code = f"{CACHE}; cache._text = {TEXTS!r}.get; print(cache._module('right').twice(2.0))"
    command = [sys.executable, "-c", code]
    racing = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(4)]
    assert {float(one.communicate(timeout=300)[0]) for one in racing} == {RIGHT[0]}
    assert compiled_apart(here.parent) == ""
