"""A design below a proven bound stops the run, whatever part of the program found it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from posreal.design import evaluate, guard, layout, optimise, problem
from posreal.design.bound import BelowBound
from posreal.metric import Measured


@pytest.mark.parametrize(
    ("name", "device"),
    [("quarter-car", "c=2600"), ("vertical-comfort", "c=17965 + b=4115"), ("lateral-comfort", "c=2e4")],
)
def test_honest_designs_pass(name, device):
    design = evaluate(problem(name), device)
    assert guard.guarded(design) is design
    floor = guard._floor(design.problem.vehicle, design.problem.objective)
    assert 0.5 * design.objective.value < floor.value < design.objective.value


def test_every_search_is_guarded(monkeypatch):
    """With the floor of a much better vehicle, nothing leaves the program."""
    real = guard._floor

    def raised(vehicle, metric):
        floor = real(vehicle, metric)
        return replace(floor, value=10 * floor.value, best=None)

    monkeypatch.setattr(guard, "_floor", raised)
    posed = problem("quarter-car")
    with pytest.raises(BelowBound):
        evaluate(posed, "c=2600")
    with pytest.raises(BelowBound):
        evaluate(posed, "S1 c=2600")
    with pytest.raises(BelowBound):
        optimise(posed, layout("S3"), starts=1)
    from posreal.design import synthesise
    from posreal.design.search import search

    with pytest.raises(BelowBound):
        synthesise(posed, 1, starts=1)
    with pytest.raises(BelowBound):
        search(posed, 1)


def test_peaks_in_time_are_guarded_by_their_comfort():
    design = evaluate(problem("lateral-gauging"), "c=2e4")
    assert design.problem.objective == "max_yv"
    assert guard.guarded(design) is design
    assert isinstance(design.metrics["Macc"], Measured)
