"""Measured numbers of the documentation, taken from results.

A page marks a number with its name, ``<!--=exponents_12c.tangents-->+1.691 ± 0.013<!--/-->``; `measured.toml`
holds every name with its text, by the study that it was measured with and the digest of that study's text.
After the studies have been run anew::

    python -m tests.benchmarks.store results   # the tables of docs/benchmarks.md that no study gives
    python -m docs.measured results results/paper

reads NAME.nc in these folders, writes `measured.toml` and the marked numbers of all pages. What is not
there leaves its numbers as they are. A test holds studies, numbers and pages together.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[1]
STORE = ROOT / "docs" / "measured.toml"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
MARK = re.compile(r"<!--=([\w.]+)-->(.*?)<!--/-->", re.DOTALL)
MICRO = 1e6


def with_error(value: float, error: float) -> str:
    """A signed number with its standard error, to the error's digits."""
    digits = max(0, min(6, 1 - math.floor(math.log10(error)))) if error > 1e-6 else 6
    return f"{value:+.{digits}f} ± {error:.{digits}f}"


def exponents(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Largest exponent but the motor's zero, by tangents and by twins."""
    value, error = result.lyapunov_exponent_per_turn.values, result.lyapunov_standard_error_per_turn.values
    largest = next(i for i in range(len(value)) if abs(value[i]) > 1e-3)
    yield "tangents", with_error(value[largest], error[largest])
    yield "twins", with_error(float(result.growth), float(result.growth_standard_error))
    yield "growth_factor", f"{math.exp(value[largest]):.1f}"


def orbit(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Logarithm of the largest multiplier's modulus, a turn."""
    yield "log_multiplier", f"{math.log(np.hypot(*result.floquet_multiplier.values[0])):.5f}"
    yield "multiplier", f"{np.hypot(*result.floquet_multiplier.values[0]):.3f}"


def parameter_map(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Where the map over clearance and gear ratio is chaotic, and its periods at gear ratio 15."""
    cells = result.squeeze(drop=True)
    beyond = cells.section_exponent_per_turn > 3 * cells.section_standard_error_per_turn
    chaotic = (beyond & (cells.period == 0)).transpose("clearance", "gear_ratio").values
    ratios = cells.gear_ratio.values
    for name, row in (("narrow", 0), ("wide", -1)):
        inside = ratios[chaotic[row]]
        yield f"{name}_clearance", f"{cells.clearance.values[row] * MICRO:.0f} µm"
        yield f"{name}_from", f"{inside.min():.2f}"
        yield f"{name}_to", f"{inside.max():.2f}"
    largest = cells.section_exponent_per_turn.where(beyond).max()
    yield "largest", f"{float(largest):.1f}"
    yield "failed", str(int((cells.cell_status != 0).sum()))


def periods(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Periods over the clearance, each value from the same start, and how often contact is lost."""
    cells = result.sel(direction="reset").squeeze(drop=True)
    clearance, period = cells.clearance.values * MICRO, cells.period.values
    below = clearance <= 300
    yield "range", f"{clearance[0]:.0f} to {clearance[-1]:.0f} µm"
    yield "step", f"{clearance[1] - clearance[0]:.0f} µm"
    yield "once_below_300", f"{np.sum(period[below] == 1)} of {np.sum(below)}"
    yield "twice_below_300", ", ".join(f"{c:.0f}" for c in clearance[below & (period == 2)])
    yield "periods_beyond", ", ".join(map(str, sorted({*period[~below]} - {0})))
    yield "none", ", ".join(f"{c:.0f}" for c in clearance[period == 0])
    yield "separations", f"{float(result.separations.sum()):.0f}"


def diagram(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Up to where every start has period 1, from where on chaos is met, and its share beyond 150 µm."""
    cells = result.sel(direction="reset").squeeze(drop=True).transpose("clearance", ...)
    clearance, exponent = cells.clearance.values * MICRO, cells.section_exponent_per_turn
    chaotic = ((exponent > 3 * cells.section_standard_error_per_turn) & (cells.period == 0)).values
    yield "values", str(len(clearance))
    yield "once_to", f"{clearance[np.argmax((cells.period.values != 1).any(axis=1)) - 1]:.1f} µm"
    yield "chaos_from", f"{clearance[np.argmax(chaotic.any(axis=1))]:.1f} µm"
    yield "chaotic_share", f"{100 * chaotic[clearance > 150].mean():.0f} %"
    periods = np.unique(cells.period.values[clearance <= 150])
    yield "periods_below", ", ".join(str(p) for p in periods if p > 0)
    differ = (cells.period.values[:, 0] != cells.period.values[:, 1]).mean()
    yield "starts_differ", f"{100 * differ:.0f} %"


def doublings(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Clearances at which the branches double their periods, in the order of the parameter."""
    kinds = result.special_kind.attrs["flag_meanings"].split()
    at = result.special_parameter.values[result.special_kind.values == kinds.index("period_doubling")]
    for i, value in enumerate(sorted(at)):
        yield f"doubling_{i}", f"{value * MICRO:.3f} µm"


def doubled(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Where an upward sweep finds period 2."""
    period = result.period.sel(direction="up").squeeze(drop=True).values
    clearance = result.clearance.values * MICRO
    twice = clearance[period == 2]
    yield "twice_from", f"{twice.min():.2f} µm"
    yield "twice_to", f"{twice.max():.2f} µm"
    yield "step", f"{clearance[1] - clearance[0]:.2f} µm"


def wedge(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """How many cells of the map between the curves have their region's label."""
    from tests.support.regions import regions

    with xr.open_dataset(Path(result.encoding["source"]).with_name("map_wedge.nc")) as diagram:
        found = regions(result, diagram)
    inside = found.number > 0
    yield "cells", str(found.number.size)
    yield "between", str(int(inside.sum()))
    yield "wrong", str(int((inside & ~found.right).sum()))
    yield "share", f"{100 * found.share:.1f} %"


def basins(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Periods and fractions of the motions that coexist, and the boundary's dimension."""
    yield "periods", ", ".join(str(int(n)) for n in result.period.values)
    yield "fractions", ", ".join(f"{100 * share:.0f}" for share in result.fraction.values) + " %"
    yield "fraction_error", f"{100 * float(result.fraction_standard_error.max()):.0f} %"
    yield "boundary_dimension", f"{float(result.boundary_dimension):.2f}"


def dimension(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Correlation dimension of the section points."""
    value, error = float(result.correlation_dimension), float(result.correlation_dimension_error)
    yield "dimension", f"{value:.2f} ± {error:.2f}"


def coexisting(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """At how many values motions coexist, and where starts had not settled"""
    motions = (result.fraction > 0).sum("identity").values
    several = motions > 1
    yield "values", str(motions.size)
    yield "several", str(several.sum())
    yield "most", str(motions.max())
    yield "unsettled", str((result.fraction_unsettled > 0).sum().item())


def verdict(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Verdict of the 0-1 test."""
    yield "verdict", result.verdict.attrs["flag_meanings"].split()[int(result.verdict)]


def growth(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Growth of small differences a turn."""
    yield "growth", with_error(float(result.growth), float(result.growth_standard_error))


def claims(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Growth a turn in the three panels, over their starts."""
    for panel, values, errors in zip(
        "abc", result.growth.values, result.growth_standard_error.values, strict=True
    ):
        low, high = min(values), max(values)
        text = f"{low:+.2f} to {high:+.2f} ± {max(errors):.2f}" if high - low > 0.01 else f"{low:+.3f}"
        yield f"growth_{panel}", text


def bending(name: str) -> Callable[[xr.Dataset], Iterator[tuple[str, str]]]:
    """Error of the deflection over a turn against the finest shapes of all, in per cent of its rms."""

    def numbers(result: xr.Dataset) -> Iterator[tuple[str, str]]:
        truth = xr.open_dataset(result.encoding["source"].replace("elements", "modes")).deflection.isel(
            modes=-1
        )
        truth = truth.sel(link="coupler").values
        for cell in range(result.sizes[name]):
            one = result.isel({name: cell}).deflection.sel(link="coupler").values
            error = np.sqrt(np.mean((one - truth) ** 2) / np.mean(truth**2))
            count = int(result[name].values[cell])
            yield f"error_{count}", f"{100 * error:.2g} %"
            yield f"evaluations_{count}", f"{int(result.n_evaluations.values[cell]) / 1000:.0f} 000"

    return numbers


def power(value: float) -> str:
    """A small number to one digit, as m·10ⁿ."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}·10{str(int(exponent)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"


def stressed(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Verdicts and ends of scenes under stress, how they closed, their cost; and each law's share."""

    def words(name: str) -> np.ndarray:
        return np.array(result[name].attrs["flag_meanings"].split())[result[name].values]

    verdict, status = words("verdict"), words("scene_status")
    ended = status == "ok"
    yield "scenes", str(len(verdict))
    for word in VERDICTS:
        yield word, str(np.sum(verdict == word))
    for word in ("crashed", "ok", "step_limit", "chatter", "not_converged"):
        yield f"ended_{word}", str(np.sum(status == word))
    yield "ended_otherwise", str(np.sum(~np.isin(status, ["ok", "step_limit", "chatter", "not_converged"])))
    grown = result.growth.values[verdict == "sensitive"] > 1e7
    yield "grown", f"{100 * grown.mean():.0f} %"
    residual = result.energy_residual.values[ended & (verdict != "suspect")]
    times = 1e3 * result.cpu_time.values[ended]
    yield "largest_residual", power(residual.max())
    yield "median_residual", power(np.median(residual))
    yield "disagreement", power(np.median(result.disagreement.values[verdict == "ok"]))
    yield "median_ms", f"{np.nanmedian(1e3 * result.cpu_time.values):.1f}"
    yield "slowest_ms", f"{times.max():.0f}"
    for kind in ("contact", "friction"):
        laws = words(f"{kind}_law")
        answered = {law: np.isin(verdict[laws == law], VERDICTS[:2]).mean() for law in np.unique(laws)}
        ends = (min(answered, key=answered.get), max(answered, key=answered.get))
        yield f"{kind}_laws", " to ".join(f"{100 * answered[law]:.0f} % (`{law}`)" for law in ends)


VERDICTS = ["ok", "sensitive", "stopped", "unconfirmed", "suspect"]
SOLVERS = ["jointplay", "heyoka", "CVODE", "LSODA", "DOP853", "Radau"]


def precision(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """CPU time of a turn at an error reached, ms, a solver a column; then the best peer's over ours."""
    seconds = result.cpu_time_at_error.reindex(solver=SOLVERS)
    for digits in (6, 8, 10):
        ms = 1e3 * seconds.sel(error_level=10.0**-digits, method="nearest").values
        yield f"at_{digits}", row([*ms, np.nanmin(ms[1:]) / ms[0]])
    yield "processor", json.loads(result.attrs["provenance"])["environment"]["processor"]


def table(result: xr.Dataset) -> Iterator[tuple[str, str]]:
    """The rows of a stored table."""
    for name in result.row.values:
        values = result.value.sel(row=name).values
        yield str(name), row(values[: np.flatnonzero(np.isfinite(values))[-1] + 1])
    yield "processor", result.attrs["processor"]


def row(values: Iterable[float]) -> str:
    """Cells of a table: three digits, a dash where there is no number."""
    return " | ".join("–" if math.isnan(value) else f"{float(f'{value:.3g}'):g}" for value in values)


STUDIES: dict[str, Callable[[xr.Dataset], Iterator[tuple[str, str]]]] = {
    "exponents_12a": exponents,
    "exponents_12b": exponents,
    "exponents_12c": exponents,
    "periodic_orbit_12a": orbit,
    "periodic_orbit_12b": orbit,
    "map_clearance_gear_ratio": parameter_map,
    "bifurcation_clearance": diagram,
    "bifurcation_clearance_slow": periods,
    "continuation_linkage": doublings,
    "curve_wedge": wedge,
    "bifurcation_period_doubling": doubled,
    "basins_linkage": basins,
    "attractors_linkage": coexisting,
    "dimension_12c": dimension,
    "chaos_test_12a": verdict,
    "chaos_test_12b": verdict,
    "chaos_test_12c": verdict,
    "sensitivity_12a": growth,
    "sensitivity_12b": growth,
    "sensitivity_12c": growth,
    "claims": claims,
    "stress_others": stressed,
    "elements_coupler": bending("elements"),
    "modes_coupler": bending("modes"),
    **dict.fromkeys(
        (
            "precision_case_a",
            "precision_case_b",
            "precision_case_c",
            "precision_elastic",
            "precision_sticking",
        ),
        precision,
    ),
    **dict.fromkeys(("scenes", "ensembles", "starts", "turns", "valve"), table),
}


def study_digest(name: str) -> str:
    """Digest of the text of a shipped study, or of the benchmark of that name."""
    (path,) = [
        *(ROOT / "studies").rglob(f"{name}.toml"),
        *(ROOT / "tests" / "benchmarks" / "suite").glob(f"{name}.py"),
    ]
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def measured(name: str, path: Path) -> dict[str, str]:
    """Numbers of one result, with the digest of its study."""
    with xr.open_dataset(path) as result:
        return {"study": study_digest(name)} | dict(STUDIES[name](result))


def stored() -> dict[str, dict[str, str]]:
    """Numbers that are on file, by study."""
    return tomllib.loads(STORE.read_text(encoding="utf-8")) if STORE.exists() else {}


def marked(text: str, numbers: dict[str, dict[str, str]]) -> str:
    """A page with its marked numbers replaced by those on file."""

    def put(mark: re.Match) -> str:
        study, name = mark[1].split(".")
        return f"<!--={mark[1]}-->{numbers[study][name]}<!--/-->"

    return MARK.sub(put, text)


def main(folders: list[str]) -> None:
    """Take the numbers from the results in some folders, and put them on the pages."""
    numbers, paths = stored(), [Path(folder) / f"{name}.nc" for folder in folders for name in STUDIES]
    numbers |= {path.stem: measured(path.stem, path) for path in paths if path.exists()}
    tables = (
        "\n".join([f"[{study}]", *(f'{name} = "{text}"' for name, text in table.items())])
        for study, table in sorted(numbers.items())
    )
    STORE.write_text("# Written by measured.py.\n\n" + "\n\n".join(tables) + "\n", encoding="utf-8")
    for page in PAGES:
        page.write_text(marked(page.read_text(encoding="utf-8"), numbers), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
