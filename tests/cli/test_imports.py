"""What commands import: a warm start is hardly anything else. Counted in modules, for seconds are no measure.

Each row: the most modules that a command may load, and packages of which it may load none.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import netCDF4
import pytest

QUICKSTART = Path(__file__).parents[2] / "studies" / "quickstart.toml"
# xarray and fontTools import these wherever they find them; no dependency of ours, so they are not counted
OPTIONAL = ("dask", "distributed", "lxml", "tornado", "jinja2", "cupy", "sparse")
SCRIPT = f"""
import json, sys
from pathlib import Path
sys.modules |= dict.fromkeys({OPTIONAL!r})
{{}}
Path(sys.argv[1]).write_text(json.dumps([name for name, module in sys.modules.items() if module]))
"""
COMMAND = """
from jointplay.cli import main
try:
    code = main(sys.argv[2:])
except SystemExit as end:
    code = end.code
assert not code
"""
COMPARE = """
from jointplay.study.file import load
from jointplay.study.result_state import refuse_other
refuse_other(load("quickstart.toml").record, Path(sys.argv[2]))
"""
COMPILES = "sympy numba llvmlite"
DRAWS = "matplotlib PIL fontTools"
TABLES = "xarray pandas netCDF4 cftime"
RARE = "scipy joblib pint"
SHORT = ("run", "quickstart.toml", "--set", "analysis.turns=2", "analysis.transient=1", "figure.turns=[1, 2]")
ROWS = {
    ("--help",): (201, f"{COMPILES} {DRAWS} {TABLES} {RARE} numpy pydantic"),
    ("list", "studies"): (215, f"{COMPILES} {DRAWS} {TABLES} {RARE} numpy pydantic"),
    ("check", "quickstart.toml"): (560, f"{COMPILES} {DRAWS} {TABLES} {RARE}"),
    (*SHORT, "--no-figure"): (1700, f"sympy {DRAWS} joblib"),
    SHORT: (2000, "sympy joblib"),
}
PYTHON = {
    "import jointplay": (190, f"{COMPILES} {DRAWS} {TABLES} {RARE} numpy pydantic"),
    "import jointplay; jointplay.catalog.chunmei2002()": (400, f"{COMPILES} {DRAWS} {TABLES} {RARE}"),
    "import jointplay as jp; jp.assess": (560, f"{COMPILES} {DRAWS} {TABLES} {RARE}"),
    "import jointplay as jp; jp.gradient": (560, f"{COMPILES} {DRAWS} {TABLES} {RARE}"),
    "import jointplay as jp; jp.simulate(jp.catalog.chunmei2002(), turns=1)": (
        1550,
        f"sympy {DRAWS} netCDF4 joblib",
    ),
}


@pytest.mark.nightly
@pytest.mark.parametrize("command", ROWS, ids=" ".join)
def test_a_command_loads_what_it_needs(command, tmp_path):
    (tmp_path / "quickstart.toml").write_text(QUICKSTART.read_text())
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "quickstart.toml").write_text(QUICKSTART.read_text())
    hold(COMMAND, tmp_path, command, *ROWS[command])


@pytest.mark.nightly
@pytest.mark.parametrize("code", PYTHON)
def test_a_call_loads_what_it_needs(code, tmp_path):
    hold(code, tmp_path, (), *PYTHON[code])


@pytest.mark.nightly
def test_a_result_that_is_there_is_compared_by_its_attributes(tmp_path):
    """Before a run writes over it; the second look costs no xarray."""
    text = QUICKSTART.read_text()
    (tmp_path / "quickstart.toml").write_text(text)
    with netCDF4.Dataset(tmp_path / "own.nc", "w") as file:
        file.provenance = json.dumps({"study": tomllib.loads(text) | {"name": "quickstart"}})
    heavy = f"{COMPILES} {DRAWS} {RARE} xarray pandas"
    hold(COMPARE, tmp_path, ("own.nc",), 600, heavy)
    with netCDF4.Dataset(tmp_path / "other.nc", "w") as file:
        file.provenance = json.dumps({"study": tomllib.loads(text) | {"name": "other"}})
    with pytest.raises(AssertionError, match="other settings"):
        hold(COMPARE, tmp_path, ("other.nc",), 600, heavy)


def hold(code, folder, words, most, none):
    """Run code in a process of its own, that of a run twice: the first may compile; hold what it loads."""
    paths = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    for _ in range(2 if "run" in words or "simulate" in code else 1):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT.format(code), str(folder / "loaded"), *words],
            cwd=folder,
            env=paths,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    loaded = json.loads((folder / "loaded").read_text())
    heavy = sorted(name for name in none.split() if name in loaded)
    assert (heavy, len(loaded)) == ([], min(len(loaded), most))
