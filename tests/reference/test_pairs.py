"""Every pair of features once, by the program and by bodies that share no equation with it.

The scenes are an all-pairs design (tests.support.features.covering) over drives, laws of contact and of
friction, joints, loads, elastic links, starts, analyses and ways of following, read from the program's
tables. Pairs that do not go together have a reason. Motions are short: a few contacts of each.
"""

from __future__ import annotations

import pytest

from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.solver.codegen.lanes import EXCLUSIONS
from jointplay.solver.mechanism.assemble import assemble
from tests.support.features import LAYOUTS, LEVELS, covering, of, pairs, scene
from tests.support.second_run import RUNS

DESIGN = covering()
CLOSE = {"response": 5e-6, "section": 1e-7, "gradient": 1e-5}
IN_LANES = 1e-4  # of motions whose tolerance is 1e-8
BEHIND_REBOUNDS = (
    2e-4  # of a derivative, whose bodies' differences have their rounding behind a row of rebounds
)
LATE = 1e-9  # s

LONG = {
    30,
    48,
    54,
    83,
    86,
    102,
    108,
    143,
    175,
}  # scenes that are quick to follow, but whose equations are long to compile
KNOWN = {}  # scenes by number whose numbers are wrong today, and why


def quick(choice):
    """Whether a scene is soon followed: rigid links, one motion, joints whose equations are short."""
    short = choice["elastic"] == "rigid" and choice["joint"] not in ("group", "guide", "moving_guide")
    return short and choice["analysis"] != "gradient" and choice["way"] == "single"


def marked(number, choice):
    """A long scene, or a nightly one."""
    marks = [pytest.mark.long if quick(choice) and number not in LONG else pytest.mark.nightly]
    marks += [pytest.mark.xfail(strict=True, reason=KNOWN[number])] if number in KNOWN else []
    return pytest.param(number, id="-".join([str(number), *choice.values()]), marks=marks)


@pytest.mark.parametrize("number", [marked(*each) for each in enumerate(DESIGN)])
def test_features_together_are_what_the_bodies_say(number):
    choice = DESIGN[number]
    apart = RUNS[choice["analysis"]](scene(choice, number))
    apart.pop("met", None)
    late, bound = apart.pop("events", 0.0), CLOSE[choice["analysis"]]
    bound = IN_LANES if choice["way"] == "lanes" else BEHIND_REBOUNDS if apart.pop("rests", 0.0) else bound
    assert late < LATE
    assert {word: x for word, x in apart.items() if not x < bound} == {}


def test_every_pair_that_goes_together_is_in_a_scene():
    table = pairs()
    fit, seen = {pair for pair, why in table.items() if not why}, set().union(*map(of, DESIGN))
    assert seen == fit
    assert len(fit) > 1700
    assert len(DESIGN) < 220
    assert 0.1 * len(DESIGN) <= sum(map(quick, DESIGN)) <= 0.25 * len(DESIGN)


def test_every_level_is_in_some_pair_and_every_refusal_has_a_reason():
    table = pairs()
    fit = {level for pair, why in table.items() if not why for level in pair}
    assert fit == {(name, level) for name, levels in LEVELS.items() for level in levels}
    assert all(isinstance(why, str) for why in table.values())
    lanes = {why for pair, why in table.items() if ("way", "lanes") in pair and why}
    assert lanes - {"lanes make section points"} <= {*EXCLUSIONS}


@pytest.mark.nightly
def test_what_is_said_to_fit_is_accepted():
    for number, choice in enumerate(DESIGN):
        started(choice, number)


REFUSED = [  # pairs that the program refuses, of those that do not go together
    {"law": "johnson", "joint": "guide"},
    {"law": "restitution", "friction": "tanh"},
    {"joint": "group", "elastic": "stretching"},
]


@pytest.mark.parametrize("pair", REFUSED, ids=lambda pair: "-".join(pair.values()))
def test_what_is_said_not_to_fit_is_refused(pair):
    assert pairs()[frozenset(pair.items())]
    plain = {
        "drive": "speed",
        "law": "kelvin_voigt",
        "friction": "none",
        "joint": "slider_pin",
        "load": "none",
    }
    plain |= {"elastic": "rigid", "analysis": "response", "way": "single", "start": "zero"}
    choice = plain | ({"law": "none"} if not LAYOUTS[pair.get("joint", "slider_pin")].loose else {}) | pair
    with pytest.raises(InputError):
        started(choice)


def started(choice, number=1):
    """The model of a scene."""
    made = scene(choice, number)
    return assemble(made.mechanism, made.initial or None)


def test_analyses_of_the_design_are_kinds_of_study():
    """All others are made of sections and of derivatives."""
    assert {*LEVELS["analysis"]} <= {*KINDS}
