"""The JSON schema of study files."""

import pytest

from jointplay.kinds import KINDS
from jointplay.study import models as study_models
from jointplay.study.file import schema
from jointplay.study.models import models


def test_every_keyword_is_described_by_its_function():
    tables, kinds = schema()["$defs"], [models(row)[1:] for row in KINDS.values()]
    named = {(m.__name__, key): each for both in kinds for m in both for key, each in _keys(tables, m)}
    assert not [place for place, each in named.items() if not each.get("description")]
    window = "Theiler window: pairs of points fewer than so many apart in time are left out."
    assert named["DimensionAnalysis", "window"]["description"] == window


def test_choices_of_words_are_listed():
    tables = schema()["$defs"]
    assert tables["TolerancesAnalysis"]["properties"]["sequence"]["enum"] == ["sobol", "random"]
    forms = tables["OptimiseAnalysis"]["properties"]["keep"]["anyOf"]
    assert any({"const": "contact", "type": "string"}.items() <= each.items() for each in forms)


def _keys(tables, model):
    return tables[model.__name__]["properties"].items()


def test_every_table_of_the_schema_is_closed():
    tables = schema()["$defs"]
    assert {"ResponseStudy", "SectionStudy", "Mechanism", "Link", "Joint"} <= set(tables)
    assert all(table["additionalProperties"] is False for table in tables.values())


@pytest.mark.nightly
def test_the_catalogs_tables_are_made_once_for_all_kinds_of_study(monkeypatch):
    first = schema()
    monkeypatch.setattr(study_models, "create_model", lambda *_, **__: pytest.fail("it is made again"))
    assert schema() == first


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["ResponseStudy", "SectionStudy"])
def test_a_name_is_not_required_and_bounds_are_said(kind):
    table = schema()["$defs"][kind]
    assert set(table["required"]) == {"kind", "mechanism"}
    assert schema()["$defs"]["Link"]["properties"]["mass"]["exclusiveMinimum"] == 0
