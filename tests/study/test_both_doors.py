"""Wrong keywords of every kind, drawn at random: Python and study files refuse the same in the same words."""

import random
import re
from dataclasses import replace

import pytest

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.study.file import validate
from jointplay.study.models import ELSEWHERE, INTEGRATOR, TABLES

PAIR = {"catalog": "impact_pair", "gap": 3.0, "restitution": 0.8}
LINKAGE = {"catalog": "chunmei2002", "clearance": 2.9e-4}
BENT = LINKAGE | {"elastic": ["coupler"]}
MECHANISMS = {  # where a test system will not do
    "readings": LINKAGE,
    "claims": LINKAGE,
    "stress": {"catalog": "chunmei2002", "speed": 80.0},  # which it refuses
    "scheme_comparison": BENT,
    "assess": LINKAGE,
}
NEEDED = {
    "basins": {"plane": {"y": [-1.0, 1.0], "v": [0.0, 1.0]}},
    "attractors": {"region": {"y": [-1.0, 1.0], "v": [0.0, 1.0]}},
    "tipping": {"region": {"y": [-1.0, 1.0], "v": [0.0, 1.0]}},
    "continuation": {"parameter": "gap", "range": [2.0, 9.0]},
    "curve": {"plane": {"gap": [2.0, 9.0], "restitution": [0.7, 0.9]}},
    "stress": {"scenes": 3},
    "tolerances": {"spreads": {"gap": {"normal": [3.0, 0.1]}}},
}
ODD = [
    *(0, 1, 2, 7, 2.5, -1, 1e-3, 0.5, 1.5, 1e3, 1e12, 10**30, float("nan"), float("inf"), True, False, "all"),
    *("", "x", "section", "up", "hann", "normal_force", "clearance", "B", [], [1], [0.5, 0.1], [0.1, 0.5]),
    *(
        [1e-5, 1e-8],
        [3, 1],
        [[0, 1]],
        [[1, 0]],
        ["up", "up"],
        ["x"],
        ["angle"],
        ["rigid"],
        ["a", "q"],
        [[1.0]],
    ),
    *({}, {"crank_angle": 1.0}, {"crank_angle": "a"}, {"crank_angel": 1.0}, {"kind": "plane"}, {"kind": "x"}),
    *({"kind": "contact"}, {"kind": "contact", "joint": "Q"}, {"kind": "crank_angle", "angle": 1e9}),
    *(
        {"y": [0.0, 1.0], "v": [1.0, 0.0]},
        {"y": {"start": 0.0, "stop": 1.0}, "v": 3},
        {"x": [0, 1], "v": [0, 1]},
    ),
    *(
        {"angle": {"crank": 1.0}},
        [{"crank_angle": 1.0}, [1.0]],
        {"kind": "plane", "quantity": "y", "value": 0},
    ),
]
ROUNDS = 40


def drawn(kind, dice):
    """Keywords, some of them odd; with no steps allowed, so that none is ever right as a whole."""
    known = [name for name in KINDS[kind].function.fields() if name not in (*ELSEWHERE, "max_steps")]
    chosen = dice.sample(known, min(len(known), dice.randint(1, 4)))
    return NEEDED.get(kind, {}) | {name: dice.choice(ODD) for name in chosen} | {"max_steps": 0}


def told(call, *values, **keywords):
    """Each problem as key, value and what would be accepted; a study's keys without the table."""
    with pytest.raises(InputError) as caught:
        call(*values, **keywords)
    found = caught.value.problems
    if call is validate:
        keywords = {table: keyword for keyword, table in TABLES.items()}
        found = [replace(p, key=re.sub("^\\w+", lambda m: keywords.get(m[0], m[0]), p.key)) for p in found]
    return sorted(
        (re.sub("^(analysis|integrator)[.]", "", p.key), repr(p.given), str(p.expected)) for p in found
    )


@pytest.mark.parametrize("kind", KINDS)
def test_both_doors_refuse_the_same_in_the_same_words(kind):
    dice, row, table = random.Random(kind), KINDS[kind], MECHANISMS.get(kind, PAIR)
    mechanism = getattr(jp.catalog, table["catalog"])(**{k: v for k, v in table.items() if k != "catalog"})
    varied = {"gap": [2.9, 3.1]} if "over" in row.function.fields() else {}
    for _ in range(ROUNDS):
        given = drawn(kind, dice)
        tables = {"integrator": {key: given[key] for key in given if key in INTEGRATOR}}
        tables |= {TABLES[key]: given[key] for key in given if key in TABLES}
        tables |= {"analysis": {key: given[key] for key in given if key not in (*INTEGRATOR, *TABLES)}}
        study = (
            {"kind": kind, "name": "x", "mechanism": table} | tables | ({"vary": varied} if varied else {})
        )
        said = told(row.function, mechanism, **given, **({"over": varied} if varied else {}))
        assert told(validate, study) == said, given
        assert "max_steps" in {key for key, *_ in said}


@pytest.mark.parametrize(
    ("kind", "table", "given"),
    [
        ("response", PAIR, {"turns": 2.5, "transient": 0.5}),
        ("response", LINKAGE, {"turns": 1, "initial": {"crank_angle": 1.0, "branch": "lower"}}),
        ("scheme_comparison", BENT, {"clearance": 1e-5, "tolerances": 1e-6, "initial": {"crank_angle": 1.0}}),
        ("work_precision", PAIR, {"tolerances": 1e-6, "peers": "LSODA"}),
    ],
)
def test_what_python_accepts_a_study_accepts(kind, table, given):
    record = validate({"kind": kind, "name": "x", "mechanism": table, "analysis": given})
    keywords = record.keywords()
    assert {key: keywords[key] for key in given} == {
        key: (value,) if isinstance(value, str | float) and key not in ("turns", "transient") else value
        for key, value in given.items()
    }
    said = told(KINDS[kind].function, record.mechanism, **given, progress="none")
    assert [key for key, *_ in said] == ["progress"]


@pytest.mark.parametrize("kind", KINDS)
def test_an_unknown_keyword_is_unknown_at_both_doors(kind):
    row, table = KINDS[kind], MECHANISMS.get(kind, PAIR)
    for name in ("trans", *ELSEWHERE):
        study = {"kind": kind, "name": "x", "mechanism": table, "vary": {}, "analysis": {name: 1}}
        assert f"analysis.{name}" in {
            key if "." in key else f"analysis.{key}" for key, *_ in told(validate, study)
        }
    said = {key: expected for key, _, expected in told(row.function, trans=1)}
    assert said["trans"].startswith("there is no such key;")
