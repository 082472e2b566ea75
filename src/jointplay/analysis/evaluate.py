"""Labelled quantities, evaluated from records of states, and variables that every dataset of a run holds.

Accelerations are right also where the motion's own steps are too coarse for them. An acceleration amplifies
the error of a state by the fastest rate of the equations: by 10^6 per second at the motor's line. Where
friction turns over, that line answers within microseconds; a step of the motion passes over this, and its
polynomial keeps a part of it that is nothing for a speed and much for an acceleration. The flow notes such
steps (method.record). What they recorded is here followed anew, from the beginning of each step, by two steps
or more and with a thousandth of the tolerance; only accelerations, and what depends on them, are taken from
there. The motion and all else that is recorded stay as they are.

Of an interrupted run with very many samples every n-th one is evaluated, so that it ends within a second.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis.labels import KEPT, Out, flags, xr
from jointplay.analysis.quantities import BALANCE, MODES, STATUS, WORDS, WORK
from jointplay.display.errors import warn
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.model import DEEP, Model
from jointplay.solver.method.codes import COUNTERS, Mode
from jointplay.solver.motion.guard_tolerances import ends
from jointplay.solver.motion.progress import Aborted, Stopped, ticked
from jointplay.solver.motion.trajectory import INTERRUPTED, Records, Request, functions, memory

NEAR = 0.5  # share of the penetration at which a law ends that is told: it is made for far less
BLOCK = 4096  # rows evaluated at a time, which stay in a processor's cache
STRANGE = re.compile(r"[^\w.+@-]")  # what a word of flags cannot hold

CLOSER = 1e-3  # of the tolerance
LEAST = 1e-13  # tolerance at which rounding begins
ATTEMPTS = 10_000  # in one step of the motion
MOST = 100_000  # samples of an interrupted motion whose quantities are evaluated: a tenth of a second
TOGETHER = 256  # coarse in a compiled call, which no interrupt ends
END, TIME = 1, 2  # columns of a coarse step


class Quantities:
    """Quantities of rows of records (time, positions, speeds, modes, work), computed when first used.

    Those that depend on accelerations are taken from `sharp` instead, where it is given.
    """

    def __init__(self, model: Model, rows: np.ndarray, start: np.ndarray, sharp: np.ndarray | None = None):
        self.model, self.rows, self.start = model, rows, start
        self.sharp = rows if sharp is None else sharp
        self.module = cache.structure_module(model.structure)
        self._n_state = len(self.module.STATE)

    def of(self, places: slice) -> Quantities:
        """Quantities of some of the rows."""
        sharp = None if self.sharp is self.rows else self.sharp[places]
        return Quantities(self.model, self.rows[places], self.start, sharp)

    @property
    def time(self) -> np.ndarray:
        """Times of the rows, s."""
        return self.rows[:, 0]

    @property
    def modes(self) -> np.ndarray:
        """Modes, shape (rows, contacts and rigid walls)."""
        return self.rows[:, self._n_state : self._n_state + len(self.model.touching)].astype(np.int8)

    def variables(self, names: Iterable[str], dim: str, prefix: str = "") -> dict[str, Any]:
        """Named variables over `dim`, as (dims, values, attributes)."""
        words = {name: WORDS[name] for name in names}
        plain = {name: word for name, word in words.items() if name not in (*BALANCE, "energy", "mode")}
        keys = {
            name: [self.key(name, label) for label in self.labels(word.of)] for name, word in plain.items()
        }
        series = self.series([key for several in keys.values() for key in several])
        none = np.zeros(len(self.rows))  # the moment at a revolute joint
        values = {name: np.stack([series.get(k, none) for k in ks], -1) for name, ks in keys.items() if ks}
        values = {name: each[:, 0] if WORDS[name].of is None else each for name, each in values.items()}
        values |= {name: self._special(name) for name in words if name not in plain}
        dims = {None: (dim,), "bending": (dim, "link"), "guided": (dim, "pin")}
        return {
            prefix + name: (dims.get(word.of, (dim, word.of)), values[name], attributes(name))
            for name, word in words.items()
            if name in values
        }

    def series(self, keys: Sequence[str]) -> dict[str, np.ndarray]:
        """Values a row of those of these outputs that the structure's program has."""
        apart = () if self.sharp is self.rows else self.module.ABRUPT
        found = self._evaluated([key for key in keys if key not in apart], self.rows)
        return found | self._evaluated([key for key in keys if key in apart], self.sharp)

    def _evaluated(self, keys: list[str], rows: np.ndarray) -> dict[str, np.ndarray]:
        """Outputs of the structure's program, one value a row."""
        keys = [key for key in keys if key in self.module.OUTPUTS]
        if not keys:
            return {}
        if len(rows) <= BLOCK:
            values = outputs.evaluate(self.module, keys, self.given(rows))
            return {key: np.broadcast_to(value, len(rows)) for key, value in values.items()}
        whole = {key: np.empty(len(rows)) for key in keys}
        for first in ticked(range(0, len(rows), BLOCK)):
            part = rows[first : first + BLOCK]
            for key, value in outputs.evaluate(self.module, keys, self.given(part)).items():
                whole[key][first : first + BLOCK] = value
        return whole

    def labels(self, of: str | None) -> tuple[str, ...]:
        """Labels of the links, joints or states of a quantity, by the kind of part that it is of."""
        model = self.model
        labels = {"link": model.links, "bending": model.bending, "joint": model.joints, "pin": model.pins}
        labels |= {"guide": model.guides, "guided": model.pins, "state": model.states}
        return labels.get(of, ("",))

    @staticmethod
    def key(name: str, label: str) -> str:
        """Name of an output of the structure's program."""
        if name == "state_value":
            return f"state:{label}"
        return f"{name}:{label}" if label else name

    def given(self, rows: np.ndarray) -> dict[str, Any]:
        """Symbols of the program: state, parameters, masks."""
        given = dict(zip(self.module.STATE, rows[:, : self._n_state].T, strict=True))
        given |= dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True))
        for j, name in enumerate(self.model.touching):
            mode = rows[:, self._n_state + j]
            given[f"touch_{name}"] = (mode > Mode.RELEASED).astype(float)
            given[f"slip_{name}"] = (mode == Mode.SLIP_POSITIVE).astype(float) - (mode == Mode.SLIP_NEGATIVE)
            given[f"stick_{name}"] = (mode == Mode.STICK).astype(float)
        return given

    def _special(self, name: str) -> np.ndarray:
        if name == "mode":
            return self.modes
        if name in BALANCE[1:]:
            return self._work.get(name, np.zeros(len(self.rows)))
        energy = self._mechanical(self.rows)
        if name == "energy":
            return energy + self._stored()
        works = self._work
        taken_in = sum(sign * works[name] for name, sign in WORK.values() if name in works)
        return energy - self._mechanical(self.start[None, :])[0] - taken_in

    @property
    def _work(self) -> dict[str, np.ndarray]:
        """Works since the start that the equations have, by quantity."""
        columns = self.rows[:, self._n_state + len(self.model.touching) :].T
        return dict(zip((WORK[word][0] for word in powers(self.model.structure)), columns, strict=False))

    def _mechanical(self, rows: np.ndarray) -> np.ndarray:
        """Kinetic and potential energy of the links."""
        energies = self._evaluated(["kinetic_energy", "potential_energy"], rows)
        return energies["kinetic_energy"] + energies["potential_energy"]

    def _stored(self) -> np.ndarray:
        """Elastic energy of the contacts."""
        keys = [f"stored_energy:{name}" for name in self.model.joints]
        stored = self._evaluated(keys, self.rows)
        held = (stored[key] * (self.modes[:, j] > Mode.RELEASED) for j, key in enumerate(keys))
        return sum(held, np.zeros(len(self.rows)))


def of_states(
    model: Model, keys: Sequence[str], states: np.ndarray, time: float | np.ndarray = 0.0, **numbers: Any
) -> dict[str, np.ndarray]:
    """Outputs of a structure's program (codegen.outputs) at states and times, arrays of shape (rows,).

    `numbers` stand in place of the model's own.
    """
    module = cache.structure_module(model.structure)
    given = dict(zip(module.STATE, [np.full(len(states), time), *np.asarray(states).T], strict=True))
    given |= dict(zip(module.PARAMETERS, model.numbers, strict=True)) | numbers
    found = outputs.evaluate(module, keys, given)
    return {key: np.broadcast_to(found[key], len(states)) for key in keys}


def mass_matrix(model: Model, state: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Mass matrix at a state, to rounding, from the kinetic energy, which is quadratic in the speeds."""
    n = len(model.turning)
    one, none = np.eye(n), np.zeros((1, n))
    rows = np.tile(state, (n * n + n + 1, 1))
    rows[:, n : 2 * n] = np.concatenate([(one[:, None] + one[None, :]).reshape(-1, n), one, none])
    energy = of_states(model, ["kinetic_energy"], rows, time)["kinetic_energy"]
    both, single, rest = energy[: n * n].reshape(n, n), energy[n * n : -1], energy[-1]
    return both - single[:, None] - single[None, :] + rest


def beyond_the_model(history: Quantities) -> dict[str, str]:
    """Warn of a motion whose journals went far into their bearings; the text as an attribute."""
    model = history.model
    if not model.clearances or not len(history.rows):
        return {}
    depth = history.variables(["penetration"], "row")["penetration"][1]
    deep = [
        f"the journal of {name} goes {deepest / e:.3g} clearances into its bearing"
        + (f", whose law ends at {end / e:.3g}" if end < np.inf else "")
        for name, deepest, e, end in zip(
            model.joints, np.nanmax(depth, axis=0, initial=0.0), model.clearances, ends(model), strict=True
        )
        if deepest > min(DEEP * e, NEAR * end)
    ]
    advice = "please check the start, the units, the loads and the contact data"
    return warn(f"{'; '.join(deep)}: {advice}") if deep else {}


def attributes(name: str) -> dict[str, Any]:
    """Attributes of a variable: units, long name, flags."""
    word = WORDS[name]
    result = {"units": word.units, "long_name": word.long_name}
    return result | flags(MODES) if name == "mode" else result


def joint_flags(model: Model) -> dict[str, Any]:
    """CF attributes of a contact's number, counted from 0: its joint's or wall's name; -1 is none."""
    names = ["none", *(STRANGE.sub("_", name) for name in model.touching)]
    return {"flag_values": np.arange(-1, len(names) - 1, dtype=np.int16), "flag_meanings": " ".join(names)}


def coordinates(model: Model) -> dict[str, Any]:
    """Label coordinates of a model."""
    labels = {
        "link": ("link", model.links),
        "joint": ("joint with clearance", model.joints if model.links else ()),
        "pin": ("ideal joint", model.pins),
        "guide": ("prismatic joint", model.guides),
        "state": ("state", model.states),
    }
    return {
        of: ((of,), np.array(names, dtype=str), {"long_name": text})
        for of, (text, names) in labels.items()
        if names
    }


RUN = {
    "status": Out((), "how the run ended", flags=STATUS, missing=KEPT),
    "wall_time": Out((), "wall time of the run", "s", missing=KEPT),
    "turn_period_nominal": Out((), "nominal period of the drive", "s", missing=KEPT),
    **{name: Out((), text, missing=KEPT) for name, text in COUNTERS.items()},
}


OUTCOME = {name: RUN[name] for name in ("status", "wall_time")}


OF_A_MODEL = RUN | {"clearance": Out("joint", "radial clearance", "m", missing=KEPT)}


def run_values(model: Model, records) -> dict[str, Any]:
    """Status, times and counters of a run, and the clearances of its model."""
    found = {"status": records.status, "wall_time": records.wall_time, "turn_period_nominal": model.period}
    found |= {name: np.int64(records.counts[name]) for name in COUNTERS}
    return found | ({"clearance": np.array(model.clearances)} if model.clearances else {})


def on_joints(dataset: xr.Dataset) -> xr.Dataset:
    """Put the variables of prismatic joints along ``joint``, after the joints with clearance.

    What only joints with clearance have is not a number there; an ideal joint has clearance 0 and touches.
    """
    if "guide" not in dataset.dims:
        return dataset
    sliding = [name for name, each in dataset.data_vars.items() if "guide" in each.dims]
    slides, rest = dataset[sliding].rename(guide="joint"), dataset.drop_dims("guide")
    both = (rest, slides) if "joint" in rest.dims else ()
    if names := list(dict.fromkeys(str(name) for each in both for name in each["joint"].values)):
        whole = {name: each.dtype for name, each in rest.data_vars.items() if "joint" in each.dims}
        fill = {name: 0 for name, kind in whole.items() if kind.kind == "i"} | {"clearance": 0.0}
        fill |= {name: int(Mode.CONTACT) for name in whole if name.split("_")[-1] == "mode"}
        fill = {name: fill.get(name, "" if kind.kind in "UO" else np.nan) for name, kind in whole.items()}
        text = {"long_name": "joint with clearance, or prismatic"}
        rest = rest.reindex(joint=np.array(names, dtype=str), fill_value=fill)
        slides = slides.reindex(joint=rest["joint"])
        rest["joint"].attrs = slides["joint"].attrs = text
    return rest.assign(slides.data_vars)


def needed(model: Model, names: Iterable[str]) -> bool:
    """Whether any of these quantities depends on accelerations, or on forces that answer a speed so."""
    abrupt = cache.structure_module(model.structure).ABRUPT
    return not {*names}.isdisjoint(key.partition(":")[0] for key in abrupt)


def in_order(*parts: np.ndarray) -> np.ndarray:
    """Rows of records in order of time; of equal times as the parts come."""
    rows = np.concatenate(parts)
    return rows[np.argsort(rows[:, 0], kind="stable")]


def quantities(model: Model, rtol: float, records: Records, rows: np.ndarray) -> Quantities:
    """Quantities of some rows of the records of a run with `Request.rates`, accelerations and all."""
    return together(model, rtol, records, rows)[0]


def together(model: Model, rtol: float, records: Records, *parts: np.ndarray) -> list[Quantities]:
    """Quantities of several parts of the records, for which steps in doubt are followed once."""
    sharp = resolved(model, rtol, records.coarse, *parts)
    return [Quantities(model, rows, records.start, each) for rows, each in zip(parts, sharp, strict=True)]


def resolved(model: Model, rtol: float, coarse: np.ndarray, *parts: np.ndarray) -> list[np.ndarray]:
    """Parts of the records of a run with `Request.rates`, with states whose accelerations are right.

    Rows outside the steps in doubt stay as they are, and so do states that come out in other contact modes,
    which lie within an event's uncertainty.
    """
    held = [_held(coarse, rows) for rows in parts]
    wanted = np.concatenate([rows[each] for rows, each in zip(parts, held, strict=True)])
    if not len(wanted):
        return [*parts]
    order = np.argsort(wanted[:, 0], kind="stable")
    wanted[order] = _right(model, rtol, coarse, wanted[order])
    result = [rows.copy() if len(each) else rows for rows, each in zip(parts, held, strict=True)]
    ends = np.cumsum([len(each) for each in held])
    for rows, each, right in zip(result, held, np.split(wanted, ends[:-1]), strict=True):
        rows[each] = right
    return result


def _held(coarse: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Places of the rows that lie in a coarse step; a beginning is its own state."""
    places = np.searchsorted(coarse[:, TIME], rows[:, 0], side="left") - 1
    held = np.flatnonzero(places >= 0)
    return held[rows[held, 0] <= coarse[places[held], END]]


def _right(model: Model, rtol: float, coarse: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows in coarse steps, by time, with states whose accelerations are right, or as they are."""
    places = np.searchsorted(coarse[:, TIME], rows[:, 0], side="left") - 1
    anew = _anew(model, rtol, coarse, places, rows)
    same = (anew[:, 0] == rows[:, 0]) & np.all(_modes(model, anew) == _modes(model, rows), axis=1)
    first = np.searchsorted(places, places)  # of the same step
    other = np.cumsum(~same)  # up to a row; none between the first of its step and itself
    same &= other == np.where(same[first], other[first], -1)
    return np.where(same[:, None], anew, rows)


def _anew(model: Model, rtol: float, coarse: np.ndarray, places: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows at the times of `rows`, each from the beginning of its coarse step; 0 where none came."""
    flow, retake = cache.method("flow").flow, cache.method("retake").retake
    closer = max(CLOSER, min(LEAST / rtol, 1.0))
    work, motion, options = memory(model, Request(np.inf, rtol, rows[:, 0], max_steps=ATTEMPTS))
    motion = motion._replace(absolute=closer * motion.absolute, relative=closer * motion.relative)
    used, first = np.unique(places, return_index=True)
    compiled = functions(model.structure)
    for i in ticked(range(0, len(used), TOGETHER)):
        retake(flow, compiled, work, motion, options, coarse[used[i : i + TOGETHER]], first[i : i + TOGETHER])
    return motion.samples


def _modes(model: Model, rows: np.ndarray) -> np.ndarray:
    """Contact modes of rows."""
    sizes, first = cache.structure_module(model.structure).SIZES, 1 + len(model.state)
    return rows[:, first : first + sizes["contacts"] + sizes["resets"]]


def evaluated(
    records: Records, rows: int, dim: str, make: Callable[[Records, int], xr.Dataset]
) -> xr.Dataset:
    """The dataset that is made of a run's records and every so many-th of its rows along `dim`.

    Every row counts, unless the run was interrupted, or is so now; then at most `MOST` do.
    """
    if records.status != INTERRUPTED:
        with suppress(Stopped, Aborted):
            return make(records, 1)
        records = replace(records, status=INTERRUPTED)
    step = math.ceil(max(rows, 1) / MOST)
    return noted(make(records, step), step, dim)


def thinned(dataset: xr.Dataset, most: int) -> xr.Dataset:
    """Every n-th entry of a dataset along the dimension that has most of it: at most so many bytes."""
    if dataset.nbytes <= most:
        return dataset
    held = {dim: sum(v.nbytes for v in dataset.variables.values() if dim in v.dims) for dim in dataset.sizes}
    dim = max(held, key=lambda each: held[each])
    step = math.ceil(held[dim] / max(most - (dataset.nbytes - held[dim]), 1 + most // 2))
    return noted(dataset.isel({dim: slice(None, None, step)}), step, str(dim))


def noted(dataset: xr.Dataset, step: int, dim: str) -> xr.Dataset:
    """The dataset, which says where it has only every so many-th entry along a dimension."""
    if step == 1:
        return dataset
    before = f"{dataset.attrs['partial']}, and of these " if "partial" in dataset.attrs else ""
    return dataset.assign_attrs(partial=f"{before}1 in {step} of what was computed along {dim}")
