"""What the tests of wrong input share."""

import pytest

from jointplay.display.errors import InputError


def listed(data):
    """Write records out as plain lists and tables, as a study file would."""
    if isinstance(data, dict):
        return {key: listed(value) for key, value in data.items() if value is not None}
    return [listed(item) for item in data] if isinstance(data, list | tuple) else data


def problems_of(build, /, *values, **named):
    """Give what a call finds wrong, by key."""
    with pytest.raises(InputError) as caught:
        build(*values, **named)
    error = caught.value
    assert len(str(error).splitlines()) == len(error.problems)
    return {problem.key: problem for problem in error.problems}


def refused(build, /, *values, **named):
    """Give what would be accepted in place of what a call finds wrong, by key."""
    return {key: problem.expected for key, problem in problems_of(build, *values, **named).items()}


def texts_of(build, /, *values, **named):
    """Give what a call says of what it finds wrong, by key."""
    return {key: str(problem) for key, problem in problems_of(build, *values, **named).items()}


def only(found, key):
    """Give the one problem found, at this key."""
    assert list(found) == [key], found
    return found[key]
