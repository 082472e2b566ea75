"""A servo: a controller whose torque makes a link follow an angle over time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from jointplay.display.errors import InputError, Problem, join, unknown
from jointplay.display.units import measure
from jointplay.solver.equations.drives import NAMES
from jointplay.solver.equations.own.grammar import (
    CONSTANTS,
    FUNCTIONS,
    Tree,
    is_name,
    parse,
    plainly_real,
    too_large,
)
from jointplay.solver.equations.structure import Course as Structure
from jointplay.solver.mechanism.base import Name, NonNegative, Number, Positive, hash_of, measured, named
from jointplay.solver.mechanism.own.own_parts import Text
from jointplay.solver.mechanism.parts.courses import Course

KINKED = {"abs", "sign", "max", "min"}


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
        if problems:
            raise InputError(problems)
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
            try:
                tree = parse(text)
            except InputError as error:
                yield from error.under(key).problems
                continue
            if large := too_large(text):
                yield Problem(key, text, large)
                continue
            if not plainly_real(tree):
                yield from _unreal(key, text)
            for other in sorted(tree.names - {*known}):
                yield unknown(key, text, other, known, f"name as {other!r}")
            for kinked in sorted(_operations(tree) & KINKED):
                yield Problem(key, text, f"an expression without kinks is accepted, and {kinked} has one")
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
        """Its structure in the equations."""
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


def _unreal(key: str, text: str) -> Iterator[Problem]:
    from jointplay.solver.equations.own.own import checked

    try:
        checked(text, kinks=False)
    except InputError as error:
        yield from error.under(key).problems


def _operations(tree: Tree) -> set[str]:
    return {tree.operation}.union(*map(_operations, tree.parts))
