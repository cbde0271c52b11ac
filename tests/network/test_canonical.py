import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.errors import BadDevice
from posreal.network import Damper, Element, Graph, Inerter, Parallel, Series, Spring, parallel, parse, series
from posreal.network.canonical import canonical, canonical_key, isomorphic
from tests.strategies import bridges, networks, trees


def shuffled(network, random):
    if isinstance(network, Series | Parallel):
        children = [shuffled(child, random) for child in network.children]
        random.shuffle(children)
        return type(network)(tuple(children))
    return network


@given(networks(8), st.randoms())
def test_order_does_not_matter(network, random):
    other = shuffled(network.unnamed(), random)
    assert isomorphic(network, other, values=True)
    assert canonical(network.unnamed()) == canonical(other)
    assert canonical(network).admittance() == network.admittance()


@given(trees(6), trees(6))
def test_networks_of_one_key_and_values_are_one_device(a, b):
    if canonical_key(a, values=True) == canonical_key(b, values=True):
        assert a.admittance() == b.admittance()
    assert isomorphic(a, b) == (canonical(a.topology().unnamed()) == canonical(b.topology().unnamed()))


@given(bridges(1), st.permutations([2, 3]), st.booleans())
def test_numbering_of_a_graph_does_not_matter(network, inner, turned):
    number = dict(zip((1, 0, 2, 3), ((0, 1) if turned else (1, 0)) + tuple(inner), strict=True))
    other = Graph(tuple((number[v], number[u], part) for u, v, part in reversed(network.branches)))
    assert isomorphic(network, other, values=True)


def test_keys():
    assert canonical_key(parse("(b + k1) | c | (k2 | b) + c")) == "((b|k)+c)|(b+k)|c"
    assert canonical_key(parse("k=2 | c"), values=True) == "c|k=2"
    assert canonical_key(parse("{1-2: b, 2-0: k, 3-0: c, 3-2-1: n=2}"), values=True) == canonical_key(
        parse("{1-2: b, 2-0: k, 3-0: c, 1-2-3: n=1/2}"), values=True
    )


@pytest.mark.parametrize(("count", "number"), [(2, 6), (3, 20), (4, 90), (5, 432)])
def test_there_are_as_many_topologies_as_theory_says(count, number):
    """Alternating trees over {k, c, b} with no two equal elements at one joint, children unordered."""
    found = {canonical_key(tree) for tree in every(count, Series) + every(count, Parallel)}
    assert len(found) == number


def every(count, joint):
    if count == 1:
        return [Spring(), Damper(), Inerter()]
    other = Parallel if joint is Series else Series
    trees = {}
    for parts in partitions(count):
        for children in itertools.product(*([*every(part, other)] for part in parts)):
            leaves = [child.letter for child in children if isinstance(child, Element)]
            if len(leaves) == len(set(leaves)):
                tree = (series if joint is Series else parallel)(*children)
                trees[canonical_key(tree)] = tree
    return list(trees.values())


def partitions(count, most=None):
    """Falling sequences of two or more numbers that add up to count."""
    most = count - 1 if most is None else most
    for first in range(min(count, most), 0, -1):
        rest = count - first
        if rest == 0:
            yield (first,)
        else:
            yield from ((first, *tail) for tail in partitions(rest, first))


def test_a_graph_too_large_to_compare_says_so():
    ladder = Graph((*((i, i + 1, Spring()) for i in range(1, 10)), (10, 0, Spring())))
    with pytest.raises(BadDevice, match="9 inner nodes is too large"):
        canonical_key(ladder)
