"""Print the lower bounds of the package's dependencies as constraints of pip.

python -m tests.lowest > lowest.txt && pip install -c lowest.txt -e .
"""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def constraints(project):
    """Each dependency at the version that its lower bound names."""
    for each in project["dependencies"]:
        name, bound = re.fullmatch(r"([\w-]+)>=([\d.]+)", each).groups()
        yield f"{name}=={bound}"


if __name__ == "__main__":
    print("\n".join(constraints(tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"])))
