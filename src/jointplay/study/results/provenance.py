"""Provenance of a result: enough to run it again, and nothing that changes between identical runs.

The wall time is the variable ``wall_time`` of the result and no part of this record; there is no time stamp.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from jointplay.analysis.labels import xr
from jointplay.display.errors import sealed
from jointplay.jobs.origin import environment, git_describe, processor, version
from jointplay.solver.codegen import cache

SCHEMA_VERSION = 1


def attach(
    dataset: xr.Dataset, resolved: dict[str, Any], text: str, processors: Iterable[str] = ()
) -> xr.Dataset:
    """Give a sealed copy of the dataset that holds its provenance: one JSON text, ``provenance``.

    For people ``source``, ``history`` (which command made it, as the CF conventions ask) and ``study_toml``.

    Parameters
    ----------
    dataset : Dataset
        What the run gave.
    resolved : dict
        The study with every default filled in, as plain JSON types.
    text : str
        The study file, verbatim.
    processors : iterable of str, optional
        The kinds of processors that computed it; this process's own if there are none.
    """
    origin = {
        "schema_version": SCHEMA_VERSION,
        "software": {"name": "jointplay", "version": version("jointplay"), "git": git_describe()},
        "environment": environment() | {"processor": ", ".join(sorted(processors)) or processor()},
        "kernel_digest": cache.digest(),
        "study": resolved,
        "study_text": text,
    }
    source = "{name} {version}".format(**origin["software"])
    said = {
        "source": source,
        "history": f"{source}: jointplay run {resolved.get('name', 'STUDY')}.toml",
        "study_toml": text,
        "provenance": json.dumps(origin, ensure_ascii=False),  # in order: that of states has a meaning
    }
    return sealed(dataset.assign_attrs(said))


def read(dataset: xr.Dataset) -> dict[str, Any]:
    """The provenance that a dataset holds; empty where there is none that can be read."""
    return held(dataset.attrs)


def held(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """The provenance among the attributes of a dataset; empty where there is none that can be read."""
    try:
        origin = json.loads(attributes["provenance"])
    except (KeyError, TypeError, ValueError, RecursionError):
        return {}
    return origin if isinstance(origin, dict) else {}
