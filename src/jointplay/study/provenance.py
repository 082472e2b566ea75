"""Where a result comes from: enough to run it again, and nothing that changes between identical runs.

The wall time is the variable ``wall_time`` of the result and no part of this record; there is no time stamp.
"""

import json
import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path
from typing import Any

import xarray as xr

from jointplay.codegen import cache

SCHEMA_VERSION = 1
PACKAGE = Path(__file__).resolve().parents[1]


def record(resolved: dict[str, Any], text: str) -> dict[str, Any]:
    """Collect the provenance of a run.

    Parameters
    ----------
    resolved : dict
        The study with every default filled in, as plain JSON types.
    text : str
        The study file, verbatim.

    Returns
    -------
    dict
        Plain JSON types: schema_version, software, environment, kernel_digest, study, study_text.
    """
    return {
        "schema_version": SCHEMA_VERSION,
        "software": {"name": "jointplay", "version": version("jointplay"), "git": git_describe()},
        "environment": environment(),
        "kernel_digest": cache.digest(),
        "study": resolved,
        "study_text": text,
    }


def attach(dataset: xr.Dataset, resolved: dict[str, Any], text: str) -> xr.Dataset:
    """Give a copy of the dataset that holds its provenance: one JSON text, the attribute ``provenance``."""
    origin = record(resolved, text)
    software = origin["software"]
    source = f"{software['name']} {software['version']}"
    return dataset.assign_attrs(
        source=source, provenance=json.dumps(origin, sort_keys=True, ensure_ascii=False)
    )


def read(dataset: xr.Dataset) -> dict[str, Any]:
    """The provenance that a dataset holds; empty where there is none that can be read."""
    try:
        origin = json.loads(dataset.attrs["provenance"])
    except (KeyError, TypeError, ValueError):
        return {}
    return origin if isinstance(origin, dict) else {}


def environment() -> dict[str, str]:
    """Versions of what decides the numbers."""
    packages = {name: version(name) for name in ("numpy", "numba", "llvmlite")}
    return {"python": platform.python_version(), **packages, "platform": platform.platform()}


def version(package: str) -> str:
    """Version of an installed package, or ``unknown``."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


def git_describe(package: Path = PACKAGE) -> str | None:
    """``git describe --dirty`` when the package runs from its own checkout, else None. Never fails."""
    try:
        checkout = Path(_git(package, "rev-parse", "--show-toplevel"))
        # an installed copy may lie inside somebody else's checkout: that describes another project
        if checkout.resolve() / "src" / package.name != package:
            return None
        return _git(package, "describe", "--always", "--tags", "--dirty")
    except (OSError, ValueError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    # a hook's GIT_DIR would point elsewhere; asking must not write into the checkout's index
    clean = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    answer = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        capture_output=True,
        text=True,
        timeout=10,
        check=True,
        env=clean | {"GIT_OPTIONAL_LOCKS": "0"},
    )
    return answer.stdout.strip()
