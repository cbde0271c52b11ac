"""Element values: gradients, and optima at least as good as every published row, at points our own check accepts."""

from __future__ import annotations

import numpy as np
import pytest

from posreal.design import layout, optimise, problem
from posreal.design.optimise import _gradient, _Station
from tests import published


@pytest.mark.parametrize("row", published.TABLE2, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_2_optima(row):
    design = optimise(problem(row.problem), layout(row.layout), starts=2)
    design.check()
    assert design.feasible
    assert round(design.objective.value, 4) <= row.figure


@pytest.mark.parametrize("row", published.TABLE3, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_3_optima(row):
    design = optimise(problem(row.problem), layout(row.layout), starts=1)
    design.check()
    assert design.feasible
    assert round(design.objective.value, 1) <= row.figure


@pytest.mark.parametrize("row", published.TABLE6, ids=lambda row: row.layout)
def test_table_6_optima(row):
    design = optimise(problem("vertical-comfort"), layout(row.layout), starts=4)
    design.check()
    assert round(design.objective.value, 2) <= row.T


def test_S6_drops_its_damper():
    posed = problem("vertical-comfort")
    S6, S5 = optimise(posed, layout("S6"), starts=4), optimise(posed, layout("S5"), starts=2)
    assert "c1 at its lower bound" in S6.found["at_bounds"]
    assert S6.objective.value == pytest.approx(S5.objective.value, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "plan"), [("lateral-comfort-primary", "S3"), ("vertical-comfort", "S7"), ("quarter-car", "S2")]
)
def test_the_gradient_is_exact(name, plan):
    station = _Station(problem(name), layout(plan))
    rng = np.random.default_rng(4)
    middle = (station.free.lower + station.free.upper) / 2
    for _ in range(3):
        theta = middle + 0.2 * rng.normal(size=len(middle))
        J, slope = station.rms(theta)
        np.testing.assert_allclose(_gradient(lambda t: station.rms(t)[0], theta)[0], slope, rtol=2e-5, atol=1e-8 * J)


def test_the_same_seed_gives_the_same_design_whatever_the_number_of_jobs():
    posed = problem("vertical-comfort")
    one = optimise(posed, layout("S4"), starts=3, seed=5)
    two = optimise(posed, layout("S4"), starts=3, seed=5, jobs=2)
    assert one.parameters == two.parameters
    assert one.metrics == two.metrics


def test_values_stay_within_bounds():
    design = optimise(problem("vertical-comfort"), layout("S4"), starts=3)
    for name, (low, high) in layout("S4").free_elements(problem("vertical-comfort")).items():
        assert low * (1 - 1e-12) <= design.parameters[name] <= high * (1 + 1e-12)
    assert design.found["at_bounds"] == ["k at its upper bound"]
