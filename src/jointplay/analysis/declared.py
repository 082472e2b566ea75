"""Outputs of an analysis, declared once, next to it.

A result's dataset, the values of a run that failed, the answer in words, the figure of a sweep, the `Returns`
of the docstring and the table of the documentation follow from the declaration.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import RUN, coordinates, on_joints
from jointplay.analysis.labels import KEPT, OF, PLANE, Out, xr
from jointplay.display import codes
from jointplay.solver.mechanism.model import Model

LISTED = 8  # words of a code that documentation names


@dataclass(frozen=True)
class Outputs:
    """All that an analysis gives.

    Parameters
    ----------
    kind : str
        Of its study.
    coords, variables : dict of str to Out
        By name, in the order of the file.
    answer : callable, optional
        Gives the answer of a result in one to five lines.
    verdict : str or callable, optional
        The answer of each cell of a sweep in a word: a variable of codes, or a function of the sweep.
    shown : mapping of str to str
        What the figure of a sweep shows, the first that a result has, each with its title; empty: its name.
    table : callable, optional
        Gives a result as text, for a file beside it.
    own_states : str
        Dimension of a system's own states where its outputs are recorded along ``state``.
    """

    kind: str
    coords: Mapping[str, Out]
    variables: Mapping[str, Out]
    answer: Callable[[xr.Dataset], str] | None = None
    verdict: str | Callable[[xr.Dataset], xr.DataArray] = ""
    shown: Mapping[str, str] = field(default_factory=dict)
    table: Callable[[xr.Dataset], str] | None = None
    own_states: str = "coordinate"

    def dataset(
        self,
        values: Mapping[str, Any],
        of: Mapping[str, str] | None = None,
        model: Model | None = None,
        plane: Mapping[str, Any] | None = None,
        words: Mapping[str, Sequence[str]] | None = None,
        groups: Mapping[str, Mapping[str, Any]] | None = None,
        **attributes: Any,
    ) -> xr.Dataset:
        """The result, of the values that are known.

        Parameters
        ----------
        values : mapping of str to array_like
            By name.
        of : mapping of str to str, optional
            Name and units of the quantity that the result is of.
        model : Model, optional
            Whose labels the dimensions have.
        plane : mapping, optional
            Coordinates of the plane that variables are over.
        words : mapping of str to sequence of str, optional
            Words of codes that the result numbers itself, by variable.
        groups : mapping of str to mapping, optional
            Variables, as xarray takes them, whose names a result has of its own, such as recorded quantities;
            by the name that stands for them in the declaration.
        **attributes
            Of the file.

        Raises
        ------
        KeyError
            If a value is not declared.
        """
        axes = plane or {}
        variables, coords = self.variables_of(values, of, [*axes], words, groups)
        head = {"Conventions": "CF-1.11", "kind": self.kind} | attributes | {"kind": self.kind}
        if model is None:
            return xr.Dataset(variables, axes | coords, head)
        if "state" in coords and model.outputs:
            known = {name for group in (groups or {}).values() for name in group}
            variables, coords = (self._beside_outputs(table, known) for table in (variables, coords))
        used = {dim for dims, *_ in variables.values() for dim in ([dims] if isinstance(dims, str) else dims)}
        labels = {of: each for of, each in coordinates(model).items() if of in used}
        return on_joints(xr.Dataset(variables, axes | coords | labels, head))

    def variables_of(
        self,
        values: Mapping[str, Any],
        of: Mapping[str, str] | None = None,
        plane: Sequence[str] = (),
        words: Mapping[str, Sequence[str]] | None = None,
        groups: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Variables and coordinates of values; as `dataset` takes them, but of the plane its axes' names."""
        if strange := values.keys() - {*self.coords, *self.variables}:
            raise KeyError(f"{self.kind} declares no {', '.join(sorted(strange))}")
        named, own, found = words or {}, groups or {}, []
        for table in (self.variables, self.coords):
            made = {}
            for name, out in table.items():
                made |= own.get(name, {})
                if name in values:
                    made[name] = out.variable(values[name], of or OF, plane, named.get(name, ()))
            found.append(made)
        return found[0], found[1]

    def _beside_outputs(self, table: Mapping[str, Any], known: Container[str]) -> dict[str, Any]:
        """Variables along states, but for the `known`, along `own_states`."""
        names = {"state": self.own_states}
        return {
            names.get(name, name): (dims if name in known else tuple(names.get(d, d) for d in dims), *rest)
            for name, (dims, *rest) in table.items()
        }

    def none(self, *names: str, **sizes: int) -> dict[str, np.ndarray]:
        """Values that a run which failed has none of, over dimensions of these sizes."""
        outs = {name: self.variables[name] for name in names}
        return {name: out.none(tuple(sizes[dim] for dim in out.axes)) for name, out in outs.items()}

    def failed(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values of the same variables in a run that failed."""
        outs = {name: self.variables[name] for name in values}
        return {n: v if outs[n].missing is KEPT else outs[n].none(np.shape(v)) for n, v in values.items()}

    def words(self, result: xr.Dataset) -> xr.DataArray | None:
        """The answer of each cell of a sweep in a word; None where nothing says it."""
        if callable(self.verdict):
            return self.verdict(result)
        return codes.words(result[self.verdict]) if self.verdict else None

    def in_sweep(self, there: Container[Any]) -> str | None:
        """Name of the variable, of those that are there, in the figure of a sweep; None: nothing."""
        return next((name for name in self.shown if name in there), None)

    def rows(self) -> Iterator[tuple[str, str, str, str]]:
        """Name, dimensions, units and meaning of each variable but for a run's times and counters."""
        for name, out in (self.coords | self.variables).items():
            if name in RUN and name != "status":
                continue
            dims = ", ".join(out.axes)
            flags = f" ({', '.join(out.flags)})" if 0 < len(out.flags) <= LISTED else ""
            parts = f"{out.long_name.format_map(OF)}{flags}", out.about, out.comment
            units = "" if out.units == "1" else out.units.format_map(OF)
            yield name, dims, units, "; ".join(filter(None, parts))

    def __str__(self) -> str:
        """The text that stands in a docstring."""
        lines = []
        for name, dims, units, meaning in self.rows():
            over = f", over ``{dims.replace(', ', '``, ``')}``" if dims and dims != name else ""
            lines.append(f"- ``{name}``{over}: {meaning}{f' ({units})' if units else ''}")
        return "\n".join([*lines, "", *self.notes()]).rstrip()

    def notes(self) -> Iterator[str]:
        """Sentences on further variables, and on names that stand for others."""
        outs = self.coords | self.variables
        if RUN.keys() & outs:
            yield "Beside them, times and counters of the run."
        if any(PLANE in out.axes for out in outs.values()):
            yield f"``{PLANE}`` stands for what is varied."
        if any(part.isupper() for name in outs for part in name.split("_")):
            yield "Words in capitals stand for names of the result's own."


def values_of(result: xr.Dataset, names: Iterable[str]) -> dict[str, Any]:
    """Values of the named variables that a result has."""
    return {name: result[name].values for name in names if name in result}
