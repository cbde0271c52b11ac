"""Parts that a network hardly needs are left out, and what is left has the figures that are printed."""

import pytest

from posreal.network import nodal_admittance, parse
from posreal.specification.design import Design
from posreal.specification.named import problem
from posreal.study.prune import pruned
from posreal.study.strut import realised
from posreal.synthesis.synthesise import synthesise

DEMO = "{1-2: (k1=91.7 | b1=31.2) + c1=177, 1-3: b2=2817.87, 2-3: b3=25489, 2-0: k2=74828.7, 3-0: c2=14494}"


def built(chosen, text):
    network = parse(text)
    device = network.admittance()
    return Design("a network", chosen, device, chosen.metrics(chosen.port(device)), network=network)


def figure(design):
    """The objective from the network's graph alone."""
    metrics = design.problem.metrics(design.problem.port(nodal_admittance(design.network)))
    return metrics[design.problem.objective].value


def test_the_demo_network_of_order_two_needs_four_elements():
    """As found by hand: without k1, b1 and c1 it is 1.92143, less with the values improved; three reach 1.92263."""
    found = pruned(built(problem("vertical-comfort"), DEMO))
    assert len(found.network) == 4
    assert figure(found) == pytest.approx(found.objective.value, rel=1e-12)
    assert figure(found) <= 1.92143
    assert found.check()
    three = pruned(built(problem("vertical-comfort"), DEMO), 1e-3)
    assert len(three.network) == 3
    assert figure(three) == pytest.approx(1.92263, abs=5e-6)


def test_what_every_part_is_needed_for_stays():
    """A spring in series with a damper has its optimum inside: both ends cost more than that."""
    chosen = problem("quarter-car")
    assert pruned(built(chosen, "b=333.298 + c=3224.24")) is None


def test_parts_that_do_nothing_cost_nothing():
    chosen = problem("quarter-car", objective="J3")
    found = pruned(built(chosen, "(b=301.826 + k=319521.5 + c=3251.47) | k=1e-3 | (c=1e-4 + b=1)"))
    assert len(found.network) == 3
    assert figure(found) == pytest.approx(461.398, rel=2e-6)


def test_constraints_are_kept():
    chosen = problem("quarter-car", limits={"J3": 480.0})
    full = built(chosen, "(b=300 | c=1) + c=3300 + k=3e5")
    assert full.feasible
    found = pruned(full)
    assert len(found.network) < 4
    assert found.feasible
    assert figure(found) <= full.objective.value * (1 + 5e-4)


def test_free_vehicle_parameters_move_along():
    chosen = problem("lateral-gauging-primary")
    full = built(chosen.with_vehicle({"Kpy": 9e6, "Cpy": 5e4}), "(c=69660 | k=1284825) + c=20689 + k=1e9")
    found = pruned(full)
    assert found is None or (found.feasible and figure(found) == pytest.approx(found.objective.value, rel=1e-9))


def test_the_design_shown_is_the_networks():
    design = synthesise(problem("vertical-comfort"), 2, starts=4)
    shown, realisation = realised(design)
    assert shown.device == realisation.target == nodal_admittance(realisation.network)
    assert shown.check()
    assert (realisation.method, len(realisation.network)) == ("pruned", 4)
    assert "3 of the 7 elements" in realisation.notes[0]
    assert "0.02 % better; the device of order 2 has 1.92163" in realisation.notes[0]
    assert shown.found["notes"][-1] == realisation.notes[0]
    kept, whole = realised(design, prune=0.0)
    assert len(whole.network) == 7
    assert kept.device == design.device
    assert kept.objective.value == pytest.approx(design.objective.value, rel=1e-9)


def test_many_parts_that_do_nothing_are_shed_first():
    full = built(problem("vertical-comfort"), f"{DEMO} | (k=1e-2 + c=1e-2) | (b=1e-3 + (c=1e-3 | k=1e-4))")
    found = pruned(full)
    assert len(found.network) == 4
    assert figure(found) <= 1.92143
