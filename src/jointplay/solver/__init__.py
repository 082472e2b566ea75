"""The compact rigid and elastic solver: a mechanism in, a motion out. It serves alone, without analyses.

    from jointplay.solver import Request, assemble, follow

    model = assemble(mechanism)
    records = follow(model, Request(duration=10 * model.period, rtol=1e-8))

`Mechanism` and `System` are what moves, `assemble` makes a `Model` of it (structure, numbers, start), and
`follow` gives the `Records` of its motion: rows of time, state, modes and work. Names load on first use.
"""

from importlib import import_module

from jointplay.display.errors import no_attribute

_HOME = {
    "Mechanism": ".mechanism.records",
    "System": ".mechanism.records",
    "assemble": ".mechanism.assemble",
    "Model": ".mechanism.model",
    **dict.fromkeys(("Request", "Records", "follow"), ".motion.trajectory"),
    "Status": ".method.codes",
}
__all__ = list(_HOME)


def __getattr__(name: str):
    if name not in _HOME:
        raise no_attribute(f"module {__name__!r}", name, __all__)
    globals()[name] = value = getattr(import_module(_HOME[name], __name__), name)
    return value
