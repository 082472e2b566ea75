"""How many mechanisms made by one drawing lose contact, are chaotic, exceed a limit; and whose fault it is.

Samples of all numbers that have a spread (`spreads`) are followed, each from the same start, or from one that
varies too (`outcomes`). Shares, quantiles, and what they hang on are of these samples (`shares`); where an
event begins at an edge, its share can be had from few runs beside that (`edges`).

Validity: as of the spreads, which are assumed; an error of the model itself is none of theirs.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Annotated, Any, Literal, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.assessment.assess import bearing_area
from jointplay.analysis.assessment.settled import plan
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.gradients import selection
from jointplay.analysis.gradients.gradient import gradient
from jointplay.analysis.gradients.gradient_dataset import IN_PARAMETER, IN_QUANTITY, LABELS, columns
from jointplay.analysis.keywords import Batched, Moving, Names, Share, Small, analysis
from jointplay.analysis.labels import Out, ended, xr
from jointplay.analysis.period import REPEATS
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import section_fits
from jointplay.analysis.sweeps.attractor import RTOL
from jointplay.analysis.sweeps.bifurcation import lanes_fit
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.tolerances import estimates
from jointplay.analysis.tolerances.outcomes import (
    FAILED,
    NO,
    OUTCOMES,
    UNDECIDED,
    YES,
    Questions,
    outcomes,
    rounds,
    usual_events,
)
from jointplay.analysis.tolerances.spreads import (
    Design,
    Spreads,
    dependence_fits,
    joint_of,
    known_quantities,
    parameter_words,
    spreads_fit,
    words_of,
)
from jointplay.display import codes
from jointplay.display.errors import ModelWarning, Problem, strangers, unknown, with_keys
from jointplay.display.number_text import counted, measure, percent, plain
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Flag, Natural, NonNegative, Number, accepts
from jointplay.solver.mechanism.parameters import INITIAL, Parameter
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section, TestSystem
from jointplay.solver.motion.ensemble_runs import in_lanes
from jointplay.solver.motion.progress import part

BLOCK, STILL_OPEN = 128, 32  # samples of a cell; fewer of those followed on, so that no worker waits
SAMPLES, TURNS, TRANSIENT, LYAPUNOV_TURNS, ROWS, EDGE_RUNS = 1000, 50, 150, 200, 128, 100
WITHIN, ABOVE = "within_limits", "above:"
SAID = {"contact_loss": "lose contact", "doubling": "have left period 1", "chaos": "are chaotic"}
SAID |= {WITHIN: "are within all limits"}
TELLING = 1.0  # width of the interval of a Sobol' share, beyond which it says nothing
TRUSTED = 0.1  # relative difference of deviations up to which the derivative's one is
TOLD = ("no", "yes")
LINE = 2.5  # normal scores to either side over which an edge is drawn
PARTS = (0.0, 0.9, 0.95, 1.0)  # of the progress: samples, edge, derivatives


def answer(result: xr.Dataset) -> str:
    """Shares with their intervals, quantiles, whose fault it is, and what narrower spreads bring."""
    total = counted(result.sizes["sample"], "sample")
    lines = [f"{total}; each share with its 95 % interval"]
    limits = sum(str(name).startswith(ABOVE) for name in result["event"].values)
    for i, name in enumerate(result["event"].values):
        if name == WITHIN and limits == 1:
            continue  # it is the other side of the one limit
        one = result.isel(event=i)
        known = bool(np.isfinite(one["share"]))
        share = _percent(one, "share") if known else "unknown how many"
        lines.append(f"{share} {_said(one, str(name))}{_rest(one)}")
        lines += [
            f"  {line}" for line in (*_fault(result, str(name)), *_changes(one), *_by_edge(one, str(name)))
        ]
    for i in range(result.sizes.get("quantity", 0)):
        one = result.isel(quantity=i)
        if not np.isfinite(one["quantity_value"]).any():
            lines.append(f"{one['quantity_name'].item()}: no sample has a value")
            continue
        units = str(one["quantity_units"].item())
        low, middle, high = (
            measure(float(one["quantile_value"].sel(quantile=q)), units, 3) for q in (0.05, 0.5, 0.95)
        )
        lines.append(f"{one['quantity_name'].item()}: {middle}, 90 % from {low} to {high}{_linear(one)}")
        lines += [f"  {line}" for line in _fault(result, str(one["quantity"].item()))]
    return "\n".join([*lines, *_cheapest(result)])


def _percent(one: xr.Dataset, name: str) -> str:
    """A share in per cent, with its interval."""
    return percent(*(float(one[key]) for key in (name, f"{name}_low", f"{name}_high")))


def _said(one: xr.Dataset, name: str) -> str:
    if name in SAID:
        return SAID[name]
    limit = measure(float(one["limit"]), str(one["limit_units"].item()))
    return f"exceed {limit} ({words_of(name.removeprefix(ABOVE))[0]})"


def _rest(one: xr.Dataset) -> str:
    """The share that is neither yes nor no."""
    share = {word: float(one[f"share_{word}"]) for word in ("undecided", "failed")}
    texts = [f"{plain(100 * each, 3)} % {word}" for word, each in share.items() if each > 0]
    return f"; {', '.join(texts)}" if texts else ""


def _fault(result: xr.Dataset, output: str) -> Iterator[str]:
    """The factor with the largest total share of an output."""
    if "total" not in result or result.sizes["factor"] < 2:
        return
    one = result.sel(output=output)
    if np.isfinite(one["total"]).any():
        best = one.isel(factor=int(np.nanargmax(one["total"].values)))
        if float(best["total_high"] - best["total_low"]) > TELLING:
            return
        value, low, high = (plain(float(best[key]), 2) for key in ("total", "total_low", "total_high"))
        yield f"most by {best['factor_name'].item()}: total Sobol' share {value} ({low} to {high})"


def _changes(one: xr.Dataset) -> Iterator[str]:
    """The single change that moves the share most."""
    if "narrowed_share" not in one or not np.isfinite(one["narrowed_share"]).any():
        return
    moved = np.abs(one["narrowed_share"].values - float(one["share"]))
    best = one.isel(factor=int(np.nanargmax(moved)))
    if float(np.nanmax(moved)) > 0:
        share = plain(100 * float(one.attrs["narrowed"]), 3)
        narrowed = _percent(best, "narrowed_share")
        yield f"with {share} % of the spread of {best['factor_name'].item()}: {narrowed}"


def _by_edge(one: xr.Dataset, name: str) -> Iterator[str]:
    if "edge_share" not in one or str(one["edge_event"].item()) != name:
        return
    found, runs = str(codes.words(one["edge_found"]).item()), int(one["edge_runs"])
    along = one["parameter_name"].sel(parameter=one.attrs["edge_parameter"]).item()
    if found == "no_edge":
        yield f"no edge along {along} within {estimates.REACH:g} standard deviations"
    elif found == "undecided":
        yield f"no edge is located along {along}: some motions there are undecided or failed"
    elif found == "unclear":
        yield f"samples do not go by edges along {along}: the share is that of the samples alone"
    else:
        missed = plain(100 * float(one["edge_exceptions"]), 2)
        places = ", ".join(
            measure(float(v), str(one["edge_place"].attrs["units"]), 6) for v in one["edge_place"].values
        )
        yield (
            f"by the edge along {along} at {places}, with {counted(runs, 'run')} more: "
            f"{_percent(one, 'edge_share')}; of samples far from it at most {missed} % are exceptions"
        )


def _linear(one: xr.Dataset) -> str:
    """The answer of the derivative beside that of the samples."""
    if "linear_deviation" not in one:
        return "; no derivatives: there is no periodic motion at the medians" * ("derivative" in one)
    if not np.isfinite(one["linear_deviation"]):
        return ""
    units = str(one["quantity_units"].item())
    both = (measure(float(one[name]), units, 3) for name in ("deviation", "linear_deviation"))
    word = "" if int(one["linear_trusted"]) else ", which is not to be trusted here"
    return "; standard deviation {}, by derivatives {}{}".format(*both, word)


def _cheapest(result: xr.Dataset) -> list[str]:
    if "cheapest" not in result:
        return []
    wanted = f"{plain(100 * result.attrs['wanted'], 3)} % within all limits"
    if not np.isfinite(result["cheapest_yield"]):
        return [f"no set of narrower spreads is known to bring {wanted}"]
    names = [str(name) for name in result["factor_name"].values[result["cheapest"].values == 1]]
    price = plain(float(result["cheapest_price"]), 4)
    what = f"narrow {', '.join(names) or 'none'}, for {price}"
    return [f"cheapest for {wanted}: {what}: {_percent(result, 'cheapest_yield')}"]


def _interval(name: str, dims: Any, text: str, units: str = "1") -> dict[str, Out]:
    """A value with the ends of its 95 % interval."""
    ends = {
        f"{name}_low": f"lower end of the 95 % interval: {text}",
        f"{name}_high": f"upper end of it: {text}",
    }
    return {name: Out(dims, text, units)} | {key: Out(dims, each, units) for key, each in ends.items()}


BY_FACTOR = ("event", "factor")
OUTPUTS = Outputs(
    "tolerances",
    {
        "parameter": LABELS["parameter"],
        "factor": Out("factor", "parameter, or parameters of one batch", ""),
        "event": Out("event", "what is asked: an event, or after above: a quantity with a limit", ""),
        "quantity": LABELS["quantity"],
        "output": Out("output", "event or quantity", ""),
        "quantile": Out("quantile", "share of the samples below"),
    },
    {
        "value": Out(("sample", "parameter"), f"value, {IN_PARAMETER}"),
        **{name: LABELS[name] for name in ("parameter_units", "parameter_name")},
        "factor_name": Out("factor", "the parameter, or the first one of a batch and how many more", ""),
        "outcome": Out(("sample", "event"), "what happens", flags=OUTCOMES),
        "period": Out("sample", "period in turns; 0: none found; -1: not looked for, or failed"),
        "sample_status": Out("sample", "how the sample ended", flags=STATUS),
        "trouble": Out("sample", "what went wrong", ""),
        "limit": Out("event", "limit, in the units of limit_units"),
        "limit_units": Out("event", "units of the limit", ""),
    }
    | _interval("share", "event", "share of the decided samples; its interval is of all")
    | {
        "share_undecided": Out("event", "share of the samples that are undecided"),
        "share_failed": Out("event", "share of the samples that failed"),
        "quantity_value": Out(("sample", "quantity"), f"value, {IN_QUANTITY}"),
        **{name: LABELS[name] for name in ("quantity_name", "quantity_units")},
        "deviation": Out("quantity", f"standard deviation, {IN_QUANTITY}"),
    }
    | _interval("mean", "quantity", f"mean, {IN_QUANTITY}")
    | _interval("quantile_value", ("quantity", "quantile"), f"quantile, {IN_QUANTITY}")
    | _interval("first_order", ("output", "factor"), "first-order Sobol' share of the variance")
    | _interval("total", ("output", "factor"), "total Sobol' share of the variance")
    | _interval("narrowed_share", BY_FACTOR, "share with the spread of one factor narrowed")
    | {
        "derivative": Out(
            ("quantity", "parameter"), "derivative at the medians, quantity_units over parameter_units"
        ),
        "linear_deviation": Out("quantity", f"standard deviation by derivatives, {IN_QUANTITY}"),
        "linear_share": Out(("quantity", "factor"), "share of the variance by derivatives"),
        "linear_trusted": Out(
            "quantity", "whether derivatives may be trusted here", flags=TOLD, missing="no"
        ),
        "cheapest": Out("factor", "whether the cheapest set narrows its spread", flags=TOLD, missing="no"),
        "cheapest_price": Out((), "price of the cheapest set"),
    }
    | _interval("cheapest_yield", (), "share within all limits with the cheapest set")
    | {
        "edge_event": Out((), "event whose edge is located", ""),
        "edge_found": Out((), "whether it is", flags=estimates.FOUND),
        "edge_place": Out("edge", "{name} at the edge, other parameters at their medians", "{units}"),
        "edge_across": Out(("factor", "line"), f"value of another parameter, {IN_PARAMETER}"),
        "edge_line": Out(
            ("edge", "factor", "line"), "{name} at the edge there, others at medians", "{units}"
        ),
        "edge_band": Out((), "half-width of the band about the edge, in normal scores"),
        "edge_runs": Out((), "runs that the edge took"),
        "edge_exceptions": Out(
            (), "largest share of samples beyond the band that go not by the edge, with 95 %"
        ),
    }
    | _interval("edge_share", (), "share of the event by its edge")
    | OUTCOME,
    answer,
    shown={"share": "share"},
)
Edge = Annotated[
    dict[str, str], accepts("a table of one event and the parameter along which its edge is sought,")
]
Limits = Annotated[dict[str, Number], accepts("a table of quantities, each with its largest accepted value,")]
Prices = Annotated[
    dict[str, NonNegative], accepts("a table of parameters, each with the price of a narrower spread,")
]
Batches = Annotated[tuple[tuple[str, ...], ...], accepts("a list of lists of parameters,")]
Matrix = Annotated[tuple[tuple[Number, ...], ...], accepts("a list of rows of numbers,")]


def _asked_fits(
    mechanism: Mechanism | TestSystem,
    events: Names | None,
    of: Names | None,
    limits: Limits | None,
    turns: int,
) -> Iterator[Problem]:
    """Yield the problems of events and quantities that the mechanism has not."""
    able = usual_events(mechanism)
    yield from strangers(with_keys("events", events), able, "event")
    if turns < REPEATS and (usual_events(mechanism) if events is None else events):
        yield Problem("turns", turns, f"at least {REPEATS} are accepted, or events = []")
    named = [*with_keys("of", of), *((f"limits.{name}", name) for name in limits or ())]
    known = known_quantities(mechanism) if named else []
    for place, name in named:
        if name not in known:
            yield unknown(place, name, name, known, "quantity")
        elif name.startswith("pressure:") and not np.isfinite(bearing_area(joint_of(mechanism, name))):
            yield Problem(place, name, "radius and length of the bearing are needed for its pressure")
    if events == () and not named:
        yield Problem("events", events, "an event, or a quantity in of or limits, is accepted")


def _causes_fit(
    spreads: Spreads,
    correlation: Matrix | None,
    shares: int | None,
    prices: Prices | None,
    wanted: float | None,
    limits: Limits | None,
    together: Batches,
) -> Iterator[Problem]:
    """Yield the problems of questions about causes."""
    if correlation is not None and shares:
        yield Problem(
            "shares", shares, "0 is accepted beside correlation: Sobol' shares are of independent numbers"
        )
    if (prices is None) != (wanted is None):
        key, given = ("wanted", wanted) if wanted is None else ("prices", prices)
        yield Problem(key, given, "prices and wanted, the share within limits, are accepted together")
    elif prices is not None and (not limits or correlation is not None):
        yield Problem("prices", prices, "accepted beside limits, and without correlation")
    heads = {batch[0] for batch in together} | {*spreads} - {key for batch in together for key in batch}
    priced = ((f"prices.{key}", key) for key in prices or ())
    yield from strangers(priced, sorted(heads), "parameter, or first one of a batch,")
    if len(prices or ()) > estimates.MOST_SUBSETS:
        yield Problem("prices", len(prices), f"at most {estimates.MOST_SUBSETS} prices are accepted")


def _edge_fits(
    mechanism: Mechanism | TestSystem,
    spreads: Spreads,
    events: Names | None,
    limits: Limits | None,
    edge: Edge | None,
) -> Iterator[Problem]:
    """Yield the problems of the edge to be found."""
    if edge is None:
        return
    if len(edge) != 1:
        yield Problem("edge", edge, "one event is accepted")
    able = [*(usual_events(mechanism) if events is None else events), *(limits or ())]
    for name, key in edge.items():
        if name not in able:
            yield unknown(f"edge.{name}", name, name, able, "event or limited quantity")
        if key not in spreads:
            yield unknown(f"edge.{name}", key, key, [*spreads], "parameter with a spread")
        elif spreads[key].values is not None:
            yield Problem(f"edge.{name}", key, "a parameter with a continuous spread is accepted")


@growing
@analysis(
    spreads_fit,
    dependence_fits,
    _asked_fits,
    _causes_fit,
    _edge_fits,
    section_fits,
    rules.turns_alike,
    "model",
    lanes_fit,
    varied=lambda mechanism: mechanism,
    model=rules.on_section,
    outputs=OUTPUTS,
    usual={"rtol": RTOL, "transient": TRANSIENT},
)
def tolerances(
    mechanism: Moving,
    *,
    spreads: Spreads,
    together: Batches = (),
    correlation: Matrix | None = None,
    events: Names | None = None,
    of: Names | None = None,
    limits: Limits | None = None,
    samples: Natural = SAMPLES,
    sequence: Literal["sobol", "random"] = "sobol",
    seed: Count = 0,
    section: Section = ONCE_A_TURN,
    turns: Natural = TURNS,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    shares: Count | None = None,
    narrowed: Small = 0.5,
    prices: Prices | None = None,
    wanted: Share | None = None,
    edge: Edge | None = None,
    edge_runs: Natural = EDGE_RUNS,
    derivatives: Flag = True,
    **motion: Unpack[Batched],
) -> xr.Dataset:
    """Give the shares of mechanisms made by one drawing that lose contact, are chaotic, or exceed limits.

    A sample that failed has its status and a reason. What is neither periodic nor surely chaotic is
    undecided: it counts in no share, and widens each interval.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    spreads : dict of str to Spread
        Parameters that vary, by name or key path as in `[vary]`, or states of a test system's start as
        ``initial.NAME``; each with its spread, as ``{"normal": [5e-5, 8e-6], "above": 2e-5}``.
    together : sequence of sequence of str
        Parameters of one batch, which are high or low together.
    correlation : sequence of sequence of float, optional
        Matrix of correlations of the parameters' normal scores, in the order of `spreads`.
    events : sequence of {"contact_loss", "doubling", "chaos"}, optional
        What is asked of each sample; all that it can have if left out. ``doubling``: the motion has left
        period 1.
    of : sequence of str, optional
        Quantities of which mean and quantiles are given: largest, smallest and end values as of `gradient`
        (``largest:normal_force:B``), of joints ``force``, ``impact_speed``, ``pressure``, ``sliding_work``,
        ``impact_loss``, ``friction_loss``, ``separations`` and ``impacts`` (``force:B``), and ``period``.
    limits : dict of str to float, optional
        Largest accepted value of quantities.
    samples : int
        Number of samples; fewer are the first of more.
    sequence : {"sobol", "random"}
        Scrambled points of Sobol's sequence, or pseudo-random ones.
    seed : int
        Of the random numbers.
    section : Section
        Where the motion is cut to see whether it repeats itself; once a turn at crank angle 0 if left out.
    turns : int
        Number of turns, or periods of the forcing, that are looked at.
    lyapunov_turns : int
        Number of turns over which the exponent of a motion without a period is averaged.
    shares : int, optional
        Number of samples of which Sobol' shares are computed, each by one more run for each parameter and
        one; if left out 128, and none of a single parameter or beside `correlation`.
    narrowed : float
        Share of its spread that one parameter is narrowed to, about its median, in the table of changes.
    prices : dict of str to float, optional
        Price of narrowing each spread so; with `wanted`.
    wanted : float, optional
        Share of the samples that is to be within all limits: the cheapest set of narrower spreads is sought.
    edge : dict of str to str, optional
        An event, or a limited quantity, and the parameter along which its edge is located; its share is then
        computed by runs beside the edge, too.
    edge_runs : int
        Number of these runs.
    derivatives : bool
        Whether derivatives of quantities at the medians are computed, where there are such.

    Raises
    ------
    InputError
        If anything asked for makes no sense, listing all of it; numerical trouble is a status instead.
    """
    began, names = time.perf_counter(), dict(limits or {})
    design = Design(spreads, together, correlation, sequence, seed)
    own_events = usual_events(mechanism) if events is None else tuple(dict.fromkeys(events))
    quantities = tuple(dict.fromkeys([*(of or ()), *names]))
    lanes = in_lanes(motion["ensemble"], mechanism, motion["rtol"], samples)
    how = plan(motion["transient"], turns, lyapunov_turns, motion["rtol"], motion["max_steps"])
    questions = Questions(replace(how, section=section, ensemble=lanes), own_events, quantities)
    run = partial(_run, mechanism, motion["initial"], design, n_jobs=motion["n_jobs"])
    tell = [part(motion["progress"], *pair) for pair in pairwise(PARTS)]
    undivided = correlation is not None or len(design.factors) < 2  # no shares of causes
    rows = min((0 if undivided else ROWS) if shares is None else shares, samples)
    factors = design.drawn(samples)
    own = design.scores(factors[:, : len(design.factors)])
    main, *mixed = run(questions, names, [own, *(_mixed(design, factors[:rows]) if rows else [])], tell[0])
    table = _labels(mechanism, design, main, names) | _of_samples(main, sequence == "sobol")
    if rows:
        table |= _causes(main.part(slice(rows)), mixed, seed)
    if correlation is None and main.events:
        ratios = _ratios(design, main.values, narrowed)
        table |= _narrowed(main, ratios)
        if prices is not None:
            table |= _cheapest_set(main, ratios, _factor_names(design), prices, wanted)
    of_edge, attributes = None, {"narrowed": narrowed, **({"wanted": wanted} if wanted else {})}
    if edge is not None:
        ((event, key),) = edge.items()
        of_edge, attributes["edge_parameter"] = parameter_words(mechanism, key), key
        alone = replace(questions, events=(event,) * (event in SAID), quantities=(event,) * (event in names))
        limit = {name: each for name, each in names.items() if name == event}
        table |= _edge(
            lambda scores: run(alone, limit, [scores], tell[1])[0].outcome(_named(event)),
            *(design, own, main, edge, edge_runs),
        )
    if derivatives:
        table |= _linear_answer(mechanism, design, main, table, motion["rtol"], motion["n_jobs"])
    status = first_bad([{"status": each} for found in (main, *mixed) for each in found.ended])
    of_edge = of_edge and dict(zip(("name", "units"), of_edge, strict=True))
    return OUTPUTS.dataset(table | ended(status, began), of_edge, **attributes)


tolerances.bounds = {"samples"}  # type: ignore[attr-defined]  # fewer samples are the first of more


@dataclass(frozen=True)
class Found:
    """Outcomes of samples; arrays over these first.

    Parameters
    ----------
    values : ndarray, shape (n, parameters)
        Of the parameters.
    ended : ndarray of int
        Status of each.
    trouble : ndarray of str
        What went wrong.
    period : ndarray of int
        In turns.
    events : tuple of str
        Names of the events and of the quantities with limits, and `WITHIN`.
    event : ndarray of int, shape (n, events)
        Outcomes, of `OUTCOMES`.
    quantities : tuple of str
        Names.
    quantity : ndarray, shape (n, quantities)
        Their values.
    """

    values: np.ndarray
    ended: np.ndarray
    trouble: np.ndarray
    period: np.ndarray
    events: tuple[str, ...]
    event: np.ndarray
    quantities: tuple[str, ...]
    quantity: np.ndarray

    @classmethod
    def none(cls, values: np.ndarray, questions: Questions) -> Found:
        """Nothing yet: each sample has failed."""
        n, (events, quantities) = len(values), (questions.events, questions.quantities)
        ended, trouble, period = np.zeros(n, np.int8), np.full(n, "", dtype=object), np.full(n, -1, np.int32)
        event, quantity = np.full((n, len(events)), FAILED, np.int8), np.full((n, len(quantities)), np.nan)
        return cls(values, ended, trouble, period, events, event, quantities, quantity)

    def put(self, block: np.ndarray, answer: Mapping[str, Any]) -> None:
        """Take in the answer of a block; where it failed as a whole, each sample has."""
        if answer["status"]:
            answer = {"ended": answer["status"], "trouble": answer.get("trouble", ""), "event": FAILED}
        for name in {"ended", "trouble", "period", "event", "quantity"} & answer.keys():
            getattr(self, name)[block] = answer[name]

    def limited(self, limits: Mapping[str, float]) -> Found:
        """The same with the outcomes of limits, and of all of them together."""
        if not limits:
            return self
        x = self.quantity[:, [self.quantities.index(name) for name in limits]]
        none = [np.broadcast_to(self.ended[:, None] != 0, x.shape), np.isnan(x)]
        over = np.select(none, [FAILED, UNDECIDED], np.where(x > [*limits.values()], YES, NO))
        each = [np.any(over == code, axis=1) for code in (YES, FAILED, UNDECIDED)]
        within = np.select(each, [NO, FAILED, UNDECIDED], YES)
        codes_ = np.column_stack([self.event, over, within]).astype(np.int8)
        return replace(self, events=(*self.events, *(ABOVE + name for name in limits), WITHIN), event=codes_)

    def part(self, which: slice) -> Found:
        """Some of the samples."""
        names = ("values", "ended", "trouble", "period", "event", "quantity")
        return replace(self, **{name: getattr(self, name)[which] for name in names})

    def outcome(self, event: str) -> np.ndarray:
        """Outcome of an event."""
        return self.event[:, self.events.index(event)]

    @property
    def outputs(self) -> np.ndarray:
        """Events as 0 and 1, undecided ones NaN, and quantities; shape (n, events and quantities)."""
        return np.hstack([np.where(self.event <= YES, self.event, np.nan), self.quantity])


def _run(
    mechanism: Any,
    initial: Any,
    design: Design,
    questions: Questions,
    limits: Mapping[str, float],
    parts: Sequence[np.ndarray],
    progress: Any,
    n_jobs: int | None,
) -> list[Found]:
    """Follow samples at normal scores, those of each part by themselves; what stays open is followed on."""
    values = design.values(np.concatenate(parts))
    bounds = np.cumsum([0, *map(len, parts)])
    whole = Found.none(values, questions)
    blocks = [
        np.arange(i, min(i + BLOCK, end)) for begin, end in pairwise(bounds) for i in range(begin, end, BLOCK)
    ]
    shared = {"mechanism": mechanism, "initial": initial}
    ready = partial(_warm, mechanism, questions.plan.ensemble)
    ends: dict[int, Any] = {}
    for plan_ in rounds(questions.plan):
        shared["questions"] = replace(questions, plan=plan_)
        cells = [shared | {"changes": design.changes(values[block])} for block in blocks]
        for cell, block in zip(cells, blocks, strict=True) if ends else ():
            cell["ends"] = [ends[i] for i in block]
        answers = handed_out(
            outcomes, cells, None if ends else progress, n_jobs, lasting="sample", ready=ready
        )
        ends = {}
        for block, answer in zip(blocks, answers, strict=True):
            whole.put(block, answer)
            ends |= {int(block[int(i)]): end for i, end in answer.get("open", {}).items()}
        if not ends:
            break
        left = np.array([*ends])
        blocks = [left[i : i + STILL_OPEN] for i in range(0, len(left), STILL_OPEN)]
    found = whole.limited(limits)
    return [found.part(slice(*pair)) for pair in pairwise(bounds)]


def _warm(mechanism: Any, lanes: bool) -> None:
    """Compile the functions that samples need, so that workers find them on the disk."""
    model = assemble(mechanism)
    warm([model], lanes)
    warm_tangents(model)


def _named(event: str) -> str:
    """An event as its dimension has it, of a limited quantity by the quantity's name."""
    return event if event in SAID else ABOVE + event


def _factor_names(design: Design) -> list[str]:
    keys = list(design.spreads)
    return [" + ".join(keys[i] for i in group) for group in design.factors]


def _labels(mechanism: Any, design: Design, main: Found, limits: Mapping[str, float]) -> dict[str, Any]:
    """Labels of all dimensions, and what they stand for."""
    words = [parameter_words(mechanism, key) for key in design.spreads]
    nouns = [words[first][0] + f" and {len(more)} more" * bool(more) for first, *more in design.factors]
    limited = [name.removeprefix(ABOVE) for name in main.events]
    table = columns("parameter", [*design.spreads], words) | {
        "factor": np.array(_factor_names(design), dtype=str),
        "factor_name": np.array(nouns, dtype=str),
        "event": np.array(main.events, dtype=str),
        "limit": np.array([limits.get(name, np.nan) for name in limited]),
        "limit_units": np.array([words_of(n)[1] if n in limits else "1" for n in limited], dtype=str),
        "output": np.array([*main.events, *main.quantities], dtype=str),
    }
    if main.quantities:
        table |= columns("quantity", main.quantities, list(map(words_of, main.quantities)))
        table["quantile"] = np.array(estimates.QUANTILES)
    return table


def _ends(name: str, found: Any) -> dict[str, np.ndarray]:
    """A value and the ends of its interval, along the last axis."""
    each = np.moveaxis(np.array(found, dtype=float), -1, 0)
    return dict(zip((name, f"{name}_low", f"{name}_high"), each, strict=True))


def _of_samples(main: Found, replicated: bool) -> dict[str, Any]:
    """Samples as they are, shares of events, means and quantiles of quantities."""
    table = {
        "value": main.values,
        "outcome": main.event,
        "period": main.period,
        "sample_status": main.ended,
        "trouble": main.trouble.astype(str),
        "share_undecided": np.mean(main.event == UNDECIDED, axis=0),
        "share_failed": np.mean(main.event == FAILED, axis=0),
    }
    if main.events:
        table |= _ends("share", [estimates.share(each, replicated) for each in main.event.T])
    if not main.quantities:
        return table
    columns = main.quantity.T
    table |= {"quantity_value": main.quantity, "deviation": _deviation(main.quantity)}
    table |= _ends("mean", [estimates.mean(each, replicated) for each in columns])
    every = [[estimates.quantile(each, q) for q in estimates.QUANTILES] for each in columns]
    return table | _ends("quantile_value", every)


def _deviation(numbers: np.ndarray) -> np.ndarray:
    """Standard deviation of the known values of each quantity."""
    known = np.sum(np.isfinite(numbers), axis=0)
    return np.where(known > 1, np.nanstd(np.where(known > 1, numbers, 0.0), axis=0), np.nan)


def _mixed(design: Design, factors: np.ndarray) -> list[np.ndarray]:
    """Scores of the second rows, and of the first ones with each factor of the second."""
    width = len(design.factors)
    first, second = factors[:, :width], factors[:, width:]
    each = [np.where(np.arange(width) == i, second, first) for i in range(width)]
    return [design.scores(rows) for rows in (second, *each)]


def _causes(first: Found, mixed: Sequence[Found], seed: int) -> dict[str, Any]:
    """Sobol' shares of every event and quantity."""
    f_a, f_b, *f_ab = (found.outputs.T for found in (first, *mixed))
    every = [
        estimates.sobol(f_a[k], f_b[k], np.stack([each[k] for each in f_ab]), seed) for k in range(len(f_a))
    ]
    first_order, total = np.moveaxis(np.array(every), 1, 0)
    return _ends("first_order", np.moveaxis(first_order, 1, -1)) | _ends("total", np.moveaxis(total, 1, -1))


def _ratios(design: Design, values: np.ndarray, narrowed: float) -> np.ndarray:
    """Ratios of densities with each factor narrowed, shape (n, factors); NaN where there is no density."""
    found = np.full((len(values), len(design.factors)), np.nan)
    for place, group in enumerate(design.factors):
        if all(design.laws[i].whole for i in group):
            each = np.array([design.laws[i].narrowed(values[:, i], narrowed) for i in group])
            found[:, place] = each[0] if np.allclose(each, each[0], rtol=1e-6) else np.nan
    return found


def _narrowed(main: Found, ratios: np.ndarray) -> dict[str, Any]:
    """Share of each event with one spread narrowed."""
    return _ends(
        "narrowed_share",
        [[estimates.weighed(outcome, ratio) for ratio in ratios.T] for outcome in main.event.T],
    )


def _cheapest_set(
    main: Found, ratios: np.ndarray, names: Sequence[str], prices: Mapping[str, float], wanted: float
) -> dict[str, Any]:
    """The cheapest set of narrower spreads for a share within all limits."""
    priced = np.array([prices.get(name.partition(" + ")[0], np.nan) for name in names])
    priced[np.isnan(ratios).any(axis=0)] = np.nan
    chosen, found = estimates.cheapest(main.outcome(WITHIN), ratios, priced, wanted)
    price = float(np.sum(priced[chosen])) if np.isfinite(found[0]) else np.nan
    return {"cheapest": chosen.astype(int), "cheapest_price": price} | _ends("cheapest_yield", found)


def _edge(
    look: estimates.Look, design: Design, own: np.ndarray, main: Found, edge: Mapping[str, str], runs: int
) -> dict[str, Any]:
    """The edge of an event along a parameter, and the share by it."""
    ((event, key),) = edge.items()
    number = list(design.spreads).index(key)
    factor = next(i for i, group in enumerate(design.factors) if number in group)
    found, edges, count = estimates.located(look, len(design.factors), factor)
    by = None
    if edges is not None:
        by = estimates.by_edges(edges, design, own, main.outcome(_named(event)), look, runs)
        found = found if by else estimates.UNCLEAR
    table: dict[str, Any] = {"edge_event": _named(event), "edge_found": found}
    if edges is not None:
        at = np.outer(edges.places, np.arange(len(design.factors)) == factor)
        table["edge_place"] = design.values(at)[:, number]
        table |= _lines(edges, design, number)
    by = by or estimates.EdgeShare((np.nan,) * 3, np.nan, np.nan, 0)
    table |= {"edge_band": by.half_width, "edge_exceptions": by.exceptions, "edge_runs": count + by.runs}
    return table | _ends("edge_share", by.share)


def _lines(edges: estimates.Edges, design: Design, number: int) -> dict[str, np.ndarray]:
    """The edges over each other factor, those beside it at their medians."""
    scores = np.linspace(-LINE, LINE, 33)
    across = np.full((len(design.factors), len(scores)), np.nan)
    lines = np.full((len(edges.places), *across.shape), np.nan)
    for place, group in enumerate(design.factors):
        if place != edges.factor:
            at = np.outer(scores, np.arange(len(design.factors)) == place)
            across[place] = design.values(at)[:, group[0]]
            for line, surface in zip(lines, edges.surfaces(at).T, strict=True):
                at[:, edges.factor] = surface
                line[place] = design.values(at)[:, number]
    return {"edge_across": across, "edge_line": lines}


def _linear_answer(
    mechanism: Any, design: Design, main: Found, table: Mapping[str, Any], rtol: float, n_jobs: int | None
) -> dict[str, Any]:
    """Derivatives of quantities at the medians, and deviations by them; empty where there are none."""
    names = [name for name in main.quantities if name.partition(":")[0] in selection.POINTS]
    smooth = all(not key.startswith(INITIAL) and Parameter(mechanism, key).smooth for key in design.spreads)
    if not names or not smooth or design.correlation is not None:
        return {}
    medians = {k: law.median for k, law in zip(design.spreads, design.laws, strict=True)}
    cell = {"mechanism": mechanism, "medians": medians, "of": tuple(names), "rtol": rtol}
    (found,) = handed_out(_derivatives, [cell], None, n_jobs, lasting="derivative")
    slopes = np.full((len(main.quantities), len(design.spreads)), np.nan)
    if found["status"]:
        return {"derivative": slopes, "linear_trusted": np.zeros(len(slopes))}
    slopes[[main.quantities.index(name) for name in names]] = found["derivative"]
    moves = slopes * [law.deviation for law in design.laws]
    parts = np.stack([moves[:, group].sum(axis=1) ** 2 for group in design.factors], axis=-1)
    variance = parts.sum(axis=1)
    alike = len({*main.period.tolist()}) == 1 and not found["doubtful"]
    with np.errstate(divide="ignore", invalid="ignore"):
        near = np.abs(np.sqrt(variance) / table["deviation"] - 1) < TRUSTED
        table = {"derivative": slopes, "linear_share": parts / variance[:, None]}
    return table | {"linear_deviation": np.sqrt(variance), "linear_trusted": (near & alike).astype(int)}


def _derivatives(
    mechanism: Any, medians: Mapping[str, float], of: tuple[str, ...], rtol: float
) -> dict[str, Any]:
    """Derivatives of quantities of the periodic orbit at the medians."""
    # what is doubtful is said in the answer
    with warnings.catch_warnings(action="ignore", category=ModelWarning):
        found = gradient(
            mechanism.varied(medians), of=of, by=tuple(medians), orbit=True, rtol=min(rtol, 1e-8)
        )
    doubtful = bool(int(found["derivative_status"]))
    return {"status": int(found["status"]), "derivative": found["derivative"].values, "doubtful": doubtful}
