"""A motion is the same in a mirror, turned, in other units, under other names, begun a turn later.

Random mechanisms (tests.support.features) are followed as they are and in every view of
tests.support.transformations: quantities, events and tangents must be those of the table. Motions are short,
since contacts part neighbours: a twin, whose masses differ by `TWIN`, tells how far a view may be off by the
rounding of its inputs. Where that is more than `SAME`, before or behind an event, a scene is not compared
any further, and counted.
"""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis import tangents
from jointplay.analysis.starts import state_names
from jointplay.solver.mechanism.assemble import assemble
from tests.support.driven import by_tangents
from tests.support.features import LEVELS, fits, scene
from tests.support.linkages import altered, jointed
from tests.support.tangent_map import tangent_map
from tests.support.transformations import MIRROR, OTHER, TABLE, factor, scaled

RTOL = 1e-12
SAME = 1e-7
SAMPLES = 16
TWIN = 1e-11
BALANCED = 1e-7  # of the energy's range: what may be missing in its balance
MOTION = ["angle", "angular_velocity", "angular_acceleration"]
TOUCH = ["journal_x", "journal_y", "penetration", "normal_velocity", "tangential_velocity"]
TOUCH += ["normal_force", "tangential_force"]
FEW = {  # structures of the default tests
    "rigid impacts": ("profile", "restitution", "none", "bearing", "tilted", "rigid"),
    "remembering": ("torque", "flores", "tanh", "slider_pin", "force_angle", "rigid"),
    "bent": ("cycle", "none", "none", "four_bar", "spring", "sine"),
    "corners": ("speed", "kelvin_voigt", "coulomb", "guide", "torque_time", "rigid"),
}
KEYS = ("drive", "law", "friction", "joint", "load", "elastic")
DEFAULT = [(name, seed) for name in FEW for seed in range(8)][:30]
STRUCTURES, EACH = 100, 5  # of the nightly ones


def chosen(levels, start="turned"):
    """A choice of features."""
    return dict(zip(KEYS, levels, strict=True)) | {"analysis": "response", "way": "single", "start": start}


def drawn(number):
    """A random choice, valid by construction."""
    random = np.random.default_rng([34, number])
    while True:
        choice = {name: str(random.choice(levels)) for name, levels in LEVELS.items()}
        choice |= {"analysis": "response", "way": "single"}
        if fits(choice):
            return choice


def words(mechanism):
    """What is recorded."""
    found = MOTION + TOUCH * bool(mechanism.contacts) + ["deflection"] * bool(mechanism.elastic_links)
    found += ["reaction_x", "reaction_y"] * any(joint.ideal for joint in mechanism.joints)
    found += ["energy", "energy_residual"]
    return found + ["drive_torque"] * bool(mechanism.drive)


def run(mechanism, initial, times):
    """A motion at these times, its quantities over (time, label), and its events."""
    how = {"duration": float(times[-1]), "at": times, "record": words(mechanism), "initial": initial or None}
    found = jp.simulate(mechanism, rtol=RTOL, **how)
    assert int(found.status) == 0, found.attrs
    assert abs(found.energy_residual.values).max() < BALANCED * np.ptp(found.energy.values)
    return found


def events(found, time=1.0, names=lambda name: name):
    """Events as (time, name, kind), those of one instant in order of names."""
    labels = [names(str(name)) for name in found.joint.values] if "joint" in found else []
    kinds = found.event_kind.flag_meanings.split()
    rows = zip(found.event_time.values, found.event_joint.values, found.event_kind.values, strict=True)
    return [(float(t) * time, labels[int(j)], kinds[int(k)]) for t, j, k in rows]


def alike(one, other, span):
    """Whether two lists of events tell the same, those within a millionth of the span in any order."""
    if sorted(row[1:] for row in one) != sorted(row[1:] for row in other):
        return False
    by = lambda rows: sorted(rows, key=lambda row: (row[1], row[0]))  # noqa: E731
    return all(
        abs(a[0] - b[0]) < 1e-6 * span and a[2] == b[2] for a, b in zip(by(one), by(other), strict=True)
    )


def off(found, plain, view, crank):
    """How far a motion is from what another view of the plain one is: the worst word and its share."""
    values = {word: plain[word].values for word in plain.data_vars if "time" in plain[word].dims}
    worst = ("", 0.0)
    for word in words_of(plain):
        dims = plain[word].dims
        labels = [str(name) for name in plain[dims[1]].values] if len(dims) > 1 else []
        wanted = view.seen(word, values, labels)
        if not labels:
            pairs = [(found[word].values, wanted)]
        else:
            seen = found[word].transpose("time", dims[1])
            pairs = [(seen.sel({dims[1]: view.names(x)}).values, wanted[:, i]) for i, x in enumerate(labels)]
        size = np.abs(wanted).max()
        for ours, theirs in pairs:
            apart = ours - theirs
            if word in ("angle", "contact_angle"):
                apart = apart - np.round(apart / np.pi / 2) * np.pi * 2
                size = 1.0
            share = np.abs(apart).max() / max(size, 1e-300)
            if share > worst[1]:
                worst = (word, float(share))
    return worst


def words_of(found):
    """Recorded quantities over time."""
    return [
        w for w in (*MOTION, *TOUCH, "deflection", "reaction_x", "reaction_y", "drive_torque") if w in found
    ]


def compared(choice, seed, views=TABLE):
    """Compare a mechanism with each view of it; what was not compared, with the reason."""
    made, left = scene(choice, seed), []
    times = np.linspace(0.0, made.duration, SAMPLES + 1)[1:] * (1 - 1e-3 * np.sin(np.arange(1, SAMPLES + 1)))
    plain = run(made.mechanism, made.initial, times)
    own = events(plain)
    moved, where = scaled(mass=1.0).inputs(made.mechanism, made.initial)
    heavier = altered(moved, gravity=moved.gravity * (1 + TWIN) + TWIN)
    twin = run(heavier, where, times)
    same = alike(events(twin), own, times[-1])
    apart = off(twin, plain, TABLE["a turn before"], made.mechanism.crank)[1] if same else np.inf
    if apart > SAME / 10:
        return [f"twins part by {apart:.1e}"]
    for name, view in views.items():
        if why := unseen(name, made):
            left.append(f"{name}: {why}")
            continue
        mechanism, initial = view.inputs(made.mechanism, made.initial)
        found = run(mechanism, initial, times * view.time)
        seen = [(t, n, kind) for t, n, kind in events(plain, view.time, view.names)]
        assert alike(events(found), seen, times[-1] * view.time), (name, events(found), seen)
        word, share = off(found, plain, view, made.mechanism.crank)
        assert share < SAME, (name, word, share)
    return left


def unseen(name, made):
    """Why a mechanism is not shown in a view."""
    drive = made.mechanism.drive
    if name == "mirrored" and drive and drive.kind == "motor":
        return "a motor turns anticlockwise"
    if name == "renamed" and drive is None and made.mechanism.links[0].name != made.mechanism.crank:
        return "no drive says which link is the crank"
    return ""


def cheap(name):
    """Views of a default test: other names are compiled anew, and seen once."""
    return {key: view for key, view in TABLE.items() if key != "renamed" or name == ("remembering", 0)}


@pytest.mark.parametrize(
    ("name", "seed"),
    DEFAULT,
)
def test_a_mechanism_moves_alike_in_every_view(name, seed):
    left = compared(chosen(FEW[name]), seed, cheap((name, seed)))
    assert not left


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(STRUCTURES))
def test_a_random_mechanism_moves_alike_in_every_view(number):
    """Five of one structure; twins that part are counted, and few."""
    choice, parted, seen = drawn(number), 0, 0
    for seed in range(EACH * number, EACH * number + EACH):
        views = {key: view for key, view in TABLE.items() if key != "renamed" or seed == EACH * number}
        left = compared(choice, seed, views)
        parted += any(why.startswith("twins") for why in left)
        seen += len(views) - len(left)
    assert parted < EACH, "no motion of this structure can be compared"
    assert seen > 0


STATES_OF = {"remembering": [("mirrored", MIRROR), ("in other units", TABLE["in other units"])]}


@pytest.mark.nightly
@pytest.mark.parametrize("name", FEW)
def test_tangents_and_derivatives_are_those_of_every_view(name):
    """The map of differences of states, and derivatives of the end by gravity."""
    made = scene(chosen(FEW[name]), 1)
    model = assemble(made.mechanism, made.initial)
    names, by = state_names(model), {"gravity": made.mechanism.gravity}
    plain = tangent_map(model, made.duration, 1e-11)
    slope = by_tangents(made.mechanism, by, made.duration, made.initial)[0, : len(names)]
    for key, view in STATES_OF["remembering"]:
        mechanism, initial = view.inputs(made.mechanism, made.initial)
        other = assemble(mechanism, initial)
        S = np.array([view.states(each) for each in names])
        M = tangent_map(other, made.duration * view.time, 1e-11)
        unit = tangents.scales(other)
        wanted = S[:, None] * plain / S
        assert off_maps(M * unit / unit[:, None], wanted * unit / unit[:, None]) < 1e-6, key
        length = 1.0 if view is MIRROR else factor("m/s²", OTHER)
        found = by_tangents(mechanism, {"gravity": mechanism.gravity}, made.duration * view.time, initial)
        assert off_maps(found[0, : len(names)] / unit, S * slope / length / unit) < 1e-6, key


def off_maps(one, other):
    """The largest difference over the largest entry."""
    return np.abs(one - other).max() / np.abs(other).max()


@pytest.mark.parametrize("name", FEW)
def test_what_is_sampled_changes_no_motion(name):
    """Even samples, chosen times, windows, own points of the integrator: one motion."""
    made = scene(chosen(FEW[name]), 2)
    how = {"rtol": RTOL, "record": words(made.mechanism), "initial": made.initial}
    period = assemble(made.mechanism, made.initial).period
    turns = made.duration / period
    even = jp.simulate(made.mechanism, turns=turns, samples_per_turn=round(24 / turns), **how)
    few = jp.simulate(made.mechanism, duration=made.duration, at=even.time.values[[5, 17]], **how)
    own = jp.simulate(made.mechanism, turns=turns, steps=True, **how)
    window = (0.3 * turns, 0.8 * turns)
    part = jp.simulate(
        made.mechanism, windows=[window], turns=turns, samples_per_turn=round(24 / turns), **how
    )
    assert events(even) == events(few) == events(own)
    begin, end = (x * period for x in window)
    assert events(part) == [row for row in events(even) if begin <= row[0] <= end]
    for word in words_of(even):
        size = np.abs(even[word]).max() + 1e-300
        assert np.abs(few[word].values - even[word].values[[5, 17]]).max() <= 1e-12 * size, word
        ends = own[word].values[-1] - even[word].values[-1]
        assert np.abs(ends).max() <= 1e-9 * size, word
    for counter in ("n_steps", "n_evaluations", "n_events"):
        assert len({int(each[counter]) for each in (even, few, own, part)}) == 1, counter


CONSERVATIVE = {"hertz": {"stiffness": 3e9}, "restitution": {"parameters": {"restitution": 1.0}}}


@pytest.mark.parametrize("law", [pytest.param("hertz", marks=pytest.mark.nightly), "restitution"])
def test_a_motion_without_losses_goes_back(law):
    """From its end with all speeds reversed, by the same events backwards, to its start."""
    made = scene(chosen(("speed", law, "none", "bearing", "tilted", "rigid")), 3)
    contact = jp.Contact(law=law, **CONSERVATIVE[law])
    mechanism = jointed(made.mechanism, loose=True, contact=contact)
    how = {"rtol": RTOL, "record": MOTION[:2], "duration": made.duration}
    there = jp.simulate(mechanism, at=[0.0, made.duration], initial=made.initial, **how)
    back = altered(mechanism, drive=mechanism.drive.model_copy(update={"speed": -mechanism.drive.speed}))
    by_link = {
        word: dict(zip(there.link.values.tolist(), there[word].values[-1], strict=True))
        for word in MOTION[:2]
    }
    turned = {
        key: {k: float(v) * sign for k, v in by_link[key].items()}
        for key, sign in zip(MOTION, (1, -1), strict=False)
    }
    again = jp.simulate(back, at=[made.duration], initial=turned, **how)
    assert len(there.event) > 1
    opposite = {"contact": "separation", "separation": "contact", "impact": "impact"}
    reverse = [(made.duration - t, n, opposite[kind]) for t, n, kind in events(there)[::-1]]
    assert [row[1:] for row in events(again)] == [row[1:] for row in reverse]
    times = [[row[0] for row in rows] for rows in (events(again), reverse)]
    assert times[0] == pytest.approx(times[1], abs=1e-7 * made.duration)
    assert again.angle.values[-1] == pytest.approx(there.angle.values[0], abs=SAME)
    assert -again.angular_velocity.values[-1] == pytest.approx(
        there.angular_velocity.values[0], rel=SAME, abs=1e-5
    )
