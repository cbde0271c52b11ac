"""The rooms and the arrows between them: nothing imports upwards, and no files import each other in a circle."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "posreal"
BELOW = {
    "errors",
    "admittance",
    "numerics",
    "units",
    "files",
    "text_table",
    "ranges",
    "real_elements",
    "network",
    "plant",
    "metric",
    "vehicle",
}
MAY_IMPORT = {
    "errors": set(),
    "numerics": {"errors"},
    "admittance": {"errors", "numerics"},
    "text_table": {"errors"},
    "files": {"errors"},
    "units": {"errors", "admittance"},
    "ranges": {"errors", "files", "units"},
    "real_elements": {"errors", "files", "units"},
    "network": {"errors", "admittance", "units", "files", "ranges", "real_elements"},
    "realisation": {"errors", "admittance", "network"},
    "plant": {"errors", "admittance"},
    "metric": {"errors", "admittance", "plant"},
    "vehicle": {"errors", "files", "admittance", "units", "ranges", "real_elements", "plant", "metric"},
    "specification": BELOW,
    "bounds": BELOW | {"specification"},
    "optimisation": BELOW | {"specification", "bounds"},
    "topology": BELOW | {"specification", "bounds", "optimisation"},
    "synthesis": BELOW | {"specification", "bounds", "optimisation"},
    "simulation": BELOW | {"specification"},
    "study": BELOW | {"realisation", "specification", "bounds", "optimisation", "topology", "synthesis", "simulation"},
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


def module(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_files(path: Path, known: set[str]) -> set[str]:
    """The modules a file imports when it runs, at its top or inside a function; a name that is a file is that file."""
    found, waiting = set(), [ast.parse(path.read_text())]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            waiting.extend(node.orelse)
            continue
        if isinstance(node, ast.ImportFrom):
            files = {f"{node.module}.{alias.name}" for alias in node.names} & known
            found |= files
            if len(files) < len(node.names):
                found.add(str(node.module))
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        waiting.extend(ast.iter_child_nodes(node))
    return found & known


def reached(start: str, arrows: dict[str, set[str]]) -> set[str]:
    """Every file to which arrows lead from this one."""
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        for name in arrows[waiting.pop()] - seen:
            seen.add(name)
            waiting.append(name)
    return seen


def circles(arrows: dict[str, set[str]]) -> set[frozenset[str]]:
    beyond = {name: reached(name, arrows) for name in arrows}
    return {
        frozenset(other for other in beyond[name] if name in beyond[other]) for name in arrows if name in beyond[name]
    }


def test_no_files_import_each_other_in_a_circle():
    paths = {module(path): path for path in PACKAGE.rglob("*.py")}
    found = circles({name: imported_files(path, set(paths)) for name, path in paths.items()})
    assert not found, "\n".join(", ".join(sorted(circle)) for circle in found)


@pytest.mark.parametrize(
    ("name", "files"),
    [
        ("deflection_velocity_rms", {"vehicle/side_view.py"}),  # a metric
        ("manchester", {"vehicle/manchester.py", "specification/named.py"}),  # a vehicle
    ],
)
def test_what_an_addition_touches(name, files):
    """No file of a solver, of a bound or of the command line knows a metric or a vehicle."""
    found = {str(path.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.py") if name in path.read_text().lower()}
    assert found == files


def test_a_circle_is_seen():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set()}) == {frozenset("abc")}
    assert circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == set()


def test_no_two_classes_have_one_name():
    names = [
        node.name
        for path in PACKAGE.rglob("*.py")
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.ClassDef)
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []


def test_one_bibliography():
    """Every key that a docstring or a page cites is in docs/references.md, and every entry is cited."""
    root = PACKAGE.parent
    known = set(re.findall(r"^- \*\*\[(\w+)\]", (root / "docs" / "references.md").read_text(), re.MULTILINE))
    pages = [path for path in (*root.glob("docs/*.md"), root / "README.md") if path.name != "references.md"]
    texts = [path.read_text() for path in (*PACKAGE.rglob("*.py"), *pages)]
    cited = {key for text in texts for key in re.findall(r"\[([A-Z][A-Za-z]+\d{4})\]", text)}
    assert cited <= known
    assert [key for key in sorted(known) if not any(key in text for text in texts)] == []
