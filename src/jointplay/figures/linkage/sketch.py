"""A linkage in one pose: ground, links, joints, springs, loads, drive, gravity, and their names.

A name stands beside what it names, where the least is drawn and other names are not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from jointplay.figures.drawing import Axes, style
from jointplay.figures.linkage import symbols
from jointplay.figures.linkage.guide import OUTLINE, SIDES
from jointplay.figures.linkage.symbols import Artists
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.parts.loads import Force, Torque
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import Pose

MARGIN, FLATTEST = 0.16, 0.45  # of the size of the mechanism: around it, and its least height or width
PLAY, STROKE, WALL = 0.1, 0.016, 0.035  # of it: a guide beyond its slider, its strokes, its faces
LETTER, HALF, NEAR = 1.5, 1.0, 2.0  # mm: a letter's width, half its height, the reach of what is drawn
DENSE = 1.0  # mm between points that stand for a line
AROUND, RINGS = np.deg2rad(np.arange(0, 360, 30)), (1.0, 1.3, 1.7, 2.2)  # RINGS: of the usual distance
FAR = 0.15  # points in a name's way that are as bad as a mm of distance


@dataclass(frozen=True)
class Sketch:
    """A mechanism to be drawn on axes whose data are lengths in m times a factor.

    Parameters
    ----------
    mechanism : Mechanism
        What is drawn.
    factor : float
        Of lengths in m.
    reach : mapping of str to (float, float)
        By prismatic joint: least and greatest slide that its guide shows, m.
    """

    mechanism: Mechanism
    factor: float = 1.0
    reach: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def places(self) -> dict[str, list[float]]:
        """Distances from a link's origin, m, between which its bar is drawn."""
        pins = [pin for joint in self.mechanism.joints for pin, _ in joint.ends]
        pins += [
            pin for part in (*self.mechanism.springs, *self.mechanism.loads) for pin in part.pins.values()
        ]
        found = {link.name: [mass.at for mass in link.masses] for link in self.mechanism.links}
        for pin in pins:
            if pin.link != GROUND:
                found[pin.link].append(pin.at)
        sliding = {joint.journal.link for joint in self.mechanism.joints if joint.prismatic}
        guides = {joint.bearing.link for joint in self.mechanism.joints if joint.prismatic}
        for link in self.mechanism.links:
            if link.name in guides or (link.name not in sliding and not any(found[link.name])):
                found[link.name].append(link.length)
        return {name: [min(ats, default=0.0), max(ats, default=0.0)] for name, ats in found.items()}

    def draw(self, ax: Axes, pose: Pose, actions: bool = True) -> Artists:
        """Draw everything but names in a pose, drive and loads if `actions`; return the artists."""
        return [
            *self._guides(ax, pose),
            *self._links(ax, pose),
            *self._joints(ax, pose),
            *self._springs(ax, pose),
            *(self._actions(ax, pose) if actions else ()),
        ]

    def corners(self, poses: Sequence[Pose]) -> np.ndarray:
        """Return all points that have to be seen, shape (points, 2), in the units of the axes."""
        fixed = [pin for joint in self.mechanism.joints for pin, _ in joint.ends]
        fixed += [pin for spring in self.mechanism.springs for pin in spring.pins.values()]
        found = [pose.along(name, at) for pose in poses for name, ats in self.places.items() for at in ats]
        found += [np.array(pin.point) for pin in fixed if pin.link == GROUND]
        sliding = [joint for joint in self.mechanism.clearance_joints if joint.prismatic]
        blocks = [self.contacts(pose, joint) for pose in poses for joint in sliding]
        return np.concatenate([self.factor * np.array(found), *blocks])

    def frame(self, ax: Axes, poses: Sequence[Pose]) -> None:
        """Set limits of the axes around all poses."""
        points = self.corners(poses)
        low, high = points.min(axis=0), points.max(axis=0)
        size = np.max(high - low)
        pad = MARGIN * size + np.maximum(FLATTEST * size - (high - low), 0.0) / 2
        low, high = low - pad, high + pad
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")

    def at(self, pose: Pose, pin: Pin) -> np.ndarray:
        """The point of a pin, in the units of the axes."""
        return self.factor * pose.point(pin)

    def contacts(self, pose: Pose, joint: Joint) -> np.ndarray:
        """Places of contacts of a joint, in the units of the axes: corners of a slider, or the journal."""
        spot = self.at(pose, joint.journal)
        if not joint.prismatic:
            return spot[None]
        angle = pose.direction(joint.journal)
        along = np.array([np.cos(angle), np.sin(angle)])
        frame = np.array([joint.half_length * along, joint.half_height * np.array([-along[1], along[0]])])
        return spot + self.factor * SIDES @ frame

    def bar(self, pose: Pose, link: str) -> np.ndarray:
        """The ends of a link's bar, shape (2, 2), in the units of the axes."""
        return self.factor * np.array([pose.along(link, at) for at in self.places[link]])

    def _guides(self, ax: Axes, pose: Pose) -> Artists:
        found, size = [], np.ptp(self.corners([pose]), axis=0).max()
        for joint in self.mechanism.joints:
            if not joint.prismatic:
                continue
            ground = joint.bearing.link == GROUND
            base, angle = self.at(pose, joint.bearing), pose.direction(joint.bearing)
            along = np.array([np.cos(angle), np.sin(angle)])
            low, high = (self.factor * s for s in self.reach.get(joint.name, (slide(pose, joint),) * 2))
            beyond = PLAY * size + (0.0 if joint.ideal else self.factor * joint.half_length)
            ends = base + np.outer([low - beyond, high + beyond], along)
            if joint.ideal:
                found += symbols.guide(ax, ends, angle, STROKE * size * ground)
                continue
            away = self.factor * (joint.half_height + joint.clearance)
            for normal in np.array([(-along[1], along[0]), (along[1], -along[0])]):
                found += symbols.face(ax, ends + away * normal, WALL * size * normal, ground)
        return found

    def _links(self, ax: Axes, pose: Pose) -> Artists:
        found = []
        for link in self.mechanism.links:
            ends = self.bar(pose, link.name)
            if np.ptp(ends, axis=0).any():
                found += symbols.bar(ax, ends, link.elastic)
            for mass in link.masses:
                found += symbols.weight(ax, self.factor * pose.along(link.name, mass.at))
        return found

    def _joints(self, ax: Axes, pose: Pose) -> Artists:
        found = []
        for joint in self.mechanism.joints:
            point = self.at(pose, joint.journal)
            if joint.prismatic and not joint.ideal:
                found += symbols.block(ax, self.contacts(pose, joint)[OUTLINE])
            elif joint.prismatic:
                found += symbols.slider(ax, point, pose.direction(joint.bearing))
            if not joint.prismatic and GROUND in joint.links:
                found += symbols.support(ax, point)
            if not joint.prismatic:
                found += symbols.pin(ax, point, loose=not joint.ideal)
        return found

    def _springs(self, ax: Axes, pose: Pose) -> Artists:
        found = []
        for spring in self.mechanism.springs:
            if spring.twists:
                found += symbols.spiral(ax, self._hinge(pose, spring.links))
                continue
            ends = [self.at(pose, pin) for pin in spring.pins.values()]
            found += symbols.coil(ax, *ends)
            for pin, end in zip(spring.pins.values(), ends, strict=True):
                if pin.link == GROUND:
                    found += symbols.support(ax, end)
        return found

    def _hinge(self, pose: Pose, links: tuple[str, str]) -> np.ndarray:
        """Point at which two links meet, or the middle of the first that moves."""
        for joint in self.mechanism.joints:
            if joint.links == {*links}:
                return self.at(pose, joint.journal)
        return self.bar(pose, next(name for name in links if name != GROUND)).mean(axis=0)

    def _actions(self, ax: Axes, pose: Pose) -> Artists:
        """Draw drive and loads."""
        found, drive = [], self.mechanism.drive
        if drive:
            axle = self.factor * self._axle(pose, drive.link)
            found += symbols.turning(ax, axle, drive.nominal_speed >= 0)
        for load in self.mechanism.loads:
            spot = self._spot(pose, load)
            if load.twists:
                found += symbols.turning(ax, spot)
            else:
                angle = load.direction + load.turning * pose.angles[load.link]
                found += symbols.arrow(ax, spot, angle)
        return found

    def _spot(self, pose: Pose, load: Force | Torque) -> np.ndarray:
        """Point at which a load is drawn: for a torque the middle of its link."""
        return self.bar(pose, load.link).mean(axis=0) if load.twists else self.at(pose, load.on)

    def _axle(self, pose: Pose, link: str) -> np.ndarray:
        """Point at which a link turns on the ground, m; else its origin."""
        for joint in self.mechanism.joints:
            if joint.links == {link, GROUND} and not joint.prismatic:
                return pose.point(joint.journal)
        return pose.origins[link]

    def name(self, ax: Axes, pose: Pose) -> None:
        """Write the names of everything, once the axes have their place and limits."""
        names, bold, slanted = Names(ax), {"fontweight": "bold"}, {"fontstyle": "italic"}
        for joint in self.mechanism.joints:
            names.around(self.at(pose, joint.journal), joint.name, **bold)
        for link in self.mechanism.links:
            bar = self.bar(pose, link.name)
            if np.ptp(bar, axis=0).any():
                names.along(bar, link.name, **slanted)
            else:
                names.around(bar[0], link.name, 5.0, **slanted)
        for spring in self.mechanism.springs:
            ends = [self.at(pose, pin) for pin in spring.pins.values()]
            if spring.twists:
                names.around(self._hinge(pose, spring.links), spring.name, 6.0, **slanted)
            else:
                names.along(ends, spring.name, 4.5, **slanted)
        for load in self.mechanism.loads:
            names.around(self._spot(pose, load), load.name, 7.0, color=symbols.ACTION)


def slide(pose: Pose, joint: Joint) -> float:
    """How far along its guide a slider is, m."""
    angle = pose.direction(joint.bearing)
    apart = pose.point(joint.journal) - pose.point(joint.bearing)
    return float(apart @ np.array([np.cos(angle), np.sin(angle)]))


def gravity(ax: Axes, mechanism: Mechanism, points: np.ndarray) -> None:
    """Draw the direction of gravity in the corner of the axes that is farthest from the drawing."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.transforms import Affine2D, ScaledTranslation

    if not mechanism.gravity:
        return
    towards = np.array([np.cos(mechanism.gravity_direction), np.sin(mechanism.gravity_direction)])
    corners = np.array([(1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
    there = ax.transAxes.inverted().transform(ax.transData.transform(points))
    free = corners[np.argmax([np.min(np.hypot(*(there - corner).T)) for corner in corners])]
    inward = (1.0 - 2.0 * free) * 5.0 * style.MILLIMETRE
    frame = Affine2D().scale(style.MILLIMETRE) + ax.figure.dpi_scale_trans
    frame += ScaledTranslation(*free, ax.transAxes) + ScaledTranslation(*inward, ax.figure.dpi_scale_trans)
    look = symbols.HEAD | {"color": style.GREY, "transform": frame}
    ax.add_patch(FancyArrowPatch(-3 * towards, 3 * towards, **look))
    offset = 2.2 * np.array([towards[1], -towards[0]])
    ax.text(*offset, "$g$", transform=frame, color=style.GREY, ha="center", va="center")


@dataclass
class Names:
    """Names on axes whose limits and place are settled, beside all that is drawn there."""

    ax: Axes

    def __post_init__(self) -> None:
        drawn = (self.ax.patch, *self.ax.lines, *self.ax.patches, *self.ax.figure.artists)
        paths = (each.get_path().to_polygons(each.get_transform(), closed_only=False) for each in drawn)
        ends = np.concatenate([np.stack([line[:-1], line[1:]], 1) for path in paths for line in path])
        ends = ends[np.isfinite(ends).all((1, 2))] / self.ax.figure.dpi / style.MILLIMETRE
        steps = 2 + (np.hypot(*(ends[:, 1] - ends[:, 0]).T) / DENSE).astype(int)
        points = [np.linspace(*both, n) for both, n in zip(ends, steps, strict=True)]
        # once each, or names would rather lie on a line than near dense hatching
        self.taken = DENSE * np.unique(np.round(np.concatenate(points) / DENSE), axis=0)

    def paper(self, points) -> np.ndarray:
        """Return points of the axes in mm on the paper."""
        return self.ax.transData.transform(points) / self.ax.figure.dpi / style.MILLIMETRE

    def around(self, point, text: str, away: float = 4.0, **look) -> None:
        """Write a name around a point."""
        half = LETTER * (len(text) - 1) / 2
        offsets = [((r * away + half) * np.cos(a), r * away * np.sin(a)) for r in RINGS for a in AROUND]
        self._best([(point, np.array(offset), 0.0) for offset in offsets], text, look)

    def along(self, ends, text: str, away: float = 3.2, **look) -> None:
        """Write a name along a line, on one of its sides."""
        first, last = np.asarray(ends)
        course = np.subtract(*self.paper([last, first]))
        across = np.array([-course[1], course[0]]) / np.hypot(*course)
        turn = (np.rad2deg(np.arctan2(course[1], course[0])) + 90) % 180 - 90
        shares = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74)
        offsets = [side * r * away * across for r in RINGS for side in (1, -1)]
        places = [(first + s * (last - first), offset, turn) for s in shares for offset in offsets]
        self._best(places, text, {"rotation": turn, "rotation_mode": "anchor"} | look)

    def _best(self, places, text: str, look: dict) -> None:
        """Write a name at the best of some places: point, offset in mm, and turn in degrees."""
        half = LETTER * len(text) / 2
        box = np.add.outer(np.linspace(-half, half, 1 + len(text)), 1j * HALF * np.array([-1, 0, 1])).ravel()

        def letters(place) -> np.ndarray:
            point, offset, turn = place
            course = np.exp(1j * np.deg2rad(turn)) * box
            return self.paper(point) + offset + np.stack([course.real, course.imag], -1)

        def crowded(place) -> float:
            gaps = letters(place)[:, None] - self.taken
            return float(np.exp(-np.square(gaps / NEAR).sum(-1)).sum(-1).mean() + FAR * np.hypot(*place[1]))

        best = min(places, key=crowded)
        self.taken = np.concatenate([self.taken, letters(best)])
        symbols.word(self.ax, best[0], text, tuple(best[1]), **look)
