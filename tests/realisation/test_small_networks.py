"""Fewest elements: the Reza–Pantell–Fialkow–Gerst bridge, biquadratics, and close networks."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from flint import fmpq
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import Rational, check, is_positive_real, parse_rational, random_port_hamiltonian
from posreal.errors import BadInput, Infeasible
from posreal.network import nodal_admittance, parse
from posreal.network.topologies import topologies, valued
from posreal.realisation import DoesNotApply, Limits, nearest_positive_real, realise, realise_all
from posreal.realisation.catalogue import behaviour, catalogue
from posreal.realisation.screen import screened
from tests import strategies

seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("text", ["(s^2+2*s+1)/(s^2+2*s+9)", "(s^2+2*s+9)/(s^2+2*s+1)", "5*(s^2+6*s+9)/(s^2+6*s+81)"])
def test_minimum_functions_take_seven_elements(text):
    y = parse_rational(text)
    assert check(y).minimum_function
    result = realise(y, "reza-pantell")
    assert (result.springs + result.inerters, result.dampers, result.levers) == (5, 2, 0)
    assert nodal_admittance(result.network) == y
    assert realise(y).method == "reza-pantell"


@pytest.mark.parametrize("text", ["(s^2+s+1)/(s^2+s+4)", "(s^2+s+4)/(s^2+s+1)", "5*(s^2+3*s+9)/(s^2+3*s+36)"])
def test_minimum_functions_whose_ends_are_one_to_four_take_five(text):
    y = parse_rational(text)
    assert check(y).minimum_function
    result = realise(y)
    assert (result.springs + result.inerters, result.dampers, result.levers) == (3, 2, 0)
    assert nodal_admittance(result.network) == y


@settings(deadline=None, max_examples=15)
@given(st.integers(2, 6), seeds)
def test_one_storing_element_less_than_bott_and_duffin_a_cycle(order, seed):
    y = random_port_hamiltonian(order, np.random.default_rng(seed)).rational()
    bridges, series = realise(y, "reza-pantell"), realise(y, "bott-duffin")
    assert bridges.residual < 1e-9
    assert all(part.exact > 0 for part in bridges.network.elements())
    assert bridges.dampers == series.dampers
    cycles = str(bridges.network).count("{")
    assert series.springs + series.inerters - bridges.springs - bridges.inerters >= cycles


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(1, 40), min_size=6, max_size=6))
def test_regular_biquadratics_take_two_storing_elements_and_three_dampers(c):
    y = Rational(c[:3], c[3:])
    verdict = check(y)
    if not verdict or y.degree != 2 or not verdict.regular:
        return
    result = realise(y, "biquadratic")
    assert result.residual < 1e-9
    assert result.springs + result.inerters == 2
    assert result.dampers <= 3
    assert result.levers == 0


@pytest.mark.parametrize(("b", "c"), [("1/10", "1/10"), ("1/50", "1/50"), ("3/20", "3/10")])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("inverted", [False, True])
def test_a_series_parallel_quartet_reaches_non_regular_biquadratics(b, c, turned, inverted):
    # poles −1 and −2 of the first branch and one of them of the second: a common one is counted once
    network = parse(f"(b1=1 | c1=3) + k=2 | b2={b} + c2={c}")
    y = network.admittance()
    y = y.dual if inverted else y
    y = Rational(y.numerator[::-1], y.denominator[::-1]) if turned else y
    assert check(y).regular is False
    result = realise(y, "biquadratic")
    assert (len(result.network), result.springs + result.inerters) == (5, 3)
    assert result.residual < 1e-12


@pytest.mark.parametrize(
    "text",
    [
        "{1-2: b=2, 1-3: c=0.3, 2-3: k=5, 2-0: c=0.7, 3-0: c=11}",
        "{1-2: c=4, 1-3: c=0.2, 2-3: b=1.5, 2-0: c=30, 3-0: k=2}",
    ],
)
def test_bridges_come_back_with_five_elements(text):
    y = parse(text).admittance()
    result = realise(y, "biquadratic")
    assert len(result.network) == 5
    assert result.residual < 1e-12
    assert len(realise(y).network) == 5


@pytest.mark.parametrize(
    "shape", ["{1-2: b, 1-3: c1, 2-3: k, 2-0: c2, 3-0: c3}", "{1-2: k, 1-3: c1, 2-3: b, 2-0: c2, 3-0: c3}"]
)
@settings(deadline=None, max_examples=40)
@given(st.lists(strategies.values(4), min_size=5, max_size=5))
def test_every_bridge_of_two_stores_is_found(shape, values):
    network = parse(shape)
    y = network.with_values(dict(zip(network.names, values, strict=True))).admittance()
    if y.degree == 2:
        result = realise(y, "biquadratic")
        assert len(result.network) <= 5
        assert result.springs + result.inerters == 2
        assert result.residual < 1e-12


@settings(deadline=None, max_examples=40)
@given(strategies.trees(5, least=1), st.booleans())
def test_small_networks_come_back_as_small(network, inverted):
    y = network.admittance()
    if y.degree == 2:
        assert len(realise(y.dual if inverted else y).network) <= len(network)


def test_what_the_biquadratic_method_refuses():
    with pytest.raises(DoesNotApply, match="degree 3"):
        realise("1/(s+1) + 1/(s+2) + 1/(s+3)", "biquadratic")
    with pytest.raises(DoesNotApply, match="reza-pantell"):
        realise("(s^2+2*s+1)/(s^2+2*s+9)", "biquadratic")


@pytest.mark.parametrize(
    "text",
    [
        "k=2 | (c=3 + b=2)",
        "(k=5 + c=1 | b=2) + c=3",
        "{1-2: c=2, 1-3: b=2, 2-3: k=1, 2-0: b=2, 3-0: c=2}",
        "{1-2: b=2, 1-3: c=0.3, 2-3: k=5, 2-0: c=0.7, 3-0: c=11}",
    ],
)
def test_among_all_topologies_of_its_size_a_network_is_found_again(text):
    network = parse(text)
    (misfit, found), *_ = screened(topologies(len(network)), network.admittance(), (0.02, 50.0), None, 0, 5)
    assert misfit < 1e-3
    omega = np.geomspace(0.02, 50, 12)
    assert misfit == pytest.approx(np.max(np.abs(found(1j * omega) / network(1j * omega) - 1)), rel=1e-3, abs=1e-12)


def test_screening_keeps_to_the_limits():
    y = parse("k=2 | (c=3 + b=2)").admittance()
    limits = Limits(k_max=1.5, c_min=4, b_max=1)
    for _, network in screened(topologies(3), y, (0.02, 50.0), limits, 0, 30):
        assert limits.broken_by(network) is None


def test_a_close_network_is_smaller():
    y = parse("(k=2e5 | (c=2e4 + b=300)) + k=5e7").admittance()
    exact = realise(y)
    close = realise(y, tolerance=0.05, band=(0.1, 100.0), largest=3)
    assert len(close.network) < len(exact.network)
    omega = np.geomspace(0.1, 100, 500)
    misfit = np.max(np.abs(close.network(1j * omega) / y(1j * omega) - 1))
    assert misfit <= 0.05
    assert close.misfit == pytest.approx(misfit, rel=1e-3)
    assert "differs" in close.notes[0]
    assert close.check().residual < 1e-9


def test_a_hopeless_tolerance_gives_the_device_itself():
    y = parse("(k=2 | (c=2 + b=3)) + k=5").admittance()
    result = realise(y, tolerance=1e-6, largest=2)
    assert (result.misfit, result.target) == (0, y)
    assert "the device itself" in result.notes[-1]
    assert "2 elements or fewer" in result.notes[-1]
    with pytest.raises(BadInput, match="tolerance of 2"):
        realise(y, tolerance=2.0)
    with pytest.raises(BadInput, match="band"):
        realise(y, tolerance=0.1, band=(3.0, 1.0))


def test_limits_reject_what_cannot_be_built():
    y = parse_rational("(s+1)*(s+3)/((s+2)*(s+5))")
    every = Limits(b_min=0.15)
    result = realise(y, limits=every)
    assert all(float(part.exact) >= 0.15 for part in result.network.elements() if part.letter == "b")
    with pytest.raises(Infeasible, match="outside"):
        realise(y, limits=Limits(c_max=0.01))
    with pytest.raises(BadInput, match="k_min"):
        Limits(k_min=2, k_max=1)


def test_limits_hold_in_close_networks():
    y = parse_rational("100/s + 20 + 1e-6*s")
    result = realise(y, tolerance=0.1, band=(0.1, 100.0), limits=Limits(k_max=95, b_min=0.01), largest=2)
    assert len(result.network) == 2
    assert all(float(part.exact) <= 95 for part in result.network.elements() if part.letter == "k")


def test_a_tolerance_serves_limits_that_the_device_itself_breaks():
    """As many elements as the device's own network are allowed then, since that one cannot be built."""
    limits = Limits(k_max=0.9)
    result = realise("(s^2+s+1)/(s^2+s+4)", tolerance=0.1, limits=limits)
    assert (result.method, len(result.network)) == ("fit", 5)
    assert limits.broken_by(result.network) is None
    with pytest.raises(Infeasible, match=r"within the limits, and no network of 5 elements.*the best is off by"):
        realise("(s^2+s+1)/(s^2+s+4)", tolerance=0.05, limits=limits)


def test_one_element_is_not_approximated():
    assert realise("3", tolerance=0.1).notes == ()


@pytest.mark.parametrize("way", ["parallel", "series", "projection"])
@pytest.mark.parametrize("gap", ["0.1", "1e-3", "1e-12"])
def test_small_misses_are_repaired_by_little(way, gap):
    y = parse_rational(f"(s^2+s+1)/(s^2+(1-{gap})*s+4)")
    repair = nearest_positive_real(y, way)
    assert repair.check()
    assert max(map(len, map(str, [*repair.device.numerator, *repair.device.denominator]))) < 100
    assert is_positive_real(repair.device)
    assert 0 < repair.change < 3 * float(gap)
    assert "positive real" in str(repair)


def test_the_parallel_damper_is_the_smallest():
    y = parse_rational("(s^2+s+1)/(s^2+0.9*s+4)")
    repair = nearest_positive_real(y, "parallel")
    assert repair.damper == pytest.approx(-check(y).margin)
    assert not is_positive_real(y | Rational([Fraction(repair.damper) * Fraction(999999, 1000000)]))


def test_the_projection_changes_less_than_a_damper():
    y = parse_rational("(s^2+s+1)/(s^2+0.9*s+4)")
    assert nearest_positive_real(y, "projection").change < nearest_positive_real(y, "parallel").change


def test_poles_to_blame():
    with pytest.raises(Infeasible, match="pole"):
        nearest_positive_real("1/(s-1)", "parallel")
    with pytest.raises(Infeasible, match="right half plane at s = 1, too far from the axis"):
        nearest_positive_real("1/(s-1)", "projection")
    with pytest.raises(Infeasible, match="multiplicity 2"):
        nearest_positive_real("1/s^2 + 1/(s+1)", "projection")
    with pytest.raises(Infeasible, match="none at all"):
        nearest_positive_real("-1/s", "projection")
    assert nearest_positive_real("1/(s+1)", "projection").change == 0
    with pytest.raises(BadInput, match="magic"):
        nearest_positive_real("1/(s-1)", "magic")


def test_a_resonance_just_undamped_is_mirrored_and_said_so():
    y = parse_rational("2/s + 3 + s/(s^2-0.002*s+4)")
    repair = nearest_positive_real(y, "projection")
    assert repair.mirrored == (pytest.approx(0.001 + 2j, rel=1e-6),)
    assert repair.device(1j * 1.5) == pytest.approx(y(1j * 1.5), rel=0.01)
    assert repair.check()
    assert "mirroring the poles at s = 0.001 ± 2j" in str(repair)
    assert repair.to_dict()["mirrored"] == [{"real": pytest.approx(0.001), "imag": pytest.approx(2.0)}]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("s/(s^2+1) - s/(s^2+4)/2 + 1", "s/(s^2+1) + 1"),
        ("1/(s^2+1) + 1/(s+2)", "1/(s+2)"),
        ("1/s + 2 - s/1e6", "1/s + 2"),
    ],
)
def test_poles_on_the_axis_keep_what_is_positive_of_their_residues(text, expected):
    repair = nearest_positive_real(text, "projection")
    omega = np.array([0.3, 1.7, 30.0])
    assert repair.device(1j * omega) == pytest.approx(parse_rational(expected)(1j * omega), rel=1e-5)


def test_a_repair_that_changes_much_says_so():
    assert "another device" in str(nearest_positive_real("(s^2+s+1)/(s^2-0.01*s+4)", "projection"))
    assert "another device" not in str(nearest_positive_real("(s^2+s+1)/(s^2+0.9*s+4)", "projection"))


@settings(deadline=None, max_examples=8)
@given(st.integers(1, 5), seeds, st.floats(1e-9, 0.3))
def test_projection_of_perturbed_devices(order, seed, size):
    rng = np.random.default_rng(seed)
    y = random_port_hamiltonian(order, rng).rational()
    off = y.without(Rational([Fraction(check(y).margin * (1 + size))]))
    assert nearest_positive_real(off, "projection").check()


@pytest.mark.parametrize(
    "text",
    ["(k=1 | c=2) + (b=3 | c=1.5 | k=0.7)", "(k=3.3 | (b=2 + c=1.7)) + (b=0.3 | k=11.1)"],
)
def test_five_elements_that_no_procedure_leads_to(text):
    y = parse(text).admittance()
    few, *others = [found for found in realise_all(y) if found.levers == 0]
    assert few.method == "few"
    assert len(few.network) == 5 < min(len(other.network) for other in others)
    s = 1j * np.geomspace(1e-3, 1e3, 61)
    assert np.abs(nodal_admittance(few.network)(s) / y(s) - 1).max() < 1e-9


def test_few_elements_that_fit_in_the_band_only_are_left_out():
    y = parse_rational(
        "(11014/505*s^3 + 107615/57873*s^2 + 109/8686*s + 1775/1659026)"
        "/(s^4 + 215230/57873*s^3 + 109/86*s^2 + 548725/4977078*s)"
    )
    assert all(found.residual < 1e-9 for found in realise_all(y))


@pytest.mark.parametrize(
    ("text", "counts"),
    [
        ("(2*s^4+13/3*s^3+20/3*s^2+10/3*s+8/3)/(s^4+1/3*s^3+4*s^2+2/3*s+4/3)", (4, 2)),
        ("(3*s^4+9*s^3+13.5*s^2+19.5*s+13.5)/(s^4+2*s^3+5.5*s^2+4.5*s)", (4, 2)),
    ],
)
def test_six_elements_that_no_procedure_leads_to(text, counts):
    result = realise(text)
    assert (result.springs + result.inerters, result.dampers, result.levers) == (*counts, 0)
    assert nodal_admittance(result.network) == parse_rational(text)


def test_the_second_of_them_is_a_bridge():
    assert "{" in str(realise("(3*s^4+9*s^3+13.5*s^2+19.5*s+13.5)/(s^4+2*s^3+5.5*s^2+4.5*s)").network)


def test_small_networks_are_looked_for_in_what_the_preamble_leaves():
    """Eight elements: a damper and a resonator around a bridge of six that no procedure leads to."""
    inner = parse("{1-2: b1=2, 1-3: k1=3 | c1=5, 2-3: b2=7, 2-0: k2=11, 3-0: k3=13}").admittance()
    y = parse("k=1 + b=1").admittance() | inner
    result = realise(y)
    assert (result.method, len(result.network)) == ("few", 8)
    assert nodal_admittance(result.network) == y


@pytest.mark.parametrize("size", [5, 6])
def test_trees_and_forests_of_the_catalogue_are_the_admittance(size):
    """Against nodal analysis; T and U may share a power of s. Every seventeenth of the catalogue."""
    primes = [fmpq(p) for p in (2, 3, 5, 7, 11, 13)][:size]
    count = 0
    for degree, *ends in product(range(1, 7), (-1, 0, 1), (-1, 0, 1)):
        for entry in catalogue(size, degree, tuple(ends)).entries[::17]:
            (top, *_), (bottom, *_) = entry.polynomials(primes)
            found = nodal_admittance(valued(entry.form, [int(p.p) for p in primes]))
            assert Rational(top, bottom) == found
            assert behaviour(found) == tuple(ends)
            assert found.degree <= entry.degree
            count += 1
    assert count > 100


def test_every_topology_stands_in_the_catalogue_once():
    """With degree 0 asked for nothing is left out; no network goes with s^(−2) or beyond at either end."""
    for size in range(1, 7):
        found = [e.form for ends in product((-1, 0, 1), repeat=2) for e in catalogue(size, 0, ends).entries]
        assert sorted(map(str, found)) == sorted(map(str, topologies(size)))


@pytest.mark.parametrize("seed", range(6))
def test_networks_of_six_elements_come_back_as_small(seed):
    rng = np.random.default_rng([6, seed])
    while True:
        form = topologies(6)[rng.integers(len(topologies(6)))]
        y = valued(form, rng.integers(1, 40, 6).tolist()).admittance()
        if y.degree >= 3:
            break
    result = realise(y)
    assert len(result.network) <= 6
    assert result.check().residual < 1e-12


def test_data_in_floats_are_met_to_their_digits():
    y = parse("{1-2: b1=2, 1-3: k1=3 | c1=5, 2-3: b2=7, 2-0: k2=11, 3-0: k3=13}").admittance().rounded(16)
    result = realise(y)
    assert len(result.network) == 6
    assert 0 < result.residual < 1e-12
