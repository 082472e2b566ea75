"""A mechanism in motion, sample by sample: its pose, its joints with clearance, the forces in them.

The hardest impact of a motion, and the stretch of time around it that a film or a sheet shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import measure
from jointplay.figures.drawing import Dataset, select, timebase
from jointplay.figures.linkage import guide
from jointplay.figures.linkage.sketch import Sketch, slide
from jointplay.solver.mechanism.parts.joints import Joint
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import Pose

NEAR = 0.125  # turns to either side of an impact beyond which a sheet shows nothing
EDGES = ("contact", "separation", "impact", "rest")  # events between which a journal flies or touches


@dataclass(frozen=True)
class Hit:
    """The hardest impact of a motion: when it begins, s, at which contact, and what it is in words."""

    time: float
    contact: str
    words: str


def hardest(motion: Dataset, joints: Sequence[Joint]) -> Hit | None:
    """The impact of the largest speed at some joints; without recorded speeds, the largest normal force."""
    named = {contact: joint.name for joint in joints for contact in joint.contacts}
    contacts = list(named)
    if not contacts:
        return None
    hits = events(motion, contacts, ("contact", "impact"))
    if hits.size and "event_normal_velocity" in motion:
        speeds = np.nan_to_num(np.abs(motion["event_normal_velocity"].values[hits]))
        hit, speed = hits[np.argmax(speeds)], measure(speeds.max(), "m s-1", 3)
        contact = select.labels(motion, "joint")[int(motion["event_joint"][hit])]
        return Hit(float(motion["event_time"][hit]), contact, f"{named[contact]} hits at {speed}")
    if "normal_force" not in motion:
        return None
    force = motion["normal_force"].sel(joint=contacts).transpose("time", "joint").values
    i, k = np.unravel_index(np.argmax(np.nan_to_num(force)), force.shape)
    return Hit(float(motion["time"][i]), contacts[k], f"largest force at {named[contacts[k]]}")


def events(motion: Dataset, contacts: Sequence[str], kinds: Sequence[str]) -> np.ndarray:
    """Numbers of the recorded events of some kinds at some contacts."""
    if not {"event_kind", "event_joint"} <= set(motion):
        return np.zeros(0, dtype=int)
    labels, known = select.labels(motion, "joint"), codes.flags(motion["event_kind"])
    there = np.isin(motion["event_joint"], [labels.index(each) for each in contacts])
    return np.flatnonzero(
        there & np.isin(motion["event_kind"], [c for c, kind in known.items() if kind in kinds])
    )


def turn(motion: Dataset) -> float:
    """A nominal turn, s; of a motion without one, its length."""
    period = float(motion.get("turn_period_nominal", np.inf))
    return period if period < np.inf else float(np.ptp(motion["time"]))


def turn_around(motion: Dataset, time: float) -> Dataset:
    """The turn around a time, of a motion recorded in windows within one; all of what is shorter."""
    panes = [each.samples for each in timebase.panes(motion)]
    pane = next((each for each in panes if time <= each["time"][-1]), panes[-1])
    times, length = pane["time"].values, turn(motion)
    begin = max(min(time - length / 2, times[-1] - length), times[0])
    slack = 1e-9 * length
    return pane.isel(time=np.flatnonzero((times >= begin - slack) & (times <= begin + length + slack)))


def phases(motion: Dataset, hit: Hit, peak: float) -> tuple[float, float]:
    """Begin of the flight before an impact, s, and end of that after it: the second edge after its peak."""
    begin, end = hit.time - NEAR * turn(motion), hit.time + NEAR * turn(motion)
    found = events(motion, [hit.contact], EDGES)
    edges = motion["event_time"].values[found] if found.size else np.zeros(0)
    before, after = edges[edges < hit.time], edges[edges > peak]
    return max([begin, *before[-1:]]), min([end, *after[1:2]])


MOST = 6  # joints with clearance that are enlarged
LEAST = 0.15  # share of the largest force from which one is drawn
SHOWN = 40  # poses from which the limits of the axes are found
MM = 1e3  # of lengths on the axes


@dataclass(frozen=True)
class Scene:
    """A mechanism and its motion.

    Parameters
    ----------
    mechanism : Mechanism
        What moves.
    motion : Dataset
        A response with ``origin_x`` and ``origin_y`` of the links.
    joints : sequence of Joint
        The joints with clearance that are enlarged.
    hit : Hit, optional
        The impact around which it is shown.
    """

    mechanism: Mechanism
    motion: Dataset
    joints: Sequence[Joint]
    hit: Hit | None = None

    @cached_property
    def times(self) -> np.ndarray:
        """Times of the samples, s."""
        return self.motion["time"].values

    @cached_property
    def _poses(self) -> tuple[list[str], np.ndarray, np.ndarray]:
        names = self.motion["link"].values.tolist()
        origins = np.stack([self.motion[f"origin_{axis}"].transpose("time", "link") for axis in "xy"], -1)
        return names, self.motion["angle"].transpose("time", "link").values, origins

    def pose(self, i: int) -> Pose:
        """Pose of the links."""
        names, angles, origins = self._poses
        return Pose(dict(zip(names, angles[i], strict=True)), dict(zip(names, origins[i], strict=True)))

    @cached_property
    def poses(self) -> list[Pose]:
        """Some poses from the whole of the motion."""
        return [self.pose(i) for i in spread(self.times, SHOWN)]

    @cached_property
    def sketch(self) -> Sketch:
        """The mechanism, its guides as long as it slides."""
        slides = {}
        for joint in self.mechanism.joints:
            if joint.prismatic:
                positions = [slide(self.pose(i), joint) for i in range(self.times.size)]
                slides[joint.name] = (min(positions), max(positions))
        return Sketch(self.mechanism, MM, slides)

    @cached_property
    def enlarged(self) -> list[Loose]:
        """The joints that are enlarged, over the motion."""
        return [Loose(joint, self) for joint in self.joints]

    @cached_property
    def forces(self) -> bool:
        """Whether there are joints to enlarge, and forces in them were recorded."""
        return bool(self.joints) and "normal_force" in self.motion

    @cached_property
    def modes(self) -> set[str]:
        """Modes of corners of the guides that are enlarged."""
        return {str(mode) for each in self.enlarged if each.joint.prismatic for mode in np.unique(each.modes)}

    def before(self, i: int) -> int:
        """The sample up to a turn before another."""
        period = float(self.motion.get("turn_period_nominal", np.inf))
        return int(np.searchsorted(self.times, self.times[i] - period)) if period < np.inf else 0

    def title(self, i: int, digits: int = 0) -> str:
        """Angle of the driven link, and time."""
        return ", ".join(filter(None, (self._angle(i, digits), measure(self.times[i], "s"))))

    def _angle(self, i: int, digits: int) -> str:
        crank = self.mechanism.crank
        angle = round(float(np.rad2deg(self.pose(i).angles[crank])), digits) % 360 if crank else 0.0
        return f"{crank} {angle:.{digits}f}°" if crank else ""

    @cached_property
    def struck(self) -> int | None:
        """The sample of the impact at which the force is largest: what follows its begin while it grows."""
        if self.hit is None:
            return None
        i = min(int(np.searchsorted(self.times, self.hit.time * (1 - 1e-12))), self.times.size - 1)
        if "normal_force" in self.motion:
            force = self.motion["normal_force"].sel(joint=self.hit.contact).values
            while i + 1 < force.size and force[i + 1] > force[i]:
                i += 1
        return i

    def frames(self, count: int) -> np.ndarray:
        """So many samples, evenly spread over all, the impact's among them."""
        found = spread(self.times, count)
        if self.struck is not None:
            found[np.argmin(np.abs(found - self.struck))] = self.struck
        return found

    def close(self, count: int) -> np.ndarray:
        """So many samples around the impact, the same number before it as after it; else of all."""
        if self.struck is None:
            return spread(self.times, count)
        i, last = self.struck, self.times.size - 1
        before = min(max((count - 1) // 2, count - 1 - (last - i)), i)
        after = min(count - 1 - before, last - i)
        begin, end = np.searchsorted(self.times, phases(self.motion, self.hit, self.times[i]))
        first, stop = max(0, min(begin, i - before)), min(max(end, i + after), last)
        parts = np.linspace(first, i, before + 1), np.linspace(i, stop, after + 1)[1:]
        return np.rint(np.concatenate(parts)).astype(int)

    def moment(self, i: int, among: np.ndarray) -> list[str]:
        """Lines that tell a sample from others: its time from the impact, and the driven link's angle."""
        crank, digits = self.mechanism.crank, 0
        if crank:
            turned = np.abs(np.diff([np.rad2deg(self.pose(k).angles[crank]) for k in among]))
            digits = int(np.clip(np.ceil(-np.log10(np.min(turned, initial=1.0) + 1e-9)), 0, 3))
        if self.struck is None:
            return [self.title(i, digits)]
        if i == self.struck:
            return [self.hit.words, self.title(i, digits)]
        apart = self.times[i] - self.times[self.struck]
        when = f"{measure(abs(apart), 's', 3)} {'after' if apart > 0 else 'before'}"
        return [when, self._angle(i, digits)]


@dataclass(frozen=True)
class Loose:
    """A joint with clearance over a motion: one contact in a bearing, four corners of a slider."""

    joint: Joint
    scene: Scene

    def _of(self, name: str) -> np.ndarray:
        """A variable of its contacts, shape (time, contacts)."""
        part = self.scene.motion[name].sel(joint=list(self.joint.contacts))
        return part.transpose("time", "joint").values

    @cached_property
    def journal(self) -> np.ndarray:
        """The journal's centre in its bearing, in clearances, shape (time, contacts, 2)."""
        return np.stack([self._of("journal_x"), self._of("journal_y")], -1) / self.joint.clearance

    @cached_property
    def shifts(self) -> np.ndarray:
        """Progress of corners towards their faces, in clearances, shape (time, 4)."""
        poses = map(self.scene.pose, range(self.scene.times.size))
        angles = np.array([pose.direction(self.joint.bearing) for pose in poses])
        normal = np.stack([-np.sin(angles), np.cos(angles)], -1)
        return np.einsum("tcx,tx,c->tc", self.journal, normal, guide.SIDES[:, 1])

    @cached_property
    def modes(self) -> np.ndarray:
        """Modes of its contacts, shape (time, contacts)."""
        if "mode" not in self.scene.motion:
            return np.full((self.scene.times.size, len(self.joint.contacts)), guide.UNKNOWN)
        meanings = codes.flags(self.scene.motion["mode"])
        return np.array([*meanings.values()])[np.searchsorted([*meanings], self._of("mode"))]

    @cached_property
    def contact(self) -> np.ndarray | None:
        """Whether contacts carry a force, shape (time, contacts); None, where modes were not recorded."""
        return ~np.isin(self.modes, ["free", "released"]) if "mode" in self.scene.motion else None

    @cached_property
    def force(self) -> np.ndarray:
        """Normal forces on the bearing or the guide, N, shape (time, contacts)."""
        return self._of("normal_force")

    @cached_property
    def extremes(self) -> list[np.ndarray]:
        """Lowest and highest normal forces since the sample before, N, where recorded; each as `force`."""
        names = [f"{word}_normal_force" for word in ("lowest", "highest")]
        found = [self._of(name) if name in self.scene.motion else self.force for name in names]
        return [np.concatenate([self.force[:1], each[1:]]) for each in found]  # the first: of time not shown

    @cached_property
    def curves(self) -> dict[str, np.ndarray]:
        """The force, N, in a bearing, or on each face of a guide."""
        name = self.joint.name
        if not self.joint.prismatic:
            return {name: self.force[:, 0]}
        faces = {"upper": 1, "lower": -1}
        return {f"{name}, {word} face": self.force @ (guide.SIDES[:, 1] == s) for word, s in faces.items()}

    @cached_property
    def most(self) -> np.ndarray:
        """The largest of its curves, N, and in a bearing the highest since the sample before."""
        return self.extremes[1][:, 0] if not self.joint.prismatic else np.max([*self.curves.values()], axis=0)

    @cached_property
    def peak(self) -> float:
        """The largest force of one contact, N."""
        return float(max(np.max(np.abs(self.force), initial=1e-300), self.extremes[1].max()))

    def felt(self, i: int) -> float:
        """The largest force at a sample, N; at that of the impact, right before and after it too."""
        if i == self.scene.struck:
            return self.most[i : i + 2].max()
        return max(curve[i] for curve in self.curves.values())

    def pushes(self, i: int) -> list[tuple[int, float, float]]:
        """Contacts with a force worth drawing: number, direction, rad, and share of the largest force."""
        along = self.scene.pose(i).direction(self.joint.bearing) + np.pi / 2
        found = []
        for k, share in enumerate(np.maximum(self.force[i], 0.0) / self.peak):
            side = along + np.pi * (guide.SIDES[k, 1] < 0)
            angle = side if self.joint.prismatic else np.arctan2(*self.journal[i, k, ::-1])
            if share > LEAST:
                found.append((k, float(angle), float(share)))
        return found


def spread(times: np.ndarray, count: int) -> np.ndarray:
    """Return the samples nearest to so many times, evenly spread over all."""
    wanted = np.linspace(times[0], times[-1], count)
    after = np.clip(np.searchsorted(times, wanted), 1, times.size - 1)
    return after - (wanted - times[after - 1] < times[after] - wanted)


def scene(mechanism: Mechanism, motion: Dataset, joint: str | None, turns=None, time=None) -> Scene:
    """Choose the joints that are enlarged and the window that is shown: by default around an impact."""
    loose = {each.name: each for each in mechanism.clearance_joints}
    if joint is not None:
        loose = {joint: loose[select.choice("joint", joint, loose)]}
    part, hit = timebase.window(motion, turns, time), None
    if turns is None and time is None and part.sizes["time"]:
        hit = hardest(motion, list(loose.values()))
        part = turn_around(motion, hit.time if hit else float(motion["time"][-1]))
    if part.sizes["time"] < 2:
        raise select.refuse("motion", f"{part.sizes['time']} samples", "a motion with two samples or more")
    return Scene(mechanism, part, list(loose.values())[:MOST], hit)
