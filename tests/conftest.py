"""The method is compiled once, in a process of its own, before any test: as users' processes have it."""

from jointplay.codegen import cache


def pytest_configure(config):
    if not hasattr(config, "workerinput"):  # the process that starts the others
        cache.method("tangent_flow")
