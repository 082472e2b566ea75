"""Study files gone wrong: tables and texts changed at random, with the whole grammar of study files."""

import datetime
import json
import re
import tomllib
from inspect import signature
from pathlib import Path

from jointplay import figures
from jointplay.kinds import KINDS
from tests.support import study_samples, sweep_samples

STUDIES = sorted((Path(__file__).parents[2] / "studies").rglob("*.toml"))
SAMPLES = (
    *(study_samples.TEXT, study_samples.WRITTEN_OUT, study_samples.BENT, study_samples.BENT_WRITTEN_OUT),
    *(study_samples.STRETCHED, *[study_samples.GUIDED] * 5),  # most of the grammar of parts is in the last
)
TEXTS = [*(path.read_text() for path in STUDIES), *SAMPLES, sweep_samples.CELLS, sweep_samples.CHAINS]
TABLES = [tomllib.loads(text) for text in TEXTS]
NAN, INF = float("nan"), float("inf")
ODD = [
    *(NAN, INF, -INF, 1e308, -1e308, 5e-324, 1e-40, 1e40, 0.0, -0.0, -1.0, 1e-9, 0.5, 1.5),
    *(0, 1, 2, 3, -1, 7, 1000, 10**6, 10**9, 10**12, 2**63, -(2**63), 10**30, 16**60, True, False),
    *(
        "",
        " ",
        "\0",
        "x" * 300,
        "B",
        "crank",
        "clearance",
        "gap",
        "up",
        "all",
        "none",
        "reset",
        "time",
        "log",
    ),
    *("ünïcödé", "\u202e", "𝒳", "a.b", "../x", "%s", "{}", "line\nbreak"),
    *([], [[]], [0], [1.0, 1.0], [NAN], [1, "a"], [{}], [{}, 1, "a"], ["up", "down"], [1e-5, 2e-5]),
    *([[0, 1], [2, 3]], [{"gap": 1.0}], list(range(1000)), [1, 2.0, True]),
    *({}, {"a": {"b": {"c": 1}}}, {"kind": "motor"}, {"kind": "contact"}, {"catalog": "lorenz"}, {"": 1}),
    *({"start": 1}, {"start": 1e-5, "stop": 5e-4, "num": 3}, {"crank_angle": 1.0}, {"kind": "plane"}),
    *({"kind": "separation"}, {"y": [0.0, 1.0], "v": [0.0, 1.0]}, {"exponent": 2}),
    *(datetime.date(2020, 1, 1), datetime.time(1, 2), datetime.datetime(2020, 1, 1, 1, 2)),
]
NUMBERS = [1e-5, 2.9e-5, 2.9e-4, 5e-4, 1e-3, 0.0, 0.1, 0.8, 1.0, 2.0, 3.0, 8.0, 15.0, -1.0, 1e6, 7e6]
PATHS = ["joints.B.contact.stiffness", "joints.B.clearance", "links.coupler.mass", "drive.rated_torque"]
PATHS += ["joints.C.friction", "joints[0].clearance", "links.crank.beam.modulus", "joints.B", "drive"]
WORDS = ["zip", "cases", "start", "stop", "num", "scale", "kind", "name", "clearance", "turns", "é"]
NUMS = [2, 3, 5, 3, 5, 40, 1, 0, -1, 2.0, 100_000, 10**6, 10**20, True, "3"]
OPTIONS = sorted({name for draw in figures.KINDS.values() for name in list(signature(draw).parameters)[1:]})


def dumped(table):
    """A table as TOML: plain values first, then each table under a header."""
    lines = [
        f"{key_of(key)} = {inline(value)}" for key, value in table.items() if not isinstance(value, dict)
    ]
    for key, value in table.items():
        if isinstance(value, dict):
            lines += [f"\n[{key_of(key)}]", *(f"{key_of(k)} = {inline(v)}" for k, v in value.items())]
    return "\n".join(lines) + "\n"


def key_of(key):
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else text_of(key)


def text_of(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def inline(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key_of(k)} = {inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if isinstance(value, bool | str):
        return text_of(value) if isinstance(value, str) else str(value).lower()
    return value.isoformat() if hasattr(value, "isoformat") else repr(value)


def copied(value):
    if isinstance(value, dict):
        return {key: copied(each) for key, each in value.items()}
    return [copied(each) for each in value] if isinstance(value, list) else value


def nodes(node):
    """Every place below a table or list, as (what holds it, key or index)."""
    found = [(node, key) for key in (list(node) if isinstance(node, dict) else range(len(node)))]
    below = (nodes(holder[key]) for holder, key in list(found) if isinstance(holder[key], dict | list))
    return found + [place for places in below for place in places]


def chosen(table, dice, fits=lambda holder, key: True):
    """One place of a table that fits; the table's own kind where none does."""
    places = [place for place in nodes(table) if fits(*place)]
    table.setdefault("kind", "response")
    return dice.choice(places or [(table, "kind")])


def misspelt(word, dice):
    i = dice.randrange(len(word) + 1)
    ways = [word[:i] + dice.choice("aeiß_.x ") + word[i:], word[:i] + word[i + 1 :], word[::-1], word.upper()]
    return dice.choice(ways)


def odd_value(table, dice):
    holder, key = chosen(table, dice)
    holder[key] = copied(dice.choice(ODD))


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
    value = holder.pop(key)
    homes = [table, *(h[k] for h, k in nodes(table) if isinstance(h[k], dict))]
    dice.choice(homes)[str(key)] = copied(value)


def nested(table, dice):
    holder, key = chosen(table, dice)
    value = holder[key]
    holder[key] = dice.choice([{str(key): value}, [value], {"value": value}, [value, copied(value)]])


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
    table["figure"] = {name: copied(dice.choice(ODD)) for name in names}
    if dice.random() < 0.8:
        table["figure"]["kind"] = dice.choice(list(figures.KINDS))


def vary(table, dice):
    """A `[vary]` in any of its forms, right or nearly so."""
    names = dice.sample(parameters(table, dice), dice.randint(1, 3))
    count, form = dice.randint(1, 4), dice.choice(["grid", "grid", "zip", "cases", "odd"])
    made = {name: values(dice) for name in names}
    if form == "zip":
        made = {name: dice.sample(NUMBERS, count) for name in names}
        made["zip"] = dice.choice([True, True, True, False, 1, "yes"])
    elif form == "cases":
        cases = [{name: dice.choice(NUMBERS) for name in names} for _ in range(count)]
        if dice.random() < 0.3:
            del dice.choice(cases)[names[0]]
        made = {"cases": cases}
    elif form == "odd":
        made[dice.choice([*names, *WORDS, ""])] = copied(dice.choice(ODD))
    table["vary"] = made


def parameters(table, dice):
    """Names that may be varied, some misspelt, some deep."""
    mechanism = table.get("mechanism")
    own = [k for k, v in mechanism.items() if isinstance(v, float)] if isinstance(mechanism, dict) else []
    names = list(dict.fromkeys([*own, *own, "clearance", "gear_ratio", "friction", dice.choice(PATHS)]))
    return [misspelt(name, dice) if dice.random() < 0.05 else name for name in names]


def values(dice):
    if dice.random() < 0.5:
        return dice.sample(NUMBERS, dice.randrange(5))
    found = {"start": dice.choice(NUMBERS), "stop": dice.choice(NUMBERS), "num": dice.choice(NUMS)}
    return found if dice.random() < 0.5 else found | {"scale": dice.choice(["log", "linear", "Log", 1])}


OF_TABLES = [odd_value, odd_value, other_number, renamed, removed, moved, nested, flattened, another_kind]
OF_TABLES += [another_part, another_part, another_figure, vary, vary, vary]


def changed_table(table, dice, most=3):
    """A copy with one to `most` changes."""
    table = copied(table)
    for _ in range(min(dice.choice([1, 1, 1, 2, 3]), most)):
        dice.choice(OF_TABLES)(table, dice)
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
        pairs = [(value, f"{before}.{key}" if before else key) for key, value in node.items()]
    else:
        pairs = [(value, f"{before}[{i}]") for i, value in enumerate(node)] if isinstance(node, list) else []
    return ([before] if before else []) + [path for value, key in pairs for path in key_paths(value, key)]


def change(table, dice):
    """A word for `--set`."""
    path = dice.choice(key_paths(table))
    path = misspelt(path, dice) if dice.random() < 0.2 else path
    return f"{path}={inline(copied(dice.choice(ODD)))}"
