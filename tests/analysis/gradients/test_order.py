"""Two impacts that exchange their order: no derivative where they coincide, the right one on either side."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.analysis.tangents import Bundle
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.trajectory import Request

STATES = ("x", "y", "v", "w")
PLAIN, COUPLED = {"m": 1.3, "n": 0.7, "j": 0.0, "r": 0.8}, {"m": 1.3, "n": 0.7, "j": 0.4, "r": 0.8}
END = 2.0
pytestmark = pytest.mark.long


def bodies(numbers):
    """Two bodies that fly freely, coupled by their mass matrix, each towards a wall of its own at 1."""
    walls = [{"name": f"wall_{q}", "gap": f"1 - {q}", "restitution": "r"} for q in "xy"]
    mass = {"v": {"v": "m", "w": "j"}, "w": {"w": "n"}}
    rates = {"x": "v", "y": "w", "v": 0, "w": 0}
    states = {"x": 0.0, "y": 0.5, "v": 1.0, "w": 0.5}
    return jp.System(states=states, parameters=numbers, rates=rates, mass=mass, impacts=walls)


def end(state, numbers):
    """State at the end, and the order of impacts: both numbers may be complex."""
    q, z, left, order = np.array(state[:2]), np.array(state[2:]), END, []
    inverse = np.linalg.inv(np.array([[numbers["m"], numbers["j"]], [numbers["j"], numbers["n"]]]))
    for _ in range(9):
        flights = [((1 - q[i]) / z[i], i) for i in (0, 1) if z[i].real > 0 and i not in order[-1:]]
        if not flights or (first := min(flights, key=lambda each: each[0].real))[0].real > left.real:
            break
        time, i = first
        q, left = q + time * z, left - time
        z = z - (1 + numbers["r"]) * z[i] * inverse[i] / inverse[i, i]
        order.append(i)
    return np.append(q + left * z, z), order


def slopes(state, numbers):
    """Derivatives of the end state by the start of x and by the restitution, to rounding."""
    h = 1e-100
    moved = [state[0] + 1j * h, *state[1:]], numbers
    lively = state, numbers | {"r": numbers["r"] + 1j * h}
    return np.array([end(*each)[0].imag / h for each in (moved, lively)]).T


@pytest.mark.parametrize("numbers", [PLAIN, COUPLED], ids=["alone", "coupled"])
def test_on_each_side_it_is_right_and_between_there_is_none(numbers):
    system, found = bodies(numbers), {}
    of, by = [f"end:state:{name}" for name in STATES], ["initial.x", "r"]
    for side in (-1e-6, 1e-6):
        start = [side, 0.5, 1.0, 0.5]
        answer = jp.gradient(system, of=of, by=by, turns=int(END), initial=start)
        expected, (_, order) = slopes(start, numbers), end(start, numbers)
        assert answer["derivative"].values == pytest.approx(expected, abs=1e-9)
        assert VERDICTS[int(answer["derivative_status"])] == "ok"
        found[side] = expected, order[:2]
    (before, one), (after, other) = found.values()
    assert one == [1, 0] != other
    assert (np.abs(before - after).max() > 0.1) == (numbers["j"] != 0)
    with pytest.warns(jp.ModelWarning, match="two contacts change at the same instant"):
        both = jp.gradient(system, of=of, by=by, turns=int(END), initial=[0.0, 0.5, 1.0, 0.5])
    assert VERDICTS[int(both["derivative_status"])] == "simultaneous_events"


def test_what_a_jump_puts_beyond_another_guard_has_no_derivative_where_its_own_guard_has_jumped():
    """The second jump follows from the first: when it happens is not what its own guard says."""
    late = jp.System(
        states={"x": 0.0, "y": 0.0},
        rates={"x": "1", "y": "one + 3*two + 2*three"},
        modes={
            "one": [{"to": "two", "guard": "1 - x", "jump": {"x": "x + 1"}}],
            "two": [{"to": "three", "guard": "1.5 - x + y/9"}],
            "three": [{"to": "one", "guard": "9 - x"}],
        },
    )
    motion = jp.simulate(late, duration=2.0, at=[2.0], rtol=1e-11)
    assert motion.state_value.values[0] == pytest.approx([3, 3, 0, 0, 1], abs=1e-10)
    bundle = Bundle(assemble(late), Request(2.0, 1e-10), np.eye(5))
    assert bundle.advance() == Status.NO_DERIVATIVE
    with pytest.warns(jp.ModelWarning, match="two contacts change at the same instant"):
        answer = jp.gradient(late, of=["end:state:y"], by=["initial.x"], turns=2)
    assert VERDICTS[int(answer["derivative_status"])] == "simultaneous_events"
    answer = jp.gradient(late, of=["end:state:y"], by=["initial.y"], turns=2)  # neighbours jump at one time
    assert VERDICTS[int(answer["derivative_status"])] == "ok"
    assert answer["derivative"].values.item() == pytest.approx(1.0, rel=1e-9)
