from fractions import Fraction

import pytest
from hypothesis import given

from posreal.admittance import Rational
from posreal.errors import BadDevice
from posreal.network import Damper, Graph, Inerter, Lever, Spring, bridge, parse
from tests.strategies import trees, values

BIQUADRATIC = Rational([4, 1, 1], [1, 1, 1])  # Y of THEORY's worked example: Z = (s²+s+1)/(s²+s+4)


def test_brune_with_a_lever_is_the_worked_example():
    """Coupled coils 1, ¼ and mutual ½ are the spring 1 beside a lever of ratio ½."""
    network = parse("{1-2: k=1, 2-0: b=1, 3-0: c=4, 1-2-3: n=1/2}")
    assert network.admittance() == BIQUADRATIC
    assert network.counts == (1, 1, 1, 1)


def test_bott_duffin_of_the_worked_example():
    network = parse("(c=4 | (k=6 + b=3) | b=2) + ((c=1 + (k=4/3 | b=2/3)) | k=2)")
    assert network.admittance() == BIQUADRATIC
    assert len(network) == 8


@given(trees(4), values(2))
def test_a_lever_with_a_fixed_pivot_scales_by_the_square_of_its_ratio(load, ratio):
    network = Graph(((3, 0, load),), ((1, 0, 3, Lever(ratio)),))
    assert network.admittance() == load.admittance().scaled(ratio**2)


@given(trees(3), trees(3), values(2))
def test_ends_of_a_lever_may_be_exchanged(leg, load, ratio):
    one = Graph(((1, 2, leg), (2, 0, leg), (3, 0, load)), ((1, 2, 3, Lever(ratio)),))
    other = Graph(((1, 2, leg), (2, 0, leg), (3, 0, load)), ((3, 2, 1, Lever(1 / ratio)),))
    assert one.admittance() == other.admittance()


@given(trees(2), trees(2), trees(3))
def test_a_balanced_bridge_does_not_feel_its_cross_branch(left, right, cross):
    network = bridge(left, left, cross, right, right)
    half = left + right
    assert network.admittance() == half.unnamed().admittance().scaled(2)


def test_bridge_of_dampers():
    """By hand: 9x − 5y = 1 and −5x + 11y = 2 give x = 21/74, y = 23/74, and Y = (1 − x) + 2(1 − y)."""
    assert bridge(*(Damper(c) for c in (1, 2, 5, 3, 4))).admittance() == Rational.damper(Fraction(155, 74))


def test_inner_nodes_are_numbered_as_they_appear():
    network = Graph((("top", "x", Spring(1)), ("x", "low", Damper(2))), terminals=("top", "low"))
    assert str(network) == "{1-2: k=1, 2-0: c=2}"
    assert network.terminals == (1, 0)


@pytest.mark.parametrize(
    ("branches", "levers", "says"),
    [
        (((1, 1, Spring(1)),), (), "begins and ends at node 1"),
        (((1, 2, Spring(1)),), (), "Node 2 is on no way"),
        (((1, 0, Spring(1)), (5, 6, Spring(1))), (), "Node 2 is on no way"),
        (((1, 0, "k"),), (), "is not a branch"),
        (((1, 0, Spring(1)),), ((1, 0, Lever(1)),), "is not a lever"),
        (((1, 0, Spring(1)),), ((1, 2, 2, Lever(1)),), "is not a lever"),
    ],
)
def test_what_is_no_two_terminal_graph_is_refused(branches, levers, says):
    with pytest.raises(BadDevice, match=says):
        Graph(branches, levers)


def test_a_device_has_two_terminals():
    with pytest.raises(BadDevice, match="Both terminals are node 1"):
        Graph(((1, 0, Spring(1)),), terminals=(1, 1))


def test_a_lever_that_leaves_a_node_loose_is_found():
    chain = ((1, 2, 3), (3, 4, 5), (5, 6, 0))
    with pytest.raises(BadDevice, match="can move without any force"):
        Graph(((1, 0, Spring(1)), (2, 6, Spring(1))), tuple((*at, Lever(2)) for at in chain)).admittance()


def test_a_lever_between_the_terminals_alone_is_found():
    rigid = Graph(((1, 2, Spring(1)), (2, 0, Spring(1))), ((1, 2, 0, Lever(2)), (1, 2, 0, Lever(3))))
    with pytest.raises(BadDevice, match="holds the two terminals together"):
        rigid.admittance()


def test_a_ratio_of_zero_is_refused():
    with pytest.raises(BadDevice, match="ratio 0"):
        Lever(0)
    assert Lever(-2).value == -2


def test_values_of_a_graph_by_name():
    network = bridge(Spring(), Damper(), Inerter(), Damper(), Spring())
    assert network.names == ("k1", "c1", "b", "c2", "k2")
    assert network.with_values(dict.fromkeys(network.names, 2)) == bridge(
        Spring(2), Damper(2), Inerter(2), Damper(2), Spring(2)
    )
