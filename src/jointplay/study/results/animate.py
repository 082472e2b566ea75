"""A motion as a film (MP4, GIF) or as a sheet of frames (PDF, PNG, …)."""

from __future__ import annotations

import json
import logging
import tempfile
import time as clock
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib.util import find_spec
from itertools import chain, islice
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from jointplay.analysis.keywords import Progress
from jointplay.display.errors import NOTHING, of_a_result, refuse
from jointplay.display.number_text import duration
from jointplay.display.terminal import requested_progress
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
TRIED = 6  # frames from which the size of a film and the time that it takes are told before
COLOURS = 128  # of a GIF, the same in all frames
INSTALL = "pip install 'jointplay[animation]', or a name that ends in .gif or .pdf"

Count = Annotated[int, Field(strict=True, ge=1, le=48)]
Rate = Annotated[int, Field(strict=True, ge=1, le=60)]
Result = Annotated[xr.Dataset, accepts("a response, as jp.simulate or jp.open gives it,")]


@checked()
def animate(
    motion: Result,
    path: Annotated[Path | str, accepts("the name of a file")],
    *,
    joint: str | None = None,
    turns: Any = None,
    time: Any = None,
    seconds: Positive = 6.0,
    rate: Rate = 16,
    frames: Count = 8,
    mechanism: Annotated[Mechanism | None, accepts("a Mechanism")] = None,
    progress: Progress = None,
) -> Path:
    """Show a mechanism in motion, its joints with clearance enlarged, their forces, and paths of the joints.

    By default a film shows the one turn around the hardest impact, which is that of the largest speed at a
    joint, and a sheet the moments before, at and after it. Where progress is shown, the size of a film and
    the time that it takes are estimated before it is drawn.

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
        The last so many turns, or [first, last], whatever happens in them.
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
    progress : bool or callable, optional
        True shows a bar, False does not, a function is called with the fraction done; by default a bar is
        shown on a terminal or in a notebook.

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
    with requested_progress(progress, path.name) as hook:
        reporter = None if hook is None else Reporter(hook)
        with of_a_result(motion, but=lambda error: reporter is not None and error is reporter.error):
            known = mechanism or _mechanism(motion)
            shown = scene(known, places(known, motion), joint, turns, time)
            if ending not in FILMS:
                return write_figure(film_sheet(shown, frames), path)
            samples = shown.frames(_count(shown, seconds, rate))
            first = int(np.clip(np.searchsorted(samples, shown.struck or 0) - TRIED // 2, 0, samples.size))
            tried = samples[first : first + TRIED]
            pictures = film_frames(shown, chain(tried, samples))
            write = _tried(pictures, len(tried), len(samples), _gif if ending == ".gif" else _mp4, rate)
            with replaced(path) as temporary:
                write(_tracked(pictures, len(samples), reporter), temporary)
    return path


def _tried(pictures: Iterator[np.ndarray], tried: int, count: int, form: Callable, rate: int) -> Callable:
    """The writer of a film with the colours of the first frames, whose size and time tell those of all."""
    shots = [next(pictures)]
    begun = clock.perf_counter()
    shots += islice(pictures, tried - 1)
    drawn = clock.perf_counter() - begun  # what encodes them waits for what draws them
    write = partial(form, rate=rate, colours=_colours(shots))
    with tempfile.TemporaryDirectory() as folder:
        one, all_ = (_size(write, part, Path(folder)) for part in (shots[:1], shots))
    more = (count - 1) / max(len(shots) - 1, 1)
    size, lasts = one + more * (all_ - one), more * drawn
    high, wide, _ = shots[0].shape
    frames = f"a film of {count} frames of {wide} × {high} pixels"
    words = f"{frames} has about {size / 1e6:.2g} MB and takes about {duration(lasts)} to draw"
    logging.getLogger("jointplay").info(words)
    return write


def _size(write: Callable, pictures: list[np.ndarray], folder: Path) -> int:
    """Size of a film of these frames, B."""
    write(iter(pictures), file := folder / "tried")
    return file.stat().st_size


def _colours(pictures: list[np.ndarray]) -> Any:
    """The colours of some frames, as an image that has them."""
    from PIL import Image

    extremes = Image.Quantize.MAXCOVERAGE  # white stays white, and a thin line its colour
    return Image.fromarray(np.concatenate(pictures)).quantize(COLOURS, extremes, dither=Image.Dither.NONE)


def _mechanism(motion: xr.Dataset) -> Mechanism:
    """The mechanism that a result names."""
    study = provenance.read(motion).get("study")
    table = study.get("mechanism") if isinstance(study, dict) else motion.attrs.get("mechanism")
    if table is None or "swept" in motion.attrs:
        expected = "the Mechanism that moved is needed: this dataset is not one motion that names it"
        raise refuse(NOTHING, expected, "mechanism")
    table = json.loads(table) if isinstance(table, str) else table
    if "rates" in table:
        raise refuse(table["name"], "a linkage is accepted, no system of equations", "mechanism")
    return Mechanism.model_validate(table)


def _count(shown, seconds: float, rate: int) -> int:
    """Number of frames of a film."""
    length = float(shown.times[-1] - shown.times[0])
    count = round(length / float(shown.motion["turn_period_nominal"]) * seconds * rate) + 1
    if not 2 <= count <= MOST:
        raise refuse(seconds, f"a film of 2 to {MOST} frames is accepted; this would have {count}", "seconds")
    return count


def _tracked(pictures: Iterable[np.ndarray], count: int, progress) -> Iterator[np.ndarray]:
    for number, picture in enumerate(pictures, 1):
        yield picture
        if progress is not None:
            progress(number / count)


def _gif(pictures: Iterator[np.ndarray], path: Path, rate: int, colours: Any) -> None:
    """Write a film that repeats, each frame as what differs from the one before."""
    from PIL import Image

    few = (Image.fromarray(each).quantize(palette=colours, dither=Image.Dither.NONE) for each in pictures)
    next(few).save(path, format="GIF", save_all=True, append_images=few, duration=1000 / rate, loop=0)


def _mp4(pictures: Iterator[np.ndarray], path: Path, rate: int, colours: Any) -> None:
    """Write a film that every player knows (H.264)."""
    from imageio_ffmpeg import write_frames

    first = next(pictures)
    form = {"codec": "libx264", "macro_block_size": 2, "output_params": ["-f", "mp4", "-crf", "20"]}
    writer = write_frames(str(path), first.shape[1::-1], fps=rate, **form)
    writer.send(None)
    try:
        for picture in chain([first], pictures):
            writer.send(picture)
    finally:
        writer.close()
