"""A linkage: chains, elastic links, contacts, friction, loops and drive put together as one system."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr, Integer, atan2, sqrt, tanh

from . import beam as elastic
from . import chain, loop
from .contact import Geometry, geometry
from .coordinates import Coordinates, Freedom, coordinates, dot
from .laws import LAWS
from .structure import Clearance, Closure, Linkage, Pin, Slide, parameter_names
from .system import Angle, Contact, System, number, traction

Vector = tuple[Expr, Expr]


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
        mass, force = c.mass(self.inertia), list(c.force(self.force, self.inertia))
        if structure.held:  # the crank: an unknown whose acceleration is none
            (crank,) = (i for i, _ in c.parts[structure.driven])
            mass = {place: entry for place, entry in mass.items() if crank not in place}
            mass[crank, crank], force[crank] = Integer(1), Integer(0)
        return System(
            positions=tuple(c.positions),
            speeds=tuple(c.speeds),
            parameters=tuple(map(number, parameter_names(structure))),
            definitions=(*c.definitions, *(d for g in self.joints.values() for d in g.definitions)),
            mass=mass,
            force=tuple(force),
            angles=tuple(angle for angle in c.angle.values() if isinstance(angle, Angle)),
            contacts=self.contacts,
            powers=self._powers(outputs) if structure.powers else {},
            outputs=outputs,
            section=outputs[structure.section] if structure.section else None,
        )

    @cached_property
    def c(self) -> Coordinates:
        """The freedoms."""
        found = coordinates(self.structure)
        loop.complete(self.structure, found)
        return found

    @cached_property
    def joints(self) -> dict[str, Geometry]:
        """Geometry of the joints with play."""
        structure = self.structure
        return {joint.name: geometry(joint, self.c, structure.driven) for joint in structure.joints}

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """Laws of the joints with play."""
        return tuple(_contact(joint, self.joints[joint.name], self.c) for joint in self.structure.joints)

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
        found[driven] += _law_torque(structure.drive, self.c.speed[driven])
        return dict(found)

    def residual(self, freedom: Freedom) -> Expr:
        """Inertia less applied forces on a freedom, contacts left out: what joints or a drive must supply."""
        total = -self.force.get(freedom, Integer(0))
        for (k, m), entry in self.inertia.items():
            if freedom in (k, m):
                total += entry * self.c.acceleration[m if freedom == k else k]
        return total

    def _needed(self, freedom: Freedom) -> Expr:
        """What ideal joints or a drive must supply on a freedom: its residual, and what contacts push."""
        total = self.residual(freedom)
        for contact in self.contacts:
            (F_n, F_t), g = traction(contact), self.joints[contact.name]
            total += g.pushed.get(freedom, Integer(0)) * F_n + g.spun.get(freedom, Integer(0)) * F_t
        return total

    @cached_property
    def _cut_joints(self) -> list[tuple[Clearance | Closure, Vector]]:
        """Joints where the chains are cut, with the force on the bearing; of closures the last one first."""
        found = []
        for contact, joint in zip(self.contacts, self.structure.joints, strict=True):
            (F_n, F_t), (x, y) = traction(contact), self.joints[joint.name].direction
            found.append((joint, (F_n * x - F_t * y, F_n * y + F_t * x)))
        for closure in reversed(self.structure.closures):
            found.append((closure, self._closing_force(closure, found[len(self.contacts) :])))
        return found

    def _closing_force(self, closure: Closure, later: list[tuple[Closure, Vector]]) -> Vector:
        needed = {}
        for unknown in closure.unknowns:
            ratios = ((k, tree[unknown]) for k, tree in self.c.tree.items() if unknown in tree)
            needed[unknown] = sum((ratio * self._needed(k) for k, ratio in ratios), Integer(0))
            for other, F in later:
                column = self._vectors(other).columns().get(unknown, loop.ZERO)
                needed[unknown] += dot(column, F)
        return loop.closing_force(self._vectors(closure), needed)

    def _vectors(self, joint: Slide | Closure) -> loop.Vectors:
        return loop.Vectors(self.structure, self.c, joint)

    def _powers(self, outputs: dict[str, Expr]) -> dict[str, Expr]:
        """Powers whose integrals close the energy balance: drive; what joints and elastic links take in."""
        joints = Integer(0)
        for joint in self.structure.joints:
            joints += outputs[f"normal_force:{joint.name}"] * outputs[f"normal_velocity:{joint.name}"]
            joints += outputs[f"tangential_force:{joint.name}"] * outputs[f"tangential_velocity:{joint.name}"]
        powers = {"drive": outputs["drive_torque"] * self.c.speed[self.structure.driven], "joints": joints}
        if self.structure.beams:
            damped = [beam for beam in self.structure.beams if beam.damped]
            lost = (elastic.dissipated_power(beam, self.c) for beam in damped)
            powers["links"] = sum(lost, Integer(0))
        return powers

    def _outputs(self) -> Iterator[tuple[str, Expr]]:
        """Every quantity that can be recorded, as word:label."""
        structure, c = self.structure, self.c
        for k in structure.links:
            yield f"angle:{k}", c.angle[k].value
            yield f"angular_velocity:{k}", c.speed[k]
            yield f"angular_acceleration:{k}", c.acceleration[k]
        for contact in self.contacts:
            yield from _contact_outputs(contact, self.joints[contact.name])
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
            yield from self._deflections()

    def _energies(self) -> Iterator[tuple[str, Expr]]:
        structure, c = self.structure, self.c
        kinetic, potential = c.kinetic_energy(chain.inertia(structure, c)), Integer(0)
        if structure.gravity:
            potential += chain.potential_energy(structure, c)
        for beam in structure.beams:
            kinetic += c.kinetic_energy(elastic.inertia(structure, beam, c))
            potential += elastic.weight_energy(beam, c) if structure.gravity else Integer(0)
        strain = sum((elastic.strain_energy(beam, c) for beam in structure.beams), Integer(0))
        yield "kinetic_energy", kinetic
        yield "potential_energy", potential + strain
        yield "strain_energy", strain

    def _deflections(self) -> Iterator[tuple[str, Expr]]:
        beams = {beam.link: beam for beam in self.structure.beams}
        for k in self.structure.links:
            bent = elastic.combined(beams[k], "gauge", self.c.position) if k in beams else Integer(0)
            yield f"deflection:{k}", bent

    def _modal_loads(self) -> Iterator[tuple[str, Expr]]:
        """Load on each mode of links whose modes are given: inertia, gravity, friction's end moments."""
        for beam in self.structure.beams:
            excited = dict(elastic.excitation(self.structure, beam, self.c))
            for mode in elastic.modes(beam):
                load = excited[mode]
                for (k, m), entry in self.inertia.items():
                    if k == mode and m != mode:
                        load -= entry * self.c.acceleration[m]
                for contact in self.contacts:
                    load -= self.joints[contact.name].spun.get(mode, Integer(0)) * traction(contact)[1]
                yield f"modal_load:{beam.link}_{mode[1]}", load

    def _drive_torque(self) -> Expr:
        """The motor's law, or what a prescribed speed costs."""
        structure, c = self.structure, self.c
        if structure.drive != "speed":
            return _law_torque(structure.drive, c.speed[structure.driven])
        driven = structure.driven
        led = ((lead[driven], self.residual(k)) for k, lead in c.leads.items() if driven in lead)
        total = sum((ratio * residual for ratio, residual in led), Integer(0))
        for contact in self.contacts:
            F_n, F_t = traction(contact)
            N, T = self.joints[contact.name].on_drive
            total += N * F_n + T * F_t
        return total

    def _reactions(self) -> Iterator[tuple[str, Vector]]:
        """Force on the bearing of every ideal joint."""
        for pin in self.structure.pins:
            yield pin.name, (self._reaction(pin, 0), self._reaction(pin, 1))
        yield from ((cut.name, F) for cut, F in self._cut_joints if isinstance(cut, Closure))

    def _slides(self, forces: dict[str, Vector]) -> Iterator[tuple[str, Expr]]:
        """Where sliding links are and how fast, and the moments on their guides about the journal's point."""
        c, cut = self.c, {one.name: F for one, F in self._cut_joints}
        closing = [(self._vectors(closure), cut[closure.name]) for closure in self.structure.closures]
        for slide in self.structure.slides:
            needed = loop.moment(self.structure, slide, c, self._needed, closing)
            d, s = c.e(slide.freedom), c.position[slide.freedom]
            # needed on the outer link about its base: the journal's point, or the bearing's
            moment = -needed if slide.sign > 0 else needed - s * loop.cross(d, forces[slide.name])
            yield f"slide_position:{slide.name}", s
            yield f"slide_velocity:{slide.name}", c.speed[slide.freedom]
            yield f"reaction_moment:{slide.name}", moment

    def _reaction(self, pin: Pin, axis: int) -> Expr:
        """Momentum rate beyond a pin, less the forces at the cut joints that act there."""
        structure = self.structure
        total = chain.beyond(pin, self.c, axis, structure.gravity)
        for beam in structure.beams:
            if beam.link in pin.links:
                total += elastic.momentum_rate(structure, beam, self.c, axis)
        for joint, force in self._cut_joints:
            total += force[axis] * ((joint.journal in pin.links) - (joint.bearing in pin.links))
        return pin.sign * total


def _law_torque(drive: str, w: Expr) -> Expr:
    """Torque of the drive on the crank as a law of its speed; 0 where the torque is no law but an outcome.

    Motor line: T(w) = a - b w, equations (1) and (2) of Chunmei et al. (2002). It is stiff: b/J reaches 1e6
    1/s. A prescribed speed makes the crank's angle a phase, Omega t + theta_0, and its torque an outcome.
    """
    return number("a") - number("b") * w if drive == "motor" else Integer(0)


def _contact(joint: Clearance, g: Geometry, c: Coordinates) -> Contact:
    law = LAWS[joint.law]
    F_n, stored = law.force(g.u, g.v_n, *(number(f"{letter}_{joint.name}") for letter in law.letters))
    drag = number(f"Ct_{joint.name}") * g.v_t if joint.viscous else Integer(0)
    drift = sum((entry * c.drift[freedom] for freedom, entry in g.spun.items()), Integer(0))
    if joint.friction == "tanh":
        drag += number(f"f_{joint.name}") * F_n * tanh(g.v_t / number(f"v_{joint.name}"))
    return Contact(
        joint.name,
        g.u,
        g.v_n,
        F_n,
        g.normal,
        joint.tension,
        g.v_t,
        g.tangential,
        number(f"f_{joint.name}") if joint.friction == "coulomb" else None,
        drag,
        stored,
        g.gap,
        drift,
    )


def _contact_outputs(contact: Contact, g: Geometry) -> Iterator[tuple[str, Expr]]:
    F_n, F_t = traction(contact)
    yield f"journal_x:{contact.name}", g.r[0]
    yield f"journal_y:{contact.name}", g.r[1]
    yield f"eccentricity:{contact.name}", g.rho
    yield f"eccentricity_ratio:{contact.name}", g.rho / number(f"e_{contact.name}")
    yield f"penetration:{contact.name}", g.u
    yield f"normal_velocity:{contact.name}", g.v_n
    yield f"tangential_velocity:{contact.name}", g.v_t
    yield f"contact_angle:{contact.name}", atan2(g.r[1], g.r[0])
    yield f"normal_force:{contact.name}", F_n
    yield f"tangential_force:{contact.name}", F_t
    yield f"stored_energy:{contact.name}", contact.stored
