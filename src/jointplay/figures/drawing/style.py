"""How every figure looks: one table of settings, two column widths, one palette.

Widths and type sizes follow what mechanics and dynamics journals print (columns of 84-90 and 174-190 mm,
8-9 pt sans-serif, embedded TrueType). Colours differ in lightness as well as in hue: a grey print keeps them.
"""

from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib.style
from cycler import cycler
from matplotlib.figure import Figure

MILLIMETRE = 1 / 25.4
COLUMNS = {"single": 88.0, "double": 180.0}  # mm

BLACK, BLUE, AMBER, GREY = "#000000", "#0072b2", "#e69f00", "#7f7f7f"
DISC, WARNING = "#f2f2f2", "#a40000"

# dark and thick against light and thin: distinct without colour
IN_CONTACT = {"color": "#00334d", "linewidth": 1.0, "linestyle": "-", "label": "contact"}
IN_FLIGHT = {"color": AMBER, "linewidth": 0.6, "linestyle": "-", "label": "free flight"}

RC = {
    "agg.path.chunksize": 20_000,  # longer paths are drawn in pieces: the rasterizer holds no more
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "axes.formatter.useoffset": False,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(
        color=[BLACK, BLUE, AMBER, GREY], linestyle=["-", (0, (5, 1.5)), (0, (6, 1, 1, 1)), (0, (1.5, 1))]
    ),
    "axes.titlesize": 8,
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same picture on every machine
    "font.size": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "lines.linewidth": 0.8,
    "lines.solid_capstyle": "round",
    "mathtext.fontset": "dejavusans",
    "path.simplify": True,
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "savefig.dpi": 600,
    "svg.fonttype": "none",
    "svg.hashsalt": "jointplay",
    "xtick.direction": "in",
    "xtick.labelsize": 8,
    "xtick.major.width": 0.6,
    "ytick.direction": "in",
    "ytick.labelsize": 8,
    "ytick.major.width": 0.6,
}
UNDATED = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}  # the same figure is the same file
PREVIEW_DPI = 300  # of a PNG; vector formats embed their point clouds at savefig.dpi
VERTEX_LIMIT = 40_000  # longer paths are embedded as images: vector files of them are slow to open


def paper() -> AbstractContextManager:
    """Settings of all figures, over matplotlib's defaults, during a `with` block or a decorated function."""
    return matplotlib.style.context(["default", RC])


class Sheet(Figure):
    """A figure that is saved in this style too: font embedding and the like are looked up only then."""

    def savefig(self, fname, **options) -> None:
        """Save as `matplotlib.figure.Figure.savefig` does, without a date and at journal resolution."""
        form = (options.get("format") or Path(str(fname)).suffix.lstrip(".") or "png").lower()
        options["metadata"] = UNDATED.get(form, {}) | (options.get("metadata") or {})
        if form == "png":
            options.setdefault("dpi", PREVIEW_DPI)
        with paper():
            super().savefig(fname, **options)


def sheet(width: float, height: float) -> Sheet:
    """Return an empty figure; `width` and `height` in mm."""
    return Sheet(figsize=(width * MILLIMETRE, height * MILLIMETRE))
