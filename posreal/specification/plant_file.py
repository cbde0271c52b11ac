"""A problem about matrices from a file: a page of TOML says which signal is what; docs/models.md describes it.

[plant]     file, and the names of its matrices A, B, C, D and of its signals; disturbances, force, velocity,
            performance, delays, density, units, terminals, beside, behind
[problem]   objective ("rms" or "gain"), weights, limits, summary
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from posreal.errors import BadInput, PosrealError, shown
from posreal.specification.from_plant import problem_from_plant
from posreal.specification.matrices_file import MatricesFile
from posreal.specification.problem import Problem

_FILE = ("file", "A", "B", "C", "D", "inputs", "outputs")
_ROLES = ("disturbances", "force", "velocity", "performance")
_SETTINGS = ("delays", "density", "units", "terminals", "beside", "behind")
_ASKED = ("objective", "weights", "limits", "summary")
SECTIONS = ("plant", "problem", "description", "name")

Keys = tuple[Any, ...]
Wrong = Callable[[Keys, object], BadInput]


@dataclass
class NamedSystem:
    """A continuous state space with named signals."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    input_labels: list[str]
    output_labels: list[str]
    dt: float = 0.0


def plant_problem(
    path: Path,
    document: Mapping[str, Any],
    known: Callable[[Keys, Mapping[str, Any], tuple[str, ...]], None],
    wrong: Wrong,
) -> Problem:
    """The problem of a page with a table ``[plant]``.

    Parameters
    ----------
    path : Path
        Of the page; the file of matrices is beside it unless its path is absolute.
    document : mapping
        The page.
    known : function of (keys, table, accepted)
        Refuses other keys.
    wrong : function of (keys, complaint)
        The error that names the line.

    Raises
    ------
    BadInput, NotPositiveReal
    """
    known((), document, SECTIONS)
    plant = _table(document, "plant", wrong)
    asked = _table(document, "problem", wrong)
    known(("plant",), plant, (*_FILE, *_ROLES, *_SETTINGS))
    known(("problem",), asked, _ASKED)
    system = _system(path, plant, wrong)
    for key in _ROLES:
        if key not in plant:
            raise wrong(("plant",), f"{key} is wanted: the names of signals, of {_said(key, system)}")
    _check(plant, asked, wrong)
    given = {key: plant[key] for key in (*_ROLES, *_SETTINGS) if key in plant}
    given |= {key: asked[key] for key in ("objective", "weights", "limits") if key in asked}
    try:
        made = problem_from_plant(system, name=path.stem, **given)
    except PosrealError as error:
        raise type(error)(str(wrong(("plant", *_blamed(str(error), plant)), error))) from None
    summary = asked.get("summary", document.get("description", ""))
    return made if not summary else _with_summary(made, str(summary))


def _with_summary(made: Problem, summary: str) -> Problem:
    return replace(made, summary=summary[:200])


def _table(document: Mapping[str, Any], name: str, wrong: Wrong) -> Mapping[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise wrong((name,), f"a table [{name}] is wanted")
    return table


def _said(key: str, system: NamedSystem) -> str:
    names = system.input_labels if key in ("disturbances", "force") else system.output_labels
    return ", ".join(names[:12])


def _system(path: Path, plant: Mapping[str, Any], wrong: Wrong) -> NamedSystem:
    if not isinstance(plant.get("file"), str):
        raise wrong(("plant",), "file is wanted, the matrices: .mat, .npz or .json")
    try:
        file = MatricesFile(path.parent / plant["file"])
    except BadInput as error:
        raise wrong(("plant", "file"), error) from None
    parts: dict[str, np.ndarray] = {}
    for name in "ABCD":
        called = plant.get(name, name)
        if not isinstance(called, str):
            raise wrong(("plant", name), "the name of a variable is wanted")
        try:
            if name == "D" and "D" not in plant and "D" not in file:
                parts[name] = np.zeros((len(parts["C"]), parts["B"].shape[1]))
            else:
                parts[name] = file.matrix(called, column=name == "B")
        except BadInput as error:
            raise wrong(("plant", name if name in plant else "file"), error) from None
    n, m, p = len(parts["A"]), parts["B"].shape[1], len(parts["C"])
    if parts["D"].size == m * p and 1 in (m, p):  # a list of numbers may be either
        parts["D"] = parts["D"].reshape(p, m)
    shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m)}
    for name, shape in shapes.items():
        if parts[name].shape != shape:
            there, wanted = (" by ".join(map(str, each)) for each in (parts[name].shape, shape))
            raise wrong(
                ("plant", name if name in plant else "file"), f"{name} is {there}, and {wanted} fits the others"
            )
    labels: dict[str, list[str]] = {}
    for key, count in (("inputs", m), ("outputs", p)):
        labels[key] = _labels(file, plant, key, wrong)
        if len(labels[key]) != count or len(set(labels[key])) != count:
            raise wrong(("plant", key), f"{count} different names are wanted, and {len(labels[key])} are given")
    sampled = next((name for name in ("dt", "Ts") if name in file), None)
    if sampled is not None and float(np.max(np.abs(file.matrix(sampled)))) > 0:
        raise wrong(("plant", "file"), f"{sampled} says that the plant is sampled; give a continuous one")
    A, B, C, D = parts.values()
    return NamedSystem(A, B, C, D, labels["inputs"], labels["outputs"])


def _labels(file: MatricesFile, plant: Mapping[str, Any], key: str, wrong: Wrong) -> list[str]:
    given = plant.get(key)
    if isinstance(given, list):
        if not all(isinstance(one, str) and 0 < len(one) <= 60 for one in given):
            raise wrong(("plant", key), "a list of names is wanted")
        return given
    if given is not None and not isinstance(given, str):
        raise wrong(("plant", key), "a list of names is wanted, or the name of a variable that has one")
    if given is None and key not in file:
        raise wrong(("plant",), f"{key} is wanted, the names of the {key} in their order: {key} = ['…', '…']")
    try:
        return file.names(given or key)
    except BadInput as error:
        raise wrong(("plant", key if given else "file"), error) from None


def _check(plant: Mapping[str, Any], asked: Mapping[str, Any], wrong: Wrong) -> None:
    """That every entry has the type that is meant; what it says is looked at where the problem is made."""
    for key in ("force", "velocity", "performance"):
        if not _is_names(plant[key]):
            raise wrong(("plant", key), "a name or a list of names is wanted")
    one = plant["disturbances"]
    if not (_is_names(one) or (isinstance(one, list) and one and all(_is_names(part) for part in one))):
        raise wrong(
            ("plant", "disturbances"),
            'names are wanted, and lists of those that share a process: [["front", "rear"], "wind"]',
        )
    for keys, table, key in (
        (("plant", "delays"), plant, "delays"),
        (("plant", "density"), plant, "density"),
        (("problem", "weights"), asked, "weights"),
        (("problem", "limits"), asked, "limits"),
    ):
        value = table.get(key, {})
        single = key == "density" and _is_number(value)
        if not single and not (isinstance(value, dict) and all(_is_number(x) for x in value.values())):
            raise wrong(keys, f"a table of names and numbers is wanted, not {shown(value)}")
    units = plant.get("units", {})
    if not (isinstance(units, dict) and all(isinstance(unit, str) and 0 < len(unit) < 40 for unit in units.values())):
        raise wrong(("plant", "units"), "a table of outputs and the units of their numbers is wanted")
    ends = plant.get("terminals", ["+", "-"])
    if not (
        isinstance(ends, list) and len(ends) == 2 and all(isinstance(end, str) and 0 < len(end) < 40 for end in ends)
    ):
        raise wrong(("plant", "terminals"), "two names are wanted")
    for key in ("beside", "behind"):
        if not isinstance(plant.get(key, ""), str):
            raise wrong(("plant", key), "a device is wanted, such as 'k=60 kN/m'")
    if not isinstance(asked.get("objective", "rms"), str):
        raise wrong(("problem", "objective"), "rms or gain is wanted")


def _is_names(given: Any) -> bool:
    items = [given] if isinstance(given, str) else given
    return isinstance(items, list) and bool(items) and all(isinstance(item, str) for item in items)


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool) and abs(given) < 1e300


def _blamed(text: str, plant: Mapping[str, Any]) -> Keys:
    """The entry that a complaint is about, where a signal that it quotes is named by one alone."""
    quoted = [part for i, part in enumerate(text.split("'")) if i % 2]
    named = [key for key in (*_ROLES, "delays", "units") if key in plant]
    found = [key for key in named if any(name in _flat(plant[key]) for name in quoted)]
    return (found[0],) if len(found) == 1 else ()


def _flat(given: Any) -> list[str]:
    if isinstance(given, str):
        return [given]
    return [name for part in given for name in _flat(part)]
