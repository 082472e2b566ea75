"""Drives of a linkage: a motor, a torque, a constant speed, a profile or cycle of speeds (or a servo).

A drive's `kind` is what the structure of the equations calls it; its `numbers` are their parameters.

A servo: a controller whose torque makes a link follow an angle over time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal, Self, get_args

from pydantic import Field, ValidationInfo, field_validator, model_validator

from jointplay.display.errors import NOTHING, Problem, join, raise_any, refuse
from jointplay.display.number_text import measure, plain
from jointplay.solver.equations.drives import NAMES
from jointplay.solver.equations.own.grammar import CONSTANTS, FUNCTIONS, is_name
from jointplay.solver.equations.structure import Course as Structure
from jointplay.solver.mechanism.base import (
    Flag,
    Fraction,
    Name,
    NonNegative,
    Number,
    Positive,
    Record,
    hash_of,
    measured,
    named,
)
from jointplay.solver.mechanism.own.own_parts import Text
from jointplay.solver.mechanism.own.well_posed import wrong_text
from jointplay.solver.mechanism.parts.courses import Course


class Servo(Course):
    """A controller that makes a link's angle θ follow a wanted one φ, T = K_p (φ − θ) + K_d (φ' − θ') + T_f.

    Time counts from the start of a run, and the angle from the link's zero, whole turns too.

    Parameters
    ----------
    link : str
        The driven link.
    stiffness : float
        K_p, the torque over the difference of the angles, N m/rad.
    damping : float
        K_d, the torque over the difference of the angular velocities, N m s/rad.
    speed : float
        Mean wanted speed, rad/s: φ is this times the time, and what follows.
    constant, harmonics, table, tolerance, factor
        An angle over the phase ν t, rad: see `Course`.
    frequency : float
        ν, rad/s; beside harmonics or a table.
    feedforward : str
        T_f, N m: an expression of the time ``t``, the link's ``angle`` and ``angular_velocity``, of
        ``wanted_angle``, ``wanted_velocity`` and ``wanted_acceleration``, and of `where`. Left out: 0.
    where : dict of str to str
        Expressions by name, each of the same and those before it.
    nominal_speed : float
        Speed by which turns are counted beforehand, rad/s; not 0.
    """

    root: ClassVar[str | None] = "drive"
    units: ClassVar[str] = "rad"
    phases: ClassVar[tuple[str, ...]] = ("frequency",)
    imposed_speed: ClassVar[None] = None
    transient: ClassVar[bool] = True
    kind: Literal["servo"] = "servo"
    link: Name = named("link name")
    stiffness: Positive = measured("stiffness", "N m/rad")
    damping: NonNegative = measured("damping", "N m s/rad")
    speed: Number = measured("mean wanted speed", "rad/s", 0.0)
    constant: Number = measured("constant part of the angle", "rad", 0.0)
    frequency: Positive | None = measured("angular frequency", "rad/s", None)
    feedforward: Text | None = None
    where: dict[Name, Text] = Field(
        default={}, json_schema_extra={"accepts": "a table of expressions by name,"}
    )
    nominal_speed: Number = measured("nominal speed", "rad/s")

    def __hash__(self) -> int:
        return hash_of(self)

    @model_validator(mode="after")
    def _sound(self) -> Self:
        problems = [*self._wrong_texts()]
        if not self.nominal_speed:
            accepted = "a finite speed in rad/s other than 0 is accepted"
            problems.append(Problem("nominal_speed", self.nominal_speed, accepted))
        raise_any(problems)
        return self

    def _forms(self) -> Iterator[Problem]:
        """Problems of the course, which may be nothing but 0 here."""
        yield from (problem for problem in super()._forms() if problem.key != "constant")

    def _wrong_texts(self) -> Iterator[Problem]:
        known = [*NAMES, *CONSTANTS]
        for name in self.where:
            if not is_name(name) or name in {*NAMES, *CONSTANTS, *FUNCTIONS}:
                accepted = "a name of letters a to z, digits and _ is accepted, a letter first, and none that"
                yield Problem(join("where", name), name, f"{accepted} has a meaning already")
        for name, text in self.fed:
            key = join("where", name) if name else "feedforward"
            yield from wrong_text(key, text, known, kinks=False)
            known.append(name)

    @property
    def fed(self) -> tuple[tuple[str, str], ...]:
        """Expressions that are fed forward: the terms of `where`, and the torque, without one."""
        torque = () if self.feedforward is None else (("", self.feedforward),)
        return (*self.where.items(), *torque) if torque else ()

    @property
    def start_speed(self) -> float:
        """The wanted speed at the start, with which a run begins, rad/s."""
        turning = sum(n * b for n, _, b in self.terms.harmonics) * (self.frequency or 0.0)
        return self.speed + self.factor * turning

    @property
    def structure(self) -> Structure:
        """Structure of its course in the equations."""
        return self.course("drive", timed=self.varies)

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        gains = {"K_p": self.stiffness, "K_d": self.damping, "W": self.speed}
        return self.course_numbers("drive") | gains | {"nu_drive": self.frequency or 0.0}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        more = ", and a torque fed forward" if self.feedforward else ""
        varies = f" and {self.course_description}" if self.varies else ""
        wanted = f"{measure(self.speed, 'rad/s', 6)}{varies}"
        return f"servo on {self.link} to {wanted}, {measure(self.stiffness, 'N m/rad')}{more}"


class MotorLine(Record):
    """A geared motor whose torque on the link falls in a straight line with the link's speed ω: T = a − b ω.

    Chunmei et al. (2002), equations (1) and (2): a = i μ T_r ω_s/(ω_s − ω_r), b = i² T_r/(ω_s − ω_r).

    Parameters
    ----------
    link : str
        The driven link.
    gear_ratio : float
        i, motor speed over link speed.
    efficiency : float
        μ of the gear, above 0 and at most 1.
    synchronous_speed : float
        ω_s of the motor, without load, rad/s.
    rated_speed : float
        ω_r of the motor at its rated torque, rad/s; less than the synchronous speed.
    rated_torque : float
        T_r of the motor at its rated speed, N m.
    efficiency_in_slope : bool
        True: μ multiplies b as well, which the printed equation leaves out.
    """

    imposed_speed: ClassVar[None] = None
    structure: ClassVar[None] = None
    transient: ClassVar[bool] = False
    kind: Literal["motor"] = "motor"
    link: Name = named("link name")
    gear_ratio: Positive = measured("gear ratio", "1")
    efficiency: Fraction = measured("gear efficiency", "1")
    synchronous_speed: Positive = measured("synchronous motor speed", "rad/s")
    rated_speed: Positive = measured("rated motor speed", "rad/s")
    rated_torque: Positive = measured("rated motor torque", "N m")
    efficiency_in_slope: Flag = False

    @field_validator("rated_speed")
    @classmethod
    def _below_synchronous(cls, rated: float, info: ValidationInfo) -> float:
        synchronous = info.data.get("synchronous_speed")
        if synchronous is not None and rated >= synchronous:
            limit = f"greater than 0 and less than the synchronous {synchronous:g} rad/s"
            raise refuse(rated, f"a rated motor speed {limit} is accepted")
        return rated

    @model_validator(mode="after")
    def _a_line_of_finite_numbers(self) -> Self:
        line = (self.stall_torque, self.slope)
        if not all(0 < number < math.inf for number in line) or not 0 < self.no_load_speed < math.inf:
            given = {name: getattr(self, name) for name in ("gear_ratio", "efficiency", "rated_torque")}
            raise refuse(given, "numbers that give a finite torque and slope other than 0 are accepted")
        return self

    @property
    def stall_torque(self) -> float:
        """Torque a on the link at rest, N m."""
        slip = self.synchronous_speed - self.rated_speed
        return self.gear_ratio * self.efficiency * self.rated_torque * self.synchronous_speed / slip

    @property
    def slope(self) -> float:
        """Loss of torque with speed b, N m s."""
        slip = self.synchronous_speed - self.rated_speed
        factor = self.efficiency if self.efficiency_in_slope else 1.0
        return factor * self.gear_ratio * self.gear_ratio * self.rated_torque / slip

    @property
    def no_load_speed(self) -> float:
        """Speed a/b of the link at which the torque is 0, rad/s."""
        return self.stall_torque / self.slope

    nominal_speed = start_speed = no_load_speed  # by which turns are counted beforehand

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return {"a": self.stall_torque, "b": self.slope}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        free = f"{measure(self.no_load_speed, 'rad/s', 6)} without load"
        return f"motor, gear ratio {plain(self.gear_ratio)}, {self.link} at {free}"


def _turns(speed: float) -> float:
    if speed == 0:
        raise refuse(speed, "a finite speed in rad/s other than 0 is accepted")
    return speed


class ConstantSpeed(Record):
    """A constant angular velocity of a link, whatever torque that takes.

    Parameters
    ----------
    link : str
        The driven link.
    speed : float
        Angular velocity, rad/s; not 0, positive turns anticlockwise.
    """

    structure: ClassVar[None] = None
    transient: ClassVar[bool] = False
    kind: Literal["speed"] = "speed"
    link: Name = named("link name")
    speed: Number = measured("speed", "rad/s")

    _turns = field_validator("speed")(_turns)

    @property
    def nominal_speed(self) -> float:
        """Speed by which turns are counted beforehand, rad/s."""
        return self.speed

    imposed_speed = start_speed = nominal_speed

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return {"Omega": self.speed, "theta_0": angle}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        return f"{self.link} at {measure(self.speed, 'rad/s', 6)}"


class PrescribedTorque(Course):
    """A torque on a link that is constant or varies with the link's own angle.

    Parameters
    ----------
    link : str
        The driven link.
    constant, harmonics, table, tolerance, factor
        The torque over the link's angle, N m: see `Course`.
    nominal_speed : float
        Speed by which turns are counted beforehand and at which a run starts unless it says otherwise, rad/s;
        not 0, positive turns anticlockwise.
    """

    root: ClassVar[str | None] = "drive"
    imposed_speed: ClassVar[None] = None
    transient: ClassVar[bool] = False
    constant: Number = measured("constant part", "N m", 0.0)
    kind: Literal["torque"] = "torque"
    link: Name = named("link name")
    nominal_speed: Number = measured("nominal speed", "rad/s")

    _turns = field_validator("nominal_speed")(_turns)

    @property
    def start_speed(self) -> float:
        """Speed at which a run starts, rad/s."""
        return self.nominal_speed

    @property
    def structure(self) -> Structure:
        """Structure of its course in the equations."""
        return self.course("drive", link=self.link)

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return self.course_numbers("drive")

    @property
    def description(self) -> str:
        """The drive in a few words."""
        return f"torque on {self.link}, {self.course_description}{' over its angle' * self.varies}"


class SpeedProfile(Record):
    """A smooth change of a link's speed from one value to another in a given time, whatever torque it takes.

    The speed is ω₀ + (ω₁ − ω₀) S(t/T), S(x) = 35 x⁴ − 84 x⁵ + 70 x⁶ − 20 x⁷, and ω₁ from T on: speed,
    acceleration and its first two derivatives are continuous. Time counts from the start of a run.

    Parameters
    ----------
    link : str
        The driven link.
    start, end : float
        ω₀ and ω₁, rad/s; positive turns anticlockwise, and not both 0. Turns are counted by the faster.
    time : float
        T, s.
    """

    root: ClassVar[str | None] = "drive"
    structure: ClassVar[None] = None
    transient: ClassVar[bool] = True
    kind: Literal["profile"] = "profile"
    link: Name = named("link name")
    start: Number = measured("speed at the start", "rad/s")
    end: Number = measured("speed at the end", "rad/s")
    time: Positive = measured("duration", "s")

    @field_validator("end")
    @classmethod
    def _turns_at_all(cls, end: float, info: ValidationInfo) -> float:
        if end == 0 and info.data.get("start") == 0:
            raise refuse(end, "a finite speed in rad/s other than 0 is accepted where start is 0")
        return end

    @property
    def nominal_speed(self) -> float:
        """Speed by which turns are counted beforehand, rad/s."""
        return max(self.end, self.start, key=abs)

    @property
    def start_speed(self) -> float:
        """Speed at which a run starts, rad/s."""
        return self.start

    imposed_speed = start_speed

    def travel(self, time: float) -> float:
        """Angle that the link turns through from the start of a run until a time (s), rad."""
        x = min(1.0, time / self.time)
        risen = x**5 * (7 - 14 * x + 10 * x**2 - 2.5 * x**3)  # the integral of S
        change = (self.end - self.start) * self.time
        return self.start * time + change * risen + (self.end - self.start) * max(0.0, time - self.time)

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return {"w_0": self.start, "w_1": self.end, "T": self.time}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        first, last = (measure(each, "rad/s", 6) for each in (self.start, self.end))
        return f"{self.link} from {first} to {last} in {measure(self.time, 's')}"


class SpeedCycle(Course):
    """A speed of a link that varies with time, the same in every period, whatever torque it takes.

    Parameters
    ----------
    link : str
        The driven link.
    constant, harmonics, table, tolerance, factor
        The speed over the phase ν t, rad/s: see `Course`. Its mean is not 0, and turns are counted by it.
    frequency : float
        ν, rad/s: a period lasts 2π/ν, the first from the start of a run.
    """

    root: ClassVar[str | None] = "drive"
    units: ClassVar[str] = "rad/s"
    transient: ClassVar[bool] = True
    kind: Literal["cycle"] = "cycle"
    link: Name = named("link name")
    constant: Number = measured("constant part of the speed", "rad/s", 0.0)
    frequency: Positive = measured("angular frequency", "rad/s")

    @model_validator(mode="after")
    def _goes_round(self) -> Self:
        if not self.varies:
            raise refuse(NOTHING, "harmonics or a table of the speed are needed", "table")
        if not self.nominal_speed:
            raise refuse(self.nominal_speed, "a mean speed other than 0 rad/s is accepted", "constant")
        return self

    @property
    def nominal_speed(self) -> float:
        """Speed by which turns are counted beforehand, rad/s."""
        return self.factor * self.terms.mean

    @property
    def start_speed(self) -> float:
        """Speed at which a run starts, rad/s."""
        return self.factor * (self.terms.mean + sum(a for _, a, _ in self.terms.harmonics))

    imposed_speed = start_speed

    @property
    def structure(self) -> Structure:
        """Structure of its course in the equations."""
        return self.course("drive", timed=True)

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return self.course_numbers("drive") | {"nu_drive": self.frequency}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        return f"{self.link} at {self.course_description}, repeated at {measure(self.frequency, 'rad/s')}"


AnyDrive = MotorLine | ConstantSpeed | PrescribedTorque | SpeedCycle | SpeedProfile | Servo


DRIVES: tuple[type[AnyDrive], ...] = get_args(AnyDrive)


Drive = Annotated[AnyDrive, Field(discriminator="kind")]
