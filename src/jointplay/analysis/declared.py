"""What an analysis gives, declared once beside it.

A result's dataset, the values of a run that failed, the answer in words, the figure of a sweep, the `Returns`
of the docstring and the table of the documentation follow from the declaration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.evaluate import dataset
from jointplay.analysis.labels import ENDED, coded, number
from jointplay.analysis.quantities import STATUS
from jointplay.display import codes
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import COUNTERS

if TYPE_CHECKING:
    import xarray as xr

KEPT = object()  # what a run that failed still tells
OF = {"name": "the quantity", "units": "its units", "squared": "its units squared"}
OF["per_hertz"] = "its units squared per hertz"  # as long as there is no quantity


@dataclass(frozen=True)
class Out:
    """A variable of a result.

    Parameters
    ----------
    dims : str or tuple of str
        Its dimensions, of a scalar ().
    long_name, units : str
        As in the file; ``{name}`` and ``{units}`` are those of the quantity that the result is of. A text has
        no units.
    about : str
        What the documentation says beside the long name.
    flags : tuple of str
        Words of an integer code.
    missing : object
        Where a run failed, of a code its word; `KEPT`: what there is until then.
    shown : str, optional
        Title in the figure of a sweep, whose default this is; empty: the long name.
    at : mapping
        The entry that is shown along each of its own dimensions.
    """

    dims: str | tuple[str, ...]
    long_name: str
    units: str = "1"
    about: str = ""
    flags: tuple[str, ...] = ()
    missing: Any = math.nan
    shown: str | None = None
    at: Mapping[str, Any] = field(default_factory=dict)

    def variable(self, values: Any, of: Mapping[str, str]) -> tuple[Any, Any, dict[str, Any]]:
        """Dimensions, values and attributes."""
        if self.flags:
            return coded(self.dims, values, self.long_name, self.flags)
        name = self.long_name.format_map(of)
        if not self.units:
            return self.dims, values, {"long_name": name}
        return number(self.dims, values, self.units.format_map(of), name)

    def none(self, shape: tuple[int, ...]) -> np.ndarray:
        """Values of a run that failed."""
        return np.full(shape, self.flags.index(self.missing) if self.flags else self.missing)


RUN = {
    "status": Out((), ENDED, flags=STATUS, missing=KEPT),
    "wall_time": Out((), "wall time of the run", "s", missing=KEPT),
    "turn_period_nominal": Out((), "nominal period of the drive", "s", missing=KEPT),
    **{name: Out((), text, missing=KEPT) for name, text in COUNTERS.items()},
}


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
        Gives the answer of a result in one to three lines.
    verdict : str or callable, optional
        The answer of each cell of a sweep in a word: a variable of codes, or a function of the sweep.
    shown : tuple of str, optional
        What the figure of a sweep shows, the first that a result has; those that say so, if left out.
    """

    kind: str
    coords: Mapping[str, Out]
    variables: Mapping[str, Out]
    answer: Callable[[xr.Dataset], str] | None = None
    verdict: str | Callable[[xr.Dataset], xr.DataArray] = ""
    shown: tuple[str, ...] = ()

    def dataset(
        self,
        values: Mapping[str, Any],
        of: Mapping[str, str] | None = None,
        model: Model | None = None,
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
        **attributes
            Of the file.

        Raises
        ------
        KeyError
            If a value is not declared.
        """
        import xarray as xr

        if strange := values.keys() - {*self.coords, *self.variables}:
            raise KeyError(f"{self.kind} declares no {', '.join(sorted(strange))}")
        variables, coords = (
            {name: out.variable(values[name], of or OF) for name, out in table.items() if name in values}
            for table in (self.variables, self.coords)
        )
        if model is not None:
            return dataset(model, variables, coords, self.kind, **attributes)
        head = {"Conventions": "CF-1.11", "kind": self.kind} | attributes | {"kind": self.kind}
        return xr.Dataset(variables, coords, head)

    def none(self, *names: str, **sizes: int) -> dict[str, np.ndarray]:
        """Values that a run which failed has none of, over dimensions of these sizes."""
        outs = {name: self.variables[name] for name in names}
        dims = {name: (out.dims,) if isinstance(out.dims, str) else out.dims for name, out in outs.items()}
        return {name: out.none(tuple(sizes[dim] for dim in dims[name])) for name, out in outs.items()}

    def words(self, result: xr.Dataset) -> xr.DataArray | None:
        """The answer of each cell of a sweep in a word; None where nothing says it."""
        if callable(self.verdict):
            return self.verdict(result)
        return codes.words(result[self.verdict]) if self.verdict else None

    def figure(self) -> Iterator[tuple[str, Out]]:
        """What the figure of a sweep shows, the first that a result has."""
        for name in self.shown or (name for name, out in self.variables.items() if out.shown is not None):
            yield name, self.variables[name]

    def told(self) -> Iterator[tuple[str, str, str, str]]:
        """Name, dimensions, units and meaning of each variable but for a run's times and counters."""
        for name, out in (self.coords | self.variables).items():
            if name in RUN and name != "status":
                continue
            dims = out.dims if isinstance(out.dims, str) else ", ".join(out.dims)
            flags = f" ({', '.join(out.flags)})" if out.flags and out.flags != STATUS else ""
            meaning = f"{out.long_name.format_map(OF)}{flags}{'; ' if out.about else ''}{out.about}"
            yield name, dims, "" if out.units == "1" else out.units.format_map(OF), meaning

    def __str__(self) -> str:
        """As it stands in a docstring."""
        lines = []
        for name, dims, units, meaning in self.told():
            over = f", over ``{dims.replace(', ', '``, ``')}``" if dims and dims != name else ""
            lines.append(f"- ``{name}``{over}: {meaning}{f' ({units})' if units else ''}")
        lines += ["- times and counters of the run"] if RUN.keys() & self.variables else []
        return "\n".join(lines)


def values_of(result: xr.Dataset, names: Iterable[str]) -> dict[str, Any]:
    """Values of those variables that a result has."""
    return {name: result[name].values for name in names if name in result}
