"""Commands start at once: none loads what it does not use, and a public name loads its room when first asked for."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import posreal

HEAVY = {"scipy", "control", "matplotlib", "networkx", "rich", "cvxpy", "clarabel", "joblib", "schemdraw", "dask"}
ASK = """
import json, sys
from posreal.cli import app
try:
    app(json.loads(sys.argv[1]))
except SystemExit as end:
    assert end.code in (0, None), end.code
print(json.dumps(sorted(sys.modules)), file=sys.stderr)
"""


def loaded(*words: str) -> list[str]:
    """The modules that a command has loaded when it ends, in a process of its own."""
    run = subprocess.run([sys.executable, "-c", ASK, json.dumps(words)], capture_output=True, text=True, check=True)
    return list(json.loads(run.stderr.splitlines()[-1]))


def packages(modules: list[str]) -> set[str]:
    return {name.partition(".")[0] for name in modules}


@pytest.mark.parametrize("words", [("--help",), ("--version",), ("evaluate", "--help"), ("search", "--help")])
def test_help_and_version_compute_nothing(words):
    modules = loaded(*words)
    assert packages(modules) & (HEAVY | {"numpy", "flint"}) == set()
    assert {name for name in modules if name.startswith("posreal.")} <= {
        "posreal.errors",
        *(name for name in modules if name.startswith("posreal.cli")),
    }


def test_check_loads_admittances_and_the_reading_of_devices():
    modules = loaded("check", "1/(s+1)")
    assert packages(modules) & HEAVY == set()
    rooms = {name.split(".")[1] for name in modules if name.startswith("posreal.")}
    assert rooms <= {"admittance", "cli", "errors", "network", "units", "files"}
    ours = [name for name in modules if name.partition(".")[0] in ("posreal", "numpy", "flint")]
    assert len(ours) < 220
    assert not any(name.startswith(("posreal.network.diagram", "posreal.network.picture")) for name in modules)


def test_realise_loads_no_design_and_no_solver():
    modules = loaded("realise", "(s+1)/(s+2)")  # a ladder; a bridge asks networkx whether it holds together
    assert packages(modules) & HEAVY == set()
    assert not any(name.startswith(("posreal.problems", "posreal.vehicle")) for name in modules)


def test_a_network_draws_itself_though_what_draws_is_loaded_late():
    ask = "import posreal; print(posreal.parse('k=1 | c=2')._repr_html_()[:5])"
    assert subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True).stdout == "<div>\n"


def test_the_public_names_are_there_once_and_for_type_checkers_too():
    tree = ast.parse(Path(posreal.__file__).read_text())
    (typed,) = (node for node in tree.body if isinstance(node, ast.If))
    stubs = {alias.name: node.module for node in typed.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert stubs == posreal._HOME
    assert {*stubs, "__version__"} == set(posreal.__all__)
    assert posreal.__all__ == sorted(posreal.__all__)
    for name, home in stubs.items():
        assert getattr(posreal, name) is getattr(import_module(home), name)
    assert set(posreal.__all__) <= set(dir(posreal))


def test_no_public_name_is_hidden_behind_a_room():
    folder = Path(posreal.__file__).parent
    rooms = {path.stem for path in folder.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert rooms & set(posreal.__all__) == set()


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'florp'"):
        posreal.florp  # noqa: B018
