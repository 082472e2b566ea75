"""Input that the tests of the records spoil."""

import pytest

from jointplay.solver.mechanism import catalog
from tests.support.wrong import listed


@pytest.fixture
def plain():
    """The catalog's mechanism as plain lists and tables."""
    return listed(catalog.chunmei2002().model_dump())
