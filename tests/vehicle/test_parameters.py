"""A user's vehicle file: what it changes, and how it is refused."""

from __future__ import annotations

import pytest

from posreal.errors import BadInput
from posreal.specification.named import problem
from posreal.vehicle import PlanView, SideView, described, from_file, override

TABLES = ("plan-view", "side-view", "quarter-car")


def write(tmp_path, text: str):
    path = tmp_path / "vehicle.toml"
    path.write_text(text)
    return path


def test_a_file_overrides_what_it_names(tmp_path):
    path = write(tmp_path, '[side-view]\nmv = 42000\nCrz = "70 kN s/m"\n\n[plan-view]\nmv = "18 t"\n')
    side = problem("vertical-comfort", vehicle_file=path).vehicle
    assert (side.mv, side.Crz, side.mb) == (42000.0, 70e3, 2500.0)
    assert problem("lateral-comfort", vehicle_file=path).vehicle.mv == 18000.0


def test_changed_masses_change_the_answer(tmp_path):
    path = write(tmp_path, "[side-view]\nmv = 19000\n")
    lighter = problem("vertical-comfort", vehicle_file=path).default_metrics["J1z_M"].value
    assert lighter > 1.2 * problem("vertical-comfort").default_metrics["J1z_M"].value


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[side-view]\nMv = 1\n", "did you mean mv"),
        ('[side-view]\nmv = "3 kN"\n', "mv"),
        ('[side-view]\nmv = "3 parsecs of stone"\n', "mv"),
        ("[side-view]\nmv = -3\n", "must be finite and greater than 0"),
        ("[side-view]\nmv = 0\n", "must be finite and greater than 0"),
        ("[side-view]\nmv = nan\n", "must be finite"),
        ("[side-view]\nmv = inf\n", "must be finite"),
        ("[side-view]\nmv = true\n", "must be a number"),
        ("[side-view]\nmv = [1]\n", "must be a number"),
        ("[sideview]\nmv = 1\n", "unknown table"),
        ("mv = 1\n", "unknown table or key"),
        ("[side-view\nmv = 1\n", "not valid TOML"),
        ("[plan-view]\nmv = 1\n", "no table [side-view]"),
    ],
)
def test_a_bad_file_is_refused_with_the_culprit(tmp_path, text, says):
    with pytest.raises(BadInput) as caught:
        from_file(SideView(), write(tmp_path, text), "side-view", TABLES)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value).replace("(at ", "")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(BadInput, match="cannot read"):
        problem("vertical-comfort", vehicle_file=tmp_path / "none.toml")


def test_every_parameter_says_what_it_is():
    for vehicle in (PlanView(), SideView()):
        for name, value, unit, meaning, source in described(vehicle):
            assert name
            assert value >= 0
            assert unit
            assert meaning
            assert source.startswith("Jiang2012")


def test_override_keeps_the_rest():
    assert override(PlanView(), {"Kpy": "6.33 MN/m"}) == PlanView(Kpy=6.33e6)
