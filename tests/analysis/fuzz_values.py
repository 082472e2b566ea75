"""Values of drawn calls: right ones by keyword, strange ones, and the calls that they are put into."""

import math
from datetime import date
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

import jointplay as jp
from jointplay.equations.friction import FRICTIONS
from jointplay.equations.laws import LAWS
from jointplay.mechanism import catalog

LOOSE = catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
IDEAL = catalog.chunmei2002(clearance=0)
BENT = LOOSE.replace(elastic=("coupler",))
GUIDED = catalog.slider_crank(clearance={"B": 1e-4, "G": 1e-4})
RIGID = catalog.flores2010()
FOLDER = TemporaryDirectory()  # for what calls write
STORED = Path(__file__).parents[2] / "results" / "paper"
RESULTS = tuple(jp.open(STORED / f"{name}.nc") for name in ("fig10", "fig12a", "readings", "claims"))
PAIR, DUFFING, LORENZ = catalog.impact_pair(3.0, 0.8), catalog.duffing(), catalog.lorenz()
MOVING = (LOOSE, LOOSE, IDEAL, PAIR, DUFFING, LORENZ)
SECTIONS = (
    *(jp.CrankAngle(), jp.CrankAngle(angle=1.0), jp.ContactSection(), jp.ContactSection(joint="B")),
    *(jp.SeparationSection(joint="X"), jp.Plane(quantity="normal_force", value=1.0, joint="B")),
    *(jp.Plane(quantity="y", value=0.0), jp.Plane(quantity="angle", link="crank", value=1e12)),
    *({"kind": "contact"}, {"kind": "plane"}, {}),
)
STARTS = (
    *(
        {"crank_angle": 1.0},
        {"crank_angle": 1e12},
        {"crank_speed": -5.0},
        {"crank_angle": "a"},
        {"branch": 3},
    ),
    *({"angle": {"crank": 0.0}}, {"angle": 3}, {"angle": None}, {"angle": {}, "angular_velocity": {}}),
    *({"angle": dict.fromkeys(("crank", "coupler", "rocker"), 0.3), "angular_velocity": {}}, [0.1, 0.2]),
    {key: dict.fromkeys(("crank", "coupler", "rocker"), 0.3) for key in ("angle", "angular_velocity")},
    {key: dict.fromkeys(("crank", "coupler", "rocker"), 1e12) for key in ("angle", "angular_velocity")},
    *([0.0, 0.1, 0.2], np.array([0.1, 0.1]), [1e300, 1.0], ["a", "b"], [[0.1], [0.2]], [10**400, 0]),
)
SPRING = {
    "name": "s",
    "from": {"link": "crank"},
    "to": {"link": "rocker"},
    "stiffness": 1.0,
    "free_length": 0.1,
}
STRANGE = (
    *(None, True, False, 0, -1, 1, 2, 3, 7, 1.5, -0.0, math.nan, math.inf, -math.inf, 1e-300, 1e300, 1e12),
    *(10**9, 10**400, -(10**400), 10**5000, "", "a", "contact", "ground", "B", "all", b"x", [], (), {}, [1]),
    *([1.0, 2.0], [math.nan], ["angle"], "angle", [[1, 2], [3, 4]], {"a": 1}, {1: 2}, {None: None}, object()),
    *({"start": 0, "stop": 1, "num": 3}, print, np.int64(3), np.float32(0.5), np.float64("nan"), [None]),
    *(np.bool_(True), np.array(3), np.array([1.0, 2.0]), np.array([]), np.array(["angle"]), np.eye(2)),
    *(1j, Decimal(1), Fraction(1, 2), date(2000, 1, 1), {1, 2}, frozenset(), iter(()), xr.Dataset(), int),
    *(
        jp.CrankAngle(),
        jp.Pin(link="a"),
        LOOSE,
        DUFFING,
        BENT,
        np.datetime64("2000-01-01"),
        range(3),
        "\ud800",
    ),
    *(
        np.timedelta64(1),
        np.longdouble(1),
        np.array([None]),
        [object()],
        {"B": 1e-4},
        {"B": np.float32(1e-4)},
    ),
)
RIGHT = {  # what some keywords may be, beside the strange
    "mechanism": (*MOVING, BENT, GUIDED, RIGID),
    "section": SECTIONS,
    "initial": STARTS,
    "starts": ([{"crank_angle": 1.0}], [[0.1, 0.2], [0.2, 0.1]], *STARTS),
    "turns": (0.2, 1, np.int64(2), 2.5),
    "duration": (1e-3, 1e20, 1e8),
    "transient": (1, np.float64(0.5)),
    "record": (
        ["angle"],
        ["mode", "energy"],
        ("state_value",),
        ["reaction", "energy_residual"],
        ["deflection"],
    ),
    "windows": ([[0, 0.1], [0.2, 0.3]], [[0, 1e9]], ((0.3, 0.1),), [[0, 0.1, 0.2]], [["a", 1]]),
    "at": ([0.0, 0.01], np.array([0.01]), [1.0, 0.0], xr.DataArray([0.0, 0.01])),
    "over": (
        {"clearance": [1e-4]},
        {"gap": [3.0]},
        {"gap": np.array([3.0])},
        {"clearance": 3},
        {"gap": [1, 1]},
    ),
    "plane": (
        *({"y": [0.0, 0.1], "v": [0.0, 0.1]}, {"y": {"start": 0, "stop": 1, "num": 2}, "v": [0, 1]}),
        *({"crank_angle": [0.0, 1.0], "journal_x": [0.0, 0.5]}, {"y": {"start": 0, "stop": 1, "num": 10**9}}),
        *({"y": [0, 1], "v": {"start": 0, "stop": 1, "num": 10**9}}, {1: [0, 1], 2: [0, 1]}),
    ),
    "direction": ("up", ["down", "up"], "reset", [[]], [1]),
    "quantity": ("journal_x", "angle:rocker", "y", "normal_force:B", "angle:", ":", "state_value"),
    "quantities": (["journal_x"], ["y"], ["y", "y"], ["angle:rocker", "angle:rocker"]),
    "parameter": ("gap", "clearance", "joints.B.clearance", "joints.B", "a.b", ".", "links.crank.name"),
    "range": ([2.9, 3.1], (2.9e-4, 3e-4), [1, 0], np.array([2.9, 3.1])),
    "compare": ("time", "section"),
    "joint": ("B", "A"),
    "distance": (1e-9, 1e-13, 1e-3),
    "rtol": (1e-6, 1e-14, 1e-4, np.float32(1e-6)),
    "window": ("hann", "kaiser", ("kaiser", 3.0), 3),
    "shares": ([0.1, 0.5], (0.5, 0.1), [0.1, "a"]),
    "exponents": (2, "all", 7, np.int8(1)),
    "panels": (["a"], ["z"], "abc"),
    "readings": (["as printed"], [3]),
    "variants": (["plain"], ["rigid"], [1]),
    "peers": ([], ["LSODA"], "LSODA"),
    "tolerances": ([1e-4], 1e-4, [1e-6, 1e-4]),
    "damping_ratios": ([0.01], [2.0], 0.01),
    "clearance": (1e-4, {"B": 1e-5}, {"Z": 1e-5}, [0.0]),
    "elastic": (["coupler"], ("crank", "x"), "coupler"),
    "link": ("crank", "ground"),
    "links": (LOOSE.links, LOOSE.links[:1], [LOOSE.links[0].model_dump()]),
    "joints": (LOOSE.joints, LOOSE.joints[::-1], LOOSE.joints[:2]),
    "drive": (LOOSE.drive, jp.ConstantSpeed(link="crank", speed=3.0), {"kind": "none"}),
    "journal": (LOOSE.joints[0].journal, {"link": "crank"}),
    "bearing": (LOOSE.joints[0].bearing, {"link": "ground", "point": [0, 0]}),
    "contact": (
        *(LOOSE.joints[0].contact, {"stiffness": 1.0, "damping": 0.0}),
        *({"law": law, "stiffness": 1e9, "parameters": {"restitution": 0.5}} for law in LAWS),
        {"law": "restitution", "parameters": {"restitution": 0.5, "tangential_restitution": 3}},
    ),
    "friction": (
        *(LOOSE.joints[0].friction, 0.1, {"coefficient": 0.1}),
        *({"law": law, "coefficient": 0.1, "velocity": 0.01} for law in FRICTIONS),
    ),
    "law": (*LAWS, *FRICTIONS),
    "beam": (LOOSE.links[0].beam, {"elements": 2}, {"axial": True}, {"shapes": "sine", "axial": True}),
    "axial": (True,),
    "half_length": (0.02,),
    "half_height": (0.01,),
    "springs": ([SPRING], [SPRING] * 2, {"s": SPRING}),
    "masses": ([{"at": 0.1, "mass": 1.0}], {"at": 0.1}),
    "guess": ({"crank": 0.0, "coupler": 1.0, "rocker": 2.0}, {"crank": 1e12}),
    "table": ([1.0, 2.0, 3.0, 2.0], [1.0] * 64, [0.0, 0.0], [1e300, -1e300, 1.0]),
    "dataset": (*RESULTS, xr.Dataset({"a": ("time", [1.0])}), xr.Dataset(attrs={"kind": "response"})),
    "motion": RESULTS,
    "along": (["clearance"], ["gear_ratio"], ["joints.B.clearance", "speed"], "clearance"),
    "reach": (1.01, 1.5),
    "point": ((0.0, 1.0), np.array([0.0, 1.0])),
    "parameters": ({"gap": 3.0, "restitution": 0.8}, {"gap": "a"}),
    "system": ("duffing", "none"),
    "kind": ("journal_orbit", "overview", "time_history", "sweep", "bifurcation", "prismatic", "profile"),
    "path": (
        *("none.nc", "/", "."),
        *(f"{FOLDER.name}/a{end}" for end in (".mat", ".csv", ".html", ".png", ".gif", "")),
        "/none/a.csv",
    ),
}
BRIEF = {"max_steps": 300, "n_jobs": 1}  # so that a call costs little, unless another value is wrong
LOOPS = {  # what would only take long if it were large
    *(
        "twin_turns",
        "passes",
        "windows_per_turn",
        "scenes",
        "rounds",
        "budget",
        "listed",
        "pairs",
        "patience",
    ),
    *("max_points", "max_branches", "max_iterations", "neighbours", "references", "repeats", "growth_turns"),
    *("settling", "phases", "directions", "edge_turns", "max_curves", "largest"),
    *("start_turn", "frequencies", "lyapunov_turns", "steps", "step", "seconds", "rate", "frames", "reach"),
}
MOTION = {"mechanism": LOOSE, "turns": 0.3}
REGION = {"y": [-1.0, 1.0], "v": [0.0, 1.0]}
MANY = {"mechanism": PAIR, "region": REGION, "starts": 2, "turns": 16, "transient": 5, "patience": 0}
CALLS = {  # a call that is right
    "simulate": MOTION,
    "poincare": MOTION,
    "bifurcation": {
        "mechanism": PAIR,
        "over": {"gap": [3.0]},
        "turns": 3,
        "transient": 2,
        "lyapunov_turns": 2,
    },
    "lyapunov": MOTION,
    "sensitivity": {"mechanism": DUFFING, "turns": 6, "neighbours": 2},
    "basins": {"mechanism": DUFFING, "plane": RIGHT["plane"][0], "turns": 4, "transient": 2, "patience": 0},
    "chaos_test": {"mechanism": PAIR, "turns": 5, "frequencies": 3},
    "spectrum": {"mechanism": PAIR, "turns": 2, "segments": 2},
    "dimension": {"mechanism": PAIR, "turns": 10},
    "optimise": {"mechanism": PAIR, "by": {"restitution": (0.5, 0.95)}, "least": "time", "orbit": False},
    "periodic_orbit": {"mechanism": PAIR, "transient": 5, "max_iterations": 3},
    "continuation": {
        "mechanism": PAIR,
        "parameter": "gap",
        "range": [2.9, 3.1],
        "transient": 5,
        "max_points": 2,
    },
    "curve": {
        "mechanism": PAIR,
        "plane": {"gap": [2.9, 3.1], "restitution": [0.75, 0.85]},
        "transient": 5,
        "max_points": 2,
        "max_curves": 1,
    },
    "gradient": {"mechanism": PAIR},
    "covariant": {"mechanism": PAIR, "turns": 5, "settling": 2, "transient": 2},
    "attractors": MANY | {"over": {"gap": [3.0]}, "lyapunov_turns": 2, "carry": False},
    "tipping": MANY | {"steps": 2, "phases": 1, "directions": 2, "edge_turns": 2},
    "growth": {"mechanism": DUFFING, "turns": 3, "transient": 2},
    "readings": {"panels": ["a"], "readings": ["none"], "turns": 3, "transient": 2, "growth_turns": 2},
    "claims": {"mechanism": DUFFING, "turns": 3, "transient": 2, "growth_turns": 2},
    "waveform": {"mechanism": IDEAL.replace(elastic=("coupler",)), "passes": 1, "step": 4e-5},
    "scheme_comparison": {"mechanism": LOOSE, "passes": 1, "repeats": 1},
    "assess": {"mechanism": LOOSE, "turns": 2, "transient": 2, "lyapunov_turns": 2, "reach": 1.01},
    "stress": {"scenes": 1, "variants": ["none"], "turns": 1},
    "work_precision": {"mechanism": PAIR, "tolerances": [1e-4], "peers": [], "rounds": 0, "budget": 0.01},
    "benchmark": {"mechanism": PAIR},
    "open": {"path": "none.nc"},
    "cell": {"dataset": xr.Dataset()},
    "figure": {"dataset": xr.Dataset()},
    "animate": {"motion": xr.Dataset(), "path": f"{FOLDER.name}/film.png"},
    "export": {"dataset": RESULTS[0], "path": f"{FOLDER.name}/result.csv"},
    "report": {"dataset": RESULTS[1], "path": f"{FOLDER.name}/result.html"},
    "catalog.lorenz": {},
    "catalog.impact_pair": {"gap": 3.0, "restitution": 0.8},
    "catalog.soft_impact_pair": {"gap": 3.0, "stiffness": 10.0, "damping": 0.1},
    "catalog.gear_backlash": {"mean_load": 0.1, "amplitude": 0.2, "frequency": 1.0, "damping": 0.1},
    "catalog.bouncing_ball": {"acceleration": 1.1, "restitution": 0.5},
    "catalog.duffing": {},
    "catalog.rossler": {},
    "catalog.jerk": {},
    "catalog.relief_valve": {},
    "catalog.chunmei2002": {},
    "Mechanism.replace": {},
    "TestSystem.replace": {},
    "Mechanism": {"links": LOOSE.links, "joints": LOOSE.joints, "drive": LOOSE.drive},
    "Link": {"name": "a", "length": 0.1, "mass": 0.1, "inertia": 1e-3},
    "Beam": {},
    "Joint": dict(LOOSE.joints[2]),
    "Pin": {"link": "a"},
    "Contact": {"stiffness": 1e6, "damping": 1.0},
    "Friction": {"coefficient": 0.1},
    "MotorLine": dict(LOOSE.drive),
    "ConstantSpeed": {"link": "crank", "speed": 3.0},
    "TestSystem": dict(PAIR),
    "System": dict(jp.catalog.jerk()),
    "Touch": {"name": "stop", "depth": "x", "force": "depth"},
    "Rubbing": {"name": "floor", "speed": "v", "normal": 1, "coefficient": "0.3"},
    "Switch": {"name": "on", "on": "x", "off": "-x"},
    "Impact": {"name": "wall", "gap": "x", "restitution": 0.8},
    "Jump": {"name": "clock", "guard": "1 - x", "jump": {"x": 0}},
    "CrankAngle": {},
    "ContactSection": {},
    "SeparationSection": {},
    "Plane": {"quantity": "angle", "value": 1.0},
    "catalog.slider_crank": {},
    "catalog.watt": {},
    "catalog.stephenson": {},
    "catalog.quick_return": {},
    "catalog.ivp_crank": {},
    "catalog.flores2010": {},
    "catalog.siconos_four_bar": {},
    "Spring": {"name": "s", "from": {"link": "a"}, "to": {"link": "b"}, "stiffness": 1.0, "free_length": 0.1},
    "TorsionSpring": {"name": "s", "from": "a", "to": "b", "stiffness": 1.0},
    "Force": {"name": "f", "on": {"link": "a"}, "direction": 0.0, "constant": 1.0},
    "Torque": {"name": "t", "link": "a", "constant": 1.0},
    "Harmonic": {"order": 1, "cosine": 1.0},
    "PointMass": {"at": 0.1, "mass": 1.0},
    "PrescribedTorque": {"link": "crank", "nominal_speed": 3.0, "constant": 1.0},
    "SpeedCycle": {"link": "crank", "table": [1.0, 2.0, 3.0, 2.0], "frequency": 2.0},
    "SpeedProfile": {"link": "crank", "start": 1.0, "end": 3.0, "time": 0.1},
    "contact_stiffness": {"radius": 0.01, "clearance": 1e-4},
    "run": {"study": "none.toml"},
    "summary": {"dataset": xr.Dataset()},
    "words": {"dataset": xr.Dataset()},
}
WEIGHTS = [1 + 3 * name.islower() for name in CALLS]  # analyses more often than records
FIGURES = (
    "kind",
    "joint",
    "link",
    "time",
    "turns",
    "variables",
    "x",
    "y",
    "column",
    "at",
    "exponents",
    "events",
)
