"""Scenes of `tests.support.features` by the program and by the bodies of `tests.support.multibody`."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import partial

import numpy as np

import jointplay as jp
from jointplay.analysis.starts import state_names
from jointplay.solver.mechanism.assemble import assemble as model_of
from jointplay.solver.method.codes import Status
from tests.support.driven import bundle_along, quotient
from tests.support.features import Scene
from tests.support.multibody import Now, Prismatic, System
from tests.support.multibody_loads import Held
from tests.support.multibody_records import from_mechanism, started
from tests.support.multibody_run import assemble, followed

RTOL, SECOND = 1e-11, 1e-11
IN_LANES = 1e-8
STEPS = 4e-4, 2e-3, 1e-2  # of differences, shares: small ones show integration errors, large ones curvature
MANY = 12  # events of compliant contacts in a motion that is differentiated
LEAST = 1e-5  # where one meets other events, shorter ones down to this
EXACT = 1e-6  # of derivatives: what is nearer to a difference is not compared with the next
ROW_END = 1e-6  # s before a rest: which rebound is the last one there is rounding
EARLY = 10  # times: bodies rest when a rebound is slow, the program when the row's sum has run out
UNSURE = 0.01  # the most by which differences with two steps may be apart
SAMPLES = 12
UNBALANCED = 50.0  # times what is missing in the balance of energy counts: 1e-7 of its range is too much
MOTION = ("angle", "angular_velocity", "angular_acceleration")
TOUCH = ("penetration", "normal_velocity", "tangential_velocity", "normal_force", "tangential_force")
WORDS = {  # of the bodies' events, by the mode before
    ("release", None): "separation",
    ("reload", None): "contact",
    ("separation", "released"): "reopening",
}
INSTANT = 1e-12  # s: a pair of events of one touch that undo each other by rounding
NEARBY, BEFORE = 1e-9, 0.98  # s, of one event by both programs; share of the time until one
AHEAD = 0.3  # rad, to the section


def begin(scene: Scene, mechanism=None) -> tuple[System, np.ndarray]:
    """The bodies and their state at the start; angles of the program's start are a rough guess."""
    mechanism, given = mechanism or scene.mechanism, scene.initial
    if "angle" not in given:
        return started(mechanism, scene.crank_angle, given.get("crank_speed"))
    system = from_mechanism(mechanism, scene.crank_angle)
    ideal = [joint for joint in system.joints if joint.play is None]
    guides = [joint for joint in ideal if isinstance(joint, Prismatic)]
    loose = next(joint for joint in system.joints if joint.play)

    def along(guide):
        """The gap has no part along a guide: for starts off the centre."""
        d = np.array([np.cos(guide.bearing.direction), np.sin(guide.bearing.direction)])

        def gap(now):
            r, J, *_ = now.between(loose.journal, loose.bearing)
            return d @ r, d @ J

        return Held("along", gap)

    placed = {part.body for part in system.drives} | {joint.journal.body for joint in guides}
    turned = {
        name: (x, given["angular_velocity"][name]) for name, x in given["angle"].items() if name not in placed
    }
    closing = System(system.bodies, ideal, [*system.drives, *map(along, guides)])
    return system, assemble(closing, given["angle"], turned)


def second(scene: Scene, times, mechanism=None, rtol=SECOND):
    """The bodies, their states at times, and by touch their events as the program calls them, with times."""
    system, y = begin(scene, mechanism)
    states, events = followed(system, y, times, rtol)
    named = [[] for _ in system.touches(Now(system, 0.0, y))]
    for event in events:
        mode = event.mode if event.mode == "released" else None
        word = WORDS.get((event.kind, mode), WORDS.get((event.kind, None), event.kind))
        named[event.touch].append((word, event.time))
    return system, states, named


def lasting(events):
    """Events of a touch without pairs that undo each other at once, and without a row's last rebounds."""
    found = []
    for event in events:
        while event[0] == "rest" and found and found[-1][0] == "impact" and event[1] - found[-1][1] < ROW_END:
            found.pop()
        if found and event[1] - found[-1][1] < INSTANT and event[0] != "rest":
            found.pop()
        else:
            found.append(event)
    return found


def by_contact(found, names) -> list[list[tuple[str, float]]]:
    """The program's events of each contact."""
    words = found.event_kind.flag_meanings.split()
    rows = zip(found.event_joint.values, found.event_kind.values, found.event_time.values, strict=True)
    rows = [(int(j), words[int(k)], float(t)) for j, k, t in rows]
    return [[(kind, t) for j, kind, t in rows if j == i] for i in range(len(names))]


def off(one, other) -> float:
    """The largest difference over the largest value."""
    one, other = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    size = max(np.abs(other).max(initial=0.0), 1e-300)
    return float(np.abs(one - other).max(initial=0.0) / size)


def response(scene: Scene) -> dict[str, float]:
    """How far the program's response and the bodies are apart: shares of the largest values; events, s."""
    mechanism = scene.mechanism
    contacts = mechanism.contacts
    random = np.random.default_rng(1)
    times = np.append(np.sort(random.uniform(0.02, 1.0, SAMPLES)), 1.0) * scene.duration
    words = [*MOTION, *TOUCH * bool(contacts), *["deflection"] * bool(mechanism.elastic_links)]
    pins = [joint.name for joint in mechanism.joints if joint.ideal]
    words += ["reaction_x", "reaction_y"] * bool(pins) + ["drive_torque"] * bool(mechanism.drive)
    words += ["energy", "energy_residual"]
    how = {"duration": scene.duration, "at": times, "record": words, "initial": scene.initial or None}
    found = jp.simulate(mechanism, rtol=RTOL, **how)
    assert int(found.status) == 0, str(found.attrs)
    system, states, events = second(scene, times)
    apart = _motion(found, system, states)
    missing = abs(found.energy_residual.values).max() / np.ptp(found.energy.values)
    apart["energy_residual"] = UNBALANCED * missing
    solved = [system.solve(x.t, x.y, x.modes, x.memory) for x in states]
    if contacts:
        rows = np.array(
            [[[x.u, x.v_n, x.v_t, F_n, F_t] for _, x, F_n, F_t in each.touches] for each in solved]
        )
        order = [contacts.index(name) for name in _touches(mechanism)]
        for i, word in enumerate(TOUCH):
            apart[word] = off(found[word].values[:, order], rows[:, :, i])
        ours = by_contact(found, contacts)
        for theirs, k in zip(events, order, strict=True):
            one, other = lasting(ours[k]), lasting(theirs)
            assert [kind for kind, _ in one] == [kind for kind, _ in other], (one, other)
            late = [
                abs(a[1] - b[1]) / (EARLY if a[0] == "rest" else 1) for a, b in zip(one, other, strict=True)
            ]
            apart["events"] = max([apart.get("events", 0.0), *late])
        apart["met"] = float(sum(map(len, events)))
    for word, axis in (("reaction_x", 0), ("reaction_y", 1)) if pins else ():
        mine = [[each.reactions[pin][axis] for pin in found.pin.values] for each in solved]
        apart[word] = off(found[word].values, mine)
    if system.drives:
        apart["drive_torque"] = off(found.drive_torque.values, [-x.reactions["drive"][2] for x in solved])
    for link in mechanism.elastic_links:
        beam, own = system.beams[link.name]
        mine = [beam.deflection(x.y[own]) for x in states]
        apart[f"deflection {link.name}"] = off(found.deflection.sel(link=link.name).values, mine)
    return apart


def _touches(mechanism) -> list[str]:
    """Names of contacts in the order of the bodies' touches."""
    return [name for joint in mechanism.joints for name in joint.contacts]


def _motion(found, system, states, dim="time") -> dict[str, float]:
    """Angles and speeds (and accelerations, where recorded) of every link."""
    apart, n = {}, system.n
    for i, word in enumerate(MOTION[:2]):
        mine = [[x.y[i * n + system.at[name] + 2] for name in found.link.values] for x in states]
        apart[word] = off(found[word].transpose(dim, "link").values, mine)
    if MOTION[2] in found:
        solved = [system.solve(x.t, x.y, x.modes, x.memory).acceleration for x in states]
        mine = [[a[system.at[name] + 2] for name in found.link.values] for a in solved]
        apart[MOTION[2]] = off(found[MOTION[2]].transpose(dim, "link").values, mine)
    return apart


def section(scene: Scene) -> dict[str, float]:
    """The same of a section point by crank angle, and by how much the bodies' crank misses it, rad."""
    level = scene.crank_angle + AHEAD
    lanes = scene.choice["way"] == "lanes"
    words = [*MOTION[:2], *(["journal_x", "journal_y"] if scene.mechanism.contacts else [])]
    how = {"turns": 1, "record": words, "initial": scene.initial or None, "ensemble": lanes}
    cut = jp.CrankAngle(angle=level)
    found = jp.poincare(scene.mechanism, cut, rtol=IN_LANES if lanes else RTOL, **how)
    assert int(found.status) == 0, str(found.attrs)
    if lanes:
        assert int(found.followed) == found.followed.flag_meanings.split().index("in_lanes")
    times = found.time.values[:1]
    system, states, events = second(scene, times)
    apart = _motion(found.isel(turn=[0]), system, states, "turn")
    apart["crank"] = abs(states[0].y[system.at[scene.mechanism.crank] + 2] - level)
    apart["met"] = float(sum(map(len, events)))
    return apart


def derivative(scene: Scene) -> dict[str, float]:
    """The same of derivatives of the end by gravity and by a mass, against the bodies' differences.

    Also whether a row of rebounds ended in rest: bodies rebound there some thirty times, each located anew.

    Differences of fourth order with one step after the other, until one is met. Where none is, a derivative
    as near to one as the nearest two are to each other is met as far as they know. Motions with other events
    have no difference; of each parameter there must be one. Where the program says that derivatives
    end, the bodies must have the reason there, and what is compared ends a little before.
    """
    heavy = scene.mechanism.links[-1]
    values = {"gravity": scene.mechanism.gravity, f"links.{heavy.name}.mass": heavy.mass}
    scene = _of_a_few_events(scene)
    names = state_names(model_of(scene.mechanism, scene.initial or None))
    bundle = bundle_along(scene.mechanism, values, scene.duration, scene.initial or None)
    if (status := bundle.advance()) == Status.NO_DERIVATIVE:
        assert _ends_derivatives(scene, bundle.time), f"no derivative from {bundle.time} s on"
        scene = replace(scene, duration=BEFORE * bundle.time)
        bundle = bundle_along(scene.mechanism, values, scene.duration, scene.initial or None)
        status = bundle.advance()
    assert status == 0
    found = bundle.vectors
    links, apart = [link.name for link in scene.mechanism.links], {}
    for (key, value), row in zip(values.items(), found, strict=True):

        def end(at, key, met):
            other = scene.mechanism.replace(**{key: at})
            system, states, events = second(scene, [scene.duration], other, SECOND / 10)
            met.append([_lasting_kinds(each) for each in events])
            there = range(2, 3 * len(system.bodies), 3)
            return states[0].y[[*there, *(system.n + i for i in there)]]

        differences, missed, shares, least = [], {}, [*STEPS], STEPS[0]
        while shares:
            share, met = shares.pop(0), []
            least = min(least, share)
            difference = quotient(partial(end, key=key, met=met), value, share * value)
            if not all(each == met[0] for each in met):  # and so would longer ones
                shares = [least / 4] if least / 4 > LEAST else []
                continue
            differences.append(difference)
            apart["rests"] = float(any("rest" in each for each in met[0]))
            apart["met"] = float(sum(map(len, met[0])))
            for k, word in enumerate(("theta", "w")):
                there = [(i, f"{word}_{x}") for i, x in enumerate(links) if f"{word}_{x}" in names]
                ours = [row[names.index(name)] for _, name in there]
                at = [k * len(links) + i for i, _ in there]
                if there:
                    missed[f"{word} by {key}"] = _missed(ours, [each[at] for each in differences])
            if all(each < EXACT for each in missed.values()):
                break
        assert differences, f"motions whose {key} differs have other events"
        apart |= missed
    return apart


def _of_a_few_events(scene: Scene) -> Scene:
    """A scene that ends between two events, behind `MANY` of them, where these are contacts and no rebounds.

    Behind more, derivatives have grown beyond what differences can tell.
    """
    how = {"duration": scene.duration, "at": [scene.duration], "initial": scene.initial or None}
    found = jp.simulate(scene.mechanism, rtol=RTOL, **how)
    times, kinds = found.event_time.values, found.event_kind.flag_meanings.split()
    rebounds = {"impact", "rest"} & {kinds[int(kind)] for kind in found.event_kind.values}
    if rebounds or len(times) <= MANY:
        return scene
    return replace(scene, duration=float(times[MANY - 1] + times[MANY]) / 2)


def _ends_derivatives(scene: Scene, time: float) -> bool:
    """Whether then two rigid touches of the bodies meet, or one rebounds by less than its restitution."""
    _, events = followed(*begin(scene), [time + NEARBY], SECOND)
    met = [each for each in events if each.kind == "impact" and abs(each.time - time) < NEARBY]
    return len({each.touch for each in met}) > 1 or any(each.share < 1 for each in met)


def _lasting_kinds(events) -> list[str]:
    """Kinds of a contact's events but for rebounds that end in rest, whose number is rounding."""
    kept = []
    for kind, _ in events:
        while kind == "rest" and kept[-1:] == ["impact"]:
            kept.pop()
        kept.append(kind)
    return kept


def _missed(ours, differences) -> float:
    """By how much the nearest of some differences misses a derivative; 0 where they do not know it better."""
    missed = min(off(ours, each) for each in differences)
    unsure = min((off(*pair) for pair in itertools.combinations(differences, 2)), default=0.0)
    return 0.0 if missed < unsure < UNSURE else missed


RUNS = {"response": response, "section": section, "gradient": derivative}
