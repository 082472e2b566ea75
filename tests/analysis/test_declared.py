"""What analyses declare that they give is what they give, in files, docstrings, documentation and sweeps."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.labels import PLANE, Out, columns
from jointplay.kinds import KINDS, Kind

LOOSE = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
PAIR, DUFFING = jp.catalog.impact_pair(3.0, 0.8), jp.catalog.duffing()
Y_V = {"y": [0.0, 0.1, 0.2], "v": [0.0, 0.1, 0.2]}
REGION = {"y": [-1.0, 1.0], "v": [0.0, 1.0]}
BENT = jp.catalog.chunmei2002(gear_ratio=3.0, elastic=["coupler"], elements=2)
BRIEF = {"turns": 4, "transient": 1, "n_jobs": 1}
CALLS = {  # of kinds whose trial does not give all that they declare, those that together do
    "response": [
        {"mechanism": LOOSE, "turns": 0.3, "section": jp.CrankAngle()},
        {"mechanism": PAIR, "windows": [(0, 1)]},
    ],
    "section": [{"mechanism": LOOSE, "turns": 2}],
    "bifurcation": [
        {"mechanism": LOOSE, "over": {"clearance": [1e-4, 2e-4, 3e-4]}, "direction": "reset", "refine": 1}
        | {"exponents": 1, "lyapunov_turns": 2}
        | BRIEF
    ],
    "lyapunov": [
        {"mechanism": LOOSE, "turns": 0.3},
        {"mechanism": DUFFING, "turns": 20, "twin_turns": 3, "exponents": "all"},
    ],
    "covariant": [
        {"mechanism": DUFFING, "turns": 4, "settling": 4},
        {"mechanism": jp.catalog.lorenz(), "turns": 4, "settling": 4},
        {"mechanism": LOOSE, "turns": 0.1, "max_steps": 5},
    ],
    "basins": [{"mechanism": DUFFING, "plane": Y_V, "turns": 4, "transient": 2, "patience": 0, "refine": 1}],
    "sensitivity": [{"mechanism": DUFFING, "turns": 4, "neighbours": 2, "plane": Y_V}],
    "gradient": [{"mechanism": PAIR, "orbit": True}],
    "optimise": [
        {"mechanism": PAIR, "by": {"restitution": (0.5, 0.95)}, "least": "largest:state:v", "orbit": False},
        {"mechanism": LOOSE, "by": {"gear_ratio": (2.9, 3.1)}, "least": "time", "orbit": False}
        | {"max_iterations": 1, "max_steps": 2000},
    ],
    "tolerances": [
        {"mechanism": LOOSE, "spreads": {"clearance": {"normal": [2e-4, 1e-6]}}, "samples": 4, "shares": 2}
        | {
            "of": ["largest:normal_force:B"],
            "limits": {"force:B": 1e6},
            "edge": {"contact_loss": "clearance"},
        }
        | {"prices": {"clearance": 1.0}, "wanted": 0.5, "turns": 12, "transient": 2, "lyapunov_turns": 2},
        {"mechanism": jp.catalog.impact_pair(3.0, 0.8), "spreads": {"restitution": {"normal": [0.75, 0.02]}}}
        | {"limits": {"largest:state:v": 1.8}, "edge": {"largest:state:v": "restitution"}, "samples": 4}
        | {"turns": 12, "transient": 20, "edge_runs": 2},
        {"mechanism": PAIR, "spreads": {"restitution": {"values": [0.7, 0.8]}}, "samples": 2, "shares": 0}
        | {"turns": 12, "transient": 2, "max_steps": 5},
    ],
    "attractors": [
        {"mechanism": PAIR, "over": {"gap": [2.95, 3.0]}, "region": REGION, "starts": 4, "turns": 16}
        | {"transient": 5, "patience": 0, "lyapunov_turns": 4, "bifurcations": True, "n_jobs": 1}
    ],
    "assess": [{"mechanism": LOOSE, "turns": 2, "transient": 2, "lyapunov_turns": 2, "reach": 1.01}],
    "periodic_orbit": [
        {"mechanism": PAIR, "transient": 5, "record": ["state_value"]},
        {"mechanism": LOOSE, "transient": 0, "max_iterations": 1, "max_steps": 50},
    ],
    "readings": [{"panels": ["b"], "readings": ["as_printed"], "growth_turns": 3} | BRIEF],
    "claims": [{"damping_ratios": (), "growth_turns": 3, "max_steps": 5} | BRIEF],
    "scheme_comparison": [
        {"mechanism": BENT, "clearance": 0.0, "start_turn": 0, "windows_per_turn": 1, "passes": 2}
        | {"steps": 2.5e-5, "tolerances": 1e-4, "repeats": 1}
    ],
    "stress": [{"scenes": 1, "variants": ("rigid",), "max_steps": 20, "n_jobs": 1}],
    "work_precision": [{"mechanism": PAIR, "tolerances": 1e-6, "peers": (), "rounds": 0}],
    "benchmark": [{"mechanism": jp.catalog.ivp_crank(), "max_steps": 3}],
}
SLOW = ("assess", "claims", "scheme_comparison")  # seconds each
AXES = {
    "basins": ("y", "v"),
    "sensitivity": ("y", "v"),
    "attractors": ("gap",),
    "bifurcation": ("clearance",),
}  # of the planes that results are over


def marked(row):
    return pytest.param(row, id=row.name, marks=[pytest.mark.long] * (row.name in SLOW))


@pytest.mark.nightly
@pytest.mark.parametrize("row", [marked(row) for row in KINDS.values()])
def test_all_that_is_declared_is_given_and_said(row):
    results = [row.function(**call) for call in CALLS.get(row.name, [{"mechanism": PAIR, **row.trial}])]
    outputs = row.outputs
    for name, out in (outputs.variables | outputs.coords).items():
        if any(part.isupper() for part in name.split("_")):  # stands for names of a result's own
            continue
        given = [result[name] for result in results if name in result]
        assert given, f"no call gives {name}"
        over = AXES.get(row.name, ())
        dims = tuple(name for dim in out.axes for name in (over if dim == PLANE else (dim,)))
        assert all(each.dims == dims for each in given), name
        assert name in RUN or f"\n    - ``{name}``" in row.function.__doc__
    assert all(result.attrs["kind"] == outputs.kind == row.name for result in results)
    assert callable(outputs.answer)
    assert outputs.shown.keys() <= outputs.variables.keys()
    assert not isinstance(outputs.verdict, str) or outputs.verdict in ("", *outputs.variables)


TRIAL = Outputs(
    "trial",
    {"turn": Out("turn", "section point")},
    {
        "height": Out("turn", "height of {name}", "{units}", about="above ground"),
        "verdict": Out((), "verdict", flags=("unknown", "high"), missing="unknown"),
    },
    verdict="verdict",
)


def test_a_dataset_has_names_units_and_words_in_the_order_of_the_declaration():
    of = {"name": "the ball", "units": "m"}
    found = TRIAL.dataset({"verdict": 1, "height": [1.0, 2.0], "turn": [0, 1]}, of=of, note="a note")
    assert list(found.data_vars) == ["height", "verdict"]
    assert found.height.attrs == {"units": "m", "long_name": "height of the ball"}
    assert jp.words(found).verdict.item() == "high"
    assert found.attrs == {"Conventions": "CF-1.11", "kind": "trial", "note": "a note"}
    assert TRIAL.words(found).item() == "high"


def test_a_run_that_failed_has_what_is_declared_as_missing():
    found = TRIAL.dataset(TRIAL.none("height", "verdict", turn=3))
    assert np.isnan(found.height).all()
    assert found.sizes == {"turn": 3}
    assert jp.words(found).verdict.item() == "unknown"


def test_cells_without_a_value_have_what_is_declared_as_missing():
    outs = {"count": Out((), "count", missing=-1), "trouble": Out((), "trouble", "", missing="")}
    outs |= {name: TRIAL.variables[name] for name in ("height", "verdict")}
    cells = [{"height": 2, "verdict": 1, "trouble": "it fell"}, {"count": 3}]
    found = columns(outs, cells, (2, 1))
    assert {name: each.ravel().tolist() for name, each in found.items() if name != "height"} == {
        "count": [-1, 3],
        "trouble": ["it fell", ""],
        "verdict": [1, 0],
    }
    assert found["height"][0].tolist() == [2.0]
    assert np.isnan(found["height"][1]).all()
    assert [found[name].dtype.kind for name in outs] == ["i", "U", "f", "i"]


def test_a_comment_is_in_the_file_and_in_the_documentation():
    out = Out((), "height", "m", "above ground", "to the millimetre")
    assert out.variable(1.0)[2] == {"units": "m", "long_name": "height", "comment": "to the millimetre"}
    assert (
        str(Outputs("trial", {}, {"height": out}))
        == "- ``height``: height; above ground; to the millimetre (m)"
    )


def test_what_stands_for_other_names_is_said():
    outs = {"QUANTITY": Out(PLANE, "what `record` asks for"), "status": RUN["status"]}
    assert list(Outputs("trial", {}, outs).notes()) == [
        "Beside them, times and counters of the run.",
        "``plane`` stands for what is varied.",
        "Words in capitals stand for names of the result's own.",
    ]
    assert str(Outputs("trial", {}, outs)).endswith(
        "the run ended\n\n" + "\n".join(Outputs("", {}, outs).notes())
    )
    assert list(TRIAL.notes()) == []


def test_a_kind_that_declares_nothing_says_nothing():
    outputs = Kind("bare", "math:sqrt").outputs
    assert (outputs.kind, outputs.variables, outputs.answer, outputs.table) == ("bare", {}, None, None)
    assert outputs.in_sweep(["height"]) is None


def test_a_value_that_is_not_declared_is_refused():
    with pytest.raises(KeyError, match="trial declares no depth, width"):
        TRIAL.dataset({"height": [1.0], "width": 1.0, "depth": 2.0})


def test_a_declaration_reads_as_text():
    assert str(TRIAL).splitlines() == [
        "- ``turn``: section point",
        "- ``height``, over ``turn``: height of the quantity; above ground (its units)",
        "- ``verdict``: verdict (unknown, high)",
    ]
