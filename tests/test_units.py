import time
from contextlib import suppress
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.errors import BadInput
from posreal.units import engineering, exact_quantity, quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("21 kN s/m", "N*s/m", 21_000),
        ("21kN·s/m", "N s/m", 21_000),
        ("2.31e6 kg m²", "kg*m**2", 2.31e6),
        ("2.31e6 kg m^2", "kg m^2", 2.31e6),
        ("38 t", "kg", 38_000),
        ("1225 mm", "m", 1.225),
        ("198 km/h", "m/s", 55),
        ("55", "m/s", 55),
        (55, "m/s", 55),
        (0.1, "m", 0.1),
        (Fraction(1, 4), "m", 0.25),
        ("6 deg", "rad", 0.10471975511965977),
        ("1 kN/mm", "N/m", 1e6),
        ("9.8 m/s²", "m/s**2", 9.8),
        ("-3 mm", "m", -0.003),
        ("1 lbf/inch", "N/m", 175.12683524647637),
        ("1/3", "", 1 / 3),
    ],
)
def test_quantities(text, unit, value):
    assert quantity(text, unit) == pytest.approx(value, rel=1e-15)


def test_decimal_units_are_exact():
    assert exact_quantity("0.3 t", "kg") == 300
    assert exact_quantity("0.1 kN/mm", "N/m") == 100_000


@pytest.mark.parametrize(
    ("text", "unit", "says"),
    [
        ("3 kg", "N/m", "The unit 'kg' measures something else; give N/m, kN/m, MN/m or N/mm"),
        ("3 N/m", "kg", "measures something else; give kg, t or g"),
        ("3 florps", "kg", "The unit 'florps' is not known; give kg, t or g"),
        ("three kg", "kg", "'three kg' is not a number with a unit; write for example '2.5 kg'"),
        ("", "m", "is not a number"),
        ("nan", "m", "is not a number"),
        ("1 degC", "K", "give K"),
        ("1 K", "degC", "give degC"),
        (float("inf"), "m", "not a finite number"),
        (None, "m", "is not a number"),
        (True, "m", "is not a number"),
        ("1e99999 m", "m", "is not a"),
        ("3 m; import os", "m", "is not a unit"),
    ],
)
def test_what_is_refused(text, unit, says):
    with pytest.raises(BadInput, match=says):
        quantity(text, unit)


@pytest.mark.parametrize(
    "text",
    ["1 m^9^9^9", "1 " + "m*" * 9999 + "m", "1" * 99_999 + " m", "1 m**99999999", "1 ((((m", "1 m**-m"],
)
def test_hostile_units_are_refused_at_once(text):
    start = time.perf_counter()
    with pytest.raises(BadInput) as refusal:
        quantity(text, "m")
    assert time.perf_counter() - start < 1
    assert len(str(refusal.value)) < 200


@given(st.text(max_size=30))
def test_any_text_is_a_number_or_advice(text):
    with suppress(BadInput):
        assert isinstance(quantity(text, "N/m"), float)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.41e6, "N/m", "1.41 MN/m"),
        (57_800, "N*s/m", "57.8 kN·s/m"),
        (57_800, "N s/m", "57.8 kN·s/m"),
        (312, "kg", "312 kg"),
        (31_234, "kg", "31200 kg"),
        (0.0042, "kg", "4.2 g"),
        (999.6, "N/m", "1 kN/m"),
        (0.5, "", "0.5"),
        (1e-7, "", "1e-7"),
        (2.5e15, "N/m", "2.5e15 N/m"),
        (3e-15, "N/m", "3e-15 N/m"),
        (2.31e6, "kg*m**2", "2.31 Mkg·m²"),
        (0, "N/m", "0 N/m"),
        (-1500, "N/m", "-1.5 kN/m"),
        (Fraction(1, 3), "m", "333 mm"),
    ],
)
def test_engineering(value, unit, text):
    assert engineering(value, unit) == text


def test_engineering_digits_and_ascii():
    assert engineering(57_812.5, "N*s/m", digits=5, ascii=True) == "57.813 kN*s/m"
    assert engineering(3e-6, "m", ascii=True) == "3 um"
    with pytest.raises(BadInput, match="ask for one or more"):
        engineering(1, "m", digits=0)


@given(st.floats(1e-9, 1e12), st.integers(1, 9))
def test_engineering_says_the_value_to_its_digits(value, digits):
    assert quantity(engineering(value, "N/m", digits), "N/m") == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits))
