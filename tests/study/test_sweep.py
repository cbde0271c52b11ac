"""Robustness: a design over vehicle parameters, the worst beside the nominal, the default suspension along with it."""

from __future__ import annotations

import json

import pytest

from posreal.errors import BadInput
from posreal.optimisation.evaluate import evaluate, read_design
from posreal.specification.named import problem
from posreal.study.sweep import read_ranges, sweep

CRZ, MASS = [30e3, 60e3, 90e3], [36e3, 40e3]


@pytest.fixture(scope="module")
def swept():
    design = evaluate(problem("vertical-comfort"), "S5 c=17965 b=4115")
    return sweep(design, {"Crz": CRZ, "mv": MASS})


def test_every_combination_is_the_changed_vehicle_s_own_figure(swept):
    assert [dict(point) for point in swept.points] == [{"Crz": c, "mv": m} for c in CRZ for m in MASS]
    for point, metrics, default in zip(swept.points, swept.metrics, swept.default, strict=True):
        there = problem("vertical-comfort", vehicle=point)
        again = evaluate(there, "S5 c=17965 b=4115").metrics
        assert {name: m.value for name, m in metrics.items()} == pytest.approx(
            {name: m.value for name, m in again.items()}, rel=1e-12
        )
        assert default["J1z_T"].value == pytest.approx(there.default_metrics["J1z_T"].value, rel=1e-12)


def test_the_worst_stands_beside_the_nominal_and_the_gain_beside_the_least_gain(swept):
    ride = swept.robustness["J1z_T"]
    own = [metrics["J1z_T"].value for metrics in swept.metrics]
    default = [metrics["J1z_T"].value for metrics in swept.default]
    assert ride.nominal == swept.design.metrics["J1z_T"].value
    assert (ride.worst, ride.default_worst) == (max(own), max(default))
    assert own[swept.points.index(ride.at)] == max(own)
    assert ride.gain == pytest.approx(swept.design.improvement())
    assert ride.least_gain == pytest.approx(min(100 * (1 - a / b) for a, b in zip(own, default, strict=True)))
    assert "static_stiffness" not in swept.robustness
    text = str(swept)
    assert "least better" in text
    assert f"{max(own):#.5g}" in text
    json.dumps(swept.to_dict(), allow_nan=False)


def test_less_damping_is_worse_and_an_unstable_point_is_said():
    design = read_design(problem("lateral-comfort"), ["S3", "c=2.1025e4", "b=1.53e4"])
    found = sweep(design, "conicity", [0.1, 0.35])
    assert found.robustness["Ldmp"].at == {"conicity": 0.35}
    assert found.robustness["Ldmp"].worst < found.robustness["Ldmp"].nominal
    lost = sweep(design, "conicity", [0.3, 0.6])
    assert lost.metrics[1] is None
    assert lost.default[1] is None
    assert lost.robustness["Macc"].worst is None
    assert "unstable" in str(lost)
    assert lost.to_dict()["rows"][1] == {"value": 0.6, "values": {"conicity": 0.6}, "metrics": None, "default": None}


def test_the_static_spring_of_a_layout_follows_the_vehicle():
    design = read_design(problem("lateral-comfort"), ["S3", "c=2.1025e4", "b=1.53e4"])
    (metrics,) = sweep(design, "Ksy", [2e5]).metrics
    there = read_design(problem("lateral-comfort", vehicle={"Ksy": 2e5}), ["S3", "c=2.1025e4", "b=1.53e4"])
    assert metrics["Macc"].value == pytest.approx(there.metrics["Macc"].value, rel=1e-12)
    assert metrics["static_stiffness"].value == 2e5


def test_a_vehicle_without_a_default_suspension():
    found = sweep(evaluate(problem("quarter-car"), "c=2000"), "ms", [200.0, 300.0])
    assert found.default == ()
    assert found.robustness["J1"].gain is None
    assert "least better" not in str(found)


def test_ranges_that_make_no_sense_are_refused():
    design = evaluate(problem("quarter-car"), "c=2000")
    with pytest.raises(BadInput, match="swept twice"):
        read_ranges(design.problem, ["ms=1:2:3", "ms=1:2:3"])
    with pytest.raises(BadInput, match="90000 points cannot be swept"):
        sweep(design, read_ranges(design.problem, ["ms=1:2:300", "k=1:2:300"]))
    with pytest.raises(BadInput, match="unknown parameter 'V1'"):
        read_ranges(design.problem, ["V1=1:2:3"])
    with pytest.raises(BadInput, match="must be finite and greater than 0"):
        sweep(design, "ms", [0.0])
