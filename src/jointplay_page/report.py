"""A result as one HTML page: answer in words, live charts, the mechanism in motion, where it comes from."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from matplotlib.collections import QuadMesh
from xarray import Dataset

from jointplay import figures
from jointplay.display.errors import InputError, of_a_result, refuse
from jointplay.figures.registry import suited_to
from jointplay.jobs.files import replaced
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.mechanism.signature import checked
from jointplay.study.file import figure_options
from jointplay.study.mechanism_table import build_mechanism
from jointplay.study.results import provenance
from jointplay.study.results.store import check_writable, write_figure
from jointplay.study.results.summary import summary
from jointplay_page import live, moving, sweep_points, thin

MOST = 5  # figures of a page
NEEDS = "a page of a result needs the package bokeh: pip install 'jointplay[report]'"


@dataclass(frozen=True)
class Content:
    """What a page shows.

    Parameters
    ----------
    dataset : Dataset
        The result.
    origin : dict
        Its provenance; empty where it has none.
    figures : dict of str to Figure
        Pictures by their kinds, the study's own first.
    cells, motion, live : dict or None
        Of a sweep; of a response; what the page needs to compute by itself.
    note : str
        Why there is no motion, or not the usual picture, or nothing that computes.
    """

    dataset: Dataset
    origin: dict[str, Any]
    figures: dict[str, Any]
    cells: dict[str, Any] | None
    motion: dict[str, Any] | None
    live: dict[str, Any] | None
    note: str


@checked()
def report(
    dataset: Annotated[Dataset | Mechanism | TestSystem, accepts("a result or a mechanism")],
    path: Annotated[Path | str, accepts("the name of a file that ends in .html")],
    *,
    mechanism: Annotated[Mechanism | None, accepts("a mechanism")] = None,
) -> list[Path]:
    """Write a result as one HTML page that needs no network, and its picture as a PNG file beside it.

    Parameters
    ----------
    dataset : Dataset, Mechanism or TestSystem
        What an analysis gave, or `jointplay.open`; of any kind. Or what moves, for a page that computes its
        motion.
    path : path-like
        The page's name, ending in ``.html``.
    mechanism : Mechanism, optional
        What moves, where the result does not hold its study; a response that recorded ``angle`` is shown in
        motion.

    Returns
    -------
    list of pathlib.Path
        The page, and its picture where the kind of result has one.

    Raises
    ------
    InputError
        When the dataset is no result, or the extra ``report`` (bokeh), which results need, is not installed.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.simulate(jp.catalog.chunmei2002(clearance=2.9e-4), turns=5)  # doctest: +SKIP
    >>> jp.report(motion, "motion.html")  # doctest: +SKIP
    [PosixPath('motion.html'), PosixPath('motion_report.png')]
    """
    path = Path(path)
    if path.suffix != ".html":
        raise refuse(str(path), "a name that ends in .html is accepted", "--out")
    if isinstance(dataset, Mechanism | TestSystem):
        check_writable(path.parent, files=[path.name])
        return [written(path, live.page(dataset))]
    if find_spec("bokeh") is None:
        raise refuse(str(path), NEEDS, "report")
    with of_a_result(dataset):
        return _report(dataset, path, mechanism)


def _report(dataset: Dataset, path: Path, mechanism: Mechanism | None) -> list[Path]:
    """Write the page of a result, and its picture."""
    answer, content = summary(dataset), content_of(dataset, mechanism)
    picture = path.with_name(f"{path.stem}_report.png")  # NAME.png is the figure of the run
    check_writable(path.parent, files=[path.name, picture.name])
    from jointplay_page import page  # bokeh takes a second to import

    first = list(content.figures.values())[:1]
    still = [write_figure(each, picture) for each in first]
    return [written(path, page.html(content, answer, *still)), *still]


def written(path: Path, text: str) -> Path:
    """Write a page whole, or not at all."""
    with replaced(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def content_of(dataset: Dataset, mechanism: Mechanism | None) -> Content:
    """Gather what the page of a result shows."""
    origin = provenance.read(dataset)
    study = origin.get("study") if isinstance(origin.get("study"), dict) else {}
    with suppress(InputError):  # another version's record: a page without motion, which it says
        mechanism = mechanism or build_mechanism(study.get("mechanism"))
    motion, note = moving.moving(dataset, mechanism if isinstance(mechanism, Mechanism) else None)
    swept = amid(mechanism, dataset, list(study.get("vary") or {})) if mechanism else None
    computing, why = live.live(swept, sweep_points.parameters(dataset)) if swept else (None, "")
    drawn, trouble = pictures(dataset)
    found = sweep_points.cells(dataset, study, thin.room(drawn.values()))
    notes = " ".join(filter(None, (note, trouble, why)))
    return Content(dataset, origin, drawn, found, motion, computing, notes)


def amid(mechanism: Mechanism | TestSystem, dataset: Dataset, keys: list[str]) -> Mechanism | TestSystem:
    """Return what moves in the middle of a sweep, from where sliders reach most of its points."""
    middle = {}
    for name in sweep_points.parameters(dataset):
        if dataset[name].dtype.kind not in "fiu":
            continue
        ends = dataset[name].values[[0, -1]]
        mean = np.sqrt(ends.prod()) * np.sign(ends[0]) if ends.prod() > 0 else ends.mean()
        middle |= {key: float(mean) for key in keys if key.rpartition(".")[2] == name}
    try:
        return mechanism.varied(middle)
    except InputError:  # a start or an order of them, which has no middle
        return mechanism


def pictures(dataset: Dataset) -> tuple[dict[str, Any], str]:
    """Return the figures that can be drawn of a result, and why that which its study asks for cannot."""
    options = figure_options(dataset)
    if "swept" in dataset.attrs:
        whole = figures.of_sweep(dataset, options)
        return ({"sweep": figures.draw(dataset, whole)} if whole else {}), ""
    kinds, found, trouble = suited_to(dataset.attrs.get("kind")), {}, ""
    try:
        first = options.get("kind") or figures.usual_kind(dataset)
        found[first] = figures.draw(dataset, options)
    except InputError as error:
        trouble = f"The usual picture cannot be drawn: {error}." if kinds else ""
    for kind in kinds[:MOST]:
        with suppress(InputError):  # this result lacks what that figure needs
            found |= {} if kind in found else {kind: figures.draw(dataset, {"kind": kind})}
    maps = {kind: each for kind, each in found.items() if any(map(is_map, each.axes))}
    one_row = maps and len(sweep_points.parameters(dataset)) > 1  # says less than the map
    return (maps if one_row else found), trouble


def is_map(ax: Any) -> bool:
    """Return whether a panel shows colours over two parameters."""
    return any(isinstance(each, QuadMesh) for each in ax.collections)
