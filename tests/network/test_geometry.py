from hypothesis import given
from hypothesis import strategies as st

from posreal.network import Graph, nodal_admittance
from posreal.network.geometry import LENGTH, geometry
from tests.network.reading import Joined
from tests.strategies import bridges, networks, trees


def key(point):
    return tuple(round(x, 6) for x in point)


def on(point, wire):
    (x0, y0), (x1, y1) = wire
    return min(x0, x1) - 1e-6 <= point[0] <= max(x0, x1) + 1e-6 and min(y0, y1) - 1e-6 <= point[1] <= max(y0, y1) + 1e-6


def read(plan):
    """The graph that the lines show: a wire's end joins what it lies on; wires that cross do not touch."""
    joined = Joined()
    ends = [(e.x + dx, e.y) for e in plan.elements for dx in (0, LENGTH)]
    points = [point for wire in plan.wires for point in wire] + ends
    for wire in plan.wires:
        for point in points:
            if on(point, wire):
                joined.join(key(wire[0]), key(point))
    branches = [
        (joined.of(key((e.x, e.y))), joined.of(key((e.x + LENGTH, e.y))), e.element.unnamed()) for e in plan.elements
    ]
    return Graph(tuple(branches), terminals=(joined.of(key((0, 0))), joined.of(key((plan.width, 0)))))


@given(st.one_of(trees(16), bridges(3)))
def test_the_wires_alone_tell_the_network(network):
    assert nodal_admittance(read(geometry(network))) == nodal_admittance(network)


@given(networks(16))
def test_nothing_lies_on_anything(network):
    plan = geometry(network)
    places = [(e.y, e.x) for e in plan.elements]
    assert len(plan.elements) + len(plan.beams) == len(network)
    for i, (y, x) in enumerate(places):
        assert 0 <= x <= plan.width - LENGTH
        assert 0 <= y < plan.rows
        assert all(other[0] != y or abs(other[1] - x) >= LENGTH for other in places[:i])


@given(networks(12))
def test_every_element_is_placed_under_its_own_name(network):
    plan = geometry(network)
    placed = {p.name: p.element for p in plan.elements} | {b.name: b.lever for b in plan.beams}
    assert placed == dict(zip(network.names, network.elements(), strict=True))
