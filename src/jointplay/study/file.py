"""Study files: a TOML text becomes a validated study; and the JSON schema of such files for editors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from jointplay.analysis.labels import xr
from jointplay.analysis.own_units import in_own_units
from jointplay.analysis.rules import NONE
from jointplay.display.accepted import descriptions
from jointplay.display.errors import NOTHING, InputError, Problem, problems_of, raise_any, refuse, unknown
from jointplay.kinds import KINDS, Kind
from jointplay.solver.mechanism.measures import PATTERN
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.study import toml_text
from jointplay.study.models import TABLES, Study, build_mechanism, in_a_study, keyword_of, models, tables_of
from jointplay.study.results import provenance
from jointplay.study.results.store import open_result
from jointplay.study.vary_table import in_own_units as varied_in_own_units
from jointplay.study.vary_table import parsed, tried

DIALECT = "https://json-schema.org/draft/2020-12/schema"
BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
INTERNAL = ("noun", "accepts", "discriminator")  # what only our own error messages and pydantic use


@dataclass(frozen=True)
class Loaded:
    """A study and the text it was read from."""

    record: Study
    text: str


def load(path: Path | str, changes: Iterable[str] = (), kind: str | None = None) -> Loaded:
    """Read and validate a study file.

    Parameters
    ----------
    path : path-like
        A TOML file; or a result (``.nc``), for the study that it answers.
    changes : iterable of str
        ``key.path=value`` changes, laid over the file before it is validated.
    kind : str, optional
        What is wanted: of a file of another kind, or of none, the mechanism alone is taken, in a study
        that is named after the file and the kind.

    Returns
    -------
    Loaded
        Else `InputError`, with everything that is wrong and its key paths.
    """
    (table, text), name = _read(path), Path(path).stem
    was = table.get("kind")
    if kind not in (None, was):
        kept = ("mechanism", *TABLES.values(), *["title"] * (was is None))
        own = {name: table[name] for name in kept if name in table}
        name, was, table = f"{name}_{kind}", None, {"kind": kind} | own
    made = {"name": name} | toml_text.override(table, changes)
    # as another kind, without tables that the other one alone has
    if made.get("kind") != was and made.get("kind") in list(KINDS):
        strange = {*TABLES.values()} - {*map(TABLES.get, KINDS[made["kind"]].function.fields())}
        made = {key: each for key, each in made.items() if key not in strange or each != table.get(key)}
    return Loaded(validate(made), text)


def _read(path: Path | str) -> tuple[dict[str, Any], str]:
    """The table of a study file, or of the study that a result answers, defaults filled in; and its text."""
    if Path(path).suffix != ".nc":
        text = toml_text.read_text(path)
        return toml_text.parse(text), text
    origin = provenance.read(open_result(path))
    if not isinstance(origin.get("study"), dict):
        expected = "a result that holds its study is accepted; this one has no provenance"
        raise InputError([Problem("study file", str(path), expected)])
    return origin["study"], str(origin.get("study_text", ""))


def mechanism_of(path: Path | str) -> Mechanism:
    """Give the linkage of a study file, of a file that holds a `[mechanism]` table alone, or of a result."""
    mechanism = moving_of(path)
    if not isinstance(mechanism, Mechanism):
        raise refuse(mechanism.name, "a linkage is accepted, no system of equations", "mechanism")
    return mechanism


def moving_of(path: Path | str) -> Mechanism | TestSystem:
    """Give the mechanism of a file: a linkage or a test system."""
    table, _ = _read(path)
    if "mechanism" not in table:
        raise InputError([Problem("mechanism", NOTHING, "a file with a table [mechanism] is accepted")])
    return build_mechanism(table["mechanism"])


def title_of(path: Path | str) -> str | None:
    """Give the title of a study file; None where it has none."""
    return _read(path)[0].get("title")


def validate(table: Mapping[str, Any]) -> Study:
    """The study of a parsed TOML table; `InputError` with everything that is wrong and its key paths."""
    raise_any(toml_text.implausible(dict(table)))
    if table.get("kind") not in list(KINDS):  # a list: what was given need not be hashable
        raise InputError(_without_kind(table))
    try:
        return models(KINDS[table["kind"]]).study.model_validate(table)
    except InputError as error:
        found, keys = [*error.problems, *_broken_rules(table, error.problems)], tables_of(table)
        raise InputError((_at_home(problem, keys) for problem in found), more=error.more) from None


def _at_home(problem: Problem, keys: Mapping[str, str]) -> Problem:
    """The same problem; of an unknown key that another table of a study has, which table that is."""
    table, _, key = problem.key.rpartition(".")
    home = keys.get(key, table)
    strange = table in ("", *keys.values()) and str(problem.expected).startswith("there is no such key")
    if home == table or not strange:
        return problem
    own = f"as a table of its own, [{key}]" if home else "before all tables"
    where = f"in the table [{home}]" if home not in ("", key) else own
    return replace(problem, expected=f"there is no such key here; it is accepted {where}")


def _broken_rules(table: Mapping[str, Any], problems: list[Problem]) -> list[Problem]:
    """Problems of the rules whose keywords are right by themselves, where something else is not."""
    row, tables = KINDS[table["kind"]], [table.get(name, {}) for name in ("integrator", "analysis")]
    wrong = {keyword_of(problem.key) for problem in problems}
    if wrong & {"integrator", "analysis"}:  # no tables, or not there
        return []
    given = {key: value for each in tables for key, value in each.items()}
    given |= {
        key: table[name] for key, name in TABLES.items() if name in table and key in row.function.fields()
    }
    if "mechanism" not in wrong:
        given["mechanism"] = build_mechanism(table["mechanism"])
    if "over" in row.function.fields() and "over" not in wrong and "vary" in table:
        given["over"] = tried(parsed(varied_in_own_units(given.get("mechanism"), table["vary"])))
    given = getattr(row.function, "left_out", NONE).completed(in_own_units(given.get("mechanism"), given))
    problems, _ = row.function.validated(given, wrong)
    return in_a_study(problems)


def _without_kind(table: Mapping[str, Any]) -> list[Problem]:
    """The problems of a study of no known kind: all that do not depend on the kind."""
    alone = "the commands assess, tolerances, figure and report take a mechanism without one"
    problem = Problem("kind", NOTHING, f"a kind of study is needed: one of {', '.join(KINDS)}; {alone}")
    if "kind" in table:
        problem = unknown("kind", table["kind"], table["kind"], KINDS, "kind of study")
    others = problems_of(validate, {**table, "kind": next(iter(KINDS))})
    return [problem, *(each for each in others if not each.key.startswith(("analysis", "figure.kind")))]


def figure_options(
    dataset: xr.Dataset | Mechanism, kind: str | None = None, changes: Iterable[str] = ()
) -> dict[str, Any]:
    """Options for drawing a stored result.

    Parameters
    ----------
    dataset : xarray.Dataset or Mechanism
        A result, whose provenance holds the study's own options; or what has none.
    kind : str, optional
        Another kind of figure; the study's options are then left aside.
    changes : iterable of str
        ``key=value`` changes of the options.

    Returns
    -------
    dict
        For `jointplay.figures.draw`.
    """
    study = provenance.read(dataset).get("study") if isinstance(dataset, xr.Dataset) else None
    own = study.get("figure") if isinstance(study, dict) else None
    options = (own if isinstance(own, dict) else {}) if kind is None else {"kind": kind}
    options = toml_text.override(options, changes)
    raise_any(toml_text.implausible(options))
    return options


def schema() -> dict[str, Any]:
    """JSON schema of study files, as plain JSON types."""
    every = reduce(or_, (models(row).study for row in KINDS.values()))
    tidy = _tidy(TypeAdapter(Annotated[every, Field(discriminator="kind")]).json_schema())
    for kind in tidy["$defs"].values():
        if {"kind", "mechanism"} <= {*kind["properties"]} and "name" in kind.get("required", ()):
            kind["required"].remove("name")  # the file's own name is taken
    for row in KINDS.values():
        _describe(row, tidy["$defs"])
        own = tidy["$defs"][models(row).analysis.__name__]
        follow = getattr(row.function, "left_out", NONE).names
        own["required"] = [name for name in own.get("required", ()) if name not in follow]
    return {"$schema": DIALECT, "title": "jointplay study file", **tidy}


def _describe(row: Kind, tables: dict[str, Any]) -> None:
    """Describe each keyword as the docstring of the analysis function does."""
    texts = descriptions(row.function)
    for model in models(row)[1:]:
        properties = tables[model.__name__]["properties"]
        for name in properties.keys() & texts.keys():
            properties[name]["description"] = texts[name]


def _tidy(node: Any, measured: bool = False) -> Any:
    """Name bounds as JSON schema does, and drop titles that only repeat the key.

    What has a unit is `measured`: each part of it that accepts a number accepts a text with a unit, too.
    """
    if isinstance(node, list):
        return [_tidy(item, measured) for item in node]
    if not isinstance(node, dict):
        return node
    kept = {key: value for key, value in node.items() if key not in INTERNAL}
    measured = measured or kept.get("units", "1") != "1"
    if measured and kept.get("type") == "number":
        kept |= {"type": ["number", "string"], "pattern": PATTERN}
    if isinstance(kept.get("title"), str):
        del kept["title"]
    return {BOUNDS.get(key, key): _tidy(value, measured) for key, value in kept.items()}
