"""Labelled quantities, evaluated from records of states, and variables that every dataset of a run holds."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.labels import KEPT, Out, flags
from jointplay.analysis.quantities import BALANCE, MODES, STATUS, WORDS, WORK
from jointplay.display.errors import warn
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.model import DEEP, Model
from jointplay.solver.method.codes import COUNTERS, Mode
from jointplay.solver.motion.guard_tolerances import ends
from jointplay.solver.motion.progress import ticked

if TYPE_CHECKING:
    import xarray as xr

NEAR = 0.5  # share of the penetration at which a law ends that is told: it is made for far less
BLOCK = 4096  # rows evaluated at a time, which stay in a processor's cache
STRANGE = re.compile(r"[^\w.+@-]")  # what a word of flags cannot hold


class Quantities:
    """Quantities of rows of records (time, positions, speeds, modes, work), computed when first used.

    Those that depend on accelerations are taken from `sharp` instead, where it is given (analysis.rates).
    """

    def __init__(self, model: Model, rows: np.ndarray, start: np.ndarray, sharp: np.ndarray | None = None):
        self.model, self.rows, self.start = model, rows, start
        self.sharp = rows if sharp is None else sharp
        self.module = cache.structure_module(model.structure)
        self._n_state = len(self.module.STATE)

    def of(self, places: slice) -> Quantities:
        """The same of some of the rows."""
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
        wanted = [key for several in keys.values() for key in several]
        apart = () if self.sharp is self.rows else self.module.ABRUPT
        series = self._evaluated([key for key in wanted if key not in apart], self.rows)
        series |= self._evaluated([key for key in wanted if key in apart], self.sharp)
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
        if name == "energy":
            return self._mechanical(self.rows) + self._stored()
        return self._gained - self._taken_in(self._work)

    @property
    def _work(self) -> dict[str, np.ndarray]:
        """Works since the start that the equations have, by quantity."""
        columns = self.rows[:, self._n_state + len(self.model.touching) :].T
        names = (WORK[word][0] for word in powers(self.model.structure))
        return dict(zip(names, columns, strict=False))

    @staticmethod
    def _taken_in(works: dict[str, np.ndarray]) -> np.ndarray:
        """Sum of the works, each with the sign with which it adds to the mechanical energy."""
        return sum(sign * works[name] for name, sign in WORK.values() if name in works)

    @property
    def _gained(self) -> np.ndarray:
        """Gain of kinetic and potential energy of the links since the start."""
        return self._mechanical(self.rows) - self._mechanical(self.start[None, :])[0]

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
    if not deep:
        return {}
    text = f"{'; '.join(deep)}: please check the start, the units, the loads and the contact data"
    warn(text)
    return {"warning": text}


def attributes(name: str) -> dict[str, Any]:
    """Attributes of a variable: units, long name, flags."""
    word = WORDS[name]
    result = {"units": word.units, "long_name": word.long_name}
    return result | flags(MODES) if name == "mode" else result


def joint_flags(model: Model) -> dict[str, Any]:
    """CF attributes of a contact's number, counted from 0: its joint's or wall's name; -1 is none."""
    names = ["none", *(STRANGE.sub("_", name) for name in model.touching)]
    values = np.arange(-1, len(names) - 1, dtype=np.int16)
    return {"flag_values": values, "flag_meanings": " ".join(names)}


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
        of: (of, np.array(names, dtype=str), {"long_name": text})
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
