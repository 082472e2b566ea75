"""Functions of one lane, compiled as operations on rows: what the same function gives as plain Python."""

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from jointplay.numerics.compiler import POLICY
from tests.support import one_lane

interpreted = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
STRANGE = np.array([0.0, -0.0, 1.0, np.inf, -np.inf, np.nan, 1e-300, -2.0])


@interpreted
def test_every_lane_has_what_plain_python_gives():
    over = one_lane.compiled
    run = numba.njit(**POLICY)(lambda w: over(w))
    random = np.random.default_rng(3)
    for _ in range(20):
        w = np.zeros((23, 8))
        w[:4] = random.normal(size=(4, 8))
        w[0] = random.permutation(STRANGE)
        w[1], w[3] = np.where(random.random((2, 8)) < 0.3, w[[0, 2]], w[[1, 3]])
        mine, plain = w.ravel().copy(), w.ravel().copy()
        run(mine)
        with np.errstate(all="ignore"):
            one_lane.looped(plain)
        np.testing.assert_allclose(mine, plain, rtol=1e-14, atol=1e-290)


@interpreted
def test_what_is_no_row_is_refused():
    over = one_lane.refused
    with pytest.raises((NumbaError, NotImplementedError), match=r"w\[i\]"):
        numba.njit(lambda w: over(w))(np.zeros(16))


@interpreted
def test_what_does_nothing_is_compiled():
    over, w = one_lane.idle, np.arange(16.0)
    numba.njit(**POLICY)(lambda w: over(w))(w)
    assert w.tolist() == list(range(16))
