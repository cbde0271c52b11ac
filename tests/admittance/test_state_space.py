"""State space and port-Hamiltonian forms against the rational functions they stand for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import (
    PortHamiltonian,
    Rational,
    StateSpace,
    as_rational,
    is_positive_real,
    parse_rational,
    random_port_hamiltonian,
    state_space,
)
from posreal.errors import BadDevice

OMEGA = np.logspace(-8, 8, 200)


def difference(a, b):
    return np.max(np.abs(a(1j * OMEGA) - b(1j * OMEGA)) / np.abs(b(1j * OMEGA)))


@pytest.mark.parametrize(
    "text",
    [
        "2.5e5/s + 2e4 + 3*s",
        "7",
        "0",
        "s/(s^2+4) + 1/(s+1)^2",
        "(s+1)^6/(s+2)^6",
        "1/(s+1)^12",
        "1/(s^2+1e-9*s+1) + 1/(s+1e8) + 1/(s+1e-8)",
        "(s+1)*(s+1.1)*(s+1.3)*(s+1.5)*(s+2)/((s+1.01)*(s+1.2)*(s+1.4)*(s+1.7)*(s+2.3))",
        "1/(s-1)",
    ],
)
def test_known_functions(text):
    y = parse_rational(text)
    device = state_space(y)
    inside = y.degree - (y.static_stiffness != 0) - (y.inertance != 0)
    assert device.order == inside
    assert (device.k, device.b) == (y.static_stiffness, y.inertance)
    if not y.is_zero():
        assert difference(device, y) < 1e-12
        assert difference(device.rational(), y) < 1e-12


def test_undamped_poles_stay_on_the_axis():
    device = state_space(parse_rational("s/(s^2+2)"))
    assert is_positive_real(device.rational()) or np.all(np.diag(device.A) == 0)
    assert np.all(np.diag(device.A) == 0)


@settings(deadline=None, max_examples=15)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1), st.sampled_from([0, 4, 8]))
def test_random_devices_with_spread_poles(order, seed, decades):
    form = random_port_hamiltonian(order, np.random.default_rng(seed), decades)
    y = form.rational()
    device = state_space(y)
    assert device.order == order
    assert difference(device, y) < 1e-11
    assert difference(form, y) < 1e-9


def test_rational_is_exact():
    A, B, C = np.array([[-1.0, 2.0], [0.0, -3.0]]), np.array([[1.0], [1.0]]), np.array([[0.5, 0.25]])
    device = StateSpace(A, B, C, np.array([[2.0]]), k=4.0, b=8.0)
    proper = Rational(["9/4", "3/4"], [3, 4, 1])  # C adj(sI − A) B = (s+3)/2 + 1 + (s+1)/4 = (3/4) s + 11/4
    expected = Rational(["11/4", "3/4"], [3, 4, 1]) | Rational([4, 2, 8], [0, 1])
    assert proper != expected
    assert device.rational() == expected
    assert as_rational(device) == expected
    assert device(2.0) == pytest.approx(float(expected.exact_value(2)))


def test_shapes_and_signs_are_checked():
    with pytest.raises(BadDevice, match="shapes"):
        StateSpace(np.eye(2), np.ones((1, 1)), np.ones((1, 2)), np.ones((1, 1))).rational()
    with pytest.raises(BadDevice, match="shapes"):
        PortHamiltonian(np.eye(2), np.ones((2, 1)), np.ones((2, 2)))
    with pytest.raises(BadDevice, match="negative"):
        PortHamiltonian(np.eye(1), np.ones((1, 1)), np.ones((2, 1)), k=-1.0)
    with pytest.raises(BadDevice):
        state_space(parse_rational("1/s^2"))


@pytest.mark.parametrize("order", [0, 1, 3])
def test_port_hamiltonian_with_spring_and_inerter(order):
    form = random_port_hamiltonian(order, np.random.default_rng(order))
    beside = PortHamiltonian(form.J, form.G, form.L, k=2.0, b=0.5)
    y = beside.rational()
    assert y == form.rational() | Rational([2, 0, "1/2"], [0, 1])
    assert is_positive_real(y)
    assert beside(1j) == pytest.approx(y(1j))
