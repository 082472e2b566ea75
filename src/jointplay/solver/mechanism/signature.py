"""Public functions that are checked by their own signature: every problem at once, as an `InputError`.

What stands in `Annotated`, or is a choice of words (`Literal`), is checked, by the types and in the words of
the records and study files; any other annotation only tells the reader, and the function looks at the value
itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial, wraps
from inspect import Parameter, signature, unwrap
from types import SimpleNamespace
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    ParamSpec,
    Protocol,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

from pydantic import ConfigDict, create_model
from typing_extensions import get_original_bases, is_typeddict

from jointplay.display.accepted import with_parameters
from jointplay.display.errors import InputError, Problem, also_known, raise_any
from jointplay.solver.mechanism.base import Record, is_number
from jointplay.solver.mechanism.paths import MAIN_JOINT, as_paths

P = ParamSpec("P")
T = TypeVar("T")
_BY_PLACE = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)


class Arguments(Record):
    """The arguments of a call."""

    model_config = ConfigDict(arbitrary_types_allowed=True)
    root: ClassVar[str | None] = ""


class MoreArguments(Arguments):
    """The arguments of a call of a function that takes others by name, too."""

    model_config = ConfigDict(extra="allow")


Rule = Callable[..., Iterable[Problem] | None]
OF_LINKS = ("mass", "centre", "inertia_centre")  # words of entries of the catalog, each a table by link


def checked(
    *rules: Rule | str,
    deferred: Collection[Rule | str] = (),
    before: Callable[[dict[str, Any]], dict[str, Any]] = dict,
    after: Callable[[dict[str, Any]], None] = lambda arguments: None,
    **shared: Callable[..., Any],
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Check the arguments of each call by the function's annotations, and bring them into their types.

    Parameters
    ----------
    *rules : callable or str
        Each is called with those of the arguments that it names, where all of these are right by themselves;
        it yields the problems of their not fitting together, or raises an `InputError`. Or the name of a
        shared value, whose making tells.
    deferred : collection of callable or str
        Rules whose problems the function itself raises first of all: asked here only beside other problems.
    before : callable
        Gives the arguments to check, of those that were given.
    after : callable
        Called with the arguments when all is right.
    **shared : callable
        What rules may name beside arguments, each made once of the arguments that it names itself; where that
        raises an `InputError`, a rule that names it takes its own default, or is not asked. The function may
        name it too: then it is no argument of a call, and told of as what is deferred where no rule names it.

    Returns
    -------
    callable
        Decorates a function. What it gives has ``fields()``, type and default of each argument, and
        ``validated``, which tells what rules say of arguments from elsewhere, and calls it with them.

    Raises
    ------
    InputError
        At a call, listing every argument that is unknown, missing, not accepted, or does not fit the others.
    """

    def decorated(function: Callable[P, T]) -> Callable[P, T]:
        whole = signature(function)
        own = {name: each for name, each in whole.parameters.items() if name not in shared}
        taken = [name for name in whole.parameters if name in shared]
        last = (*(name for name in taken if name not in rules), *deferred)
        function.__signature__ = whole.replace(parameters=own.values())  # type: ignore[attr-defined]
        fields = cache(partial(_fields, function))
        alone = [name for name, each in own.items() if each.kind is Parameter.POSITIONAL_ONLY]
        places = [name for name, each in own.items() if each.kind in _BY_PLACE]
        open_ended = any(each.kind is Parameter.VAR_KEYWORD for each in own.values())
        form = cache(partial(_form, function.__name__, fields, open_ended))

        def known(given: Mapping[str, Any], wrong: Collection[str]) -> _Shared:
            """Arguments that are right by themselves; none where so much is wrong that not all is known."""
            usual = {name: None if default is ... else default for name, (_, default) in fields().items()}
            sound = {name: value for name, value in given.items() if name not in wrong}
            try:
                return _Shared(usual | (dict(form(needed=False)(**sound)) if wrong else sound), shared)
            except InputError:
                return _Shared({}, shared)

        def validated(
            given: Mapping[str, Any], wrong: Collection[str] = ()
        ) -> tuple[list[Problem], Callable[..., T]]:
            """Problems that rules find in arguments, but of those that are `wrong`, and the answer."""
            arguments = known(given, wrong)
            problems = arguments.problems((*rules, *last), wrong)
            return problems, partial(answer, arguments, problems)

        def answer(arguments: _Shared, problems: list[Problem], **more: Any) -> T:
            """Call the function; `more` stands in place of its arguments, as rules that name it allow."""
            again = [
                rule for rule in rules if not isinstance(rule, str) and _names(rule).keys() & more.keys()
            ]
            raise_any(problems + _Shared(arguments.given | more, shared).problems(again))
            given = arguments.given | {name: arguments[name] for name in taken} | more
            by_place = [given.pop(name) for name in alone]
            if not open_ended:
                return function(*by_place, **given)
            try:
                return function(*by_place, **given)
            except InputError as error:  # of a keyword that it hands on, where its own are accepted too
                named = [name for name in own if name in fields() and name != "self"]
                found = (also_known(problem, named) for problem in error.problems)
                raise InputError(found, error.root, error.more) from None

        @wraps(function)
        def call(*values: P.args, **others: P.kwargs) -> T:
            given = before(_by_name(function.__name__, places, values, others))
            try:
                given, problems = dict(form()(**given)), []
            except InputError as error:
                problems = error.problems
            wrong = {first(problem.key) for problem in problems}
            arguments = known(given, wrong)
            if problems := problems + arguments.problems(rules, wrong):
                raise InputError(problems + arguments.problems(last, wrong))
            after(given)
            return answer(arguments, [])

        call.fields, call.validated = fields, validated  # type: ignore[attr-defined]
        return call

    return decorated


class _Shared(dict[str, Any]):
    """Arguments by name (`given`), and values shared by rules, made of the arguments when first used."""

    def __init__(self, given: Mapping[str, Any], shared: Mapping[str, Callable[..., Any]]) -> None:
        super().__init__(given)
        self.given, self.shared = dict(given), shared

    def __missing__(self, name: str) -> Any:
        made = self[name] = self.shared[name](**self.of(self.shared[name]))
        return made

    def of(self, function: Callable[..., Any]) -> dict[str, Any]:
        """The arguments of a function; of shared values that cannot be made its own defaults."""
        found = dict(_names(function))
        for name, default in _names(function).items():
            try:
                found[name] = self[name]
            except InputError:
                if default is Parameter.empty:
                    raise
        return found

    def needed(self, rule: Rule | str) -> set[str]:
        """Names of the arguments that a rule, or a shared value, cannot do without."""
        named = {rule: Parameter.empty} if isinstance(rule, str) else _names(rule)
        own = {n for n, each in named.items() if n not in self.shared or each is Parameter.empty}
        return own.union(*(self.needed(self.shared[name]) for name in own & self.shared.keys()))

    def problems(self, rules: Iterable[Rule | str], wrong: Collection[str] = ()) -> list[Problem]:
        """Problems that rules, or the making of shared values, find; but of `wrong` arguments."""
        applicable = [rule for rule in rules if self.given and not (wrong and self.needed(rule) & {*wrong})]
        return [problem for rule in applicable for problem in self._of(rule)]

    def _of(self, rule: Rule | str) -> list[Problem]:
        try:
            own = None if isinstance(rule, str) else self.of(rule)
        except InputError:  # another rule tells
            return []
        try:
            if own is not None:
                return list(rule(**own) or ())
            self[rule]
        except InputError as error:
            return error.problems
        return []


@cache
def _names(function: Callable[..., Any]) -> dict[str, Any]:
    """Names of a function's parameters, and their defaults."""
    return {name: each.default for name, each in signature(function).parameters.items()}


@runtime_checkable
class Preset(Protocol):
    """An entry of the catalog, which `preset` makes: a function that gives a mechanism or a system."""

    references: tuple[str, ...]
    trial: Mapping[str, Any]
    fields: Callable[[], Mapping[str, Any]]

    def __call__(self, **arguments: Any) -> Any:
        """Give the mechanism, or system."""


def as_one(given: Mapping[str, Any], main: str = MAIN_JOINT) -> dict[str, Any]:
    """Changes by word and by path that fit together; tables of parts are paths.

    A friction stays where a contact is given by its parts, and so do numbers of links where their shape is.
    A joint's clearance (`main`: whose a bare number is) cannot be given by word and again by path, by its fit
    either.
    """
    given = as_paths(given)
    joints = [key.removesuffix("contact") for key in given if key.endswith(".contact")]
    rubs = {"coefficient": given["friction"]} if "friction" in given else None
    raise_any(_given_twice(given, main))
    tables = {word: given[word] for word in OF_LINKS if isinstance(given.get(word), Mapping)}
    rows = ((f"links.{name}", word, x) for word, table in tables.items() for name, x in table.items())
    kept = {f"{link}.{word}": x for link, word, x in rows if f"{link}.shape" in given}
    return {f"{joint}friction": rubs for joint in joints if rubs} | kept | given


def _given_twice(given: Mapping[str, Any], main: str) -> Iterator[Problem]:
    """Clearances by word of joints that have one, or a fit, by path too."""
    word = given.get("clearance")
    for name, value in (word if isinstance(word, Mapping) else {main: word}).items():
        for path in (f"joints.{name}.clearance", f"joints.{name}.fit"):
            there = isinstance(value, str) or (is_number(value) and value != 0)
            if there and given.get(path) is not None:
                text = f"either clearance or {path}, which is {given[path]}, is accepted, not both"
                yield Problem(f"clearance.{name}" if word is not value else "clearance", value, text)


def preset(*references: str, **trial: Any) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Mark an entry of the catalog: its arguments are checked, its trial and its references kept with it.

    Parameters
    ----------
    *references : str
        What it rests on, as of a law (`equations.quantity.ForceLaw`).
    **trial
        Arguments with which it is tried: those that have no default.
    """

    def decorated(make: Callable[P, T]) -> Callable[P, T]:
        made = checked(before=as_one)(make)
        made.references, made.trial = references, trial
        return made

    return decorated


@dataclass(frozen=True)
class Usual:
    """Default of a keyword in a table that functions unpack, as ``Annotated[Rtol, Usual(1e-8)]``."""

    value: Any


def unpack(function: Callable[..., Any], usual: Mapping[str, Any]) -> None:
    """Write the keywords of a table that a function unpacks (PEP 692) into its signature and docstring.

    Parameters
    ----------
    function : callable
        Takes ``**name: Unpack[table]``, with a table of keywords whose defaults are each `Usual`. One that
        takes no table stays as it is. What its docstring describes itself is not described by the table.
    usual : mapping of str to object
        Defaults that are this function's own.

    Raises
    ------
    TypeError
        If a default is that of no keyword of the table.
    """
    given = signature(function)
    *own, last = given.parameters.values()
    if last.kind is not Parameter.VAR_KEYWORD:
        return
    hint = SimpleNamespace(__annotations__={last.name: function.__annotations__.pop(last.name)})
    (table,) = get_args(get_type_hints(hint, function.__globals__)[last.name])
    tables, hints = _with_bases(table), get_type_hints(table, include_extras=True)
    if strange := usual.keys() - hints:
        raise TypeError(f"{function.__name__} takes no {', '.join(sorted(strange))}")
    for key in sorted(hints, key=lambda key: sum(key in each.__annotations__ for each in tables)):
        kind, *more, default = get_args(hints[key])
        function.__annotations__[key] = Annotated[kind, *more] if more else kind
        text = re.sub(r"^Annotated\[(.*), Usual\(.*\)\]$", r"\1", table.__annotations__[key].__forward_arg__)
        default = usual.get(key, default.value)
        own.append(Parameter(key, Parameter.KEYWORD_ONLY, annotation=text, default=default))
    function.__signature__ = given.replace(parameters=own)  # type: ignore[attr-defined]
    function.__doc__ = with_parameters(function.__doc__, *tables)


def _with_bases(table: type) -> list[type]:
    """A table of keywords and the tables that it widens, the widest first."""
    above = [base for base in get_original_bases(table) if is_typeddict(base)]
    return [table, *(each for base in above for each in _with_bases(base))]


def first(key: str) -> str:
    """The first part of a key path: ``links`` of ``links[0].mass``."""
    return re.split(r"[.\[]", key)[0]


def _fields(function: Callable[..., Any]) -> dict[str, tuple[Any, Any]]:
    """Type and default of each argument of a function; of one that is needed, `...`."""
    types, own = types_of(function), signature(function).parameters.items()
    return {
        name: _field(types.get(name), each) for name, each in own if each.kind is not Parameter.VAR_KEYWORD
    }


def types_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Types of a function's arguments; the type of its result may not be imported yet."""
    written = unwrap(function)
    named = {name: hint for name, hint in written.__annotations__.items() if name != "return"}
    return get_type_hints(SimpleNamespace(__annotations__=named), written.__globals__, include_extras=True)


def _form(name: str, fields: Callable[[], Any], open_ended: bool, needed: bool = True) -> type[Arguments]:
    """The arguments of a function as a record; None stands for omitted ones, where none is needed."""
    own: Any = {
        key: (hint, None if default is ... and not needed else default)
        for key, (hint, default) in fields().items()
    }
    return create_model(name, __base__=MoreArguments if open_ended else Arguments, **own)


def _field(hint: Any, parameter: Parameter) -> tuple[Any, Any]:
    default = ... if parameter.default is Parameter.empty else parameter.default
    said = any(get_origin(each) in (Annotated, Literal) for each in (hint, *get_args(hint)))
    return (hint if said else Any, default)


def _by_name(
    function: str, places: list[str], values: tuple[Any, ...], named: dict[str, Any]
) -> dict[str, Any]:
    if len(values) > len(places):
        known = ", ".join(name for name in places if name != "self") or "nothing"
        expected = f"{known} by position, all else by keyword is accepted"
        raise InputError([Problem(function, values[len(places) :], expected)])
    placed = dict(zip(places, values, strict=False))
    once = "once is accepted, not by position too"
    raise_any(Problem(name, named[name], once) for name in placed.keys() & named.keys())
    return placed | named
