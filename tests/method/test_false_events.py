"""No event where nothing happens: guards start from the base point, and noise of a speed is not its sign."""

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request, follow

SLIP_REVERSAL = EVENTS.index("slip_reversal")


@pytest.mark.parametrize("rtol", [1e-7, 1e-8])
def test_sticking_does_not_end_where_it_begins(rtol):
    """A long first step after the onset of sticking; the friction force then swings within microseconds."""
    model = assemble(catalog.chunmei2002(3.7006669710940466e-4, gear_ratio=20.0))
    loose, tight = (
        follow(model, Request(10 * model.period, each, events=True, log_from=0.0)) for each in (rtol, 1e-10)
    )
    assert loose.status == tight.status == 0
    assert loose.events[:, 1].tolist() == tight.events[:, 1].tolist()


STICKING = [  # clearance, gear ratio: short episodes of sticking, which begin and end within tolerances
    (1.222156e-5, 15.666667),
    (1.493665e-5, 18.333333),
    (2.466437e-5, 17.666667),
    (1.227675e-4, 12.666667),
    (2.738987e-4, 6.0),
    (4.091131e-4, 7.333333),
]


@pytest.mark.parametrize(("clearance", "gear_ratio"), STICKING)
def test_slip_does_not_turn_at_once(clearance, gear_ratio):
    """Reversals that follow each other are apart by far more than rounding."""
    model = assemble(catalog.chunmei2002(clearance, gear_ratio=gear_ratio))
    records = follow(model, Request(150 * model.period, 1e-7, events=True, log_from=0.0))
    assert records.status == 0
    kinds, times = records.events[:, 1], records.events[:, 2]
    again = (kinds[1:] == SLIP_REVERSAL) & (kinds[:-1] == SLIP_REVERSAL)
    assert np.sum(again) > 100
    assert np.min(np.diff(times)[again]) > 1e-9 * model.period
