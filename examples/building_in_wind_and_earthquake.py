"""A plant of one's own from another field: three storeys on shaking ground and in the wind.

    minimise    √Σ (rms of each storey's drift)²   over the device between the ground and the first floor

Ground acceleration and wind are white processes that know nothing of each other, so their mean squares add. The plant
is a python-control state space with named signals; its coordinates are displacements relative to the ground.
"""

from __future__ import annotations

import control
import numpy as np

import posreal as pr


def plant() -> control.StateSpace:
    """Masses of 10 t, storeys of 8 MN/m and a little damping of their own."""
    m, k = 1e4, 8e6
    stiffness = k * np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    damping = 1e-3 * stiffness
    ground, wind, device = -np.ones(3), np.array([0.3, 0.6, 1.0]) / m, np.array([-1.0, 0, 0]) / m
    drifts = np.array([[1.0, 0, 0], [-1, 1, 0], [0, -1, 1]])
    return control.ss(
        np.block([[np.zeros((3, 3)), np.eye(3)], [-stiffness / m, -damping / m]]),
        np.vstack([np.zeros((3, 3)), np.column_stack([ground, wind, device])]),
        np.vstack([np.hstack([drifts, np.zeros((3, 3))]), np.eye(6)[3]]),
        np.zeros((4, 3)),
        inputs=["ground", "wind", "f"],
        outputs=["drift1", "drift2", "drift3", "v"],
    )


def main() -> dict[str, float]:
    """The norm of the drifts (m) with the best damper and with the best device of order 2."""
    problem = pr.problem_from_plant(
        plant(),
        disturbances=["ground", "wind"],
        density={"ground": 0.01, "wind": 1e6},  # (m/s²)² and N² per rad/s
        force="f",
        velocity="v",
        performance=["drift1", "drift2", "drift3"],
        name="building",
    )
    damper = pr.synthesise(problem, 0)
    device = pr.synthesise(problem, 2, starts=4)
    device.check()
    network = pr.realise(device.device).network
    print(pr.diagram(network, ("first floor", "ground")))
    print(f"damper {damper.objective.value * 1e3:.4g} mm, order 2 {device.objective.value * 1e3:.4g} mm")
    return {"damper": damper.objective.value, "order 2": device.objective.value}


if __name__ == "__main__":
    main()
