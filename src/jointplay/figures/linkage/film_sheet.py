"""Frames of a motion side by side on one sheet, each with its bearing enlarged."""

from matplotlib.figure import Figure

from jointplay.figures.drawing import artists, style
from jointplay.figures.linkage import bearing, film
from jointplay.figures.linkage.linkage import gravity
from jointplay.figures.linkage.scene import Scene, spread

COLUMNS = 4
CELL = 50.0, 34.0  # mm of height: with a bearing, without


@style.paper()
def film_sheet(scene: Scene, count: int) -> Figure:
    """Draw so many frames of a motion, evenly spread over it, in rows of four.

    Parameters
    ----------
    scene : Scene
        What moves.
    count : int
        How many.
    """
    rows, loose = -(-count // COLUMNS), scene.joint is not None
    figure = style.sheet(180.0, rows * CELL[not loose] + 6.0)
    cells = figure.add_gridspec(rows, min(count, COLUMNS))
    for number, i in enumerate(spread(scene.times, count)):
        parts = cells[number // COLUMNS, number % COLUMNS].subgridspec(
            1 + loose, 1, height_ratios=(1, 0.9)[: 1 + loose]
        )
        ax = figure.add_subplot(parts[0])
        scene.sketch.frame(ax, scene.poses)
        scene.sketch.draw(ax, scene.pose(int(i)), actions=False)
        if not number:
            gravity(ax, scene.mechanism, scene.sketch.corners(scene.poses))
        ax.set(xticks=[], yticks=[])
        artists.heading(ax, f"({number + 1})", scene.title(int(i)))
        if loose:
            inset = figure.add_subplot(parts[1])
            bearing.frame(inset, scene.joint.clearance)
            film.inside(inset, scene, int(i))
    return artists.finish(figure, scene.motion)
