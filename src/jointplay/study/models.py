"""Validated records of studies, made of the kind's row and the signature of its analysis.

The keywords of the analysis function are the keys of the tables `[analysis]` and `[integrator]`: their types,
defaults and rules come from there. What all kinds share is in `Study`.

The `[mechanism]` table of a study file: an entry of the catalog with changes, or a linkage written out.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property, partial
from inspect import signature
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, get_type_hints

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)

from jointplay import figures
from jointplay.analysis.keywords import LENGTHS, doubts, turns_as_driven
from jointplay.analysis.own_units import in_own_units
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.rules import NONE
from jointplay.analysis.vary import largest
from jointplay.display.errors import NOTHING, InputError, Problem, join, raise_any, refuse, unknown
from jointplay.display.number_text import counted, measure, typed
from jointplay.display.terminal import one_line
from jointplay.kinds import KINDS, Kind, load
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Record, named
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Changes, Mechanism, TestSystem
from jointplay.solver.mechanism.signature import first
from jointplay.study import vary_table
from jointplay.study.vary_table import Points, points

FORMS = (
    "catalog = a name and its changes as further keys, a linkage written out as links, joints and drive, "
    "or equations as states, parameters and rates"
)


def build_mechanism(given: Any) -> Mechanism | TestSystem:
    """The mechanism that a table describes.

    Parameters
    ----------
    given : mapping
        With the key ``catalog``, the other keys are that entry's keywords, and tables of parts by name, as
        ``joints = { C = { clearance = 1e-4 } }``; with ``states``, equations written out; else a linkage
        written out. A record passes as it is. `InputError` lists everything that is wrong, with keys relative
        to the table.
    """
    if isinstance(given, Mechanism | TestSystem):
        return given
    if not isinstance(given, Mapping):
        raise refuse(given, f"a table is accepted: {FORMS}")
    if "catalog" in given:
        changes = dict(given)
        name = changes.pop("catalog")
        if not isinstance(name, str) or name not in catalog.NAMES:
            raise InputError([unknown("catalog", name, name, catalog.NAMES, "mechanism")])
        return catalog.NAMES[name](**changes)
    return (TestSystem if {"states", "rates"} & given.keys() else Mechanism).model_validate(given)


class MechanismSchema:
    """Marks a field so that its JSON schema offers every form of the `[mechanism]` table."""

    def __get_pydantic_json_schema__(self, _: Any, handler: Any) -> dict[str, Any]:
        forms = [_form(name, function) for name, function in catalog.NAMES.items()]
        tables = [handler.resolve_ref_schema(handler(form.__pydantic_core_schema__)) for form in forms]
        for table in tables:  # what is left out is as the entry has it, not as a change would be by itself
            for key in table["properties"].values():
                key.pop("default", None)
        return {
            "anyOf": [*tables, *(handler(each.__pydantic_core_schema__) for each in (Mechanism, TestSystem))]
        }


@cache
def _form(name: str, function: Callable[..., Any]) -> type[Record]:
    """The table of one entry of the catalog, as a record that only lends its schema."""
    hints, catalog_key = get_type_hints(function, include_extras=True), (Literal[name], ...)
    # a linkage's keywords are the changes that every linkage knows, and what the entry has beside
    linkage = hints["return"] is Mechanism
    base, known = (Changes, Changes.model_fields) if linkage else (Record, {})
    arguments = [a for a in signature(function).parameters.values() if a.kind is not a.VAR_KEYWORD]
    own = {
        a.name: (hints[a.name], ... if a.default is a.empty else a.default)
        for a in arguments
        if a.name not in known
    }
    own |= {part: (dict[str, dict[str, Any]], {}) for part in ("links", "joints") if linkage}
    return create_model(f"catalog_{name}", __base__=base, catalog=catalog_key, **own)  # type: ignore[call-overload]


NAME = r"^\w[\w .+-]*$"
BYTES = 200  # of a name: file systems take 255, and endings are put to it
INTEGRATOR = ("rtol", "max_steps", "ensemble")  # keywords of analyses that stand in the table [integrator]
# and those that no key of [analysis] gives
ELSEWHERE = ("mechanism", "over", "n_jobs", "progress", "branches", "labels")
TABLES = {"spreads": "tolerances"}  # and those that are a table of a study's own, beside [analysis]


class OfKind(Record):
    """A record of one kind of study; it is pickled with the kind's row, of which workers make its class."""

    row: ClassVar[Kind]
    part: ClassVar[str]

    def __reduce__(self) -> Any:
        return _restored, (self.row, self.part, self.__getstate__())


def _restored(row: Kind, part: str, state: dict[str, Any]) -> OfKind:
    model = getattr(models(row), part)
    record = model.__new__(model)
    record.__setstate__(state)
    return record


class Integrator(OfKind):
    """The table `[integrator]`: the accuracy of motions."""

    part: ClassVar[str] = "integrator"


class Analysis(OfKind):
    """The table `[analysis]`: settings of the computation."""

    part: ClassVar[str] = "analysis"


def _checked_figure(options: dict[str, Any]) -> dict[str, Any]:
    raise_any(figures.problems(options), "figure")
    return options


class FigureSchema:
    """Marks a field so that its JSON schema lists the kinds of figure and their options."""

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        options = [name for draw in figures.KINDS.values() for name in list(signature(draw).parameters)[1:]]
        kind = {"enum": list(figures.KINDS)}
        properties = {"kind": kind} | {name: {} for name in sorted(set(options))}
        return {"type": "object", "properties": properties, "additionalProperties": False}


def _short(name: str) -> str:
    if (count := len(name.encode())) > BYTES:
        expected = f"a name of at most {BYTES} bytes is accepted, not {count}: files are named after it"
        raise refuse(name, expected)
    return name


class Study(OfKind):
    """A study, of any kind.

    Parameters
    ----------
    kind : str
        Which analysis.
    name : str
        Name of the result and of its figure.
    title : str, optional
        One line for people.
    mechanism : Mechanism or TestSystem
        What is studied.
    vary : dict
        What changes from cell to cell, and its values; one cell if left out.
    integrator : Integrator
        How accurately.
    analysis : Analysis
        For how long, from where, and what to keep.
    figure : dict
        ``kind`` of figure and its options.
    """

    part: ClassVar[str] = "study"
    root: ClassVar[str] = ""
    kind: str
    name: Annotated[str, Field(pattern=NAME, max_length=100), AfterValidator(_short)] = named(
        "name of at most 100 letters, digits, spaces and _ . + -"
    )
    title: str | None = None
    mechanism: Annotated[Mechanism | TestSystem, BeforeValidator(build_mechanism), MechanismSchema()]
    vary: vary_table.Varied = vary_table.vary_field(default_factory=dict)
    integrator: Integrator
    analysis: Analysis
    figure: Annotated[dict[str, Any], AfterValidator(_checked_figure), FigureSchema()] = Field(
        default_factory=dict, json_schema_extra={"accepts": "a table of kind and its options"}
    )

    @field_validator("vary", mode="before", check_fields=False)
    @classmethod
    def _varied_in_their_units(cls, vary: Any, info: ValidationInfo) -> Any:
        if vary is None and (vary := cls._completed({}, info).get("over")) is None:
            raise refuse(NOTHING, f"a table of parameters, each with {vary_table.ACCEPTED}, is accepted")
        return vary_table.in_own_units(info.data.get("mechanism"), vary)

    @field_validator("analysis", mode="before", check_fields=False)
    @classmethod
    def _keywords_in_their_units(cls, given: Any, info: ValidationInfo) -> Any:
        if not isinstance(given, Mapping):
            return given
        keywords = cls._completed(in_own_units(info.data.get("mechanism"), given), info)
        return {key: value for key, value in keywords.items() if key not in ELSEWHERE or key in given}

    @classmethod
    def _completed(cls, given: Mapping[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """Keywords, with those that follow from the mechanism where they are left out."""
        known = {"mechanism": info.data["mechanism"]} if "mechanism" in info.data else {}
        return getattr(cls.row.function, "left_out", NONE).completed({**known, **given})

    @field_validator(*TABLES.values(), mode="before", check_fields=False)  # most kinds have none
    @classmethod
    def _tables_in_their_units(cls, given: Any, info: ValidationInfo) -> Any:
        keyword = next(key for key, table in TABLES.items() if table == info.field_name)
        return in_own_units(info.data.get("mechanism"), {keyword: given})[keyword]

    @field_validator("vary", check_fields=False)  # some kinds have none
    @classmethod
    def _can_vary(cls, vary: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        known = "mechanism" in info.data
        raise_any(vary_table.problems(info.data["mechanism"], vary, "") if vary and known else ())
        return vary

    @property
    def bounds(self) -> set[str]:
        """Settings of the analysis that say how far it goes, and change no cell's answer."""
        return getattr(self.row.function, "bounds", set())

    @cached_property
    def checked(self) -> tuple[list[Problem], Callable[..., Any]]:
        """Problems of keywords that do not fit together, and the analysis with these keywords."""
        return self.row.function.validated(self.keywords() | {"mechanism": self.mechanism})

    def model_copy(self, **how: Any) -> Self:
        """A copy with other values, of which the analysis has not been asked."""
        copied = super().model_copy(**how)
        copied.__dict__.pop("checked", None)
        return copied

    def __getstate__(self) -> dict[Any, Any]:
        state = super().__getstate__()
        return state | {"__dict__": {name: state["__dict__"][name] for name in type(self).model_fields}}

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        arguments = (self.row, self.mechanism, self.keywords(), self.vary, self.figure)
        raise_any([*self._broken_rules(), *figure_problems(*arguments)])
        return self

    def _broken_rules(self) -> list[Problem]:
        """Problems of keywords that do not fit together, by the rules of the analysis function."""
        problems, _ = self.checked
        return in_a_study(problems)

    @property
    def heading(self) -> str:
        """One line: the title, or the kind and the mechanism."""
        kind = {"assess": "assessment", "optimise": "optimisation"}.get(self.kind, self.kind)
        return one_line(self.title or "") or f"{kind} of {self.mechanism.name}".replace("_", " ")

    def keywords(self) -> dict[str, Any]:
        """Keywords of the analysis function, as records and plain values; omitted ones stay out."""
        fields = type(self).model_fields
        tables = {key: getattr(self, table) for key, table in TABLES.items() if table in fields}
        given = {**dict(self.integrator), **dict(self.analysis), **tables}
        return {key: value for key, value in given.items() if value is not None}

    def doubts(self) -> list[str]:
        """Lines on probable mistakes in a study that can be computed."""
        given = self.keywords()
        start, section = given.get("initial"), given.get("section")
        several = (self.mechanism, largest(self.mechanism, vary_table.values(self.vary)))
        found = [problem for mechanism in several for problem in doubts(mechanism, start, section)]
        found += [*self._failing_cells(), *self._idle()]
        return list(dict.fromkeys(str(replace(problem, key=_place(problem.key))) for problem in found))

    def _failing_cells(self) -> Iterator[Problem]:
        """Least and largest values of `[vary]` at which the crank cannot turn as it is driven."""
        lengths = {name: value for name, value in self.keywords().items() if name in LENGTHS}
        for key, values in vary_table.values(self.vary).items():
            for value in sorted({min(values), max(values)}):
                for problem in turns_as_driven(self.mechanism.varied({key: value}), **lengths):
                    yield Problem(f"over.{key}", value, f"its cells fail: {problem.expected}")

    def _idle(self) -> Iterator[Problem]:
        """Contact data in `[vary]` of joints that have no play."""
        given = vary_table.values(self.vary)
        joints = {joint.name: joint for joint in getattr(largest(self.mechanism, given), "joints", ())}
        for key, values in given.items():
            of, name, *rest = [*key.split("."), "", ""]
            if of == "joints" and joints[name].ideal and rest[0] in ("contact", "friction"):
                why = f"nothing varies: joint {name} has no play, and so no contact"
                yield Problem(f"over.{key}", list(values[:2]), why)

    def summary(self) -> str:
        """A few lines on the study's settings."""
        lines = [
            f"{self.name}: {self.heading}",
            f"kind       {self.kind}, {self._length()}",
            f"tolerance  {typed(self.integrator.rtol)}",
            f"figure     {self.figure.get('kind', 'as suits the result')}",
            self.mechanism.summary(),
        ]
        if self.vary:
            axes = vary_table.values(self.vary).items()
            lines.insert(1, f"varies     {'; '.join(self._span(*axis) for axis in axes)}")
        return "\n".join(lines)

    def _span(self, key: str, values: Sequence[float]) -> str:
        """A parameter, of a clearance whose, how many values it has, and the least and the largest."""
        found = Parameter.named(self.mechanism, key)
        least, most = (measure(each, found.units) for each in (min(values), max(values)))
        if key == "clearance" and isinstance(self.mechanism, Mechanism):
            own = found.paths[0].split(".")[1]
            ideal = ", ".join(each.name for each in self.mechanism.clearance_joints if each.name != own)
            key += f" of joint {own}" + f" (none at {ideal})" * bool(ideal)
        return f"{key}, {counted(len(values), 'value')} from {least} to {most}"

    def _length(self) -> str:
        """Length of the motion, in words."""
        given = dict(self.analysis)
        if windows := given.get("windows"):
            return "turns " + " and ".join(f"{typed(first)} to {typed(last)}" for first, last in windows)
        text = self.row.length
        if given.get("duration") is not None:
            text = text.replace("{turns} turns", "{duration} s")
        line = text.format(**{key: _Listed((value,)) for key, value in given.items()})
        return re.sub(r"(?<![\d.])(1 (?:dropped )?\w+)s\b", r"\1", line.replace(" after 0 dropped turns", ""))


class SingleStudy(Study):
    """A study of one mechanism, without `[vary]`."""

    vary: ClassVar[dict] = {}  # type: ignore[misc]


class SweepStudy(Study):
    """A study whose analysis varies parameters itself."""

    vary: vary_table.Vary = vary_table.vary_field(default=None, validate_default=True)

    def keywords(self) -> dict[str, Any]:
        """Keywords of the analysis function; omitted ones stay out."""
        return super().keywords() | {"over": vary_table.values(self.vary)}

    @cached_property
    def checked(self) -> tuple[list[Problem], Callable[..., Any]]:
        """The same of the smallest and largest values; those between are checked when the analysis runs."""
        given = self.keywords() | {"mechanism": self.mechanism}
        ends = {key: sorted({min(each), max(each)}) for key, each in given["over"].items()}
        problems, answer = self.row.function.validated(given | {"over": ends})
        return problems, partial(answer, over=given["over"])

    def _broken_rules(self) -> list[Problem]:
        if not 1 <= len(self.vary) <= 2:
            return [Problem("vary", list(self.vary), "one parameter or two are accepted")]
        return super()._broken_rules()


class _Listed(tuple):
    """A value in a line of text, the items of a list one after another; in the format ``#`` their number."""

    def __format__(self, form: str) -> str:
        (value,) = self
        several = value if isinstance(value, tuple | Mapping) else (value,)
        if form == "#":
            return str(len(several))
        return ", ".join(typed(each) if isinstance(each, float) else str(each) for each in several)

    def __getitem__(self, index: Any) -> Any:
        return _Listed((super().__getitem__(0)[index],))


class Models(NamedTuple):
    """The records of a kind of study."""

    study: type[Study]
    integrator: type[Integrator]
    analysis: type[Analysis]


@cache
def models(row: Kind) -> Models:
    """Make the records of a kind of study."""
    fields = row.function.fields()
    title, about = row.name.title().replace("_", ""), f"Keywords of `{row.function.__name__}`."
    integrator, analysis = (
        create_model(f"{title}{base.__name__}", __base__=base, __doc__=about, **keys)
        for base, keys in (
            (Integrator, {name: field for name, field in fields.items() if name in INTEGRATOR}),
            (
                Analysis,
                {k: field for k, field in fields.items() if k not in (*INTEGRATOR, *ELSEWHERE, *TABLES)},
            ),
        )
    )
    study = create_model(
        f"{title}Study",
        __base__=SweepStudy if "over" in fields else Study if row.varies else SingleStudy,
        __doc__=row.function.__doc__.partition("\n")[0],
        kind=(Literal[row.name], ...),
        integrator=(integrator, integrator()),
        analysis=(analysis, Field({}, validate_default=True)),
        **{table: fields[key] for key, table in TABLES.items() if key in fields},
    )
    made = Models(study, integrator, analysis)
    for model in made:
        model.row = row
    return made


def tables_of(study: Mapping[str, Any]) -> dict[str, str]:
    """The table of a study in which each key is accepted; of a table its own name, else none."""
    made, given = models(KINDS[study["kind"]]), study.get("mechanism")
    given = given if isinstance(given, Mapping) else {}
    entry = catalog.NAMES.get(name) if isinstance(name := given.get("catalog"), str) else None
    own = _form(name, entry) if entry else TestSystem if "states" in given else Mechanism
    each = {"mechanism": own, "integrator": made.integrator, "analysis": made.analysis}
    found = {key: name for name, record in each.items() for key in record.model_fields}
    return found | {key: "" if key in ("kind", "name", "title") else key for key in made.study.model_fields}


def in_a_study(problems: Iterable[Problem]) -> list[Problem]:
    """Problems of keywords of an analysis, with the keys that these have in a study."""
    return [replace(problem, key=_place(problem.key)) for problem in problems]


def keyword_of(key: str) -> str:
    """Keyword of the analysis for a key of a study; else the first part of the key."""
    own, _, rest = key.partition(".")
    inside = own in ("analysis", "integrator") and rest
    named = {vary_table.ROOT: "over"} | {table: key for key, table in TABLES.items()}
    return first(rest) if inside else named.get(first(own), first(own))


def _place(key: str) -> str:
    """Key of a study for a key of an analysis function."""
    own, rest = first(key), key[len(first(key)) :]
    if own == "parameters":  # of a test system
        return f"mechanism.{key}"
    if own in TABLES:
        return f"{TABLES[own]}{rest}"
    if own in ("mechanism", "over"):
        return key if own == "mechanism" else f"{vary_table.ROOT}{rest}"
    return join("integrator" if own in INTEGRATOR else "analysis", key)


def figure_problems(
    row: Kind,
    mechanism: Mechanism | TestSystem,
    keywords: Mapping[str, Any],
    vary: Mapping[str, Any],
    options: Mapping[str, Any],
) -> list[Problem]:
    """Problems of a figure's options that the result cannot satisfy; keywords are right by themselves."""
    followed = {keywords["parameter"]: keywords["range"]} if "parameter" in keywords else {}
    grown = largest(mechanism, keywords.get("over", followed))  # by what the analysis varies itself
    settings = {**keywords, "recorded": _recorded(row, grown, keywords)}
    suited = _suited(row, grown, keywords, vary)
    kind = options.get("kind", figures.usual(suited, options, len(keywords.get("over", ()))))
    if kind not in suited:
        expected = f"for this {row.name} one of {', '.join(suited) or 'none'} is accepted"
        problems = [Problem("figure.kind", kind, expected)]
    elif kind == "sweep":
        problems = [*_sweep_problems(row, points(mechanism, vary), options, settings)]
    else:
        problems = figures.study_problems(kind, options, settings)
    problems += _unknown_parts(grown, options)
    events = options.get("events", False)
    named = [] if isinstance(events, bool) else [events] if isinstance(events, str) else list(events)
    problems += [unknown("figure.events", e, e, EVENTS, "kind of event") for e in named if e not in EVENTS]
    return sorted(problems, key=lambda problem: problem.key)


def _recorded(
    row: Kind, mechanism: Mechanism | TestSystem, keywords: Mapping[str, Any]
) -> tuple[str, ...] | None:
    """Quantities that `record` names, of a test system states too; None if wrong ones, or none can be."""
    if "record" not in row.function.fields():
        return None
    try:
        names = load(row.recorded)(keywords.get("record"), mechanism)
    except InputError:
        return None
    return names + (mechanism.observed if "state_value" in names else ())


def _suited(
    row: Kind, mechanism: Mechanism | TestSystem, keywords: Mapping[str, Any], vary: Mapping[str, Any]
) -> list[str]:
    """Kinds of figure that the result can be drawn as; with `[vary]`, of all cells side by side too."""
    kinds = [*figures.suited(row), *["sweep"] * (bool(vary) and "over" not in keywords)]
    if "windows" in row.function.fields() and keywords.get("section"):
        kinds.append("poincare_section")
    if isinstance(mechanism, Mechanism) and mechanism.clearance_joints:
        return kinds
    return [name for name in kinds if not figures.ABOUT[name].clearance]


def _sweep_problems(
    row: Kind, grid: Points, options: Mapping[str, Any], settings: Mapping[str, Any]
) -> Iterator[Problem]:
    """Problems of the options of a figure of all cells."""
    usual = figures.suited(row)[:1]
    misfits = (figures.study_problems(kind, {"kind": kind}, settings) for kind in usual)
    if not options.get("quantity") and (not row.outputs.shown or any(misfits)):
        expected = f"the name of a variable is needed: a {row.name} has no usual number here"
        yield Problem("figure.quantity", options.get("quantity", NOTHING), expected)
    names = [*grid.dims, *(axis.name for axis in grid.axes if axis.name not in grid.dims)]
    if (along := options.get("along")) is not None and along not in names:
        yield unknown("figure.along", along, along, names, "varied parameter")
    at, most = options.get("at"), settings.get("starts")
    number = at.get("number") if isinstance(at, Mapping) and isinstance(most, int) else None
    if number not in (None, "largest", *range(1, 1 + (most or 0))):
        expected = f"the number of a motion, from 1 to {most}, that of the starts, or 'largest' is accepted"
        yield Problem("figure.at.number", number, expected)


def _unknown_parts(mechanism: Mechanism | TestSystem, options: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of a figure's options that name a link or joint that the mechanism does not have."""
    if not isinstance(mechanism, Mechanism):
        return
    parts = {
        "link": ([link.name for link in mechanism.links], "link"),
        "joint": (
            [*dict.fromkeys(mechanism.contacts + mechanism.guides)],
            "joint with clearance, or prismatic",
        ),
        "pin": ([joint.name for joint in mechanism.joints if joint.ideal], "ideal joint"),
    }
    for key, (names, what) in parts.items():
        if key in options and options[key] not in names:
            yield unknown(f"figure.{key}", options[key], options[key], names, what)
