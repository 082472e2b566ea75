"""Figures and ticks of our own, of matplotlib's classes: imported where something is drawn."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import Locator, MaxNLocator, MultipleLocator

UNDATED = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}  # the same figure is the same file
PREVIEW_DPI = 300  # of images; vector formats embed their point clouds at savefig.dpi
NOTEBOOK_DPI = 130
VECTORS = ("pdf", "svg", "svgz", "ps", "eps", "pgf")
STEPS = (1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720, 1800, 3600)  # of ticks, deg
MOST = 6  # intervals on an axis


class Sheet(Figure):
    """A figure that is saved in its own style too: font embedding and the like are imported only then."""

    style: Callable[[], AbstractContextManager] = nullcontext

    def savefig(self, fname, **options) -> None:
        """Save as `matplotlib.figure.Figure.savefig` does, without a date and at journal resolution."""
        form = (options.get("format") or Path(str(fname)).suffix.lstrip(".") or "png").lower()
        if metadata := UNDATED.get(form, {}) | (options.pop("metadata", None) or {}):
            options["metadata"] = metadata
        if form not in VECTORS:
            options.setdefault("dpi", PREVIEW_DPI)
        with self.style():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        """Show itself in a notebook."""
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=NOTEBOOK_DPI)
        return stream.getvalue()


class Degrees(Locator):
    """Ticks at 45, 90, 180, 360 deg and the like, whichever of them gives at most six intervals."""

    def __call__(self):
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin, vmax):
        """Return the ticks, in deg, of an axis from `vmin` to `vmax`."""
        span = abs(vmax - vmin)
        if span < STEPS[0] or span > MOST * STEPS[-1]:
            return MaxNLocator(MOST, steps=(1, 1.8, 3.6, 9, 10)).tick_values(vmin, vmax)
        step = next(step for step in STEPS if span <= MOST * step)
        return MultipleLocator(step).tick_values(min(vmin, vmax), max(vmin, vmax))
