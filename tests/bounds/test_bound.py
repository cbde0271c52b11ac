"""Bounds: nothing positive real beats them, what is not positive real breaks their inequality, and they are close."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from flint import fmpq
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from posreal.admittance import Rational, parse_rational, random_port_hamiltonian
from posreal.admittance.roots import precision
from posreal.bounds import device_at_points, shor_dual
from posreal.bounds.compute import bound
from posreal.bounds.figure import BoundedFigure, enclosed, figure
from posreal.bounds.interpolation_space import floats
from posreal.bounds.points import cycled
from posreal.bounds.result import BelowBound
from posreal.bounds.sampled import Sampled
from posreal.errors import BadInput, Infeasible
from posreal.optimisation.evaluate import evaluate
from posreal.plant.mounting import Mounting
from posreal.specification.named import problem
from posreal.study.price_of_simplicity import reached
from posreal.vehicle import QuarterCar
from tests.strategies import trees

QUARTER_CAR = problem("quarter-car")
SIDE = problem("vertical-comfort")
MIDDLE = problem("vertical-comfort", position="M")
PLAN = problem("lateral-comfort")
BEST_J1 = 1.411600  # the best device known at k = 60 kN/m, order 10 beside an inerter

SCALES = {"quarter-car": (2600.0, 20), "side-view": (20000.0, 10), "plan-view": (20000.0, 10)}


def seen(posed, device, size=9):
    """x of every loop, Φ(x), and the projection of z, for a device in its place."""
    damper, omega = SCALES[posed.vehicle.name]
    about = figure(posed)
    with precision(400):
        found = enclosed(about, cycled([omega, (2.0 * omega, 0.4), 2.0 * omega], size), fmpq(int(damper)))
        space = found.space
        c0 = Rational.damper(int(damper))
        sigma = space.rational(device.without(c0).times((device | c0).inverse()))
        x = [space.over(sigma * 2, space.one - w * sigma) for w in found.W]
        X = [floats(space.operator(part)) for part in x]
    data = Sampled.of(found)
    columns = [floats(part)[:, 0] for part in x]
    a = np.vstack([2 * np.eye(size) + part @ w for part, w in zip(X, data.W, strict=True)])
    b = np.vstack(X)
    z = data.tau + sum(np.einsum("rkj,j->rk", o, part) for o, part in zip(data.O, columns, strict=True))
    return data, columns, X, a @ a.T - b @ b.T, float(np.linalg.norm(z))


def least(Phi):
    return float(np.linalg.eigvalsh(Phi)[0] / max(1.0, np.abs(Phi).max()))


def device_for(posed, admittance):
    """A drawn device (values around one) on the vehicle's scales, a little damped."""
    damper, omega = SCALES[posed.vehicle.name]
    return admittance.time_scaled(fmpq(1, omega)).scaled(int(damper)) | Rational.damper(10)


@pytest.mark.parametrize("posed", [QUARTER_CAR, MIDDLE, SIDE, PLAN], ids=lambda p: f"{p.name}-{p.objective}")
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(network=trees(5, decades=2), seed=st.integers(0, 2**32 - 1))
def test_positive_real_devices_satisfy_the_inequality(posed, network, seed):
    drawn = random_port_hamiltonian(3, np.random.default_rng(seed), 1.0).rational()
    for device in (device_for(posed, network.admittance()), device_for(posed, drawn)):
        data, columns, X, Phi, projected = seen(posed, device)
        assert least(Phi) > -1e-9
        if len(columns) == 2:  # one device in both loops
            d = (data.W[1] - data.W[0])[:, 0]
            gap = columns[1] - columns[0] - X[0] @ X[1] @ d / 2
            assert np.abs(gap).max() < 1e-9 * max(1.0, np.abs(columns).max() ** 2)
        try:
            whole = figure(posed).measure(posed.port(device))
        except Infeasible:  # some make the plan view hunt
            continue
        assert projected <= whole * (1 + 1e-7)


@pytest.mark.parametrize("text", ["-6e4/s", "-200*s", "2600 - 3e4/s", "2600 - 100*s", "-10", "2600*(s - 30)/(s + 30)"])
@pytest.mark.parametrize("posed", [QUARTER_CAR, MIDDLE], ids=lambda p: p.objective)
def test_what_is_not_positive_real_breaks_the_inequality(posed, text):
    assert least(seen(posed, parse_rational(text).scaled(1 if posed is QUARTER_CAR else 7), 21)[3]) < -1e-4


def test_a_negative_spring_would_beat_the_bound_on_the_axis():
    # Re Y(jω) is that of the damper: only the interior of the half plane tells −k/s from nothing at all
    device = parse_rational("2600 - 45000/s")
    figure_J1 = figure(QUARTER_CAR).measure(QUARTER_CAR.port(device))
    found = bound(QUARTER_CAR, L=20, omega0=20)
    assert figure_J1 < found.value
    with pytest.raises(BelowBound):
        found.beside(QUARTER_CAR.port(device))


@pytest.mark.parametrize("objective", ["J1", "J3"])
def test_one_point_has_a_closed_form(objective):
    # one point a: σ(a) is any number in [−1, 1], Y(a) any in [0, ∞]
    posed = problem("quarter-car", objective=objective)
    data = Sampled.of(enclosed(figure(posed), [fmpq(20)], fmpq(2600)))
    w, o, t = data.W[0, 0, 0], data.O[0, 0, 0, 0], data.tau[0, 0]
    free = -t / o
    nearest = min(max(free, -2 / (1 + w)), 2 / (1 - w))
    assert bound(posed, L=0, omega0=20).value == pytest.approx(abs(t + o * nearest), rel=1e-4, abs=1e-6 * abs(t))


@pytest.mark.parametrize(("posed", "sizes"), [(QUARTER_CAR, (1, 4, 9, 20, 30)), (SIDE, (2, 4, 8)), (PLAN, (2, 6, 12))])
@pytest.mark.parametrize("omega0", [15, (10, 30)])
def test_monotone_in_the_number_of_points(posed, sizes, omega0):
    values = [bound(posed, L=L, omega0=omega0).value for L in sizes]
    assert all(b > a * (1 - 1e-5) for a, b in pairwise(values))
    assert values[-1] > values[0]


def test_quarter_car_is_settled_to_two_parts_in_a_thousand():
    found = bound(QUARTER_CAR, L=60, omega0=20, best=BEST_J1)
    assert found.value >= 1.4095
    assert 0 < found.gap_percent <= 0.2
    assert found.check() >= found.value


@pytest.mark.parametrize("stiffness", [15e3, 30e3, 120e3])
@pytest.mark.parametrize("objective", ["J1", "J3"])
def test_other_stiffnesses_stay_below_every_simple_strut(stiffness, objective):
    posed = problem("quarter-car", objective=objective, stiffness=stiffness)
    found = bound(posed, L=20, omega0=20)
    simple = min(
        figure(posed).measure(posed.port(parse_rational(text)))
        for text in ("1500", "2600", "4000", "2300 + 30*s", "3200*333*s/(3200 + 333*s)")
    )
    assert 0.5 * simple < found.value < simple


def test_the_weighted_sum_lies_above_the_sum_of_the_bounds():
    parts = [bound(problem("quarter-car", objective=name), L=20, omega0=20).value for name in ("J1", "J3")]
    both = bound(QUARTER_CAR, weights={"J1": 1.0, "J3": 1e-6}, L=20, omega0=20)
    assert both.value >= math.sqrt(parts[0] ** 2 + 1e-6 * parts[1] ** 2) * (1 - 1e-6)
    design = evaluate(QUARTER_CAR, "b=30 | c=2300")
    J1, J3 = (design.metrics[name].value for name in ("J1", "J3"))
    assert both.beside(design).best.value == pytest.approx(math.sqrt(J1**2 + 1e-6 * J3**2), rel=1e-9)


def test_side_view_middle_on_the_papers_vehicle():
    found = bound(MIDDLE, L=24, omega0=20, best=evaluate(MIDDLE, "c=17965 + b=4115"))
    assert (found.form, found.passive, found.unit) == ("plain", True, "%g")
    assert 0.765 < found.value < found.best.value
    # the band of the paper ends at 20 Hz; the bound and what is put beside it do not
    assert found.best.value > evaluate(MIDDLE, "c=17965 + b=4115").metrics["J1z_M"].value + 0.04
    assert "whole-band" in found.kind


def test_shared_device_by_the_lifted_form():
    found = bound(SIDE, L=10, omega0=10, best=evaluate(SIDE, "c=17965 + b=4115"))
    assert found.form == "lifted"
    assert 1.31 < found.value < found.best.value
    assert bound(SIDE, L=10, omega0=16).value > 1.31


def test_pairs_of_points_prove_more_than_single_ones():
    single, pairs = (bound(SIDE, L=20, omega0=omega0).value for omega0 in (16, (8, (50, 0.44), 8)))
    assert pairs > 1.6 > single > 1.56
    assert bound(QUARTER_CAR, L=20, omega0=(10, (20, 0.8), 10)).value > 1.4015


@pytest.mark.parametrize(
    ("posed", "omega0"),
    [(SIDE, 16), (problem("vertical-comfort", position="L"), (6, (70, 0.4), 6)), (PLAN, 10), (QUARTER_CAR, 20)],
    ids=lambda value: getattr(value, "objective", ""),
)
def test_the_relaxation_loses_nothing(posed, omega0):
    # a device's values at the points that reach what the certificate proves: no certificate there proves more
    about = figure(posed)
    points = cycled(omega0 if isinstance(omega0, tuple) else (omega0,), 13)
    data = Sampled.of(enclosed(about, points, fmpq(20000 if posed is not QUARTER_CAR else 2600)))
    reached_there = device_at_points.solve(data, tolerance=1e-7)
    proven = math.sqrt(shor_dual.solve(data, tolerance=1e-6).value)
    assert proven <= reached_there.value * (1 + 1e-9)
    assert proven == pytest.approx(reached_there.value, rel=2e-4)
    on_kernel = shor_dual.solve(data, reached_there.kernel, tolerance=1e-6)
    assert math.sqrt(on_kernel.value) == pytest.approx(proven, rel=2e-4)


@pytest.mark.long
def test_what_the_scan_proves_by_default():
    assert bound(SIDE).value > 1.71
    assert bound(problem("vertical-comfort", position="L")).value > 1.523
    assert bound(MIDDLE).value > 0.789
    assert bound(PLAN).value > 0.1437
    assert bound(QUARTER_CAR).value > 1.4097


def test_plan_view_by_the_lifted_form():
    found = bound(PLAN, L=12, omega0=10, best=evaluate(PLAN, None))
    assert (found.form, found.passive) == ("lifted", False)
    assert found.value > 0.1374
    assert "stable" in found.devices
    with pytest.raises(BadInput, match="not positive real"):
        bound(PLAN, L=4, form="plain")


def hardly_active(negative):
    """The quarter-car with a damper of −negative N s/m across its port: Re P is negative somewhere."""
    plant = QuarterCar().road()
    fed = dataclasses.replace(plant, A=plant.A - negative * plant.Bf @ plant.Cv)
    return BoundedFigure(fed, Mounting(Rational.spring(60000), None), {"acceleration": fmpq(1)}, "ride", "m/s^2")


def test_a_slightly_active_port_is_refused_by_the_plain_form_and_served_by_the_lifted():
    with pytest.raises(BadInput, match="not positive real"):
        bound(hardly_active(1e-6), form="plain", L=8, omega0=20)
    active = bound(hardly_active(1e-6), L=12, omega0=20)
    assert (active.form, active.passive) == ("lifted", False)
    passive = bound(hardly_active(0.0), L=12, omega0=20)
    assert (passive.form, passive.passive) == ("plain", True)
    assert active.value == pytest.approx(passive.value, rel=1e-4)
    assert active.check() >= active.value


def test_the_lifted_form_agrees_with_the_plain_one_where_both_apply():
    plain, lifted = (bound(QUARTER_CAR, L=12, omega0=20, form=form).value for form in ("plain", "lifted"))
    assert lifted == pytest.approx(plain, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "words"),
    [("lateral-gauging", "max_yv is known: it is a peak in time"), ("lateral-comfort-primary", "Kpy and Cpy free")],
)
def test_problems_without_a_bound_are_refused(name, words):
    with pytest.raises(BadInput, match=words):
        bound(problem(name))


def test_a_peak_in_time_has_no_bound():
    with pytest.raises(BadInput, match=r"max_yv is known: it is a peak in time"):
        bound(dataclasses.replace(PLAN, objective="max_yv"))
    with pytest.raises(BadInput, match="not a mean-square figure"):
        bound(QUARTER_CAR, weights={"J2": 1.0})


@pytest.mark.parametrize(
    "options", [{"L": -1}, {"L": 10**6}, {"effort": 9}, {"omega0": 0.0}, {"omega0": ()}, {"form": "x"}]
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(BadInput):
        bound(QUARTER_CAR, **options)


def test_ports_that_feel_each_other_are_refused():
    plant = SIDE.vehicle.track()
    coupled = plant.Bf @ np.array([[1.0, 0.5], [0.0, 1.0]])
    with pytest.raises(BadInput, match="feel each other"):
        BoundedFigure(
            dataclasses.replace(plant, Bf=coupled), Mounting(None, None), {"acceleration_T": fmpq(1)}, "z", "1"
        )


def test_the_scan_finds_a_good_place():
    assert bound(QUARTER_CAR, L=20).value > 1.398


# --- sums of norms and peaks ---------------------------------------------------------------------------------


def test_a_weighted_sum_of_roots():
    posed = problem("quarter-car", objective="J1 + 0.001*J3")
    found = bound(posed, L=30, omega0=20, best=posed.port(parse_rational("2300 + 30*s")))
    alone = [bound(problem("quarter-car", objective=name), L=30, omega0=20).value for name in ("J1", "J3")]
    assert alone[0] + 1e-3 * alone[1] < found.value < found.best.value
    assert found.check() >= found.value
    # the same design, whose figure is J1 + J3/1000
    design = evaluate(QUARTER_CAR, "b=30 | c=2300")
    expected = design.metrics["J1"].value + 1e-3 * design.metrics["J3"].value
    assert found.best.value == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("objective", ["gain_acceleration", "gain_tyre_force"])
def test_the_largest_gain(objective):
    posed = problem("quarter-car", objective=objective)
    values = [bound(posed, L=L, omega0=20).value for L in (0, 6, 20)]
    assert all(b >= a * (1 - 1e-5) for a, b in pairwise(values))
    found = bound(posed, L=20, omega0=20)
    assert (found.kind, found.unit) == ("H-infinity", "1")
    gains = [
        figure(posed).measure(posed.port(parse_rational(text)))
        for text in ("1500", "3000", "4500", "6000", "3000 + 20*s", "9000*600*s/(9000 + 600*s)")
    ]
    assert 0.4 * min(gains) < found.value < min(gains)
    assert found.check() >= found.value


def test_at_the_point_no_gain_is_below_the_value_itself():
    # one point, and a device that is forced to a rigid strut or to nothing: |z(a)| at best over σ(a) in [−1, 1]
    posed = problem("quarter-car", objective="gain_acceleration")
    data = Sampled.of(enclosed(figure(posed), [fmpq(20)], fmpq(2600)))
    w, o, t = data.W[0, 0, 0], data.O[0, 0, 0, 0], data.tau[0, 0]
    nearest = min(max(-t / o, -2 / (1 + w)), 2 / (1 - w))
    assert bound(posed, L=0, omega0=20).value == pytest.approx(abs(t + o * nearest), rel=1e-4, abs=1e-6)


def test_sums_and_peaks_need_one_passive_port():
    with pytest.raises(BadInput, match="one passive port"):
        bound(dataclasses.replace(figure(SIDE), combine="sum"))
    with pytest.raises(BadInput, match="peak takes one"):
        dataclasses.replace(figure(QUARTER_CAR, {"J1": 1.0, "J3": 1.0}), combine="peak")


def test_the_worst_of_several_points_is_refused_with_advice():
    with pytest.raises(BadInput, match="bound one of its parts"):
        bound(problem("vertical-comfort", position="worst"))


def test_orders_are_measured_against_the_bound(monkeypatch):
    known = {1: "c=3224.2 + b=333.3", 2: "(c=3224.2 + b=333.3) | b=20"}

    def looked_up(posed, order, *, warm, **options):
        assert len(warm) == order - 1
        return evaluate(posed, known[order])

    monkeypatch.setattr("posreal.study.price_of_simplicity.synthesise", looked_up)
    found = bound(QUARTER_CAR, L=20, omega0=20)
    low, high = reached(found, (1, 2))
    assert (low.order, high.order) == (1, 2)
    assert low.value == pytest.approx(1.585094, rel=1e-5)
    assert low.gap_percent == pytest.approx(100 * (1 - found.value / low.value))
    with pytest.raises(BadInput, match="no problem"):
        reached(bound(figure(QUARTER_CAR), L=2, omega0=20))


def test_orders_of_the_side_view_minimise_the_whole_band(monkeypatch):
    # with the band-limited figure, a device that rings above 20 Hz would pass for a good one
    def looked_up(posed, order, **options):
        assert posed.objective == "J1z_M_whole"
        return evaluate(posed, "c=17965 + b=4115")

    monkeypatch.setattr("posreal.study.price_of_simplicity.synthesise", looked_up)
    found = bound(MIDDLE, L=8, omega0=20)
    (first,) = reached(found, (1,))
    assert first.value == pytest.approx(
        found.figure.measure(MIDDLE.port(parse_rational("17965*4115*s/(17965 + 4115*s)")))
    )
    assert first.value == pytest.approx(first.design.objective.value)


@pytest.mark.long
def test_what_low_orders_reach():
    first, second = reached(bound(QUARTER_CAR, L=40, omega0=20), (1, 2), starts=6)
    assert first.value == pytest.approx(1.585094, rel=1e-4)
    assert second.value < 1.55
