"""First and later runs, from a checkout and from a release's wheel, beside those of another commit.

    python -m tests.benchmarks.first_runs [COMMIT] [--rounds N] [--only NAME ...]

Each run is a process of its own. Cold ones begin with an empty cache; those of a wheel have the loops that it
brings. The sources take turns, and medians are printed with the least and the most. A commit that brings no
loops runs cold from its wheel as from its checkout, and is left out there. A further structure costs what a
process that has run one mechanism takes for the first turn of another, its equations derived and compiled.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from time import perf_counter

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-m", "jointplay"]
QUICKSTART = [*COMMAND, "run", str(ROOT / "studies" / "quickstart.toml"), "--fresh"]
SCENE = "jp.catalog.chunmei2002(gear_ratio=3.0)"
LYAPUNOV = f"jp.lyapunov({SCENE}, turns=50, transient=10)"
LANES = (
    f"jp.bifurcation({SCENE}, over={{'clearance': [2e-5 + 1e-6 * i for i in range(16)]}}, direction='reset',"
    " turns=20, transient=10, n_jobs=1, ensemble=True)"
)
OTHERS = {
    "slider-crank": "jp.catalog.slider_crank(clearance={'B': 1e-4})",
    "two plays": "jp.catalog.chunmei2002(gear_ratio=3.0, clearance={'B': 2.9e-5, 'C': 2.9e-5})",
    "elastic, four modes": "jp.catalog.chunmei2002(gear_ratio=3.0, elastic=('coupler',), elements=2)",
}
FURTHER = f"""
import resource, time
import jointplay as jp
def spent():
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
jp.simulate({SCENE}, turns=1)
began = spent()
jp.simulate({{}}, turns=0.01)
print(spent() - began)
"""
COLD = {
    "run quickstart": QUICKSTART,
    "lyapunov": [sys.executable, "-c", f"import jointplay as jp; {LYAPUNOV}"],
    "sweep in lanes": [sys.executable, "-c", f"import jointplay as jp; {LANES}"],
}
WARM = {
    "run quickstart": QUICKSTART,
    "check": [*COMMAND, "check", str(ROOT / "studies" / "quickstart.toml")],
    "--help": [*COMMAND, "--help"],
}


def timed(command: list[str], source: Path, cache: Path) -> tuple[float, float, str]:
    """Seconds of wall and of CPU time of a command with the package of a folder, and its last line."""
    changes = {"PYTHONPATH": str(source), "JOINTPLAY_CACHE": str(cache)}
    with tempfile.TemporaryDirectory() as folder:
        began, before = perf_counter(), os.times()
        done = subprocess.run(
            command, env=os.environ | changes, cwd=folder, check=True, capture_output=True, text=True
        )
        wall, after = perf_counter() - began, os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return wall, cpu, done.stdout.strip().rpartition("\n")[2]


def cold(command: list[str], source: Path) -> float:
    """Wall time of a command that finds an empty cache."""
    with tempfile.TemporaryDirectory() as cache:
        return timed(command, source, Path(cache))[0]


def further(mechanism: str, source: Path) -> float:
    """CPU time of a further structure's first turn."""
    with tempfile.TemporaryDirectory() as cache:
        timed([sys.executable, "-c", FURTHER.format(SCENE)], source, Path(cache))
        return float(timed([sys.executable, "-c", FURTHER.format(mechanism)], source, Path(cache))[2])


def wheel(tree: Path, folder: Path) -> Path | None:
    """Folder into which the wheel of a tree is installed, below a new folder; None if it brings no loops."""
    if not (tree / "src" / "jointplay" / "solver" / "codegen" / "prebuilt.py").exists():
        return None
    built = folder / "tree"
    shutil.copytree(tree / "src", built / "src", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", ".gitignore", "README.md", "LICENSE"):
        shutil.copy(tree / name, built)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    target = ("--target", str(folder / "installed"))
    for command in (
        [sys.executable, "-m", "jointplay.solver.codegen.prebuilt"],
        [*pip, "wheel", "--no-deps", "--wheel-dir", str(folder), str(built)],
        [*pip, "install", "--no-deps", "--no-index", "--find-links", str(folder), *target, "jointplay"],
    ):
        changes = {"PYTHONPATH": str(built / "src")}
        subprocess.run(command, env=os.environ | changes, cwd=folder, check=True, capture_output=True)
    return folder / "installed"


@contextmanager
def checkout(commit: str, folder: Path) -> Iterator[Path]:
    """Work tree of a commit."""
    git = ["git", "-C", str(ROOT), "worktree"]
    subprocess.run([*git, "add", "--quiet", "--detach", str(folder), commit], check=True)
    try:
        yield folder
    finally:
        subprocess.run([*git, "remove", "--force", str(folder)], check=True)


def table(head: str, rows: dict, sources: dict[str, Path], rounds: int) -> None:
    """Print what each row takes from each source, in turns: median (least to most)."""
    print(f"\n| {head} | " + " | ".join(sources) + " |\n|" + " --- |" * (len(sources) + 1), flush=True)
    for name, measure in rows.items():
        found = {source: [] for source in sources}
        for _ in range(rounds):
            for source, path in sources.items():
                found[source].append(measure(path))
        cells = (f"{median(each):.2f} ({min(each):.2f} to {max(each):.2f})" for each in found.values())
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    """Measure this tree's last commit, and another."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("commit", nargs="?", help="commit to compare with")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", nargs="+", default=["cold", "wheel", "further", "warm"])
    given = parser.parse_args()
    with ExitStack() as until_done:
        folder = Path(until_done.enter_context(tempfile.TemporaryDirectory()))
        commits = {"this commit": "HEAD"} | ({given.commit: given.commit} if given.commit else {})
        trees = {
            name: until_done.enter_context(checkout(commit, folder / f"tree {at}"))
            for at, (name, commit) in enumerate(commits.items())
        }
        _measure(trees, folder, given)


def _measure(trees: dict[str, Path], folder: Path, given: argparse.Namespace) -> None:
    sources = {name: tree / "src" for name, tree in trees.items()}
    starts = {name: lambda at, run=run: cold(run, at) for name, run in COLD.items()}
    if "cold" in given.only:
        table("cold, from a checkout: s of wall time", starts, sources, given.rounds)
    if "wheel" in given.only:
        made = {name: wheel(tree, folder / f"wheel {tree.name}") for name, tree in trees.items()}
        brought = {name: at for name, at in made.items() if at}
        table("cold, from a wheel: s of wall time", starts, brought, given.rounds)
    if "further" in given.only:
        rows = {name: lambda at, it=it: further(it, at) for name, it in OTHERS.items()}
        table("a further structure: s of CPU time", rows, sources, given.rounds)
    if "warm" in given.only:
        caches = {at: _made(folder / f"cache {at.parent.name}") for at in sources.values()}
        rows = {name: lambda at, run=run: timed(run, at, caches[at])[1] for name, run in WARM.items()}
        for at in sources.values():
            timed(QUICKSTART, at, caches[at])
        table("warm: s of CPU time", rows, sources, given.rounds)


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


if __name__ == "__main__":
    main()
