"""What is best to 20 Hz may ring above: no search returns what is worse than nothing over all frequencies."""

from __future__ import annotations

import math

import pytest

import posreal as pr
from posreal.errors import Infeasible
from posreal.network.topologies import network, topologies, valued
from posreal.optimisation.layout_values import improve
from posreal.specification.layout import ElementRule, Layout
from posreal.topology.found import SearchSettings
from posreal.topology.values import best_values
from posreal.vehicle import PlanView, SideView, whole_band_twin
from tests.fuzz import independent

BUSH = ElementRule(fixed="bush")
RINGING = "b1 | b2 + c + k"


@pytest.mark.parametrize("vehicle", [SideView(), PlanView()])
def test_what_ends_at_20_hz_has_a_twin_that_does_not(vehicle):
    ends = [name for name, metric in vehicle.metrics.items() if metric.norm() and math.isfinite(metric.norm().stop)]
    assert ends
    for name in ends:
        twin = vehicle.metrics[whole_band_twin(vehicle, name)]
        assert math.isinf(twin.norm().stop)
        assert twin.norm().output == vehicle.metrics[name].norm().output
        assert twin.unit == vehicle.metrics[name].unit
        assert (name in vehicle.headline) == (name + "_whole" in vehicle.headline)
    assert whole_band_twin(vehicle, ends[0] + "_whole") is None


def test_the_network_that_is_worse_than_nothing_above_20_hz():
    """The best four elements to 20 Hz: 1.8828 %g there, 2.365 over all frequencies; the airspring alone has 2.227."""
    problem = pr.problem("vertical-comfort")
    design = pr.evaluate(problem, "b=178.648 | b=4214.08 + c=22218.2 + k=1349750")
    element = independent.element
    four = independent.parallel(
        element("b", "178.648"),
        independent.series(element("b", "4214.08"), independent.series(element("c", "22218.2"), element("k", 1349750))),
    )
    right, nothing = independent.side_view(four), independent.side_view(None)
    assert design.metrics["J1z_T_whole"].value == pytest.approx(right["J1z_T_whole"], rel=1e-9)
    assert design.metrics["J1z_T"].value < 1.8829
    assert right["J1z_T_whole"] > 2.365 > nothing["J1z_T_whole"]
    (constraint,) = problem.constraints
    assert constraint.value == pytest.approx(nothing["J1z_T_whole"], rel=2e-6)
    assert constraint.verdict(design.metrics) == "VIOLATED"
    assert not pr.problem("vertical-comfort", band_only=True).constraints


def test_a_topology_keeps_the_other_band():
    (form,) = (form for form in topologies(4) if str(network(form)) == RINGING)
    both, band = (
        best_values(pr.problem("vertical-comfort", band_only=only), form, SearchSettings(8)) for only in (False, True)
    )
    assert band.objective == pytest.approx(1.88281, rel=1e-5)
    assert both.objective == pytest.approx(1.88343, rel=1e-5)
    design = pr.evaluate(pr.problem("vertical-comfort"), valued(form, both.values))
    assert design.feasible
    assert design.metrics["J1z_T_whole"].value == pytest.approx(2.22705, rel=1e-5)


def test_a_layout_keeps_the_other_band():
    rules = {name: ElementRule(bounds=(1e2, 1e8)) for name in ("c", "k")} | {
        "b1": ElementRule(bounds=(10.0, 1e4)),
        "b2": ElementRule(bounds=(10.0, 1e5)),
        "k_bush": BUSH,
    }
    layout = Layout("ringing", pr.parse(f"k_bush + ({RINGING})"), "", "", rules, ())
    values = {"b1": 178.648, "b2": 4214.08, "c": 22218.2, "k": 1349750.0}
    free = improve(pr.problem("vertical-comfort", band_only=True), layout, values, {})
    kept = improve(pr.problem("vertical-comfort"), layout, values, {})
    assert free.objective.value == pytest.approx(1.88281, rel=1e-5)
    assert kept.objective.value == pytest.approx(1.88343, rel=1e-5)
    assert kept.problem.band_only is False
    assert kept.feasible


def test_the_worst_of_several_keeps_the_worst_of_the_default():
    problem = pr.problem("vertical-comfort", position="worst")
    worst = max(problem.default_metrics[f"J1z_{at}_whole"].value for at in "LMT")
    assert {c.metric for c in problem.constraints} == {f"J1z_{at}_whole" for at in "LMT"}
    assert all(c.value == pytest.approx(worst, rel=2e-6) for c in problem.constraints)


def test_a_limit_of_ones_own_stands_in_place_of_the_default():
    (only,) = pr.problem("vertical-comfort", limits={"J1z_T_whole": 2.1}).constraints
    assert only.value == 2.1


def test_what_keeps_only_one_band_is_refused_in_a_sentence():
    near = {"c": 22218.2, "k": 1349750.0, "b1": 178.648, "b2": 4214.08}
    rules = {name: ElementRule(bounds=(0.99 * value, 1.01 * value)) for name, value in near.items()}
    layout = Layout("ringing", pr.parse(f"k_bush + ({RINGING})"), "", "", rules | {"k_bush": BUSH}, ())
    with pytest.raises(Infeasible, match=r"J1z_T_whole.*--band-only allows"):
        pr.optimise(pr.problem("vertical-comfort"), layout, starts=1)
    free = pr.optimise(pr.problem("vertical-comfort", band_only=True), layout, starts=1)
    assert any("worse than the default" in note for note in free.found["notes"])


def test_the_largest_over_speeds_over_all_frequencies():
    design = pr.evaluate(pr.problem("lateral-comfort"), "S3 c=2.1025e4 b=1.53e4")
    Y = independent.series(independent.element("c", "2.1025e4"), independent.element("b", "1.53e4"))
    figure = design.metrics["Macc_whole"]
    assert figure.at == "at 55 m/s"
    assert figure.value == pytest.approx(independent.plan_view(Y)["Macc_whole"], rel=1e-9)
    assert design.metrics["J1y_whole"].value == figure.value
