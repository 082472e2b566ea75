"""The laboratory's verb of the command line. Heavy modules are imported inside it."""

import sys
from argparse import Namespace
from pathlib import Path

from jointplay.cli.verb import DONE, FAILED, FRESH, JOBS, folder, option, say, verb


@verb(
    "reproduce",
    option("names", nargs="*", metavar="NAME", help="studies of studies/paper, such as fig05b; all if none"),
    *(JOBS, folder("results/reproduced"), FRESH),
    example="fig12c --jobs 1",
)
def reproduce_paper(arguments: Namespace) -> int:
    """Compute and draw every figure of the paper, or the named ones, and grade its conclusions."""
    from jointplay_lab.reproduce import reproduce

    try:
        outcomes = reproduce(arguments.names, arguments.jobs, arguments.out, fresh=arguments.fresh, say=say)
    except KeyboardInterrupt:
        kept = any(Path(arguments.out).glob("*.journal"))
        again = "run the same command again to go on; finished cells are kept"
        raise KeyboardInterrupt(*[again] * kept) from None
    failed = [outcome for outcome in outcomes if outcome.failure]
    say(f"{len(outcomes) - len(failed)} of {len(outcomes)} studies done; results in {arguments.out}")
    for outcome in failed:
        say(f"failed: {outcome.name}: {outcome.failure}", file=sys.stderr)
    return FAILED if failed else DONE
