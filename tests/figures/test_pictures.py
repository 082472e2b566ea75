"""Every kind of figure is drawn as it was before: what it consists of, in words and numbers.

After a change that is meant, look at the figure, then run this file: `python -m tests.figures.test_pictures`.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from jointplay import catalog, figures
from jointplay.analysis.tolerances.tolerances import OUTPUTS as shared
from jointplay.kinds import KINDS
from tests.figures.analyses.test_bifurcation import sweep
from tests.figures.analyses.test_chaos_figures import counted, density, judged
from tests.figures.analyses.test_covariant_figure import vectors
from tests.figures.analyses.test_fields import basins, coexisting, divergence, field, tipped
from tests.figures.analyses.test_lyapunov_figure import exponents
from tests.figures.analyses.test_sweep_figure import cases, swept
from tests.figures.lab.test_work_precision import works
from tests.figures.support.synthetic import flag_words, oscillator, response, section
from tests.figures.support.synthetic_assessment import assessment
from tests.figures.support.synthetic_branches import branches, curves, orbit
from tests.figures.support.synthetic_tables import claims, readings, schemes
from tests.study.test_sweep_kinds import CELLS

KNOWN = Path(__file__).with_name("pictures.txt")
VERDICTS = ("ok", "sensitive", "stopped", "unconfirmed", "suspect")


def stressed() -> xr.Dataset:
    """Twelve scenes of five verdicts; two without an energy balance."""
    count = np.arange(12)
    data = {
        "verdict": ("model", (count % 5).astype(np.int8), flag_words(VERDICTS, "verdict")),
        "stiffness_number": ("model", 10.0 ** (count / 3)),
        "cpu_time": ("model", 1e-4 * (1 + count)),
        "energy_residual": ("model", np.where(count > 9, np.nan, 10.0 ** (-18.0 + 1.4 * count))),
        "status": ((), np.int8(0), flag_words(("ok",), "outcome")),
    }
    return xr.Dataset(data, attrs={"kind": "stress"})


def compared() -> xr.Dataset:
    """Three quantities of a benchmark, one of them met to the last bit."""
    off = np.array([1e-9, 0.0, 3e-12])
    data = {"published": ("quantity", np.ones(3)), "computed": ("quantity", 1 + off)}
    data |= {
        "relative_difference": ("quantity", off),
        "status": ((), np.int8(0), flag_words(("ok",), "outcome")),
    }
    return xr.Dataset(data, {"quantity": ["angle", "speed", "force"]}, {"kind": "benchmark"})


def leaning() -> xr.Dataset:
    """Two quantities by three parameters, one of which the second does not depend on."""
    slopes = np.array([[2.0, -0.5, 0.1], [0.3, 0.0, -0.2]])
    both = ("quantity", "parameter")
    data = {"derivative": (both, 10 * slopes), "error": (both, 0.5 * np.abs(slopes))}
    data |= {
        "relative_sensitivity": (both, slopes),
        "status": ((), np.int8(0), flag_words(("ok",), "outcome")),
    }
    names = {"quantity": ["largest:normal_force:B", "time"], "parameter": ["clearance", "speed", "friction"]}
    data |= {
        "quantity_name": ("quantity", ["largest normal contact force, B", "time"]),
        "parameter_name": ("parameter", ["radial clearance", "speed", "friction coefficient"]),
    }
    return xr.Dataset(data, names, {"kind": "gradient"})


def improved() -> xr.Dataset:
    """Two parameters, a force and the largest forces of two joints, before and after; one is not known."""
    force = {"units": "N", "long_name": "normal contact force"}
    time = {"units": "s", "long_name": "time"}
    data = {"status": ((), np.int8(0), flag_words(("ok",), "outcome"))}
    rows = {"low": [0.1, 2.0], "high": [0.3, 4.0], "optimum": [0.1, 4.0], "first_value": [0.2, 3.0]}
    rows |= {"parameter_units": ["kg", "1"], "parameter_name": ["mass of the coupler", "gear ratio"]}
    data |= {name: ("parameter", np.array(values)) for name, values in rows.items()}
    data |= {
        "force_before": ("joint", [40.0, 60.0], force),
        "force_after": ("joint", [20.0, np.nan], force),
    }
    for name, size in (("before", 40.0), ("after", 20.0)):
        data[f"time_{name}"] = f"time_{name}", np.array([0.0, 0.01, 0.02]), time
        data[f"course_{name}"] = f"time_{name}", np.array([size, 1.0, size]), force
    names = {"parameter": ["links.coupler.mass", "gear_ratio"], "joint": ["B", "O"]}
    return xr.Dataset(data, names, {"kind": "optimise"})


def sampled() -> xr.Dataset:
    """Forty samples of two numbers, a limit that some exceed, and its edge."""
    a, b = (np.arange(40) * 7 % 40) / 40 - 0.5, (np.arange(40) * 11 % 40) / 40 - 0.5
    over = (a + 0.2 * b > 0.2).astype(int)
    shares = {"first_order": [[0.7, 0.1], [0.6, 0.2]], "total": [[0.9, 0.3], [0.8, 0.4]]}
    ends = {"": 0.0, "_low": -0.1, "_high": 0.1}
    line = np.linspace(-0.5, 0.5, 5)
    table = {f"{name}{end}": np.array(v) + off for name, v in shares.items() for end, off in ends.items()}
    table |= {f"share{end}": [0.25 + off] for end, off in ends.items()}
    table |= {
        "parameter": ["joints.B.clearance", "speed"],
        "factor": ["joints.B.clearance", "speed"],
        "parameter_name": ["radial clearance of joint B", "speed"],
        "factor_name": ["radial clearance of joint B", "speed"],
        "parameter_units": ["m", "rad s-1"],
        "event": ["above:force:B"],
        "quantity": ["force:B"],
        "output": ["above:force:B", "force:B"],
        "quantity_name": ["largest joint force, B"],
        "quantity_units": ["N"],
        "value": np.stack([1e-4 + 1e-5 * a, 200 + 5 * b], axis=1),
        "outcome": np.where(np.arange(40) == 3, 2, over)[:, None],
        "quantity_value": 100 + 50 * (a + 0.2 * b)[:, None],
        "limit": [110.0],
        "edge_event": "above:force:B",
        "edge_across": np.stack([np.full(5, np.nan), 200 + 5 * line]),
        "edge_line": np.stack([np.full(5, np.nan), 1e-4 + 1e-5 * (0.2 - 0.2 * line)])[None],
    }
    of = {"name": "radial clearance", "units": "m"}
    return shared.dataset(table, of, edge_parameter="joints.B.clearance")


PICTURES = {
    "tolerances": lambda: (sampled(), {}),
    "tolerances of one": lambda: (sampled().isel(parameter=[0]).drop_dims(("quantity", "factor")), {}),
    "optimise": lambda: (improved(), {}),
    "gradient": lambda: (leaning(), {}),
    "time_history": lambda: (response(), {"kind": "time_history"}),
    "time_history of turns": lambda: (response(), {"kind": "time_history", "turns": [1, 3], "axis": "angle"}),
    "time_history of a system": lambda: (oscillator(), {}),
    "contact_angle": lambda: (response(), {"kind": "contact_angle"}),
    "journal_orbit": lambda: (response(), {"kind": "journal_orbit"}),
    "phase_portrait": lambda: (response(), {"kind": "phase_portrait"}),
    "phase_portrait of a system": lambda: (oscillator(), {"kind": "phase_portrait"}),
    "poincare_section": lambda: (section(), {}),
    "poincare_section of a run": lambda: (response(), {"kind": "poincare_section"}),
    "poincare_section of two": lambda: (section(300, joints=("B", "C")), {"x": "journal_x"}),
    "overview": lambda: (response(), {}),
    "overview of a failed run": lambda: (response(status="diverged"), {}),
    "claims": lambda: (claims(), {}),
    "readings": lambda: (readings(), {}),
    "scheme_comparison": lambda: (schemes(), {}),
    "bifurcation": lambda: (sweep(), {}),
    "bifurcation of starts": lambda: (sweep(directions=("reset",), starts=3, exponents=0), {}),
    "parameter_map": lambda: (sweep(("reset",), over=("clearance", "gear_ratio")), {"kind": "parameter_map"}),
    "lyapunov": lambda: (exponents(), {}),
    "covariant": lambda: (vectors(), {}),
    "chaos_test": lambda: (judged(), {}),
    "spectrum": lambda: (density(), {}),
    "dimension": lambda: (counted(), {}),
    "divergence": lambda: (divergence(), {}),
    "field": lambda: (field(), {}),
    "basins": lambda: (basins(), {}),
    "attractors": lambda: (coexisting(), {}),
    "tipping": lambda: (tipped(), {}),
    "continuation": lambda: (branches(), {}),
    "curve": lambda: (curves(), {}),
    "floquet": lambda: (orbit((0.5, 0.3), (0.5, -0.3), (-0.2, 0.0)), {}),
    "floquet of a branch": lambda: (branches(), {"kind": "floquet"}),
    "assess": lambda: (assessment(settled=0), {}),
    "stress": lambda: (stressed(), {}),
    "work_precision": lambda: (works(), {}),
    "benchmark": lambda: (compared(), {}),
    "mechanism": lambda: (catalog.chunmei2002(clearance={"B": 2.9e-4}, elastic=("coupler",)), {}),
    "sweep": lambda: (swept("clearance"), {"kind": "sweep"}),
    "sweep over two": lambda: (swept("clearance", "gear_ratio"), {"kind": "sweep"}),
    "sweep of cases": lambda: (cases(), {"kind": "sweep"}),
}


def number(value) -> str:
    """Four digits, and no sign of a zero."""
    return f"{float(value) + 0.0:.4g}"


def numbers(values) -> str:
    """How many there are, their sum and that of their places times them, of those that are finite."""
    flat = np.ma.masked_invalid(np.ma.asarray(values, dtype=float)).filled(0.0).ravel()
    size = np.abs(flat).max(initial=0.0)
    sums = (flat.sum(), flat @ np.linspace(0.0, 1.0, flat.size)) if size else (0.0, 0.0)
    return f"{flat.size}: " + " ".join("0" if abs(each) < 1e-9 * size else number(each) for each in sums)


def colours(values) -> str:
    each = np.atleast_2d(values)
    return (
        f"{len(each)} {to_hex(each[0], keep_alpha=True)} {to_hex(each[-1], keep_alpha=True)}"
        if each.size
        else "-"
    )


def line(one) -> str:
    look = [to_hex(one.get_color()), number(one.get_linewidth()), one.get_linestyle(), one.get_marker()]
    more = [
        number(one.get_markersize()),
        number(one.get_markeredgewidth()),
        one.get_alpha(),
        one.get_zorder(),
    ]
    data = [numbers(one.get_xdata(orig=False)), numbers(one.get_ydata(orig=False))]
    return f"line {one.get_label()!r} {look} {more} {one.get_rasterized()} {data}"


def cloud(one) -> str:
    look = [colours(one.get_facecolor()), colours(one.get_edgecolor()), numbers(one.get_linewidth())]
    data = [numbers(one.get_offsets()), numbers([path.vertices.sum() for path in one.get_paths()])]
    values = "-" if one.get_array() is None else f"{numbers(one.get_array())} {scaled(one)}"
    kind, order = type(one).__name__, f"{one.get_alpha()} {one.get_zorder()}"
    return f"{kind} {one.get_label()!r} {look} {order} {data} {values}"


def scaled(one) -> str:
    return f"{one.cmap.name} {[number(each) for each in one.get_clim()]} {type(one.norm).__name__}"


def patches(all_of_them) -> list[str]:
    """Those that look alike together, as the bars of a histogram."""
    for look, some in groupby(all_of_them, patch):
        corners = [one.get_path().transformed(one.get_patch_transform()).vertices for one in some]
        yield f"{look} {len(corners)} of them, {numbers(np.concatenate(corners))}"


def patch(one) -> str:
    look = [colours(one.get_facecolor()), colours(one.get_edgecolor()), number(one.get_linewidth())]
    return f"{type(one).__name__} {look} {one.get_hatch()} {one.get_zorder()}"


def text(one) -> str:
    where = [number(each) for each in one.get_position()]
    look = [to_hex(one.get_color()), number(one.get_size()), one.get_ha(), one.get_va(), one.get_rotation()]
    return f"text {one.get_text()!r} {where} {look}"


def legend(one) -> str:
    words = [each.get_text() for each in one.get_texts()]
    return f"legend {words} {one._loc} {one._ncols} {number(one.handletextpad)} {number(one.columnspacing)}"


def axis(name, one, limits) -> str:
    ticks = [type(one.get_major_locator()).__name__, type(one.get_major_formatter()).__name__]
    look = [one.get_scale(), one.get_visible(), one.get_ticks_position(), number(one.label.get_size())]
    return f"{name} {one.get_label_text()!r} {[number(each) for each in limits]} {look} {ticks}"


def panel(ax) -> list[str]:
    """What is in a panel, one thing a line."""
    titles = [ax.get_title(loc=loc) for loc in ("left", "center", "right")]
    spines = [name for name, spine in ax.spines.items() if spine.get_visible()]
    yield f"panel {titles} {ax.get_aspect()} {ax.axison} {spines} {to_hex(ax.get_facecolor())}"
    widths = (spec := ax.get_subplotspec()) and spec.get_gridspec().get_width_ratios()
    if widths and len({*widths}) > 1:
        yield f"widths {[number(each) for each in widths]}"
    if bar := getattr(ax, "_colorbar_info", None):
        yield f"bar {bar['location']} {number(bar['pad'])}"
    yield axis("x", ax.xaxis, ax.get_xlim())
    yield axis("y", ax.yaxis, ax.get_ylim())
    yield from map(line, ax.lines)
    yield from map(cloud, ax.collections)
    yield from patches(ax.patches)
    yield from (f"image {numbers(one.get_array())} {scaled(one)}" for one in ax.images)
    yield from map(text, ax.texts)
    yield from map(legend, filter(None, [ax.get_legend()]))
    yield from (axis("second x", one.xaxis, one.get_xlim()) for one in ax.child_axes)


def picture(name: str) -> list[str]:
    """A figure in words and numbers."""
    dataset, options = PICTURES[name]()
    figure = figures.draw(dataset, options)
    figure.set_layout_engine(None)  # as for a file
    figure.draw_without_rendering()  # meshes get their colours then
    size = [number(each) for each in figure.get_size_inches()]
    found = [
        f"figure {size} {figure.get_suptitle()!r}",
        *map(legend, figure.legends),
        *map(text, figure.texts),
    ]
    for ax in figure.axes:
        found += panel(ax)
    return [each.replace("\n", " ") for each in found]


def known() -> dict[str, list[str]]:
    """The pictures as they are stored: a heading and their lines."""
    blocks = KNOWN.read_text(encoding="utf-8").strip("\n").split("\n\n")
    return {block.split("\n")[0]: block.split("\n")[1:] for block in blocks}


@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_is_drawn_as_it_was(name):
    assert picture(name) == known()[name]


def test_a_figure_is_laid_out_without_being_drawn(monkeypatch):
    drawn = []
    monkeypatch.setattr(Figure, "draw", lambda *_: drawn.append(1))
    dataset, options = PICTURES["overview"]()
    figures.draw(dataset, options)
    assert drawn == []


def test_every_kind_of_figure_is_among_them_or_drawn_of_each_kind_that_is_tried():
    tried = {name for kind in CELLS for name in figures.suited(KINDS[kind])}  # tests.study.test_sweep_kinds
    assert {name.split(" ")[0] for name in PICTURES} | tried == set(figures.KINDS)
    assert set(known()) == set(PICTURES)


if __name__ == "__main__":
    blocks = ["\n".join([name, *picture(name)]) for name in PICTURES]
    KNOWN.write_text("\n\n".join(blocks) + "\n", encoding="utf-8")
