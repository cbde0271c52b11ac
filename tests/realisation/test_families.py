"""Drawn devices of every family, by every method that serves them: the same device, built of what it should be.

A few of each on every run, three hundred with ``make test-long``.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from flint import acb, ctx
from hypothesis import HealthCheck, given, settings

from posreal.admittance import Rational, check
from posreal.network import nodal_value, parse
from posreal.realisation import realise, realise_all
from tests import strategies

FAMILIES = {
    "trees": strategies.trees(8).map(lambda network: network.admittance()),
    "trees over ten decades": strategies.trees(8, decades=10).map(lambda network: network.admittance()),
    "bridges": strategies.bridges(2).map(lambda network: network.admittance()),
    "bridges over ten decades": strategies.bridges(2, decades=10).map(lambda network: network.admittance()),
    "networks with levers": strategies.lever_networks(2).map(lambda network: network.admittance()),
    "port-Hamiltonian": strategies.port_hamiltonians(8),
    "on the boundary": strategies.touching(8),
    "on the boundary over six decades": strategies.touching(6, decades=6),
    "lossless": strategies.lossless(8),
    "lossless over ten decades": strategies.lossless(8, decades=10),
}
EVERYWHERE = ("brune", "reza-pantell", "bott-duffin")
PROBES = [acb(0, w) for w in (0.0009765625, 0.03125, 0.6875, 11.5, 93.25, 5120.0)]  # exact in binary


def built_every_way(y: Rational) -> None:
    """Realise by all methods; each must have y's admittance, recomputed here, and the counts it promises."""
    results = {r.method: r for r in realise_all(y)}
    assert set(EVERYWHERE) <= set(results)
    for result in results.values():
        assert (result.target, result.lift) == (y, 0)
        assert result.residual < 1e-9
        assert all(part.exact > 0 for part in result.network.elements() if part.letter != "n")
        assert parse(str(result.network)) == result.network
        for s in PROBES:
            assert off(nodal_value(result.network, s, 120), y, s) < 1e-9
        assert result.springs + result.inerters >= y.degree
        assert result.levers == 0 or result.method == "brune"
    assert results["brune"].springs + results["brune"].inerters == y.degree
    assert results["brune"].levers <= y.degree // 2
    assert len(results["bott-duffin"].network) <= most(y.degree, 7)
    assert len(results["reza-pantell"].network) <= most(y.degree, 6)
    if not any(r.notes for r in results.values()):
        assert len(results["reza-pantell"].network) <= len(results["bott-duffin"].network)
    if check(y).lossless:
        for name in ("foster-1", "foster-2", "cauer-1", "cauer-2"):
            assert len(results[name].network) == y.degree


def auto_takes_the_fewest(y: Rational) -> None:
    """`realise` by itself against all that `realise_all` lists."""
    fewest = min(len(r.network) for r in realise_all(y) if r.levers == 0)
    auto = realise(y)
    assert (auto.levers, len(auto.network)) == (0, fewest)


def most(degree: int, cycle: int) -> int:
    """Elements at worst: a damper and an end's element a degree, or a damper and a cycle with two rests."""
    if degree <= 0:
        return 1 if degree == 0 else 0
    return max(2 + most(degree - 1, cycle), cycle + 2 * most(degree - 2, cycle) if degree > 1 else 0)


def off(found: acb, y: Rational, s: acb) -> float:
    """|found/Y(s) − 1|, and 0 where s is a pole or a zero."""
    with ctx.workprec(400):
        top, bottom = (sum((acb(c) * s**i for i, c in enumerate(p.coeffs())), acb(0)) for p in (y.n, y.d))
        if top.contains(0) or bottom.contains(0):
            return 0.0
        return float((abs(found * bottom / top - 1)).upper())


@pytest.mark.parametrize("family", FAMILIES)
def test_a_few_of_each_family(family):
    _run(family, built_every_way, 2)


@pytest.mark.parametrize("family", FAMILIES)
def test_auto_on_each_family(family):
    _run(family, auto_takes_the_fewest, 1)


@pytest.mark.long
@pytest.mark.parametrize("family", FAMILIES)
def test_many_of_each_family(family):
    _run(family, built_every_way, 30)


def _run(family: str, holds: Callable[[Rational], None], count: int) -> None:
    @settings(deadline=None, max_examples=count, suppress_health_check=list(HealthCheck))
    @given(FAMILIES[family])
    def each(y: Rational) -> None:
        holds(y)

    each()
