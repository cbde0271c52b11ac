"""The comparison of vertical-comfort: what `make demo` prints."""

from __future__ import annotations

from pathlib import Path

import control
import numpy as np
import pytest

from posreal.errors import Infeasible
from posreal.specification.from_plant import problem_from_plant
from posreal.specification.named import problem
from posreal.study.compare import compare
from posreal.study.strut import strut


@pytest.fixture(scope="module")
def comparison():
    return compare(problem("vertical-comfort"))


def test_rows(comparison):
    labels = [row.label for row in comparison.rows]
    assert labels == ["airspring only", "S4", "S5", "S6", "S7", "order 1", "order 2"]
    figures = {row.label: row.objective.value for row in comparison.rows}
    assert figures["airspring only"] == pytest.approx(2.2202, abs=1e-4)
    assert figures["order 1"] <= 1.9614
    assert figures["order 2"] <= 1.93
    assert comparison.best.label == "order 2"


def test_every_row_checks(comparison):
    for row in comparison.rows:
        row.check()


def test_synthesised_rows_are_networks_that_are_the_device(comparison):
    for row in comparison.rows[-2:]:
        assert row.network is not None
        assert row.found["residual"] < 1e-9
        assert all(element.value > 0 for element in row.network.elements())
        whole = strut(row)
        assert len(whole) == len(row.network) + 1  # the bush


def test_text_and_data_agree(comparison):
    text = comparison.text()
    data = comparison.to_dict()
    assert 1.4 < data["bound"]["bound"]["value"] < min(row["objective"]["value"] for row in data["rows"])
    assert data["bound"]["bound"]["kind"] == "whole-band H2"
    assert all(row["gap_percent"] > 0 for row in data["rows"])
    for row in data["rows"]:
        assert row["label"] in text
        assert f"{row['metrics']['J1z_T']['value']:#.5g}" in text
    assert "Best network, order 2" in text
    assert max(len(line) for line in text.splitlines()) <= 130


def test_the_readme_shows_this_comparison(comparison):
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    for row in comparison.rows:
        (line,) = [line for line in readme.splitlines() if line.startswith(f"  {row.label}  ")]
        figures = line[len(row.label) + 2 :].split()
        T = row.metrics["J1z_T"].value
        assert float(figures[3]) == pytest.approx(T, abs=2e-4)
        network = strut(row)
        assert figures[-2] == ("–" if network is None else str(len(network)))


def drawn_numbers(comparison, path):
    """Everything that the picture says, from its SVG with text as text."""
    import matplotlib

    with matplotlib.rc_context({"svg.fonttype": "none"}):
        comparison.draw(path)
    return path.read_text()


@pytest.mark.usefixtures("without_pyplot")
def test_the_picture_never_mixes_bands(comparison, tmp_path):
    text = drawn_numbers(comparison, tmp_path / "vertical.svg")
    assert not comparison.shares_figure
    assert "J1z_T, to 20 Hz" in text
    assert "J1z_T, all frequencies" in text
    assert f"no passive device below {comparison.bound.value:#.5g}" in text
    for row in comparison.rows:
        assert f"gap {comparison.gap(row):.1f} %" in text
        assert row.label in text
    for ending, start in ((".png", b"\x89PNG"), (".pdf", b"%PDF")):
        path = comparison.draw(tmp_path / f"vertical{ending}")
        assert path.read_bytes().startswith(start)


@pytest.mark.usefixtures("without_pyplot")
def test_a_sum_over_the_whole_band_has_one_dot_a_row_and_its_bound(tmp_path):
    found = compare(problem("quarter-car", objective="J1 + 0.001*J3"), orders=(1,))
    assert found.shares_figure
    text = found.text()
    assert "sum [1]" in text
    assert "Sum: J1 + 0.001*J3." in text
    assert all(0 < found.gap(row) < 15 for row in found.rows)
    assert "all frequencies" not in drawn_numbers(found, tmp_path / "sum.svg")
    for row in found.rows:
        assert row.metrics["J1 + 0.001*J3"].value == pytest.approx(
            row.metrics["J1"].value + 1e-3 * row.metrics["J3"].value
        )


def test_operating_points_have_a_column_and_keep_their_damping():
    found = compare(problem("lateral-comfort", worst_case=[{"conicity": 0.35}]), orders=())
    text = found.text()
    assert "worst case [m/s^2]" in text
    assert "Worst case: Macc, the worst over the nominal vehicle, conicity=0.35." in text
    assert "Subject to Ldmp at conicity=0.35 >= 3.13477 (the default's)." in text
    for row in found.rows:
        row.check()
        worst = max(row.metrics["Macc"].value, row.metrics["Macc at conicity=0.35"].value)
        assert row.objective.value == worst
    assert found.best.label == "S3"


@pytest.mark.long
def test_the_worst_of_three_points_has_the_best_of_their_bounds():
    found = compare(problem("vertical-comfort", position="worst"), orders=())
    assert found.bound.metric == "J1z_T"
    assert not found.shares_figure
    text = found.text()
    assert "The bound is on J1z_T, than which the worst is no smaller." in text
    assert "Worst: worst of J1z_L, J1z_M, J1z_T." in text


def test_no_bound_says_why():
    found = compare(problem("lateral-gauging"), orders=())
    assert found.bound is None
    assert "No bound: no valid bound on max_yv is known" in found.text()
    assert found.to_dict()["bound"] is None


def test_limits_that_nothing_keeps_are_one_sentence():
    with pytest.raises(Infeasible, match=r"neither a layout nor a synthesised device was found that keeps J3 <= 100"):
        compare(problem("quarter-car", limits={"J3": 100.0}), orders=())


def test_a_plant_of_the_users_own_is_compared_too():
    # a mass on a spring, shaken, and an absorber of a twentieth of it on the device
    A = np.array([[0, 1, 0, 0], [-1, -0.002, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0.0]])
    B, C = np.array([[0, 0], [1, -1], [0, 0], [0, 20.0]]), np.array([[1, 0, 0, 0], [0, 1, 0, -1.0]])
    system = control.ss(A, B, C, np.zeros((2, 2)), inputs=["w", "f"], outputs=["x", "v"])
    posed = problem_from_plant(
        system, disturbances="w", force="f", performance="x", velocity="v", limits={"static_stiffness": 1.0}
    )
    found = compare(posed, orders=(1,))
    assert [row.label for row in found.rows] == ["order 1"]
    assert "rms_x" in found.text()
    assert "  + ─" in found.text()
