"""The verb `animate`: a stored motion as a film or a sheet of frames."""

from argparse import Namespace
from pathlib import Path

from jointplay.cli.verbs import DONE, say
from jointplay.errors import InputError, Problem
from jointplay.terminal import Progress

OPTIONS = ("joint", "turns", "time", "seconds", "rate", "frames")


def animate_result(arguments: Namespace) -> int:
    """Show the mechanism of a stored motion as it moves: a film, or a sheet of frames."""
    from jointplay.errors import unknown
    from jointplay.results.animate import animate
    from jointplay.results.store import open_result
    from jointplay.study import toml_text

    options = toml_text.override({}, arguments.set)
    if strange := [key for key in options if key not in OPTIONS]:
        raise InputError([unknown(f"--set {key}", options[key], key, OPTIONS, "option") for key in strange])
    target = Path(arguments.out) if arguments.out else Path(arguments.result).with_suffix(".mp4")
    if not target.suffix:
        raise InputError([Problem("--out", str(target), "a name that ends in .mp4, .gif, .pdf or .png")])
    with Progress(target.name) as progress:
        path = animate(open_result(arguments.result), target, **options, progress=progress)
    say(f"written {path}")
    return DONE
