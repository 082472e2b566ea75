"""Studies that compare the paper's scheme with the monolithic method."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.display.errors import InputError
from jointplay.study import run
from jointplay.study.file import Loaded, validate
from jointplay.study.toml_text import override, parse
from tests.support.wrong import texts_of

SCHEME = """\
kind = "scheme_comparison"
name = "small"

[mechanism]
catalog = "chunmei2002"
gear_ratio = 3.0
elastic = ["coupler"]

[analysis]
clearance = [0.0]
start_turn = [0]
windows_per_turn = [1]
passes = 4
steps = [2.5e-5]
tolerances = [1e-5]
repeats = 1
"""


def problems(*changes):
    """Key and message of each problem."""
    return texts_of(validate, override(parse(SCHEME), changes))


def test_what_is_left_out_is_as_in_the_function():
    record = validate({"name": "x", "kind": "scheme_comparison", "mechanism": parse(SCHEME)["mechanism"]})
    assert record.keywords()["rtol"] == 1e-10
    assert record.keywords()["clearance"] == (0.0, 2.9e-5, 2.9e-4)
    assert "single turns after 0, 20 turns" in record.summary()


@pytest.mark.long
def test_a_study_runs():
    found = run.run(Loaded(validate(parse(SCHEME)), SCHEME))
    assert found.attrs["study"] == "small"
    assert found.pass_change.shape == (1, 1, 4)
    assert np.all(np.isfinite(found.scheme_error))


def test_every_mistake_is_told_with_its_place():
    found = problems(
        "mechanism.elastic=[]", "analysis.windows_per_turn=[4, 1]", "analysis.steps=[1e-6, 1e-5]"
    )
    assert set(found) == {"mechanism.elastic", "analysis.windows_per_turn", "analysis.steps"}
    assert "falling" in found["analysis.steps"]
    assert set(problems("analysis.passes=0", "analysis.clearance=[-1.0]")) == {
        "analysis.passes",
        "analysis.clearance[0]",
    }


def test_a_figure_of_another_kind_is_refused():
    assert "scheme_comparison" in problems('figure.kind="overview"')["figure.kind"]


def test_a_step_too_large_is_refused_when_it_runs():
    record = validate(override(parse(SCHEME), ["analysis.steps=[1e-4]"]))
    with pytest.raises(InputError, match=r"at most 5\.9e-05 s"):
        run.run(Loaded(record, SCHEME))
