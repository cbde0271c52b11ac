from hypothesis import given

from posreal.network import Element, Parallel, Series, parse
from posreal.network.simplify import simplified
from tests.strategies import networks


def joints(network):
    if isinstance(network, Series | Parallel):
        yield network
    for child in getattr(network, "children", ()):
        yield from joints(child)


@given(networks(10))
def test_simplifying_keeps_the_device_and_leaves_no_twins(network):
    smaller = simplified(network)
    assert smaller.admittance() == network.admittance()
    assert len(smaller) <= len(network)
    assert simplified(smaller) == smaller
    for joint in joints(smaller):
        letters = [child.letter for child in joint.children if isinstance(child, Element)]
        assert len(letters) == len(set(letters))


def test_examples():
    assert simplified(parse("k=2 + k=2")) == parse("k=1")
    assert simplified(parse("b=1 | (b=6 + (b=1 | b=2)) | c=1")) == parse("b=3 | c=1")
    assert simplified(parse("ka=2 | c | k")) == parse("ka | c")
