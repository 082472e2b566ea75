"""The JSON schema of study files, for editors that complete keys and mark mistakes."""

from typing import Any

from jointplay.study.file import STUDY_FILE

DIALECT = "https://json-schema.org/draft/2020-12/schema"
BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
INTERNAL = ("noun", "accepts", "discriminator")  # what only our own error messages and pydantic use


def schema() -> dict[str, Any]:
    """JSON schema of study files, as plain JSON types."""
    tidy = _tidy(STUDY_FILE.json_schema())
    for kind in tidy["$defs"].values():
        if (
            "kind" in kind["properties"]
            and "name" in kind.get("required", ())
            and "mechanism" in kind["properties"]
        ):
            kind["required"].remove("name")  # the file's own name is taken
    return {"$schema": DIALECT, "title": "jointplay study file", **tidy}


def _tidy(node: Any) -> Any:
    """Name bounds as JSON schema does, and drop titles that only repeat the key."""
    if isinstance(node, list):
        return [_tidy(item) for item in node]
    if not isinstance(node, dict):
        return node
    return {BOUNDS.get(key, key): _tidy(value) for key, value in node.items() if not _idle(key, value)}


def _idle(key: str, value: Any) -> bool:
    return key in INTERNAL or (key == "title" and isinstance(value, str))
