"""Dampers that do nothing are left out, and nothing else is."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import acb
from hypothesis import given

from posreal.admittance import Rational
from posreal.network import Damper, nodal_value, parse
from posreal.realisation import prove, realise
from posreal.realisation.idle_dampers import without_negligible
from tests import strategies


def test_a_hair_of_a_damper_goes():
    network = parse("k=2e5 | (c1=2e4 + b=300) | c2=1e-9")
    target = network.admittance()
    smaller, said = without_negligible(network, target)
    assert str(smaller) == "k=200000 | c=20000 + b=300"
    assert said == ("a damper of 1e-09 N s/m was left out: it does nothing",)


def test_a_damper_inside_a_bridge_stays_and_is_not_said_to_go():
    network = parse("{1-2: c1=1, 1-3: b=2, 2-3: k1=3 | c2=1e-20, 2-0: b=4, 3-0: c3=5} | k2=1 | c4=1e-20")
    smaller, said = without_negligible(network, network.admittance())
    assert (len(smaller), len(said)) == (len(network) - 1, 1)
    assert "c2" in smaller.names


def test_a_spring_with_a_corner_of_its_own_stays():
    """However high that corner is: the device has it, and who does not want it asks for a tolerance."""
    network = parse("k1=1e24 + c=2e4 + b=300 | k2=1e5")
    assert without_negligible(network, network.admittance()) == (network, ())


@given(strategies.trees(most=6, least=2), strategies.values(30))
def test_what_is_left_is_the_same_device(network, value):
    """With a damper of any size beside it: it goes only where it does nothing, and the proof still holds."""
    whole = network.unnamed() | Damper(value)
    target = whole.admittance()
    smaller, said = without_negligible(whole, target)
    assert len(smaller) == len(whole) - len(said)
    assert prove(smaller, target).residual < 1e-10
    if not said:
        assert smaller == whole


def test_boundary_devices_come_out_without_the_hair():
    touching = Rational.parse("(s^2 + 2*s + 1)/(s^2 + 2*s + 9)")
    lifted = touching | Rational([1e-14])
    assert len(realise(lifted).network) == len(realise(touching).network)
    assert realise(lifted).residual == pytest.approx(0, abs=1e-11)


@pytest.mark.parametrize("damping", ["1e-9", "1e-14", "1e-25"])
def test_what_damps_a_resonance_stays_however_little_it_damps(damping):
    """Without it Y would be infinite at ω = 1, where it is 1/damping; nowhere else is it felt."""
    device = Rational.parse(f"s/(s^2 + {damping}*s + 1) + 1")
    for name in ("brune", "bott-duffin"):
        result = realise(device, name)
        assert result.network.counts.dampers == 2
        peak = float(abs(nodal_value(result.network, acb(0, 1), 100)))
        assert peak == pytest.approx(1 / float(Fraction(damping)), rel=1e-8)


def test_an_undamped_resonance_beside_a_zero_stays():
    """Its pole and its zero are 7e-10 apart, so that no sampled frequency feels it; yet it is there."""
    device = Rational.parse("(1.5001*s^3 + 0.00015*s)/(s^4 + 150010.0001*s^2 + 15)")
    for name in ("foster-1", "foster-2", "cauer-1", "cauer-2"):
        result = realise(device, name)
        assert result.springs + result.inerters == 4
        without = Rational.parse("1.5001*s/(s^2 + 150010)")
        assert prove(result.network, without).values < 1e-8
