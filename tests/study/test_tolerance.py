"""Tolerances: spreads and yields against a Monte Carlo of its own, corners, shares, seeds and workers."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest

import posreal as pr
from posreal.cli import app
from posreal.errors import BadInput
from posreal.network import parse
from posreal.plant.quadrature import BAND, lateral_sum
from posreal.specification.tolerances import read_tolerances, tolerances
from posreal.specification.variation import Variation
from posreal.specification.variation import variation as vary
from posreal.study.tolerance import as_network, tolerance
from posreal.study.tolerance_result import Share
from posreal.vehicle import PlanView, SideView
from tests.vehicle.naive import lateral_sum as naive_lateral
from tests.vehicle.naive import vertical

CB = "c=17964.926+b=4114.8145"
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def ride_at_the_trailing_bogie(c: float, b: float, bush: float) -> float:
    """J1z(T) in %g of a damper and an inerter in series behind a bush, from the equations solved frequency by frequency
    and a Gauss rule on even panels."""
    vehicle = SideView()
    edges = np.linspace(0.0, BAND, 81)
    total = 0.0
    for low, high in itertools.pairwise(edges):
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            omega = (low + high) / 2 + (high - low) / 2 * node
            z = vertical(vehicle, lambda s: 1 / (s / bush + 1 / c + 1 / (s * b)), omega)["acceleration_T"]
            total += (high - low) / 2 * weight * abs(z) ** 2
    return 100 / vehicle.g * math.sqrt(math.pi * vehicle.Av * vehicle.V * total)


def variation(design, *given, **named) -> Variation:
    return vary(as_network(design), tolerances(*given, **named))


@pytest.fixture(scope="module")
def found():
    return tolerance(pr.problem("vertical-comfort"), CB, draws=40, seed=3)


def test_an_independent_monte_carlo_has_the_same_percentiles_and_worst(found):
    own = np.random.default_rng(3).uniform(0.8, 1.2, (40, 3)) * [17964.926, 4114.8145, 5e6]
    corners = np.array([[c, b, k] for c in (0.8, 1.2) for b in (0.8, 1.2) for k in (0.8, 1.2)])
    drawn = np.sort([ride_at_the_trailing_bogie(*row) for row in own])
    spread = found.spreads["J1z_T"]
    # the nearest-rank percentile is a draw's figure: the 2nd, 20th and 38th of forty
    assert [spread.p5, spread.p50, spread.p95] == pytest.approx(drawn[[1, 19, 37]].tolist(), rel=2e-5)
    worst = max(*drawn, *(ride_at_the_trailing_bogie(*(row * [17964.926, 4114.8145, 5e6])) for row in corners))
    assert spread.worst == pytest.approx(worst, rel=2e-5)
    assert found.better is not None
    assert found.better.fraction == 1.0


def test_the_worst_is_where_it_is_said_to_be(found):
    at = found.spreads["J1z_T"].worst_at
    vehicle = {"bush": at["bush"]}
    again = pr.evaluate(pr.problem("vertical-comfort", vehicle=vehicle), f"c={at['c']:.17g}+b={at['b']:.17g}")
    assert again.metrics["J1z_T"].value == pytest.approx(found.spreads["J1z_T"].worst, rel=1e-12)
    assert set(found.spreads) == set(found.design.metrics)
    assert all(found.spreads[name].nominal == metric.value for name, metric in found.design.metrics.items())


def test_every_printed_figure_is_a_draw_s_own_confirmed_by_two_methods(found):
    own = np.random.default_rng(3).uniform(-1, 1, (40, 3))
    varied = variation(found.design)
    values = np.array([varied.confirmed(row, ["J1z_T", "deflection_rear"]) for row in own])
    for j, name in enumerate(("J1z_T", "deflection_rear")):
        assert found.spreads[name].p95 in values[:, j]
    assert found.apart < 5e-7


def test_shares_add_up_and_one_value_alone_has_all_of_the_variance(found):
    shares = found.shares["J1z_T"]
    assert set(shares) == {"c", "b", "bush"}
    assert 0.8 < sum(shares.values()) <= 1 + 1e-12
    alone = tolerance(
        pr.problem("vertical-comfort"), CB, tolerance={"k": 0, "c": 0, "b": 0}, vehicle={"mv": 0.1}, draws=30
    )
    assert alone.shares["J1z_M"]["mv"] == pytest.approx(1, abs=1e-3)
    slope = (_mass(1.001) - _mass(0.999)) / 0.002 * 0.1
    assert alone.effects["J1z_M"]["mv"] == pytest.approx(slope, rel=0.02)


def _mass(factor: float) -> float:
    heavier = pr.problem("vertical-comfort", vehicle={"mv": 38000.0 * factor})
    return pr.evaluate(heavier, CB).metrics["J1z_M"].value


def test_the_same_seed_gives_the_same_answer_with_any_number_of_workers(found):
    two = tolerance(found.design, draws=40, seed=3, jobs=2)
    assert two.to_dict() == found.to_dict()
    assert tolerance(found.design, draws=40, seed=4).spreads["J1z_T"].p50 != found.spreads["J1z_T"].p50


def test_yield_of_the_damping_limit_against_vehicles_evaluated_one_by_one():
    problem = pr.problem("lateral-comfort")
    found = tolerance(problem, "default", draws=10, seed=1)
    u = np.random.default_rng(1).uniform(0.8, 1.2, (10, 4))  # Csy, Ksy, Kpy, Cpy
    limit = problem.constraints[0].value
    kept, rides = 0, []
    for row in u * [2e4, 2.45e5, 4.71e6, 1.2e4]:
        csy, ksy, kpy, cpy = (float(f"{value:.6g}") for value in row)
        built = pr.problem("lateral-comfort", vehicle={"Ksy": ksy, "Kpy": kpy, "Cpy": cpy})
        own = pr.evaluate(built, f"c={csy!r}").metrics
        kept += own["Ldmp"].value >= limit
        rides.append(own["Macc"].value)
    assert found.yields["Ldmp"] == Share(kept, 10)
    assert found.spreads["Macc"].p95 == pytest.approx(np.sort(rides)[9], rel=1e-9)
    assert found.spreads["Macc"].p50 == pytest.approx(np.sort(rides)[4], rel=1e-9)
    at = found.spreads["Macc"].worst_at
    vehicle = PlanView(Ksy=at["Ksy"], Kpy=at["Kpy"], Cpy=at["Cpy"])
    rule = lateral_sum()
    plain = math.sqrt(naive_lateral(vehicle, lambda s: at["Ksy"] / s + at["c"], rule.omega[19::40], 0.4))
    assert found.spreads["Macc"].worst == pytest.approx(plain, rel=5e-3)  # every fortieth term of the paper's sum


def test_a_vehicle_that_is_not_stable_keeps_nothing():
    found = tolerance(pr.problem("lateral-comfort"), "default", vehicle={"conicity": 0.9}, draws=12)
    assert 0 < found.stable.count < 12
    assert found.spreads["Macc"].worst is None
    assert found.spreads["Ldmp"].worst is None
    assert found.yields["Ldmp"].count <= found.stable.count
    assert "unstable" in str(found)
    json.dumps(found.to_dict(), allow_nan=False)


def test_the_binomial_interval():
    """[ClopperPearson1934]: of 10 trials 0 successes leave up to 1 − 0.025^(1/10); 5 of 10: 0.1871 … 0.8129."""
    assert Share(0, 10).interval == (0.0, pytest.approx(1 - 0.025**0.1))
    assert Share(10, 10).interval == (pytest.approx(0.025**0.1), 1.0)
    assert Share(5, 10).interval == (pytest.approx(0.1871, abs=5e-5), pytest.approx(0.8129, abs=5e-5))


@pytest.mark.parametrize(
    ("network", "few"),
    [
        ("b1=200 | (b2=4000+k1=1.3e6+c1=2e4)", 16),
        pytest.param("b1=200 | (b2=4000+k1=1.3e6+c1=2e4) | (c2=2e3+k2=1e5+b3=500)", 128, marks=pytest.mark.long),
    ],
)
def test_corners_of_many_values_are_climbed_to(monkeypatch, network, few):
    """From corner to corner to the worst of all, here found by looking at each."""
    monkeypatch.setattr("posreal.study.tolerance._ALL_CORNERS", few)
    found = tolerance(pr.problem("vertical-comfort"), network, draws=30)
    assert found.of_corners == 2 ** len(found.variation.parts)
    assert found.corners < found.of_corners
    every = np.array(list(itertools.product((-1.0, 1.0), repeat=len(found.variation.parts))))
    values = found.variation.measured(every, ["J1z_T"])[:, 0]
    assert found.spreads["J1z_T"].worst == pytest.approx(values.max(), rel=1e-9)


def test_tolerances_as_text():
    assert read_tolerances("20%") == (0.2, {})
    assert read_tolerances("0.1, k=5 %,c1=30%") == (0.1, {"k": pytest.approx(0.05), "c1": pytest.approx(0.3)})
    design = pr.evaluate(pr.problem("vertical-comfort"), "k1=1e5+(c1=2e4|b1=1e3)")
    parts = {part.name: part.tolerance for part in variation(design, "10%,k=5%,b1=0", "Crz=15%").parts}
    assert parts == {"k1": pytest.approx(0.05), "c1": pytest.approx(0.1), "Crz": pytest.approx(0.15)}
    for bad in ("20", "120%", "-5%", "k=x", "k=", ""):
        with pytest.raises(BadInput, match="tolerance"):
            read_tolerances(bad)
    with pytest.raises(BadInput, match="no element 'c7'"):
        variation(design, "c7=5%")
    with pytest.raises(BadInput, match="did you mean Crz"):
        variation(design, vehicle="Cr=5%")
    with pytest.raises(BadInput, match="nothing varies"):
        tolerance(pr.problem("vertical-comfort"), "default")
    with pytest.raises(BadInput, match="give from 1 to"):
        tolerance(design, draws=0)


def test_a_layout_brings_its_own_spring_and_an_admittance_is_realised_first():
    lateral = pr.problem("lateral-comfort-primary")
    s2 = variation(pr.evaluate(lateral, "S2 c=1.51e4 b=256 Kpy=6.68e6 Cpy=5.4e3"))
    assert {part.name for part in s2.parts} == {"k", "c", "b", "Kpy", "Cpy"}
    with pytest.raises(BadInput, match="Ksy is the static spring of this strut"):
        variation(s2.design, vehicle="Ksy=5%")
    device = parse("k=2e5 | c=1e4").admittance()
    realised = variation(pr.evaluate(pr.problem("quarter-car"), device))
    assert {part.name[0]: part.nominal for part in realised.parts} == {"k": 60e3, "c": 1e4} or len(realised.parts) == 3


def test_operating_points_vary_too():
    problem = pr.problem("vertical-comfort", worst_case=[{"V": 40.0}], limits={"deflection_rms_rear": 7.0})
    found = tolerance(problem, CB, draws=10)
    assert "deflection_rms_rear at V=40" in found.yields
    assert found.spreads["worst-case J1z_T"].worst == pytest.approx(found.spreads["J1z_T"].worst)


@pytest.mark.long
@pytest.mark.parametrize(
    ("network", "nominal", "corner", "p95"),
    [
        ("c=12635.89", 2.0617, 2.0668, 2.0662),
        (CB, 1.9613, 1.9743, 1.9697),
        ("b=2740.801438+(c=14195.96742|k=83748.1782)", 1.9226, 1.9550, 1.9402),
        ("b1=178.6480665|(b2=4214.084037+c=22218.24946+k=1349748.529)", 1.8828, 1.9181, 1.8980),
    ],
)
def test_vertical_devices_within_twenty_per_cent(network, nominal, corner, p95):
    """Figures of an independent computation: all corners of the element values, and 95 % of some even draws.

    For four elements that computation gave 1.9007, of few draws; 1.8980 is that of 20,000 by another route, element
    values straight to the ride on a Gauss rule.
    """
    found = tolerance(pr.problem("vertical-comfort"), network, vehicle=0.0, draws=1000)
    spread = found.spreads["J1z_T"]
    assert spread.nominal == pytest.approx(nominal, abs=1e-4)
    assert spread.worst == pytest.approx(corner, abs=1e-4)
    assert spread.p95 == pytest.approx(p95, abs=2.5e-3)  # of how many draws is not known


def test_command(capsys):
    app(["tolerance", "quarter-car", "c=2000", "--draws", "20", "--json"], standalone_mode=False)
    document = json.loads(capsys.readouterr().out)
    assert set(document["metrics"]["J1"]) >= {"nominal", "p5", "p50", "p95", "worst", "unit"}
    assert document["yield"] == {}
    app(["tolerance", "quarter-car", "c=2000", "--draws", "20"], standalone_mode=False)
    printed = capsys.readouterr().out
    assert "20 draws (seed 0)" in printed
    assert f"{document['metrics']['J1']['p95']:#.5g}" in printed
