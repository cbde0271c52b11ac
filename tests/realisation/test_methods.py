"""Every method on everything it serves: positive elements, expected counts, the right admittance."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import Rational, check, parse_rational, random_port_hamiltonian
from posreal.errors import BadDevice, BadInput, NotPositiveReal
from posreal.network import Damper, Inerter, Network, Parallel, Series, Spring, bridge, nodal_admittance, parse
from posreal.realisation import METHODS, Realisation, prove, realise, realise_all
from posreal.realisation.elements import dual

seeds = st.integers(0, 2**32 - 1)


@st.composite
def trees(draw: st.DrawFn, kinds: str = "kcb", decades: int = 5, most: int = 8) -> Network:
    """A series–parallel tree with values spread over twice so many decades."""
    make = {"k": Spring, "c": Damper, "b": Inerter}

    def leaf() -> Network:
        value = Fraction(draw(st.integers(1, 99))) * Fraction(10) ** draw(st.integers(-decades, decades))
        return make[draw(st.sampled_from(kinds))](value)

    parts = [leaf() for _ in range(draw(st.integers(1, most)))]
    while len(parts) > 1:
        i = draw(st.integers(0, len(parts) - 2))
        join = draw(st.sampled_from([Series, Parallel]))
        parts[i : i + 2] = [join((parts[i], parts[i + 1]))]
    return parts[0]


def holds(result: Realisation, device: Rational) -> None:
    assert result.target == device
    assert result.residual < 1e-9
    assert all(part.exact > 0 for part in result.network.elements() if part.letter != "n")
    assert parse(str(result.network)) == result.network
    assert result.check().residual == result.residual


def test_the_worked_example_of_bott_and_duffin_is_exact():
    result = realise(parse_rational("(s^2+s+1)/(s^2+s+4)").inverse(), "bott-duffin")
    expected = parse("(k=6 + b=3 | c=4 | b=2) + ((b=2/3 | k=4/3) + c=1 | k=2)")
    assert str(result.network.unnamed()) == str(expected.unnamed())
    assert result.residual == 0
    assert nodal_admittance(result.network) == result.device


def test_the_worked_example_of_brune_is_exact():
    result = realise(parse_rational("(s^2+s+1)/(s^2+s+4)").inverse(), "brune")
    assert (result.springs, result.dampers, result.inerters, result.levers) == (1, 1, 1, 1)
    assert nodal_admittance(result.network) == result.device
    assert result.network.values() == {"k": 1, "b": 1, "c": 4, "n": 0.5}


@settings(deadline=None, max_examples=10)
@given(trees())
def test_networks_come_back_by_every_method(network):
    y = network.admittance()
    results = realise_all(y)
    assert {"brune", "bott-duffin"} <= {r.method for r in results}
    for result in results:
        holds(result, y)
    auto = realise(y)
    assert auto.levers == 0
    assert len(auto.network) == min(len(r.network) for r in results if r.method != "brune")


@settings(deadline=None, max_examples=10)
@given(st.lists(trees(most=2), min_size=5, max_size=5))
def test_bridges_come_back(arms):
    y = bridge(*arms).admittance()
    for method in ("brune", "reza-pantell", "bott-duffin"):
        holds(realise(y, method), y)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 8), seeds, st.sampled_from([0, 4, 10]))
def test_random_positive_real_functions(order, seed, decades):
    y = random_port_hamiltonian(order, np.random.default_rng(seed), decades).rational()
    for method in ("brune", "bott-duffin"):
        result = realise(y, method)
        holds(result, y)
        if method == "brune":
            assert result.springs + result.inerters == order


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 3), seeds)
def test_devices_on_the_boundary(half, seed):
    """With the least Re Y taken out to float precision, either side of zero."""
    form = random_port_hamiltonian(2 * half, np.random.default_rng(seed))
    y = form.rational()
    touching = y.without(Rational([check(y).margin]))
    result = realise(touching, "bott-duffin")
    holds(result, result.target)
    miss = float(result.target.without(touching).numerator[0])
    assert miss == pytest.approx(result.lift)
    assert 0 <= miss < 1e-12 * max(1.0, check(y).margin)
    assert any("lifted" in note for note in result.notes) == (result.lift > 0)
    if check(touching).minimum_function:
        assert len(result.network) <= 8 * 2**half - 7


@settings(deadline=None, max_examples=25)
@given(st.sampled_from(["kb", "kc", "cb"]), st.data())
def test_two_kinds_of_element_are_minimal_in_all_four_canonical_forms(kinds, data):
    y = data.draw(trees(kinds=kinds, most=7)).admittance()
    results = {r.method: r for r in realise_all(y)}
    assert {"foster-1", "foster-2", "cauer-1", "cauer-2"} <= set(results)
    stores = {"kb": ("springs", "inerters"), "kc": ("springs",), "cb": ("inerters",)}[kinds]
    for name in ("foster-1", "foster-2", "cauer-1", "cauer-2"):
        result = results[name]
        holds(result, y)
        assert sum(getattr(result, kind) for kind in stores) == y.degree
        assert len(result.network) == _fewest(y, kinds)


def _fewest(y: Rational, kinds: str) -> int:
    """Parameters of the function: one element each."""
    if kinds == "kb":
        return y.degree
    return sum(1 for c in (*y.numerator, *y.denominator) if c != 0) - 1


@pytest.mark.parametrize("k", ["1", "1e-5"])
def test_lossless_with_irrational_frequencies(k):
    y = parse_rational(f"(s^4 + 3*s^2 + 1)/(s^3 + 2*s) + {k}*s/(s^4 + 5*s^2 + 5)*(s^2 + 2)")
    for result in realise_all(y):
        holds(result, y)
        assert result.springs + result.inerters == y.degree


@pytest.mark.parametrize("method", ["foster-1", "foster-2", "cauer-1", "cauer-2"])
def test_forms_that_do_not_apply_say_why(method):
    with pytest.raises(BadDevice, match="use bott-duffin"):
        realise("(s^2+s+1)/(s^2+s+4)", method)


def test_what_is_refused():
    with pytest.raises(NotPositiveReal):
        realise("(s^2+s+1)/(s^2+0.9*s+4)")
    with pytest.raises(NotPositiveReal):
        realise("1/(s-1)")
    with pytest.raises(BadDevice, match="no device"):
        realise("0")
    for beyond in ("1e400*s", "1e-400", "1/(1e310*s+1)"):
        with pytest.raises(BadDevice, match="scale it first"):
            realise(beyond)
    with pytest.raises(BadInput, match="no method 'magic'"):
        realise("s", "magic")


def test_small_misses_are_lifted_and_larger_ones_are_not():
    result = realise("(s^2+s+1)/(s^2+(1-1e-12)*s+4)", "bott-duffin")
    assert result.lift == pytest.approx(1e-12 / 3, rel=1e-3)
    assert len(result.network) == 8
    assert "lifted" in result.notes[0]
    with pytest.raises(NotPositiveReal):
        realise("(s^2+s+1)/(s^2+(1-1e-3)*s+4)")


def test_touching_twice_at_degree_four_uses_two_cycles_in_line():
    y = parse_rational("(s^2+s+1)/(s^2+s+4)")
    twice = y | y.time_scaled(3).scaled(2)
    for result in realise_all(twice):
        holds(result, twice)


@settings(deadline=None, max_examples=25)
@given(trees())
def test_the_dual_network_has_the_dual_admittance(network):
    assert dual(network).admittance() == network.admittance().dual
    assert dual(dual(network)) == network.unnamed()


def test_a_wrong_network_is_not_proven():
    y = parse_rational("(s+1)/(s+2)")
    right = realise(y).network
    wrong = right.with_values({right.names[0]: right.elements()[0].exact * (1 + Fraction(1, 10**6))})
    assert prove(right, y).residual < 1e-15
    assert 1e-9 < prove(wrong, y).residual < 1e-5


def test_results_show_themselves():
    result = realise("(s^2+2*s+1)/(s^2+2*s+9)", "bott-duffin")
    assert str(result).startswith("bott-duffin: 8 elements, relative residual 0.0e+00\n")
    assert str(result).endswith(str(result.network))
    assert "<svg" in result._repr_html_()
    with pytest.raises(BadDevice, match="degree 21; networks are made up to degree 20"):
        realise("1/(s+1)^21 + 100")


def test_a_branch_in_resonance_at_a_point_of_the_proof_is_no_obstacle():
    y = parse_rational("(s^2+2*s+1)/(s^2+2*s+9)") | parse_rational("s/(s^2+1)") | parse_rational("(s+1)/(s+2)")
    for result in realise_all(y):
        holds(result, y)


def test_results_as_json():
    data = realise("(s^2+s+1)/(s^2+s+4)", "bott-duffin").to_dict()
    assert data["elements"] == {"springs": 3, "dampers": 2, "inerters": 3, "levers": 0}
    assert parse(data["notation"]).admittance() == Rational.from_dict(data["rational"])
    assert set(METHODS) >= {"foster-1", "foster-2", "cauer-1", "cauer-2", "brune", "bott-duffin"}
