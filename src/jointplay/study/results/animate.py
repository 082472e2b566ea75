"""A motion as a film (MP4, GIF) or as a sheet of frames (PDF, PNG, …)."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from jointplay.display.errors import NOTHING, InputError, Problem, of_a_result, refuse
from jointplay.jobs.files import replaced
from jointplay.solver.mechanism.base import Positive, accepts
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.signature import checked
from jointplay.solver.motion.progress import Reporter
from jointplay.study.results import provenance
from jointplay.study.results.places import places
from jointplay.study.results.store import check_writable, write_figure

FILMS = (".mp4", ".gif")
MOST = 20_000  # frames of a film
INSTALL = "pip install 'jointplay[animation]', or a name that ends in .gif or .pdf"

Count = Annotated[int, Field(strict=True, ge=1, le=48)]
Rate = Annotated[int, Field(strict=True, ge=1, le=60)]
Result = Annotated[xr.Dataset, accepts("a response, as jp.simulate or jp.open gives it,")]
Progress = Annotated[Callable[[float], None] | None, accepts("a function of the fraction done")]


@checked()
def animate(
    motion: Result,
    path: Annotated[Path | str, accepts("the name of a file")],
    *,
    joint: str | None = None,
    turns: Any = None,
    time: Any = None,
    seconds: Positive = 6.0,
    rate: Rate = 25,
    frames: Count = 8,
    mechanism: Annotated[Mechanism | None, accepts("a Mechanism")] = None,
    progress: Progress = None,
) -> Path:
    """Show a mechanism in motion, its joints with clearance enlarged, their forces, and paths of the joints.

    Parameters
    ----------
    motion : Dataset
        A response that records angles, journals and, where there are any, slides, as by default.
    path : path-like
        The file: ``.mp4`` (needs the extra ``animation``) or ``.gif`` is a film; ``.pdf``, ``.png`` and the
        other formats of figures are a sheet of frames.
    joint : str, optional
        The one joint with clearance that is enlarged; by default all of them, up to six.
    turns : float or pair, optional
        The last so many turns, or [first, last]; by default everything.
    time : pair, optional
        A window in s, instead of `turns`.
    seconds : float
        Of a film: how long a turn lasts on the screen, s.
    rate : int
        Of a film: frames a second.
    frames : int
        Of a sheet: how many frames.
    mechanism : Mechanism, optional
        What moved; by default what the result says.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        If there is nothing to show, no such format, or the encoder of films is not installed.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.simulate(jp.catalog.slider_crank(clearance=1e-4), turns=2)  # doctest: +SKIP
    >>> jp.animate(motion, "slider_crank.mp4")  # doctest: +SKIP
    """
    from jointplay.figures.linkage.film import film_frames, film_sheet
    from jointplay.figures.linkage.scene import scene

    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".mp4" and not find_spec("imageio_ffmpeg"):
        raise refuse(str(path), f"films as MP4 need an encoder: {INSTALL}", "path")
    check_writable(path.parent, "path", [path.name])
    told = None if progress is None else Reporter(progress)
    with of_a_result(motion, but=lambda error: told is not None and error is told.error):
        known = mechanism or _mechanism(motion)
        shown = scene(known, places(known, motion), joint, turns, time)
        if ending not in FILMS:
            return write_figure(film_sheet(shown, frames), path)
        count = _count(shown, seconds, rate)
        pictures = _told(film_frames(shown, count), count, told)
        with replaced(path) as temporary:
            (_gif if ending == ".gif" else _mp4)(pictures, temporary, rate)
    return path


def _mechanism(motion: xr.Dataset) -> Mechanism:
    """The mechanism that a result names."""
    study = provenance.read(motion).get("study")
    table = study.get("mechanism") if isinstance(study, dict) else motion.attrs.get("mechanism")
    if table is None or "swept" in motion.attrs:
        expected = "the Mechanism that moved is needed: this dataset is not one motion that names it"
        raise InputError([Problem("mechanism", NOTHING, expected)])
    return Mechanism.model_validate(json.loads(table) if isinstance(table, str) else table)


def _count(shown, seconds: float, rate: int) -> int:
    """Number of frames of a film."""
    length = float(shown.times[-1] - shown.times[0])
    count = round(length / float(shown.motion["turn_period_nominal"]) * seconds * rate) + 1
    if not 2 <= count <= MOST:
        raise refuse(seconds, f"a film of 2 to {MOST} frames is accepted; this would have {count}", "seconds")
    return count


def _told(pictures: Iterable[np.ndarray], count: int, progress) -> Iterator[np.ndarray]:
    for number, picture in enumerate(pictures, 1):
        yield picture
        if progress is not None:
            progress(number / count)


def _gif(pictures: Iterator[np.ndarray], path: Path, rate: int) -> None:
    """Write a film that repeats, in up to 128 colours."""
    from PIL import Image

    first, *rest = (Image.fromarray(each).quantize(128, dither=Image.Dither.NONE) for each in pictures)
    first.save(path, format="GIF", save_all=True, append_images=rest, duration=1000 / rate, loop=0)


def _mp4(pictures: Iterator[np.ndarray], path: Path, rate: int) -> None:
    """Write a film that every player knows (H.264)."""
    from imageio_ffmpeg import write_frames

    first = next(pictures)
    size = (first.shape[1], first.shape[0])
    form = {"codec": "libx264", "macro_block_size": 2, "output_params": ["-f", "mp4", "-crf", "20"]}
    writer = write_frames(str(path), size, fps=rate, **form)
    writer.send(None)
    try:
        writer.send(first)
        for picture in pictures:
            writer.send(picture)
    finally:
        writer.close()
