"""Checks of a call by the function's own signature: every problem at once, as an `InputError`.

What stands in `Annotated` is checked, by the types and in the words of the records and study files; any other
annotation only informs the reader, and the function checks the value itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cache, partial, wraps
from inspect import Parameter, signature
from typing import Annotated, Any, ClassVar, TypeVar, get_args, get_origin, get_type_hints

from pydantic import ConfigDict, create_model

from jointplay.errors import InputError, Problem
from jointplay.mechanism.base import Record

T = TypeVar("T")
_POSITIONAL = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)


class Arguments(Record):
    """Arguments of a call."""

    model_config = ConfigDict(arbitrary_types_allowed=True)
    root: ClassVar[str | None] = ""


class MoreArguments(Arguments):
    """Arguments of a call of a function that also takes others by name (``**keywords``)."""

    model_config = ConfigDict(extra="allow")


Rule = Callable[..., Iterable[Problem] | None]


def checked(*rules: Rule) -> Callable[[Callable[..., T]], Callable[..., T]]:
    """Check the arguments of each call by the function's annotations, and bring them into their types.

    Parameters
    ----------
    *rules : callable
        Each is called with those of the arguments that it names, where all of these are valid by themselves;
        it yields the problems of their combination, or raises an `InputError`.

    Returns
    -------
    callable
        Decorates a function. The result has ``fields()``, type and default of each argument, and
        ``rule_problems``, which gives the problems that the rules find in arguments from elsewhere.

    Raises
    ------
    InputError
        At a call, listing every argument that is unknown, missing, not accepted, or does not fit the others.
    """

    def decorated(function: Callable[..., T]) -> Callable[..., T]:
        fields = cache(partial(_fields, function))
        parameters = signature(function).parameters
        positional = [name for name, p in parameters.items() if p.kind is Parameter.POSITIONAL_ONLY]
        open_ended = any(p.kind is Parameter.VAR_KEYWORD for p in parameters.values())
        record = cache(partial(_record, function.__name__, fields, open_ended))
        named = [(rule, {*signature(rule).parameters}) for rule in rules]

        def rule_problems(given: Mapping[str, Any], invalid: Collection[str] = ()) -> list[Problem]:
            """Problems that the rules find in arguments, apart from those that are invalid by themselves."""
            defaults = {name: None if default is ... else default for name, (_, default) in fields().items()}
            valid = {name: value for name, value in given.items() if name not in invalid}
            try:
                valid = defaults | (dict(record(needed=False)(**valid)) if invalid else valid)
            except InputError:  # so much is wrong that not all of it is known
                return []
            checks = ((rule, {n: valid[n] for n in names}) for rule, names in named if not names & {*invalid})
            return [problem for rule, arguments in checks for problem in _problems(rule, arguments)]

        @wraps(function)
        def call(*values: Any, **others: Any) -> T:
            given = _by_name(function, values, others)
            try:
                arguments, problems = dict(record()(**given)), []
            except InputError as error:
                arguments, problems = given, error.problems
            if problems := problems + rule_problems(arguments, {first(problem.key) for problem in problems}):
                raise InputError(problems)
            return function(*[arguments.pop(name) for name in positional], **arguments)

        call.fields, call.rule_problems = fields, rule_problems  # type: ignore[attr-defined]
        return call

    return decorated


def _problems(rule: Rule, arguments: dict[str, Any]) -> list[Problem]:
    """Problems that a rule finds in the arguments that it names."""
    try:
        return list(rule(**arguments) or ())
    except InputError as error:
        return error.problems


def first(key: str) -> str:
    """The first part of a key path: ``links`` of ``links[0].mass``."""
    return re.split(r"[.\[]", key)[0]


def _fields(function: Callable[..., Any]) -> dict[str, tuple[Any, Any]]:
    """Type and default of each argument of a function; of one that is needed, `...`."""
    hints, parameters = get_type_hints(function, include_extras=True), signature(function).parameters.items()
    own = {name: p for name, p in parameters if p.kind is not Parameter.VAR_KEYWORD}
    return {name: _field(hints.get(name), p) for name, p in own.items()}


def _field(hint: Any, parameter: Parameter) -> tuple[Any, Any]:
    default = ... if parameter.default is Parameter.empty else parameter.default
    annotated = any(get_origin(part) is Annotated for part in (hint, *get_args(hint)))
    return (hint if annotated else Any, default)


def _record(name: str, fields: Callable[[], Any], open_ended: bool, needed: bool = True) -> type[Arguments]:
    """Make the record of a function's arguments; unless they are needed, None stands for those left out."""
    own: Any = {
        key: (hint, None if default is ... and not needed else default)
        for key, (hint, default) in fields().items()
    }
    return create_model(name, __base__=MoreArguments if open_ended else Arguments, **own)


def _by_name(function: Callable[..., Any], values: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any]:
    """Bring all arguments of a call under their names."""
    names = [name for name, p in signature(function).parameters.items() if p.kind in _POSITIONAL]
    if len(values) > len(names):
        known = ", ".join(name for name in names if name != "self") or "nothing"
        expected = f"{known} by position, all else by keyword is accepted"
        raise InputError([Problem(function.__name__, values[len(names) :], expected)])
    placed = dict(zip(names, values, strict=False))
    if twice := placed.keys() & named.keys():
        text = "once is accepted, not by position too"
        raise InputError(Problem(name, named[name], text) for name in twice)
    return placed | named
