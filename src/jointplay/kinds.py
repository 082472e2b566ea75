"""The kinds of study: a row for each with all that the program knows of a kind but its keywords.

The keywords of a kind, with their types, defaults and rules, are those of its analysis function
(`analysis.keywords`). To add a kind, write that function and add its row to `KINDS`; a figure of its own is
one file (`figures.registry`). See docs/developers.md. Rows name code by its place, so that nothing is
imported before it is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from jointplay.display.errors import InputError, Problem
from jointplay.solver.extensions import Table

LENGTH = "{turns} turns after {transient} dropped turns"


@dataclass(frozen=True)
class Kind:
    """A kind of study; what it gives is declared beside its analysis function (`analysis.declared`).

    Parameters
    ----------
    name : str
        As study files and results call it.
    home : str
        Where its analysis function is, as ``package.module:function``; a leading dot stands for this package.
    figures : tuple of str
        Figures of its result; the default is the first whose variables it has. A figure can add itself.
    length : str
        Length of a study of this kind, in a line, with its keywords in braces.
    recorded : str
        Where the function is that names the recorded quantities, given ``record`` and the mechanism.
    varies : bool
        Whether a study of this kind may have a table `[vary]`.
    tangents : bool
        Whether tangents are propagated, so that their code is compiled before workers start.
    kept : bool
        Whether an interrupted run keeps what it has computed so far as a result.
    slow : int
        Rank among studies that run side by side: the larger, the earlier it begins.
    example : mapping of str to mapping
        What a new study of this kind sets (`jointplay new`) beside defaults: tables by name.
    trial : mapping of str to object
        Keywords of a short call for a test system, the impact pair of the catalog, by which it is tried.
    references : tuple of str, optional
        What it rests on, as of a law (`equations.quantity.ForceLaw`).
    """

    name: str
    home: str
    figures: tuple[str, ...] = ()
    length: str = LENGTH
    recorded: str = ".analysis.quantities:recorded"
    varies: bool = True
    tangents: bool = False
    kept: bool = False
    slow: int = 0
    example: Mapping[str, Mapping[str, Any]] = field(default_factory=dict, hash=False)
    trial: Mapping[str, Any] = field(default_factory=dict, hash=False)
    references: tuple[str, ...] | None = None

    @property
    def function(self) -> Callable[..., Any]:
        """The analysis function; `InputError` where another package names one that cannot be loaded."""
        try:
            return load(self.home)
        except (ImportError, AttributeError) as error:
            if not (source := KINDS.source(self.name)):
                raise
            why = f"its analysis {self.home} cannot be loaded: {type(error).__name__}: {error}"
            raise InputError([Problem("kind", self.name, f"{source}: {why}")]) from None

    @property
    def outputs(self) -> Any:
        """Declared outputs of the analysis (`analysis.declared`), none where it declares none."""
        return getattr(self.function, "outputs", None) or load(".analysis.declared:Outputs")(
            self.name, {}, {}
        )


def load(home: str) -> Any:
    """Import the object at a place such as ``.analysis.simulate:simulate``."""
    module, _, name = home.partition(":")
    return getattr(import_module(module, __package__), name)


DISC = ("eccentricity_ratio_x", "eccentricity_ratio_y")  # coordinates of a plane of starts
_ROWS = (
    Kind(
        "response",
        ".analysis.simulate:simulate",
        ("overview", "time_history", "contact_angle", "journal_orbit", "phase_portrait"),
        kept=True,
        example={"analysis": {"transient": 20, "turns": 5}},
        references=(),
        trial={"turns": 2, "steps": True},
    ),
    Kind(
        "section",
        ".analysis.poincare:poincare",
        ("poincare_section",),
        kept=True,
        example={"analysis": {"transient": 50, "turns": 200}},
        references=(),
        trial={"turns": 5},
    ),
    Kind(
        "bifurcation",
        ".analysis.sweeps.bifurcation:bifurcation",
        ("bifurcation", "parameter_map"),
        LENGTH + " at each point",
        recorded=".analysis.sweeps.bifurcation:names",
        example={
            "vary": {"clearance": {"start": 1e-5, "stop": 5e-4, "num": 40, "scale": "log"}},
            "analysis": {"transient": 100, "turns": 50, "exponents": 1, "lyapunov_turns": 50},
        },
        references=("parker_chua1989", "thompson_stewart2002"),
    ),
    Kind(
        "lyapunov",
        ".analysis.exponents.lyapunov:lyapunov",
        ("lyapunov",),
        tangents=True,
        kept=True,
        example={"analysis": {"transient": 20, "turns": 300}},
        references=("benettin1980", "flyvbjerg_petersen1989"),
        trial={"turns": 10},
    ),
    Kind(
        "covariant",
        ".analysis.exponents.covariant:covariant",
        ("covariant",),
        "{turns} turns after {transient} dropped turns, and {settling} after them",
        tangents=True,
        example={"analysis": {"turns": 100}},
        references=("ginelli2007", "benettin1980", "flyvbjerg_petersen1989"),
        trial={"turns": 10, "settling": 3, "transient": 3},
    ),
    Kind(
        "chaos_test",
        ".analysis.signals.chaos_test:chaos_test",
        ("chaos_test",),
        "{turns} section points after {transient} dropped turns",
        example={"analysis": {"transient": 50}},
        references=("gottwald_melbourne2004", "gottwald_melbourne2009"),
        trial={"turns": 60, "transient": 5},
    ),
    Kind(
        "spectrum",
        ".analysis.signals.spectrum:spectrum",
        ("spectrum",),
        example={"analysis": {"transient": 50, "turns": 100}},
        references=("welch1967", "percival_walden1993"),
        trial={"turns": 16, "quantity": "v"},
    ),
    Kind(
        "dimension",
        ".analysis.signals.dimension:dimension",
        ("dimension",),
        "{turns} section points after {transient} dropped turns",
        example={"analysis": {"transient": 50}},
        references=("grassberger_procaccia1983", "theiler1986", "eckmann_ruelle1992"),
        trial={"turns": 120},
    ),
    Kind(
        "sensitivity",
        ".analysis.states.sensitivity:sensitivity",
        ("divergence", "field"),
        tangents=True,
        kept=True,
        example={"analysis": {"transient": 50, "references": 5}},
        references=("wolf1985", "shadden2005", "benettin1980"),
        trial={"turns": 40},
    ),
    Kind(
        "basins",
        ".analysis.states.basins:basins",
        ("basins",),
        example={
            "mechanism": {"clearance": 2.5e-4},
            "analysis": {
                "plane": {key: {"start": -1.0, "stop": 1.0, "num": 13} for key in DISC},
                "turns": 24,
            },
        },
        references=("wilson1927", "grebogi1983"),
        trial={"plane": {"y": [-1.0, 1.0], "v": [0.0, 1.0]}, "transient": 5, "turns": 4, "patience": 0},
    ),
    Kind(
        "attractors",
        ".analysis.coexisting.attractors:attractors",
        ("attractors",),
        "{starts} starts in the region at each value, {turns} turns after up to {transient} dropped turns",
        recorded=".analysis.sweeps.bifurcation:names",
        example={
            "mechanism": {"clearance": 2.5e-4},
            "vary": {"clearance": {"start": 2.4e-4, "stop": 2.6e-4, "num": 3}},
            "analysis": {"region": dict.fromkeys(DISC, (-0.7, 0.7)), "starts": 24, "turns": 24},
        },
        references=("datseris2023", "wilson1927"),
    ),
    Kind(
        "tipping",
        ".analysis.coexisting.tipping:tipping",
        ("tipping",),
        "{starts} starts in the region, knocks up to {largest} in {steps} steps",
        tangents=True,
        example={
            "mechanism": {"clearance": 2.5e-4},
            "analysis": {
                "region": dict.fromkeys(DISC, (-0.7, 0.7)),
                "starts": 16,
                "turns": 24,
                "steps": 4,
                "phases": 1,
                "directions": 2,
            },
        },
        references=("schultz2017", "skufca2006"),
        trial={
            "region": {"y": [-1.0, 1.0], "v": [0, 1]},
            "starts": 2,
            "turns": 16,
            "patience": 1,
            "steps": 2,
        },
    ),
    Kind(
        "periodic_orbit",
        ".analysis.orbits.periodic_orbit:periodic_orbit",
        ("floquet", "time_history", "journal_orbit", "phase_portrait"),
        "period {period}, after {transient} dropped turns",
        recorded=".analysis.orbits.periodic_orbit:names",
        tangents=True,
        example={"mechanism": {"clearance": 2.9e-5}},
        references=("parker_chua1989", "deuflhard2011", "kuznetsov2004"),
        trial={"transient": 20},
    ),
    Kind(
        "continuation",
        ".analysis.orbits.continuation:continuation",
        ("continuation", "floquet"),
        "{parameter} from {range[0]} to {range[1]}, period {period}",
        tangents=True,
        kept=True,
        example={"mechanism": {"clearance": 2.9e-5}, "analysis": {"range": (2.9e-5, 3.5e-5), "step": 0.05}},
        references=("allgower_georg2003", "keller1977", "parker_chua1989", "deuflhard2011", "kuznetsov2004"),
        trial={"parameter": "restitution", "range": [0.7, 0.85], "max_points": 5},
    ),
    Kind(
        "curve",
        ".analysis.curves.curve:curve",
        ("curve",),
        "{plane:#} parameters, period {period}",
        tangents=True,
        kept=True,
        example={
            "mechanism": {"clearance": 4.19e-5},
            "analysis": {
                "plane": {"clearance": (4.1e-5, 4.3e-5), "gear_ratio": (2.98, 3.02)},
                "max_points": 20,
                "max_curves": 1,
            },
        },
        references=("allgower_georg2003", "keller1977", "govaerts2000", "kuznetsov2004"),
        trial={"plane": {"restitution": [0.7, 0.85], "gap": [2.8, 3.4]}, "transient": 20, "max_points": 5},
    ),
    Kind(
        "gradient",
        ".analysis.gradients.gradient:gradient",
        ("gradient",),
        "{turns} turns",
        example={
            "mechanism": {"clearance": 2.9e-5},
            "analysis": {
                "of": ("largest:normal_force:B", "time"),
                "by": ("clearance", "gear_ratio"),
                "orbit": True,
            },
        },
        references=("hiskens_pai2000", "squire_trapp1998"),
        trial={"turns": 1},
    ),
    Kind(
        "optimise",
        ".analysis.gradients.optimise:optimise",
        ("optimise",),
        "{turns} turns at each design",
        example={"analysis": {"least": "largest:normal_force:B", "by": {"gear_ratio": (2.9, 3.2)}}},
        references=("hiskens_pai2000", "kraft1988"),
        trial={
            "least": "end:state:v",
            "orbit": False,
            "by": {"restitution": [0.7, 0.9]},
            "max_iterations": 3,
        },
    ),
    Kind(
        "tolerances",
        ".analysis.tolerances.tolerances:tolerances",
        ("tolerances",),
        "{samples} samples, {turns} turns after {transient} dropped turns",
        varies=False,
        tangents=True,
        slow=1,
        example={
            "mechanism": {"clearance": 2.9e-5},
            "tolerances": {"clearance": {"normal": (2.9e-5, 2e-6)}},
            "analysis": {"limits": {"force:B": 200.0}, "samples": 64, "shares": 16},
        },
        trial={
            "spreads": {"restitution": {"uniform": [0.7, 0.8]}},
            "samples": 32,
            "shares": 0,
            "transient": 5,
        },
        references=("owen1997", "saltelli2010", "jansen1999", "wilson1927"),
    ),
    Kind(
        "assess",
        ".analysis.assessment.assess:assess",
        ("assess",),
        LENGTH + "; each parameter to {reach} times its value",
        varies=False,
        tangents=True,
        references=("archard1953", "allgower_georg2003", "keller1977", "parker_chua1989", "kuznetsov2004"),
    ),
)


KINDS = Table("jointplay.kinds", Kind, {row.name: row for row in _ROWS})
