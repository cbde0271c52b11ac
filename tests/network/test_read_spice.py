"""Decks read back: posreal's own to the last digit, other people's by what stands between which nodes."""

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.errors import BadDevice
from posreal.network import nodal_admittance, parse
from posreal.network.read_device import read_device
from posreal.network.read_spice import read_spice
from posreal.network.spice import spice
from tests.network.test_spice import SAMPLE
from tests.strategies import networks


@pytest.mark.parametrize("text", SAMPLE.values(), ids=SAMPLE.keys())
def test_every_deck_of_ours_is_read_back(text):
    network = parse(text)
    assert read_spice(spice(network, title="A strut", frequencies=(0.01, 30))) == network


@settings(max_examples=40)
@given(networks(8))
def test_drawn_networks_come_back(network):
    assert read_spice(spice(network)) == network


@settings(max_examples=40)
@given(networks(6))
def test_elements_alone_say_the_same(network):
    """Without the comment, from the elements between their nodes; values are the floats that the deck has."""
    deck = "\n".join(line for line in spice(network).splitlines() if "As posreal writes" not in line)
    if "m1" in deck or network.counts.levers:  # by controlled sources
        with pytest.raises(BadDevice, match="no resistor"):
            read_spice(deck)
        return
    deck = "\n".join(line for line in deck.splitlines() if not line.startswith("Hport"))
    s = 1j
    assert complex(read_spice(deck).admittance()(s)) == pytest.approx(complex(network.admittance()(s)), rel=1e-9)


def test_an_edited_deck_is_read_by_its_elements():
    deck = spice(parse("k=1000 | (c=20 + b=3)")).replace("0.05", "0.1").replace("Hport", "* ")
    assert read_spice(deck).admittance() == parse("k=1000 | (c=10 + b=3)").admittance()


def test_a_bridge_between_the_nodes_of_a_source():
    deck = """a bridge
    V1 a b AC 1
    R1 a c 4.7k ; a comment
    l2 c b
    + 10mH
    C3 a d 1u
    R4 d b 1meg
    R5 c d 5e0
    .ac dec 10 1 1e6
    .end
    X9 nobody reads this"""
    network = read_spice(deck)
    assert nodal_admittance(network) == nodal_admittance(
        parse("{1-2: c1=1/4700, 2-0: k2=100, 1-3: b3=1e-6, 3-0: c4=1e-6, 2-3: c5=0.2}")
    )


def test_joints_are_put_together():
    assert str(read_spice("t\nL1 1 2 1m\nR2 2 0 2\nC3 1 gnd 300\n")) == "b3=300 | k1=1000 + c2=0.5"


@pytest.mark.parametrize(
    ("deck", "said"),
    [
        ("t\n", "no resistor"),
        ("t\nX1 1 0 2", "line 2.*no resistor R"),
        ("t\n\nR1 1 0", "line 3.*no element"),
        ("t\nR1 1 0 x", "'x' is not a value"),
        ("t\nR1 1 0 0", "above 0"),
        ("t\nR1 1 0 -5k", "above 0"),
        ("t\nR1 2 3 5", "terminal '1'"),
        ("t\nV1 1 0 1\nI2 1 0 1\nR1 1 0 5", "2 sources"),
        ("t\nR1 1 0 5\nR2 0 7 3", "no way from"),
        ("t\nR1 1 1 5\nR2 1 0 5", "begins and ends"),
        ("t\nR1 1 0 1e9999", "exponent|finite|size|large"),
    ],
)
def test_another_deck_is_refused_in_a_sentence(deck, said):
    with pytest.raises(BadDevice, match=said):
        read_spice(deck)


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    with suppress(BadDevice):
        read_spice("t\nR1 1 0 5\n" + text)


def test_a_file_is_read_by_its_ending(tmp_path):
    path = tmp_path / "strut.cir"
    path.write_text("t\nR1 1 0 0.05\n")
    assert str(read_device(str(path))) == "c1=20"
