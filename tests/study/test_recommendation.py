"""The network to build: what is recommended, what is said of it, and the page that says it."""

from __future__ import annotations

import json
import shutil
import subprocess
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest

import posreal as pr
from posreal.errors import BadInput, Infeasible
from posreal.network import nodal_admittance
from posreal.network.as_made import made
from posreal.study.recommendation import design, ordered, over_all_frequencies, smallest
from posreal.study.report import page, save


@pytest.fixture(scope="module")
def found():
    return design("quarter-car", elements=2, orders=(1,), draws=40)


def test_the_smallest_network_that_is_near_enough(found):
    best = found.search.best.objective.value
    assert found.recommended.objective.value <= best * 1.0111
    smaller = [point for point in found.search.front if point.elements < len(found.network)]
    assert all(point.design.objective.value > best * 1.01 for point in smaller)
    assert found.above_best_percent == pytest.approx(100 * (found.recommended.objective.value / best - 1))
    assert len(smallest(found.search, 0.5).bought) == 1  # half as much again costs less than a part
    assert smallest(found.search, 0.0).objective == found.search.best.objective


def test_values_are_those_to_order(found):
    """Three digits, and every figure is of these values: recomputed from the network's graph."""
    for value in found.network.exact_values().values():
        assert float(value) == float(f"{float(value):.3g}")
    problem = found.recommended.problem
    anew = problem.metrics(problem.port(nodal_admittance(made(found.network, problem.elements))))
    for name, metric in anew.items():
        assert found.recommended.metrics[name].value == pytest.approx(metric.value, rel=1e-9)
    assert not found.recommended.outside


def test_what_it_is_held_against(found):
    bound = found.comparison.bound
    assert bound is not None
    value = found.recommended.objective.value
    assert found.gap_percent == pytest.approx(100 * (1 - bound.value / value))
    assert found.above_reached_percent == pytest.approx(100 * (value / bound.attained.value - 1))
    assert found.tolerance.design.bought == found.network
    for (_, less), (_, more) in pairwise(found.larger):
        assert less <= more


def test_text_and_data_say_the_same(found):
    text, data = str(found), json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert f"Build this: {len(found.network)} elements, J1 " in text
    assert data["recommended"]["network"]["notation"] == str(found.network)
    assert data["recommended"]["objective"]["value"] == found.recommended.objective.value
    assert data["recommended"]["feasible"] is True
    assert set(data) >= {"rows", "front", "bound", "recommended", "within_percent", "tolerance"}
    assert {row["label"] for row in data["rows"]} <= set(
        text.split("Networks of up to")[0].replace("  ", "\n").split("\n")
    )
    nominal = data["tolerance"]["metrics"]["J1"]["nominal"]
    assert nominal == pytest.approx(found.recommended.objective.value, rel=1e-9)


def test_what_ends_at_20_hz_is_designed_over_all_frequencies():
    problem = pr.problem("vertical-comfort")
    assert over_all_frequencies(problem).objective == "J1z_T_whole"
    assert over_all_frequencies(pr.problem("lateral-comfort")).objective == "Macc_whole"
    only = pr.problem("vertical-comfort", band_only=True)
    assert over_all_frequencies(only) is only
    points = pr.problem("vertical-comfort", worst_case=[{"V": 40.0}])
    assert over_all_frequencies(points).base_objective == "J1z_T_whole"
    there = over_all_frequencies(pr.problem("quarter-car"))
    assert there.objective == "J1"


def test_rounding_keeps_a_constraint_that_binds():
    """S3 stands on the damping limit, where the nearest values of three digits may miss it."""
    problem = pr.problem("lateral-comfort")
    best = pr.optimise(problem, pr.layout("S3"), any_values=True)
    inner = pr.evaluate(problem, f"c={best.parameters['c']!r} + b={best.parameters['b']!r}")
    few = ordered(inner)
    assert few.feasible
    assert few.objective.value <= inner.objective.value * 1.001
    assert all(len(str(int(value)).rstrip("0")) <= 4 for value in few.network.exact_values().values())
    with pytest.raises(Infeasible, match="Ldmp"):
        ordered(pr.evaluate(problem, "c=1000"))


def test_bad_fraction():
    with pytest.raises(BadInput, match=r"within is 1\.5"):
        design("quarter-car", within=1.5)


class _Page(HTMLParser):
    """What a page loads, its open tags, and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.open: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img"):
            self.open.append(tag)
        self.loaded += [value for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_the_page_stands_by_itself(found, tmp_path):
    path = save(found, tmp_path / "report.html")
    parsed = _Page()
    parsed.feed(path.read_text())
    assert parsed.open == []
    assert len(parsed.loaded) == 4
    assert all(source.startswith("data:image/svg+xml;base64,") for source in parsed.loaded)
    text = " ".join(parsed.words)
    assert f"Build this: {len(found.network)} elements" in text
    assert f"{found.recommended.objective.value:#.6g}" in text
    assert page(found) == path.read_text()  # the same bytes again
    with pytest.raises(BadInput, match=r"accepted are \.html"):
        save(found, tmp_path / "report.pdf")


@pytest.mark.skipif(
    shutil.which("chromium") is None, reason="chromium is not installed, so no browser looks at the page"
)
def test_a_browser_shows_the_page(found, tmp_path):
    """Nothing sticks out to the right, no picture is broken: asked of the browser itself."""
    probe = (
        "<script>addEventListener('load', () => { const wide = document.documentElement; const broken = "
        "[...document.images].filter(i => !i.complete || i.naturalWidth === 0).length; document.title = "
        "`probe ${document.images.length} ${broken} ${wide.scrollWidth - wide.clientWidth}`; });</script>"
    )
    path = tmp_path / "report.html"
    path.write_text(page(found).replace("</body>", probe + "</body>"))
    command = [
        "chromium",
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    run = subprocess.run(
        [*command, "--window-size=1100,2000", "--dump-dom", path.as_uri()], capture_output=True, text=True, timeout=120
    )
    title = run.stdout.split("<title>")[1].split("</title>")[0]
    assert title == "probe 4 0 0"


def test_the_command(monkeypatch, capsys, tmp_path):
    from posreal import cli

    words = ["posreal", "design", "quarter-car", "--elements", "1", "--orders", "0", "--draws", "20", "--jobs", "1"]
    monkeypatch.setattr("sys.argv", [*words, "--report", str(tmp_path / "r.html"), "--json"])
    with pytest.raises(SystemExit, match="0"):
        cli.main()
    data = json.loads(capsys.readouterr().out)
    assert data["recommended"]["network"]["elements"]["dampers"] == 1
    assert (tmp_path / "r.html").read_text().startswith("<!DOCTYPE html>")
    monkeypatch.setattr("sys.argv", [*words, "--within", "150%"])
    with pytest.raises(SystemExit):
        cli.main()
    assert "is not a fraction such as 1%" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.parametrize("name", ["vertical-comfort", "lateral-comfort"])
def test_what_is_recommended_can_be_built(name):
    found = design(name, elements=3, draws=100)
    assert found.recommended.feasible
    assert not found.recommended.outside
    assert found.recommended.improvement() > 1
    twin = found.asked.objective
    assert found.recommended.metrics[twin].value < found.asked.default_metrics[twin].value


@pytest.mark.long
def test_the_readme_shows_what_the_demo_says():
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    said = readme[readme.index("Build this:") :].split("```")[0].rstrip()
    assert said in str(design("vertical-comfort"))
