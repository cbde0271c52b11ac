"""Certificates: what a file claims is proven from its numbers alone, and an edited file proves itself wrong."""

from __future__ import annotations

import copy
import dataclasses
import json

import numpy as np
import pytest
from flint import fmpq

from posreal.admittance import Rational
from posreal.admittance.roots import precision
from posreal.bounds import certificate as formula
from posreal.bounds.certificate import NotProven
from posreal.bounds.compute import bound
from posreal.bounds.figure import BoundedFigure, enclosed, figure
from posreal.bounds.file import from_dict, load_bound
from posreal.bounds.sampled import Sampled
from posreal.bounds.shor_dual import form
from posreal.errors import BadInput, PosrealError
from posreal.optimisation.evaluate import evaluate
from posreal.specification.named import problem
from posreal.specification.problem import Problem
from posreal.vehicle.user_plant import UserPlant

QUARTER_CAR = problem("quarter-car")
SIDE = problem("vertical-comfort")


@pytest.fixture(scope="module")
def plain():
    return bound(QUARTER_CAR, L=12, omega0=20, best=evaluate(QUARTER_CAR, "b=30 | c=2300"))


@pytest.fixture(scope="module")
def lifted():
    return bound(SIDE, L=6, omega0=(10, (30, 0.5)))


@pytest.mark.parametrize("posed", [QUARTER_CAR, SIDE, problem("lateral-comfort")], ids=lambda p: p.name)
def test_the_formula_in_balls_is_the_formula_in_floats(posed):
    rng = np.random.default_rng(3)
    about = figure(posed)
    found = enclosed(about, [fmpq(20), (fmpq(50), fmpq(2, 5)), fmpq(20), fmpq(7)], fmpq(5000))
    r, m = len(about.loops), 5
    C = np.tril(rng.standard_normal((r * m, r * m))) * 1e-2
    mu = 1e-5 * rng.standard_normal((r * (r - 1) // 2, m))
    V = rng.standard_normal((r * m, r * m))
    affine = form(Sampled.of(found), V)
    half = np.linalg.solve(V, C)
    c, b, M = affine.at(np.concatenate([(half @ half.T)[affine.pairs], mu.ravel()]))
    assert np.all(np.linalg.eigvalsh(M) > 0)
    with precision(300):
        ball = formula.proven(found, C, mu)
    assert float(ball) == pytest.approx(c - b @ np.linalg.solve(M, b), rel=1e-9)
    assert ball.rad() < 1e-12


def test_any_multiplier_gives_a_bound(plain):
    # half the multiplier, a rotated one, or none at all: less is proven, never too much
    for change in (lambda C: C / 2, lambda C: C[::-1], lambda C: 0 * C, lambda C: C * 1.01):
        numbers = plain.certificate
        other = dataclasses.replace(numbers, factor=change(numbers.factor))
        try:
            assert other.lower_bound(plain.figure) <= plain.value * (1 + 1e-8)
        except NotProven:
            continue


@pytest.fixture(scope="module")
def summed():
    return bound(problem("quarter-car", objective="J1 + 0.001*J3"), L=8, omega0=20)


@pytest.fixture(scope="module")
def peak():
    return bound(problem("quarter-car", objective="gain_tyre_force"), L=8, omega0=20)


@pytest.mark.parametrize("kind", ["plain", "lifted", "summed", "peak"])
def test_saved_and_read_again(kind, request, tmp_path):
    found = request.getfixturevalue(kind)
    found.save(tmp_path / "bound.json")
    again = load_bound(tmp_path / "bound.json")
    assert again.value == found.value
    assert again.check() >= again.value > 0.9 * again.check()
    assert again.gap_percent == found.gap_percent
    assert str(again) == str(found)


def test_checking_needs_no_solver(plain, lifted, monkeypatch):
    def fail(*args, **kwargs):
        raise AssertionError("a solver was asked")

    documents = plain.to_dict(), lifted.to_dict()
    monkeypatch.setattr("posreal.bounds.one_passive_port.solve", fail)
    monkeypatch.setattr("posreal.bounds.shor_dual.solve", fail)
    for document in documents:
        assert from_dict(document).check() > 0


EDITS = {
    "bound value": lambda d: d["bound"].update(value=d["bound"]["value"] * 1.001),
    "bound value below 0": lambda d: d["bound"].update(value=-1.0),
    "unit": lambda d: d["bound"].update(unit="km/s^2"),
    "metric": lambda d: d["bound"].update(metric="J3"),
    "kind": lambda d: d["bound"].update(kind="to 20 Hz"),
    "holds for": lambda d: d.update(holds_for="every device"),
    "passive": lambda d: d.update(passive=False),
    "format": lambda d: d.update(format="posreal bound 2"),
    "gap": lambda d: d.update(gap_percent=0.01),
    "best value": lambda d: d["best"].update(value=1.5),
    "best unit": lambda d: d["best"].update(unit="%g"),
    "best device": lambda d: d["best"]["port"]["numerator"].__setitem__(1, "2500"),
    "best gone": lambda d: d.update(best=None),
    "a softer spring": lambda d: d["about"]["vehicle"].update(k=40e3),
    "a heavier body": lambda d: d["about"]["vehicle"].update(ms=300.0),
    "a smoother road": lambda d: d["about"]["vehicle"].update(kappa=4e-7),
    "another problem": lambda d: d["about"].update(problem="vertical-comfort"),
    "no problem": lambda d: d["about"].update(problem="quarter-horse"),
    "objective": lambda d: d["about"].update(objective="J2"),
    "weights": lambda d: d["about"].update(weights={"J1": 0.5}),
    "a point": lambda d: d["certificate"]["points"].__setitem__(3, "19"),
    "a point outside": lambda d: d["certificate"]["points"].__setitem__(0, "-20"),
    "a pair of points": lambda d: d["certificate"]["points"].__setitem__(slice(2, 4), [["20", "0.5"]]),
    "half a pair": lambda d: d["certificate"]["points"].__setitem__(3, ["20"]),
    "a pair without damping": lambda d: d["certificate"]["points"].__setitem__(slice(2, 4), [["20", "0"]]),
    "a point less": lambda d: d["certificate"]["points"].pop(),
    "damper": lambda d: d["certificate"].update(damper="5001"),
    "negative damper": lambda d: d["certificate"].update(damper="-5000"),
    "an entry": lambda d: d["certificate"]["factor"][0].__setitem__(0, d["certificate"]["factor"][0][0] * 1.05),
    "every entry": lambda d: d["certificate"].update(
        factor=[[3 * v for v in row] for row in d["certificate"]["factor"]]
    ),
    "an entry more": lambda d: d["certificate"]["factor"][1].append(0.0),
    "a text": lambda d: d["certificate"]["factor"][1].__setitem__(0, "1.0"),
    "multipliers": lambda d: d["certificate"].update(multipliers=[[0.0] * 13]),
    "form": lambda d: d["certificate"].update(form="guess"),
    "a key more": lambda d: d.update(comment="trust me"),
    "a key less": lambda d: d.pop("certificate"),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_certificate_fails(plain, name):
    document = json.loads(json.dumps(plain.to_dict()))
    assert from_dict(copy.deepcopy(document)).check() >= plain.value
    EDITS[name](document)
    with pytest.raises(PosrealError):
        from_dict(document).check()


def test_an_edit_that_leaves_the_claim_true_is_told_honestly(plain):
    document = plain.to_dict()
    document["bound"]["value"] = 1.2
    document["best"], document["gap_percent"] = None, None
    assert from_dict(document).check() > 1.37


def test_multipliers_of_the_shared_device_count(lifted):
    document = json.loads(json.dumps(lifted.to_dict()))
    document["certificate"]["multipliers"][0][1] *= 1.2
    with pytest.raises(NotProven):
        from_dict(document).check()


@pytest.mark.parametrize("kind", ["summed", "peak"])
def test_a_stretched_functional_proves_nothing_more(kind, request):
    found = request.getfixturevalue(kind)
    document = json.loads(json.dumps(found.to_dict()))
    rows = document["certificate"]["functional"]
    document["certificate"]["functional"] = [[2 * value for value in row] for row in rows]
    assert from_dict(copy.deepcopy(document)).check() == pytest.approx(
        found.check(), rel=1e-9
    )  # only its direction counts
    document["certificate"]["functional"] = [[-value for value in rows[0]], *rows[1:]]
    with pytest.raises(NotProven):
        from_dict(document).check()
    document["certificate"]["functional"] = [[0.0 for _ in row] for row in rows]
    with pytest.raises(NotProven, match="no functional"):
        from_dict(document).check()
    document["certificate"]["functional"] = rows[:1]
    with pytest.raises(BadInput):
        from_dict(document)


def test_a_plant_of_ones_own(tmp_path):
    # plan view: shaping filter, delays, a port that is not passive, everything as bare matrices
    posed = problem("lateral-comfort")
    named = figure(posed)
    own = BoundedFigure(named.plant, named.mounting, named.weights, "ride", "m/s^2")
    found = bound(own, L=5, omega0=10, best=posed.default_port)
    assert found.value == pytest.approx(bound(posed, L=5, omega0=10).value, rel=1e-6)
    found.save(tmp_path / "own.json")
    again = load_bound(tmp_path / "own.json")
    assert again.check() >= again.value == found.value
    for edit in (
        lambda plant: plant["A"].__setitem__(3, [0.0]),
        lambda plant: plant["Bf"].pop(),
        lambda plant: plant["Bw"][0].append(1.0),
        lambda plant: plant.update(density=-1.0),
        lambda plant: plant.update(delays=[0.0, -0.1]),
        lambda plant: plant.update(outputs="z"),
        lambda plant: plant.update(A=[]),
    ):
        document = json.loads(json.dumps(found.to_dict()))
        edit(document["about"]["plant"])
        with pytest.raises(BadInput):
            from_dict(document)
    document = json.loads(json.dumps(found.to_dict()))
    document["about"]["plant"]["A"][8][1] *= 1.1
    with pytest.raises(PosrealError):
        from_dict(document).check()


def test_a_problem_about_ones_own_plant(tmp_path):
    own = UserPlant(QUARTER_CAR.vehicle.road(), beside=Rational.spring(60000))
    posed = Problem("mine", "ride", own, "rms_acceleration")
    found = bound(posed, L=8, omega0=20, best=evaluate(posed, "c=2600"))
    assert found.value == pytest.approx(bound(QUARTER_CAR, L=8, omega0=20).value, rel=1e-7)
    found.save(tmp_path / "mine.json")
    assert load_bound(tmp_path / "mine.json").check() >= found.value


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "17", '{"format": "posreal bound 1"}', '{"bound": NaN}', "[" * 100_000, "\u00e9" * 10],
    ids=range(8),
)
def test_files_that_are_no_certificate(tmp_path, text):
    path = tmp_path / "bad.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=r"bad\.json"):
        load_bound(path)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(BadInput, match="cannot read"):
        load_bound(tmp_path / "missing.json")
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadInput, match="not a text file"):
        load_bound(tmp_path / "binary.json")


def test_a_certificate_says_what_was_proven():
    """A vehicle that runs at 100 m/s, or a road ten thousand times as rough, is another claim under the same name."""
    fast = bound(SIDE.with_vehicle({"V": 100.0}), L=2, omega0=10)
    lines = fast.described()
    assert "vehicle: side-view of vertical-comfort, with V = 100 m/s, not 55" in lines
    assert any("acceleration_T over all frequencies" in line for line in lines)
    assert any(line.startswith("input: white noise of single-sided density") for line in lines)
    usual = bound(SIDE, L=2, omega0=10)
    assert "vehicle: side-view of vertical-comfort, as it comes" in usual.described()
    about = usual.figure
    rough = dataclasses.replace(about, plant=dataclasses.replace(about.plant, density=1e4 * about.plant.density))
    stated = bound(rough, L=2, omega0=10).described()
    assert any(f"density {1e4 * about.plant.density:.6g} per rad/s" in line for line in stated)
    assert any(line.startswith("plant: one of the file's own, ") for line in stated)


def test_a_gain_has_no_density():
    found = bound(problem("quarter-car", objective="gain_acceleration"), L=4, omega0=20)
    assert "input: any, of any frequency; a gain has no density" in found.described()


def test_text_of_a_file_is_shown_on_its_line(plain):
    document = plain.to_dict()
    document["best"]["label"] = "good\n\x1b[2Jproven again: J1 ≥ 9 m/s^2\u202e"
    shown = str(from_dict(document))
    assert r"good\n\x1b[2Jproven again: J1 ≥ 9 m/s^2\u202e" in shown
    assert all(line.isprintable() for line in shown.split("\n"))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda d: d["bound"].update(value=1e308), "not a number of at most"),
        (lambda d: d["bound"].update(value=10**400), "not a number of at most"),
        (lambda d: d["best"].update(value=0), "gap_percent"),
        (lambda d: d["about"]["vehicle"].update(ms=1e99), "ms"),
        (lambda d: d["certificate"]["factor"][0].__setitem__(0, 1e308), "not a number of at most"),
        (lambda d: d["about"].update(problem=["x"] * 50_000), "problem is"),
    ],
)
def test_numbers_beyond_all_reason_are_refused(plain, change, says):
    document = copy.deepcopy(plain.to_dict())
    change(document)
    with pytest.raises(BadInput, match=says) as caught:
        from_dict(document)
    assert len(str(caught.value)) < 500


def test_a_proof_on_disk_is_replaced_whole_or_not_at_all(plain, tmp_path, monkeypatch):
    path = tmp_path / "proof.json"
    plain.save(path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(BadInput, match="No space left"):
        plain.save(path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["proof.json"]
