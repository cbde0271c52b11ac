"""A design below a proven bound stops the run, whatever part of the program found it."""

from __future__ import annotations

from dataclasses import replace

import control
import numpy as np
import pytest

from posreal.admittance import Rational
from posreal.bounds import guard
from posreal.bounds.result import BelowBound
from posreal.metric import Measured
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.plant.mounting import Mounting
from posreal.specification.from_plant import problem_from_plant
from posreal.specification.layout import layout
from posreal.specification.named import problem
from tests.bounds.test_bound_plants import masses
from tests.bounds.test_bound_plants import posed as plant


@pytest.mark.parametrize(
    ("name", "device"),
    [("quarter-car", "c=2600"), ("vertical-comfort", "c=17965 + b=4115"), ("lateral-comfort", "c=2e4")],
)
def test_honest_designs_pass(name, device):
    design = evaluate(problem(name), device)
    assert guard.guarded(design) is design
    floor = guard._floor(design.problem.vehicle, design.problem.objective, None, design.problem.mounting)
    assert 0.5 * design.objective.value < floor.value < design.objective.value


def test_every_search_is_guarded(monkeypatch):
    """With the floor of a much better vehicle, nothing leaves the program."""
    real = guard._floor

    def raised(*asked):
        floor = real(*asked)
        return replace(floor, value=10 * floor.value, best=None)

    monkeypatch.setattr(guard, "_floor", raised)
    posed = problem("quarter-car")
    with pytest.raises(BelowBound):
        evaluate(posed, "c=2600")
    with pytest.raises(BelowBound):
        evaluate(posed, "S1 c=2600")
    with pytest.raises(BelowBound):
        optimise(posed, layout("S3"), starts=1)
    from posreal.synthesis.synthesise import synthesise
    from posreal.topology.search import search

    with pytest.raises(BelowBound):
        synthesise(posed, 1, starts=1)
    with pytest.raises(BelowBound):
        search(posed, 1)


def test_peaks_in_time_are_guarded_by_their_comfort():
    design = evaluate(problem("lateral-gauging"), "c=2e4")
    assert design.problem.objective == "max_yv"
    assert guard.guarded(design) is design
    assert isinstance(design.metrics["Macc"], Measured)


@pytest.fixture
def own_struts(tmp_path):
    """Layouts without roles, whose springs are free of the vehicle's."""
    (tmp_path / "kc.toml").write_text('network = "k | c"\n')
    (tmp_path / "cb.toml").write_text('network = "c | b"\n')
    (tmp_path / "series.toml").write_text('network = "k + c"\n')
    return lambda name: str(tmp_path / f"{name}.toml")


def test_a_strut_is_held_against_the_spring_that_it_has(own_struts):
    """k | c of 100 N/m is below what any device beside the vehicle's 60 kN/m reaches, and is a legitimate design."""
    soft = evaluate(problem("quarter-car"), f"{own_struts('kc')} k=100 c=200")
    assert guard.held(soft) == Mounting(Rational.spring(100), None)
    with_its_own = guard._floor(soft.problem.vehicle, "J1", None, soft.problem.mounting)
    assert soft.objective.value < with_its_own.value
    assert guard._floor(soft.problem.vehicle, "J1", None, guard.held(soft)).value < soft.objective.value
    assert optimise(problem("quarter-car"), layout(own_struts("kc")), starts=1).feasible
    softer = evaluate(problem("lateral-comfort"), "S1 k=1e4 c=1e3")
    assert guard.held(softer) == Mounting(Rational.spring(10000), None)


def test_a_strut_without_a_bush_is_held_against_no_bush(own_struts):
    side = problem("vertical-comfort")
    rigid = evaluate(side, f"{own_struts('cb')} c=2e4 b=100")
    assert guard.held(rigid) == Mounting(side.mounting.beside, None)
    behind = evaluate(side, f"{own_struts('series')} k=1e5 c=2e4")
    assert guard.held(behind) == side.mounting  # softer than the bush: 1e5 is the bush and another spring in series
    stiff = evaluate(side, f"{own_struts('series')} k=1e8 c=2e4")
    assert guard.held(stiff) == Mounting(side.mounting.beside, Rational.spring(10**8))


@pytest.mark.parametrize("objective", ["J1 + 0.001*J3", "gain_acceleration", "gain_tyre_force + J1"])
def test_sums_and_gains_are_guarded(objective):
    design = evaluate(problem("quarter-car", objective=objective), "c=2000")
    for metric, goal in guard._figures(design.problem):
        floor = guard._floor(design.problem.vehicle, metric, goal, design.problem.mounting)
        assert 0.2 * design.metrics[metric].value < floor.value < design.metrics[metric].value


def test_a_sum_is_the_same_in_either_order():
    first, second = (
        problem("quarter-car", objective=f"{a} + {b}")
        for a, b in [("gain_tyre_force", "J1"), ("J1", "gain_tyre_force")]
    )
    found = [optimise(one, layout("S3"), starts=1).objective.value for one in (first, second)]
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_the_worst_of_three_places_is_guarded_by_each():
    design = evaluate(problem("vertical-comfort", position="worst"), "S5 c=2e4 b=4e3")
    assert [metric for metric, _ in guard._figures(design.problem)] == ["J1z_L", "J1z_M", "J1z_T"]


def test_a_plant_of_ones_own_is_guarded():
    posed = plant(masses(), beside="k=40")
    design = evaluate(posed, "c=30")
    floor = guard._floor(posed.vehicle, "rms_z0", None, posed.mounting)
    assert 0.2 * design.objective.value < floor.value < design.objective.value


def test_a_weighted_sum_over_a_plant_of_ones_own_is_guarded():
    """The quarter-car's masses and springs, a sum of body acceleration and tyre deflection."""
    ms, mu, k, kt = 250.0, 35.0, 20e3, 150e3
    A = np.array([[0, 1, 0, 0], [-k / ms, 0, k / ms, 0], [0, 0, 0, 1], [k / mu, 0, -(k + kt) / mu, 0]])
    A = np.block([[A, np.array([[0.0], [0], [0], [kt / mu]])], [np.zeros((1, 5))]])
    B = np.array([[0, 0], [0, -1 / ms], [0, 0], [0, 1 / mu], [1, 0]])
    C = np.array([A[1], [0, 0, 1, 0, -1], [0, 1, 0, -1, 0]])
    T = np.eye(5)
    T[0, 4] = T[2, 4] = 1.0  # positions relative to the road, which itself is unbounded
    A, B, C = (np.linalg.inv(T) @ A @ T, np.linalg.inv(T) @ B, C @ T)
    A, B, C = A[:4, :4], B[:4], C[:, :4]
    D = np.array([[0, -1 / ms], [0, 0], [0, 0]])
    system = control.ss(A, B, C, D, inputs=["w", "f"], outputs=["a", "tyre", "v"])
    sums = {"a": 1.0, "tyre": 100.0}
    posed = problem_from_plant(system, disturbances="w", force="f", performance="a", velocity="v", weights=sums)
    design = evaluate(posed, "c=1500")
    floor = guard._floor(posed.vehicle, posed.objective, posed.goal, posed.mounting)
    assert 0.2 * design.objective.value < floor.value < design.objective.value


def test_what_has_no_quick_bound_is_not_guarded():
    posed = plant(masses(ports=2))
    design = evaluate(posed, "c=30")
    assert guard.guarded(design) is design
    assert guard._floor(posed.vehicle, "rms_z0", None, posed.mounting) is None
