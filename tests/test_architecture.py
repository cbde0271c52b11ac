"""The rooms and the arrows between them: nothing imports upwards."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "posreal"
MAY_IMPORT = {
    "errors": set(),
    "admittance": {"errors"},
    "text_table": set(),
    "files": {"errors"},
    "units": {"errors", "admittance"},
    "network": {"errors", "admittance", "units", "files"},
    "realise": {"errors", "admittance", "network"},
    "vehicle": {"errors", "admittance", "units"},
    "design": {"errors", "admittance", "network", "units", "vehicle"},
    "study": {"errors", "admittance", "network", "units", "text_table", "files", "vehicle", "realise", "design"},
}


def imported_rooms(path: Path) -> set[str]:
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [node.module or ""]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        rooms |= {name.split(".")[1] for name in names if name.startswith("posreal.")}
    return rooms


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_arrows_go_one_way(room):
    files = [PACKAGE / f"{room}.py"] if (PACKAGE / f"{room}.py").exists() else sorted((PACKAGE / room).rglob("*.py"))
    assert files
    for path in files:
        assert imported_rooms(path) <= MAY_IMPORT[room] | {room}, path


def test_every_room_has_a_rule():
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert rooms - {"__init__", "__main__", "cli"} == set(MAY_IMPORT)
