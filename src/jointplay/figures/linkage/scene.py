"""A mechanism in motion, sample by sample: its pose, a journal in its bearing, the force between them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from xarray import Dataset

from jointplay.display.units import measure
from jointplay.figures.drawing import select, timebase
from jointplay.figures.linkage.linkage import Sketch
from jointplay.mechanism.joints import Joint
from jointplay.mechanism.pose import Pose
from jointplay.mechanism.records import Mechanism

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
    joint : Joint or None
        The joint with clearance that is enlarged; None where there is none.
    """

    mechanism: Mechanism
    motion: Dataset
    joint: Joint | None

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
        """Where the links are."""
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
                label = (*joint.contacts, joint.name)[0]  # with play its corners slide as it does
                way = self.motion["slide_position"].sel(joint=label).values
                slides[joint.name] = (float(way.min()), float(way.max()))
        return Sketch(self.mechanism, MM, slides)

    @cached_property
    def journal(self) -> np.ndarray:
        """The journal's centre in its bearing, in clearances, shape (time, 2)."""
        ways = [self.motion[f"journal_{axis}"].sel(joint=self.joint.name).values for axis in "xy"]
        return np.stack(ways, -1) / self.joint.clearance

    @cached_property
    def contact(self) -> np.ndarray:
        """Whether the journal feels the bearing; always, where modes were not recorded."""
        found = select.in_contact(self.motion, self.joint.name)
        return np.ones(self.times.size, dtype=bool) if found is None else found

    @cached_property
    def force(self) -> np.ndarray | None:
        """The normal force on the bearing, N; None where it was not recorded."""
        if self.joint is None or "normal_force" not in self.motion:
            return None
        return self.motion["normal_force"].sel(joint=self.joint.name).values

    @cached_property
    def peak(self) -> float:
        """The largest force, N."""
        return float(np.max(np.abs(self.force), initial=1e-300))

    def title(self, i: int) -> str:
        """Angle of the driven link, and time."""
        crank = self.mechanism.crank
        angle = float(np.rad2deg(self.pose(i).angles[crank])) % 360 if crank else 0.0
        return (
            f"{crank} {angle:.0f}°, {measure(self.times[i], 's')}" if crank else measure(self.times[i], "s")
        )


def spread(times: np.ndarray, count: int) -> np.ndarray:
    """Return the samples nearest to so many times, evenly spread over all."""
    wanted = np.linspace(times[0], times[-1], count)
    after = np.clip(np.searchsorted(times, wanted), 1, times.size - 1)
    return after - (wanted - times[after - 1] < times[after] - wanted)


def scene(mechanism: Mechanism, motion: Dataset, joint: str | None, turns=None, time=None) -> Scene:
    """Choose the bearing that is enlarged and the window that is shown."""
    loose = {each.name: each for each in mechanism.clearance_joints if not each.prismatic}
    if joint is not None:
        select.choice("joint", joint, loose)
    part = timebase.window(motion, turns, time)
    if part.sizes["time"] < 2:
        raise select.refuse("motion", f"{part.sizes['time']} samples", "a motion with two samples or more")
    chosen = loose.get(joint or next(iter(loose), ""))
    return Scene(mechanism, part, chosen)
