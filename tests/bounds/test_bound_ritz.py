"""The other side of a bound: devices of high order, passive without doubt, that reach what is claimed for them."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from flint import fmpq

from posreal.admittance import parse_rational
from posreal.admittance.positive_real import is_positive_real
from posreal.admittance.state_space import StateSpace
from posreal.bounds.certificate import NotProven
from posreal.bounds.compute import bound
from posreal.bounds.figure import figure
from posreal.bounds.file import from_dict, load_bound
from posreal.bounds.ritz import Basis, HighOrder, best_device
from posreal.bounds.windows import Windows
from posreal.errors import BadInput, PosrealError
from posreal.plant.mounting import Mounting
from posreal.specification.named import problem

QUARTER_CAR = problem("quarter-car")
SIDE = problem("vertical-comfort")
MIDDLE = problem("vertical-comfort", position="M")
PLAN = problem("lateral-comfort")
POINTS = (fmpq(5), (fmpq(20), fmpq(2, 5)), (fmpq(50), fmpq(1, 3)))
DEVICE = HighOrder(POINTS, fmpq(9000), (0.2, 0.3, -0.1, 0.05, 0.02, -0.15))
S = np.array([1j, 7j, 40j, 300j, 3 + 11j])


def response(system: StateSpace, s):
    n = len(system.A)
    inner = [system.C @ np.linalg.solve(at * np.eye(n) - system.A, system.B) for at in s]
    return np.array(inner)[:, 0, 0] + system.D[0, 0] + system.k / s + system.b * s


def test_the_functions_are_those_written_down():
    omega = np.array([0.5, 3.0, 20.0, 111.0])
    s = 1j * omega
    first = (s - 5) / (s + 5)
    d = s**2 + 2 * 0.4 * 20 * s + 400
    expected = [np.ones(4), 5 / (s + 5), 20 * s / d * first, 400 / d * first]
    assert np.allclose(Basis(POINTS, np.ones(5)).values(omega)[:4], expected)


def test_polynomials_and_state_space_are_one_device():
    omega = np.array([0.5, 3.0, 20.0, 111.0])
    sigma = np.array(DEVICE.coefficients) @ Basis(POINTS, np.ones(5)).values(omega)
    Y = 9000 * (1 + sigma) / (1 - sigma)
    assert np.allclose(np.asarray(DEVICE.admittance()(1j * omega)), Y)
    assert np.allclose(response(DEVICE.state_space(), 1j * omega), Y)
    assert DEVICE.order == 5 == DEVICE.admittance().d.degree()


@pytest.mark.parametrize("posed", [QUARTER_CAR, SIDE, PLAN], ids=lambda p: p.name)
def test_a_mounting_around_a_state_space_is_one_around_a_rational(posed):
    exact = posed.mounting.port(DEVICE.admittance())
    assert np.allclose(response(posed.mounting.around(DEVICE.state_space()), S), np.asarray(exact(S)), rtol=1e-9)


def test_a_mounting_with_everything():
    mounting = Mounting(parse_rational("3e5/s + 200 + 30*s/(s + 4)"), parse_rational("1e6/s + 2e3 + 5e4/(s + 9)"))
    exact = mounting.port(DEVICE.admittance())
    assert np.allclose(response(mounting.around(DEVICE.state_space()), S), np.asarray(exact(S)), rtol=1e-9)
    with pytest.raises(BadInput, match="inerter"):
        Mounting(None, parse_rational("1e6/s + 5*s")).around(DEVICE.state_space())


@pytest.fixture(scope="module")
def found():
    return bound(MIDDLE, L=30, both_sides=True)


def test_both_sides(found, tmp_path):
    attained = found.attained
    assert attained.value > found.value
    assert is_positive_real(attained.device.admittance())
    # the sum over a dense grid of frequencies, of the response of the polynomials
    about = found.figure
    omega = np.geomspace(1e-3, 1e6, 200_000)
    port = np.asarray(MIDDLE.mounting.port(attained.device.admittance())(1j * omega))
    (name,) = about.weights
    z, _ = about.plant.responses(omega, name).closed({about.plant.groups[0]: port})

    scale = int(about.weights[name].p) / int(about.weights[name].q)
    value = math.sqrt(scale * about.plant.density * np.trapezoid(np.abs(z) ** 2, omega))
    assert value == pytest.approx(attained.value, rel=1e-4)
    assert "reached" in str(found)
    found.save(tmp_path / "both.json")
    again = load_bound(tmp_path / "both.json")
    assert again.attained == attained
    assert again.check() >= again.value
    document = json.loads((tmp_path / "both.json").read_text())
    assert document["reached"]["gap_percent"] == pytest.approx(100 * (1 - found.value / attained.value))
    assert document["reached"]["unit"] == "%g"


FORGED = {
    "value": lambda r: r.update(value=r["value"] * 0.999),
    "below the bound": lambda r: r.update(value=0.1),
    "active": lambda r: r.update(coefficients=[1.05 * value for value in r["coefficients"]]),
    "another device": lambda r: r.update(coefficients=[0.9 * value for value in r["coefficients"]]),
    "damper": lambda r: r.update(damper="12345"),
    "unit": lambda r: r.update(unit="km"),
    "a coefficient less": lambda r: r["coefficients"].pop(),
    "rigid": lambda r: r["coefficients"].__setitem__(0, 1.0),
    "how": lambda r: r.update(how="magic"),
    "a key more": lambda r: r.update(trust="me"),
    "a pole outside": lambda r: r["points"].__setitem__(1, ["-3", "0.5"]),
    "gap": lambda r: r.update(gap_percent=0.01),
}


@pytest.mark.parametrize("name", FORGED)
def test_what_is_not_reached_is_refused(found, name):
    document = json.loads(json.dumps(found.to_dict()))
    FORGED[name](document["reached"])
    value = document["reached"]["value"]
    if name not in ("gap", "below the bound") and value:
        document["reached"]["gap_percent"] = 100 * (1 - found.value / value)
    with pytest.raises(PosrealError):
        from_dict(document).check()


def test_a_device_that_is_not_passive_is_not_measured():
    active = dataclasses.replace(DEVICE, coefficients=(0.9, 0.9, 0.9, 0.9, 0.9, 0.9))
    with pytest.raises(PosrealError):
        active.measure(figure(MIDDLE))
    attained = dataclasses.replace(bound(MIDDLE, L=26, both_sides=True).attained, device=active)
    forged = dataclasses.replace(bound(MIDDLE, L=26), attained=attained)
    with pytest.raises(NotProven, match="does not"):
        forged.check()


@pytest.mark.parametrize(
    ("posed", "most"), [(QUARTER_CAR, 1.46), (SIDE, 1.96), (PLAN, 0.155)], ids=lambda v: getattr(v, "name", "")
)
def test_the_order_of_twelve_comes_near(posed, most):
    knots = np.geomspace(2.0, 300.0, 8)
    c0 = fmpq(2600) if posed is QUARTER_CAR else fmpq(40000)
    attained = best_device(figure(posed), [Windows(knots, -0.7 * np.log(knots), 0.0)], 12, c0)
    assert attained is not None
    assert attained.value < most
    assert attained.value == pytest.approx(
        figure(posed).measure(posed.mounting.port(attained.device.admittance())), rel=1e-5
    )


@pytest.mark.long
def test_the_intervals_of_the_papers_vehicles():
    assert bound(SIDE, effort=2, both_sides=True).room_percent < 2.6
    assert bound(problem("vertical-comfort", position="L"), both_sides=True).room_percent < 0.6
    assert bound(PLAN, effort=3, both_sides=True).room_percent < 0.3
