"""Bounds for plants of one's own: the form follows the port, exactly, and what is around the device counts."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest
from flint import arb, fmpq

import posreal as pr
from posreal.admittance import Rational, parse_rational, state_space
from posreal.admittance.positive_real import is_positive_real
from posreal.admittance.roots import precision
from posreal.bounds.compute import bound
from posreal.bounds.figure import figure
from posreal.bounds.file import load_bound
from posreal.bounds.interpolation_space import Space
from posreal.bounds.points import passive
from posreal.errors import BadInput
from posreal.specification import named

DEVICES = ("30", "3 + 0.2*s", "8*5*s/(8*s + 5)", "4 + 6/s", "0")


def masses(k=100.0, m=1.0, mu=0.3, damping=0.5, ports=1):
    """(A, B_w, B_f, C_z, C_v) of equal pairs of masses on one ground: spring and damper beneath, device between."""
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0  # z_upper, z_lower, velocities
    A[3, 1], A[3, 3] = -k / mu, -damping / mu
    Bw = np.array([[0.0], [0.0], [0.0], [damping / mu]])
    Bf = np.array([[0.0], [0.0], [-1 / m], [1 / mu]])
    Cz = np.array([[0.0, 0.0, 1.0, -0.2]])
    Cv = np.array([[0.0, 0.0, 1.0, -1.0]])
    eye = np.eye(ports)
    return np.kron(eye, A), np.kron(np.ones((ports, 1)), Bw), np.kron(eye, Bf), np.kron(eye, Cz), np.kron(eye, Cv)


def system(A, Bw, Bf, Cz, Cv):
    ports, outputs = Bf.shape[1], len(Cz)
    names = [f"z{i}" for i in range(outputs)] + [f"v{i}" for i in range(ports)]
    B, C = np.hstack([Bw, Bf]), np.vstack([Cz, Cv])
    inputs = [f"w{i}" for i in range(Bw.shape[1])] + [f"f{i}" for i in range(ports)]
    return control.ss(A, B, C, np.zeros((len(C), B.shape[1])), inputs=inputs, outputs=names)


def posed(parts, **options):
    made = system(*parts)
    ports = [name for name in made.input_labels if name.startswith("f")]
    return pr.problem_from_plant(
        made,
        disturbances=[[name for name in made.input_labels if name.startswith("w")]],
        force=ports,
        velocity=[name.replace("f", "v") for name in ports],
        performance="z0",
        **options,
    )


def least(problem, found, devices=DEVICES):
    """The smallest figure of some devices, each of which is above the bound."""
    about = figure(problem)
    values = [about.measure(problem.port(parse_rational(text))) for text in devices if text != "0"]
    assert found.value < min(values)
    return min(values)


def test_a_passive_port_is_served_by_the_plain_form():
    problem = posed(masses(), beside="k=40")
    found = bound(problem, L=20, omega0=8)
    assert (found.form, found.passive) == ("plain", True)
    assert found.value > 0.5 * least(problem, found)
    assert found.check() >= found.value


def test_a_delay_changes_the_bound_and_stays_exact():
    A, Bw, Bf, Cz, Cv = masses()
    twice = np.hstack([Bw, 0.7 * Bw])
    parts = (A, twice, Bf, Cz, Cv)
    late, prompt = (posed(parts, beside="k=40", delays={"w1": delay}) for delay in (0.3, 0.0))
    one = posed((A, 1.7 * Bw, Bf, Cz, Cv), beside="k=40")
    values = [bound(problem, L=12, omega0=8).value for problem in (late, prompt, one)]
    assert values[1] == pytest.approx(values[2], rel=1e-7)
    assert abs(values[0] / values[1] - 1) > 0.01
    least(late, bound(late, L=12, omega0=8))


def test_a_spring_beside_is_the_spring_in_the_plant():
    A, Bw, Bf, Cz, Cv = masses()
    stiff = A + 40.0 * Bf @ np.array([[1.0, -1.0, 0.0, 0.0]])
    inside, outside = posed((stiff, Bw, Bf, Cz, Cv)), posed((A, Bw, Bf, Cz, Cv), beside="k=40")
    assert bound(inside, L=14, omega0=8).value == pytest.approx(bound(outside, L=14, omega0=8).value, rel=1e-6)


def test_a_soft_spring_behind_the_device_costs_something():
    stiff, soft = (posed(masses(), beside="k=40", behind=f"k={k}") for k in (1e9, 30.0))
    free = posed(masses(), beside="k=40")
    values = [bound(problem, L=14, omega0=8).value for problem in (free, stiff, soft)]
    assert values[1] == pytest.approx(values[0], rel=1e-4)
    assert values[2] > values[0] * 1.001
    least(soft, bound(soft, L=14, omega0=8))


def test_two_equal_ports_are_one_port_twice():
    # J² of both outputs together is twice that of one, and so is its bound
    single = posed(masses(), beside="k=40")
    double = posed(masses(ports=2), beside="k=40")
    both = bound(double, weights={"rms_z0": 1.0, "rms_z1": 1.0}, L=8, omega0=8)
    assert both.form == "lifted"
    assert both.value == pytest.approx(math.sqrt(2) * bound(single, L=8, omega0=8).value, rel=1e-3)


def test_two_unlike_ports_share_the_device():
    one, two = masses(), masses(m=2.5)
    parts = tuple(
        np.block([[a, np.zeros((a.shape[0], b.shape[1]))], [np.zeros((b.shape[0], a.shape[1])), b]])
        for a, b in zip(one, two, strict=True)
    )
    parts = (parts[0], parts[1].sum(axis=1, keepdims=True), *parts[2:])
    problem = posed(parts, beside="k=40")
    weights = {"rms_z0": 1.0, "rms_z1": 1.0}
    found = bound(problem, weights=weights, L=10, omega0=8)
    apart = [bound(posed(part, beside="k=40"), L=10, omega0=8).value for part in (one, two)]
    # tighter than two devices, each free; and below every shared one
    assert found.value > math.hypot(*apart) * (1 + 1e-4)
    about = figure(problem, weights)
    assert found.value < min(about.measure(problem.port(parse_rational(text))) for text in DEVICES[:-1])


def narrow(width):
    """A port whose Re P is negative in a band of about `width` rad/s around 1 rad/s, if width > 0."""
    P = parse_rational(f"(s^2 - {width}*s + 1)/((s^2 + {2 * abs(width)}*s + 1)*(s + 3))")
    form = state_space(P)
    return (form.A, form.B, -form.B, form.C, form.C), P


@pytest.mark.parametrize(("width", "passive_port"), [(1e-6, False), (-1e-6, True)])
def test_a_port_that_is_active_in_a_narrow_band_is_not_taken_for_passive(width, passive_port):
    parts, P = narrow(width)
    assert is_positive_real(P) == passive_port
    omega = np.geomspace(1e-3, 1e3, 5000)
    assert P(1j * omega).real.min() > 0  # a grid sees nothing
    problem = posed(parts)
    assert passive(figure(problem)) == passive_port
    found = bound(problem, L=6, omega0=2)
    assert found.form == ("plain" if passive_port else "lifted")
    assert found.passive == passive_port
    if not passive_port:
        with pytest.raises(BadInput, match="not positive real"):
            bound(problem, L=6, omega0=2, form="plain")


def test_a_certificate_of_ones_own_plant_is_read_back(tmp_path):
    problem = posed(masses(ports=2), beside="k=40", behind="k=500")
    found = bound(problem, L=8, omega0=(5, (12, 0.5)))
    assert any(isinstance(point, tuple) for point in found.certificate.points)
    found.save(tmp_path / "own.json")
    assert load_bound(tmp_path / "own.json").check() >= found.value


@pytest.mark.parametrize(
    ("text", "point"),
    [("-1/s", 1e-3), ("-s", 1e3), ("2600 - 1e-6/s", 1e-10), ("2600 - 1e-9*s", 1e13), ("2600 - 1e-12*s/(s^2 + 1)", 1)],
)
def test_what_only_the_axis_forgives_breaks_the_inequality_at_some_point(text, point):
    # Re Y(jω) ≥ 0 wherever it is finite
    device = parse_rational(text)
    assert not is_positive_real(device)
    omega = np.geomspace(1e-3, 1e3, 999)
    assert np.all(device(1j * omega).real >= -1e-9)
    sigma = device.without(Rational.damper(2600)).times((device | Rational.damper(2600)).inverse())
    with precision(400):
        if text.endswith("+ 1)"):  # a negative residue on the axis: two points close to it tell
            space = Space(((fmpq(1), fmpq(1, 10**16)),))
        else:
            space = Space((fmpq(point),) if isinstance(point, int) else (fmpq(*float(point).as_integer_ratio()),))
        Sigma = space.operator(space.rational(sigma))
        broken = (Sigma * Sigma.transpose())[0, 0] - arb(1)
        assert broken > 0


@pytest.mark.parametrize("omega0", [1e308, 1e-308, float("nan"), 0.0, [20.0, (50.0, -1.0)], []])
def test_a_place_that_is_no_frequency(omega0):
    with pytest.raises(BadInput, match="give frequencies from 1e-06"):
        bound(named.problem("quarter-car"), L=4, omega0=omega0)
