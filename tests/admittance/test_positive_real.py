"""The verdict against cases with known answers, and against devices positive real by construction."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import (
    AxisPole,
    NegativeReal,
    Rational,
    RightHalfPlanePole,
    check,
    is_positive_real,
    parse_rational,
    random_port_hamiltonian,
    require,
)
from posreal.errors import NotPositiveReal


@pytest.mark.parametrize(
    "text",
    [
        "3/s", "2", "5*s", "0", "s/(s^2+2) + 1", "(s^2+1)/(s^2+2)/s", "(s^2+s+1)/(s^2+s+4)",
        "(s^2+s+1)/(s^2+(1+1e-12)*s+4)", "(s^2+s+1)/(s^2+(1+1e-30)*s+4)", "2.5e5/s + 2e4 + 3*s",
        "s/(s^2+1) + s/(s^2+1.000000001)", "1/(s+1)", "s/(s+1)", "(s+1)/(s+1)",
        "(s^2+1)*(s^2+4)/((s^2+1)*(s^2+4) + s*(s^2+2))",
    ],
)  # fmt: skip
def test_positive_real(text):
    verdict = check(text)
    assert verdict
    assert verdict.witness is None
    assert verdict.margin >= 0
    assert is_positive_real(text)
    assert require(text) == parse_rational(text)


@pytest.mark.parametrize(
    ("text", "witness"),
    [
        ("(s^2+s+1)/(s^2+(1-1e-12)*s+4)", NegativeReal),
        ("(s^2+s+1)/(s^2+(1-1e-30)*s+4)", NegativeReal),
        ("(s^2+s+1)/(s^2+(1-1e-300)*s+4)", NegativeReal),
        ("(s^2-1e-6*s+1)/(s^2+2e-6*s+1)", NegativeReal),
        ("(1-s)/(1+s)", NegativeReal),
        ("-1", NegativeReal),
        ("-1/s", AxisPole),
        ("-s", AxisPole),
        ("1/s^2", AxisPole),
        ("s^2", AxisPole),
        ("s^3 + 1", AxisPole),
        ("s/(s^2+1)^2", AxisPole),
        ("1/(s+1) - 1e-30/s", AxisPole),
        ("1/(s^2+2) + 1", AxisPole),
        ("1 - s/(s^2+2)", AxisPole),
        ("s/(s^2+1) + s/(s^2+2) - 1e-20*s/(s^2+3)", AxisPole),
        ("1/(s-1)", RightHalfPlanePole),
        ("(s^2+1)/(s^2-1e-20*s+1)", RightHalfPlanePole),
        ("1/(s^4+1)", RightHalfPlanePole),
        ("1/(s^4-3*s^2+2)", RightHalfPlanePole),
    ],
)
def test_not_positive_real(text, witness):
    verdict = check(text)
    assert not verdict
    assert isinstance(verdict.witness, witness)
    assert not is_positive_real(text)
    with pytest.raises(NotPositiveReal) as caught:
        require(text)
    assert caught.value.witness == verdict.witness
    json.dumps(verdict.to_dict(), allow_nan=False)


@pytest.mark.parametrize("gap", ["1e-3", "1e-12", "1e-30", "1e-100"])
def test_the_witness_is_a_rational_frequency_with_the_sign_it_claims(gap):
    verdict = check(f"(s^2+s+1)/(s^2+(1-{gap})*s+4)")
    assert isinstance(verdict.witness, NegativeReal)
    real, _ = verdict.device.exact_response(verdict.witness.omega)
    assert real == verdict.witness.value < 0
    assert verdict.margin == pytest.approx(-float(Fraction(gap)) / 3, rel=1e-2)


def test_axis_poles_are_located_and_weighed():
    pole = check("1/(s^2+2) + 1").witness
    assert pole.location == pytest.approx(math.sqrt(2))
    assert pole.residue == pytest.approx(-1j / (2 * math.sqrt(2)))
    assert check("s^3").witness == AxisPole(math.inf, 3, None)
    assert check("1/(s+1) - 1e-3/s").witness.residue == pytest.approx(-1e-3)


def test_a_minimum_function_touches_zero():
    verdict = check("(s^2+s+1)/(s^2+s+4)")
    assert verdict.minimum_function
    assert verdict.margin == 0
    assert verdict.touches == pytest.approx((math.sqrt(2),))
    assert verdict.regular is False
    assert not check("(s^2+s+1)/(s^2+1.1*s+4)").minimum_function
    assert not check("(s^2+1)/(s^2+s+1)").minimum_function  # its zero is on the axis


def test_touching_at_zeros_on_the_axis():
    verdict = check("(s^2+1)*(s^2+4)/((s^2+1)*(s^2+4) + s*(s^2+2))")
    assert verdict.touches == pytest.approx((1, 2))
    assert not verdict.minimum_function


def test_touching_at_several_frequencies():
    # even part of n(s) d(−s) at s² = −x is (x − 1)²(x − 4)² for n = d = Π(s + …) shifted by an odd function
    d = Rational([2, 3, 1]).times(Rational([6, 5, 1])).n
    x = Rational([1, 0, 1]).n * Rational([4, 0, 1]).n
    # n d(−s) + n(−s) d = 2 x², solved for n of the same degree
    n = _positive_real_with_even_part(d, x * x)
    verdict = check(Rational(n, d))
    assert verdict
    assert verdict.touches == pytest.approx((1, 2))
    nudged = check(Rational(n, d).without(Rational([Fraction(1, 10**40)])))
    assert not nudged
    assert isinstance(nudged.witness, NegativeReal)


def _positive_real_with_even_part(d, target):
    from flint import fmpq_mat, fmpq_poly

    size = d.degree() + 1
    columns = []
    for power in range(size):
        s = fmpq_poly([0] * power + [1])
        minus = fmpq_poly([-c if i % 2 else c for i, c in enumerate(d.coeffs())])
        product = s * minus
        columns.append([product[2 * i] for i in range(size)])
    system = fmpq_mat(size, size, [columns[j][i] for i in range(size) for j in range(size)])
    return fmpq_poly(system.solve(fmpq_mat(size, 1, [target[2 * i] for i in range(size)])).entries())


def test_what_else_a_verdict_says():
    verdict = check("2/s + 3 + 5*s")
    assert (verdict.degree, verdict.static_stiffness, verdict.inertance) == (2, 2, 5)
    assert (verdict.margin, verdict.lossless) == (3, False)
    assert check("2/s + 5*s + s/(s^2+7)").lossless
    assert check("1/(s+1)").margin_at == math.inf
    assert verdict.check() == verdict


def test_facts_for_a_reader():
    facts = " | ".join(check("(s^2+s+1)/(s^2+s+4)").facts())
    assert "minimum function" in facts
    assert "<br>a minimum function" in check("(s^2+s+1)/(s^2+s+4)")._repr_html_()
    assert "exactly zero at ω = 1.41421356237 rad/s" in facts
    assert "not regular" in facts
    assert any("static stiffness 2 N/m" in fact for fact in check("2/s + 3 + 5*s").facts())
    assert any("inertance at high frequency 5 kg" in fact for fact in check("2/s + 3 + 5*s").facts())
    assert "least Re Y(jω) is -0.0376649" in check("(s^2+s+1)/(s^2+0.9*s+4)").facts()[0]


@pytest.mark.parametrize(
    ("text", "regular"),
    [("(s^2+s+1)/(s^2+1.001*s+4)", False), ("(s^2+3*s+1)/(s^2+s+1)", True), ("s/(s^2+1) + 1", True)],
)
def test_regular_biquadratics(text, regular):
    assert check(text).regular is regular


def test_degree_twenty():
    rng = np.random.default_rng(0)
    y = Rational.damper(0.1)
    for i in range(20):
        y = y + Rational.inerter(rng.uniform(0.1, 10)) if i % 2 else y | Rational.spring(rng.uniform(0.1, 10))
        y = y | Rational.damper(rng.uniform(0.1, 1)) if i % 2 else y + Rational.damper(rng.uniform(0.1, 1))
    verdict = check(y)
    assert verdict
    assert verdict.degree == 20


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 8), st.integers(0, 2**32 - 1), st.sampled_from([0, 4, 10]))
def test_port_hamiltonian_devices_are_positive_real_and_so_are_their_impedances(order, seed, decades):
    y = random_port_hamiltonian(order, np.random.default_rng(seed), decades).rational()
    assert y.degree == order
    verdict = check(y)
    assert verdict
    assert check(y.inverse())
    omega = np.logspace(-8, 8, 50)
    assert verdict.margin <= np.min(y(1j * omega).real) + 1e-12


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(1e-12, 0.5))
def test_taking_out_more_than_the_margin_breaks_it(order, seed, excess):
    y = random_port_hamiltonian(order, np.random.default_rng(seed)).rational()
    margin = check(y).margin
    less = check(y.without(Rational([margin * (1 + excess) + 1e-15])))
    assert isinstance(less.witness, NegativeReal)
    assert less.witness.value < 0
    assert less.margin < 0
