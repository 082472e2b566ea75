"""Stored results that are damaged, mislabelled or of another version: shown, or refused in one sentence.

`python -m tests.results.damage 2000` damages so many files at random, and counts how showing them ended.
"""

from __future__ import annotations

import random
import sys
import tempfile
import warnings
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np

import jointplay as jp
from jointplay.display.errors import InputError, sealed
from jointplay.study.results import store
from tests.figures.test_pictures import PICTURES
from tests.fuzz.files import called, fault

PAPER = sorted((Path(__file__).parents[2] / "results" / "paper").glob("*.nc"))
LIMIT = 120.0  # s of CPU time
STRANGE = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, 1e-320)
TEXTS = ("", "$", "$x$ and $\\frac", "a\nb", "\x1b[2J", "nan", "0", "{", "name with\tmore", "ß" * 300)


def whole():
    """Names of results that are as they should be, and how to get them."""
    made = {name: make for name, make in PICTURES.items() if name != "mechanism"}
    made |= {f"motion {i}": _motion for i in range(10)}
    return {path.stem: lambda path=path: (jp.open(path), {}) for path in PAPER} | made


@cache
def _motion():
    """A motion that can be shown as it moves."""
    crank = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    return jp.simulate(crank, turns=2, samples_per_turn=60), {}


def variable(dice, dataset):
    return dice.choice(sorted(map(str, dataset.variables)))


def drop_variable(dice, dataset):
    return dataset.drop_vars(variable(dice, dataset))


def drop_attribute(dice, dataset):
    del dataset.attrs[dice.choice(sorted(dataset.attrs))]
    return dataset


def drop_attribute_of_variable(dice, dataset):
    attrs = dataset[variable(dice, dataset)].attrs
    if attrs:
        del attrs[dice.choice(sorted(attrs))]
    return dataset


def change_attribute(dice, dataset):
    name = dice.choice(["kind", "swept", "study", "title", "provenance", "mechanism", *sorted(dataset.attrs)])
    other = dice.choice(
        [*TEXTS, *STRANGE, 3, *jp.kinds.KINDS, np.arange(3.0), str(dataset.attrs.get(name))[:-9]]
    )
    return dataset.assign_attrs({name: other})


def change_attribute_of_variable(dice, dataset):
    name = variable(dice, dataset)
    key = dice.choice(["units", "long_name", "flag_values", "flag_meanings", *sorted(dataset[name].attrs)])
    dataset[name].attrs[key] = dice.choice([*TEXTS, *STRANGE, np.arange(3, dtype=np.int8)])
    return dataset


def change_type(dice, dataset):
    name = variable(dice, dataset)
    values = dataset[name].values
    kind = dice.choice(["U", np.float32, np.int64, np.int8, bool])
    with np.errstate(all="ignore"):
        try:
            other = values.astype(kind)
        except (ValueError, TypeError, OverflowError):
            other = np.full(values.shape, "text")
    return changed(dataset, name, other)


def changed(dataset, name, values):
    return dataset.assign({name: (dataset[name].dims, values, dataset[name].attrs)})


def strange_values(dice, dataset):
    name = variable(dice, dataset)
    values = np.array(dataset[name].values)
    if values.dtype.kind in "OU":
        other = values.astype(object)
        places = np.asarray(other.reshape(-1))
        places[: dice.randint(0, 3)] = dice.choice(TEXTS)
        return changed(dataset, name, places.reshape(values.shape).astype(str))
    flat = values.astype(float).ravel()
    flat[[dice.randrange(len(flat)) for _ in range(5)] if len(flat) and dice.random() < 0.5 else ...] = (
        dice.choice(STRANGE)
    )
    with np.errstate(all="ignore"):
        return changed(dataset, name, flat.reshape(values.shape).astype(values.dtype))


def shuffle_values(dice, dataset):
    name = variable(dice, dataset)
    order = np.random.default_rng(dice.randrange(99)).permutation(dataset[name].size)
    return changed(dataset, name, dataset[name].values.ravel()[order].reshape(dataset[name].shape))


def other_length(dice, dataset):
    dim = dice.choice(sorted(map(str, dataset.sizes)) or [""])
    return dataset.isel({dim: slice(0, dice.choice([0, 1, 2]))}) if dim else dataset


def one_entry(dice, dataset):
    dim = dice.choice(sorted(map(str, dataset.sizes)) or [""])
    return dataset.isel({dim: 0}) if dim and dataset.sizes[dim] else dataset


def rename(dice, dataset):
    name = dice.choice([variable(dice, dataset), *sorted(map(str, dataset.sizes))])
    return dataset.rename({name: dice.choice(["x", "time_2", "angle$b$"])})


def swap(dice, dataset):
    one, other = variable(dice, dataset), variable(dice, dataset)
    return dataset if one == other else dataset.rename({one: other, other: one})


def transpose(_, dataset):
    return dataset.transpose(*reversed(list(dataset.sizes)))


def new_labels(dice, dataset):
    texts = [name for name in dataset.coords if dataset[name].dtype.kind in "OU" and dataset[name].size]
    if not texts:
        return dataset
    name = dice.choice(sorted(map(str, texts)))
    values = [dice.choice(TEXTS) + str(i) * dice.randint(0, 1) for i in range(dataset[name].size)]
    return dataset.assign_coords(
        {name: (dataset[name].dims, np.array(values, dtype=str).reshape(dataset[name].shape))}
    )


DAMAGES = [
    drop_variable,
    drop_attribute,
    drop_attribute_of_variable,
    change_attribute,
    change_attribute_of_variable,
    change_type,
    strange_values,
    shuffle_values,
    other_length,
    one_entry,
    rename,
    swap,
    transpose,
    new_labels,
]


def _as_given(dataset):
    """A result sealed as an analysis gives it; only as much as a figure needs is none, and has no seal."""
    try:
        str(jp.summary(dataset))
    except InputError:
        return dataset
    return sealed(dataset)


def damaged(dice, dataset, path):
    """Write a result with one to three damages; in one of ten files bytes are cut off as well."""
    dataset, done = _as_given(dataset.copy(deep=True)), []
    for _ in range(dice.choice([1, 1, 2, 3])):
        damage = dice.choice(DAMAGES)
        try:
            dataset = damage(dice, dataset)
        except (ValueError, IndexError, KeyError, TypeError):  # it cannot be damaged so
            continue
        done.append(damage.__name__)
    try:
        store.write_result(dataset, path)
    except Exception:  # what cannot be stored is no file
        return None
    if dice.random() < 0.1:
        data = path.read_bytes()
        path.write_bytes(data[: dice.randrange(len(data))])
        done.append("cut")
    return done


def shown(dice, path, options):
    """How one way to show a file ended, in a word, or what is wrong with that."""
    out = path.with_name("out")
    ways = {
        "figure": ["figure", str(path), "--out", f"{out}.png"],
        "other figure": [
            "figure",
            str(path),
            "--out",
            f"{out}.pdf",
            "--kind",
            dice.choice(sorted(jp.figures.KINDS)),
        ],
        "report": ["report", str(path), "--out", f"{out}.html"],
        "mat": ["export", str(path), "--out", f"{out}.mat"],
        "csv": ["export", str(path), "--out", f"{out}.csv"],
        "animate": ["animate", str(path), "--out", f"{out}.png", "--set", "frames=2"],
    }
    if "kind" in options:
        ways["figure"] += ["--kind", options["kind"]]
    way = dice.choice([*ways, "figure", "summary", "summary", "summary", "mat", "csv"])
    if way == "summary":
        try:
            str(jp.summary(jp.open(path)))
            return way, "shown", None
        except InputError as error:
            return way, "refused", None if str(error).strip() else "says nothing"
    code, _, said = called(ways[way], LIMIT)
    if code == 0:
        return way, "shown", None
    return way, "refused", f"{code}\n{said}" if code != 2 else fault(code, "", said)


def run(files, seed=0, tell=lambda _: None):
    """Damage so many files; how showing them ended, counted, and all that is wrong."""
    dice, sound, counts, wrong = random.Random(seed), whole(), Counter(), []
    kept = {}
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        while counts.total() < files:
            name = dice.choice(sorted(sound))
            dataset, options = kept.setdefault(name, None) or sound[name]()
            kept[name] = dataset, options
            path, own = Path(folder) / "a.nc", dice.randrange(10**9)
            damages = damaged(random.Random(own), dataset, path)
            if damages is None:
                continue
            try:
                way, ended, fault_found = shown(random.Random(own + 1), path, options)
            except Exception as error:
                way, ended, fault_found = "summary", "raised", repr(error)
            counts[f"{way} {ended}"] += 1
            if fault_found:
                wrong.append(f"{name} {damages} {own} {way}: {fault_found}")
                tell(wrong[-1])
    return counts, wrong


def main(files=2000, seed=0):
    counts, wrong = run(int(files), int(seed), lambda line: print(line, flush=True))
    print(f"{counts.total()} damaged files: {len(wrong)} ended wrongly; {dict(sorted(counts.items()))}")
    return len(wrong)


if __name__ == "__main__":
    sys.exit(bool(main(*sys.argv[1:])))
