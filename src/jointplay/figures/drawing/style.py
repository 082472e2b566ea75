"""Style of every figure: one table of settings, two column widths, one palette.

Widths and type sizes follow what mechanics and dynamics journals print (columns of 84-90 and 174-190 mm,
8-9 pt sans-serif, embedded TrueType). Colours differ in lightness as well as in hue: a grey print keeps them.

Axes of somebody else's figure in the place of a figure of our own, for drawings of one panel.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from cycler import cycler

from jointplay.display.terminal import held
from jointplay.figures.drawing import Axes, Dataset, Figure, SubFigure, select

if TYPE_CHECKING:
    from jointplay.figures.drawing.derived import Sheet

MILLIMETRE = 1 / 25.4
COLUMNS = {"single": 88.0, "double": 180.0}  # mm
BLACK, BLUE, AMBER, GREY = "#000000", "#0072b2", "#e69f00", "#7f7f7f"
MORE = ("#8b2500", "#56b4e9", "#007a5a", "#cc79a7")  # of lines beyond the fourth
DASHES = (
    *("-", (0, (5, 1.5)), (0, (6, 1, 1, 1)), (0, (1.5, 1))),
    *((0, (6, 1, 1, 1, 1, 1)), (0, (10, 2)), (0, (3, 2.5)), (0, (1, 2.5))),
)
DISC, WARNING = "#f2f2f2", "#a40000"
# dark and thick against light and thin: distinct without colour
IN_CONTACT = {"color": "#00334d", "linewidth": 1.0, "linestyle": "-", "label": "contact"}
IN_FLIGHT = {"color": AMBER, "linewidth": 0.6, "linestyle": "-", "label": "free flight"}
RC = {
    "agg.path.chunksize": 20_000,  # longer paths are drawn in pieces: the rasterizer holds no more
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.useoffset": False,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(color=[BLACK, BLUE, AMBER, GREY, *MORE], linestyle=DASHES),
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
VERTEX_LIMIT = 40_000  # longer paths are embedded as images: vector files of them are slow to open
TALL = 0.5  # height over width from which a sheet keeps its shape where its width is changed


class Settings(NamedTuple):
    """Settings of a figure besides its content: width in mm, font, axes to draw in, results drawn with it."""

    width: float | None = None
    font: str | None = None
    ax: Axes | SubFigure | None = None
    same_sheet: tuple[Dataset, ...] = ()

    @property
    def rc(self) -> dict[str, Any]:
        """Settings of the font; its formulas too."""
        if self.font is None:
            return {}
        formulas = {"rm": self.font, "it": f"{self.font}:italic", "bf": f"{self.font}:bold"}
        return {"font.family": self.font, "mathtext.fontset": "custom", "mathtext.cal": self.font} | {
            f"mathtext.{face}": name for face, name in formulas.items()
        }


_USUAL = Settings()


_SETTINGS: ContextVar[Settings] = ContextVar("settings", default=_USUAL)


def settings(**given: Any) -> AbstractContextManager[None]:
    """Draw figures inside the block with these `Settings`."""
    return held(_SETTINGS, _SETTINGS.get()._replace(**given))


def same_sheet() -> tuple[Dataset, ...]:
    """Results on the same sheet, with which a figure has units and axes in common."""
    return _SETTINGS.get().same_sheet


@contextmanager
def paper(settings: dict[str, Any] | None = None) -> Iterator[None]:
    """Settings of all figures, over matplotlib's defaults, during a `with` block or a decorated function."""
    more = _SETTINGS.get().rc if settings is None else settings
    import matplotlib.style

    with matplotlib.style.context(["default", RC | more]):
        yield


def sheet(width: float, height: float) -> Sheet | SubFigure | Panel:
    """Return an empty figure, of `width` and `height` in mm, or the user's axes or subfigure instead."""
    from matplotlib.axes import Axes

    from jointplay.figures.drawing.derived import Sheet

    given = _SETTINGS.get()
    if isinstance(given.ax, Axes):
        return Panel(given.ax)
    if given.ax is not None:
        return given.ax
    if given.width:
        scale = given.width / width
        width, height = given.width, height * scale if height > TALL * width else height
    figure = Sheet(figsize=(width * MILLIMETRE, height * MILLIMETRE))
    figure.style = partial(paper, given.rc | {"figure.constrained_layout.use": False})  # it is laid out then
    return figure


class Panel:
    """A user's axes that answer as a figure with one panel; size and layout are their owner's.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    """

    def __init__(self, ax: Axes) -> None:
        self.ax, self.figure, self.axes = ax, ax.figure, [ax]

    def subplots(self, rows: int = 1, columns: int = 1, squeeze: bool = True, **_: Any) -> Any:
        """Give the axes, where one panel is wanted."""
        if rows * columns > 1:
            self._several(rows * columns)
        return self.ax if squeeze else np.array([[self.ax]])

    def subfigures(self, rows: int, columns: int, **_: Any) -> Any:
        """Refuse: a sheet of several results has several panels."""
        self._several(rows * columns)

    def add_gridspec(self, rows: int, columns: int, **_: Any) -> Any:
        """Give the place of the axes, where one panel is wanted."""
        if rows * columns > 1:
            self._several(rows * columns)
        return np.empty((1, 1))

    def add_subplot(self, _: Any) -> Axes:
        """Give the axes."""
        return self.ax

    def supxlabel(self, words: str, **_: Any) -> None:
        """Write below the label of the x axis."""
        self.ax.set_xlabel(f"{self.ax.get_xlabel()}\n{words}")

    @staticmethod
    def _several(count: int) -> None:
        expected = f"a matplotlib SubFigure: this figure has {count} panels, which one Axes cannot hold"
        raise select.refuse("ax", "an Axes", expected)

    def legend(self, *entries: Any, loc: str = "best", **look: Any) -> None:
        """Put the legend inside the axes."""
        self.ax.legend(*entries, **look, loc="best" if loc.startswith("outside") else loc)

    def colorbar(self, mesh: Any, **look: Any) -> Any:
        """Put the colour bar next to the axes."""
        return self.ax.figure.colorbar(mesh, **look)

    def findobj(self, *match: Any) -> list[Any]:
        """Find artists in the axes."""
        return self.ax.findobj(*match)

    def suptitle(self, words: str, **look: Any) -> None:
        """Write on top of the axes."""
        look.pop("bbox", None)
        self.ax.set_title(words, **look)


def owner(figure: Any) -> Figure:
    """Return the whole figure that something was drawn in."""
    return (figure.ax.figure if isinstance(figure, Panel) else figure).get_figure(root=True)
