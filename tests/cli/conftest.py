"""Fixtures that these tests share with others."""

from tests.support.fixtures import calls, study

__all__ = ["calls", "study"]
