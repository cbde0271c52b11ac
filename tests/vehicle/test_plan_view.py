"""The lateral model against [Jiang2012], against equations solved one frequency at a time, and against itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from posreal.admittance import Rational, random_port_hamiltonian
from posreal.errors import Infeasible
from posreal.plant import h2_norm, time_response
from posreal.specification.layout import layout
from posreal.specification.named import problem
from posreal.vehicle import PlanView, measure
from posreal.vehicle.plan_view import lateral_track_filter
from tests import published
from tests.vehicle import naive
from tests.vehicle import responses as metrics

VEHICLE = PlanView()
DEFAULT = Rational.spring(VEHICLE.Ksy) | Rational.damper(VEHICLE.Csy)


def random_port(seed: int, order: int = 3) -> Rational:
    """A random positive-real device, of the size of a damper that suits the vehicle, beside the static spring."""
    device = random_port_hamiltonian(order, np.random.default_rng(seed)).rational()
    return Rational.spring(VEHICLE.Ksy) | device.time_scaled(1 / 8).scaled(2e4) | Rational.damper(1e4)


@pytest.mark.parametrize("row", published.TABLE2, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_2_is_reproduced_at_the_published_parameters(row):
    posed = problem(row.problem).with_vehicle(row.vehicle)
    network = layout(row.layout).valued(posed, row.values)
    found = posed.metrics(network.admittance())
    assert found["Macc"].value == pytest.approx(row.figure, abs=2e-4)
    assert found["Macc"].at == "at 55 m/s"
    assert posed.violated(found, tolerance=1e-3) == []  # Ldmp no less than the default's, as the paper demands


@pytest.mark.parametrize("row", published.TABLE3, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_3_is_reproduced_at_the_published_parameters(row):
    posed = problem(row.problem).with_vehicle(row.vehicle)
    found = posed.metrics(layout(row.layout).valued(posed, row.values).admittance())
    assert found["max_yv"].value == pytest.approx(row.figure, abs=0.1)


def test_the_default_has_the_published_damping():
    found = metrics.least_damping(VEHICLE, DEFAULT)
    assert 100 * found.ratio == pytest.approx(published.LDMP_DEFAULT, abs=0.005)
    assert found.speed == 55.0
    assert found.frequency == pytest.approx(5.60, abs=0.005)


def test_the_density_goes_with_the_square_of_speed():
    printed = math.sqrt(1 / VEHICLE.V) * metrics.lateral_rms(VEHICLE, DEFAULT)
    assert printed == pytest.approx(0.02972, abs=1e-5)  # what the printed Sy = 2π Al V would give


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("speed", [7.0, 55.0])
def test_response_with_a_random_device_is_that_of_the_equations(seed, speed):
    vehicle, device = VEHICLE.at(speed), random_port(seed)
    omega = np.array([0.01, 0.3, 3.7, 11.0, 35.2, 60.0, 125.6])
    z, _ = vehicle.random_track().responses(omega, "body_acceleration").closed({"secondary": device(1j * omega)})
    H = lateral_track_filter(1j * omega)
    late = np.exp(-1j * omega * vehicle.axle_delay)
    front = np.array([naive.lateral_acceleration(vehicle, device, w, "front") for w in omega])
    rear = np.array([naive.lateral_acceleration(vehicle, device, w, "rear") for w in omega])
    np.testing.assert_allclose(z, H * (front + rear * late), rtol=1e-8)
    closed = metrics.inside(vehicle, device).on("track").shaped_loop().response(omega, "body_acceleration")
    np.testing.assert_allclose(closed, z, rtol=1e-7)


def test_the_sum_of_the_paper_with_a_random_device():
    device = random_port(5)
    omega = 0.01 * np.arange(1, 12567)
    assert len(omega) == math.floor(40 * math.pi / 0.01)
    z, _ = VEHICLE.random_track().responses(omega, "body_acceleration").closed({"secondary": device(1j * omega)})
    density = 2 * math.pi * VEHICLE.Al * VEHICLE.V**2
    every = slice(17, None, 101)  # the naive sum over each 101st point, against ours over the same points
    ours = 0.01 * density * np.sum(np.abs(z[every]) ** 2)
    assert ours == pytest.approx(naive.lateral_sum(VEHICLE, device, omega[every], 0.01), rel=1e-9)
    assert metrics.lateral_rms(VEHICLE, device) == pytest.approx(math.sqrt(0.01 * density * np.sum(np.abs(z) ** 2)))


@pytest.mark.parametrize("seed", range(3))
def test_primary_as_a_port_is_the_same_vehicle(seed):
    device = random_port(seed)
    omega = np.geomspace(0.02, 120, 40)
    s = 1j * omega
    whole, slopes = VEHICLE.random_track().responses(omega, "body_acceleration").closed({"secondary": device(s)})
    open_, by_port = (
        VEHICLE.random_track(primary_open=True)
        .responses(omega, "body_acceleration")
        .closed({"secondary": device(s), "primary": VEHICLE.Kpy / s + VEHICLE.Cpy})
    )
    np.testing.assert_allclose(open_, whole, rtol=1e-8)
    np.testing.assert_allclose(by_port["secondary"], slopes["secondary"], rtol=1e-7)
    step = 1e-5
    stiffer = PlanView(Kpy=VEHICLE.Kpy * (1 + step)).random_track().responses(omega, "body_acceleration")
    softer = PlanView(Kpy=VEHICLE.Kpy * (1 - step)).random_track().responses(omega, "body_acceleration")
    difference = stiffer.closed({"secondary": device(s)})[0] - softer.closed({"secondary": device(s)})[0]
    expected = by_port["primary"] * VEHICLE.Kpy / s * 2 * step
    np.testing.assert_allclose(difference, expected, rtol=1e-4, atol=1e-6 * np.abs(expected).max())


def test_ride_three_ways():
    """Sum to 20 Hz, exact covariance over all frequencies, and a simulated track."""
    by_sum = metrics.lateral_rms(VEHICLE, DEFAULT)
    loop = metrics.inside(VEHICLE, DEFAULT).on("track").shaped_loop()
    by_covariance = math.sqrt(h2_norm.mean_square(loop, "body_acceleration"))

    # The definitions differ by what lies above 20 Hz, which adaptive quadrature of another response function gives …
    def density(omega: float) -> float:
        z = loop.response(np.array([omega]), "body_acceleration")
        return loop.density * abs(z[0]) ** 2

    edge = 0.01 * (12566 + 0.5)
    above = quad(density, edge, 3e3, limit=600, epsrel=1e-9)[0]
    below = quad(density, 0, 0.005)[0]
    # … and by the step of the sum, whose points are midpoints of intervals of 0.01 rad/s from 0.005 on.
    assert by_covariance**2 - above - below == pytest.approx(by_sum**2, rel=2e-6)
    assert by_covariance == pytest.approx(by_sum, rel=1e-4)
    simulated, error = time_response.monte_carlo(loop, "body_acceleration", seed=20121, duration=1500)
    assert abs(simulated - by_covariance) < 4 * error
    assert error < 0.02 * by_covariance
    again, _ = time_response.monte_carlo(loop, "body_acceleration", seed=20121, duration=1500)
    assert again == simulated


def test_damping_is_that_of_the_dynamic_stiffness_roots():
    """Every pole makes the frequency-domain equations singular: checked through the naive response blowing up."""
    device = random_port(8)
    poles = metrics.lateral_poles(VEHICLE, device, np.array([30.0]))[0]
    vehicle = VEHICLE.at(30.0)
    lightly = poles[(poles.imag > 1) & (np.abs(poles) < 300)]
    assert len(lightly) >= 3
    for pole in lightly:
        near = [abs(naive.lateral_acceleration(vehicle, device, (pole * (1 + h)) / 1j, "front")) for h in (1e-3, 1e-6)]
        assert near[1] > 300 * near[0]


def test_curve_entry_is_that_of_a_stepped_simulation():
    loop_plant = VEHICLE.curve_entry()
    from posreal.admittance import state_space
    from posreal.plant.plant import close

    loop = close(loop_plant, {"secondary": state_space(DEFAULT)})
    step = VEHICLE.axle_delay / 40
    time = np.arange(0, 5, step)
    ramp = np.clip(time / 3, 0, 1)
    late = np.clip((time - VEHICLE.axle_delay) / 3, 0, 1)
    plain = time_response.stepped(loop, "body_displacement", np.column_stack([ramp, late]), step)
    exact = metrics.curve_response(VEHICLE, DEFAULT, time)
    # the corner at 3 s falls between samples: the plain way is off by O(step²) there
    np.testing.assert_allclose(exact, plain, atol=2e-6)
    peak = measure(VEHICLE, {"secondary": DEFAULT})["max_yv"].value
    assert peak == pytest.approx(77.1427, abs=2e-3)
    assert 1e3 * np.max(np.abs(exact)) == pytest.approx(peak, abs=1e-2)


def test_steady_curving_balances():
    """Long after the curve has begun, the body's cant deficiency hangs on the secondary springs."""
    unbalanced = VEHICLE.mv * (VEHICLE.V**2 / VEHICLE.R - VEHICLE.g * VEHICLE.cant)
    soft = PlanView(Ksy=1e5)
    device = Rational.spring(soft.Ksy) | Rational.damper(soft.Csy)
    stiff = Rational.spring(2e5) | Rational.damper(soft.Csy)
    late = np.array([60.0])
    change = metrics.curve_response(soft, device, late)[0] - metrics.curve_response(soft, stiff, late)[0]
    assert change == pytest.approx(unbalanced / (2 * 1e5) - unbalanced / (2 * 2e5), rel=1e-6)


def test_an_unstable_vehicle_is_refused():
    with pytest.raises(Infeasible, match="not stable"):
        measure(VEHICLE, {"secondary": Rational.spring(VEHICLE.Ksy) | Rational.damper(1.0)})
