"""Whole searches: the front, the company of each network, repeatability, interruption, and what is refused."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from posreal.errors import BadInput, Infeasible
from posreal.network import nodal_admittance
from posreal.optimisation.layout_values import optimise
from posreal.specification.layout import layout
from posreal.specification.named import problem
from posreal.study.pareto import pareto
from posreal.topology.checkpoint import Checkpoint
from posreal.topology.options import read_at_most, read_bounds, read_limits
from posreal.topology.search import search

BEHIND_THE_BUSH = {1: 2.0617, 2: 1.9614, 3: 1.9227, 4: 1.8829}  # known best J1z(T), %g
HEADER = {"version": 1, "problem": "p", "seed": 0}


@pytest.fixture(scope="module")
def vertical():
    return search(problem("vertical-comfort", band_only=True), 4, starts=4, seed=1)


def front(found):
    return [(str(point.network), point.design.objective.value) for point in found.front]


def test_the_front_is_as_good_as_what_is_known(vertical):
    assert [point.elements for point in vertical.front] == [1, 2, 3, 4]
    for point in vertical.front:
        assert point.design.objective.value <= BEHIND_THE_BUSH[point.elements]
        assert point.design.order <= point.network.counts.springs + point.network.counts.inerters
    vertical.check()
    assert vertical.of(3) is vertical.front[2].design
    assert vertical.best is vertical.front[3].design


def test_equivalent_networks_are_the_same_device(vertical):
    point = vertical.front[3]
    s = 1j * np.geomspace(0.1, 100, 30)
    # within ranges each of the two is searched for itself, and which is called the other's equivalent is rounding's
    both = {str(network.topology()) for network in (point.network, *point.equivalent)}
    assert both == {"b1 + (b2 | c + k)", "b1 | b2 + c + k"}
    for network in point.equivalent:
        assert nodal_admittance(network)(s) == pytest.approx(point.design.device(s), rel=1e-6)


def test_runners_up_are_no_smaller_networks_in_disguise(vertical):
    for point in vertical.front[1:]:
        assert all(other.objective > point.design.objective.value for other in point.others)
        assert all(len(other.network) == point.elements for other in point.others)
    # k + c, c | k, … want their spring rigid or gone
    assert vertical.tallies[1].reduced == 4
    assert [str(other.network.topology()) for other in vertical.front[1].others] == ["b | c"]


def test_tallies_add_up(vertical):
    assert [tally.topologies for tally in vertical.tallies] == [3, 6, 20, 90]
    assert [tally.redundant for tally in vertical.tallies] == [0, 0, 0, 0]  # within ranges each stands for itself
    assert all(tally.impossible == 0 for tally in vertical.tallies)


def test_any_number_of_jobs_gives_the_same(vertical):
    side_by_side = search(problem("vertical-comfort", band_only=True), 3, starts=4, seed=1, jobs=2)
    assert front(side_by_side) == front(vertical)[:3]


def test_what_left_out_topologies_would_find_is_found_anyway():
    """With bounds nothing is left out beforehand; wide ones change nothing."""
    wide = {"k": (1e-1, 1e12), "c": (1e-2, 1e10), "b": (1e-3, 1e9)}
    posed = problem("quarter-car")
    every, fewer = search(posed, 3, bounds=wide), search(posed, 3, any_values=True)
    assert every.tallies[2].redundant == 0 < fewer.tallies[2].redundant
    assert [J for _, J in front(every)] == pytest.approx([J for _, J in front(fewer)], rel=1e-6)
    # closed forms of k | c and of k | c + b beside the static spring
    assert [J for _, J in front(fewer)][:2] == pytest.approx([1.759967, 1.585094], abs=2e-6)


def test_no_more_elements_of_a_kind_than_allowed():
    found = search(problem("quarter-car"), 3, at_most={"springs": 0, "inerters": 1}, starts=3)
    assert all(point.network.counts.springs == 0 and point.network.counts.inerters <= 1 for point in found.front)
    assert found.front[-1].elements == 2  # a second damper brings nothing
    none = search(problem("vertical-comfort"), 1, at_most={"dampers": 0, "inerters": 0, "springs": 0})
    assert none.front == ()
    found = search(problem("quarter-car"), 3, at_most={"reactive": 1}, starts=3)
    assert all(point.design.order <= 1 for point in found.front)


def test_lateral_comfort_keeps_its_damping():
    found = search(problem("lateral-comfort"), 2, starts=3, any_values=True)
    assert found.front[1].design.objective.value <= 0.2173  # S3
    assert all(point.design.feasible for point in found.front)
    assert found.tallies[0].impossible == 2  # a spring or an inerter alone damps nothing
    found.check()


def test_a_limit_on_another_metric_is_kept():
    free = search(problem("vertical-comfort"), 2, starts=3)
    ceiling = 0.99 * free.best.metrics["deflection_rms_rear"].value
    held = search(problem("vertical-comfort"), 2, starts=3, limits={"deflection_rms_rear": ceiling})
    assert held.best.metrics["deflection_rms_rear"].value <= ceiling * (1 + 1e-9)
    assert held.best.objective.value > free.best.objective.value
    held.check()
    assert [c.metric for c in held.problem.without_limits.constraints] == ["J1z_T_whole"]
    with pytest.raises(Infeasible, match="2 elements or fewer"):
        pareto(search(problem("vertical-comfort"), 2, starts=2, limits={"deflection_rms_rear": 0.1}))


def test_a_search_takes_what_the_other_searches_take():
    """A peak in time as a limit, the worst of three places, an operating point, a gain, a weighted sum."""
    ceiling = 0.98 * search(problem("vertical-comfort"), 2, starts=2).best.metrics["deflection_front"].value
    posed = problem(
        "vertical-comfort", position="worst", worst_case=[{"Crz": 50e3}], limits={"deflection_front": ceiling}
    )
    found = search(posed, 2, starts=2)
    found.check()
    assert found.best.metrics["deflection_front"].value <= ceiling * (1 + 1e-9)
    alone = optimise(posed, layout("S5"), starts=2)  # a damper and an inerter in series
    assert found.best.objective.value <= alone.objective.value * (1 + 1e-6)


@pytest.mark.parametrize("objective", ["J1 + 0.001*J3", pytest.param("gain_acceleration", marks=pytest.mark.long)])
def test_a_search_for_a_sum_and_for_a_gain(objective):
    posed = problem("quarter-car", objective=objective)
    best = min(optimise(posed, layout(name), starts=3).objective.value for name in ("S1", "S2", "S3"))
    assert search(posed, 2, starts=4).best.objective.value <= best * (1 + 1e-5)


def test_trading_comfort_against_deflection():
    found = search(problem("vertical-comfort"), 2, starts=3, metric="deflection_rms_rear")
    two = [point.design for point in found.front if point.elements == 2]
    assert len(two) >= 3
    figures = [(d.objective.value, d.metrics["deflection_rms_rear"].value) for d in two]
    assert figures == sorted(figures)
    assert [m for _, m in figures] == sorted((m for _, m in figures), reverse=True)
    found.check()


@pytest.mark.usefixtures("without_pyplot")
def test_the_picture_and_the_text(tmp_path):
    drawn = pareto(search(problem("quarter-car"), 2, starts=3), orders=(1,), bound=1.409531)
    path = drawn.draw(tmp_path / "front.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    text = drawn.text(ascii=True)
    assert "1.5851" in text
    assert "S2 (2 elements): 1.6608" in text
    assert drawn.above_synthesis(drawn.search.front[1]) == pytest.approx(0.0, abs=1e-3)
    document = json.loads(json.dumps(drawn.to_dict(), allow_nan=False))
    assert [entry["elements"] for entry in document["front"]] == [1, 2]
    assert {"objective", "notation", "metrics", "equivalent"} <= set(document["front"][0])
    with pytest.raises(BadInput, match=r"front\.xyz.*accepted are"):
        drawn.draw(tmp_path / "front.xyz")


# --- interruption --------------------------------------------------------------------------------------------


def test_a_search_goes_on_from_its_checkpoint(tmp_path, vertical):
    path = tmp_path / "so-far.jsonl"
    search(problem("vertical-comfort"), 2, starts=4, seed=1, checkpoint=path)
    before = path.read_bytes()
    again = search(problem("vertical-comfort"), 3, starts=4, seed=1, checkpoint=path)
    assert again.found["resumed"] == 9
    assert path.read_bytes().startswith(before)
    assert front(again) == front(vertical)[:3]
    size = path.stat().st_size
    assert search(problem("vertical-comfort"), 3, starts=4, seed=1, checkpoint=path).found["resumed"] == 29
    assert path.stat().st_size == size


def test_a_killed_search_goes_on(tmp_path, vertical):
    path = tmp_path / "so-far.jsonl"
    code = (
        "from posreal.specification.named import problem; from posreal.topology.search import search;"
        f"search(problem('vertical-comfort', band_only=True), 4, starts=4, seed=1, checkpoint={str(path)!r})"
    )
    with subprocess.Popen([sys.executable, "-c", code]) as process:
        deadline = time.monotonic() + 60
        while (not path.exists() or path.read_bytes().count(b"\n") < 45) and time.monotonic() < deadline:
            time.sleep(0.01)
        os.kill(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    again = search(problem("vertical-comfort", band_only=True), 4, starts=4, seed=1, checkpoint=path)
    assert 25 <= again.found["resumed"] < 65
    assert front(again) == front(vertical)


def test_an_unfinished_last_line_is_cut_off(tmp_path):
    path = tmp_path / "c"
    with Checkpoint(path, HEADER) as file:
        file.add([{"network": "c"}, {"network": "k"}])
    whole = path.read_bytes()
    for cut in (1, 5, 20):
        path.write_bytes(whole[:-cut])
        with Checkpoint(path, HEADER) as file:
            assert file.records == [{"network": "c"}]
            assert file.trimmed
            file.add([{"network": "k"}])
        assert path.read_bytes() == whole
    with Checkpoint(path, HEADER) as file:
        assert not file.trimmed


def test_damage_further_up_is_refused(tmp_path):
    path = tmp_path / "c"
    with Checkpoint(path, HEADER) as file:
        file.add([{"network": "c", "objective": 1.25}, {"network": "k", "objective": 2.5}])
    whole = path.read_text()
    path.write_text(whole.replace("1.25", "1.24"))
    with pytest.raises(BadInput, match=r"line 2 of the checkpoint .* is damaged"):
        Checkpoint(path, HEADER)
    path.write_text(whole.replace("\n", "", 1))
    with pytest.raises(BadInput, match="not a checkpoint"):
        Checkpoint(path, HEADER)


def test_a_foreign_file_is_left_alone(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("do not\noverwrite me\n")
    with pytest.raises(BadInput, match="not a checkpoint"):
        search(problem("quarter-car"), 1, checkpoint=path)
    assert path.read_text() == "do not\noverwrite me\n"
    path.write_text("one line without an end")
    with pytest.raises(BadInput, match="not a checkpoint"):
        search(problem("quarter-car"), 1, checkpoint=path)
    with pytest.raises(BadInput, match="cannot write"):
        search(problem("quarter-car"), 1, checkpoint=tmp_path / "nowhere" / "c")


def test_another_search_s_checkpoint_is_refused(tmp_path):
    path = tmp_path / "c"
    search(problem("quarter-car"), 1, starts=2, checkpoint=path)
    with pytest.raises(BadInput, match="its seed is 0, here it is 1"):
        search(problem("quarter-car"), 1, starts=2, seed=1, checkpoint=path)
    with pytest.raises(BadInput, match="its problem is 'quarter-car'"):
        search(problem("vertical-comfort"), 1, starts=2, checkpoint=path)
    with pytest.raises(BadInput, match="fingerprint"):
        search(problem("quarter-car", stiffness=5e4), 1, starts=2, checkpoint=path)


def test_two_searches_do_not_share_a_checkpoint(tmp_path):
    with Checkpoint(tmp_path / "c", HEADER), pytest.raises(BadInput, match="in use"):
        Checkpoint(tmp_path / "c", HEADER)


# --- what is refused -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"elements": 0}, "from 1 to 7"),
        ({"elements": 8}, "from 1 to 7"),
        ({"starts": 0}, "from 1 to 1000"),
        ({"jobs": 0}, "-1 for all cores"),
        ({"backend": "ray"}, "unknown backend 'ray'"),
        ({"backend": "dask"}, "needs the address"),
        ({"scheduler": "tcp://x:1"}, "for the dask backend"),
        ({"at_most": {"spring": 2}}, "did you mean springs"),
        ({"at_most": {"springs": -1}}, "whole number"),
        ({"bounds": {"k": (2.0, 1.0)}}, "below the second"),
        ({"bounds": {"x": (1.0, 2.0)}}, "k, c or b"),
        ({"limits": {"J1z": 20.0}}, "'J1z' cannot be limited"),
        ({"limits": {"J1z_M": -1.0}}, "greater than 0"),
        ({"metric": "J1z_T"}, "cannot be traded against 'J1z_T'"),
    ],
)
def test_what_cannot_be_searched_is_refused(options, message):
    with pytest.raises(BadInput, match=message):
        search(problem("vertical-comfort"), **{"elements": 1, **options})


def test_options_as_text():
    assert read_at_most("springs=2, inerters=1") == {"springs": 2, "inerters": 1}
    assert read_bounds(["k=10 kN/m:5 MN/m"]) == {"k": (1e4, 5e6)}
    assert read_limits(["deflection_rms_rear=7.5"]) == {"deflection_rms_rear": 7.5}
    for read, text in (
        (read_at_most, "springs"),
        (read_at_most, "levers=1"),
        (read_bounds, ["k=5"]),
        (read_bounds, ["n=1:2"]),
        (read_bounds, ["k=1 kg:2 kg"]),
        (read_limits, ["J1=much"]),
    ):
        with pytest.raises(BadInput):
            read(text)
