"""Values for any key, right, nearly right and strange: from the checked signatures, and from studies.

A key's schema is that of its annotation, in a function, a record or a study file's table. What stands under a
key in some study is right too, in its place. Nearly right is a right value changed at a place. Whatever is
drawn depends on the dice alone.
"""

from __future__ import annotations

import datetime
import math
import random
import re
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from pydantic import BaseModel, TypeAdapter
from pydantic.errors import PydanticInvalidForJsonSchema, PydanticSchemaGenerationError

import jointplay as jp
from jointplay import figures
from jointplay.kinds import KINDS
from jointplay.solver.mechanism.signature import types_of
from tests.support import study_samples, sweep_samples

Dice = random.Random
Table = dict[str, Any]
STUDIES = sorted((Path(__file__).parents[2] / "studies").rglob("*.toml"))
SAMPLES = (
    *(study_samples.TEXT, study_samples.WRITTEN_OUT, study_samples.BENT, study_samples.BENT_WRITTEN_OUT),
    *(study_samples.STRETCHED, *[study_samples.GUIDED] * 5),  # most of the grammar of parts is in the last
)
TEXTS = [*(path.read_text() for path in STUDIES), *SAMPLES, sweep_samples.CELLS, sweep_samples.CHAINS]
TABLES = [tomllib.loads(text) for text in TEXTS]
NAN, INF = float("nan"), float("inf")
STRANGE = [  # what a study file can say
    *(NAN, INF, -INF, 1e308, -1e308, 1e300, 5e-324, 1e-300, 1e-40, 1e40, 1e12, 0.0, -0.0, -1.0, 1e-9, 0.5),
    *(0, 1, 2, 3, -1, 7, 1.5, 1000, 10**6, 10**9, 10**12, 2**63, -(2**63), 10**30, 16**60, True, False),
    *("", " ", "\0", "x" * 300, "ünïcödé", "\u202e", "𝒳", "a.b", "../x", "%s", "{}", "line\nbreak", "a", ":"),
    *("B", "crank", "ground", "clearance", "gap", "up", "all", "none", "reset", "time", "log", "angle"),
    *([], [[]], [0], [1], [1.0, 1.0], [1.0, 2.0], [NAN], [1, "a"], [{}], [{}, 1, "a"], ["up", "down"]),
    *([1e-5, 2e-5], [[0, 1], [2, 3]], [{"gap": 1.0}], list(range(1000)), [1, 2.0, True], ["angle"], ["z"]),
    *({}, {"a": {"b": {"c": 1}}}, {"a": 1}, {"kind": "motor"}, {"kind": "contact"}, {"catalog": "lorenz"}),
    *({"": 1}, {"start": 1}, {"start": 1e-5, "stop": 5e-4, "num": 3}, {"start": 0, "stop": 1, "num": 10**9}),
    *({"crank_angle": 1.0}, {"kind": "plane"}, {"kind": "separation"}, {"y": [0.0, 1.0], "v": [0.0, 1.0]}),
    *({"exponent": 2}, {"B": 1e-4}, {"Z": 1e-5}),
    *(datetime.date(2020, 1, 1), datetime.time(1, 2), datetime.datetime(2020, 1, 1, 1, 2)),
]
OWN = [  # and what only Python can
    *(None, 10**400, -(10**400), 10**5000, b"x", (), (1, 2), {1: 2}, {None: None}, {1, 2}, frozenset()),
    *(object(), print, int, range(3), "\ud800", 1j, Decimal(1), Fraction(1, 2), [None], [object()], math.nan),
    *(np.int64(3), np.float32(0.5), np.float64("nan"), np.bool_(True), np.longdouble(1), np.array(3)),
    *(np.array([1.0, 2.0]), np.array([]), np.array(["angle"]), np.array([None]), np.eye(2)),
    *(np.datetime64("2000-01-01"), np.timedelta64(1), {"B": np.float32(1e-4)}, xr.Dataset()),
    *(jp.CrankAngle(), jp.Pin(link="a")),
]
# words of pydantic, in which no error is to be told
FOREIGN = r"(Input|Keys?|Tuple|List|String|Dictionary|Object|Value|Unable) (should|is|error|to)\b"
NUMBERS = [1e-5, 2.9e-5, 2.9e-4, 5e-4, 1e-3, 0.0, 0.1, 0.8, 1.0, 2.0, 3.0, 8.0, 15.0, -1.0, 1e6, 7e6]
MANY = 100_000  # a count that may be as large only takes long: it is drawn small, or larger than it may be


def copied(value: Any) -> Any:
    """A table or list whose parts can be changed."""
    if isinstance(value, dict):
        return {key: copied(each) for key, each in value.items()}
    return [copied(each) for each in value] if isinstance(value, list) else value


def nodes(node: Any) -> list[tuple[Any, Any]]:
    """Every place below a table or list, as (what holds it, key or index)."""
    found = [(node, key) for key in (list(node) if isinstance(node, dict) else range(len(node)))]
    below = (nodes(holder[key]) for holder, key in list(found) if isinstance(holder[key], dict | list))
    return found + [place for places in below for place in places]


def chosen(table: Table, dice: Dice, fits: Callable[[Any, Any], bool] = lambda holder, key: True) -> Any:
    """One place of a table that fits; the table's own kind where none does."""
    places = [place for place in nodes(table) if fits(*place)]
    table.setdefault("kind", "response")
    return dice.choice(places or [(table, "kind")])


def _seen() -> dict[str, list[Any]]:
    """What stands under each key of the studies."""
    found = defaultdict(dict)
    for table in TABLES:
        for holder, key in nodes(table):
            if isinstance(key, str):
                found[key][repr(holder[key])] = holder[key]
    return {key: list(values.values()) for key, values in found.items()}


SEEN = _seen()
SEEN["over"] = SEEN["vary"]
WORDS = sorted(
    {x for values in SEEN.values() for x in values if isinstance(x, str) and re.fullmatch(r"[\w.:]{1,20}", x)}
)


@cache
def schemas(owner: Any) -> dict[str, Table]:
    """The schema of each argument of a function or a record that can be told by one."""
    if isinstance(owner, type) and issubclass(owner, BaseModel):
        whole = owner.model_json_schema()
        return {key: {"$defs": whole.get("$defs", {})} | each for key, each in whole["properties"].items()}
    found = {}
    for key, hint in types_of(owner).items():
        try:
            found[key] = TypeAdapter(hint).json_schema()
        except (PydanticInvalidForJsonSchema, PydanticSchemaGenerationError):
            continue
    return found


@cache
def everywhere() -> dict[str, list[Table]]:
    """The schemas that a key has anywhere: in kinds of study and in the records of mechanisms."""
    found = defaultdict(list)
    records = [each for each in vars(jp).values() if isinstance(each, type) and issubclass(each, BaseModel)]
    for owner in (*(kind.function for kind in KINDS.values()), *records):
        for key, schema in schemas(owner).items():
            found[key].append(schema)
    return found


OPTIONS = sorted({name for draw in figures.KINDS.values() for name in list(signature(draw).parameters)[1:]})


def accepted(schema: Table, dice: Dice, defs: Table | None = None) -> Any:
    """A value that a schema accepts, or one just beyond the bound of a number."""
    defs = schema.get("$defs", defs or {})
    if "$ref" in schema:
        return accepted(defs[schema["$ref"].rpartition("/")[2]], dice, defs)
    if ways := schema.get("anyOf") or schema.get("oneOf") or schema.get("allOf"):
        return accepted(dice.choice(ways), dice, defs)
    if "enum" in schema or "const" in schema:
        return dice.choice(schema.get("enum") or [schema.get("const")])
    kind = schema.get("type")
    if kind in ("integer", "number"):
        return _number(schema, dice, kind == "integer")
    if kind == "array":
        least, most = schema.get("minItems", 0), min(schema.get("maxItems", 4), 4)
        return [
            accepted(schema.get("items", {}), dice, defs)
            for _ in range(dice.randint(least, max(least, most)))
        ]
    if kind == "object":
        return dict(_members(schema, dice, defs))
    return {"boolean": dice.random() < 0.5, "null": None}.get(kind, dice.choice(WORDS))


def _number(schema: Table, dice: Dice, whole: bool) -> float:
    """A number near the least or the usual one; now and then at the least, or beyond what is accepted."""
    least = schema.get("minimum", schema.get("exclusiveMinimum"))
    most = schema.get("maximum", schema.get("exclusiveMaximum"))
    if dice.random() < 0.2:
        edges = [
            x
            for x in (least, None if least is None else least - 1, None if most is None else 2 * most + 1)
            if x is not None
        ]
        return dice.choice(edges or [0])
    if whole:
        return (least or 0) + dice.randrange(4)
    usual = schema.get("default") or dice.choice(NUMBERS)
    found = usual * dice.choice((1.0, 0.5, 1.01))
    below = least is not None and found < least
    return (
        least * 1.01
        if below and least
        else least + 0.01
        if below
        else found
        if most is None
        else min(found, most)
    )


def _members(schema: Table, dice: Dice, defs: Table) -> Iterator[tuple[str, Any]]:
    """Members of an object: what it needs, some others, and of an open one some words."""
    needed = schema.get("required", ())
    for key, each in schema.get("properties", {}).items():
        if key in needed or dice.random() < 0.2:
            yield key, accepted(each, dice, defs)
    if isinstance(more := schema.get("additionalProperties"), dict):
        for key in dice.sample(WORDS, dice.randint(1, 2)):
            yield key, accepted(more, dice, defs)


def right(key: str, dice: Dice, owner: Any = None) -> Any:
    """A value that a key has in some study, or that its schema accepts: its owner's, or any."""
    own = schemas(owner).get(key) if owner else None
    ways = [own] if own else everywhere().get(key, [])
    if key in SEEN and (not ways or dice.random() < 0.5):
        return copied(dice.choice(SEEN[key]))
    return accepted(dice.choice(ways), dice) if ways else dice.choice(WORDS)


def value(key: Any, dice: Dice, owner: Any = None, more: tuple[Any, ...] | list[Any] = ()) -> Any:
    """Any value for a key; `more` are strange ones that the door lets through beside those of files."""
    if not isinstance(key, str) or (drawn := dice.random()) < 0.5:
        return copied(dice.choice(more if more and dice.random() < 0.5 else STRANGE))
    found = right(key, dice, owner)
    if drawn > 0.8 and isinstance(found, dict | list) and found:
        holder, place = dice.choice(nodes(found))
        holder[place] = copied(dice.choice(STRANGE))
    return found
