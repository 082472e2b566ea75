"""A linkage's record built from Exudyn's own bodies, joints and contacts, followed at a fixed step.

Links are `ObjectRigidBody2D` with all coordinates of their own, ideal joints its revolute and prismatic
constraints, and a journal in its bearing a sphere in a hollow sphere, whose linear contact in the plane is
F_n = K u + C u' while u > 0: Kelvin and Voigt's with tension. The trapezoidal rule in index 2; a contact
begins and ends at the end of a step, so the error is of the step's order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import jointplay as jp
from jointplay.solver.mechanism.start import start

RADIUS = 0.01  # of journals, m: nothing depends on it without friction


@dataclass(frozen=True)
class Run:
    """What a run gives: times, journals relative to their bearings over times, by joint."""

    t: np.ndarray
    r: dict[str, np.ndarray]
    v: dict[str, np.ndarray]

    def penetration(self, joint):
        """u of a joint, m."""
        return np.linalg.norm(self.r[joint.name], axis=1) - joint.clearance

    def force(self, joint):
        """F_n of a joint, N."""
        u, rho = self.penetration(joint), np.linalg.norm(self.r[joint.name], axis=1)
        closing = np.sum(self.r[joint.name] * self.v[joint.name], axis=1) / np.maximum(rho, 1e-300)
        return (u > 0) * (joint.contact.stiffness * u + joint.contact.damping * closing)

    def begins(self, joint):
        """Times at which contact begins, s, between steps where u crosses 0."""
        u = self.penetration(joint)
        (i,) = np.nonzero((u[:-1] <= 0) & (u[1:] > 0))
        return self.t[i] + (self.t[i + 1] - self.t[i]) * -u[i] / (u[i + 1] - u[i])


def free(mechanism):
    """A linkage without drive and friction."""
    joints = [
        joint if joint.prismatic else jp.Joint(**dict(joint) | {"friction": None})
        for joint in mechanism.joints
    ]
    return jp.Mechanism(**dict(mechanism) | {"joints": joints, "drive": None})


def follow(mechanism, initial, end, h):
    """Follow an undriven mechanism up to a time, s, at a step, s."""
    import exudyn as exu
    from exudyn import itemInterface as item

    mbs = exu.SystemContainer().AddSystem()
    state, bodies = start(mechanism, initial), {}
    up = mechanism.gravity_direction
    for link in (each.total for each in mechanism.links):
        angle, w = state.angles[link.name], state.speeds[link.name]
        c, s = math.cos(angle), math.sin(angle)
        (x, y), (vx, vy) = state.points[link.name]
        place = [x + link.centre * c, y + link.centre * s, angle]
        speed = [vx - link.centre * s * w, vy + link.centre * c * w, w]
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=place, initialVelocities=speed))
        own = link.inertia - link.mass * link.centre**2
        body = mbs.AddObject(item.ObjectRigidBody2D(mass=link.mass, inertia=own, nodeNumber=node))
        bodies[link.name] = body, link.centre
        marker = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body))
        weight = [link.mass * mechanism.gravity * part for part in (math.cos(up), math.sin(up), 0.0)]
        mbs.AddLoad(item.LoadForceVector(markerNumber=marker, loadVector=weight))
    ground = mbs.AddObject(item.ObjectGround())

    def at(pin):
        body, centre = bodies.get(pin.link, (ground, 0.0))
        return body, [*pin.point, 0.0] if pin.point else [pin.at - centre, 0.0, 0.0]

    sensors = {}
    for joint in mechanism.joints:
        ends = [at(joint.journal), at(joint.bearing)]
        markers = [mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=b, localPosition=p)) for b, p in ends]
        if joint.prismatic:
            d = joint.bearing.direction
            axis, normal = [math.cos(d), math.sin(d), 0.0], [-math.sin(d), math.cos(d), 0.0]
            pair = {"markerNumbers": markers[::-1], "axisMarker0": axis, "normalMarker1": normal}
            mbs.AddObject(item.ObjectJointPrismatic2D(**pair))
        elif joint.ideal:
            mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=markers))
        else:
            data = mbs.AddNode(
                item.NodeGenericData(initialCoordinates=[joint.clearance, 0, 0, 0], numberOfDataCoordinates=4)
            )
            law = {"contactStiffness": joint.contact.stiffness, "contactDamping": joint.contact.damping}
            radii = {"spheresRadii": [RADIUS, RADIUS + joint.clearance], "isHollowSphere1": True}
            mbs.AddObject(
                item.ObjectContactSphereSphere(markerNumbers=markers, nodeNumber=data, **radii, **law)
            )
            words = (exu.OutputVariableType.Position, exu.OutputVariableType.Velocity)
            sensors[joint.name] = [
                mbs.AddSensor(item.SensorMarker(markerNumber=m, outputVariableType=word, storeInternal=True))
                for word in words
                for m in markers
            ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(end / h)
    settings.timeIntegration.endTime = end
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = h
    newton = settings.timeIntegration.newton
    newton.useModifiedNewton = False
    settings.timeIntegration.discontinuous.maxIterations = 1
    settings.timeIntegration.discontinuous.ignoreMaxIterations = True
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    r, v = {}, {}
    for name, numbers in sensors.items():
        P, Q, VP, VQ = (mbs.GetSensorStoredData(number) for number in numbers)
        t, r[name], v[name] = P[:, 0], (P - Q)[:, 1:3], (VP - VQ)[:, 1:3]
    return Run(t, r, v)
