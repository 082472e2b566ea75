"""Drawn cases by two doors, each by its number alone: `python -m tests.fuzz DOOR [COUNT] [SEED] …`.

`files` (10 000 take some minutes; kinds of study may follow), `calls` (3 000: minutes; the first may follow).
"""

import sys

from . import calls, files


def main(door="", *words):
    """Try what the command line says."""
    if door == "files":
        return files.main(*map(int, words[:2]), *words[2:])
    if door == "calls":
        return calls.main(*map(int, words))
    raise SystemExit(__doc__)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
