from fractions import Fraction

import pytest
from flint import fmpq
from hypothesis import given

from posreal.admittance import Rational
from posreal.errors import BadDevice
from posreal.network import (
    Counts,
    Damper,
    Inerter,
    Parallel,
    Series,
    Spring,
    nodal_admittance,
    parallel,
    parse,
    series,
)
from tests.strategies import trees

K, C, B = Spring(2), Damper(3), Inerter(5)


def test_one_element_is_its_own_admittance():
    assert K.admittance() == Rational.spring(2)
    assert C.admittance() == Rational.damper(3)
    assert B.admittance() == Rational.inerter(5)


def test_series_binds_tighter_than_parallel():
    assert Parallel((K, Series((C, B)))) == (K | C + B)


def test_joints_of_one_kind_are_one_joint():
    assert (K | (C | B)).children == (K, C, B)
    assert ((K + C) + B).children == (K, C, B)


def test_helpers_leave_a_single_network_alone():
    assert series(K) is K
    assert parallel(K) is K
    assert series(K, C) == K + C


@given(trees(10))
def test_tree_and_nodal_analysis_agree_exactly(network):
    assert network.admittance() == nodal_admittance(network)


@given(trees(8, decades=10))
def test_values_spread_over_ten_decades_change_nothing(network):
    assert network.admittance() == nodal_admittance(network)


@given(trees(8, kinds="kb"))
def test_without_dampers_the_admittance_is_odd(network):
    y = network.admittance()
    assert y.exact_response(Fraction(7, 11) + 1)[0] == 0


@given(trees(8))
def test_degree_is_at_most_the_number_of_springs_and_inerters(network):
    assert network.admittance().degree <= network.counts.springs + network.counts.inerters


def test_names_are_numbered_where_absent():
    network = K | C + K | Damper(1, "ce") | Spring(1, "k2")
    assert network.names == ("k1", "c", "k3", "ce", "k2")
    assert network.counts == Counts(springs=3, dampers=2, inerters=0, levers=0)
    assert network.counts.total == len(network) == 5


def test_a_single_element_of_a_kind_keeps_the_bare_letter():
    assert parse("k + (c1 | (c + b))").names == ("k", "c1", "c", "b")


def test_a_bare_letter_given_as_a_name_is_no_name():
    assert Spring(1, "k").name is None
    assert (Spring(1, "k") | Spring(2, "k")).names == ("k1", "k2")


def test_a_name_given_twice_is_refused():
    with pytest.raises(BadDevice, match=r"Two elements are called 'k1'.*unnamed"):
        _ = Spring(1, "k1") | Spring(2, "k1")
    assert (Spring(1, "k1").unnamed() | Spring(2, "k1")).names == ("k", "k1")


def test_equality_is_form_values_and_names():
    assert Spring(2, "k") | Damper(3) == K | C
    assert K | C != C | K
    assert Spring(2, "ka") != K
    assert hash(K | C) == hash(Spring("2") | Damper(Fraction(3)))
    assert K != "k"


@pytest.mark.parametrize("value", [3, 3.0, "3", "3.0e0", Fraction(3), fmpq(3), "6/2"])
def test_a_value_may_be_any_kind_of_number(value):
    assert Spring(value).value == 3


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (0, "above zero"),
        (-2.5, "-2.5 N/m"),
        (float("nan"), "finite"),
        (float("inf"), "finite"),
        (1e-310, "out of range"),
        ("x", "not a number"),
        (True, "not a number"),
        (1j, "not a number"),
    ],
)
def test_a_value_that_is_none_is_refused_by_name(value, says):
    with pytest.raises(BadDevice, match=says):
        Spring(value, "k7")


def test_an_error_names_the_element():
    with pytest.raises(BadDevice, match=r"The spring k7 is 0 N/m; give a value above zero\."):
        Spring(0, "k7")
    with pytest.raises(BadDevice, match="'x1' cannot name a damper"):
        Damper(1, "x1")


def test_values_by_name():
    layout = parse("k | (c + b)")
    assert not layout.is_valued
    assert layout.values() == {}
    device = layout.with_values({"k": 2e5, "c": "21 kN s/m", "b": Fraction(1, 3)})
    assert device.is_valued
    assert device.values() == {"k": 2e5, "c": 21000.0, "b": 1 / 3}
    assert device.exact_values()["b"] == Fraction(1, 3)
    assert device.with_values({"k": 1}).values()["k"] == 1
    assert device.topology() == layout


def test_with_values_names_the_culprit():
    with pytest.raises(BadDevice, match="There is no element 'x' here; give k, c or b"):
        parse("k | (c + b)").with_values({"x": 1})
    with pytest.raises(BadDevice, match="The damper c2 is -1 N s/m"):
        parse("c | c").with_values({"c2": -1})
    with pytest.raises(BadDevice, match="'kg' measures something else"):
        parse("c | c").with_values({"c2": "1 kg"})


@given(trees(8, decades=10))
def test_float_values_come_back_as_they_went_in(network):
    floats = {name: value * 1.1 for name, value in network.values().items()}
    assert network.with_values(floats).values() == floats


def test_a_missing_value_is_named():
    for ask in (Parallel.admittance, nodal_admittance, lambda network: network(1j)):
        with pytest.raises(BadDevice, match=r"The damper c.* has no value yet"):
            ask(parse("k=1 | c2"))


def test_what_is_no_network_is_refused():
    with pytest.raises(BadDevice, match="'k=2' is not a network"):
        Parallel((K, "k=2"))
    with pytest.raises(BadDevice, match="joins two networks or more and got 1"):
        Series((K,))
    with pytest.raises(TypeError):
        _ = K + 3


def test_depth_is_limited():
    network = K
    for _ in range(99):
        network = C | (K + network)
    assert network.depth == 199
    assert network.admittance()(1.0) == pytest.approx(network(1.0).real)
    with pytest.raises(BadDevice, match="nested more than 200 levels"):
        _ = C | (K + network)
