"""The JSON schema of study files, for editors that complete keys and mark mistakes."""

import re
from functools import reduce
from inspect import getdoc
from operator import or_
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from jointplay.kinds import KINDS, Kind
from jointplay.study.models import models

DIALECT = "https://json-schema.org/draft/2020-12/schema"
BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
INTERNAL = ("noun", "accepts", "discriminator")  # what only our own error messages and pydantic use


def schema() -> dict[str, Any]:
    """JSON schema of study files, as plain JSON types."""
    every = reduce(or_, (models(row).study for row in KINDS.values()))
    tidy = _tidy(TypeAdapter(Annotated[every, Field(discriminator="kind")]).json_schema())
    for kind in tidy["$defs"].values():
        if (
            "kind" in kind["properties"]
            and "name" in kind.get("required", ())
            and "mechanism" in kind["properties"]
        ):
            kind["required"].remove("name")  # the file's own name is taken
    for row in KINDS.values():
        _describe(row, tidy["$defs"])
    return {"$schema": DIALECT, "title": "jointplay study file", **tidy}


def _describe(row: Kind, tables: dict[str, Any]) -> None:
    """Say of each keyword what the docstring of the analysis function says of it."""
    text = getdoc(row.function).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    told = dict(re.findall(r"^(\S[^:\n]*?)(?: :.*)?\n((?:    .*\n?)+)", text, re.M))
    texts = {name: " ".join(each.split()) for names, each in told.items() for name in names.split(", ")}
    for model in models(row)[1:]:
        for name, each in tables[model.__name__]["properties"].items():
            if name in texts:
                each["description"] = texts[name]


def _tidy(node: Any) -> Any:
    """Name bounds as JSON schema does, and drop titles that only repeat the key."""
    if isinstance(node, list):
        return [_tidy(item) for item in node]
    if not isinstance(node, dict):
        return node
    return {BOUNDS.get(key, key): _tidy(value) for key, value in node.items() if not _idle(key, value)}


def _idle(key: str, value: Any) -> bool:
    return key in INTERNAL or (key == "title" and isinstance(value, str))
