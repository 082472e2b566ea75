"""Every kind of study with cells: each cell, taken out again, is that kind's analysis by itself."""

import pytest

import jointplay as jp
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
ANALYSIS = {
    "response": "turns = 2\nsteps = true",
    "section": "turns = 5",
    "lyapunov": "turns = 10",
    "covariant": "turns = 10\nsettling = 3\ntransient = 3",
    "chaos_test": "turns = 60\ntransient = 5",
    "spectrum": 'turns = 16\nquantity = "v"',
    "dimension": "turns = 120",
    "periodic_orbit": "transient = 20",
    "continuation": 'parameter = "restitution"\nrange = [0.7, 0.85]\nmax_points = 5',
    "curve": "plane = { restitution = [0.7, 0.85], gap = [2.8, 3.4] }\ntransient = 20\nmax_points = 5",
    "sensitivity": "turns = 40",
    "gradient": "turns = 1",
    "optimise": 'least = "end:state:v"\norbit = false\nby = { restitution = [0.7, 0.9] }\nmax_iterations = 3',
    "tipping": "region.y = [-1.0, 1.0]\nregion.v = [0, 1]\nstarts = 2\nturns = 16\npatience = 1\nsteps = 2",
    "basins": "plane.y = [-1.0, 1.0]\nplane.v = [0.0, 1.0]\ntransient = 5\nturns = 4\npatience = 0",
}
SINGLE = {
    *("readings", "claims", "scheme_comparison", "bifurcation", "assess", "stress", "work_precision"),
    "benchmark",
    "attractors",
}
ENDS = ("wall_time", "status", "trouble")
LONGEST = "tipping"


def test_every_kind_is_looked_at():
    assert ANALYSIS.keys() | SINGLE == set(KINDS)


@pytest.mark.parametrize(
    ("kind", "system"),
    [
        *((kind, PAIR) for kind in ANALYSIS if kind != LONGEST),
        *(("spectrum", GEAR), pytest.param(LONGEST, PAIR, marks=pytest.mark.long)),
    ],
)
def test_a_cell_is_the_analysis_by_itself(kind, system, tmp_path):
    study = loaded(f'kind = "{kind}"\nname = "a"\n{system}[analysis]\n{ANALYSIS[kind]}\n')
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
