"""Every kind of study with cells: each cell, taken out again, is that kind's analysis by itself."""

import json

import pytest

import jointplay as jp
from jointplay import figures
from jointplay.kinds import KINDS
from tests.support.sweep_samples import bare, loaded, ran

PAIR = """\
[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8
[vary]
gap = [2.9, 3.3]
"""
GEAR = """\
[mechanism]
catalog = "gear_backlash"
mean_load = 0.1
amplitude = 0.2
frequency = 0.8
damping = 0.05
[vary]
frequency = [0.7, 0.8]
"""
CELLS = [name for name, row in KINDS.items() if row.varies and "over" not in row.function.fields()]
ENDS = ("wall_time", "status", "trouble")


def lines(table, above=""):
    """A table of keywords as lines of a study file."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from lines(value, f"{above}{key}.")
        else:
            yield f"{above}{key} = {json.dumps(value)}"


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("kind", "system"),
    [*((kind, PAIR) for kind in CELLS), ("spectrum", GEAR)],
)
def test_a_cell_is_the_analysis_by_itself(kind, system, tmp_path):
    study = loaded(f'kind = "{kind}"\nname = "a"\n{system}[analysis]\n' + "\n".join(lines(KINDS[kind].trial)))
    found = ran(study, tmp_path)
    assert found.identical(jp.open(tmp_path / "a.nc"))
    (varied,) = found.attrs["swept"].split()
    untold = (0, 4) if kind == "sensitivity" else (0,)  # at gap 2.9 nothing can be told of the growth
    assert set(found["cell_status"].values.flat) == set(untold)
    for value in found[varied].values:
        model = study.record.mechanism.varied({varied: float(value)})
        alone = KINDS[kind].function(model, **study.record.keywords())
        cell = jp.cell(found, **{varied: value})
        same, other = (bare(each.drop_vars([n for n in ENDS if n in each])) for each in (cell, alone))
        assert same.identical(other)
    kind_of_figure = figures.usual_kind(alone)
    assert figures.draw(alone, {"kind": kind_of_figure}).axes
