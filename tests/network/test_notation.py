from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.admittance import Rational
from posreal.errors import BadDevice
from posreal.network import Damper, Graph, Inerter, Lever, Parallel, Series, Spring, parse
from posreal.network.value import read_value, write_value
from tests.strategies import networks, trees
from tests.work import counted_calls


@given(networks(8, decades=10))
def test_text_reads_back_as_the_same_network(network):
    assert parse(str(network)) == network
    assert str(parse(str(network))) == str(network)


@given(trees(8))
def test_a_topology_reads_back_too(network):
    assert parse(str(network.topology())) == network.topology()


@given(st.floats(1e-200, 1e200) | st.fractions(min_value="1/1000000000000"))
def test_every_digit_of_a_value_survives(value):
    if value > 0:
        assert parse(str(Spring(value))).values()["k"] == float(value)
        assert parse(str(Spring(value))) == Spring(value)


@given(st.fractions())
def test_numbers_are_written_as_they_are_read(value):
    assert read_value(write_value(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("2.45e5", "245000"),
        (0.1, "0.1"),
        ("1/3", "1/3"),
        (2.5e-7, "2.5e-7"),
        (1e16, "1e16"),
        (1e300, "1e300"),
        (12.0, "12"),
    ],
)
def test_values_are_written_short(value, text):
    assert write_value(read_value(value)) == text


@pytest.mark.parametrize(
    ("text", "network"),
    [
        ("k=2", Spring(2)),
        (" ( k=2e0 ) ", Spring(2)),
        ("k=1|c=2+b=3", Parallel((Spring(1), Series((Damper(2), Inerter(3)))))),
        ("(k=1|c=2)+b=3", Series((Parallel((Spring(1), Damper(2))), Inerter(3)))),
        ("ke = 5e+6", Spring(5_000_000, "ke")),
        ("k=1e+5+c=2", Series((Spring(100_000), Damper(2)))),
        ("k = 245 kN/m", Spring(245_000)),
        ("k=0.3 N/mm", Spring(300)),
        ("c=21kN·s/m", Damper(21_000)),
        ("c=21 kN s/m", Damper(21_000)),
        ("c=21 kN*s/m", Damper(21_000)),
        ("b=0.3 t", Inerter(300)),
        ("k=1/3", Spring("1/3")),
        ("k1 | cx", Parallel((Spring(None, "k1"), Damper(None, "cx")))),
        ("{1-2: k=1, 2-0: c=2}", Graph(((1, 2, Spring(1)), (2, 0, Damper(2))))),
        ("{1-a:k=1|c=2,a-0:c=2}+b", Graph(((1, 2, Spring(1) | Damper(2)), (2, 0, Damper(2)))) + Inerter()),
        ("{2-0: k=1, 1-0-2: n=-1/2}", Graph(((2, 0, Spring(1)),), ((1, 0, 2, Lever("-1/2")),))),
    ],
)
def test_what_is_accepted(text, network):
    assert parse(text) == network


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "the end, where an element"),
        ("k=", "k at position 0: '' is not a number"),
        ("k=2 | ", "the end, where an element"),
        ("k=2)", r"'\)' at position 3, where '\|', '\+' or the end"),
        ("(k=2", r"the end, where '\)'"),
        ("k=2 | q=3", "'q' at position 6, where a name beginning with k"),
        ("k=2 | 3", "'3' at position 6"),
        ("k=-2", "A spring is -2 N/m; give a value above zero"),
        ("k=0", "give a value above zero"),
        ("k=nan", "'nan' is not a number"),
        ("k=inf", "'inf' is not a number"),
        ("k=1e999", "out of range"),
        ("k=1e99999", "is not a"),
        ("c=2 kg", "The unit 'kg' measures something else; give N s/m"),
        ("b=2 parsecs/fortnite", "The unit 'parsecs/fortnite' is not known; give kg, t or g"),
        ("k=2 m**99999999", "is not a unit"),
        ("k1=1 | k1=2", "Two elements are called 'k1'"),
        ("n=3", "stands on three nodes"),
        ("{1-2: k}", "Node 2 is on no way"),
        ("{1-2 k}", "an edge such as"),
        ("{1-2-0: k}", "takes a lever"),
        ("{1-0: k", "',' or '}'"),
        ("k=__import__('os')", "is not a number"),
        (None, "is not text"),
    ],
)
def test_what_is_refused(text, says):
    with pytest.raises(BadDevice, match=says):
        parse(text)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 90_000,
        "k+" * 40_000 + "k",
        "k=" + "9" * 90_000,
        "k=1 " + "m*" * 40_000,
        "k" * 200_000,
        "{1-2:" * 15_000,
        "k=1 " + "m**9" * 9,
        "k=1" + "/1" * 999,
        "|" * 99_999,
        "(k=1+" * 5_000,
        "k=1 kg^9^9^9",
    ],
)
def test_hostile_text_is_refused_with_no_more_work_than_it_is_long(text):
    parse("k=1 N/m")
    with pytest.raises(BadDevice) as refusal, counted_calls() as calls:
        parse(text)
    assert calls() < 500 + len(text)
    assert len(str(refusal.value)) < 300


@given(st.text("kcbn12=|+(){}:,- .e/\x00Nmkgs·²", max_size=30) | st.text(max_size=20))
def test_any_text_is_a_network_or_advice(text):
    try:
        network = parse(text)
    except BadDevice:
        return
    assert parse(str(network)) == network


def test_a_float_is_the_decimal_it_prints_as():
    """In a coefficient it is the binary fraction it is; see `posreal.network.value` for why they differ."""
    assert Spring(0.3).exact == Fraction(3, 10)
    assert repr(Spring(0.3)) == "parse('k=0.3')"
    assert Spring(np.float64(0.3)) == Spring(Decimal("0.3")) == parse("k=0.3")
    assert Rational.spring(0.3) == Rational([Fraction(0.3)], [0, 1]) != Spring(0.3).admittance()
