"""Usual ranges: what a search stays inside, and what is said of what lies outside."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from posreal.errors import BadInput, Infeasible
from posreal.network import parse
from posreal.network.usual import at_ends, outside
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.ranges import WIDEST, UsualRanges, ranges_from, read_ranges
from posreal.specification.layout import ElementRule, Layout, layout
from posreal.specification.named import problem, problems
from posreal.specification.usual import own_springs, within
from posreal.topology.search import search

VERTICAL = problem("vertical-comfort")


def test_every_place_of_every_vehicle_has_ranges_with_a_source():
    places = [place for one in problems() for place in one.vehicle.places.values()]
    assert all(place.usual is not None and place.usual.source for place in places)
    assert all(set(place.usual.by_kind) == set("kcb") for place in places)
    assert all(0 < low < high for place in places for low, high in place.usual.by_kind.values())
    widest = WIDEST.by_kind
    assert all(
        widest[kind][0] <= low and high <= widest[kind][1]
        for place in places
        for kind, (low, high) in place.usual.by_kind.items()
    )


def test_a_file_is_read_with_units_and_written_back(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('b = ["100 kg", "2 t"]\nstroke = "60 mm"\nsource = "a price list"\n')
    mine = read_ranges(path, VERTICAL.place.usual)
    assert mine.b == (100.0, 2000.0)
    assert mine.stroke == pytest.approx(0.06)
    assert mine.k == VERTICAL.place.usual.k
    assert ranges_from(tomllib.loads(mine.to_toml())) == mine
    assert problem("vertical-comfort", ranges=path).usual == mine
    assert problem("vertical-comfort", ranges={"b": (100, "2 t")}).usual.b == mine.b


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"m": [1, 2]}, "unknown key 'm'"),
        ({"k": "5 MN/m"}, "k must be a list of two"),
        ({"k": [1, 2, 3]}, "k must be a list of two"),
        ({"k": ["5 MN/m", "10 kN/m"]}, "k: the least, '5 MN/m', is not below"),
        ({"c": ["5 kg", "10 kN s/m"]}, "c: The unit 'kg' measures something else"),
        ({"b": [True, 3]}, "b: True is no value"),
        ({"b": [0, 3]}, "b: 0 is no value"),
        ({"b": [1, float("inf")]}, "b: inf is no value"),
        ({"stroke": [1]}, "stroke: .1. is no value"),
        ({"force": "3 kg"}, "force: The unit"),
        ({"source": 3}, "source is 3"),
    ],
)
def test_what_is_wrong_with_a_file_is_named(given, says):
    with pytest.raises(BadInput, match=says):
        ranges_from(given)


def test_what_lies_outside():
    usual = UsualRanges(k=(1e4, 5e6), c=(500.0, 2e5), b=(50.0, 5e3))
    network = parse("k1=5e6 + (c1=499 | b1=16.3e3) + k2=6e6")
    found = outside(network, usual)
    assert [(one.name, one.value) for one in found] == [("c1", 499.0), ("b1", 16.3e3), ("k2", 6e6)]
    assert str(found[1]) == "b1 = 16300 kg, above 5000 kg"
    assert [one.name for one in outside(network, usual, own={"bush": 6e6})] == ["c1", "b1"]
    assert outside(network, None) == []
    assert at_ends(network, usual) == ["k1 stands at the greatest that can usually be bought, 5 MN/m"]


def test_a_design_says_what_lies_outside():
    design = evaluate(VERTICAL, parse("b=25489 + (c=14.5e3 | k=74.8e3)"))
    assert [one.name for one in design.outside] == ["b"]
    assert design.to_dict()["outside_usual"][0] == {
        "name": "b", "value": 25489.0, "usual": [50.0, 5000.0], "unit": "kg"
    }  # fmt: skip
    assert "b = 25500 kg, above 5000 kg" in str(design)
    short = evaluate(problem("vertical-comfort", ranges={"stroke": "50 mm"}), parse("b=3000 + c=1.4e4"))
    assert [one.name for one in short.out_of_stroke] == ["deflection_overall_rear"]
    assert short.out_of_stroke[0].value == short.metrics["deflection_overall_rear"].value / 1e3 > 0.05


def test_a_layout_is_cut_but_for_what_is_the_vehicle_s():
    cut = within(layout("S6"), VERTICAL)
    free = cut.free_elements(VERTICAL)
    assert free["c1"] == (500.0, 2e5)
    assert free["b"] == (50.0, 5000.0)
    assert free["k"] == layout("S6").free_elements(VERTICAL)["k"]  # the bush
    assert own_springs(VERTICAL) == {"bush": VERTICAL.vehicle.bush}
    alone = Layout("mine", parse("k + (c | b)"), "", "", {"b": ElementRule(bounds=(1.0, 20.0))}, ())
    with pytest.raises(BadInput, match="bounds of b, 1 kg to 20 kg, leave nothing"):
        within(alone, VERTICAL)


def test_an_optimum_within_the_ranges_is_the_layout_s_own():
    """S4 at 91.7 kg is an optimum of its own bounds; a search started within the ranges alone ends at 2.058 %g."""
    design = optimise(VERTICAL, layout("S4"))
    assert design.objective.value == pytest.approx(2.03215, rel=1e-5)
    assert not any("bought" in note for note in design.found["notes"])


def test_an_optimum_outside_is_left_for_the_best_inside_and_named():
    posed = problem("lateral-comfort", band_only=True)
    free = optimise(posed, layout("S3"), starts=2, any_values=True)
    usual = optimise(posed, layout("S3"), starts=2)
    assert free.objective.value == pytest.approx(0.217219, abs=2e-6)
    assert usual.parameters["b"] == pytest.approx(5000.0)
    assert usual.objective.value > free.objective.value
    assert usual.feasible
    note = next(note for note in usual.found["notes"] if "bought" in note)
    assert "b stands at the greatest that can usually be bought, 5000 kg" in note
    assert f"--any-values lifts that: {free.objective}" in note
    assert usual.outside == ()
    # whatever else is inside: the grid of c at the end of b, damping kept, has nothing better
    for c in np.geomspace(1.5e4, 4e4, 26):
        one = evaluate(posed, parse(f"c={c} + b=5000"))
        assert not one.feasible or one.objective.value >= usual.objective.value * (1 - 1e-6)


def test_nothing_inside_that_keeps_the_constraints_says_what_any_values_reach():
    posed = problem("vertical-comfort", ranges={"b": (50, 51)}, limits={"J1z_T": 2.0})
    with pytest.raises(Infeasible, match=r"can usually be bought.*--any-values lifts that: 1.96127 %g with b = 4110"):
        optimise(posed, layout("S5"), starts=2)


def test_a_search_stays_inside():
    posed = problem("vertical-comfort", ranges={"b": ("50 kg", "2 t")})
    inside = search(posed, 2, starts=3)
    assert inside.bounds == posed.usual.by_kind
    best = inside.best
    assert best.network.values()["b"] == pytest.approx(2000.0)
    assert any("b stands at the greatest that can usually be bought, 2000 kg; --any" in n for n in best.found["notes"])
    assert best.objective.value == pytest.approx(optimise(posed, layout("S5"), starts=3).objective.value, rel=1e-6)
    free = search(posed, 2, starts=3, any_values=True)
    assert free.bounds == {}
    assert free.best.objective.value < best.objective.value
    assert [one.name for one in free.best.outside] == ["b"]
    given = search(posed, 2, starts=3, bounds={"b": (50.0, 3000.0)}).best  # what is given counts
    assert given.network.values()["b"] == pytest.approx(3000.0)
    assert not any("--any-values" in note for note in given.found["notes"])
