"""Study files: how a TOML text becomes a validated study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.kinds import KINDS
from jointplay.results import provenance
from jointplay.results.store import open_result
from jointplay.study import toml_text
from jointplay.study.mechanism_table import build_mechanism
from jointplay.study.models import Study, broken_rules, keyword_of, models
from jointplay.study.vary_table import parsed, values


@dataclass(frozen=True)
class Loaded:
    """A study and the text it was read from."""

    record: Study
    text: str


def load(path: Path | str, changes: Iterable[str] = ()) -> Loaded:
    """Read and validate a study file.

    Parameters
    ----------
    path : path-like
        A TOML file; or a result (``.nc``), for the study that it answers.
    changes : iterable of str
        ``key.path=value`` changes, laid over the file before it is validated.

    Returns
    -------
    Loaded

    Raises
    ------
    jointplay.errors.InputError
        Listing everything that is wrong, with key paths.
    """
    if Path(path).suffix == ".nc":
        table, text = _stored(path)
    else:
        text = toml_text.read_text(path)
        table = toml_text.parse(text)
    return Loaded(validate({"name": Path(path).stem} | toml_text.override(table, changes)), text)


def _stored(path: Path | str) -> tuple[dict[str, Any], str]:
    """The study that a result answers, with every default filled in, and the text that it was read from."""
    origin = provenance.read(open_result(path))
    if not isinstance(origin.get("study"), dict):
        expected = "a result that holds its study is accepted; this one has no provenance"
        raise InputError([Problem("study file", str(path), expected)])
    return origin["study"], str(origin.get("study_text", ""))


def validate(table: Mapping[str, Any]) -> Study:
    """Make a study of a parsed TOML table.

    Raises
    ------
    jointplay.errors.InputError
        Listing everything that is wrong, with key paths.
    """
    problems = toml_text.implausible(dict(table))
    if problems:
        raise InputError(problems)
    if table.get("kind") not in list(KINDS):  # a list: what was given need not be hashable
        raise InputError(_without_kind(table))
    model = models(KINDS[table["kind"]]).study
    try:
        return model.model_validate(table)
    except InputError as error:
        raise InputError([*error.problems, *_unsaid(table, error.problems)], more=error.more) from None


def _unsaid(table: Mapping[str, Any], problems: list[Problem]) -> list[Problem]:
    """What rules say of the keywords that are right by themselves, where something else is not."""
    row, tables = KINDS[table["kind"]], [table.get(name, {}) for name in ("integrator", "analysis")]
    wrong = {keyword_of(problem.key) for problem in problems}
    if wrong & {"integrator", "analysis"}:  # no tables, or not there
        return []
    given = {key: value for each in tables for key, value in each.items()}
    if "mechanism" not in wrong:
        given["mechanism"] = build_mechanism(table["mechanism"])
    if "over" in row.function.fields() and "over" not in wrong:
        given["over"] = values(parsed(table["vary"]))
    return broken_rules(row, given, wrong)


def _without_kind(table: Mapping[str, Any]) -> list[Problem]:
    """The problems of a study of no known kind: all but those that depend on the kind."""
    names = ", ".join(KINDS)
    problem = Problem("kind", NOTHING, f"a kind of study is needed: one of {names}")
    if "kind" in table:
        problem = unknown("kind", table["kind"], table["kind"], KINDS, "kind of study")
    try:
        validate({**table, "kind": next(iter(KINDS))})
    except InputError as error:
        return [
            problem,
            *(other for other in error.problems if not other.key.startswith(("analysis", "figure.kind"))),
        ]
    return [problem]


def figure_options(
    dataset: xr.Dataset, kind: str | None = None, changes: Iterable[str] = ()
) -> dict[str, Any]:
    """Options for drawing a stored result.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result; its provenance holds the study's own options.
    kind : str, optional
        Another kind of figure; the study's options are then left aside.
    changes : iterable of str
        ``key=value`` changes of the options.

    Returns
    -------
    dict
        For `jointplay.figures.draw`.
    """
    study = provenance.read(dataset).get("study")
    own = study.get("figure") if isinstance(study, dict) else None
    options = (own if isinstance(own, dict) else {}) if kind is None else {"kind": kind}
    options = toml_text.override(options, changes)
    if problems := toml_text.implausible(options):
        raise InputError(problems)
    return options
