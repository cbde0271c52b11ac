"""Layout files: what S1-S7 say, and how a bad file is refused."""

from __future__ import annotations

import pytest

from posreal.errors import BadDevice, BadInput
from posreal.specification.layout import layout, layouts
from posreal.specification.named import problem
from tests import published

VERTICAL, LATERAL = problem("vertical-comfort"), problem("lateral-comfort")


def test_there_are_seven():
    assert [entry.name for entry in layouts()] == [f"S{i}" for i in range(1, 8)]
    assert all("Jiang2012" in entry.source and entry.description for entry in layouts())


def test_published_rows_are_the_paper_s():
    rows = {(r.table, r.problem, e.name): r for e in layouts() for r in e.published}
    for number, table in ((2, published.TABLE2), (3, published.TABLE3)):
        for row in table:
            found = rows.pop((number, row.problem, row.layout))
            assert {**found.values, **row.values} == found.values
            assert found.vehicle == row.vehicle
            assert list(found.figures.values()) == [row.figure]
    for row in published.TABLE6:
        found = rows.pop((6, "vertical-comfort", row.layout))
        assert found.figures == {"J1z_T": row.T}
        assert tuple(found.improvements_percent.values()) == row.improvements
        assert {**found.values, **row.values} == found.values
    assert not rows


def test_roles_take_their_value_from_the_vehicle():
    lateral = problem("lateral-comfort", vehicle={"Ksy": 3e5})
    assert layout("S3").valued(lateral, {"c": 2e4, "b": 100}).values()["k"] == 3e5
    vertical = problem("vertical-comfort", vehicle={"bush": "6 MN/m"})
    assert layout("S5").valued(vertical, {"c": 2e4, "b": 100}).values()["k"] == 6e6
    assert layout("S5").free_elements(vertical)["k"][1] == 6e6


def test_the_static_spring_is_free_only_where_the_problem_frees_it():
    assert list(layout("S3").free_elements(LATERAL)) == ["c", "b"]
    assert list(layout("S3").free_elements(problem("lateral-gauging"))) == ["k", "c", "b"]


def test_a_layout_that_does_not_fit_is_refused():
    with pytest.raises(BadInput, match=r"S5 contains the bush.*layouts that fit it are S1, S2 or S3"):
        layout("S5").valued(LATERAL, {"c": 1, "b": 1})


def test_a_missing_value_is_named():
    with pytest.raises(BadDevice, match="needs a value for b, such as b=300"):
        layout("S3").valued(LATERAL, {"c": 2e4})


@pytest.mark.parametrize("name", ["S8", "s33", "", "T1"])
def test_unknown_layout(name):
    with pytest.raises(BadInput, match="unknown layout"):
        layout(name)


def test_a_user_s_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('network = "k | (c + k2)"\n[elements.k]\nrole = "static spring"\n')
    mine = layout(path)
    assert mine.name == "mine"
    assert set(mine.free_elements(LATERAL)) == {"c", "k2"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "has no network"),
        ('network = "k | | c"', "network"),
        ('network = "k | c"\nnetwrok = 1', "unknown key 'netwrok'"),
        ('network = "k | c"\n[elements.q]\nfixed = 1', "not in the network"),
        ('network = "k | c"\n[elements.c]\nfixd = 1', "unknown key 'fixd'"),
        ('network = "k | c"\n[elements.c]\nfixed = -1', "above 0"),
        ('network = "k | c"\n[elements.c]\nfixed = "8 kg"', "kg"),
        ('network = "k | c"\n[elements.c]\nbounds = [2, 1]', "lower bound"),
        ('network = "k | c"\n[elements.c]\nbounds = [2]', "list of two"),
        ('network = "k | c"\n[elements.k]\nrole = "sprung"', "unknown role"),
        ('network = "k | c"\n[[published]]\ntable = 2', "a row has"),
        ('network = "k | c"\nelements = 3', "must be tables"),
        ('network = "k | c', "not valid TOML"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, text, says):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        layout(path)
    assert says in str(caught.value)
    assert "bad.toml" in str(caught.value) or "kg" in says
