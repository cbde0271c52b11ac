"""What a user meets in Python: names where objects are meant, short reprs, tables for notebooks and pandas."""

from __future__ import annotations

import sys

import pytest

import posreal as pr


@pytest.fixture(scope="module")
def quarter():
    return pr.problem("quarter-car")


@pytest.fixture(scope="module")
def found(quarter):
    return pr.search(quarter, 2)


def test_a_name_is_as_good_as_the_thing(quarter):
    by_name = pr.optimise("quarter-car", "S3", starts=2)
    assert by_name.objective == pr.optimise(quarter, pr.layout("S3"), starts=2).objective
    assert pr.evaluate("quarter-car", "c=1500").metrics == pr.evaluate(quarter, "c=1500").metrics
    assert pr.bound("quarter-car", L=8, omega0=20.0).value == pr.bound(quarter, L=8, omega0=20.0).value
    assert pr.synthesise("quarter-car", 0, starts=1).problem == quarter


def test_a_vehicle_may_be_a_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[quarter-car]\nk = "20 kN/m"\n')
    for given in (path, str(path)):
        assert pr.problem("quarter-car", vehicle=given).vehicle.k == 20e3
    with pytest.raises(pr.BadInput, match="give one"):
        pr.problem("quarter-car", vehicle=path, vehicle_file=path)


@pytest.mark.parametrize("given", [3, None, ["quarter-car"]])
def test_what_is_no_problem_is_refused(given):
    with pytest.raises(pr.BadInput, match=r"name of one.*quarter-car"):
        pr.evaluate(given, "c=1")
    with pytest.raises(pr.BadInput, match="did you mean quarter-car"):
        pr.evaluate("quartercar", "c=1")


def test_reprs_are_a_line(quarter, found):
    design = pr.evaluate(quarter, "c=1500")
    comparison = pr.Comparison(quarter, (design,))
    shown = [quarter, design, found, found.front, found.front[0], comparison, pr.pareto(found)]
    shown += [pr.sweep(design, {"V": (10.0, 20.0)}), pr.bound(quarter, L=4, omega0=20.0)]
    for thing in shown:
        assert len(repr(thing)) < 250
        assert "\n" not in repr(thing)
    assert "J1" in str(quarter)
    assert "c=" in str(found)
    assert len(str(found).splitlines()) == 4 + len(found.front)


def test_notebooks_show_tables(quarter, found):
    design = pr.evaluate(quarter, "k=60e3 | c=1500")
    for thing, said in ((quarter, "minimises"), (design, "on top of"), (found, "elements"), (pr.pareto(found), "J1")):
        page = thing._repr_html_()
        assert page.count("<table>") == page.count("</table>") >= 1
        assert said in page
    page = pr.Comparison(quarter, (design,))._repr_html_()
    assert "<svg" in page
    assert "k_static" in page


def test_frames(quarter, found):
    pytest.importorskip("pandas")
    design = pr.evaluate(quarter, "c=1500")
    assert design.to_frame().loc["J1", "value"] == design.metrics["J1"].value
    frame = found.to_frame()
    assert list(frame.index) == [point.elements for point in found.front]
    assert frame.loc[1, "J1"] == found.front[0].design.objective.value
    assert frame.loc[1, "c"] == found.front[0].design.parameters["c"]
    swept = pr.sweep(design, {"V": (10.0, 20.0)}).to_frame()
    assert list(swept["V"]) == [10.0, 20.0]
    assert list(pr.Comparison(quarter, (design,)).to_frame().index) == [design.label]


def test_without_pandas_a_frame_is_a_sentence(quarter, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(pr.BadInput, match=r"posreal\[pandas\]"):
        pr.evaluate(quarter, "c=1500").to_frame()
