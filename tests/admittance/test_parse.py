"""Reading functions of s: what is meant, and clear, quick refusals."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.admittance import Rational, parse_rational
from posreal.errors import BadDevice


@pytest.mark.parametrize(
    ("text", "numerator", "denominator"),
    [
        ("(s^2+s+1)/(s^2+s+4)", [1, 1, 1], [4, 1, 1]),
        ("2.5e5/s + 2e4", [250000, 20000], [0, 1]),
        ("-s**2", [0, 0, -1], [1]),
        ("2^-3 * s^-2", ["1/8"], [0, 0, 1]),
        ("1 - 1e-30", ["999999999999999999999999999999/1000000000000000000000000000000"], [1]),
        ("1/(s+1)/(s+2)", [1], [2, 3, 1]),
        ("6/2*s", [0, 3], [1]),
        (".5 + 1.", ["3/2"], [1]),
        ("--s - -1", [1, 1], [1]),
        ("2s", [0, 2], [1]),
        ("4 s + 3 s^2", [0, 4, 3], [1]),
        ("(s+1)(s+3)/(s+2)", [3, 4, 1], [2, 1]),
        ("-2s(s+1)^2/3", [0, "-2/3", "-4/3", "-2/3"], [1]),
        ("1/s*s(s+1)", [1, 1], [1]),
        ("Y = 2s", [0, 2], [1]),
        ("Y(s)=s+1", [1, 1], [1]),
        ("Z = (s+1)/(2s)", [0, 2], [1, 1]),
        (" Z( s ) = 1/3", [3], [1]),
        ("tf([1 0], [1 2 3])", [0, 1], [3, 2, 1]),
        ("tf([1,-2e1, 0.5],[2])", ["1/4", -10, "1/2"], [1]),
        ("Z = tf([1 2], [3])", [3], [2, 1]),
    ],
)
def test_reads_ordinary_algebra(text, numerator, denominator):
    assert parse_rational(text) == Rational(numerator, denominator)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "empty"),
        ("2 3", "operator before '3'.*character 3"),
        ("(s+1)2", "operator before '2'"),
        ("s2", "'s2' is not known"),
        ("1/2s", "after a division.*character 4"),
        ("(s+1)/(s+2)(s+3)", "after a division"),
        ("s/3(s+1)s", "after a division"),
        ("Z = 0", "rigid"),
        ("Z = tf([0], [1])", "rigid"),
        ("tf([], [1])", "number|coefficient"),
        ("tf([1], [0])", "denominator"),
        ("tf([1 1e], [1])", "number|coefficient"),
        ("tf([1], [1], 0.1)", "'tf' is not known|not part"),
        (f"tf([{'1 ' * 60}], [1])", "above 40"),
        ("Z = Y = s", "'=' is not part"),
        ("X = s", "'=' is not part"),
        ("k/s", "'k' is not known"),
        ("(s+1", r"expected '\)'.*character 5"),
        ("s+", "found 'the end'"),
        ("1/(s-s)", "division by zero"),
        ("s^1.5", "whole number"),
        ("s^2^3", "parentheses"),
        ("s^41", "above 40"),
        ("s^99999", "whole number"),
        ("1e999999", "exponent"),
        ("s # 1", "'#' is not part"),
        ("(" * 5000 + "s", "more than|deep"),
        ("-" * 3000 + "s", "deep"),
        ("__import__('os')", "not part|not known"),
    ],
)
def test_refuses_with_the_place(text, complaint):
    with pytest.raises(BadDevice, match=complaint):
        parse_rational(text)


@pytest.mark.parametrize(
    "text",
    [
        "*".join(["(1e300*s+1)"] * 30 + ["(1e-300*s+7)"] * 300),
        "+".join(f"1/(s+{i}.{i}1)" for i in range(1, 60)),
        "(" + "+".join(f"{i}.{'3' * 900}*s^{i}" for i in range(1, 40)) + ")/(s+1)",
        "+".join(["(s+1e150)^39/(s+7e149)^39"] * 1500),
    ],
)
def test_hostile_text_does_not_hang_the_reader(text):
    with suppress(BadDevice):
        parse_rational(text)


@given(st.text(alphabet="s0123456789.+-*/^()e YZ=tf[],", max_size=30))
def test_any_text_is_read_or_refused(text):
    with suppress(BadDevice):
        parse_rational(text)


@given(st.lists(st.sampled_from(["2", "s", "(s+3)", "(2*s^2+1)", "s^2", "5.5"]), min_size=1, max_size=6))
def test_a_product_without_a_mark_is_the_product(factors):
    """Wherever two factors may stand side by side at all: a number only comes first."""
    beside = " ".join(factors)
    wanted = parse_rational("*".join(factors))
    if any(factor[0].isdigit() for factor in factors[1:]):
        with pytest.raises(BadDevice, match="operator before"):
            parse_rational(beside)
    else:
        assert parse_rational(beside) == wanted
        assert parse_rational(f"Z = {beside}") == wanted.inverse()


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=6), st.lists(st.integers(1, 9), min_size=1, max_size=6))
def test_descending_lists_are_what_python_control_takes(top, bottom):
    control = pytest.importorskip("control")
    wanted = Rational.from_control(control.TransferFunction(top, bottom))
    assert parse_rational(f"tf({top}, {bottom})") == wanted
    assert Rational.descending(top, bottom) == wanted
    assert Rational.from_dict({"numerator": top, "denominator": bottom, "powers": "descending"}) == wanted
    assert Rational.from_dict({"numerator": top[::-1], "denominator": bottom[::-1]}) == wanted
