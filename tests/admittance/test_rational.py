"""Rational functions: value semantics, exactness, scaling, and every form they are read from."""

import pickle
from fractions import Fraction

import control
import numpy as np
import pytest
from flint import acb, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from posreal.admittance import Rational, as_rational, parse_rational
from posreal.errors import BadDevice

coefficients = st.lists(st.fractions(min_value=-50, max_value=50, max_denominator=30), min_size=1, max_size=5)
functions = st.builds(Rational, coefficients, coefficients.filter(any))


def test_elements_and_their_combination():
    spring, damper, inerter = Rational.spring(2), Rational.damper("0.5"), Rational.inerter(3)
    assert spring == Rational([2], [0, 1])
    assert spring | damper | inerter == Rational([2, Fraction(1, 2), 3], [0, 1])
    assert spring + damper == Rational([2], [4, 1])  # 1/(s/2 + 2)
    assert spring + Rational.zero() == Rational.zero()
    assert (spring | damper).dual == Rational([0, 2], [4, 1])


def test_common_factors_and_scale_do_not_matter():
    reduced = Rational([1, 1], [3, 1])
    typed = Rational([2, 4, 2], [6, 8, 2])
    assert typed == reduced
    assert hash(typed) == hash(reduced)
    assert typed.degree == 1


def test_floats_are_the_rationals_they_are():
    y = Rational([0.1])
    assert y.numerator == (Fraction(0.1),)
    assert y != Rational(["0.1"])


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1j, None, "two", "1/0", "1e99999"])
def test_coefficients_that_are_no_numbers_are_refused(bad):
    with pytest.raises(BadDevice):
        Rational([1, bad])


def test_zero_denominator_and_negative_elements_are_refused():
    with pytest.raises(BadDevice, match="denominator"):
        Rational([1], [0, 0])
    with pytest.raises(BadDevice, match="negative stiffness"):
        Rational.spring(-1)
    with pytest.raises(BadDevice, match="zero admittance"):
        Rational.zero().inverse()


def test_limits():
    y = Rational([5, 2, 0, 3], [0, 1])
    assert (y.static_stiffness, y.degree) == (5, 3)
    with pytest.raises(BadDevice):
        _ = y.inertance
    assert Rational([5, 2, 3], [0, 1]).inertance == 3
    assert Rational([1], [1, 1]).static_stiffness == 0


def test_does_not_change():
    y = Rational([1])
    with pytest.raises(AttributeError):
        y.n = y.d


@given(functions)
def test_text_dictionary_and_pickle_return_the_same_function(y):
    assert parse_rational(str(y)) == y
    assert Rational.from_dict(y.to_dict()) == y
    assert eval(repr(y), {"Rational": Rational}) == y
    assert pickle.loads(pickle.dumps(y)) == y


@given(functions, functions)
def test_parallel_and_series_are_dual(a, b):
    assert a | b == b | a
    if a.is_zero() or b.is_zero() or a.without(b.scaled(-1)).is_zero():
        return
    assert (a + b) == (a.inverse() | b.inverse()).inverse()


def test_values_neither_overflow_nor_lose_digits():
    degree = 20
    y = Rational([10 ** (7 * i) for i in range(degree)], [3 ** (4 * i) + i for i in range(degree + 1)])
    points = np.array([1e6j, 1e-9j, 1e250, 3 + 4j, 1e-250j])
    got = y(points)
    before = ctx.prec
    ctx.prec = 2000
    try:
        for s, value in zip(points, got, strict=True):
            exact = _horner(y.n, s) / _horner(y.d, s)
            assert value == pytest.approx(complex(exact), rel=1e-13)
    finally:
        ctx.prec = before
    assert y(points[0]) == got[0]
    assert y(points.reshape(5, 1)).shape == (5, 1)


def _horner(p, s):
    total = acb(0)
    for c in reversed(p.coeffs()):
        total = total * acb(arb(s.real), arb(s.imag)) + acb(c)
    return total


def test_values_at_poles_zeros_and_exactly():
    y = Rational([1, 0, 1], [0, 1])
    assert y(0) == complex(np.inf)
    assert y(1j) == 0
    assert y.exact_value("1/2") == Fraction(5, 2)
    assert Rational([1, 1, 1], [4, 1, 1]).exact_response(1) == (Fraction(1, 10), Fraction(3, 10))
    with pytest.raises(ZeroDivisionError):
        y.exact_value(0)


def test_rounding_keeps_significant_digits():
    y = Rational([Fraction(1, 3), 123456789], [Fraction(2, 3), 1]).rounded(4)
    assert y == Rational(["0.3333", 123500000], ["0.6667", 1])


def test_time_scaling():
    y = Rational([1, 2], [3, 1])
    assert y.time_scaled(2).exact_value(1) == y.exact_value(2)


def test_control_systems_in_and_out():
    y = Rational([1, 1, 1], [4, 1, 1])
    assert Rational.from_control(y.to_control()) == y
    assert Rational.from_control(control.tf2ss(y.to_control())) == y
    assert as_rational(control.tf([1, 2, 3], [1, 1])) == Rational([3, 2, 1], [1, 1])  # improper
    assert as_rational(control.ss([], [], [], [[2.0]])) == Rational([2])
    with pytest.raises(BadDevice, match="sampled"):
        Rational.from_control(control.tf([1], [1, 1], 0.1))
    with pytest.raises(BadDevice, match="one port"):
        Rational.from_control(control.ss(-np.eye(1), np.ones((1, 2)), np.ones((1, 1)), np.zeros((1, 2))))


def test_unreachable_states_drop_out():
    system = control.ss([[-1, 0], [0, 5]], [[1], [0]], [[1, 1]], [[0]])
    assert Rational.from_control(system) == Rational([1], [1, 1])


def test_devices_in_every_form():
    y = Rational([1, 2], [3, 1])
    assert as_rational(y) is y
    assert as_rational(([1, 2], [3, 1])) == as_rational(y.to_dict()) == as_rational("(2*s + 1)/(s + 3)") == y
    assert as_rational(3) == Rational.damper(3)
    for bad in (None, object(), [1, 2, 3], {"num": [1]}):
        with pytest.raises(BadDevice):
            as_rational(bad)
