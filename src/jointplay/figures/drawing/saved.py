"""The figure that all figures are: it is saved in their style too."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure

UNDATED = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}  # the same figure is the same file
PREVIEW_DPI = 300  # of images; vector formats embed their point clouds at savefig.dpi
NOTEBOOK_DPI = 130
VECTORS = ("pdf", "svg", "svgz", "ps", "eps", "pgf")


class Sheet(Figure):
    """A figure that is saved in its own style too: font embedding and the like are imported only then."""

    style: Callable[[], AbstractContextManager] = nullcontext

    def savefig(self, fname, **options) -> None:
        """Save as `matplotlib.figure.Figure.savefig` does, without a date and at journal resolution."""
        form = (options.get("format") or Path(str(fname)).suffix.lstrip(".") or "png").lower()
        if told := UNDATED.get(form, {}) | (options.pop("metadata", None) or {}):
            options["metadata"] = told
        if form not in VECTORS:
            options.setdefault("dpi", PREVIEW_DPI)
        with self.style():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        """Show itself in a notebook."""
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=NOTEBOOK_DPI)
        return stream.getvalue()
