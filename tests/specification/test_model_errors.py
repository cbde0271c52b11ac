"""A page that is not a model is refused in a sentence that names the file, the line and the key."""

from __future__ import annotations

import string
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import posreal as pr
from posreal.errors import BadInput
from posreal.specification.model_text import admittance_text
from posreal.specification.toml_lines import line_of
from posreal.vehicle.expression import admittance, linear, number

PAGE = """[parameters]
ms = "250 kg"
k = "60 kN/m"
[coordinates]
zs = "ms"
zu = 35
[connections]
tyre = { between = "zu - road", stiffness = "150 kN/m" }
[places.strut]
between = "zs - zu"
static_spring = "k"
[inputs]
road = { quantity = "velocity", density = 1e-3 }
[outputs]
acceleration = { acceleration = "zs" }
load = { force = "tyre" }
[metrics]
J1 = { rms = "acceleration" }
[problem]
minimise = "J1"
"""


def page(tmp_path: Path, old: str = "", new: str = "") -> str:
    assert old in PAGE
    path = tmp_path / "mine.toml"
    path.write_text(PAGE.replace(old, new, 1))
    return str(path)


def test_the_page_itself_is_a_model(tmp_path):
    problem = pr.problem(page(tmp_path))
    assert (problem.name, problem.objective) == ("mine", "J1")
    assert problem.vehicle.ms == 250
    named = pr.problem(page(tmp_path, "[problem]", "[problems.ride]") + ":ride")
    assert named.name == "mine:ride"
    assert pr.problem(page(tmp_path, '[problem]\nminimise = "J1"', "")).objective == "J1"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('ms = "250 kg"', 'ms = "250 kgg"', "line 2: parameters.ms: .*not known"),
        ('ms = "250 kg"', "ms = [1]", "line 2: parameters.ms: a number or text with a unit"),
        ('ms = "250 kg"', 'ms = "-250 kg"', "ms .* is -250 kg; it must be finite"),
        (
            'ms = "250 kg"',
            'ms = { value = 250, unitt = "kg" }',
            "line 2: parameters.ms.unitt: unknown key; did",
        ),
        ('ms = "250 kg"', 'plant = "250 kg"', "line 2: parameters.plant: .*another meaning"),
        ('ms = "250 kg"', '"m s" = 3', "line 2.*a letter, followed by"),
        ('zs = "ms"', 'zs = "mss"', "line 5: coordinates.zs: 'mss' is not known; did you mean ms"),
        ('zs = "ms"', 'zs = "ms*s"', "line 5: coordinates.zs: .*depends on s"),
        ('zs = "ms"', 'ms = "ms"', "line 5: coordinates.ms: the name ms is taken"),
        ("zu = 35", "zu = 0", "line 6: coordinates.zu: zu has no mass"),
        ("zu = 35", "zu = -1", "line 6: coordinates.zu: .*at least 0"),
        ('"zu - road"', '"zu - rod"', "line 8: connections.tyre.between: 'rod' is not known; did you mean road"),
        ('"zu - road"', '"zu*zs"', "line 8: connections.tyre.between: .*not linear"),
        ('"zu - road"', '"zu - 1"', "line 8: connections.tyre.between: .*part without a coordinate"),
        ('"zu - road"', '"0*zu"', "line 8: connections.tyre.between: .*nothing but 0"),
        ('"zu - road"', '"1/zu"', "line 8: connections.tyre.between: .*division by zero"),
        ("stiffness =", "stifness =", "line 8: connections.tyre.stifness: unknown key; did you mean stiffness"),
        (', stiffness = "150 kN/m"', "", "line 8: connections.tyre: one of stiffness"),
        ("stiffness =", "inertance =", "line 8: connections.tyre: an inerter to an input"),
        ('tyre = { between = "zu - road", stiffness = "150 kN/m" }', "tyre = 3", "line 8: connections.tyre: a table"),
        ('"zs - zu"', '"zs - road"', "line 10: places.strut.between: .*an input in it"),
        ('"k"', '"kk"', "line 11: places.strut.static_spring: the name of a parameter"),
        ('between = "zs - zu"\n', "", "line 9: places.strut: give between"),
        ("velocity", "speed", "line 13: inputs.road.quantity: accepted are velocity"),
        ("velocity", "acceleration", ""),
        ("velocity", "displacement", "line 13: inputs.road: .*through a filter"),
        ("density = 1e-3", "density = 0", "line 13: inputs.road.density: .*above 0"),
        ("density = 1e-3", 'filter = "1/s"', "line 13: inputs.road.filter: .*an integrator"),
        ("density = 1e-3", 'filter = "s"', "line 13: inputs.road.filter: .*fall off"),
        ("density = 1e-3", "delay = 1", "line 13: inputs.road.delay: a delay is of an input that follows"),
        ("density = 1e-3", 'follows = "rod"', "line 13: inputs.road.follows: the name of an input"),
        ('acceleration = "zs"', 'displacement = "zs"', "line 15: outputs.acceleration.displacement: .*itself"),
        ('force = "tyre"', 'force = "tire"', "line 16: outputs.load.force: .*did you mean tyre"),
        (
            'rms = "acceleration"',
            'rms = "accel"',
            "line 18: metrics.J1.rms: there is no output 'accel'; accepted",
        ),
        ('rms = "acceleration"', 'rms = "acceleration", unit = "g"', "line 18: metrics.J1: factor is wanted"),
        ('rms = "acceleration"', 'sum = "J2 + J3"', "line 18: metrics.J1.sum: 'J2' is no metric above"),
        ('rms = "acceleration"', 'rms = "load", peak = "load"', "line 18: metrics.J1: one of"),
        ('rms = "acceleration"', 'peak = "load"', "line 18: metrics.J1.corners: a peak is after ramps"),
        ('minimise = "J1"', 'minimise = "J2"', "line 20: problem.minimise: objective 'J2' does not fit"),
        ('minimise = "J1"', 'keep = ["J1"]', "line 20: problem.keep: nothing can be kept"),
        ('minimise = "J1"', "limits = { J2 = 3 }", "line 20: problem.limits: 'J2' cannot be limited"),
        ('minimise = "J1"', "limits = { J1 = -3 }", "line 20: problem.limits: .*above 0"),
        ("[problem]", "[problm]", "line 19: problm: unknown key; did you mean problem"),
        ("[inputs]", "[inputz]", "line 12: inputz: unknown key; did you mean inputs"),
        ("[coordinates]", "[coordinates", "not valid TOML"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, old, new, said):
    path = page(tmp_path, old, new)
    if not said:
        assert pr.problem(path).plant.Dzw.shape == (2, 1)
        return
    with pytest.raises(BadInput, match=f"mine.toml.*{said}") as error:
        pr.problem(path)
    assert "\n" not in str(error.value)


def test_a_ground_that_is_accelerated_moves_no_damper(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        PAGE.replace("velocity", "acceleration").replace(
            'stiffness = "150 kN/m" }', 'stiffness = "150 kN/m" }\nsky = { between = "zs", damping = 10 }'
        )
    )
    with pytest.raises(BadInput, match=r"line 14: inputs.road.quantity: a damper feels the velocity of road"):
        pr.problem(str(path))


def test_a_missing_file_and_a_missing_problem(tmp_path):
    with pytest.raises(BadInput, match=r"cannot read .*none.toml"):
        pr.problem(str(tmp_path / "none.toml"))
    with pytest.raises(BadInput, match=r"has no \[problems.ride\]"):
        pr.problem(page(tmp_path) + ":ride")
    with pytest.raises(BadInput, match="no problem 'rid'; did you mean ride"):
        pr.problem(page(tmp_path, "[problem]", "[problems.ride]") + ":rid")


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 20), st.text(alphabet=string.printable, max_size=30))
def test_any_line_is_read_or_refused(tmp_path_factory, at, line):
    path = tmp_path_factory.mktemp("pages") / "mine.toml"
    lines = PAGE.splitlines()
    lines[at : at + 1] = [line]
    path.write_text("\n".join(lines))
    with suppress(BadInput):
        pr.problem(str(path))


def test_lines_are_found_under_every_way_of_writing_a_table():
    text = '[a]\nb.c = 1\n"d e" = 2\n[a.f]\ng = { h = 3 }\n# [a.x]\n[z]\n'
    found = [line_of(text, path) for path in (("a", "b", "c"), ("a", "d e"), ("a", "f", "g", "h"), ("z",), ("q",))]
    assert found == [2, 3, 5, 7, None]


def test_expressions():
    names = {"k": Fraction(3), "lvx": Fraction(19, 2)}
    assert number("2 k/(1+1)", names) == 3
    assert number("20 Hz", names) == pytest.approx(40 * 3.141592653589793, rel=1e-15)
    assert linear("2*(z1 - lvx*z2)/4", ["z1", "z2"], names) == [0.5, -4.75]
    assert str(admittance("k/s + 2", names)) == "(2*s + 3)/s"
    for text in ("k | c=2", "k=3 | c1=2 N s/m", "c=2 | k1=k"):
        assert admittance(admittance_text(text, names), names) == admittance("k/s + 2", names)
    series = admittance(admittance_text("k1=k + (c=2 | b=5 kg)", names), names)
    assert series == pr.parse("k=3 + (c=2 | b=5)").admittance()
    with pytest.raises(BadInput, match=r"c in 'k \| c' has no value"):
        admittance_text("k | c", names)
