"""What has to have one length is not cut to the shortest: a mistake in the program is an error."""

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.gradients import gradient_dataset
from jointplay.analysis.starts import Journals
from jointplay.jobs.columns import Field, Form, Layout
from jointplay.solver.mechanism.assemble import assemble


def test_a_distance_that_is_missing_makes_no_derivative():
    with pytest.raises(ValueError, match="longer than argument 1"):
        gradient_dataset.verdict((1.0, 1.0))


def test_a_state_that_lacks_a_speed_has_no_journals():
    model = assemble(catalog.chunmei2002())
    journals, states = Journals(model), np.array([model.state])
    assert journals.positions(states).shape == (1, 2)
    with pytest.raises(ValueError, match="shorter than argument 1"):
        journals.positions(states[:, :-1])


def test_a_dimension_without_a_length_has_no_sizes():
    layout = Layout((Field("variables", "force", ("time", "joint"), {}),), {})
    assert Form(layout, (9, 2), (), ()).sizes == {"time": 9, "joint": 2}
    with pytest.raises(ValueError, match="shorter than argument 1"):
        Form(layout, (9,), (), ()).sizes
