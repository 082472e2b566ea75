"""Guards are watched from the base point, also where a step's error was estimated a second time beside it."""

import pytest

from jointplay import catalog
from jointplay.analysis.run import Request, follow
from jointplay.mechanism.assemble import assemble


@pytest.mark.parametrize("rtol", [1e-7, 1e-8])
def test_sticking_does_not_end_where_it_begins(rtol):
    """A long first step after the onset of sticking; the friction force then swings within microseconds."""
    scene = assemble(catalog.chunmei2002(3.7006669710940466e-4, gear_ratio=20.0))
    loose, tight = (
        follow(scene, Request(10 * scene.period, each, events=True, log_from=0.0)) for each in (rtol, 1e-10)
    )
    assert loose.status == tight.status == 0
    assert loose.events[:, 1].tolist() == tight.events[:, 1].tolist()
