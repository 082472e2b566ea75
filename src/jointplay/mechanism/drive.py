"""What drives a linkage: a motor's torque line, or a constant speed.

A drive's `kind` is what the structure of the equations calls it; its `numbers` are their parameters.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, Self, get_args

from pydantic import Field, ValidationInfo, field_validator, model_validator

from jointplay.errors import refuse
from jointplay.mechanism.base import Flag, Fraction, Name, Number, Positive, Record, measured, named


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
    synchronous_speed, rated_speed : float
        ω_s and ω_r of the motor, rad/s; rated below synchronous.
    rated_torque : float
        T_r of the motor at its rated speed, N m.
    efficiency_in_slope : bool
        True: μ multiplies b as well, which the printed equation leaves out.
    """

    imposed_speed: ClassVar[None] = None
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

    nominal_speed = no_load_speed  # by which turns are counted beforehand

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return {"a": self.stall_torque, "b": self.slope}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        ratio = f"motor, gear ratio {self.gear_ratio:g}"
        return f"{ratio} on {self.link}, no load at {self.no_load_speed:.6g} rad/s"


class ConstantSpeed(Record):
    """A constant angular velocity of a link, whatever torque that takes.

    Parameters
    ----------
    link : str
        The driven link.
    speed : float
        Angular velocity, rad/s; not 0, positive turns anticlockwise.
    """

    kind: Literal["speed"] = "speed"
    link: Name = named("link name")
    speed: Number = measured("speed", "rad/s")

    @field_validator("speed")
    @classmethod
    def _turns(cls, speed: float) -> float:
        if speed == 0:
            raise refuse(speed, "a finite speed in rad/s other than 0 is accepted")
        return speed

    @property
    def nominal_speed(self) -> float:
        """Speed by which turns are counted beforehand, rad/s."""
        return self.speed

    imposed_speed = nominal_speed

    def numbers(self, angle: float) -> dict[str, float]:
        """Parameters of the equations, where the link starts at an angle (rad)."""
        return {"Omega": self.speed, "theta_0": angle}

    @property
    def description(self) -> str:
        """The drive in a few words."""
        return f"{self.link} at {self.speed:g} rad/s"


AnyDrive = MotorLine | ConstantSpeed
DRIVES: tuple[type[AnyDrive], ...] = get_args(AnyDrive)
Drive = Annotated[AnyDrive, Field(discriminator="kind")]
