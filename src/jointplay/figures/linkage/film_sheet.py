"""Frames of a motion side by side on one sheet, each with its loose joints enlarged."""

from matplotlib.figure import Figure

from jointplay.figures.drawing import artists, style
from jointplay.figures.linkage import enlarged, film
from jointplay.figures.linkage.linkage import gravity
from jointplay.figures.linkage.scene import Scene, spread

COLUMNS = 4
ALONE, LINKAGE, PANEL = (
    34.0,
    26.0,
    24.0,
)  # mm of height: of a linkage, of one with joints, of a joint enlarged


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
    rows, loose = -(-count // COLUMNS), len(scene.joints)
    figure = style.sheet(180.0, rows * (ALONE if not loose else LINKAGE + PANEL * loose) + 6.0)
    cells = figure.add_gridspec(rows, min(count, COLUMNS))
    insets = []
    for number, i in enumerate(spread(scene.times, count)):
        parts = cells[number // COLUMNS, number % COLUMNS].subgridspec(
            1 + loose, 1, height_ratios=[1.0] + [0.9] * loose
        )
        ax = figure.add_subplot(parts[0])
        scene.sketch.frame(ax, scene.poses)
        scene.sketch.draw(ax, scene.pose(int(i)), actions=False)
        if not number:
            gravity(ax, scene.mechanism, scene.sketch.corners(scene.poses))
        ax.set(xticks=[], yticks=[])
        artists.heading(ax, f"({number + 1})", scene.title(int(i)))
        for place, each in enumerate(scene.enlarged, 1):
            inset = figure.add_subplot(parts[place])
            enlarged.of(each.joint).frame(inset, each.joint)
            insets.append((inset, each.joint))
            film.inside(inset, scene, each, int(i))
            if loose > 1:
                look = {"ha": "right", "va": "center", "fontweight": "bold"}
                inset.text(-0.05, 0.5, each.joint.name, transform=inset.transAxes, **look)
    enlarged.legend(figure, scene.modes)
    finished = artists.finish(figure, scene.motion)
    figure.draw_without_rendering()
    for inset, joint in insets:
        enlarged.of(joint).enlargement(inset, joint)
    return finished
