"""The method is compiled once, in a process of its own, before any test: as users' processes have it.

Meanwhile the structures that most tests use are compiled here, and not by every worker once more.
"""

import hypothesis
import pytest

from jointplay import catalog
from jointplay.analysis.rules import quantity
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import CrankAngle
from jointplay.solver.motion.trajectory import functions

hypothesis.settings.register_profile(  # a busy machine is no mistake of the program's
    "unhurried", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("unhurried")

LOOPS = ("flow", "tangents.tangent_flow", "lanes.flow", "lanes.lane", "lanes.attempts", "walls.wall_flow")


def pytest_configure(config):
    if not hasattr(config, "workerinput"):  # the process that starts the others
        for loop in LOOPS:
            cache.prepare(loop)
        system = catalog.chunmei2002()
        plain, turn = assemble(system), quantity(CrankAngle(), system)
        for model in (plain, assemble(system, None, turn), assemble(system, powers=True)):
            functions(model.structure)
        cache.variation_module(plain.structure)
        for loop in LOOPS:
            cache.method(loop)


def pytest_collection_modifyitems(items):
    """Long tests end too, after half an hour where they name no limit."""
    for item in items:
        slow = item.get_closest_marker("long") or item.get_closest_marker("nightly")
        if slow and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(1800))
