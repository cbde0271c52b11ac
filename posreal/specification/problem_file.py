"""A problem on a page of TOML: a model or a plant of matrices, and what is asked of it.

``mine.toml`` is the file's one problem, or its first; ``mine.toml:comfort`` is the one under ``[problems.comfort]``. A
file without a problem minimises its first metric.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.files import read_text, toml_document
from posreal.specification.model_file import SECTIONS, ModelReader
from posreal.specification.plant_file import plant_problem
from posreal.specification.problem import Problem
from posreal.vehicle.modelled import Modelled

_ASKED = re.compile(r"(?P<path>.*\.toml)(?::(?P<name>[\w-]+))?", re.DOTALL | re.IGNORECASE)
_KEYS = ("minimise", "keep", "limits", "summary")


@dataclass(frozen=True)
class Asked:
    """What a file asks for.

    Attributes
    ----------
    name : str
        The file's, without folder and ending, and that of the problem where the file has several.
    vehicle : Vehicle
    minimise : str
        A metric, or a weighted sum of some.
    keep : tuple of str
    limits : mapping of metric to number
    summary : str
    wrong : function of (key, complaint)
        The error that names the line of a key of the problem.
    """

    name: str
    vehicle: Modelled
    minimise: str
    keep: tuple[str, ...]
    limits: Mapping[str, float]
    summary: str
    wrong: Callable[[str, object], BadInput]


def is_problem_file(text: str) -> bool:
    """Whether this is no problem's name but a file with a problem."""
    return _ASKED.fullmatch(text) is not None


def read_problem(text: str) -> Asked | Problem:
    """The problem of a file: made already where it is about a plant of matrices.

    Raises
    ------
    BadInput
        Naming the file, the line and the key.
    """
    match = _ASKED.fullmatch(text)
    assert match is not None
    path = Path(match["path"])
    if match["name"] is not None and not path.exists() and os.path.exists(text):
        path = Path(text)
    content = read_text(path)
    document = toml_document(content, path)
    reader = ModelReader(path, document, content)
    if "plant" in document:
        if match["name"] is not None:
            raise BadInput(f"{plain(path)} has one problem, and no name goes with it")
        return plant_problem(path, document, reader.known, reader.wrong)
    reader.known((), document, (*SECTIONS, "name", "description", "problem", "problems"))
    vehicle = reader.vehicle()
    keys, table, name = _chosen(reader, document, match["name"])
    reader.known(keys, table, _KEYS)
    metrics = vehicle.metrics
    minimise = table.get("minimise", vehicle.headline[0])
    if not isinstance(minimise, str):
        raise reader.wrong((*keys, "minimise"), f"the name of a metric is wanted: {listed(metrics)}")
    keep = table.get("keep", [])
    if not isinstance(keep, list) or not all(isinstance(one, str) and one in metrics for one in keep):
        raise reader.wrong((*keys, "keep"), f"a list of metrics is wanted, of {listed(metrics)}")
    if keep and not next(iter(vehicle.places.values())).has_default:
        raise reader.wrong((*keys, "keep"), "nothing can be kept where the place has no default device to compare with")
    limits = table.get("limits", {})
    good = isinstance(limits, dict) and all(
        isinstance(x, int | float) and not isinstance(x, bool) and 0 < x < 1e300 for x in limits.values()
    )
    if not good:
        raise reader.wrong((*keys, "limits"), "a table of metrics and numbers above 0 is wanted, in the metrics' units")
    summary = table.get("summary", document.get("description", ""))
    if not isinstance(summary, str):
        raise reader.wrong((*keys, "summary"), "text is wanted")
    return Asked(
        name=f"{path.stem}:{name}" if name else path.stem,
        vehicle=vehicle,
        minimise=minimise,
        keep=tuple(keep),
        limits={one: float(x) for one, x in limits.items()},
        summary=plain(summary or f"least {minimise}", 200),
        wrong=lambda key, complaint: reader.wrong((*keys, key), complaint),
    )


def _chosen(
    reader: ModelReader, document: Mapping[str, Any], name: str | None
) -> tuple[tuple[str, ...], Mapping[str, Any], str]:
    """Where the problem stands, its table, and its name where it has one."""
    several = reader.section("problems")
    if "problem" in document and several:
        raise reader.wrong(("problem",), "give one [problem], or several as [problems.NAME]")
    if name is None and not several:
        table = document.get("problem", {})
        if not isinstance(table, dict):
            raise reader.wrong(("problem",), "a table [problem] is wanted")
        return ("problem",), table, ""
    if not several:
        raise BadInput(f"{plain(reader.path)} has no [problems.{plain(name, 40)}]")
    chosen = next(iter(several)) if name is None else name
    if chosen not in several:
        raise BadInput(f"{plain(reader.path)} has no problem {shown(chosen)}; {hint(chosen, several)}")
    return ("problems", chosen), reader.table("problems", chosen, several[chosen]), chosen
