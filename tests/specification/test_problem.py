"""Problems: names, options, constraints and what stands at the port."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from posreal.admittance import Rational, random_port_hamiltonian
from posreal.errors import BadInput, Infeasible, NotPositiveReal
from posreal.optimisation.evaluate import evaluate
from posreal.specification.named import limited, over_points, problem, problems

NAMES = (
    "lateral-comfort",
    "lateral-comfort-primary",
    "lateral-gauging",
    "lateral-gauging-primary",
    "vertical-comfort",
    "manchester-comfort",
    "quarter-car",
)


def test_the_names_are_the_interface():
    assert tuple(p.name for p in problems()) == NAMES


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", range(3))
def test_the_mounting_in_floats_is_the_exact_port(name, seed):
    mounting = problem(name).mounting
    device = random_port_hamiltonian(3, np.random.default_rng(seed)).rational().scaled(2e4)
    s = 1j * np.geomspace(0.01, 1000, 60)
    found, slope = mounting.response(np.asarray(device(s)), s)
    np.testing.assert_allclose(found, mounting.port(device)(s), rtol=1e-10)
    step = 1e-6 * np.asarray(device(s))
    np.testing.assert_allclose(
        (mounting.response(device(s) + step, s)[0] - mounting.response(device(s) - step, s)[0]) / (2 * step),
        slope,
        rtol=1e-6,
        atol=1e-9,
    )


def test_constraints_are_the_default_s_own_figures():
    posed = problem("lateral-gauging")
    held = {c.metric: (c.sense, c.value) for c in posed.constraints}
    assert held["Ldmp"] == (">=", posed.default_metrics["Ldmp"].value)
    assert held["Macc"] == ("<=", posed.default_metrics["Macc"].value)
    heavier = problem("lateral-gauging", vehicle={"mv": "20 t"})
    assert heavier.constraints[0].value != held["Ldmp"][1]
    assert posed.violated(posed.default_metrics) == []


def test_a_retuned_vehicle_is_compared_with_the_original():
    posed = problem("lateral-comfort-primary")
    tuned = posed.with_vehicle({"Kpy": 6.33e6})
    assert tuned.vehicle.Kpy == 6.33e6
    assert tuned.constraints == posed.constraints
    assert tuned.improvement(posed.default_metrics) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("lateral", {}, "unknown problem"),
        ("vertical-confort", {}, "did you mean vertical-comfort"),
        ("vertical-comfort", {"position": "X"}, "takes L, M or T"),
        ("lateral-comfort", {"position": "L"}, "does not fit"),
        ("quarter-car", {"objective": "J2"}, "it takes J1, J3"),
        ("quarter-car", {"stiffness": -1.0}, "greater than 0"),
        ("vertical-comfort", {"stiffness": 1.0}, "quarter-car takes one"),
    ],
)
def test_bad_options_are_refused(name, options, says):
    with pytest.raises(BadInput, match=says):
        problem(name, **options)


def test_position_and_objective_choose_the_metric():
    assert problem("vertical-comfort", position="M").objective == "J1z_M"
    assert problem("quarter-car", objective="J3", stiffness=8e4).vehicle.k == 8e4


def test_a_device_is_behind_the_bush_or_beside_the_spring():
    found = evaluate(problem("vertical-comfort"), "c=17965 + b=4115")
    same = evaluate(problem("vertical-comfort"), "S5 c=17965 b=4115")
    assert found.port == same.port
    beside = evaluate(problem("lateral-comfort"), Rational.damper(2e4))
    assert beside.metrics["Macc"].value == problem("lateral-comfort").default_metrics["Macc"].value
    beside.check()


def test_devices_that_are_none():
    with pytest.raises(NotPositiveReal):
        evaluate(problem("vertical-comfort"), "(s^2+s+1)/(s^2+0.9*s+4)")
    with pytest.raises(Infeasible, match="not stable"):
        evaluate(problem("lateral-comfort"), "b=3")


def test_a_design_that_was_tampered_with_does_not_check():
    from dataclasses import replace

    from posreal.metric import Measured

    design = evaluate(problem("vertical-comfort"), "c=17965 + b=4115")
    better = replace(design, metrics={**design.metrics, "J1z_T": Measured(1.9, "%g")})
    with pytest.raises(Infeasible, match=r"J1z_T is 1\.96"):
        better.check()


def test_constraints_hold_at_every_operating_point_by_its_own_default():
    points = [{"conicity": 0.35}, {"mv": 20e3}]
    posed = problem("lateral-comfort", worst_case=points, limits={"max_yv": 80.0})
    held = {c.metric: c for c in posed.constraints}
    assert set(held) == {
        f"{name}{at}" for name in ("Ldmp", "Macc_whole", "max_yv") for at in ("", " at conicity=0.35", " at mv=20000")
    }
    for point, name in zip(points, posed.at_points, strict=True):
        there = problem("lateral-comfort", vehicle=point)
        assert held[f"Ldmp at {name}"].value == there.default_metrics["Ldmp"].value
        assert held[f"max_yv at {name}"].value == 80.0
    design = evaluate(posed, "S3 c=2.1025e4 b=1.53e4")
    assert not design.feasible
    assert posed.violated(design.metrics) == ["max_yv at mv=20000 <= 80 (a limit) is violated: 91.4944"]
    with pytest.raises(Infeasible, match="max_yv at mv=20000"):
        design.check()
    verdicts = {row["metric"]: row["verdict"] for row in design.to_dict()["constraints"]}
    assert verdicts["max_yv at mv=20000"] == "violated"
    assert verdicts["Ldmp"] == "holds"


def test_a_retuned_vehicle_keeps_each_point_s_reference():
    posed = problem("lateral-comfort-primary", worst_case=[{"mv": 20e3}])
    tuned = posed.with_vehicle({"Kpy": 6.33e6})
    assert tuned.constraints == posed.constraints
    (there,) = tuned.at_points.values()
    assert (there.vehicle.Kpy, there.vehicle.mv) == (6.33e6, 20e3)
    assert tuned.original is posed


def test_a_limit_on_a_retuned_vehicle_leaves_the_reference_as_it_was():
    posed = problem("lateral-comfort-primary")
    tuned = posed.with_vehicle({"Kpy": 9e6, "Cpy": 5e4})
    asked = {"max_yv": 90.0}
    for made in (limited(tuned, asked), limited(posed, asked).with_vehicle({"Kpy": 9e6, "Cpy": 5e4})):
        assert made.constraints == limited(posed, asked).constraints
        assert made.improvement(posed.default_metrics) == 0
    assert tuned == posed.with_vehicle({"Kpy": 9e6, "Cpy": 5e4})
    assert tuned != dataclasses.replace(tuned, reference=None)  # keeps what its own default suspension has
    assert tuned.with_vehicle({"Kpy": posed.vehicle.Kpy, "Cpy": posed.vehicle.Cpy}) == posed


def test_points_and_restrictions_of_a_retuned_vehicle_keep_the_reference():
    posed = problem("lateral-comfort-primary")
    values = {"Kpy": 9e6, "Cpy": 5e4}
    for points in ([{"mv": 20e3}], [{"conicity": 0.25}, {"mv": 20e3}]):
        after, before = over_points(posed.with_vehicle(values), points), over_points(posed, points).with_vehicle(values)
        assert after.constraints == before.constraints == over_points(posed, points).constraints
        assert [p.vehicle for p in after.at_points.values()] == [p.vehicle for p in before.at_points.values()]
    held = limited(posed, {"Macc": 0.25})
    assert limited(posed.with_vehicle(values), {"Macc": 0.25}).constraints == held.constraints
    assert held.with_vehicle(values).constraints == held.constraints


def test_nothing_can_be_kept_where_the_default_is_unstable():
    with pytest.raises(Infeasible, match=r"with the default suspension, at conicity=0.6: the vehicle is not"):
        _ = problem("lateral-comfort", worst_case=[{"conicity": 0.6}]).constraints
