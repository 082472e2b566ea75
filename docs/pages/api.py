"""The Python interface by task: each public name, on one page."""

from __future__ import annotations

import jointplay
from jointplay.kinds import KINDS

TASKS = {
    "mechanism": (
        "Describe a mechanism",
        "Links, joints, drives and loads, and what a drawing says of a joint.",
    ),
    "equations": (
        "Describe own equations",
        "Systems of states and rates, with contacts, switches and jumps.",
    ),
    "simulate": ("Simulate", "Time histories and Poincaré sections."),
    "analyse": ("Analyse", "Chaos, orbits, basins, sweeps, derivatives, optima."),
    "draw": ("Draw", "Figures, films and pages."),
    "store": ("Run, store and read", "Studies, and results as they are read, put into words and exported."),
    "errors": ("Errors and warnings", "What wrong and unusual input raises."),
    "laboratory": ("The laboratory", "The paper's claims, and the program's examination of itself."),
    "others": ("From other packages", "What packages beside this one publish."),
}
_NAMES = {
    "mechanism": "Mechanism Link PointMass Beam Joint Pin Contact Friction Spring TorsionSpring Force Torque "
    "Harmonic MotorLine ConstantSpeed PrescribedTorque SpeedProfile SpeedCycle Servo "
    "contact_data fit contact_stiffness",
    "equations": "System Touch Rubbing Switch Impact Jump TestSystem",
    "simulate": "simulate poincare CrankAngle ContactSection SeparationSection Plane",
    "analyse": "growth",
    "draw": "figure animate report",
    "store": "run open summary words cell export",
    "errors": "InputError ModelWarning",
}
OF = {name: task for task, names in _NAMES.items() for name in names.split()}
PLACES = {name: place for place, name in enumerate(OF, 1)}  # those with none come before
METHODS = {"Mechanism": ("replace", "summary")}


def task(name: str) -> str:
    """The task on whose page a public name is."""
    homes = {row.home.partition(":")[2]: row.home for row in KINDS.values()} | jointplay._homes()
    if name in OF:
        return OF[name]
    if homes[name].startswith(".solver"):
        return "mechanism"
    package = homes[name].partition(".")[0]
    return {"": "analyse", "jointplay_lab": "laboratory"}.get(package, "others")


def described(name: str) -> str:
    """Directives that describe a public name."""
    value = getattr(jointplay, name)
    of = "function"
    if isinstance(value, type):
        of = "exception" if issubclass(value, Exception) else "class"
    methods = [f".. automethod:: jointplay.{name}.{each}" for each in METHODS.get(name, ())]
    return "\n".join([f".. auto{of}:: jointplay.{name}", *methods])


def pages() -> dict[str, str]:
    """A page for each task, and the list of them."""
    names = {*jointplay.__all__} - {"__version__", "catalog"}
    names = sorted(names, key=lambda name: (PLACES.get(name, 0), jointplay.__all__.index(name)))
    found, rows = {}, []
    for key, (title, said) in TASKS.items():
        own = [name for name in names if task(name) == key]
        if not own:
            continue
        listed = "\n".join(described(name) for name in own)
        found[f"api_{key}.md"] = f"# {title}\n\n{said}\n\n```{{eval-rst}}\n{listed}\n```\n"
        rows.append(f"| [{title}](generated/api_{key}.md) | {', '.join(f'`{name}`' for name in own)} |")
    tree = "\n".join(f"generated/{name.removesuffix('.md')}" for name in found)
    table = "\n".join(["| task | names |", "| --- | --- |", *rows])
    return found | {"api.inc": f"{table}\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n"}
