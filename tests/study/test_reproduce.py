"""The reproduction of [Jiang2012]: all rows there, figures drawn, nothing half written."""

from __future__ import annotations

import struct

import pytest

from posreal.errors import BadInput
from posreal.study.figures import FIGURES, draw, writable
from posreal.study.reproduce import reproduce


@pytest.fixture(scope="module")
def reproduction():
    return reproduce(starts=2)


def test_every_row_stands_beside_the_published_one(reproduction):
    assert {number: len(rows) for number, rows in reproduction.tables.items()} == {2: 6, 3: 4, 6: 4}
    for number, rows in reproduction.tables.items():
        digits = {2: 4, 3: 1, 6: 2}[number]
        for row in rows:
            row.optimum.check()
            if row.published is not None:
                printed = row.published.figures[row.metric]
                assert round(row.optimum.metrics[row.metric].value, digits) <= printed
                assert row.at_published.metrics[row.metric].value == pytest.approx(printed, rel=5e-3)


def test_the_text_explains_the_differences(reproduction):
    text = str(reproduction)
    for word in ("2π Al V²", "kN/m", "rounded", "peak on the slope", "6.448 %", "Table 5", "S6", "→ 0"):
        assert word in text
    data = reproduction.to_dict()
    assert len(data["tables"]["2"]) == 6
    assert data["table5"]["J1z_T"]["value"] == pytest.approx(2.2202, abs=1e-4)


@pytest.mark.usefixtures("without_pyplot")
def test_figures(reproduction, tmp_path):
    written = draw(reproduction, tmp_path / "figures")
    assert [path.name for path in written] == list(FIGURES)
    for path in written:
        head = path.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", head[16:24])
        assert width > 600
        assert height > 400
    assert not list((tmp_path / "figures").glob(".*"))


def test_an_unwritable_folder_is_refused_before_any_work(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write figures"):
        writable(tmp_path / "file" / "figures")
