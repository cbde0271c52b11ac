"""The Manchester coach against its equations, solved one frequency at a time with complex stiffnesses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import posreal as pr
from posreal.vehicle.manchester import ManchesterCoach


def acceleration(vehicle: ManchesterCoach, device, omega: float) -> np.ndarray:
    """Body acceleration at L, M, T for a unit of track velocity at the first wheelset."""
    s = 1j * omega
    primary = 2 * (vehicle.Kpz + s / (1 / vehicle.Cpz + s / vehicle.Kpz_end))
    secondary = 2 * (vehicle.Ksz + s / (1 / device(s) + s / vehicle.bush))
    K = np.zeros((6, 6), complex)
    N = np.zeros((6, 4), complex)
    wheels = [(2, vehicle.lbx, 0), (2, -vehicle.lbx, 1), (4, vehicle.lbx, 2), (4, -vehicle.lbx, 3)]
    for at, arm, wheel in wheels:
        row = np.zeros(6)
        row[at], row[at + 1] = 1.0, arm
        K += primary * np.outer(row, row)
        N[:, wheel] = primary * row
    for bogie, arm in ((2, vehicle.lvx), (4, -vehicle.lvx)):
        row = np.zeros(6)
        row[0], row[1], row[bogie] = -1.0, -arm, 1.0
        K += secondary * np.outer(row, row)
    M = np.diag([vehicle.mv, vehicle.Iv, vehicle.mb, vehicle.Ib, vehicle.mb, vehicle.Ib])
    late = np.exp(-s * np.array([0, 2 * vehicle.lbx, 2 * vehicle.lvx, 2 * (vehicle.lvx + vehicle.lbx)]) / vehicle.V)
    q = np.linalg.solve(K + s**2 * M, N @ late / s)
    return s**2 * np.array([q[0] + vehicle.lvx * q[1], q[0], q[0] - vehicle.lvx * q[1]])


@pytest.mark.parametrize("text", ["default", "c=39300 + b=8630"])
def test_the_ride_is_that_of_the_equations(text):
    design = pr.evaluate(pr.problem("manchester-comfort"), text)
    vehicle = design.problem.vehicle
    device = pr.parse(f"c={vehicle.Csz}" if text == "default" else text)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    edges = np.unique(np.concatenate([[1e-3], np.geomspace(0.3, 40 * math.pi, 500)]))
    half, middle = np.diff(edges) / 2, (edges[1:] + edges[:-1]) / 2
    omega = (middle[:, None] + half[:, None] * nodes).ravel()
    z = np.array([acceleration(vehicle, device, w) for w in omega])
    squares = (half[:, None] * weights).ravel() @ np.abs(z) ** 2
    rms = 100 / vehicle.g * np.sqrt(math.pi * vehicle.Av * vehicle.V * squares)
    for point, value in zip("LMT", rms, strict=True):
        assert design.metrics[f"J1z_{point}"].value == pytest.approx(value, rel=1e-6)


def test_what_is_known_of_the_default():
    """To five digits, from a model of somebody else's: rigid body, dampers with their end stiffness, 55 m/s."""
    metrics = pr.evaluate(pr.problem("manchester-comfort"), "default").metrics
    found = [metrics[f"J1z_{point}"].value for point in "LMT"]
    assert found == pytest.approx([3.7221, 1.6082, 4.2294], abs=6e-5)


def test_every_search_takes_it():
    posed = pr.problem("manchester-comfort")
    layout = pr.optimise(posed, pr.layout("S5"), starts=2, any_values=True)
    two = pr.search(posed, 2, starts=3, any_values=True).best
    one = pr.synthesise(posed, 1, starts=2, method="ph")
    assert layout.objective.value == pytest.approx(3.50239, abs=1e-5)
    assert two.objective.value == pytest.approx(layout.objective.value, rel=1e-6)
    assert one.objective.value == pytest.approx(layout.objective.value, rel=1e-5)
    assert pr.bound(posed, L=6).value < 3.38  # what order 2 reaches over all frequencies
