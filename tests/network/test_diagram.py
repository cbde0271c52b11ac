import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posreal.errors import BadDevice, BadInput
from posreal.network import Spring, bridge, nodal_admittance, parse, series
from posreal.network.diagram import diagram
from tests.network.reading import read_diagram
from tests.strategies import bridges, networks, trees

GOLDEN = {
    "k=1.41 MN/m | (c=57.8 kN s/m + (k=3e5 | b=312))": """\
  body ─┬──────[ k1 ]──────┬─ bogie
        └─[ c ]─┬─[ k2 ]─┬─┘
                └─[ b ]──┘
  k1 = 1.41 MN/m     c = 57.8 kN·s/m    k2 = 300 kN/m      b = 312 kg""",
    "k + c + b": "  body ─[ k ]─[ c ]─[ b ]─ bogie",
    "k | c | b": """\
  body ─┬─[ k ]─┬─ bogie
        ├─[ c ]─┤
        └─[ b ]─┘""",
    "(ke | ce) + (b | (c + k))": """\
  body ─┬─[ ke ]─┬─┬────[ b ]────┬─ bogie
        └─[ ce ]─┘ └─[ c ]─[ k ]─┘""",
    "{1-2: k, 1-3: c, 2-3: b, 2-0: c, 3-0: k}": """\
  body ─┬─[ k1 ]─┬─[ b ]─┬─[ k2 ]─┬─ bogie
        └─[ c1 ]─│───────┘        │
                 └─────────[ c2 ]─┘""",
    "{1-2: k=1, 2-0: b=1, 3-0: c=4, 1-2-3: n=1/2}": """\
  body ─┬──[ k ]──┐   ┌─[ c ]─┬─ bogie
        │         ├───│─[ b ]─┘
        ╞1═[ n ]══△══n╡
  k = 1 N/m      b = 1 kg       c = 4 N·s/m
  n = 0.5 (far arm / near arm)""",
}


@pytest.mark.parametrize(("text", "drawing"), GOLDEN.items())
def test_golden(text, drawing):
    assert diagram(parse(text)) == drawing


def test_ascii():
    assert (
        diagram(parse("k=3e5 | (c=57.8 kN s/m + b)"), ascii=True)
        == """\
  body -+----[ k ]----+- bogie
        +-[ c ]-[ b ]-+
  k = 300 kN/m       c = 57.8 kN*s/m"""
    )


def test_terminals_and_digits():
    drawing = diagram(Spring(123456), ("sprung mass", "unsprung"), digits=2)
    assert drawing == "  sprung mass ─[ k ]─ unsprung\n  k = 120 kN/m"


@given(networks(25), st.sampled_from((40, 60, 100)), st.booleans())
def test_every_element_is_drawn_once_and_within_the_width(network, width, plain):
    drawing = diagram(network, width=width, ascii=plain)
    tags = re.findall(r"\[ (\w+) \]", drawing)
    assert sorted(tags) == sorted(network.names)
    assert max(len(row) for row in drawing.split("\n")) <= width
    assert not plain or drawing.isascii()
    for name, value in network.exact_values().items():
        assert value
        assert re.search(rf"(?<!\w){name} = ", drawing)


@given(st.one_of(trees(25), bridges(4)), st.sampled_from((60, 100, 400)))
def test_the_lines_alone_tell_the_network(network, width):
    elements = dict(zip(network.names, network.elements(), strict=True))
    drawing = diagram(network, width=width, legend=False)
    drawn = read_diagram(drawing, {name: part.unnamed() for name, part in elements.items()}, ("body", "bogie"))
    assert nodal_admittance(drawn) == nodal_admittance(network)


def test_a_crossing_read_as_a_joint_would_be_another_network():
    network = parse("{1-2: k=1, 1-3: c=2, 2-3: b=3, 2-0: c=4, 3-0: k=5}")
    elements = {name: part.unnamed() for name, part in zip(network.names, network.elements(), strict=True)}
    drawing = diagram(network, legend=False)
    assert read_diagram(drawing, elements, ("body", "bogie")).admittance() == network.admittance()
    with pytest.raises(BadDevice):
        read_diagram(drawing.replace("─│─", "─┼─"), elements, ("body", "bogie"))


def test_a_long_chain_is_broken_into_named_rows():
    assert diagram(series(*[Spring()] * 9), width=40).split("\n\n") == [
        "  body ─( A )─( B )─( C )─ bogie",
        "     A ─[ k1 ]─[ k2 ]─[ k3 ]─",
        "     B ─[ k4 ]─[ k5 ]─[ k6 ]─",
        "     C ─[ k7 ]─[ k8 ]─[ k9 ]─",
    ]


def test_a_graph_too_wide_for_rails_is_listed():
    part = parse("k + c")
    drawing = diagram(bridge(part, part, part, part, part), width=40)
    assert drawing.split("\n\n")[1].split("\n") == [
        "     A  from node 1 to node 0:",
        "        1─( B )─2   1─( C )─3",
        "        2─( D )─3   2─( E )─0",
        "        3─( F )─0",
    ]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"width": 20}, "20 columns wide cannot be read; give 40"),
        ({"terminals": ("b" * 60, "x")}, "cannot be drawn"),
        ({"terminals": ("a\nb", "x")}, "cannot be drawn"),
        ({"terminals": ("Aufbau ü", "x"), "ascii": True}, "cannot be drawn"),
    ],
)
def test_what_cannot_be_drawn(options, says):
    with pytest.raises(BadInput, match=says):
        diagram(Spring(1), **options)
