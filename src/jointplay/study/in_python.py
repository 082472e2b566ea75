"""A study file run from Python: the answer as a dataset, nothing kept on the disk."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from jointplay.analysis.keywords import Progress as Keyword
from jointplay.analysis.labels import xr
from jointplay.display.errors import refuse
from jointplay.display.terminal import requested_progress
from jointplay.solver.mechanism.base import Natural, accepts
from jointplay.solver.mechanism.paths import ends
from jointplay.solver.mechanism.signature import checked
from jointplay.study import run as runner
from jointplay.study.file import load


@checked()
def run(
    study: Annotated[Path | str, accepts("the name of a study file")],
    *,
    progress: Keyword = None,
    jobs: Natural | None = None,
    **changes: Any,
) -> xr.Dataset:
    """Run a study file, as `jointplay run` does, and give the result.

    Parameters
    ----------
    study : path-like
        A study file (TOML), or a result (``.nc``), whose study is run again.
    progress : bool or callable
        True shows how far the run is, False does not; a function is called with the fraction done. Left out:
        a bar on a terminal or in a notebook, of a run that lasts over 3 s.
    jobs : int, optional
        Worker processes, for studies that have cells.
    **changes
        Values laid over the file, by table or by path: ``mechanism={"clearance": 1e-4}``, or
        ``**{"mechanism.clearance": 1e-4}``.

    Returns
    -------
    xarray.Dataset
        With its provenance. Numerical trouble is in its ``status``; `jointplay.summary` says the answer.

    Raises
    ------
    InputError
        With everything that is wrong in the file or the changes.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.run("studies/quickstart.toml", analysis={"turns": 3})  # doctest: +SKIP
    """
    loaded = load(study, [f"{path}={_text(path, value)}" for path, value in ends(changes)])
    with requested_progress(progress, loaded.record.name) as tell:
        return runner.run(loaded, tell, jobs)


def _text(path: str, value: Any) -> str:
    """A value as TOML writes it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return f"[{', '.join(_text(path, each) for each in value)}]"
    try:
        return str(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
    except TypeError:
        raise refuse(value, "a number, a text, true, false, or a list of them is accepted", path) from None
