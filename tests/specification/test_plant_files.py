"""Matrices from files, with a page that says which signal is what: the quarter-car again, from every form."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import posreal as pr
from posreal.errors import BadInput, NotPositiveReal

MS, MU, KT = 250.0, 35.0, 150e3
A = np.array([[0, 0, 1, -1], [0, 0, 0, 1], [0, 0, 0, 0], [0, -KT / MU, 0, 0]])
B = np.array([[0, 0], [-1, 0], [0, -1 / MS], [0, 1 / MU]])
C = np.array([[0, 0, 0, 0], [0, KT, 0, 0], [0, 0, 1, -1]])
D = np.array([[0, -1 / MS], [0, 0], [0, 0]])
INPUTS, OUTPUTS = ["road", "push"], ["body", "tyre", "stroke rate"]
PAGE = """[plant]
file = "quarter.{ending}"
disturbances = "road"
force = "push"
velocity = "stroke rate"
performance = "body"
density = 1.5707963267948966e-4
beside = "k=60 kN/m"
units = {{ body = "m/s^2", tyre = "N" }}
terminals = ["body", "wheel"]
[problem]
limits = {{ rms_tyre = 600 }}
"""


def write(folder, ending, **changed):
    parts = {"A": A, "B": B, "C": C, "D": D, "inputs": INPUTS, "outputs": OUTPUTS} | changed
    parts = {name: part for name, part in parts.items() if part is not None}
    path = folder / f"quarter.{ending}"
    if ending == "mat":
        cells = {name: np.array(part, dtype=object) if isinstance(part, list) else part for name, part in parts.items()}
        savemat(path, cells, do_compression=True)
    elif ending == "npz":
        np.savez(path, **parts)
    else:
        path.write_text(
            json.dumps({n: part.tolist() if hasattr(part, "tolist") else part for n, part in parts.items()})
        )
    page = folder / "mine.toml"
    page.write_text(PAGE.format(ending=ending))
    return page


@pytest.mark.parametrize("ending", ["mat", "npz", "json"])
def test_every_form_says_the_same(tmp_path, ending):
    problem = pr.problem(str(write(tmp_path, ending)))
    found = pr.evaluate(problem, "b=300 + c=3224")
    known = pr.evaluate("quarter-car", "b=300 + c=3224")
    assert found.metrics["rms_body"].value == pytest.approx(known.metrics["J1"].value, rel=1e-10)
    assert found.metrics["rms_tyre"].value == pytest.approx(known.metrics["J3"].value, rel=1e-10)
    assert found.metrics["rms_tyre"].unit == "N"
    assert problem.place.terminals == ("body", "wheel")
    assert [str(c) for c in problem.constraints] == ["rms_tyre <= 600 (a limit)"]


def test_structs_character_matrices_and_lists(tmp_path):
    """As other people save them: fields of a struct, names in a padded character matrix, no D, a list for a column."""
    page = write(tmp_path, "mat", A=None, B=None, C=None, D=None, inputs=np.array(INPUTS), outputs=np.array(OUTPUTS))
    whole = {
        "plant": {"A": A, "B": B, "C": C, "D": D},
        "inputs": np.array(INPUTS),
        "z": np.array(OUTPUTS, dtype=object),
    }
    savemat(tmp_path / "quarter.mat", whole)
    fields = "".join(f'{name} = "plant.{name}"\n' for name in "ABCD")
    page.write_text(page.read_text().replace("disturbances", f'{fields}outputs = "z"\ndisturbances'))
    assert pr.problem(str(page)).plant.outputs == ("body", "tyre")
    one = tmp_path / "one.json"
    one.write_text(
        '{"A": [[0, 1], [-4, 0]], "B": [[1, 0], [0, 1]], "C": [0, 1], "inputs": ["w", "f"], "outputs": ["v"]}'
    )
    own = tmp_path / "own.toml"
    own.write_text('[plant]\nfile = "one.json"\ndisturbances = "w"\nforce = "f"\nvelocity = "v"\nperformance = "v"\n')
    with pytest.raises(BadInput, match=r"own.toml, line 1: plant: every output is the velocity of a port"):
        pr.problem(str(own))


def test_searches_take_the_page(tmp_path):
    page = str(write(tmp_path, "npz"))
    assert pr.synthesise(page, 1, starts=2).objective.value == pytest.approx(1.585094, rel=1e-5)
    found = pr.search(page, 2, checkpoint=tmp_path / "kept.jsonl")
    assert found.best.objective.value == pytest.approx(1.585094, rel=1e-5)
    assert pr.bound(page, L=10, omega0=20.0).value < 1.4145


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("quarter.json", "quarter.xyz", "line 2: plant.file: .*ends in none of"),
        ("quarter.json", "nothing.json", "line 2: plant.file: cannot read"),
        ('force = "push"', 'force = "pull"', "line 4: plant.force: the plant has no input 'pull'; it has road or push"),
        ('force = "push"', 'forces = "push"', "line 4: plant.forces: unknown key; did you mean force"),
        ('force = "push"\n', "", "line 1: plant: force is wanted.*road, push"),
        ('force = "push"', "force = 3", "line 4: plant.force: a name or a list"),
        ('"road"', "[[]]", "line 3: plant.disturbances: names are wanted"),
        ('"stroke rate"', '"body"', "line 1: plant: .*answers an input at once"),
        ("1.5707963267948966e-4", "0", "line 1: plant: the density of road is 0"),
        ("k=60 kN/m", "k=60 kN", "line 1: plant: .*measures something else"),
        ("rms_tyre", "rms_tire", "line 1: plant: 'rms_tire' cannot be limited"),
        ("limits", "limit", "line 12: problem.limit: unknown key; did you mean limits"),
        ("tyre =", "tire =", "line 1: plant.*no output 'tire'|line 9: plant.units.*no output 'tire'"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, old, new, said):
    page = write(tmp_path, "json")
    assert old in page.read_text()
    page.write_text(page.read_text().replace(old, new, 1))
    with pytest.raises(BadInput, match=f"mine.toml.*({said})"):
        pr.problem(str(page))


@pytest.mark.parametrize("ending", ["mat", "npz", "json"])
@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"A": None}, "no variable 'A'"),
        ({"B": np.ones((3, 2))}, "B is 3 by 2, and 4 by 2 fits"),
        ({"A": np.array([["a", "b"]])}, "not a matrix of real numbers"),
        ({"inputs": ["a", "b", "c"]}, "line .*plant.inputs|2 different names"),
        ({"outputs": None}, "outputs is wanted"),
        ({"dt": np.array([[0.1]])}, "dt says that the plant is sampled"),
    ],
)
def test_a_file_of_other_matrices_is_refused(tmp_path, ending, changed, said):
    with pytest.raises(BadInput, match=said):
        pr.problem(str(write(tmp_path, ending, **changed)))


@pytest.mark.parametrize(
    ("ending", "content"),
    [
        ("mat", b"not one"),
        ("mat", b"MATLAB 7.3 MAT-file" + bytes(200)),
        ("npz", b"PK\x03\x04 and no more"),
        ("json", b"[1, 2]"),
        ("json", b"\xff\xfe"),
        ("json", b"{"),
    ],
)
def test_what_is_no_such_file_is_refused(tmp_path, ending, content):
    page = write(tmp_path, ending)
    (tmp_path / f"quarter.{ending}").write_bytes(content)
    with pytest.raises(BadInput, match=r"mine.toml, line 2: plant.file"):
        pr.problem(str(page))


def test_nothing_is_unpickled(tmp_path):
    page = write(tmp_path, "npz")
    np.savez(tmp_path / "quarter.npz", A=np.array([{"a": 1}], dtype=object))
    with pytest.raises(BadInput, match=r"Object arrays|pickle"):
        pr.problem(str(page))


def test_a_file_that_grows_is_refused_before_it_does(tmp_path):
    page = write(tmp_path, "mat", A=np.zeros((6000, 6000)))
    assert (tmp_path / "quarter.mat").stat().st_size < 1e6
    with pytest.raises(BadInput, match="more than 20000000 numbers"):
        pr.problem(str(page))
    write(tmp_path, "npz")
    np.savez_compressed(tmp_path / "quarter.npz", A=np.zeros((6000, 6000)))
    with pytest.raises(BadInput, match="more than 20000000 numbers"):
        pr.problem(str(page))


def test_what_stands_beside_is_passive(tmp_path):
    page = write(tmp_path, "json")
    page.write_text(page.read_text().replace("k=60 kN/m", "-60000/s"))
    with pytest.raises(NotPositiveReal, match=r"mine.toml, line 1: plant"):
        pr.problem(str(page))


def test_the_example_is_the_quarter_car():
    page = Path(__file__).parents[2] / "examples" / "plants" / "quarter_car.toml"
    found, known = pr.evaluate(str(page), "c=1500"), pr.evaluate("quarter-car", "c=1500")
    assert found.objective.value == pytest.approx(known.objective.value, rel=1e-10)
