"""J1y of [Jiang2012] (12,566 frequencies, two delayed inputs): at the port, by python-control, in a loop."""

from __future__ import annotations

import math

import control
import numpy as np

from benchmarks.timing import medians, report
from posreal import PlanView, Rational
from posreal.optimisation.mean_square import mean_square
from posreal.plant.figures import ClosedPlant
from posreal.specification.named import problem
from posreal.vehicle.plan_view import lateral_track_filter


def main() -> None:
    """All ways must agree to 1e-6; then their times."""
    vehicle = PlanView()
    device = Rational.spring(vehicle.Ksy) | (Rational.damper(2.1e4) + Rational.inerter(1.5e4))
    omega = 0.01 * np.arange(1, 12567)
    s = 1j * omega
    loop = ClosedPlant(vehicle.random_track(), {"secondary": device}).shaped_loop()
    ride = mean_square(problem("lateral-comfort"))
    paper = vehicle.random_track().responses(omega, "body_acceleration")
    values, coarse = np.asarray(device(s)), np.asarray(device(ride.s))
    scale = 0.01 * loop.density
    shaping = lateral_track_filter(s)
    assert np.all(np.isfinite(shaping))
    system = control.ss(loop.A, loop.B, loop.C, loop.D)

    def at_the_port() -> float:
        z, _ = paper.closed({"secondary": values})
        return math.sqrt(scale * float(np.sum(np.abs(z) ** 2)))

    def with_gradient() -> float:
        return ride.value_and_slopes({"secondary": coarse})[0]

    def python_control() -> float:
        response = control.frequency_response(system, omega).frdata[0]
        z = response[0] + response[1] * np.exp(-s * vehicle.axle_delay)
        return math.sqrt(scale * float(np.sum(np.abs(z) ** 2)))

    def naive() -> float:
        total, n = 0.0, len(loop.A)
        for w in omega:
            x = np.linalg.solve(1j * w * np.eye(n) - loop.A, loop.B)
            g = (loop.C @ x + loop.D)[0]
            total += abs(g[0] + g[1] * np.exp(-1j * w * vehicle.axle_delay)) ** 2
        return math.sqrt(scale * total)

    calls = {
        "at the port, the paper's 12,566 points": at_the_port,
        f"at the port with gradient, Gauss rule, {len(coarse)} points": with_gradient,
        "python-control frequency response": python_control,
        "a matrix solve per frequency in a loop": naive,
    }
    figures = {name: call() for name, call in calls.items()}
    first = next(iter(figures.values()))
    for name, value in figures.items():
        assert abs(value - first) < 1e-5 * first, (name, value, first)
    report(medians(calls), "at the port, the paper's 12,566 points")


if __name__ == "__main__":
    main()
