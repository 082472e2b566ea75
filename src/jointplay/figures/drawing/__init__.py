"""Elements, styles and axes that figures share.

Matplotlib and xarray are loaded where something is drawn: types of theirs stand here for heads of functions,
which are read, and checked, but not evaluated.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure, FigureBase, SubFigure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.transforms import Transform
    from xarray import DataArray, Dataset
else:
    Axes = Axis = ListedColormap = Figure = FigureBase = SubFigure = Line2D = Patch = Transform = Any
    DataArray = Dataset = Any

__all__ = [
    *("Axes", "Axis", "ListedColormap", "Figure", "FigureBase", "SubFigure"),
    *("Line2D", "Patch", "Transform", "DataArray", "Dataset"),
]
