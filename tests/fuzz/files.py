"""Study files gone wrong: tables and texts changed at random, with the whole grammar of study files.

Every shipped study and the samples of the tests are changed at random. `jointplay check` has to accept each,
in silence or with doubts, or refuse it by lines of a key path, what was given and what is accepted; soon, and
nothing else. A share of what is accepted is planned and run too, each motion over a few hundred steps. Where
kinds are named, files of these alone are changed, and all that are accepted are run.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import re
import tempfile
from pathlib import Path

from jointplay import cli, figures
from jointplay.kinds import KINDS

from .loop import MAX_STEPS, SHORT, tried, within
from .values import FOREIGN, NUMBERS, OPTIONS, STRANGE, TABLES, TEXTS, chosen, copied, nodes, schemas, value

LIMIT, RUN_LIMIT = 10.0, 60.0  # s of CPU, a file
RUN_SHARE = 0.25  # of what is accepted
CELLS = 12  # at most, of what is run
SAID = rf"(?P<key>\S.*?): got (?P<given>.*?); (?!{FOREIGN})(?P<accepted>.+)"
LINE = re.compile(rf"  ({SAID}|and [\d,]+ more)")
PATHS = ["joints.B.contact.stiffness", "joints.B.clearance", "links.coupler.mass", "drive.rated_torque"]
PATHS += ["joints.C.friction", "joints[0].clearance", "links.crank.beam.modulus", "joints.B", "drive"]
WORDS = ["zip", "cases", "start", "stop", "num", "scale", "kind", "name", "clearance", "turns", "é"]
NUMS = [2, 3, 5, 3, 5, 40, 1, 0, -1, 2.0, 100_000, 10**6, 10**20, True, "3"]


def dumped(table):
    """A table as TOML: plain values first, then each table under a header."""
    lines = [
        f"{key_of(key)} = {inline(given)}" for key, given in table.items() if not isinstance(given, dict)
    ]
    for key, given in table.items():
        if isinstance(given, dict):
            lines += [f"\n[{key_of(key)}]", *(f"{key_of(k)} = {inline(v)}" for k, v in given.items())]
    return "\n".join(lines) + "\n"


def key_of(key):
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else text_of(key)


def text_of(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def inline(given):
    if isinstance(given, dict):
        return "{" + ", ".join(f"{key_of(k)} = {inline(v)}" for k, v in given.items()) + "}"
    if isinstance(given, list):
        return "[" + ", ".join(map(inline, given)) + "]"
    if isinstance(given, bool | str):
        return text_of(given) if isinstance(given, str) else str(given).lower()
    return given.isoformat() if hasattr(given, "isoformat") else repr(given)


def misspelt(word, dice):
    i = dice.randrange(len(word) + 1)
    ways = [word[:i] + dice.choice("aeiß_.x ") + word[i:], word[:i] + word[i + 1 :], word[::-1], word.upper()]
    return dice.choice(ways)


def said(key, dice, owner=None):
    """A value that TOML can say: it knows no null."""
    found = value(key, dice, owner)
    return found if "None" not in repr(found) else dice.choice([x for x in STRANGE if x is not None])


def another_value(table, dice):
    holder, key = chosen(table, dice)
    kind = table.get("kind")
    known = isinstance(kind, str) and kind in KINDS and holder is table.get("analysis")
    holder[key] = said(key, dice, KINDS[kind].function if known else None)


def another_key(table, dice):
    """A keyword that the kind has, or any analysis."""
    kind = table.get("kind") if dice.random() < 0.8 else dice.choice(list(KINDS))
    if isinstance(table.setdefault("analysis", {}), dict) and isinstance(kind, str) and kind in KINDS:
        function = KINDS[kind].function
        key = dice.choice(sorted(schemas(function)))
        table["analysis"][key] = said(key, dice, function)


def other_number(table, dice):
    holder, key = chosen(table, dice, lambda h, k: type(h[k]) in (int, float))
    factor = dice.choice([-1, 0, 1e-3, 1e3, 0.5, 2, 10, 1e30, 1e-30])
    holder[key] = factor * holder[key] if type(holder[key]) in (int, float) else factor


def renamed(table, dice):
    holder, key = chosen(table, dice, lambda h, k: isinstance(k, str))
    holder[misspelt(key, dice) if dice.random() < 0.6 else dice.choice(WORDS)] = holder.pop(key)


def removed(table, dice):
    holder, key = chosen(table, dice)
    del holder[key]


def moved(table, dice):
    holder, key = chosen(table, dice)
    given = holder.pop(key)
    homes = [table, *(h[k] for h, k in nodes(table) if isinstance(h[k], dict))]
    dice.choice(homes)[str(key)] = copied(given)


def nested(table, dice):
    holder, key = chosen(table, dice)
    given = holder[key]
    holder[key] = dice.choice([{str(key): given}, [given], {"value": given}, [given, copied(given)]])


def flattened(table, dice):
    holder, key = chosen(table, dice, lambda h, k: isinstance(h, dict) and isinstance(h[k], dict))
    below = holder.pop(key)
    dotted = dice.random() < 0.5
    holder.update({f"{key}.{k}" if dotted else k: v for k, v in below.items()} if type(below) is dict else {})


def another_kind(table, dice):
    table["kind"] = dice.choice(list(KINDS))


def another_part(table, dice):
    """A table, or a key or two, of another study; often of its kind too."""
    other = copied(dice.choice(TABLES))
    part = dice.choice(["analysis", "analysis", "mechanism", "figure", "vary", "integrator"])
    mine, theirs = table.get(part), other.get(part)
    if dice.random() < 0.5 and isinstance(mine, dict) and isinstance(theirs, dict):
        mine.update(dice.sample(list(theirs.items()), min(len(theirs), 2)))
    elif part in other:
        table[part] = theirs
    if dice.random() < 0.5:
        table["kind"] = other["kind"]


def another_figure(table, dice):
    names = dice.sample(OPTIONS, dice.randrange(3))
    table["figure"] = {name: said(name, dice) for name in names}
    if dice.random() < 0.8:
        table["figure"]["kind"] = dice.choice(list(figures.KINDS))


def vary(table, dice):
    """A `[vary]` in any of its forms, right or nearly so."""
    names = dice.sample(parameters(table, dice), dice.randint(1, 3))
    count, form = dice.randint(1, 4), dice.choice(["grid", "grid", "zip", "cases", "odd"])
    made = {name: axis(dice) for name in names}
    if form == "zip":
        made = {name: dice.sample(NUMBERS, count) for name in names}
        made["zip"] = dice.choice([True, True, True, False, 1, "yes"])
    elif form == "cases":
        cases = [{name: dice.choice(NUMBERS) for name in names} for _ in range(count)]
        if dice.random() < 0.3:
            del dice.choice(cases)[names[0]]
        made = {"cases": cases}
    elif form == "odd":
        made[dice.choice([*names, *WORDS, ""])] = said("vary", dice)
    table["vary"] = made


def parameters(table, dice):
    """Names that may be varied, some misspelt, some deep."""
    mechanism = table.get("mechanism")
    own = [k for k, v in mechanism.items() if isinstance(v, float)] if isinstance(mechanism, dict) else []
    names = list(dict.fromkeys([*own, *own, "clearance", "gear_ratio", "friction", dice.choice(PATHS)]))
    return [misspelt(name, dice) if dice.random() < 0.05 else name for name in names]


def axis(dice):
    """Values of one parameter: a list, or a range."""
    if dice.random() < 0.5:
        return dice.sample(NUMBERS, dice.randrange(5))
    found = {"start": dice.choice(NUMBERS), "stop": dice.choice(NUMBERS), "num": dice.choice(NUMS)}
    return found if dice.random() < 0.5 else found | {"scale": dice.choice(["log", "linear", "Log", 1])}


CHANGES = [
    another_value,
    another_value,
    another_key,
    other_number,
    renamed,
    removed,
    moved,
    nested,
    flattened,
]
CHANGES += [another_kind, another_part, another_part, another_figure, vary, vary, vary]


def changed_table(table, dice, most=3):
    """A copy with one to `most` changes."""
    table = copied(table)
    for _ in range(min(dice.choice([1, 1, 1, 2, 3]), most)):
        dice.choice(CHANGES)(table, dice)
    return table


def changed_text(text, dice):
    """Characters changed, or lines doubled, dropped and swapped."""
    if dice.random() < 0.5:
        start = dice.randrange(len(text))
        new = "".join(
            dice.choice(['"', "[", "]", "=", "\n", ".", "é", "\0", "9", "-", "e", "𝒳"]) for _ in range(3)
        )
        return text[:start] + new[: dice.randrange(4)] + text[start + dice.randrange(8) :]
    lines = text.splitlines()
    i, j = dice.randrange(len(lines)), dice.randrange(len(lines))
    lines[i : i + dice.randrange(3)] = [lines[j]]
    return "\n".join(lines) + "\n"


def key_paths(node, before=""):
    """Every key path of a parsed text, tables included."""
    if isinstance(node, dict):
        pairs = [(each, f"{before}.{key}" if before else key) for key, each in node.items()]
    else:
        pairs = [(each, f"{before}[{i}]") for i, each in enumerate(node)] if isinstance(node, list) else []
    return ([before] if before else []) + [path for each, key in pairs for path in key_paths(each, key)]


def change(table, dice):
    """A word for `--set`."""
    path = dice.choice(key_paths(table))
    found = said(path.rpartition(".")[2], dice)
    path = misspelt(path, dice) if dice.random() < 0.2 else path
    return f"{path}={inline(found)}"


def mutated(dice, numbers):
    """A text, its table where it is one still, and words for the command line."""
    i = dice.choice(numbers)
    if dice.random() < 0.2:
        return changed_text(TEXTS[i], dice), {}, []
    table = changed_table(TABLES[i], dice)
    words = ["--set", change(TABLES[i], dice)] if dice.random() < 0.15 else []
    return dumped(table), table, words


def called(words, limit):
    """Exit code, output and errors of a command; the traceback in place of a code."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code, raised = within(limit, cli.main, words)
    return raised or code, out.getvalue(), err.getvalue()


def fault(code, out, err):
    """What is wrong with how `check` ended; None if nothing is."""
    if code == 0:
        doubted = all(line.startswith("warning ") for line in err.splitlines())
        return None if out and doubted else "accepted, but not in silence"
    if code != 2:
        return f"ended with {code}"
    first, *lines = err.splitlines()
    wrong = [line for line in lines if not LINE.fullmatch(line)]
    return None if first.startswith("wrong input") and lines and not wrong else f"says {wrong or err}"


def brief(table):
    """Changes that make a run short; None where it cannot be, or would compile."""
    mechanism, analysis = table.get("mechanism", {}), table.get("analysis", {})
    if table.get("kind") not in SHORT or "catalog" not in mechanism or "elastic" in mechanism:
        return None
    if {"duration", "windows", "at", "plane", "error"} & set(analysis):
        return None
    keywords = SHORT[table["kind"]].items()
    return [f"integrator.max_steps={MAX_STEPS}", *(f"analysis.{key}={inline(x)}" for key, x in keywords)]


def ran(path, table, folder):
    """How planning and running an accepted study ended, None if well; and whether it was tried."""
    changes = brief(table)
    code = 2 if changes is None else called(["check", path, "--set", *changes], LIMIT)[0]
    if code != 0:
        return None if code == 2 else f"check of a short one ended with {code}", False
    words = ["--out", folder, "--jobs", "1", "--set", *changes]
    planned = called(["plan", path, *words], RUN_LIMIT)
    if planned[0] not in (0, 2):
        return f"plan ended with {planned[0]}", True
    cells = re.search(r"^cells +(\d+):", planned[1], re.MULTILINE)
    if cells and int(cells[1]) > CELLS:
        return None, True
    code, _, err = called(["run", path, "--fresh", *words], RUN_LIMIT)
    return (None if code in (0, 1) else f"run ended with {code}\n{err}"), True


def main(files=10_000, seed=0, *kinds):
    """Try so many files; tell what was wrong, and how long the slowest took."""
    numbers = [n for n, table in enumerate(TABLES) if not kinds or table.get("kind") in kinds]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "study.toml")
        for n in numbers:  # what checking compiles, so that none is slow for that
            Path(path).write_text(TEXTS[n])
            assert called(["check", path], 10 * RUN_LIMIT)[0] == 0, TEXTS[n]

        def case(number):
            dice = random.Random(f"{seed} {number}")
            text, table, words = mutated(dice, numbers)
            Path(path).write_bytes(text.encode("utf-8", "surrogatepass"))
            code, out, err = called(["check", path, *words], LIMIT)
            wrong = fault(code, out, err)
            ends = [{0: "accepted", 2: "refused"}.get(code, "raised")]
            if code == 0 and not words and (kinds or dice.random() < RUN_SHARE):
                wrong, begun = ran(path, table, os.path.join(folder, "out"))
                ends += ["run"] * begun
            return f"{' '.join(words)}\n{text}", ends, wrong

        return tried("file", seed, range(files), case)
