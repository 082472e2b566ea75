"""The method is compiled once, in a process of its own, before any test: as users' processes have it.

Meanwhile the structures that most tests use are compiled here, and not by every worker once more.
"""

from jointplay import catalog
from jointplay.analysis.request import quantity
from jointplay.analysis.run import functions
from jointplay.codegen import cache
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import CrankAngle


def pytest_configure(config):
    if not hasattr(config, "workerinput"):  # the process that starts the others
        cache.prepare("tangent_flow")
        system, crank = catalog.chunmei2002(), quantity(CrankAngle(), catalog.chunmei2002())
        for scene in (assemble(system), assemble(system, None, crank), assemble(system, powers=True)):
            functions(scene.structure)
        cache.variation_module(assemble(system).structure)
        cache.method("tangent_flow")
