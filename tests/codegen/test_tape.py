"""The tape by hand: derivatives through assignments, and L D L^T of small mass matrices."""

from __future__ import annotations

import numpy as np
import pytest
from sympy import Integer, Matrix, Symbol, cos, cse, diff, numbered_symbols, sin, sqrt

from jointplay.solver.codegen.dynamics import Dynamics, InverseMass
from jointplay.solver.codegen.tape import Tape, partial, read, shared
from jointplay.solver.codegen.variants import variants
from jointplay.solver.equations.system import TIME, Angle, System, number
from jointplay.solver.equations.write import system
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble

q, v, W = Symbol("q", real=True), Symbol("v", real=True), number("W")
TURNED = Angle("th", q, W, Integer(2))


def empty(**parts):
    """A system of one position and one speed."""
    base = {"parameters": (W,), "definitions": (), "mass": None, "force": (Integer(0),), "angles": (TURNED,)}
    return System(positions=(q,), speeds=(v,), **base | parts)


def unfolded(tape, value):
    """An expression with every assignment put in, and the angle's sine and cosine."""
    for _ in range(20):
        value = value.subs(tape.values)
    return value.subs({TURNED.sin: sin(TURNED.value), TURNED.cos: cos(TURNED.value)})


@pytest.mark.parametrize("x", [q, v, TIME])
def test_derivative_through_assignments(x):
    tape = Tape(empty())
    a = tape.let("a", TURNED.sin * v + q**2)
    b = tape.let("b", sqrt(1 + a**2) * TURNED.cos)
    value = b**2 + a * q * v
    ours, plain = unfolded(tape, tape.derivative(value, x)), diff(unfolded(tape, value), x)
    point = {q: 0.37, v: -1.2, W: 1.7, TIME: 0.9}
    assert float(ours.subs(point)) == pytest.approx(float(plain.subs(point)), rel=1e-14)


def test_a_named_value_is_named_once():
    tape = Tape(empty())
    assert tape.let("a", q + v) is tape.let("b", q + v)
    assert tape.let("c", Integer(3)) == 3
    assert tape.define(Symbol("zero"), Integer(0)) == 0


def test_the_program_runs_in_order_and_holds_no_more_than_it_needs():
    tape = Tape(empty())
    a = tape.let("a", q + v)
    tape.let("never", q * 17)
    b = tape.let("b", a**2 + TURNED.sin)
    known = {q, v, TURNED.sin, TURNED.cos, W, TIME}
    names = []
    for symbol, value in tape.program({"out": b * a}):
        assert value.free_symbols <= known
        known.add(symbol)
        names.append(str(symbol))
    assert names[-1] == "out"
    assert "never" not in names


@pytest.mark.parametrize("zeros", [(), ((1, 0),), ((2, 0), (2, 1)), ((3, 0), (2, 1), (1, 0))])
def test_substitution_solves_the_mass_matrix(zeros):
    n, random = 4, np.random.default_rng(3)
    dense = random.normal(size=(n, n))
    dense = dense @ dense.T + n * np.eye(n)
    for i, j in zeros:
        dense[i, j] = dense[j, i] = 0.0
    symbols = {(i, j): Symbol(f"m{i}{j}") for i in range(n) for j in range(i + 1) if dense[i, j]}
    speeds = tuple(Symbol(f"z{i}", real=True) for i in range(n))
    system = System((), speeds, (), (), dict(symbols), (Integer(0),) * n)
    tape, b = Tape(system), [Symbol(f"b{i}") for i in range(n)]
    x = InverseMass(tape, system)(b, "x")
    right = random.normal(size=n)
    values = {s: dense[place] for place, s in symbols.items()} | dict(zip(b, right, strict=True))
    ours = np.array(Matrix(x).subs(_numbers(tape, values)), dtype=float).ravel()
    assert ours == pytest.approx(np.linalg.solve(dense, right), rel=1e-12)


def _numbers(tape, values):
    """Values of all assignments, in their order."""
    values = dict(values)
    for symbol, expression in tape.values.items():
        values[symbol] = expression.subs(values)
    return values


def test_without_a_mass_the_matrix_is_the_identity():
    system = empty()
    b = [Symbol("b")]
    assert InverseMass(Tape(system), system)(b, "x") == b


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["slider_crank", "flores2010"])
def test_slopes_and_common_subexpressions_are_those_of_sympy(name):
    """In its order, on the programs of every variant."""
    equations, compared = system(assemble(catalog.NAMES[name]()).structure), 0
    for variant in variants(equations):
        dynamics = Dynamics(equations, variant)
        dynamics.jacobian()
        values = list(dynamics.tape.values.values())
        ours = shared(values, numbered_symbols("k", real=True))
        assert ours == cse(values, numbered_symbols("k", real=True), order="none")
        compared += len(ours[0])
        for value in values:
            for s in read(value):
                assert partial(value, s) == value.diff(s)
    assert compared > 10
