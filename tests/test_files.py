"""Files are whole or absent, and refusals name the file."""

import os

import pytest

from posreal.errors import BadInput
from posreal.files import require_folder, require_writable, write_whole
from posreal.network import parse
from posreal.network.picture import save_picture


def test_a_file_is_written_whole_or_left_as_it_was(tmp_path, monkeypatch):
    path = write_whole(tmp_path / "a.txt", b"first")
    assert path.read_bytes() == b"first"
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(BadInput, match=r"cannot write .*a\.txt: No space left"):
        write_whole(path, b"second")
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("a.txt", b"first")]


def test_what_cannot_be_written_is_refused_before_any_work(tmp_path):
    assert require_writable(str(tmp_path / "a.PNG"), (".png",)) == tmp_path / "a.PNG"
    (tmp_path / "b.png").mkdir()
    for path, says in (
        ("a.gif", r"cannot write .*a\.gif: its ending says the form, and accepted are \.png or \.svg"),
        ("b.png", "it is a folder; give a file"),
        ("none/c.png", "cannot write into the folder .*none: No such file"),
    ):
        with pytest.raises(BadInput, match=says):
            require_writable(tmp_path / path, (".png", ".svg"))
    require_folder(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["b.png"]


def test_a_picture_in_no_folder_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(BadInput, match="cannot write"):
        save_picture(parse("k=1"), tmp_path / "nowhere" / "a.svg")
