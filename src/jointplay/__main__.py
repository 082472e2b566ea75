"""``python -m jointplay``: the command line."""

import sys

from jointplay.cli import main

if __name__ == "__main__":
    sys.exit(main())
