"""A linkage: chains, elastic links, contacts, friction, loops and drive put together as one system.

Loads: forces at points of links and torques on links, that vary with time or with an angle.

    f = f_0 + sum_n (a_n cos n phi + b_n sin n phi),    phi = nu t, or a link's angle,

on a force's point P along a unit vector d, fixed or turning with the link: Q_z = f d.dP/dz, power f d.P'; on
a link's angle: Q = f, power f w. Sines of multiples follow from sin phi and cos phi by addition. Source:
virtual work.

Springs with dampers between two points, or between the angles of two links.

With the stretch s, which is L - L_0 for the distance L = |r| of the points, or theta_p - theta_q - theta_0,

    F = k s + c s',     V = k s^2 / 2,     Q_z = -F ds/dz,     power taken in by the damper c s'^2.

Source: virtual work. Assumptions: no mass; linear in the stretch, pulling and pushing. Where the two points
meet, their line has no direction and the spring no force on that line: TINY keeps the division finite there.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr, Float, Integer, Symbol, cos, sin, sqrt

from . import beam as elastic
from . import chain, play
from .contact import Geometry, corner_geometry, geometry
from .coordinates import Coordinates, Freedom, coordinates, dot
from .drives import DRIVES, NAMES, WANTED
from .loops import loop, vectors
from .loops.vectors import ZERO, Vector, Vectors, cross
from .own import own
from .parameters import parameter_names
from .structure import Clearance, Closure, Course, Linkage, Load, Pin, Slide, Spring
from .system import TIME, Angle, Contact, System, number, traction

TINY = Float(1e-200)


@dataclass(frozen=True)
class Action:
    """An action on a linkage: `amount` times `column` on the freedoms, `pulls` on the bodies of links.

    `energy` is what it stores, `lost` the power that it takes in, `power` the power that it brings.
    """

    amount: Expr
    column: dict[Freedom, Expr]
    pulls: tuple[tuple[str, vectors.Vector], ...] = ()
    energy: Expr = Integer(0)
    lost: Expr = Integer(0)
    power: Expr = Integer(0)


def system(structure: Linkage) -> System:
    """Write the equations of motion of a linkage."""
    return Parts(structure).system


@dataclass(frozen=True)
class Parts:
    """Parts that the equations of a linkage are put together from."""

    structure: Linkage

    @property
    def system(self) -> System:
        """The equations."""
        structure, c, outputs = self.structure, self.c, dict(self._outputs())
        drive = DRIVES[structure.drive]
        mass, force = c.mass(self.inertia), list(c.force(self.force, self.inertia))
        imposed = dict(c.imposed)
        if structure.held:  # the crank: an unknown whose acceleration is none
            (crank,) = (i for i, _ in c.parts[structure.driven])
            mass, imposed[crank] = {pair: m for pair, m in mass.items() if crank not in pair}, Integer(0)
        mass |= {(i, i): Integer(1) for i, speed in enumerate(c.speeds) if speed in self.memories}
        for place, acceleration in imposed.items():
            mass[place, place], force[place] = Integer(1), acceleration + loop.watched(structure, c)
        return System(
            positions=tuple(c.positions),
            speeds=tuple(c.speeds),
            parameters=tuple(map(number, parameter_names(structure))),
            definitions=tuple(c.definitions) + play.definitions(self.joints.values()),
            mass=mass,
            force=tuple(force),
            angles=(*(angle for angle in c.angle.values() if isinstance(angle, Angle)), *self._phases()),
            contacts=self.contacts,
            resets=tuple(
                play.wall(joint, self.joints[joint.name], c, self._drawing)
                for joint in structure.rigid_joints
            ),
            folds=tuple(c.folds),
            powers=self._powers(outputs) if structure.powers else {},
            outputs=outputs,
            section=outputs[structure.section] if structure.section else None,
            roots=tuple(c.roots),
            imposed=imposed,
            draws=self._draws(),
            answering=tuple(map(number, drive.letters)) if drive.torque else (),
        )

    @cached_property
    def c(self) -> Coordinates:
        """The freedoms."""
        found, course = coordinates(self.structure), self.structure.course
        if course and DRIVES[self.structure.drive].imposed:
            found.impose(self.structure.driven, derivatives(course, found, 1)[1])
        loop.complete(self.structure, found)
        return found

    @cached_property
    def joints(self) -> dict[str, Geometry]:
        """Geometry of the joints with play."""
        pairs = ((joint, corner_geometry if joint.corner else geometry) for joint in self.structure.joints)
        return {joint.name: of(joint, self.c, self.structure.driven) for joint, of in pairs}

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """Laws of the joints with play."""
        soft = self.structure.soft_joints
        return tuple(play.contact(joint, self.joints[joint.name], self.c) for joint in soft)

    @cached_property
    def memories(self) -> set[Symbol]:
        """Speeds that no freedom has: laws remember them."""
        return {symbol for contact in self.contacts for symbol in contact.entry}

    @cached_property
    def inertia(self) -> dict[tuple[Freedom, Freedom], Expr]:
        """Mass matrix over all freedoms, each pair once."""
        found: dict[tuple[Freedom, Freedom], Expr] = defaultdict(lambda: Integer(0))
        for k, m, entry in chain.inertia(self.structure, self.c):
            found[k, m] += entry
        for beam in self.structure.beams:
            for k, m, entry in elastic.inertia(self.structure, beam, self.c):
                found[k, m] += entry
        return dict(found)

    @cached_property
    def force(self) -> dict[Freedom, Expr]:
        """Forces on all freedoms, contacts and the outcome of a prescribed speed left out."""
        structure, driven = self.structure, self.structure.driven
        found: dict[Freedom, Expr] = defaultdict(lambda: Integer(0))
        for freedom, value in chain.force(structure, self.c):
            found[freedom] += value
        for beam in structure.beams if not structure.relaxed else ():
            for freedom, value in elastic.force(structure, beam, self.c):
                found[freedom] += value
        found[driven] += self._law_torque
        for each in (*self.springs, *self.loads):
            for freedom, entry in each.column.items():
                found[freedom] += each.amount * entry
        return dict(found)

    @cached_property
    def springs(self) -> tuple[Action, ...]:
        """Actions of the springs."""
        return tuple(spring_action(spring, self.c) for spring in self.structure.springs)

    @cached_property
    def loads(self) -> tuple[Action, ...]:
        """Actions of the loads."""
        return tuple(load_action(load, self.c) for load in self.structure.loads)

    def _phases(self) -> Iterator[Angle]:
        """Phases of the courses that vary with time."""
        courses = (*(load.course for load in self.structure.loads), self.structure.course)
        yield from (phase(course) for course in courses if course and course.timed)

    @cached_property
    def _law_torque(self) -> Expr:
        """Torque of the drive on the crank where it is a law; 0 where it is an outcome."""
        structure, law, w = self.structure, DRIVES[self.structure.drive], self.c.speed[self.structure.driven]
        if law.follows:
            return self.c.let("servo", _servo(structure, self.c))
        if structure.course and not law.imposed:
            return course_value(structure.course, self.c)
        return law.torque(w, *map(number, law.letters)) if law.torque else Integer(0)

    def residual(self, freedom: Freedom) -> Expr:
        """Inertia less applied forces on a freedom, contacts left out: the force due to joints or a drive."""
        total = -self.force.get(freedom, Integer(0))
        for (k, m), entry in self.inertia.items():
            if freedom in (k, m):
                total += entry * self.c.acceleration[m if freedom == k else k]
        return total

    def _needed(self, freedom: Freedom) -> Expr:
        """Force that ideal joints or a drive must supply on a freedom: residual, and push of contacts."""
        total = self.residual(freedom)
        for name, (F_n, F_t) in self._tractions.items():
            g = self.joints[name]
            total += g.pushed.get(freedom, Integer(0)) * F_n + g.spun.get(freedom, Integer(0)) * F_t
        return total

    @cached_property
    def _tractions(self) -> dict[str, Vector]:
        """Normal and tangential force of the joints with play; of a rigid one the holding force."""
        found = {contact.name: traction(contact) for contact in self.contacts}
        rigid = self.structure.rigid_joints
        return found | {joint.name: play.held(joint, self.joints[joint.name], rigid) for joint in rigid}

    @cached_property
    def _cut_joints(self) -> list[tuple[Clearance | Closure, Vector]]:
        """Joints where the chains are cut, with the force on the bearing; of closures the last one first."""
        found = []
        for joint in self.structure.joints:
            (F_n, F_t), g = self._tractions[joint.name], self.joints[joint.name]
            pairs = zip(g.direction, g.across, strict=True)
            found.append((joint, tuple(F_n * n + F_t * t for n, t in pairs)))
        for closures in reversed(self.structure.loops):
            forces = self._closing_forces(closures, found[len(self.structure.joints) :])
            found += zip(closures, forces, strict=True)
        return found

    def _closing_forces(self, closures: tuple[Closure, ...], later: list) -> list[Vector]:
        needed = {}
        for unknown in closures[0].unknowns:
            ratios = ((k, tree[unknown]) for k, tree in self.c.tree.items() if unknown in tree)
            needed[unknown] = sum((ratio * self._needed(k) for k, ratio in ratios), Integer(0))
            for other, F in later:
                column = self._vectors(other).columns().get(unknown, ZERO)
                needed[unknown] += dot(column, F)
        return loop.closing_forces([self._vectors(closure) for closure in closures], needed)

    def _vectors(self, joint: Slide | Closure) -> Vectors:
        return Vectors(self.structure, self.c, joint)

    def _powers(self, outputs: dict[str, Expr]) -> dict[str, Expr]:
        """Powers whose integrals close the energy balance: drive, joints, elastic links, springs, loads."""
        joints = Integer(0)
        for joint in self.structure.joints:
            joints += outputs[f"normal_force:{joint.name}"] * outputs[f"normal_velocity:{joint.name}"]
            joints += outputs[f"tangential_force:{joint.name}"] * outputs[f"tangential_velocity:{joint.name}"]
        powers = {"drive": outputs["drive_torque"] * self.c.speed[self.structure.driven], "joints": joints}
        if self.structure.beams:
            damped = [beam for beam in self.structure.beams if beam.damped]
            lost = (elastic.dissipated_power(beam, self.c) for beam in damped)
            powers["links"] = sum(lost, Integer(0))
        if self.springs:
            powers["springs"] = sum((each.lost for each in self.springs), Integer(0))
        if self.loads:
            powers["loads"] = sum((each.power for each in self.loads), Integer(0))
        return powers

    @property
    def _drawing(self) -> Expr:
        """Speed of a drive whose impulses do work that is wanted; else 0."""
        imposes = self.structure.powers and DRIVES[self.structure.drive].imposed
        return self.c.speed[self.structure.driven] if imposes else Integer(0)

    def _draws(self) -> tuple[Expr, ...]:
        """Work of the drive per change of each unknown speed: its speed times the inertia between both."""
        c, found = self.c, [Integer(0)] * len(self.c.speeds)
        for (k, m), entry in self.inertia.items() if self._drawing != 0 else ():
            for one, other in {(k, m), (m, k)}:
                ratio = c.leads[one].get(self.structure.driven, Integer(0))
                for i, part in c.parts[other]:
                    found[i] += self._drawing * ratio * entry * part
        return tuple(found)

    def _outputs(self) -> Iterator[tuple[str, Expr]]:
        """Every quantity that can be recorded, as word:label."""
        structure, c = self.structure, self.c
        for k in structure.links:
            yield f"angle:{k}", c.angle[k].value
            yield f"angular_velocity:{k}", c.speed[k]
            yield f"angular_acceleration:{k}", c.acceleration[k]
        stored = {contact.name: contact.stored for contact in self.contacts}
        for joint in structure.joints:
            kept, name = stored.get(joint.name, Integer(0)), joint.name
            yield from play.outputs(joint, self.joints[name], self._tractions[name], kept)
        reactions = dict(self._reactions())
        for name, force in reactions.items():
            yield f"reaction_x:{name}", force[0]
            yield f"reaction_y:{name}", force[1]
            yield f"reaction:{name}", sqrt(force[0] ** 2 + force[1] ** 2)
        yield from self._slides(reactions)
        yield "drive_torque", self._drive_torque()
        if structure.relaxed:
            yield from self._modal_loads()
            return
        yield from self._energies()
        if structure.beams:
            yield from elastic.deflections(self.structure, self.c)

    def _energies(self) -> Iterator[tuple[str, Expr]]:
        structure, c = self.structure, self.c
        kinetic, potential = c.kinetic_energy(chain.inertia(structure, c)), Integer(0)
        if structure.gravity:
            potential += chain.potential_energy(structure, c)
        for beam in structure.beams:
            kinetic += c.kinetic_energy(elastic.inertia(structure, beam, c))
            potential += elastic.weight_energy(structure, beam, c) if structure.gravity else Integer(0)
        strain = sum((elastic.strain_energy(beam, c) for beam in structure.beams), Integer(0))
        strain += sum((each.energy for each in self.springs), Integer(0))
        yield "kinetic_energy", kinetic
        yield "potential_energy", potential + strain
        yield "strain_energy", strain

    def _modal_loads(self) -> Iterator[tuple[str, Expr]]:
        """Load on each mode of links whose modes are given: inertia, gravity, friction's end moments."""
        for beam in self.structure.beams:
            excited = dict(elastic.excitation(self.structure, beam, self.c))
            for mode in elastic.modes(beam):
                load = excited[mode]
                for (k, m), entry in self.inertia.items():
                    if k == mode and m != mode:
                        load -= entry * self.c.acceleration[m]
                for name, g in self.joints.items():
                    load -= g.spun.get(mode, Integer(0)) * self._tractions[name][1]
                yield f"modal_load:{beam.link}_{mode[1]}", load

    def _drive_torque(self) -> Expr:
        """The torque of the motor's law, or the torque that a prescribed speed costs."""
        c, driven = self.c, self.structure.driven
        if not DRIVES[self.structure.drive].imposed:
            return self._law_torque
        led = ((lead[driven], self.residual(k)) for k, lead in c.leads.items() if driven in lead)
        total = sum((ratio * residual for ratio, residual in led), Integer(0))
        for name, g in self.joints.items():
            (F_n, F_t), (N, T) = self._tractions[name], g.on_drive
            total += N * F_n + T * F_t
        return total

    def _reactions(self) -> Iterator[tuple[str, Vector]]:
        """Force on the bearing of every ideal joint."""
        for pin in self.structure.pins:
            yield pin.name, (self._reaction(pin, 0), self._reaction(pin, 1))
        yield from ((cut.name, F) for cut, F in self._cut_joints if isinstance(cut, Closure))

    def _slides(self, forces: dict[str, Vector]) -> Iterator[tuple[str, Expr]]:
        """Positions and speeds of sliding links, and moments on their guides about the journal's point."""
        c, cut = self.c, {one.name: F for one, F in self._cut_joints}
        closing = [(self._vectors(closure), cut[closure.name]) for closure in self.structure.closures]
        for slide in self.structure.slides:
            needed = loop.moment(self.structure, slide, c, self._needed, closing)
            d, s = c.e(slide.freedom), c.position[slide.freedom]
            # needed on the outer link about its base: the journal's point, or the bearing's
            moment = -needed if slide.sign > 0 else needed - s * cross(d, forces[slide.name])
            yield f"slide_position:{slide.name}", s
            yield f"slide_velocity:{slide.name}", c.speed[slide.freedom]
            yield f"reaction_moment:{slide.name}", moment

    def _reaction(self, pin: Pin, axis: int) -> Expr:
        """Momentum rate beyond a pin, less the forces at the cut joints that act there."""
        structure = self.structure
        total = chain.beyond(structure, pin, self.c, axis)
        for beam in structure.beams:
            if beam.link in pin.links:
                total += elastic.momentum_rate(structure, beam, self.c, axis)
        for joint, force in self._cut_joints:
            total += force[axis] * ((joint.journal in pin.links) - (joint.bearing in pin.links))
        for each in (*self.springs, *self.loads):
            total -= sum((force[axis] for link, force in each.pulls if link in pin.links), Integer(0))
        return pin.sign * total


def _servo(structure: Linkage, c: Coordinates) -> Expr:
    """The torque of a controller that makes the driven link follow an angle over time.

        T = K_p (phi - theta) + K_d (phi' - w) + T_f(t, theta, w, phi, phi', phi''),      phi = W t + f(nu t),

    with a course f. T_f is fed forward, given as text: with what a model of the mechanism
    needs for the wanted motion the whole is a computed torque. Reference: Slotine and Li, Applied Nonlinear
    Control (1991), chapters 6 and 9. Assumption: the controller acts at once and without limit.
    """
    angle, speed, W = c.angle[structure.driven], c.speed[structure.driven], number("W")
    value, slope, bend = derivatives(structure.course, c, 2)
    wanted = [
        c.let(name, each) for name, each in zip(WANTED, (W * TIME + value, W + slope, bend), strict=True)
    ]
    names = dict(zip(NAMES, (TIME, angle.value, speed, *wanted), strict=True))
    known = {
        "sin": lambda x: angle.sin if x == angle.value else sin(x),
        "cos": lambda x: angle.cos if x == angle.value else cos(x),
        "tan": lambda x: known["sin"](x) / known["cos"](x),
    }
    for name, text in structure.fed:
        names[name] = c.let(f"fed_{name}", own.smooth(text, names, known).xreplace(own.NUMBERS))
    drive = DRIVES[structure.drive]
    lacking = wanted[0] - angle.value, wanted[1] - speed
    return drive.torque(*lacking, *map(number, drive.letters[:2])) + names.get("", 0)


def phase(course: Course) -> Angle:
    """The phase nu t of a course over time."""
    return Angle(f"phase_{course.name}", None, number(f"nu_{course.name}"))


def course_value(course: Course, c: Coordinates) -> Expr:
    """The value of a course: its mean and its harmonics."""
    total = number(f"mean_{course.name}")
    if not course.orders:
        return total
    for _, a, b, even, odd in _harmonics(course, c):
        total += a * even + b * odd
    return c.let(f"f_{course.name}", total)


def derivatives(course: Course, c: Coordinates, most: int) -> list[Expr]:
    """A course over time, and its derivatives by the time up to so many."""
    nu, found = number(f"nu_{course.name}"), [number(f"mean_{course.name}"), *[Integer(0)] * most]
    for n, a, b, even, odd in _harmonics(course, c) if course.orders else ():
        for k in range(most + 1):
            found[k] += a * even + b * odd
            a, b = n * nu * b, -n * nu * a
    return found


def _harmonics(course: Course, c: Coordinates) -> Iterator[tuple[int, Expr, Expr, Expr, Expr]]:
    """Order, amplitudes, cosine and sine of each harmonic."""
    name, angle = course.name, phase(course) if course.timed else c.angle[course.link]
    cos, sin = angle.cos, angle.sin
    for n in range(1, max(course.orders) + 1):
        if n in course.orders:
            yield n, number(f"a_{name}_{n}"), number(f"b_{name}_{n}"), cos, sin
        cos, sin = cos * angle.cos - sin * angle.sin, sin * angle.cos + cos * angle.sin
        cos, sin = c.let(f"cos_{name}_{n + 1}", cos), c.let(f"sin_{name}_{n + 1}", sin)


def load_action(load: Load, c: Coordinates) -> Action:
    """Action of a load."""
    name, f = load.course.name, course_value(load.course, c)
    if load.span is None:
        return Action(f, {load.link: Integer(1)}, power=f * c.speed[load.link])
    x, y = number(f"dx_{name}"), number(f"dy_{name}")
    if load.turning:
        e, n = c.e(load.link), c.n(load.link)
        x, y = x * e[0] + y * n[0], x * e[1] + y * n[1]
    column = vectors.column(load.span, c, (x, y))
    return Action(f, column, ((load.link, (f * x, f * y)),), power=f * vectors.rate(column, c))


def spring_action(spring: Spring, c: Coordinates) -> Action:
    """Action of a spring."""
    name, pulls = spring.span.name, ()
    if spring.twists:
        signs = dict(zip(spring.links, (1, -1), strict=True))
        entries = {k: Integer(sign) for k, sign in signs.items() if k != "ground"}
        stretch = sum(sign * c.angle[k].value for k, sign in entries.items()) - number(f"rest_{name}")
    else:
        x, y = (
            c.let(f"d{axis}_{name}", v) for axis, v in zip("xy", vectors.vector(spring.span, c), strict=True)
        )
        length = c.let(f"L_{name}", sqrt(x**2 + y**2 + TINY))
        unit = c.let(f"ux_{name}", x / length), c.let(f"uy_{name}", y / length)
        entries, stretch = vectors.column(spring.span, c, unit), length - number(f"rest_{name}")
    k, s = number(f"k_{name}"), c.let(f"stretch_{name}", stretch)
    speed = c.let(f"rate_{name}", vectors.rate(entries, c)) if spring.damped else Integer(0)
    damping = number(f"c_{name}") if spring.damped else Integer(0)
    F = c.let(f"F_{name}", k * s + damping * speed)
    if not spring.twists:
        pulls = tuple(
            (link, (sign * F * unit[0], sign * F * unit[1]))
            for link, sign in zip(spring.links, (-1, 1), strict=True)
        )
    return Action(-F, entries, pulls, k * s**2 / 2, damping * speed**2)
