"""Every example runs and returns the numbers it claims."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from examples import (
    a_network_from_a_formula,
    best_damper_behind_a_bush,
    building_in_wind_and_earthquake,
    measured_track,
    own_vehicle,
)

TESTED = {
    "a_network_from_a_formula",
    "best_damper_behind_a_bush",
    "building_in_wind_and_earthquake",
    "measured_track",
    "own_vehicle",
}


def test_all_are_tested():
    folder = Path(__file__).parents[1] / "examples"
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == TESTED


def test_a_network_from_a_formula():
    found = a_network_from_a_formula.main()
    assert found["elements"] <= 8
    assert found["residual"] < 1e-12
    assert found["touches"] == pytest.approx(math.sqrt(2), rel=1e-12)
    assert found["fails"] == pytest.approx(math.sqrt(2), rel=1e-3)


def test_best_damper_behind_a_bush():
    found = best_damper_behind_a_bush.main()
    assert found["airspring only"] == pytest.approx(2.2202, abs=1e-4)
    assert found["order 1"] <= 1.9614
    assert found["order 2"] <= 1.93


def test_own_vehicle():
    found = own_vehicle.main()
    assert found["S3"] < found["conventional"]


def test_building_in_wind_and_earthquake():
    found = building_in_wind_and_earthquake.main()
    assert found["order 2"] < 0.94 * found["damper"]


def test_measured_track():
    found = measured_track.main()
    assert found["D1"] == pytest.approx(0.9843, rel=0.03)
    assert found["by frequency"] == pytest.approx(found["on erri-low"], rel=0.05)
    assert found["in time"] == pytest.approx(found["by frequency"], rel=0.05)
