"""The JSON schema: the committed copy has the same keys, and shipped studies keep to them."""

import json
from pathlib import Path

import pytest

from jointplay.study.schema import schema

ROOT = Path(__file__).parents[2]
COMMITTED = ROOT / "docs" / "study.schema.json"


def keys(node, path=""):
    """Every key that the schema allows or requires; not how a release of pydantic happens to write it."""
    if isinstance(node, list):
        return set().union(*(keys(item, path) for item in node))
    if not isinstance(node, dict):
        return set()
    own = {f"{path}.{name}" for name in node.get("properties", {})}
    own |= {f"{path}.{name}!" for name in node.get("required", [])}
    return own.union(*(keys(value, f"{path}.{name}") for name, value in node.items()))


def test_the_committed_schema_is_the_current_one():
    told = (
        "run `jointplay schema > docs/study.schema.json`; study files written before must still be accepted"
    )
    assert keys(json.loads(COMMITTED.read_text(encoding="utf-8"))) == keys(schema()), told


def test_every_table_of_the_schema_is_closed():
    tables = schema()["$defs"]
    assert {"ResponseStudy", "SectionStudy", "Mechanism", "Link", "Joint"} <= set(tables)
    assert all(table["additionalProperties"] is False for table in tables.values())


@pytest.mark.parametrize("kind", ["ResponseStudy", "SectionStudy"])
def test_a_name_is_not_required_and_bounds_are_said(kind):
    table = schema()["$defs"][kind]
    assert set(table["required"]) == {"kind", "mechanism", "analysis"}
    assert schema()["$defs"]["Link"]["properties"]["mass"]["exclusiveMinimum"] == 0
