"""Listed values in place of designed ones."""

from __future__ import annotations

import itertools
import json
from fractions import Fraction

import pytest

import posreal as pr
from posreal.errors import BadInput, Infeasible
from posreal.network.preferred_numbers import SERIES, Steps, read_steps

VERTICAL = pr.problem("vertical-comfort")
THREE = "b=2741 + (c=14196 | k=83748)"


def test_the_series_are_those_of_the_standards():
    assert [float(number) for number in SERIES["R5"]] == [1, 1.6, 2.5, 4, 6.3]
    assert [float(number) for number in SERIES["R10"]] == [1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8]
    assert [float(number) for number in SERIES["E6"]] == [1, 1.5, 2.2, 3.3, 4.7, 6.8]
    for name, numbers in SERIES.items():
        assert len(numbers) == int(name[1:])
        for i, number in enumerate(numbers):  # rounded powers: ISO 3 to 1.3 %, IEC 60063 to half a tenth and a bit
            assert float(number) == pytest.approx(10 ** (i / len(numbers)), rel=0.013 if name[0] == "R" else 0.06)


@pytest.mark.parametrize("value", [0.0123, 1.0, 6.3, 9.4, 83748.0, 9.99e5])
def test_what_lies_around_a_value(value):
    steps = read_steps("R10")["k"]
    every = sorted(number * Fraction(10) ** n for n in range(-8, 10) for number in SERIES["R10"])
    near = steps.around(value, 2)
    assert near == sorted(near)
    assert near == [one for one in every if one <= value][-2:] + [one for one in every if one > value][:2]


def test_lists_and_steps(tmp_path):
    path = tmp_path / "maker.toml"
    path.write_text('k = "R20"\nc = ["15 kN s/m", "10 kN s/m", 2e4]\nb = { step = "50 kg" }\n')
    listed = read_steps(path)
    assert listed["c"].values == (10_000, 15_000, 20_000)
    assert listed["c"].around(12e3, 3) == [10_000, 15_000, 20_000]
    assert listed["c"].around(1.0, 1) == [10_000]
    assert listed["b"] == Steps(step=Fraction(50))
    assert listed["b"].around(2741, 1) == [2700, 2750]
    assert listed["b"].around(3.0, 1) == [50]
    assert listed["b"].around(120, 9)[0] == 50


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("R7", "unknown series 'R7'"),
        ("/nowhere/x.toml", "cannot read"),
        ({}, "no values are listed"),
        ({"m": "R5"}, "unknown key 'm'"),
        ({"k": []}, "k must be a series such as"),
        ({"k": [3, -1]}, "k: -1 is no value; give one above 0"),
        ({"k": ["3 kg"]}, "measures something else"),
        ({"b": {"step": "50 kg", "from": 3}}, "b must have a step and nothing else"),
        ({"b": {"step": [1]}}, "is no value"),
    ],
)
def test_what_is_wrong_with_a_list_is_named(given, says):
    with pytest.raises(BadInput, match=says):
        read_steps(given)


def test_the_best_of_every_combination_is_taken():
    car = pr.problem("quarter-car")
    found = pr.preferred(car, "b=192 + (c=2396 | k=23664)", steps="E6")
    numbers = {"b": (100, 150, 220, 330), "c": (1500, 2200, 3300, 4700), "k": (15e3, 22e3, 33e3, 47e3)}
    figures = {
        values: pr.evaluate(car, "b={} + (c={} | k={})".format(*values)).objective.value
        for values in itertools.product(*numbers.values())
    }
    best = min(figures, key=figures.get)
    assert tuple(found.design.parameters[name] for name in "bck") == best
    assert found.design.objective.value == pytest.approx(figures[best], rel=1e-9)
    assert found.cost_percent == pytest.approx(100 * (figures[best] / found.given.objective.value - 1))
    found.design.check()


def test_a_layout_keeps_what_is_the_vehicle_s_and_what_it_fixes():
    found = pr.preferred(VERTICAL, "S7 b=165 c=13932 k=1.5e6", steps="E12")
    assert set(found.changed) == {"b", "c", "k"}
    assert (found.design.parameters["ke"], found.design.parameters["ce"]) == (5e6, 8e3)
    assert "| ce=8000" in str(found.design.network)


def test_constraints_are_kept_as_they_are_measured():
    posed = pr.problem("vertical-comfort", limits={"deflection_rms_rear": 6.3})
    best = pr.optimise(posed, "S5", starts=2)
    found = pr.preferred(best, steps="E12")
    assert found.design.feasible
    assert found.design.metrics["deflection_rms_rear"].value <= 6.3
    assert found.design.objective.value >= best.objective.value * (1 - 1e-9)
    with pytest.raises(
        Infeasible,
        match=r"no listed values near those of the device were found that keep J1z_T_whole .*; deflection_rms_rear",
    ):
        pr.preferred(best, steps={"c": ["1 kN s/m"], "b": ["100 kg"]})


def test_real_elements_are_chosen_as_real_ones():
    posed = pr.problem("vertical-comfort", elements="real")
    found = pr.preferred(posed, THREE, steps="R10")
    same = pr.evaluate(posed, found.design.bought)
    assert found.design.objective.value == same.objective.value
    assert found.design.ideal.metrics["J1z_T"].value == same.ideal.metrics["J1z_T"].value
    assert "k_end_c" in found.design.network.names


def test_a_network_of_many_elements_starts_at_the_nearest_and_goes_on_by_steps():
    ladder = "c1=400"
    for i in range(2, 8):
        ladder = f"c{i}=400 | (k{i}=1.1e5 + ({ladder}))"
    posed = pr.problem("quarter-car")
    found = pr.preferred(posed, ladder, steps="E6")
    assert len(found.changed) == 13
    steps = read_steps("E6")
    for name, (before, value) in found.changed.items():
        allowed = steps[name[0]].around(before, 4)
        here = [float(one) for one in allowed].index(value)
        for other in allowed[max(0, here - 1) : here + 2]:
            moved = found.design.bought.with_values({name: other})
            assert pr.evaluate(posed, moved).objective.value >= found.design.objective.value * (1 - 1e-6)


def test_a_device_without_elements():
    with pytest.raises(BadInput, match="has no elements"):
        pr.preferred(VERTICAL, None)
    with pytest.raises(BadInput, match="of the kinds of elements of the device none is listed"):
        pr.preferred(VERTICAL, "c=2e4", steps={"b": "R5"})


def test_command(capsys):
    from posreal.cli import app

    app(["preferred", "quarter-car", "b=330 + c=3224", "--series", "R10", "--json"], standalone_mode=False)
    document = json.loads(capsys.readouterr().out)
    assert document["steps"] == "R10"
    assert document["changed"]["c"] == [3224.0, 3150.0]
    assert document["design"]["parameters"]["b"] in (315.0, 400.0)
    app(["preferred", "quarter-car", "b=330 + c=3224", "--series", "R10"], standalone_mode=False)
    assert "3.15 kN·s/m" in capsys.readouterr().out
