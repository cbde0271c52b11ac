"""The independent program on figures known before either program: closed forms, published tables, dense sums.

The dense sums and 30-digit values are of devices whose figures posreal once printed wrong.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from tests.fuzz import independent
from tests.fuzz.draws import companion, quarter_plant, weighted
from tests.fuzz.independent import PLAN_VIEW, element, parallel, polynomial, series
from tests.published import TABLE2, TABLE5

CLOSE = 1e-10


@pytest.mark.parametrize("c", ["4.288e9", "2615.34", "5.271e-9"])
def test_the_closed_form_of_a_spring_and_a_damper(c: str):
    ms, mu, kt, k, x = 250.0, 35.0, 150e3, 60e3, float(c)
    shared = 4 * math.pi**2 * 25 * 5e-7
    ride = kt * x / (2 * ms**2) + k**2 * (ms + mu) / (2 * x * ms**2)
    rest = k**2 * (ms + mu) ** 3 - 2 * k * kt * ms * mu * (ms + mu) + kt**2 * ms**2 * mu
    grip = x * kt * (ms + mu) ** 2 / (2 * ms**2) + rest / (2 * x * ms**2)
    found = independent.quarter_car(element("c", c))
    assert found["J1"] == pytest.approx(math.sqrt(shared * ride), rel=CLOSE)
    assert found["J3"] == pytest.approx(math.sqrt(shared * grip), rel=CLOSE)


@pytest.mark.parametrize(
    ("device", "J1"),
    [
        (element("c", "2615.34"), 1.759967),
        (parallel(element("c", "2328.8"), element("b", "31.27")), 1.660764),
        (series(element("c", "3224.2"), element("b", "333.3")), 1.585094),
    ],
)
def test_the_quarter_car_of_papageorgiou_and_smith(device: independent.Device, J1: float):
    assert independent.quarter_car(device)["J1"] == pytest.approx(J1, abs=6e-7)


def test_sharp_resonances_behind_the_bush():
    """Dense sums of two million points."""
    ringing = series(parallel(element("k", 228500), element("c", "11.22")), element("b", "21.3"))
    found = independent.side_view(parallel(element("c", 1090), ringing))
    assert found["J1z_T"] == pytest.approx(2.400134, abs=6e-7)
    assert found["J1z_L"] == pytest.approx(1.93437, abs=6e-6)
    assert found["J1z_T_whole"] > found["J1z_T"]
    undamped = independent.side_view(series(element("k", 7648), element("b", "34.6")))
    assert [undamped[f"J1z_{at}"] for at in "LMT"] == pytest.approx([1.91628, 1.24096, 2.30525], abs=6e-6)


def test_the_airspring_alone():
    found = independent.side_view(None)
    assert [found[f"J1z_{at}"] for at in "LMT"] == pytest.approx([1.666, 1.047, 2.220], abs=6e-4)
    assert {name: found[name] for name in TABLE5} == pytest.approx(TABLE5, abs=0.01)
    assert found["deflection_front"] == pytest.approx(29.9, abs=0.05)
    assert found["deflection_rear"] == pytest.approx(36.0, abs=0.05)
    assert found["deflection_rms_front"] == pytest.approx(5.27, abs=0.005)
    assert found["deflection_rms_rear"] == pytest.approx(7.78, abs=0.005)


def test_the_lateral_tables():
    join = {"S1": parallel, "S2": parallel, "S3": series}
    for row, figure in zip(TABLE2, (0.22037, 0.22056, 0.21726, 0.19968, 0.19209, 0.19360), strict=True):
        device = join[row.layout](*(element(letter, value) for letter, value in row.values.items()))
        found = independent.plan_view_at(device, {**PLAN_VIEW, **row.vehicle})
        assert found == pytest.approx(figure, abs=6e-6)
        assert found == pytest.approx(row.figure, abs=2e-4)
    ringing = (
        polynomial([Fraction(667937605, 221), Fraction(25359275397, 442000), Fraction("18640.76309")]),
        polynomial([Fraction(573337, 3536), Fraction(76309, 35360000), 1]),
    )
    assert independent.plan_view_at(ringing, {**PLAN_VIEW, "V": 30.0}) == pytest.approx(0.674116, abs=6e-7)
    assert independent.plan_view_at(ringing, PLAN_VIEW) == pytest.approx(0.35567, abs=6e-6)


def test_the_default_lateral_suspension():
    found = independent.plan_view(element("c", 20_000))
    assert found["Macc speed"] == 55
    assert found["Ldmp"] == pytest.approx(6.448, abs=6e-4)
    assert found["max_yv"] == pytest.approx(77.14, abs=6e-3)


@pytest.mark.parametrize(("c", "right"), [("1500", 0.923348443945), ("531.125640794298", 0.743642664029)])
def test_a_weighted_plant(c: str, right: float):
    plant = weighted(quarter_plant(250, 35, 20e3, 150e3), 0)
    density = 4 * math.pi * 25 * 5e-7
    found = independent.own_plant(
        plant, element("c", c), processes=[[(0, 0.0)]], densities=[density], force=1, velocity=2, outputs=[0]
    )
    assert found[0][0] == pytest.approx(right, rel=2e-11)  # the entries of the filter are rounded


def test_delays_and_gains_of_one_mass():
    """m z̈ + c ż + k z = w(t) + w(t − T): ∫ = π/(2 c k) · 2 (1 + ρ(T)); the largest gain is 1/(2 ζ √(1 − ζ²) k)."""
    m, k, c, T = 2.0, 50.0, 3.0, 0.3
    omega, zeta = math.sqrt(k / m), c / (2 * math.sqrt(k * m))
    damped = omega * math.sqrt(1 - zeta**2)
    rho = math.exp(-zeta * omega * T) * (math.cos(damped * T) + zeta * omega / damped * math.sin(damped * T))
    A = np.array([[0, 1], [-k / m, 0]])
    B, C, D = np.array([[0, 0, 0], [1, 1, -1]]) / m, np.eye(2), np.zeros((2, 3))
    found = independent.own_plant(
        (A, B, C, D),
        element("c", 3),
        processes=[[(0, 0.0), (1, T)]],
        densities=[1.0],
        force=2,
        velocity=1,
        outputs=[0],
    )
    assert found[0][0] ** 2 == pytest.approx(math.pi / (c * k) * (1 + rho), rel=CLOSE)
    alone = independent.own_plant(
        (A, B[:, 1:], C, D[:, 1:]),
        element("c", 3),
        processes=[[(0, 0.0)]],
        densities=[1.0],
        force=1,
        velocity=1,
        outputs=[0],
        gains=True,
    )
    assert alone[0][1] == pytest.approx(1 / (2 * zeta * math.sqrt(1 - zeta**2) * k), rel=CLOSE)


def test_what_is_not_stable_is_refused():
    for device in (element("k", 1), element("b", "1e-9"), series(element("k", 5), element("b", 3))):
        with pytest.raises(independent.NotStable):
            independent.quarter_car(device)


def test_a_filter_in_companion_form_is_its_transfer_function():
    numerator, denominator, s = np.array([1.0, 2.0]), np.array([2.0, 3.0, 5.0]), 0.7j
    A, B, C, D = companion(numerator, denominator)
    assert (C @ np.linalg.solve(s * np.eye(2) - A, B) + D).item() == pytest.approx(
        np.polyval(numerator, s) / np.polyval(denominator, s)
    )
