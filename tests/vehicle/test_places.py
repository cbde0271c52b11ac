"""A device in another place of the plan view: the primary suspension, beside its spring, in place of its damper."""

from __future__ import annotations

import numpy as np
import pytest

import posreal as pr
from posreal.admittance import Rational, state_space
from posreal.errors import BadInput
from posreal.plant.figures import ClosedPlant
from posreal.plant.plant import absorbed
from posreal.vehicle import PlanView


def test_the_default_is_the_default_wherever_it_is_seen_from():
    secondary = pr.evaluate(pr.problem("lateral-comfort"), "default").metrics
    primary = pr.evaluate(pr.problem("lateral-comfort", at="primary"), "default").metrics
    for name in ("Macc", "J1y", "Ldmp", "max_yv"):
        assert primary[name].value == pytest.approx(secondary[name].value, rel=1e-8)
    assert primary["static_stiffness"].value == PlanView().Kpy


@pytest.mark.parametrize("text", ["c=20000", "c=20000 | b=50", "(c=3e4 + k=1e6) | c=5000"])
def test_a_primary_device_against_the_vehicle_with_both_places_open(text):
    vehicle = PlanView()
    device = pr.parse(text).admittance()
    design = pr.evaluate(pr.problem("lateral-comfort", at="primary"), text)
    inside = {
        "secondary": Rational.spring(vehicle.Ksy) | Rational.damper(vehicle.Csy),
        "primary": Rational.spring(vehicle.Kpy) | device,
    }
    both = ClosedPlant(vehicle.plant("track", opened=True), inside)
    poles = np.sort_complex(both.loop.poles())
    alone = ClosedPlant(design.problem.plant, {"secondary": design.port})
    assert np.sort_complex(alone.loop.poles()) == pytest.approx(poles, rel=1e-6, abs=1e-6)
    assert alone.band_rms("body_acceleration").value == pytest.approx(
        both.band_rms("body_acceleration").value, rel=1e-8
    )


def test_a_damper_there_is_the_vehicle_with_that_damper():
    there = pr.evaluate(pr.problem("lateral-comfort", at="primary"), "c=20000").metrics
    tuned = pr.evaluate(pr.problem("lateral-comfort", vehicle={"Cpy": 20000}), "default").metrics
    for name in ("Macc", "J1y", "Ldmp", "max_yv"):
        assert there[name].value == pytest.approx(tuned[name].value, rel=1e-8)


def test_states_of_what_is_absorbed_belong_to_the_plant():
    vehicle = PlanView()
    maxwell = pr.parse("(c=2e4 + k=3e6) | k=2.45e5").admittance()
    primary = Rational.spring(vehicle.Kpy) | Rational.damper(vehicle.Cpy)
    opened = vehicle.plant("track", opened=True)
    both = ClosedPlant(opened, {"secondary": maxwell, "primary": primary})
    one = ClosedPlant(absorbed(opened, {"secondary": state_space(maxwell)}, group="here"), {"here": primary})
    assert one.band_rms("body_acceleration").value == pytest.approx(both.band_rms("body_acceleration").value, rel=1e-9)
    with pytest.raises(BadInput, match="inertance"):
        absorbed(opened, {"secondary": state_space(pr.parse("b=10").admittance())}, group="here")


def test_a_search_in_the_primary_place():
    posed = pr.problem("lateral-comfort", at="primary")
    best = pr.optimise(posed, pr.layout("S1"), starts=3)
    best.check()
    assert best.objective.value <= posed.default_metrics["Macc"].value * (1 + 1e-9)


def test_what_is_no_place():
    with pytest.raises(BadInput, match="no place 'bogie'; it has secondary or primary"):
        pr.problem("lateral-comfort", at="bogie")
    with pytest.raises(BadInput, match="it has secondary"):
        pr.problem("vertical-comfort", at="primary")
    with pytest.raises(BadInput, match="leaves Kpy or Cpy free"):
        pr.problem("lateral-comfort-primary", at="primary")
    assert pr.problem("lateral-comfort", at="secondary") == pr.problem("lateral-comfort")
