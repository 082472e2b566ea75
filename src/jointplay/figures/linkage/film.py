"""A mechanism in motion as a film: the linkage, a bearing enlarged with its force, and the history of it."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jointplay.display.units import measure
from jointplay.figures.drawing import artists, style
from jointplay.figures.linkage import bearing, symbols
from jointplay.figures.linkage.linkage import gravity
from jointplay.figures.linkage.scene import Scene, spread

DPI = 120
LONGEST, LEAST = 14.0, 0.15  # mm: the arrow of the largest force at the joint; the least share of it drawn
TRACE = {"color": style.GREY, "linewidth": 0.5, "linestyle": "-", "zorder": 1}
CURSOR = {"color": style.WARNING, "linewidth": 0.8, "linestyle": "-", "zorder": 5}


def frames(scene: Scene, count: int) -> Iterator[np.ndarray]:
    """Draw a film, a frame after the other, each an array of bytes, shape (height, width, 3), both even."""
    figure, axes = stage(scene)
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(DPI)
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    for i in spread(scene.times, count):
        canvas.restore_region(still)
        with style.paper():
            drawn = moment(scene, axes, int(i))
            for each in sorted(drawn, key=lambda one: one.get_zorder()):
                each.draw(canvas.renderer)
        pixels = np.asarray(canvas.buffer_rgba())[..., :3]
        yield np.ascontiguousarray(pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2])
        for each in drawn:
            each.remove()


@style.paper()
def stage(scene: Scene) -> tuple[Figure, dict[str, Axes]]:
    """Return the figure with all that does not move, and its panels."""
    loose, forced = scene.joint is not None, scene.force is not None
    figure = style.sheet(160.0 if loose else 110.0, 104.0 if forced else 84.0)
    mosaic, ratios = ("lb;ff" if forced else "lb" if loose else "l"), {}
    if loose:
        ratios = {"width_ratios": (1.9, 1.0)} | ({"height_ratios": (2.6, 1.0)} if forced else {})
    axes = figure.subplot_mosaic(mosaic, **ratios)
    linkage(axes["l"], scene)
    if loose:
        bearing.frame(axes["b"], scene.joint.clearance)
        axes["b"].set_title(
            f"{scene.joint.name}: {scene.joint.journal.link} in {scene.joint.bearing.link}", pad=16
        )
    if forced:
        history(axes["f"], scene)
    figure.draw_without_rendering()
    if loose:
        bearing.enlargement(axes["b"], scene.joint.clearance)
    figure.set_layout_engine("none")
    return figure, axes


def linkage(ax: Axes, scene: Scene) -> None:
    """Set the stage of the linkage: limits for the whole motion, and the paths of its moving joints."""
    scene.sketch.frame(ax, scene.poses)
    gravity(ax, scene.mechanism, scene.sketch.corners(scene.poses))
    ax.set(xlabel="$x$ (mm)", ylabel="$y$ (mm)", title=" ")
    for joint in scene.mechanism.joints:
        path = np.array(
            [scene.sketch.at(pose, joint.journal) for pose in map(scene.pose, spread(scene.times, 400))]
        )
        if np.ptp(path, axis=0).max() > 1e-3:
            ax.plot(*path.T, **TRACE)


def history(ax: Axes, scene: Scene) -> None:
    """Draw the force over the whole time."""
    artists.curve(ax, 1e3 * scene.times, scene.force, color=style.BLACK, linewidth=0.6)
    ax.set(xlabel="Time (ms)", ylabel="Normal contact\nforce (N)", xlim=1e3 * scene.times[[0, -1]])


def moment(scene: Scene, axes: dict[str, Axes], i: int) -> symbols.Artists:
    """Draw what moves, at one sample."""
    pose = scene.pose(i)
    found = scene.sketch.draw(axes["l"], pose)
    place = {"transform": axes["l"].transAxes, "ha": "left", "va": "bottom"}
    found.append(axes["l"].text(0.0, 1.02, scene.title(i), **place))
    if scene.joint is None:
        return found
    found += inside(axes["b"], scene, i)
    if scene.force is None:
        return found
    spot, share = scene.sketch.at(pose, scene.joint.journal), max(scene.force[i], 0.0) / scene.peak
    if share > LEAST:
        found += symbols.arrow(axes["l"], spot, np.arctan2(*scene.journal[i, ::-1]), LONGEST * share)
    return [*found, axes["f"].axvline(1e3 * scene.times[i], **CURSOR)]


def inside(ax: Axes, scene: Scene, i: int) -> symbols.Artists:
    """Draw the journal's centre, its path of up to a turn before, and the force on the bearing."""
    period = float(scene.motion.get("turn_period_nominal", np.inf))
    first = int(np.searchsorted(scene.times, scene.times[i] - period))
    (x, y), touching = scene.journal[first : i + 1].T, scene.contact[first : i + 1]
    found = []
    for where, look in ((~touching, style.IN_FLIGHT), (touching, style.IN_CONTACT)):
        shown = where | artists.neighbours(where) if look is style.IN_FLIGHT else where
        found += ax.plot(x, np.where(shown, y, np.nan), **{**look, "label": "_"}, zorder=4)
    found += bearing.journal(ax, *scene.journal[i])
    if scene.force is None:
        return found
    found.append(ax.text(0.0, bearing.OUTER + 0.05, force_words(scene, i), ha="center", va="bottom"))
    share, (x, y) = max(scene.force[i], 0.0) / scene.peak, scene.journal[i]
    if share > LEAST:
        angle = np.arctan2(y, x)
        along = 0.9 * share * np.array([np.cos(angle), np.sin(angle)])
        tip = scene.journal[i] + along
        found += bearing.push(ax, scene.journal[i], tip)
    return found


def force_words(scene: Scene, i: int) -> str:
    """Return the force and, for the arrow's scale, the largest one."""
    return f"{measure(scene.force[i], 'N', 3)} of at most {measure(scene.peak, 'N', 3)}"
