"""What differs between systems: what Python has on POSIX systems alone, and how a run goes on without it."""

import ast
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from jointplay.analysis import evaluate
from jointplay.cli import main
from jointplay.jobs import interrupts
from jointplay.solver.motion import progress
from tests.docs.pages import ROOT
from tests.support.study_samples import SOFT
from tests.support.windows import MODULES
from tests.test_docstrings import FILES

posix = pytest.mark.skipif(os.name == "nt", reason="plays Windows on a POSIX system")
ALONE = {  # what is not there on Windows, or does something else
    "os": "fork forkpty geteuid getuid getgid getegid getpgid getpgrp getppid getsid kill killpg nice uname "
    "setsid mkfifo chown fchmod statvfs sysconf sched_getaffinity getloadavg sync set_blocking waitpid",
    "signal": "pthread_kill pthread_sigmask setitimer alarm pause set_wakeup_fd SIGURG SIGKILL SIGHUP",
}
LISTED = {  # by name: the file, and what is done without it
    "fcntl": ("jointplay.jobs.files", "msvcrt locks"),
    "os.geteuid": ("jointplay.solver.codegen.place", "owners and modes are not asked for"),
    "os.kill": ("jointplay.solver.codegen.place", "a process counts as being there"),
    "os.set_blocking": ("jointplay.jobs.interrupts", "unguarded, as Python's handlers then come soon"),
    "signal.SIGURG": ("jointplay.jobs.interrupts", "the same"),
    "signal.set_wakeup_fd": ("jointplay.jobs.interrupts", "the same"),
    "signal.pthread_kill": ("jointplay.jobs.interrupts jointplay.solver.motion.progress", "interrupt_main"),
    "signal.pthread_sigmask": ("jointplay.jobs.interrupts", "processes that are started hear it too"),
    "os.getppid": ("jointplay.jobs.parallel", "a worker ends as its pipe breaks, when its cell is done"),
}
PLAYED = """
import sys
sys.path.insert(0, sys.argv[1])
import joblib.externals.loky, llvmlite.binding, matplotlib.figure, netCDF4, numpy, pint, pydantic
import scipy.optimize, sympy, xarray  # all of which ask what system it is
import pytest
from tests.support import windows
windows.pretend(pytest.MonkeyPatch())
from jointplay.cli import main
for line in sys.stdin.read().splitlines():
    print("==", line, "==", main(line.split("|")), file=sys.stderr, flush=True)
"""
STUDY = """
kind = "response"
title = "Stöße in einem Weg"
[mechanism]
catalog = "impact_pair"
gap = 3.6
restitution = 0.8
[analysis]
turns = 1
"""
SWEEP = "Weg + Stöße.toml|--jobs|1"
COMMANDS = (
    *("run|Stoß 1.toml", "run|Stoß 1.toml", "export|results/Stoß 1.nc|--out|Daten ü.csv|--over|time"),
    *("figure|results/Stoß 1.nc|--out|Bild ü.png", "report|results/Stoß 1.nc|--out|Seite ü.html"),
    *(f"run|{SWEEP}|--part|1/2", f"run|{SWEEP}|--part|2/2", "merge|Weg + Stöße.toml", f"run|{SWEEP}|--fresh"),
    *(f"run|{SWEEP}|--set|vary.gap=[3.6,3.65]", "new|response|Neu ü.toml|--mechanism|four_bar"),
    *("check|Neu ü.toml", "list|.", "cache|verify"),
)


def used(tree):
    """Names of POSIX alone in a file, also as texts of `getattr` and `hasattr`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES.split())
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            yield f"{node.value.id}.{node.attr}"
        elif isinstance(node, ast.Call) and len(node.args) > 1 and isinstance(node.args[1], ast.Constant):
            yield f"{ast.unparse(node.args[0])}.{node.args[1].value}"


@pytest.mark.nightly
def test_whatever_is_of_posix_alone_is_listed_with_what_is_done_without_it():
    names = {f"{module}.{name}" for module, text in ALONE.items() for name in text.split()} | {
        *MODULES.split()
    }
    found = {}
    for file, path in FILES.items():
        text = path.read_text(encoding="utf-8")
        for name in {*used(ast.parse(text))} & names:
            found.setdefault(name, set()).add(file)
        assert "/proc/" not in text, file
        assert "/dev/" not in text, file
    assert found == {name: {*files.split()} for name, (files, _) in LISTED.items()}


@posix
@pytest.mark.nightly
def test_where_windows_refuses_and_names_have_spaces_and_umlauts_everything_runs(tmp_path):
    place = tmp_path / "Übung 1 – Gelenk"
    place.mkdir()
    (place / "Stoß 1.toml").write_text(STUDY, encoding="utf-8")
    (place / "Weg + Stöße.toml").write_text(STUDY + "[vary]\ngap = [3.6, 3.7, 3.8]\n", encoding="utf-8")
    own = {"JOINTPLAY_CACHE": str(place / "Kerne für alle"), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", PLAYED, str(ROOT)]
    done = subprocess.run(
        command, cwd=place, env=os.environ | own, input="\n".join(COMMANDS), capture_output=True, text=True
    )
    ends = re.findall("^== (.*) == (.*)$", done.stderr, re.M)
    assert ends == [(line, "0") for line in COMMANDS], done.stderr
    assert "kernel cache:" not in done.stderr
    assert "0 were damaged" in done.stdout
    assert {path.name for path in place.glob("* ü.*")} == {
        "Bild ü.png",
        "Daten ü.csv",
        "Neu ü.toml",
        "Seite ü.html",
    }
    assert not [*place.rglob("*tmp*")]


@posix
def test_ctrl_c_without_signals_to_threads(tmp_path, monkeypatch):
    from tests.cli.test_ctrl_c import pressing

    monkeypatch.delattr(signal, "pthread_kill")
    monkeypatch.setattr(interrupts, "PROBE", None)
    monkeypatch.setattr(evaluate, "BLOCK", 1000)
    monkeypatch.setattr(evaluate, "MOST", 2000)
    (tmp_path / "one.toml").write_text(f'kind = "response"\n\n{SOFT}turns = 40\nsamples_per_turn = 250\n')
    pressing(monkeypatch, evaluate.Quantities, "given", 2, lambda _, rows: len(rows) == 1000)
    assert main(["run", str(tmp_path / "one.toml"), "--out", str(tmp_path)]) == 130
    assert (tmp_path / "one.partial.nc").exists()


@posix
def test_a_stop_that_nobody_heeds_interrupts_without_signals_to_threads(monkeypatch):
    monkeypatch.delattr(signal, "pthread_kill")
    monkeypatch.setattr(progress, "PATIENCE", 0.1)

    def deaf():
        with progress.stoppable():
            assert progress.stop()
            for _ in range(600):
                time.sleep(0.05)

    with pytest.raises(KeyboardInterrupt):
        deaf()


@posix
def test_in_folders_that_know_no_capitals_another_studys_result_is_not_written_over(tmp_path, capsys):
    for name, turns in {"Spring": 1, "spring": 2}.items():
        (tmp_path / f"{name}.toml").write_text(f'kind = "response"\n{SOFT}turns = {turns}\n')
    run = ("--no-figure", "--out", str(tmp_path))
    assert main(["run", str(tmp_path / "Spring.toml"), *run]) == 0
    os.link(tmp_path / "Spring.nc", tmp_path / "spring.nc")  # one file by both names, as there
    before = (tmp_path / "Spring.nc").read_bytes()
    assert main(["run", str(tmp_path / "spring.toml"), *run]) == 2
    assert "it is a result with other settings (name, analysis.turns)" in capsys.readouterr().err
    assert (tmp_path / "Spring.nc").read_bytes() == before


def test_the_workflow_calls_the_commands_of_the_readme_alone_on_every_python_there_is():
    text = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    commands = re.findall(r"^ +- run: (.*)$", text, re.M)
    assert len(commands) == text.count("run: ") - text.count("{ run: {") == 2
    assert {*commands} <= {*readme}
    (least,) = re.findall(
        r'requires-python = ">=(.*)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    )
    assert re.findall(r'"(3\.\d+)"', text)[0] == least
