from contextlib import suppress
from fractions import Fraction

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.errors import BadInput
from posreal.units import engineering, exact_quantity, quantity
from tests.work import counted_calls


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
        ("5 %", "1", 0.05),
        ("3 Hz", "rad/s", 18.84955592153876),
        (numpy.float32(0.25), "m", 0.25),
        (numpy.float64(0.1), "m", 0.1),
        (numpy.int64(3), "m", 3),
    ],
)
def test_quantities(text, unit, value):
    assert quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.3 t", "kg", "300"),
        ("0.1 kN/mm", "N/m", "1e5"),
        ("21 kNs/m", "N*s/m", "21000"),
        ("21 kN s/m", "N*s/m", "21000"),
        ("21 kN * s / m", "N*s/m", "21000"),
        ("7 Ns/mm", "N*s/m", "7000"),
        ("3 MN m/rad", "N*m/rad", "3e6"),
        ("3 kNms/rad", "N*m*s/rad", "3000"),
        ("1 kg", "N*s^2/m", "1"),
        ("5 kg m2", "kg m^2", "5"),
        ("3 m/s2", "m/s**2", "3"),
        ("2 s⁻¹", "1/s", "2"),
        ("4 m^-2", "1/m^2", "4"),
        ("1 mm²", "m^2", "1e-6"),
        ("0.7 Mg", "t", "0.7"),
        ("36 km/h", "m/s", "10"),
        ("36 kph", "m/s", "10"),
        ("100 mph", "km/h", "160.9344"),
        ("60 rpm", "Hz", "1"),
        ("1 h", "s", "3600"),
        ("1 kgf", "N", "9.80665"),
        ("1 ft", "mm", "304.8"),
        ("1 lbf/in", "N/m", "4.4482216152605/0.0254"),  # the pound-force of 1959 in newtons, and the inch
        ("1 lbf*s/inch", "N*s/m", "4.4482216152605/0.0254"),
        ("1 slug", "kg", "4.4482216152605/0.3048"),
        ("1 lb", "kg", "0.45359237"),
        ("2 mH", "ohm*s", "0.002"),
        ("3 µF", "s/Ω", "3e-6"),
        ("3 uF", "F", "3e-6"),
        ("2.2 kΩ", "V/A", "2200"),
    ],
)
def test_units_are_exact(text, unit, value):
    above, _, below = value.partition("/")
    assert exact_quantity(text, unit) == Fraction(above) / Fraction(below or 1)


def test_half_a_turn_is_pi_to_fifty_digits():
    pi = Fraction("3.14159265358979323846264338327950288419716939937510")
    assert abs(exact_quantity("180°", "rad") - pi) < Fraction(1, 10**49)


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
        ("3 kt", "kg", "The unit 'kt' is not known; give kg, t or g"),
        ("3 MMN", "N", "is not known"),
        ("3 N-s/m", "N*s/m", "is not a unit"),
        ("3 deg", "", "measures something else; give a plain number"),
        ("3 Hz", "1/s", "measures something else; give 1/s"),
        ("1e400 kg", "kg", "'1e400' is out of range; give one from 1e-300 to 1e300, for example '2.5 kg'"),
        ("1e-400", "kg", "out of range"),
        ("9e299 t", "kg", "A number above 1e300 is out of range"),
        ("9" * 400, "kg", "out of range"),
        ("9" * 5000, "kg", "out of range"),
        ("1/" + "9" * 5000, "kg", "out of range"),
    ],
)
def test_what_is_refused(text, unit, says):
    with pytest.raises(BadInput, match=says):
        quantity(text, unit)


@pytest.mark.parametrize("digits", [301, 400, 5000])  # from 4,300 on Python itself does not write them out
def test_long_whole_numbers_are_refused_in_a_sentence(digits):
    for number in (10**digits, -(10**digits), Fraction(10**digits)):
        with pytest.raises(BadInput, match="A number above 1e300 is out of range; give one from 1e-300 to 1e300, for"):
            quantity(number, "kg")
    with pytest.raises(BadInput, match="A number below 1e-300"):
        quantity(Fraction(1, 10**digits), "kg")
    assert quantity(10**300, "kg") == 1e300


@pytest.mark.parametrize(
    "text",
    ["1 m^9^9^9", "1 " + "m*" * 9999 + "m", "1" * 99_999 + " m", "1 m**99999999", "1 ((((m", "1 m**-m"],
)
def test_hostile_units_are_refused_without_work(text):
    quantity("1 m", "m")
    with pytest.raises(BadInput) as refusal, counted_calls() as calls:
        quantity(text, "m")
    assert calls() < 200
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
