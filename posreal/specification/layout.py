"""Fixed layouts: networks with known form and free element values, one TOML file each.

A layout is the whole suspension strut: where the vehicle's own static spring or bush is part of it, that element has
a *role* and takes its value from the vehicle. A file reads::

    network = "k | (c + b)"
    source = "where it comes from"
    description = "one line"
    [elements.k]
    role = "static spring"                 # or "bush"
    bounds = ["50 kN/m", "1000 kN/m"]      # of the optimiser; a number, text with a unit, or a role
    [elements.c]
    bounds = ["100 N s/m", "1000 kN s/m"]  # or: fixed = "8 kN s/m"
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from posreal.errors import BadDevice, BadInput, hint, listed, plain, shown
from posreal.files import read_toml
from posreal.network import Network, parse
from posreal.specification.problem import Problem
from posreal.units import quantity

ROLES = ("static spring", "bush")
_LEAST, _MOST = 1e-15, 1e15  # of an element, SI units
_UNITS = {"k": "N/m", "c": "N*s/m", "b": "kg"}
_WIDEST = {"k": (1e3, 1e9), "c": (1.0, 1e7), "b": (0.1, 1e6)}
"""Bounds of an element for which a file gives none: what a road or rail vehicle could carry."""


@dataclass(frozen=True)
class ElementRule:
    """What a layout says of one element: its role, a fixed value, or bounds; text stands for a role's value."""

    role: str | None = None
    fixed: float | str | None = None
    bounds: tuple[float | str, float | str] | None = None


@dataclass(frozen=True)
class Published:
    """One published row: element and vehicle values, the figures printed for them, and the improvement in per cent."""

    table: int
    problem: str
    values: Mapping[str, float]
    figures: Mapping[str, float]
    vehicle: Mapping[str, float]
    improvements_percent: Mapping[str, float]
    note: str


@dataclass(frozen=True)
class Layout:
    """A network of known form with free values; see the module for the file it comes from."""

    name: str
    network: Network
    source: str
    description: str
    rules: Mapping[str, ElementRule]
    published: tuple[Published, ...]

    def fits(self, problem: Problem) -> bool:
        """Whether the vehicle has what the layout's roles stand for."""
        return self.roles <= set(problem.roles)

    @property
    def roles(self) -> set[str]:
        """The parts of a vehicle that elements stand for or have a value or a bound from."""
        named = [text for rule in self.rules.values() for text in (rule.role, rule.fixed, *(rule.bounds or ()))]
        return {text for text in named if isinstance(text, str)}

    def require(self, problem: Problem) -> None:
        """Refuse a problem whose vehicle has no place for this layout."""
        if not self.fits(problem):
            missing = listed(sorted(self.roles - set(problem.roles)))
            fitting = [entry.name for entry in layouts() if entry.fits(problem)]
            others = (
                f"layouts that fit it are {listed(fitting)}" if fitting else "give a layout of its own as a TOML file"
            )
            raise BadInput(
                f"layout {plain(self.name, 40)} contains the {missing}, which {problem.name} does not have; {others}"
            )

    def free_elements(self, problem: Problem) -> dict[str, tuple[float, float]]:
        """Elements whose values the optimiser chooses on `problem`, with their bounds."""
        free: dict[str, tuple[float, float]] = {}
        for name in self.network.names:
            rule = self.rules.get(name, ElementRule())
            if rule.fixed is not None:
                continue
            if rule.role == "static spring":
                parameter = problem.roles[rule.role]
                if parameter in problem.free:
                    free[name] = (problem.free[parameter].lower, problem.free[parameter].upper)
                continue
            low, high = rule.bounds or _WIDEST[name[0]]
            free[name] = (_value(low, problem), _value(high, problem))
            if not free[name][0] < free[name][1]:
                raise BadInput(
                    f"layout {plain(self.name, 40)}: the lower bound of {name}, {free[name][0]:g}, is not below the "
                    f"upper one, {free[name][1]:g}, in this vehicle"
                )
        return free

    def settled_values(self, problem: Problem) -> dict[str, float]:
        """Elements that need no choosing: fixed ones, and those that stand for a part of the vehicle."""
        values: dict[str, float] = {}
        for name, rule in self.rules.items():
            if rule.fixed is not None:
                values[name] = _value(rule.fixed, problem)
            elif rule.role is not None:
                values[name] = _value(rule.role, problem)
        return values

    def valued(self, problem: Problem, values: Mapping[str, Any]) -> Network:
        """The network with `values`; what is not given comes from the vehicle or the layout.

        Raises
        ------
        BadDevice
            If an element is unknown, has a bad value, or is left without one.
        """
        self.require(problem)
        network = self.network.with_values({**self.settled_values(problem), **values})
        lacking = [name for name in network.names if name not in network.exact_values()]
        if lacking:
            raise BadDevice(
                f"layout {plain(self.name, 40)} ({plain(self.network)}) needs a value for "
                f"{listed(lacking).replace(' or ', ' and ')}, such as {lacking[0]}={_example(lacking[0])}"
            )
        return network


def _example(name: str) -> str:
    return {"k": "2.5e5", "c": "2e4", "b": "300"}[name[0]]


def _value(given: float | str, problem: Problem) -> float:
    return float(getattr(problem.vehicle, problem.roles[given])) if isinstance(given, str) else given


def layouts() -> tuple[Layout, ...]:
    """Every layout that comes with posreal, by name."""
    return tuple(layout(path.name.removesuffix(".toml")) for path in sorted(_folder().iterdir(), key=lambda p: p.name))


def layout(name: str | Path | Layout) -> Layout:
    """A layout by name, or from a TOML file of the user's; a layout as it is.

    Raises
    ------
    BadInput
        For an unknown name, or a file that is not a layout.
    """
    if isinstance(name, Layout):
        return name
    text = str(name)
    if text.endswith(".toml"):
        return read_layout(text)
    known = sorted(path.name.removesuffix(".toml") for path in _folder().iterdir())
    if text not in known:
        raise BadInput(f"unknown layout {shown(text)}; {hint(text, [*known, 'a path ending in .toml'])}")
    return _shipped(text)


@lru_cache
def _shipped(name: str) -> Layout:
    return read_layout(_folder() / f"{name}.toml")


def _folder() -> Any:
    """``posreal/_layouts`` of an installed wheel, or ``layouts`` beside the package of a checkout."""
    installed = files("posreal") / "_layouts"
    return installed if installed.is_dir() else Path(__file__).parents[2] / "layouts"


def read_layout(path: Any) -> Layout:
    """Read a layout file.

    Raises
    ------
    BadInput
        Naming the file, the key and what would be accepted.
    """
    path = Path(str(path))
    document, where = read_toml(path), plain(path)
    _known(document, ("network", "source", "description", "elements", "published"), where)
    if not isinstance(document.get("network"), str):
        raise BadInput(f'{where} has no network; give a line such as network = "k | (c + b)"')
    try:
        network = parse(document["network"])
    except BadDevice as error:
        raise BadInput(f"{where}: network: {error}") from None
    if network.counts.levers:
        raise BadInput(f"{where}: network: a lever has no place in a layout; give springs, dampers and inerters")
    rules = {}
    for name, table in _table(document, "elements", where).items():
        if name not in network.names:
            raise BadInput(
                f"{where}: [elements.{plain(name, 40)}] is not in the network; its elements are {listed(network.names)}"
            )
        rules[name] = _rule(name, table, f"{where}: [elements.{plain(name, 40)}]")
    rows = document.get("published", [])
    if not isinstance(rows, list):
        raise BadInput(f"{where}: published must be tables such as [[published]]")
    return Layout(
        path.stem,
        network,
        str(document.get("source", "")),
        str(document.get("description", "")),
        rules,
        tuple(_published(row, f"{where}: [[published]]", network) for row in rows),
    )


def _table(document: Mapping[str, Any], key: str, where: str) -> Mapping[str, Any]:
    table = document.get(key, {})
    if not isinstance(table, dict) or not all(isinstance(row, dict) for row in table.values()):
        raise BadInput(f"{where}: {key} must be tables such as [{key}.k]")
    return table


def _known(table: Mapping[str, Any], accepted: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in accepted:
            raise BadInput(f"{where}: unknown key {shown(key)}; accepted are {listed(accepted)}")


def _rule(name: str, table: Mapping[str, Any], where: str) -> ElementRule:
    _known(table, ("role", "fixed", "bounds"), where)
    role = table.get("role")
    if role is not None:
        role = _role(name, role, where)
    bounds = table.get("bounds")
    limits = None
    if bounds is not None:
        if not isinstance(bounds, list) or len(bounds) != 2:
            raise BadInput(f"{where}: bounds must be a list of two, the lower and the upper one")
        limits = (_number(name, bounds[0], where), _number(name, bounds[1], where))
        if not any(isinstance(limit, str) for limit in limits) and not limits[0] < limits[1]:  # type: ignore[operator]
            raise BadInput(f"{where}: the lower bound {bounds[0]} is not below the upper one {bounds[1]}")
    fixed = table.get("fixed")
    return ElementRule(role, None if fixed is None else _number(name, fixed, where), limits)


def _number(name: str, given: Any, where: str) -> float | str:
    if isinstance(given, str) and given in ROLES:
        return _role(name, given, where)
    if isinstance(given, str):
        try:
            given = quantity(given, _UNITS[name[0]])
        except BadInput as error:
            raise BadInput(f"{where}: {error}") from None
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not _LEAST <= given <= _MOST:
        raise BadInput(
            f"{where}: {shown(given)} is not a value; give a number above 0, {_LEAST:g} to {_MOST:g}, text with a "
            "unit, or a role"
        )
    return float(given)


def _role(name: str, given: Any, where: str) -> str:
    if given not in ROLES:
        raise BadInput(f"{where}: unknown role {shown(given)}; accepted are {listed(ROLES)}")
    if name[0] != "k":
        raise BadInput(f"{where}: the {given} is a spring, and {name} is none")
    return str(given)


def _published(row: Any, where: str, network: Network) -> Published:
    if not isinstance(row, dict):
        raise BadInput(f"{where}: published must be tables such as [[published]]")
    accepted = (
        "table",
        "problem",
        "values",
        "figures",
        "vehicle",
        "improvement_percent",
        "improvements_percent",
        "note",
    )
    _known(row, accepted, where)
    try:
        improvements = _numbers(row.get("improvements_percent", {}))
        if "improvement_percent" in row:
            improvements |= _numbers({next(iter(row["figures"])): row["improvement_percent"]})
        network.with_values(row["values"])
        return Published(
            int(row["table"]),
            str(row["problem"]),
            _numbers(row["values"]),
            _numbers(row["figures"]),
            _numbers(row.get("vehicle", {})),
            improvements,
            str(row.get("note", "")),
        )
    except BadDevice as error:
        raise BadInput(f"{where}: values: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, StopIteration):
        raise BadInput(
            f"{where}: a row has table, problem, values and figures, and may have vehicle and note"
        ) from None


def _numbers(table: Mapping[str, Any]) -> dict[str, float]:
    if not all(math.isfinite(value) for value in table.values()):
        raise ValueError
    return dict(table)
