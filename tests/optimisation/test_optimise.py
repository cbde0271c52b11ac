"""Element values: gradients, and optima at least as good as every published row, at points our own check accepts."""

from __future__ import annotations

import numpy as np
import pytest

from posreal.errors import BadInput, Infeasible
from posreal.optimisation.element_search import ElementSearch, Watch
from posreal.optimisation.layout_values import evaluate_layout, optimise
from posreal.specification.layout import layout
from posreal.specification.named import problem
from tests import published


@pytest.mark.parametrize("row", published.TABLE2, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_2_optima(row):
    design = optimise(problem(row.problem), layout(row.layout), starts=2, any_values=True)
    design.check()
    assert design.feasible
    assert round(design.objective.value, 4) <= row.figure


@pytest.mark.parametrize("row", published.TABLE3, ids=lambda row: f"{row.problem}-{row.layout}")
def test_table_3_optima(row):
    design = optimise(problem(row.problem), layout(row.layout), starts=1, any_values=True)
    design.check()
    assert design.feasible
    assert round(design.objective.value, 1) <= row.figure


@pytest.mark.parametrize("row", published.TABLE6, ids=lambda row: row.layout)
def test_table_6_optima(row):
    design = optimise(problem("vertical-comfort"), layout(row.layout), starts=4, any_values=True)
    design.check()
    assert round(design.objective.value, 2) <= row.T


def test_S6_drops_its_damper():
    posed = problem("vertical-comfort")
    S6, S5 = (
        optimise(posed, layout("S6"), starts=4, any_values=True),
        optimise(posed, layout("S5"), starts=2, any_values=True),
    )
    assert "c1 at its lower bound" in S6.found["at_bounds"]
    assert S6.objective.value == pytest.approx(S5.objective.value, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "plan", "options"),
    [
        ("lateral-comfort-primary", "S3", {"worst_case": [{"mv": 20e3}]}),
        ("lateral-gauging-primary", "S2", {"limits": {"static_stiffness": 1e6, "inertance": 1e6}}),
        ("vertical-comfort", "S7", {"position": "worst", "limits": {"deflection_overall_rear": 60.0}}),
        ("quarter-car", "S2", {"objective": "J1 + 0.001*J3", "limits": {"gain_acceleration": 1e3}}),
    ],
)
def test_the_gradient_of_everything_that_counts_is_exact(name, plan, options):
    station = ElementSearch(problem(name, **options), layout(plan))
    rng = np.random.default_rng(4)
    elements = station.elements
    theta = (elements.lower + elements.upper) / 2 + 0.2 * rng.normal(size=elements.size)
    parameters = {key: (r.lower + r.upper) / 2 for key, r in station.free.items()}
    functions = [f.slopes for f in station.objective] + [r.margins for r in station.requirements(Watch())]
    for function in functions:
        here = function(elements, theta, parameters)
        step = rng.normal(size=elements.size)
        up, down = (function(elements, theta + h * step, parameters).values for h in (1e-5, -1e-5))
        size = np.abs(here.values).max()
        np.testing.assert_allclose(step @ here.by_theta, (up - down) / 2e-5, rtol=1e-4, atol=1e-5 * size)
        for key, value in parameters.items():
            up, down = (function(elements, theta, parameters | {key: value * h}).values for h in (1 + 1e-5, 1 - 1e-5))
            np.testing.assert_allclose(value * here.by[key], (up - down) / 2e-5, rtol=1e-4, atol=1e-5 * size)


def test_the_same_seed_gives_the_same_design_whatever_the_number_of_jobs():
    posed = problem("vertical-comfort")
    one = optimise(posed, layout("S4"), starts=3, seed=5, any_values=True)
    two = optimise(posed, layout("S4"), starts=3, seed=5, jobs=2, any_values=True)
    assert one.parameters == two.parameters
    assert one.metrics == two.metrics


def test_values_stay_within_bounds():
    design = optimise(problem("vertical-comfort"), layout("S4"), starts=3, any_values=True)
    for name, (low, high) in layout("S4").free_elements(problem("vertical-comfort")).items():
        assert low * (1 - 1e-12) <= design.parameters[name] <= high * (1 + 1e-12)
    assert design.found["at_bounds"] == ["k at its upper bound"]


@pytest.mark.parametrize(
    ("name", "plan", "options"),
    [
        ("vertical-comfort", "S7", {"position": "worst", "limits": {"deflection_rear": 34.0}}),
        ("vertical-comfort", "S5", {"worst_case": [{"Crz": 40e3}, {"Crz": 90e3}]}),
        ("quarter-car", "S3", {"objective": "gain_acceleration"}),
        ("quarter-car", "S3", {"objective": "J1 + 0.001*J3", "limits": {"inertance": 5.0}}),
    ],
)
def test_an_objective_made_of_several_figures(name, plan, options):
    """No step of forty, in any direction within bounds and limits, is better."""
    posed = problem(name, **options)
    best = optimise(posed, layout(plan), starts=4, any_values=True)
    best.check()
    rng = np.random.default_rng(1)
    free = layout(plan).free_elements(posed)
    for size in np.repeat([0.3, 0.03], 20):
        values = {key: value * np.exp(size * rng.normal()) for key, value in best.parameters.items() if key in free}
        if all(low <= values[key] <= high for key, (low, high) in free.items()):
            other = evaluate_layout(posed, layout(plan), values)
            assert not other.feasible or other.objective.value >= best.objective.value * (1 - 1e-7)


def test_damping_is_kept_at_every_operating_point():
    posed = problem("lateral-comfort", worst_case=[{"conicity": 0.35}])
    best = optimise(posed, layout("S3"), starts=3, any_values=True)
    best.check()
    assert best.objective.value < posed.default_metrics[posed.objective].value
    alone = optimise(problem("lateral-comfort"), layout("S3"), starts=2, any_values=True)
    assert best.metrics["Macc"].value >= alone.objective.value * (1 - 1e-9)


def test_a_layout_with_nothing_to_choose_is_refused(tmp_path):
    path = tmp_path / "fixed.toml"
    path.write_text('network = "c"\n[elements.c]\nfixed = 2e3\n')
    with pytest.raises(BadInput, match="leaves no value to choose"):
        optimise(problem("quarter-car"), layout(path), any_values=True)


@pytest.mark.parametrize(
    ("name", "plan", "values", "point"),
    [
        ("lateral-comfort", "S3", {"c": 2.1e4, "b": 1.5e4}, {"Ksy": 2e5}),
        ("vertical-comfort", "S5", {"c": 1.8e4, "b": 4e3, "k": 4e6}, {"Crz": 5e4}),
    ],
)
def test_a_layouts_own_spring_has_the_points_value(name, plan, values, point):
    """The search sees at the operating point what the metrics measure there: the layout in that vehicle."""
    posed = problem(name, worst_case=[point])
    station = ElementSearch(posed, layout(plan))
    theta = np.log([values[key] for key in station.elements.names])
    measured = evaluate_layout(posed, layout(plan), station.elements.values(theta)).metrics
    free = {key: value for key, value in values.items() if key in layout(plan).free_elements(posed)}
    alone = evaluate_layout(problem(name, vehicle=point), layout(plan), free).metrics
    (label,) = posed.at_points
    base = posed.base_objective
    assert measured[f"{base} at {label}"].value == pytest.approx(alone[base].value, rel=1e-9)
    seen = [float(figure.values(station.elements.device(theta), {}).max()) for figure in station.objective]
    ride = "J1y" if base == "Macc" else base
    assert seen == pytest.approx([measured[ride].value, alone[ride].value], rel=1e-3)


@pytest.mark.parametrize(
    ("plan", "error", "says"),
    [("S7", Infeasible, "bush cannot vary here"), ("S5", BadInput, "chooses its own bush, so no operating point")],
)
def test_a_bush_that_is_not_the_vehicles_alone_cannot_vary(plan, error, says):
    posed = problem("vertical-comfort", worst_case=[{"bush": 1e6}])
    with pytest.raises(error, match=says):
        optimise(posed, layout(plan), starts=1, any_values=True)


def test_a_design_prints_its_figures_and_its_network():
    posed = problem("quarter-car")
    design = optimise(posed, layout("S1"), starts=1, any_values=True)
    text = str(design)
    assert text.startswith("quarter-car: S1\n  J1 = 1.759")
    assert text.endswith(f"  {design.network}")
