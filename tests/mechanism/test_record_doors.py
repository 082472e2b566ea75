"""Records are not changed, and the catalog lists what it holds and nothing else."""

import pickle

import pytest

import jointplay as jp
from jointplay.mechanism.catalog import NAMES


def test_a_record_that_is_set_says_what_to_do():
    mechanism = jp.catalog.chunmei2002()
    with pytest.raises(jp.InputError, match=r"clearance: got 3; .*replace\(\)"):
        mechanism.clearance = 3
    with pytest.raises(jp.InputError, match=r"mass: got 1\.0"):
        mechanism.links[0].mass = 1.0
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism == mechanism.model_copy()


def test_the_catalog_lists_its_entries():
    assert dir(jp.catalog) == sorted(NAMES)
