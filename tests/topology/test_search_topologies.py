"""Enumeration against an independent count, limits and left-out topologies against the admittances themselves."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import comb

import numpy as np
import pytest

from posreal.network import topologies
from posreal.network.canonical import canonical_key
from posreal.network.topologies import forms, key, letters, network
from posreal.topology import degenerate
from posreal.topology.equivalence import classes, foster_form, rewritten
from posreal.topology.equivalent import fitted, sample
from posreal.topology.ground import Units

COUNTS = [3, 6, 20, 90, 432, 2202]
S = np.array([0.4 + 0.2j, 0.5 + 1j, 0.3 + 3j, 0.5 + 0.7j])
UNITS = Units(c0=1.0, omega0=1.0)


def counted(largest):
    """Trees by the generating function: bags of joints of the other kind and sets of three elements."""
    joints = [0, 0]  # of one kind, by size
    for n in range(2, largest + 1):
        series = [comb(3, i) for i in range(4)] + [0] * n
        for m in range(2, n):  # (1 − x^m)^(−joints[m]) to order n
            bags = [comb(joints[m] + i - 1, i) if joints[m] else int(i == 0) for i in range(n // m + 1)]
            series = [
                sum(bags[i] * series[k - i * m] for i in range(k // m + 1)) if k <= n else 0 for k in range(n + 1)
            ]
        joints.append(series[n])
    return [3, *(2 * count for count in joints[2:])]


def random_values(form, rng):
    return np.exp(rng.normal(size=len(letters(form))))


def test_the_number_of_trees():
    assert [len(forms(n, bridges=False)) for n in range(1, 7)] == COUNTS == counted(6)


def test_the_number_of_bridges_by_burnside():
    def unchanged(turn):
        return sum(all(branches[i] == branches[j] for i, j in enumerate(turn)) for branches in product("kcb", repeat=5))

    turns = [(0, 1, 2, 3, 4), (3, 4, 2, 0, 1), (1, 0, 2, 4, 3), (4, 3, 2, 1, 0)]
    assert len(forms(5)) - len(forms(5, bridges=False)) == sum(map(unchanged, turns)) // 4 == 81


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5])
def test_no_topology_twice(size):
    found = forms(size)
    assert len({canonical_key(network(form)) for form in found}) == len({key(form) for form in found}) == len(found)


@pytest.mark.parametrize("size", [2, 4, 5, 6])
def test_the_degree_is_within_the_reactive_elements(size):
    rng = np.random.default_rng(size)
    every = forms(size)
    for form in every if len(every) < 100 else [every[i] for i in rng.integers(len(every), size=80)]:
        topology = network(form)
        values = {name: Fraction(int(rng.integers(1, 50)), 7) for name in topology.names}
        degree = topology.with_values(values).admittance().degree
        assert degree <= sum(letter != "c" for letter in letters(form)), key(form)


@pytest.mark.parametrize("size", [3, 5, 6])
def test_limits_are_limits(size):
    rng = np.random.default_rng(size)
    every = forms(size)
    for form in [every[i] for i in rng.integers(len(every), size=40)]:
        for limit in degenerate.limits(form):
            values = random_values(limit.form, rng)
            border = 1e7 if limit.locked else 1e-7
            larger = degenerate.start(limit, values.tolist(), border, [1.0] * size)
            here = network(form).response(larger, S)
            assert here == pytest.approx(network(limit.form).response(values, S), rel=2e-5), (
                key(form),
                key(limit.form),
            )


def test_elements_that_go_take_only_idle_ones_with_them():
    # b + c loses b: nothing is left to hold c, so no smaller network but a lone element remains
    assert {key(limit.form) for limit in degenerate.limits(("+", "b", "c"))} == {"b", "c"}
    assert {key(limit.form) for limit in degenerate.limits(forms(3)[0])} <= {
        key(form) for n in (1, 2) for form in forms(n)
    }


def test_arrows_never_add_elements_of_any_kind():
    for size in (3, 4, 5):
        for form in forms(size):
            for other in rewritten(form):
                assert all(letters(other).count(kind) <= letters(form).count(kind) for kind in "kcb")


@pytest.mark.parametrize("size", [3, 4, 5])
def test_what_is_left_out_can_be_done_by_what_stands_for_it(size):
    rng = np.random.default_rng(7)
    points = sample(UNITS)
    left_out = [form for form, other in classes(size).items() if other != form and len(letters(form)) == size]
    for form in [left_out[i] for i in rng.permutation(len(left_out))[:12]]:
        target = network(form).response(random_values(form, rng), points)
        assert fitted(classes(size)[form], target, points, UNITS, rng) is not None, key(form)


def test_what_stands_for_others_stands_for_itself():
    found = classes(5)
    assert all(found[other] == other for other in found.values())
    assert [sum(found[form] == form for form in forms(n)) for n in range(1, 6)] == [3, 6, 14, 42, 192]


def test_one_reactive_element_needs_three_in_all():
    found = classes(5)
    for form in forms(5):
        if len(set(letters(form)) - {"c"}) == 1 and letters(form).count("c") == 4:
            assert len(letters(found[form])) <= 3


@pytest.mark.parametrize(
    ("form", "foster"),
    [
        (("+", "c", ("|", "c", "k")), "c|(c+k)"),
        (("+", ("|", "b", "k"), ("|", "b", "k")), "b|(b+k)|k"),
        (("+", ("|", "c", "k"), ("|", "c", "k")), "c|(c+k)|k"),
    ],
)
def test_foster_forms(form, foster):
    assert key(foster_form(form)) == foster


def test_fitting_tells_devices_apart():
    rng = np.random.default_rng(0)
    points = sample(UNITS)
    target = network(("+", "b", "c", "k")).response([1.0, 2.0, 3.0], points)
    assert fitted(("+", "b", "c", "k"), target, points, UNITS, rng) == pytest.approx((1.0, 2.0, 3.0), rel=1e-6)
    assert fitted(("|", "b", "c", "k"), target, points, UNITS, rng) is None


def test_every_name_of_the_module_is_a_network():
    assert str(topologies.valued(("|", "k", ("+", "b", "c")), [2.0, 3.0, 4.0])) == "k=2 | b=3 + c=4"
