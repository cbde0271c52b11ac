"""The side view as rigid bodies in an independent multibody program, the inerter a flywheel on a screw.

Needs Exudyn: ``pip install 'posreal[multibody]'``. Planar rigid bodies with springs at their material points, the
airspring's and the strut's inner points of next to no mass, and a rotor that a screw of 20 mm pitch drives.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import posreal as pr
from posreal.network import parse
from posreal.simulation.figures import mean_squares
from posreal.simulation.laws import ElementLaw
from posreal.simulation.stepper import beside, stepper
from posreal.simulation.track import random_track, step_for

exu = pytest.importorskip(
    "exudyn", reason="the multibody check needs Exudyn, which is not installed: pip install 'posreal[multibody]'"
)
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")

PROBLEM = pr.problem("vertical-comfort")
V = PROBLEM.vehicle
S5 = (5e6, 17964.926, 4114.8145)  # bush, damper, inerter
LIGHT, PITCH = 1e-2, 0.02  # kg, m


def multibody(wheel, rate, stop, step, *, strut=S5, friction=0.0):
    """Deflections front and rear, m, and the acceleration over the trailing bogie, m/s², at every step.

    Parameters
    ----------
    wheel, rate : functions of time: the track's displacement and velocity under the first wheelset
    """
    from exudyn import itemInterface as item

    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(item.ObjectGround())
    still = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))

    def coordinate(node, number):
        return system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))

    def point(body, x):
        return system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))

    def spring(first, second, k, c=0.0):
        system.AddObject(
            item.CartesianSpringDamper(markerNumbers=[first, second], stiffness=[0, k, 0], damping=[0, c, 0])
        )

    def upright(node):
        system.AddObject(item.CoordinateConstraint(markerNumbers=[still, coordinate(node, 0)]))
        return node

    def body(mass, inertia, x):
        node = upright(system.AddNode(item.NodeRigidBody2D(referenceCoordinates=[x, 0, 0])))
        return node, system.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def shaken(marker, late):
        def force(_, t, load):
            return [0, 2 * V.Kpz * wheel(t - late) + 2 * V.Cpz * rate(t - late), 0]

        system.AddLoad(item.Force(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=force))

    def on_a_screw(car, bogie, bogie_node, x):
        """Coordinates: both ends of the bush, the nut, and the rotor, which the screw ties to the bogie."""
        k, c, b = strut
        node = system.AddNode(
            item.NodeGenericODE2(
                referenceCoordinates=[0.0] * 4,
                initialCoordinates=[0.0] * 4,
                initialCoordinates_t=[0.0] * 4,
                numberOfODE2Coordinates=4,
            )
        )
        K, D = np.zeros((4, 4)), np.zeros((4, 4))
        K[:2, :2], D[1:3, 1:3] = [[k, -k], [-k, k]], [[c, -c], [-c, c]]
        rotor = b * (PITCH / (2 * math.pi)) ** 2
        inside = system.AddObject(
            item.ObjectGenericODE2(
                nodeNumbers=[node],
                massMatrix=np.diag([LIGHT, LIGHT, LIGHT, rotor]),
                stiffnessMatrix=K,
                dampingMatrix=D,
            )
        )
        own = system.AddMarker(item.MarkerObjectODE2Coordinates(objectNumber=inside))
        screw = [0.0, 0.0, 1.0, -PITCH / (2 * math.pi)]
        for other, theirs, ours in ((car, [0.0, 1.0, x], [1.0, 0.0, 0.0, 0.0]), (bogie, [0.0, 1.0, 0.0], screw)):
            marker = system.AddMarker(item.MarkerObjectODE2Coordinates(objectNumber=other))
            system.AddObject(
                item.CoordinateVectorConstraint(
                    markerNumbers=[marker, own],
                    scalingMarker0=np.array([theirs]),
                    scalingMarker1=np.array([ours]),
                    offset=[0.0],
                )
            )
        if friction:
            system.AddObject(
                item.CoordinateSpringDamperExt(
                    markerNumbers=[coordinate(bogie_node, 1), coordinate(node, 2)],
                    dynamicFrictionForce=friction,
                    frictionProportionalZone=2e-4,
                )
            )

    car_node, car = body(V.mv, V.Iv, 0.0)
    nodes = [car_node]
    late = iter(V.wheel_delays)
    for x in (V.lvx, -V.lvx):
        node, bogie = body(V.mb, V.Ib, x)
        nodes.append(node)
        for arm in (V.lbx, -V.lbx):
            axle = point(bogie, arm)
            spring(point(ground, x + arm), axle, 2 * V.Kpz, 2 * V.Cpz)
            shaken(axle, next(late))
        inner = upright(system.AddNode(item.NodePoint2D(referenceCoordinates=[x, 0])))
        between = point(system.AddObject(item.MassPoint2D(mass=LIGHT, nodeNumber=inner)), 0.0)
        spring(point(car, x), between, V.Ksz)
        spring(between, point(bogie, 0.0), V.Krz, V.Crz)
        if strut:
            on_a_screw(car, bogie, node, x)
    kinds = exu.OutputVariableType
    sensors = [
        system.AddSensor(
            item.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kind)
        )
        for node, kind in [*((node, kinds.Coordinates) for node in nodes), (car_node, kinds.Coordinates_tt)]
    ]
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = round(stop / step), stop
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = step
    system.SolveDynamic(settings)
    body_, front, rear, acceleration = (system.GetSensorStoredData(sensor) for sensor in sensors)
    turned = V.lvx * np.sin(body_[:, 3])
    return (
        front[:, 2] - body_[:, 2] - turned,
        rear[:, 2] - body_[:, 2] + turned,
        acceleration[:, 2] - V.lvx * acceleration[:, 3],
    )


@pytest.mark.parametrize(("strut", "device"), [(None, "default"), (S5, f"S5 k={S5[0]} c={S5[1]} b={S5[2]}")])
def test_deflections_onto_the_slope(strut, device):
    def rate(t):
        return 0.4 * min(max(t, 0.0), 1.0)

    def wheel(t):
        return 0.0 if t < 0 else 0.2 * t**2 if t < 1 else 0.2 + 0.4 * (t - 1)

    front, rear, _ = multibody(wheel, rate, 2.5, 1e-3, strut=strut)
    metrics = pr.evaluate(PROBLEM, device).metrics
    assert 1e3 * np.abs(front).max() == pytest.approx(metrics["deflection_front"].value, rel=3e-5)
    assert 1e3 * np.abs(rear).max() == pytest.approx(metrics["deflection_rear"].value, rel=3e-5)


def test_friction_in_the_screw_on_random_track():
    """500 N on one record of track: the ride with friction over the ride without, in both programs."""
    plant = beside(V.plant("track"), PROBLEM.place.beside_strut)
    h = step_for(plant, 1e-3)
    count, held = 10_000, 4
    steps = random_track(plant, h, count, 1, seed=4)[::held, 0, 0]
    velocity = np.repeat(steps, held)[:count]
    position = np.concatenate([[0.0], np.cumsum(velocity) * h])
    late = [round(delay / h) for delay in plant.delays]
    w = np.stack([np.concatenate([np.zeros(d), velocity[: count - d]]) for d in late], axis=1)[:, None, :]

    def wheel(t):
        return float(np.interp(t, h * np.arange(count + 1), position, left=0.0))

    def rate(t):
        return float(velocity[min(int(t / h + 1e-6), count - 1)]) if t >= 0 else 0.0

    def ride(z):
        return math.sqrt(float(mean_squares(z[2000:, None], h, 0.0, 40 * math.pi)[0]))

    network = parse(f"k={S5[0]} + c={S5[1]} + b={S5[2]}")
    ours, theirs = [], []
    for friction in (0.0, 500.0):
        laws = {"b": ElementLaw(friction=friction)} if friction else {}
        run = stepper(plant, network, PROBLEM.place.copies, laws, h).run(w)
        ours.append(ride(run.outputs[:, 0, plant.output("acceleration_T")]))
        theirs.append(ride(multibody(wheel, rate, count * h, h, friction=friction)[2]))
    assert theirs[0] == pytest.approx(ours[0], rel=0.01)
    assert ours[1] / ours[0] > 1.01
    assert theirs[1] / theirs[0] == pytest.approx(ours[1] / ours[0], abs=3e-3)
