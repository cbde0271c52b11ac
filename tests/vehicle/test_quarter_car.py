"""The quarter-car against its closed forms [PS2006]."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import Rational
from posreal.optimisation.mean_square import mean_square
from posreal.specification.named import problem
from posreal.vehicle import QuarterCar, measure


@settings(deadline=None, max_examples=25)
@given(
    c=st.floats(200, 20000),
    k=st.floats(1e4, 2e5),
    ms=st.floats(50, 2000),
    mu=st.floats(10, 200),
    kt=st.floats(5e4, 1e6),
)
def test_spring_and_damper_have_the_closed_form(c, k, ms, mu, kt):
    car = QuarterCar(ms=ms, mu=mu, kt=kt, k=k)
    found = measure(car, {"secondary": Rational.spring(k) | Rational.damper(c)})
    unit = 4 * math.pi**2 * car.V * car.kappa
    J1 = math.sqrt(unit * (kt * c / (2 * ms**2) + k**2 * (ms + mu) / (2 * c * ms**2)))
    m = ms + mu
    J3 = math.sqrt(
        unit
        * (
            c * kt * m**2 / (2 * ms**2)
            + (k**2 * m**3 - 2 * k * kt * ms * mu * m + kt**2 * ms**2 * mu) / (2 * c * ms**2)
        )
    )
    assert found["J1"].value == pytest.approx(J1, rel=1e-9)
    assert found["J3"].value == pytest.approx(J3, rel=1e-9)


@pytest.mark.parametrize("objective", ["J1", "J3"])
def test_whole_axis_quadrature_is_the_covariance(objective):
    posed = problem("quarter-car", objective=objective)
    device = Rational.damper(2300) + (Rational.inerter(40) | Rational.spring(3e4) | Rational.damper(50))
    exact = posed.metrics(posed.mounting.port(device))[objective].value
    for panels, tolerance in ((12, 2e-5), (48, 1e-10)):  # the resonance has a damping ratio of 2 %
        ride = mean_square(posed, panels=panels)
        J, _ = ride.of_device(np.asarray(device(ride.s)), posed.mounting)
        assert pytest.approx(exact, rel=tolerance) == J


@pytest.mark.parametrize(
    ("layout", "figure"), [("S1", 1.759967), ("S2", 1.660764), ("S3", 1.585094)], ids=["S1", "S2", "S3"]
)
def test_optimal_layouts(layout, figure):
    from posreal.optimisation.layout_values import optimise
    from posreal.specification.layout import layout as named

    assert optimise(problem("quarter-car"), named(layout), starts=3).objective.value == pytest.approx(figure, rel=1e-6)
