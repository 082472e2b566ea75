"""Kinds of study of the laboratory, published as an entry point of the group `jointplay.kinds`."""

from jointplay.kinds import Kind

KINDS = (
    Kind(
        "readings",
        "jointplay_lab.paper.readings:readings",
        ("readings",),
        varies=False,
        slow=2,
        example={
            "analysis": {"panels": ("c",), "readings": ("as_printed", "no_tension")}
            | {"transient": 50, "turns": 100}
        },
        references=("chunmei2002",),
    ),
    Kind(
        "claims",
        "jointplay_lab.paper.claims:claims",
        ("claims",),
        varies=False,
        slow=1,
        example={"analysis": {"damping_ratios": (0.01,), "transient": 50, "turns": 50, "growth_turns": 20}},
        references=("chunmei2002", "benettin1980"),
    ),
    Kind(
        "scheme_comparison",
        "jointplay_lab.scheme.scheme_comparison:scheme_comparison",
        ("scheme_comparison",),
        "single turns after {start_turn} turns, clearances {clearance} m",
        varies=False,
        example={
            "mechanism": {"elastic": ["coupler"], "elements": 2},
            "analysis": {"clearance": (0.0,), "start_turn": (0,), "windows_per_turn": (12,)},
        },
        references=("chunmei2002", "nigam_jennings1969"),
    ),
    Kind(
        "stress",
        "jointplay_lab.stress.stress:stress",
        ("stress",),
        "{scenes} scenes of seed {seed} from number {first}, {turns} turns each",
        varies=False,
        example={"analysis": {"scenes": 10, "variants": ("rigid",)}},
        references=(),
    ),
    Kind(
        "work_precision",
        "jointplay_lab.precision.work_precision:work_precision",
        ("work_precision",),
        "{turns} turns at {tolerances:#} tolerances, beside {peers}",
        varies=False,
        example={"analysis": {"tolerances": (1e-5, 1e-7, 1e-9), "peers": ("LSODA", "Radau"), "rounds": 2}},
        references=("hindmarsh2005", "petzold1983", "biscani_izzo2021", "biscani_izzo2022"),
    ),
    Kind(
        "benchmark",
        "jointplay_lab.benchmarks.benchmark:benchmark",
        ("benchmark",),
        "to where the published answer stands",
        varies=False,
        example={"mechanism": {"catalog": "ivp_crank"}},
        references=(),
    ),
)
