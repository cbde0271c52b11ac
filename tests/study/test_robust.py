"""Constraints that hold at every corner of the tolerances: against vehicles built there one by one, and by draws."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest

import posreal as pr
from posreal.cli import app
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle
from posreal.network import parse
from posreal.optimisation.element_search import ElementSearch
from posreal.specification.layout import ElementRule, Layout
from posreal.specification.mounted import STATIC, mounted
from posreal.study.robust import as_drawn, beside, made_robust

PRIMARY = pr.problem("lateral-comfort-primary")
LIMITED = pr.problem("vertical-comfort", limits={"J1z_L": 1.68})


@pytest.fixture(scope="module")
def s1():
    return pr.optimise(PRIMARY.robust(), pr.layout("S1"), starts=1)


def test_every_vehicle_at_a_corner_keeps_the_damping_ratio(s1):
    limit = PRIMARY.constraints[0].value
    worst = np.inf
    values = {name: s1.parameters[name] for name in ("k", "c", "Kpy", "Cpy")}
    for factors in itertools.product((0.8, 1.2), repeat=4):
        k, c, Kpy, Cpy = (value * factor for value, factor in zip(values.values(), factors, strict=True))
        built = pr.problem("lateral-comfort-primary", vehicle={"Ksy": k, "Kpy": Kpy, "Cpy": Cpy})
        closed = ClosedVehicle(built.vehicle, {"secondary": built.port(pr.Rational.damper(c))})
        worst = min(worst, closed.value(built.vehicle.metrics["Ldmp"]).value)
    assert worst >= limit * (1 - 1e-6)
    assert worst == pytest.approx(limit, rel=1e-5)  # what it costs is no more than it must
    drawn = pr.optimise(PRIMARY, pr.layout("S1"), starts=1)
    assert drawn.objective.value < s1.objective.value < 1.01 * drawn.objective.value


def test_no_neighbour_that_keeps_the_corners_is_better(s1):
    """Local optimality: of small steps either way, those that lower the ride break a corner."""
    search = ElementSearch(PRIMARY.robust(), pr.layout("S1"))
    theta, vehicle = search.point(s1.parameters, s1.parameters)
    rng = np.random.default_rng(0)
    better = 0
    for step in 1e-3 * rng.normal(size=(40, 3)):
        moved = {"Kpy": vehicle["Kpy"] * np.exp(step[1]), "Cpy": vehicle["Cpy"] * np.exp(step[2])}
        there = (theta + step[0], moved)
        if search.value(there) < search.value((theta, vehicle)) * (1 - 1e-6):
            better += 1
            assert not search.holds_at_corners(there)
    assert better > 5


def test_slopes_at_a_corner_are_differences():
    search = ElementSearch(PRIMARY.robust(0.15, {"Kpy": 0.1, "Kpx": 0.05}), pr.layout("S3"))
    corners = search.corners
    assert corners is not None
    c = PRIMARY.constraints[0]
    signs = (1, -1, 1, -1, 1)
    requirement = corners.requirement(c, signs, (20.0, 55.0), 1.0)
    theta, vehicle = np.log([16e3, 1e4]), {"Kpy": 5e6, "Cpy": 8e3}
    found = requirement.margins(search.elements, theta, vehicle)
    for i in range(2):
        low, high = (
            requirement.margins(search.elements, theta + sign * 1e-6 * np.eye(2)[i], vehicle).values for sign in (-1, 1)
        )
        assert found.by_theta[i] == pytest.approx((high - low) / 2e-6, rel=1e-4, abs=1e-5)
    for name, value in vehicle.items():
        low, high = (
            requirement.margins(search.elements, theta, vehicle | {name: value * (1 + sign * 1e-6)}).values
            for sign in (-1, 1)
        )
        assert found.by[name] * value == pytest.approx((high - low) / 2e-6, rel=1e-4, abs=1e-5)
    # what it is of: the vehicle with each value at its end
    factors = corners.factors(signs)
    built = pr.problem(
        "lateral-comfort-primary",
        vehicle={"Kpy": 5e6 * factors["Kpy"], "Cpy": 8e3, "Kpx": PRIMARY.vehicle.Kpx * factors["Kpx"]},
    )
    values = {n: v * factors[n] for n, v in {"k": 2.45e5, "c": 16e3, "b": 1e4}.items()}
    own = pr.evaluate(built, "S3 " + " ".join(f"{n}={v!r}" for n, v in values.items()))
    assert corners.value(c, signs, theta, vehicle) == pytest.approx(own.metrics["Ldmp"].value, rel=1e-9)


def test_a_limit_on_the_ride_holds_at_the_corners_of_a_layout_with_a_bush():
    design = pr.optimise(LIMITED.robust(0.1), pr.layout("S5"), starts=2)
    values = {name: design.parameters[name] for name in ("k", "c", "b")}
    rides = []
    for factors in itertools.product((0.9, 1.1), repeat=3):
        k, c, b = (value * factor for value, factor in zip(values.values(), factors, strict=True))
        built = pr.problem("vertical-comfort", vehicle={"bush": k})
        rides.append(pr.evaluate(built, f"c={c!r} + b={b!r}").metrics["J1z_L"].value)
    assert max(rides) == pytest.approx(1.68, rel=1e-5)
    assert max(rides) <= 1.68 * (1 + 1e-6)


def test_with_many_corners_the_worst_is_found_by_an_ascent(monkeypatch):
    search = ElementSearch(PRIMARY.robust(), pr.layout("S3"))
    assert search.corners is not None
    c = PRIMARY.constraints[0]
    at = np.log([16e3, 1e4]), {"Kpy": 5e6, "Cpy": 8e3}
    every = search.corners.worst(c, *at)
    monkeypatch.setattr("posreal.optimisation.corners.ALL", 4)
    assert search.corners.worst(c, *at) == every


def test_a_network_in_its_place_is_made_robust_and_compared():
    built = pr.evaluate(LIMITED, "c=17964.926+b=4114.8145")
    robust = made_robust(pr.evaluate(LIMITED.robust(0.1), "c=17964.926+b=4114.8145"))
    found = beside(as_drawn(robust), robust, draws=40)
    assert found.before.yields["J1z_L"].fraction < 1
    assert found.after.yields["J1z_L"].fraction == 1
    assert found.after.spreads["J1z_L"].worst <= 1.68 * (1 + 1e-6)
    assert robust.objective.value > built.objective.value
    assert "kept by" in str(found)
    json.dumps(found.to_dict(), allow_nan=False)
    strut = ElementSearch(LIMITED.robust(0.1, 0.05), pr.layout("S5")).corners
    assert strut is not None
    assert strut.of_elements == {"k": 0.1, "c": 0.1, "b": 0.1}


def test_the_vehicle_s_spring_in_a_topology_has_the_vehicle_s_tolerance():
    problem = pr.problem("lateral-comfort").robust(0.1, 0.05)
    strut = mounted(problem, parse("c"))
    layout = Layout("", strut, "", "", {STATIC: ElementRule(role="static spring")}, ())
    corners = ElementSearch(problem, layout).corners
    assert corners is not None
    assert sorted(corners.of_elements.values()) == [0.05, 0.1]
    assert corners.of_elements[STATIC] == 0.05
    assert corners.of_vehicle == {"Kpy": 0.05, "Cpy": 0.05}


def test_without_constraints_there_is_nothing_to_keep():
    with pytest.raises(BadInput, match="no constraint that tolerances could break"):
        pr.optimise(pr.problem("vertical-comfort").robust(), pr.layout("S5"))
    with pytest.raises(BadInput, match="no value has a tolerance"):
        pr.optimise(PRIMARY.robust(0.0, 0.0), pr.layout("S1"))


def test_command(capsys, monkeypatch):
    monkeypatch.setitem(beside.__kwdefaults__, "draws", 30)
    words = ["optimise", "vertical-comfort", "S5", "--limit", "J1z_L=1.68", "--robust", "--tolerance", "10%"]
    app([*words, "--starts", "1", "--json"], standalone_mode=False)
    (design,) = json.loads(capsys.readouterr().out)["designs"]
    assert design["robust"]["after"]["yield"] == {"J1z_L": 1.0}
    assert design["robust"]["before"]["yield"]["J1z_L"] < 1
    with pytest.raises(BadInput, match="go with --robust"):
        app(["optimise", "vertical-comfort", "S5", "--tolerance", "10%"], standalone_mode=False)


@pytest.mark.long
def test_search_and_synthesis_within_tolerances(capsys):
    limit = ["--limit", "J1z_L=1.68", "--robust", "--tolerance", "10%"]
    app(["search", "vertical-comfort", "--elements", "2", *limit, "--starts", "2", "--json"], standalone_mode=False)
    found = json.loads(capsys.readouterr().out)
    assert found["robust"]["after"]["yield"] == {"J1z_L": 1.0}
    app(["synthesise", "vertical-comfort", "--order", "1", *limit, "--json"], standalone_mode=False)
    made = json.loads(capsys.readouterr().out)
    assert made["robust"]["after"]["yield"] == {"J1z_L": 1.0}
    best = found["front"][-1]["objective"]
    assert made["design"]["objective"]["value"] == pytest.approx(best, rel=1e-4)  # order 1 is c + b there
