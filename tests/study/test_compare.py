"""The comparison of vertical-comfort: what `make demo` prints."""

from __future__ import annotations

from pathlib import Path

import pytest

from posreal.design import problem
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
