"""Mechanisms in plain Python: their equations at a point, and their motion by another program's method."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from jointplay.solver.codegen import outputs
from jointplay.solver.equations.write import system
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import Joint, Link, Mechanism, Pin
from tests.support.plain import Point, masks, plain


def bar(name, length=0.4, mass=1.5, inertia=0.1, **more):
    """A link whose mass centre is not halfway."""
    return Link(**{"name": name, "length": length, "mass": mass, "inertia": inertia, "centre": 0.15} | more)


def pendulum(link=None, **more):
    """One link on the ground, without gravity unless `more` says so."""
    joint = Joint(name="O", journal=Pin(link="arm"), bearing=Pin(link="ground", point=(0.1, -0.2)))
    return Mechanism(links=(link or bar("arm"),), joints=(joint,), **{"gravity": 0.0} | more)


def double(clearance=0.0, **more):
    """Two links, one on the other; with a clearance the two together float."""
    play = {"clearance": clearance, "radius": 0.01, "contact": {"stiffness": 1e6, "damping": 1.0}}
    joints = (
        Joint(name="O", journal=Pin(link="arm"), bearing=Pin(link="ground", point=(0.1, -0.2)), **play),
        Joint(name="A", journal=Pin(link="hand"), bearing=Pin(link="arm", at=0.4)),
    )
    return Mechanism(links=(bar("arm"), bar("hand", inertia=0.06)), joints=joints, **{"gravity": 0.0} | more)


def at(mechanism, angles, speeds):
    """The start of an open chain."""
    names = [link.name for link in mechanism.links]
    return {
        "angle": dict(zip(names, angles, strict=True)),
        "angular_velocity": dict(zip(names, speeds, strict=True)),
    }


def seen(model, state, t=0.0, modes=None, numbers=None):
    """Every output at a state, in these modes of its contacts; nothing touches, if left out.

    `numbers` stand in place of the model's own.
    """
    functions = plain(model.structure)
    given = dict(zip(functions.STATE, [t, *state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True)) | (numbers or {})
    words = [f"{mask}_{name}" for name in model.joints for mask in ("touch", "slip", "stick")]
    given |= dict(zip(words, masks(modes or ["free"] * len(model.joints)), strict=False))
    return {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}


def forces(model, state, t=0.0):
    """The right-hand sides of the equations of motion, contacts left out."""
    equations = system(model.structure)
    values = dict(zip(equations.parameters, model.numbers, strict=True))
    values |= dict(zip(equations.positions + equations.speeds, state, strict=True))
    values |= dict.fromkeys(set().union(*(a.value.free_symbols for a in equations.angles)) - {*values}, t)
    for angle in equations.angles:
        value = float(angle.value.subs(values))
        values |= {angle.sin: np.sin(value), angle.cos: np.cos(value)}
    for symbol, value in equations.definitions:
        values[symbol] = float(value.subs(values))
    return np.array([float(value.subs(values)) for value in equations.force])


def follow(mechanism, initial, times, rtol=1e-12):
    """States at times, and the integrals of the powers, by SciPy."""
    model = assemble(mechanism, initial, powers=True)
    functions, n = plain(model.structure), len(model.state)
    n_q, n_p = functions.SIZES["positions"], functions.SIZES["powers"]

    def rate(t, y):
        point = Point(functions, model.numbers, y[:n], [], t=t)
        a = point.rate()[:, 0]
        return [*y[n_q:n], *a, *point.watched()[-n_p:, 0]]

    start = np.concatenate([model.state, np.zeros(n_p)])
    span = (0.0, float(times[-1]))
    found = solve_ivp(rate, span, start, "DOP853", times, rtol=rtol, atol=1e-13, max_step=span[1] / 50)
    return model, found.y[:n].T, found.y[n:].T
