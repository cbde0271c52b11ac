"""Elements opened and shorted, against what the whole network does as their values go to 0 and to infinity."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.errors import BadDevice
from posreal.network import isomorphic, parse
from posreal.network.removal import removed
from tests import strategies


@pytest.mark.parametrize(
    ("text", "index", "opened", "shorted"),
    [
        ("k1=2 | (c=1 + k2=3)", 1, "k=2", "k=5"),
        ("k1=2 | (c=1 + k2=3)", 0, "c=1 + k=3", None),
        ("c=4", 0, None, None),
        ("k=2 + c=3", 1, None, "k=2"),
        ("k1=2 + c=3 + (k2=6 | b=1)", 3, "k=1.5 + c=3", "k1=2 + c=3"),
        ("{1-2: b=1, 1-3: c=2, 2-3: k=3, 2-0: c=4, 3-0: c=5}", 2, "(b=1 + c=4) | (c=2 + c=5)", "(b=1 | c=2) + c=9"),
        (
            "{1-2: b=1, 1-3: c=2, 2-3: k=3, 2-0: c=4, 3-0: c=5}",
            0,
            "c=2 + (c=5 | (k=3 + c=4))",
            "(c=2 | k=3) + c=5 | c=4",
        ),
    ],
)
def test_what_is_left(text, index, opened, shorted):
    network = parse(text)
    for wanted, short in ((opened, False), (shorted, True)):
        found = removed(network, index, shorted=short)
        if wanted is None:
            assert found is None
        else:
            assert found is not None
            assert found.admittance() == parse(wanted).admittance()
            assert len(found) < len(network)


def test_like_elements_merge_and_names_are_given_anew():
    found = removed(parse("k1=2 | (c=1 + k2=3)"), 1, shorted=True)
    assert str(found) == "k=5"
    kept = removed(parse("{1-2: b=1, 1-3: c=2, 2-3: k=3 + b=7, 2-0: c=4, 3-0: c=5}"), 2, shorted=True)
    assert isomorphic(kept, parse("{1-2: b=1, 1-3: c=2, 2-3: b=7, 2-0: c=4, 3-0: c=5}"))


@settings(deadline=None, max_examples=60)
@given(st.one_of(strategies.trees(7, least=2), strategies.bridges()), st.data())
def test_a_removed_element_is_the_limit_of_its_value(network, data):
    index = data.draw(st.integers(0, len(network) - 1))
    shorted = data.draw(st.booleans())
    name = network.names[index]
    limit = network.with_values({name: Fraction(10) ** (15 if shorted else -15)}).admittance()
    found = removed(network, index, shorted=shorted)
    for s in (Fraction(3, 10), Fraction(1), Fraction(4)):  # where every admittance is positive
        wanted = float(limit.exact_value(s))
        if found is None:
            assert wanted > 1e9 or wanted < 1e-9
        else:
            assert float(found.admittance().exact_value(s)) == pytest.approx(wanted, rel=1e-6)


def test_levers_are_refused():
    with pytest.raises(BadDevice, match="levers"):
        removed(parse("{1-2: k=1, 2-0: c=1, 3-0: b=1, 1-2-3: n=2}"), 0, shorted=True)
