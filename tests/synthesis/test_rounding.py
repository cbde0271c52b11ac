"""Devices a hair off a face of positive realness are put on it, exactly, and keep their figures."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.admittance import Rational, check, is_positive_real, parse_rational, random_port_hamiltonian
from posreal.network import nodal_admittance, parse
from posreal.realisation import realise
from posreal.specification.named import problem
from posreal.study.strut import realised
from posreal.synthesis.rounding import presented
from posreal.synthesis.synthesise import synthesise

OMEGA = 1j * np.geomspace(1e-2, 1e2, 60)
HAIR = Fraction(1, 10**13)


def near(Y, tolerance=1e-9):
    """Whether a device answers like another."""
    return lambda other: bool(np.all(np.abs(other(OMEGA) / Y(OMEGA) - 1) < tolerance))


def on_its_face(Y):
    found, note = presented(Y, near(Y))
    assert note == ""
    assert is_positive_real(found)
    assert near(Y)(found)
    return found


@pytest.mark.parametrize("text", ["(s^2+s+1)/(s^2+s+4)", "3*s/(s+7) + (s^2+s+1)/(s^2+s+4)/5 + 1/s"])
def test_a_real_part_that_nearly_touches_zero_touches_it(text):
    """Re of the first is (ω² − 2)²/|d|², in closed form; the second's is that over 5 and what else there is."""
    exact = parse_rational(text)
    found = on_its_face(exact | Rational([HAIR]))
    frequencies = check(found).touches
    if text.startswith("(s"):
        assert frequencies == pytest.approx([math.sqrt(2)], rel=1e-12)
    else:
        assert frequencies == ()
        assert found.static_stiffness == pytest.approx(1)


@pytest.mark.parametrize(
    ("text", "degree"),
    [
        ("k=3 | c=2 + b=5", 3),
        ("b=3 | c=2 + k=5", 2),
        ("(k=3 | c=2) + b=5", 2),
        ("(k=2 + b=3) | c=5 + k=7", 3),
        ("(k=2 | b=3) + (c=5 | b=7)", 3),
        ("b=2 | (k=2 + b=3) | c=5 + (k=7 | b=2)", 6),
    ],
)
def test_poles_and_zeros_next_to_the_axis_lie_on_it(text, degree):
    """A damper of 1e-13 across every spring and inerter, one of 1e13 behind it: no pole or zero is left on the axis."""
    network = parse(text)
    exact = network.admittance()
    parts = {
        "k": lambda v: f"((k={v} | c={HAIR}) + c={1 / HAIR})",
        "b": lambda v: f"((b={v} | c={HAIR}) + c={1 / HAIR})",
    }
    lossy = text
    for part in network.elements():
        if part.letter in parts:
            lossy = lossy.replace(f"{part.letter}={part.exact}", parts[part.letter](part.exact), 1)
    Y = parse(lossy).admittance()
    assert Y.degree >= exact.degree
    found = on_its_face(Y)
    assert found.degree == exact.degree
    assert found(OMEGA) == pytest.approx(exact(OMEGA), rel=1e-10)
    assert len(realise(found).network) <= len(network)


@settings(deadline=None, max_examples=25)
@given(st.integers(1, 4), st.integers(0, 2**32 - 1), st.sampled_from(["1/s", "s", "s/(s^2+3)", "0"]), st.booleans())
def test_every_device_of_a_face_stays_on_it(order, seed, beside, inverted):
    """The smallest Re taken out, an undamped leg beside it, upside down or not: rounded by parts it keeps all of it."""
    inner = random_port_hamiltonian(order, np.random.default_rng(seed)).rational()
    least = check(inner).margin
    Y = inner.without(Rational([Fraction(least) * (1 - HAIR)])) | Rational.parse(beside)
    if not is_positive_real(Y):
        return
    Y = Y.inverse() if inverted else Y
    found = on_its_face(Y)
    assert found.degree <= Y.degree
    network = realise(found).network
    assert np.all(np.abs(nodal_admittance(network)(OMEGA) / Y(OMEGA) - 1) < 2e-9)


def test_what_lies_inside_is_only_rounded():
    Y = parse("(k=1/3 | (c=1/7 + b=3/11)) + c=10/3").admittance()
    found = on_its_face(Y)
    assert found == Y.rounded(15)


def test_a_face_that_costs_is_not_taken():
    Y = parse_rational("(s^2+s+1)/(s^2+s+4) + 1e-5")
    assert near(Y)(on_its_face(Y))
    assert check(on_its_face(Y)).touches == ()


@pytest.mark.parametrize(
    ("name", "objective", "order", "figure"),
    [
        ("quarter-car", "J3", 2, 461.398),
        ("quarter-car", "J3", 3, 454.156),
        pytest.param("quarter-car", "J1", 3, 1.454769, marks=pytest.mark.long),
        pytest.param("vertical-comfort", None, 2, 1.921627, marks=pytest.mark.long),
    ],
)
def test_a_synthesised_device_and_its_network_have_the_same_figures(name, objective, order, figure):
    design = synthesise(problem(name, objective=objective), order, starts=8)
    assert design.objective.value == pytest.approx(figure, rel=2e-6)
    assert not any("lifted" in note or "long" in note for note in design.found["notes"])
    network = realise(design.device).network
    chosen = design.problem
    measured = chosen.metrics(chosen.port(nodal_admittance(network)))
    for metric, found in measured.items():
        assert found.value == pytest.approx(design.metrics[metric].value, rel=1e-9), metric
    assert all(1e-3 < float(part.exact) < 1e9 for part in network.elements())
    assert realised(design)[0].feasible
