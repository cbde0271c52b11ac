"""Real elements: an exact substitution of leaves, with its derivative, from a catalogue."""

from __future__ import annotations

import math

import numpy as np
import pytest

from posreal.errors import BadInput
from posreal.network import nodal_admittance, parse
from posreal.network.as_made import companions, leaf, made
from posreal.network.topologies import letters, topologies, valued
from posreal.real_elements import RAIL, Parasitics, RealElements, read_elements
from posreal.topology.batch import Grid, admittance

S = 1j * np.geomspace(0.5, 300, 40)
DAMPED = RealElements(
    spring=Parasitics(parallel_damping=300.0),
    damper=Parasitics(end_stiffness=4e6, end_damping=900.0),
    inerter=Parasitics(1e3, 5e6, 2e3),
)


def by_hand(kind: Parasitics, own: np.ndarray) -> np.ndarray:
    inside = own + kind.parallel_damping
    if math.isinf(kind.end_stiffness):
        return inside
    return 1 / (1 / inside + 1 / (kind.end_stiffness / S + kind.end_damping))


@pytest.mark.parametrize("elements", [RAIL, DAMPED], ids=["real", "damped"])
def test_every_leaf_is_replaced(elements):
    k, c, b = 3e5, 2e4, 400.0
    network = made(parse(f"(k={k} | c={c}) + b={b}"), elements)
    K, C, B = (by_hand(elements.of(x), own) for x, own in zip("kcb", (k / S, c + 0 * S, b * S), strict=True))
    by_rule = 1 / (1 / (K + C) + 1 / B)
    assert network(S) == pytest.approx(by_rule, rel=1e-12)
    assert nodal_admittance(network)(S) == pytest.approx(by_rule, rel=1e-9)


def test_names_stay_and_what_comes_with_an_element_is_named_after_it():
    network = made(parse("c=2e4 + (b1=300 | k1=1e5 + b2=200)"), RAIL, keep={"b2"})
    assert network.values() == {
        "c": 2e4, "k_end_c": 5e6, "b1": 300.0, "c_par_b1": 1e3, "k_end_b1": 5e6, "k1": 1e5, "b2": 200.0
    }  # fmt: skip
    assert companions(parse("c + (b1 | k1 + b2)"), RAIL, keep={"b2"}) == {
        "k_end_c": 5e6, "c_par_b1": 1e3, "k_end_b1": 5e6
    }  # fmt: skip
    assert made(network, None) is network
    assert made(parse("k=2 | c=3"), RealElements()) == parse("k=2 | c=3")
    bridge = made(valued(topologies(5)[-1], [1e5] * 5), DAMPED)
    assert bridge.counts[:3] == (5, 5, 0)


@pytest.mark.parametrize("elements", [RAIL, DAMPED], ids=["real", "damped"])
def test_many_values_at_once_are_the_network_s_with_its_derivative(elements):
    rng = np.random.default_rng(3)
    unit = {"k": 3e5, "c": 2e4, "b": 1e3}
    for form in [*topologies(1), *topologies(3)[::4], topologies(5)[-60], topologies(5)[-1]]:
        base = np.log([unit[x] for x in letters(form)])
        theta = base + rng.normal(size=(2, len(base)))
        Y, pull = admittance(form, theta, Grid.at(S, elements))
        for row, y in zip(theta, Y, strict=True):
            assert y == pytest.approx(made(valued(form, np.exp(row)), elements)(S), rel=1e-10)
        g = rng.normal(size=Y.shape) + 1j * rng.normal(size=Y.shape)
        found, h = pull(g), 1e-6

        def figure(t, form=form, g=g):
            return (g * admittance(form, t, Grid.at(S, elements))[0]).real.sum(axis=1)

        for i, step in enumerate(h * np.eye(len(base))):
            slope = (figure(theta + step) - figure(theta - step)) / (2 * h)
            assert found[:, i] == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(found).max())


def test_a_leaf_and_its_slope():
    own = 2e4 + 0 * S
    y, share = leaf(DAMPED.damper, own, S)
    more, _ = leaf(DAMPED.damper, own * (1 + 1e-6), S)
    assert (more - y) / (1e-6 * own) == pytest.approx(share, rel=1e-4)
    assert leaf(Parasitics(parallel_damping=5.0), own, S)[0] == pytest.approx(own + 5)


def test_a_catalogue_is_read(tmp_path):
    path = tmp_path / "maker.toml"
    path.write_text(
        'source = "a maker"\n[inerter]\nparallel_damping = "1 kN s/m"\nend_stiffness = 5e6\n'
        '[damper]\nend_stiffness = "3 MN/m"\nend_damping = "2 kN s/m"\n'
    )
    found = read_elements(path)
    assert found == RealElements(damper=Parasitics(0.0, 3e6, 2e3), inerter=Parasitics(1e3, 5e6), source="a maker")
    assert str(found).startswith("damper with ends of 3 MN/m with 2 kN·s/m; inerter with 1 kN·s/m beside it")
    assert found.to_dict()["spring"]["end_stiffness"] is None


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"lever": {}}, "unknown key 'lever'"),
        ({"inerter": 3}, "inerter must be a table with parallel_damping"),
        ({"inerter": {"end": 3}}, "inerter: unknown key 'end'"),
        ({"inerter": {"end_stiffness": "3 kg"}}, "inerter.end_stiffness: The unit 'kg' measures something else"),
        ({"damper": {"end_stiffness": 0}}, "0 is no value"),
        ({"damper": {"end_stiffness": float("inf")}}, "inf is no value|not a finite number"),
        ({"damper": {"end_stiffness": [1]}}, "damper.end_stiffness: .1. is no value"),
        ({"damper": {"end_damping": 3}}, "end_stiffness, which is missing"),
        ({"source": 3}, "source is 3"),
        ("ideal", "give real, or a path"),
        ("/nowhere/x.toml", "cannot read /nowhere/x.toml"),
    ],
)
def test_what_is_wrong_with_a_catalogue_is_named(given, says):
    with pytest.raises(BadInput, match=says):
        read_elements(given)
