"""The `[mechanism]` table of a study file: an entry of the catalog with changes, or a linkage written out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from inspect import signature
from typing import Any, Literal, get_type_hints

from pydantic import create_model

from jointplay.display.errors import InputError, refuse, unknown
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.paths import as_paths
from jointplay.solver.mechanism.records import Changes, Mechanism, TestSystem

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
        return catalog.NAMES[name](**as_paths(changes))
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
