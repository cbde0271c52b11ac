"""Floats against exact arithmetic, and gradients against the identities they obey.

Scaling every admittance by t scales Y by t, and scaling s is scaling inerters up and springs down:

    Σ ∂Y/∂log θ = Y          Σ_inerters − Σ_springs = s dY/ds
"""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings

from posreal.errors import BadDevice
from posreal.network import parse
from tests.strategies import lever_networks, networks, trees

S = np.array([0.3 + 2j, 1.0, 5 - 0.1j, 0.01 + 40j])


def derivative(y, s):
    n, d = y.n, y.d
    slope = [(n.derivative() * d - n * d.derivative()), d * d]
    top, bottom = ([complex(float(Fraction(int(c.p), int(c.q)))) for c in p.coeffs()] for p in slope)
    return np.polyval(top[::-1], s) / np.polyval(bottom[::-1], s)


@given(networks(6))
def test_floats_follow_the_exact_function(network):
    assert network(S) == pytest.approx(network.admittance()(S), rel=1e-10)


@settings(max_examples=8)
@given(trees(25, least=20, decades=8))
def test_floats_follow_the_exact_function_of_large_trees(network):
    assert network(S) == pytest.approx(network.admittance()(S), rel=1e-10)


@given(networks(6))
def test_sensitivities_add_up(network):
    kinds = np.array([element.letter for element in network.elements()])
    gradient = network.sensitivities(S)
    assert gradient.shape == (len(network), *S.shape)
    assert gradient[kinds != "n"].sum(axis=0) == pytest.approx(network(S), rel=1e-9)


@given(networks(4, decades=2))
def test_sensitivities_give_the_slope_along_s(network):
    kinds = np.array([element.letter for element in network.elements()])
    gradient = network.sensitivities(S)
    slope = gradient[kinds == "b"].sum(axis=0) - gradient[kinds == "k"].sum(axis=0)
    assert slope == pytest.approx(S * derivative(network.admittance(), S), rel=1e-6, abs=1e-6 * abs(network(S)).max())


@given(networks(3))
def test_each_sensitivity_is_the_exact_difference_quotient(network):
    s, step = Fraction(3, 2), Fraction(1, 10**7)
    gradient = network.sensitivities(1.5)
    for i, (name, value) in enumerate(network.exact_values().items()):
        up, down = (network.with_values({name: value * t}).admittance().exact_value(s) for t in (1 + step, 1 - step))
        assert gradient[i].real == pytest.approx(float((up - down) / (2 * step)), rel=1e-6, abs=1e-9 * abs(float(up)))


@given(lever_networks(2))
def test_evaluating_at_other_values_needs_no_new_network(network):
    values = np.array(list(network.values().values())) * 1.25
    y, gradient = network.topology().evaluate(values, S)
    other = network.with_values(dict(zip(network.names, values.tolist(), strict=True)))
    assert y == pytest.approx(other(S))
    assert gradient == pytest.approx(other.sensitivities(S))


def test_shapes():
    network = parse("k=1 | (c=2 + b=3)")
    assert isinstance(network(1j), complex)
    assert network(np.ones((2, 3))).shape == (2, 3)
    y, gradient = network.evaluate([1, 2, 3], np.ones((2, 3)))
    assert y.shape == (2, 3)
    assert gradient.shape == (3, 2, 3)
    with pytest.raises(BadDevice, match="takes 3 values"):
        network.evaluate([1, 2], 1j)


@pytest.mark.parametrize(
    ("text", "s", "value"),
    [
        ("k=1 | c=1", 0, np.inf),
        ("c=2 + k=1", 0, 2),
        ("(k=4 + b=1) | c=1", 2j, np.inf),
        ("((k=4 + b=1) | c=1) + c=3", 2j, 3),
        ("(k=4 | b=1) + c=3", 2j, 0),
        ("{1-2: k=2, 1-3: c=3, 2-3: b=1, 2-0: c=4, 3-0: k=7}", 0, np.inf),
        ("{1-2: k=2, 1-3: c=3, 2-3: b=1, 2-0: c=4, 3-0: c=7}", 0, 49 / 11),
    ],
)
def test_poles_and_zeros_inside_do_not_hurt(text, s, value):
    network = parse(text)
    exact = network.admittance()(s)
    assert network(s) == exact
    assert network([s, 1.0])[0] == exact
    if np.isfinite(value):
        assert exact == pytest.approx(value) or "{" in text


@given(trees(6))
def test_elements_of_any_kind_at_any_point_share_one_sweep(network):
    """A row of points may belong to different values, kinds and frequencies; each column stands for itself."""
    powers = np.array(["kcb".index(element.letter) - 1 for element in network.elements()])
    values = np.array([float(element.exact) for element in network.elements()])
    branches = values[:, None] * S ** powers[:, None]
    mixed = np.concatenate([branches, 1 / branches], axis=1)
    y, slope = network.response.joined(mixed)
    assert y[: len(S)] == pytest.approx(network(S), rel=1e-12)
    assert slope[:, : len(S)] == pytest.approx(network.sensitivities(S), rel=1e-12)
    assert slope.sum(axis=0) == pytest.approx(y, rel=1e-9)  # Y scales with its elements
