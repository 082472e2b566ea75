"""How many lines broken on purpose the tests notice: `python -m tests.mutation.sample VERB`.

The sample and its verdicts are the table beside this file. Nothing is changed in the working tree: mutants
stand in a copy of the last commit, with a cache of compiled code of its own. A run that was ended goes on.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from queue import SimpleQueue
from threading import Lock

from . import mutants, trial
from .chosen import Map

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TABLE = HERE / "sample.csv"
COLUMNS = ["file", "line", "operator", "occurrence", "before", "after", "verdict", "by", "explanation"]
NOTICED = ("killed", "timeout")


def read() -> list[dict]:
    """Rows of the table."""
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(file))


def write(rows: list[dict]) -> None:
    """Write the table whole, so that a kill leaves the old one or the new one."""
    fresh = TABLE.with_suffix(".tmp")
    with fresh.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    os.replace(fresh, TABLE)


def draw(options) -> None:
    """Draw a new sample; or new rows in place of those whose lines are no more, or behind the others."""
    rows, within = read(), [ROOT / place for place in options.within]
    sample = mutants.draw(ROOT / "src", options.size, options.seed, within)
    drawn = [dict.fromkeys(COLUMNS, "") | vars(mutant) for mutant in sample]
    write(_filled(rows, drawn) if options.gone else rows + _unknown(rows, drawn) if within else drawn)


def _unknown(rows: list[dict], drawn: list[dict]) -> list[dict]:
    known = {(row["file"], row["before"], row["after"]) for row in rows}
    return [row for row in drawn if (row["file"], row["before"], row["after"]) not in known]


def _is_gone(row: dict) -> bool:
    file = ROOT / row["file"]
    return not file.exists() or mutants.found_again(_mutant(row), file.read_text()) is None


def _mutant(row: dict) -> mutants.Mutant:
    return mutants.Mutant(*(int(row[k]) if str(row[k]).isdigit() else row[k] for k in COLUMNS[:6]))


def _filled(rows: list[dict], drawn: list[dict]) -> list[dict]:
    new = _unknown(rows, drawn)
    by_room = {name: iter([row for row in new if _room(row) == name]) for name in {*map(_room, rows)}}
    return [next(by_room[_room(row)]) if _is_gone(row) else row for row in rows]


def copied(work: Path) -> Path:
    """A copy of the last commit to break."""
    tree = work / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True)
    subprocess.run(["tar", "-x", "-C", str(tree)], input=archive.stdout, check=True)
    return tree


def cover(options) -> None:
    """Run tests under coverage, to know which line is whose; `tests` may name some of them or options."""
    trial.cover(copied(options.work), options.work, options.tests)


def run(options) -> None:
    """Try mutants that have no verdict yet, or one of those asked for, and no explanation."""
    if not any(_asked(row, options) for row in read()):
        print("every line has a verdict")
        return
    known, places, lock = Map(options.work / "cover", options.budget), SimpleQueue(), Lock()
    if not known.tests:
        raise SystemExit(f"which test runs which line is not known in {options.work}: begin with `map`")
    for job in range(options.jobs):
        places.put(copied(options.work / f"job{job}"))

    def tried(number: int, row: dict) -> None:
        mutant = _mutant(row)
        place = places.get()
        try:
            verdict, by = trial.judged(mutant, place, options.work, known, options.plain)
        finally:
            places.put(place)
        with lock:
            rows = read()  # explanations may have been written meanwhile
            rows[number] |= {"verdict": verdict, "by": by}
            write(rows)
        print(f"{number} {verdict} {mutant.file}:{mutant.line} {mutant.operator} {by}", flush=True)

    with ThreadPoolExecutor(options.jobs) as pool:
        trials = [pool.submit(tried, *each) for each in enumerate(read()) if _asked(each[1], options)]
        for each in as_completed(trials):
            each.result()


def _asked(row: dict, options) -> bool:
    of_room = not options.rooms or _room(row) in options.rooms
    return row["verdict"] in options.verdicts and not row["explanation"] and of_room


def check(options) -> None:
    """Run whatever noticed a mutant where nothing is broken; take back what tests that fail there said."""
    noted = sorted({row["by"] for row in read() if "::" in row["by"]})
    wrong = trial.failing(noted, copied(options.work), options.work)
    rows = read()
    write([row | ({"verdict": "", "by": ""} if row["by"] in wrong else {}) for row in rows])
    gone = sum(map(_is_gone, rows))
    print(f"fail by themselves or are no more: {sorted(wrong)}")
    print(f"{len(noted)} tests noticed a line, {len(wrong)} do no more; {gone} of {len(rows)} lines are gone")


def report(options) -> None:
    """Print how many were noticed, by rooms, and the survivors that nobody has explained."""
    rows = read()
    for room in [*sorted({_room(row) for row in rows}), ""]:
        some = [row for row in rows if room in ("", _room(row))]
        count = Counter("noticed" if row["verdict"] in NOTICED else row["verdict"] or "open" for row in some)
        count["explained"] = sum(bool(row["explanation"]) for row in some)
        tried = len(some) - count["gone"] - count["open"]
        share = count["noticed"] / max(1, tried)
        print(f"{room or 'all':12} {tried:4} tried, {share:4.0%} noticed  {dict(count)}")
    for row in rows:
        if row["verdict"] == "survived" and not row["explanation"]:
            print(f"{row['file']}:{row['line']}: {row['before']}  ->  {row['after']}")


def _room(row):
    return mutants.room(ROOT / row["file"], ROOT / "src")


def main(arguments=None) -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation.sample", description=__doc__)
    parser.add_argument("--work", type=Path, default=Path.home() / ".cache" / "jointplay-mutation")
    verbs = parser.add_subparsers(required=True)
    one = verbs.add_parser("draw", help=draw.__doc__)
    one.add_argument("--size", type=int, default=400)
    one.add_argument("--seed", type=int, required=True)
    one.add_argument("--gone", action="store_true", help="only in place of rows whose lines are no more")
    one.add_argument("--within", nargs="*", default=[], help="files and folders from which rows are added")
    one.set_defaults(do=draw)
    two = verbs.add_parser("map", help=cover.__doc__)
    two.add_argument("tests", nargs=argparse.REMAINDER, help="folders or files, then options of pytest")
    two.set_defaults(do=cover)
    three = verbs.add_parser("run", help=run.__doc__)
    three.add_argument("--verdicts", nargs="*", default=[""], help="as survived; else what has none yet")
    three.add_argument("--rooms", nargs="*", default=[])
    three.add_argument("--budget", type=float, default=300.0, help="seconds of tests in a round")
    three.add_argument("--plain", action="store_true", help="leave out the rounds that compile anew")
    three.add_argument("--jobs", type=int, default=1, help="mutants at a time")
    three.set_defaults(do=run)
    verbs.add_parser("check", help=check.__doc__).set_defaults(do=check)
    verbs.add_parser("report", help=report.__doc__).set_defaults(do=report)
    options = parser.parse_args(arguments)
    options.work = options.work.resolve()
    options.do(options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
