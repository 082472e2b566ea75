"""A mechanism in motion as a film: the linkage, its loose joints enlarged, their forces and their history."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from textwrap import fill

import numpy as np

from jointplay.display.number_text import measure
from jointplay.figures.drawing import Axes, Figure, artists, envelope, style
from jointplay.figures.linkage import enlarged, symbols
from jointplay.figures.linkage.scene import Loose, Scene, spread
from jointplay.figures.linkage.sketch import gravity

DPI, WIDE = 120, 760  # dots an inch, and most of a frame's width, of which larger sheets are drawn smaller
LONGEST = 14.0  # mm: the arrow of the largest force at a joint
ROWS = 3  # enlarged joints below each other
DASHES = ((style.BLACK, "-"), (style.BLUE, (0, (5, 1.5))), (style.AMBER, "-"), (style.GREY, (0, (1.5, 1))))
LINES = [{"color": colour, "linestyle": dashes} for colour, dashes in DASHES]
TRACE = {"color": style.GREY, "linewidth": 0.5, "linestyle": "-", "zorder": 1}
CURSOR = {"color": style.WARNING, "linewidth": 0.8, "linestyle": "-", "zorder": 5}
COLUMNS = 4
WIDE_ENOUGH = 1.7  # of its height: a linkage's panel on a sheet
LINKAGE, PANEL = 34.0, 29.0  # mm of height, with words: a linkage, a joint enlarged


def film_frames(scene: Scene, samples: Iterable[int]) -> Iterator[np.ndarray]:
    """Draw a film, a frame after the other, each an array of bytes, shape (height, width, 3), both even."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure, axes = stage(scene)
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(min(DPI, WIDE / figure.get_figwidth()))
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    for i in samples:
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
    """Return the figure with all that does not move, and its panels: l, f, and b: with a joint's name."""
    count, forced = len(scene.joints), scene.forces
    rows, columns = min(count, ROWS) or 1, -(-count // ROWS)
    height = max(84.0, 36.0 * rows) + 20.0 * forced
    figure = style.sheet(110.0 + 50.0 * columns, height)
    ratios = {"width_ratios": [1.9] + [1.0] * columns, "height_ratios": [2.6 / rows] * rows + [1.0] * forced}
    grid = figure.add_gridspec(rows + forced, 1 + columns, **ratios)
    axes = {"l": figure.add_subplot(grid[:rows, 0])}
    linkage(axes["l"], scene)
    for n, joint in enumerate(scene.joints):
        ax = axes["b:" + joint.name] = figure.add_subplot(grid[n % ROWS, 1 + n // ROWS])
        enlarged.frame(ax, joint, pad=16)
    if forced:
        history(axes.setdefault("f", figure.add_subplot(grid[rows, :])), scene)
    enlarged.legend(figure, scene.modes)
    for _ in range(2):  # panels whose aspect is fixed have their places after the second
        figure.draw_without_rendering()
    for joint in scene.joints:
        enlarged.of(joint).enlargement(axes["b:" + joint.name], joint)
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
    """Draw the forces over the whole time: of a bearing, of each face of a guide."""
    curves, beyond = {}, {}
    for loose in scene.enlarged:
        curves |= loose.curves
        if not loose.joint.prismatic:
            beyond[loose.joint.name] = [each[:, 0] for each in loose.extremes]
    for number, (name, force) in enumerate(curves.items()):
        look = LINES[number % len(LINES)] | {"linewidth": 0.6 if number < len(LINES) else 1.2}
        envelope.course(ax, 1e3 * scene.times, force, beyond.get(name), label=name, **look)
    ax.set(xlabel="Time (ms)", ylabel="Normal contact\nforce (N)", xlim=1e3 * scene.times[[0, -1]])
    if len(ax.get_legend_handles_labels()[1]) > 1:
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.0)


def moment(scene: Scene, axes: dict[str, Axes], i: int) -> symbols.Artists:
    """Draw the moving parts, at one sample."""
    pose = scene.pose(i)
    found = scene.sketch.draw(axes["l"], pose)
    place = {"transform": axes["l"].transAxes, "ha": "left", "va": "bottom"}
    found.append(axes["l"].text(0.0, 1.02, scene.title(i), **place))
    for loose in scene.enlarged:
        found += inside(axes["b:" + loose.joint.name], scene, loose, i)
        if scene.forces:
            spots = scene.sketch.contacts(pose, loose.joint)
            for k, angle, share in loose.pushes(i):
                found += symbols.arrow(axes["l"], spots[k], angle, LONGEST * share)
    return [*found, axes["f"].axvline(1e3 * scene.times[i], **CURSOR)] if scene.forces else found


def inside(ax: Axes, scene: Scene, loose: Loose, i: int, of_all: str = " (largest {})") -> symbols.Artists:
    """Draw the journal's centre and its path of up to a turn before, or the block; and the forces."""
    kind = enlarged.of(loose.joint)
    found = kind.moment(ax, loose, i, scene.before(i))
    if not scene.forces:
        return found
    words = measure(loose.felt(i), "N", 3) + of_all.format(measure(loose.most.max(), "N", 3))
    found.append(ax.text(0.0, ax.get_ylim()[1] + 0.05, words, ha="center", va="bottom"))
    turned = scene.pose(i).direction(loose.joint.bearing) if loose.joint.prismatic else 0.0
    for k, angle, share in loose.pushes(i):  # a guide's panel is in line with it
        along = kind.PUSH * share * np.array([np.cos(angle - turned), np.sin(angle - turned)])
        found += symbols.push(ax, kind.spots(loose, i)[k], along)
    return found


@style.paper()
def film_sheet(scene: Scene, count: int) -> Figure:
    """Draw so many frames of a motion in rows of four: around its impact, or evenly spread.

    Parameters
    ----------
    scene : Scene
        What moves.
    count : int
        How many.
    """
    samples = scene.close(count)
    columns, panels = min(len(samples), COLUMNS), 1 + len(scene.joints)
    rows = -(-len(samples) // columns)
    heights = [LINKAGE] + [PANEL] * len(scene.joints)
    figure = style.sheet(45.0 * COLUMNS, rows * sum(heights) + 6.0 * bool(scene.modes))
    grid = figure.add_gridspec(rows * panels, columns, height_ratios=heights * rows)
    insets = []
    for number, i in enumerate(samples.tolist()):
        row, column = number // columns * panels, number % columns
        ax = figure.add_subplot(grid[row, column])
        scene.sketch.frame(ax, scene.poses)
        beyond = max(WIDE_ENOUGH * np.ptp(ax.get_ylim()) - np.ptp(ax.get_xlim()), 0.0) / 2
        ax.set_xlim(ax.get_xlim() + beyond * np.array([-1, 1]))  # a title has the panel's width
        scene.sketch.draw(ax, scene.pose(i), actions=False)
        if not number:
            gravity(ax, scene.mechanism, scene.sketch.corners(scene.poses))
        ax.set(xticks=[], yticks=[])
        words = [fill(line, artists.NARROW) for line in scene.moment(i, samples)]
        ax.set_title(f"({number + 1}) " + "\n".join(words), loc="left")
        for place, each in enumerate(scene.enlarged, 1):
            inset = figure.add_subplot(grid[row + place, column])
            enlarged.of(each.joint).frame(inset, each.joint)
            insets.append((inset, each.joint))
            inside(inset, scene, each, i, of_all="")
            if panels > 2:
                look = {"ha": "right", "va": "center", "fontweight": "bold"}
                inset.text(-0.05, 0.5, each.joint.name, transform=inset.transAxes, **look)
    enlarged.legend(figure, scene.modes)
    finished = artists.finish(figure, scene.motion)
    figure.draw_without_rendering()
    for inset, joint in insets:
        enlarged.of(joint).enlargement(inset, joint)
    return finished
