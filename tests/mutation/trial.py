"""One mutant before the tests: default ones first, then long ones."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from coverage import CoverageData

from . import mutants
from .chosen import Map
from .covering import CONTEXT, TABLE
from .mutants import Mutant, found_again
from .processes import call, tested

KERNELS = ("equations", "codegen", "method")  # rooms whose change compiles everything anew
# Compiled rounds of the kernels' rooms: the rooms' own tests, then those that know exact motions.
OWN = {
    "equations": ["tests/equations", "tests/codegen", "tests/mechanism"],
    "codegen": [
        "tests/codegen",
        "tests/equations",
        "tests/method",
        "tests/analysis/sweeps/test_ensemble.py",
        "tests/analysis/sweeps/test_ensemble_analyses.py",
        "tests/cli/test_cache_verb.py",
        "tests/test_fresh_kernels.py",
    ],
    "method": [
        *("tests/method", "tests/codegen"),
        *("tests/analysis/sweeps/test_ensemble.py", "tests/analysis/sweeps/test_ensemble_analyses.py"),
    ],
}
EXACT = [
    *("tests/analysis/test_known_ball.py", "tests/analysis/test_known_impacts.py"),
    *("tests/analysis/test_known_sections.py", "tests/analysis/test_known_smooth.py"),
    *("tests/analysis/test_known_soft.py", "tests/analysis/test_truth.py", "tests/analysis/test_elastic.py"),
    *(
        "tests/analysis/test_energy.py",
        "tests/analysis/test_event_order.py",
        "tests/analysis/test_sections.py",
    ),
    *("tests/analysis/test_contacts.py", "tests/analysis/test_elastic_energy.py"),
]
INTERPRETED = " (interpreted)"  # behind a test's name
LEFT_OUT = ("JOINTPLAY_KERNELS", "NUMBA_CACHE_DIR", "PYTHONDONTWRITEBYTECODE")  # variables of the caller
ENDLESS = 150  # s a test, compilation included: twice what the slowest takes
TIMES = 10  # how much slower than under coverage a busy machine may be
SETTINGS = """[run]
source_pkgs =
    jointplay
    jointplay_lab
    jointplay_page
parallel = true
data_file = {folder}/raw/data
context = ${{{context}}}
patch = _exit
sigterm = true
disable_warnings = no-data-collected,module-not-imported,module-not-measured,already-imported
"""


def environment(tree: Path, work: Path, **more: str) -> dict[str, str]:
    """Variables under which tests of the copy run: its package, and folders that nobody else uses."""
    for name in ("home", "tmp"):
        (tree.parent / name).mkdir(parents=True, exist_ok=True)
    plain = {k: v for k, v in os.environ.items() if k not in LEFT_OUT}
    own = {
        "PYTHONPATH": str(tree / "src"),
        "JOINTPLAY_CACHE": str(work / "cache"),
        "HOME": str(tree.parent / "home"),
        "TMPDIR": str(tree.parent / "tmp"),
        "HYPOTHESIS_STORAGE_DIRECTORY": str(tree.parent / "tmp" / "hypothesis"),
        "PYTHONUNBUFFERED": "1",
    }
    return plain | own | more


def cover(tree: Path, work: Path, tests: list[str]) -> None:
    """Run tests under coverage and add to the map what they ran; NUMBA_DISABLE_JIT=1 shows it the kernels."""
    folder = work / "cover"
    (folder / "raw").mkdir(parents=True, exist_ok=True)
    (folder / "rc").write_text(SETTINGS.format(folder=folder, context=CONTEXT))
    told = {"COVERAGE_PROCESS_START": str(folder / "rc"), CONTEXT: "", TABLE: str(folder / "tests.jsonl")}
    options = ["-q", "-p", "tests.mutation.covering", "-p", "no:cacheprovider", "--timeout=3000"]
    call([sys.executable, "-m", "pytest", *options, *tests], tree, environment(tree, work, **told))
    found = CoverageData(str(folder / "data"))
    found.read()
    for part in (folder / "raw").glob("data.*"):
        one = CoverageData(str(part))
        one.read()
        found.update(one)
        part.unlink()


def judged(mutant: Mutant, tree: Path, work: Path, known: Map, plain: bool = False) -> tuple[str, str]:
    """Verdict on a mutant: killed, timeout, survived or gone; and the test that noticed it.

    Plain: none on one that only the compiled code could show.
    """
    path = tree / mutant.file
    source, times = path.read_text(), path.stat()
    changed = found_again(mutant, source)
    if changed is None:
        return "gone", ""
    try:
        path.write_text(changed)
        for told, limit, tests in rounds(mutant, source, tree.parent / "compiled", known):
            if plain and "JOINTPLAY_CACHE" in told:
                return "", ""
            verdict, by = _asked(tree, environment(tree, work, **told), limit, tests)
            if verdict != "survived":
                return verdict, by + (INTERPRETED if "NUMBA_DISABLE_JIT" in told else "")
        return "survived", ""
    finally:
        path.write_text(source)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # as the compiled module remembers it
        for name in ("tmp", "compiled"):
            shutil.rmtree(tree.parent / name, ignore_errors=True)


def failing(tests: list[str], tree: Path, work: Path) -> set[str]:
    """Those of some tests that fail where nothing is broken, or are no more."""
    told = environment(tree, work)
    there = _names(tree, told)
    found = {name for name in tests if name.removesuffix(INTERPRETED) not in there}
    tests = [name for name in tests if name not in found]
    for some, more in (
        ([t for t in tests if not t.endswith(INTERPRETED)], {}),
        ([t.removesuffix(INTERPRETED) for t in tests if t.endswith(INTERPRETED)], {"NUMBA_DISABLE_JIT": "1"}),
    ):
        left = some
        while left:
            verdict, by = _asked(tree, told | more, 36000, ["-m", "", *left])
            if verdict == "survived":
                break
            if by not in left:
                raise RuntimeError(f"the tests cannot be run: {verdict} {by}")
            found.add(by + (INTERPRETED if more else ""))
            left = left[left.index(by) + 1 :]
    return found


def _names(tree: Path, told: dict[str, str]) -> set[str]:
    """Names of all tests."""
    code, said = tested(["-p", "no:cacheprovider", "-q", "--collect-only", "-m", ""], tree, told, 600)
    if code:
        raise RuntimeError(f"the tests cannot be collected\n{said[-500:]}")
    return {line for line in said.splitlines() if line.startswith("tests/") and "::" in line}


def rounds(mutant: Mutant, source: str, cache: Path, known: Map):
    """Variables, seconds and tests of each round, the cheapest first."""
    room, place = mutants.room(Path(mutant.file), Path("src")), (mutant.file, mutant.line, source)
    if room not in KERNELS:
        for long in (False, True):
            if tests := known.able(*place, long=long, interpreted=False):
                yield {}, _limit(tests), ["-m", "", *(t.name for t in tests)]
        return
    if tests := known.able(*place, interpreted=True):
        yield {"NUMBA_DISABLE_JIT": "1"}, _limit(tests), ["-m", "", *(t.name for t in tests)]
    fresh = {"JOINTPLAY_CACHE": str(cache)}
    for marks, tests in (
        ("not (long or nightly)", OWN[room]),
        ("not (long or nightly)", EXACT),
        ("long", ["tests/method", *EXACT]),
    ):
        yield fresh, 5400, ["-m", marks, *tests]


def _limit(tests) -> float:
    return 300 + TIMES * sum(t.seconds for t in tests)


def _asked(tree, told, limit, tests) -> tuple[str, str]:
    """What tests say of the copy as it stands."""
    listed = Path(told["TMPDIR"]) / "asked"
    listed.parent.mkdir(exist_ok=True)
    listed.write_text("\n".join(tests))
    options = [
        "-p",
        "no:cacheprovider",
        "-x",
        "-v",
        "--no-header",
        "--tb=line",
        f"--timeout={ENDLESS}",
        f"--basetemp={listed.parent}/pytest",
    ]
    code, said = tested([*options, f"@{listed}"], tree, told, limit)
    failed = re.search(r"^(?:FAILED|ERROR) (tests/.*?)(?: - |$)", said, re.MULTILINE)
    last = re.findall(r"^(tests/[^ ]+::.*?) *(?:PASSED.*|[+]+ Timeout.*)?$", said, re.MULTILINE)
    if code is None or (" Timeout " in said and not failed):
        return "timeout", last[-1] if last else ""
    if code in (0, 5):
        return "survived", ""
    if code == 4 and "ERROR: not found" in said:
        raise RuntimeError(f"the map names tests that are no more: make it anew\n{said[-500:]}")
    return "killed", failed[1] if failed else "at import" if code in (2, 3, 4) else f"exit code {code}"
