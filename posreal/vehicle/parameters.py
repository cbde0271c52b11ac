"""Vehicle parameters: typed fields that carry their unit, meaning and source, and a user's file laid over them.

A vehicle is a frozen dataclass whose fields are made by :func:`parameter`. A TOML file overrides any of
them, one table a vehicle, each value a number in the field's SI unit or a string with a unit of its own::

    [side-view]
    mv  = 42000             # kg
    Crz = "70 kN s/m"
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.files import read_toml
from posreal.units import quantity

T = TypeVar("T")
SMALLEST, LARGEST = 1e-15, 1e15  # in SI units, other than 0: beyond that, matrices are singular to rounding


def parameter(default: float, unit: str, meaning: str, *, source: str, may_be_zero: bool = False) -> Any:
    """A dataclass field for one physical parameter, in SI units.

    Parameters
    ----------
    default : float
        Value in `unit`.
    unit : str
        SI unit, ``"1"`` for a pure number.
    meaning : str
        What the parameter is, for tables and error messages.
    source : str
        Reference key of the default.
    may_be_zero : bool
        Whether 0 is a physical value (a leakage stiffness) or not (a mass).
    """
    return dataclasses.field(
        default=default,
        metadata={"unit": unit, "meaning": meaning, "source": source, "may_be_zero": may_be_zero},
    )


def described(vehicle: Any) -> Iterator[tuple[str, float, str, str, str]]:
    """Yield ``(name, value, unit, meaning, source)`` of every parameter of a vehicle."""
    for field in _physical(vehicle):
        meta = field.metadata
        yield field.name, getattr(vehicle, field.name), meta["unit"], meta["meaning"], meta["source"]


def parameters(vehicle: Any) -> dict[str, float]:
    """The value of every parameter by name; none for a plant of the user's own."""
    return {field.name: getattr(vehicle, field.name) for field in _physical(vehicle)}


def _physical(vehicle: Any) -> list[dataclasses.Field[Any]]:
    """The fields that are numbers with a unit: not the track or the weighting that a vehicle is judged on."""
    return [field for field in dataclasses.fields(vehicle) if "unit" in field.metadata]


def validated(vehicle: Any) -> None:
    """Refuse parameters that are not finite, negative, or zero where zero is not physical.

    Raises
    ------
    BadInput
        Naming the parameter, its value and what would be accepted.
    """
    for field in _physical(vehicle):
        value, unit = getattr(vehicle, field.name), field.metadata["unit"]
        low = "at least 0" if field.metadata["may_be_zero"] else "greater than 0"
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise BadInput(f"{field.name} must be a number in {unit}, not {shown(value)}")
        if not (SMALLEST <= value <= LARGEST or (value == 0 and field.metadata["may_be_zero"])):
            size = f"{value:g}" if isinstance(value, float) else plain(value, 30)
            raise BadInput(
                f"{field.name} ({field.metadata['meaning']}) is {size} {unit}; it must be finite and {low}"
                + (f", from {SMALLEST:g} to {LARGEST:g}" if value > 0 else "")
            )


def override(vehicle: T, values: Mapping[str, Any], *, where: str = "parameters") -> T:
    """Return `vehicle` with some parameters replaced.

    Parameters
    ----------
    vehicle : dataclass instance
    values : mapping of parameter name to number (SI) or string with unit
    where : str
        Named in error messages: a file, or the command line.

    Raises
    ------
    BadInput
        For an unknown parameter, an unknown or wrong unit, or a value out of range.
    """
    fields = {field.name: field for field in _physical(vehicle)}
    replaced: dict[str, float] = {}
    for name, value in values.items():
        if name not in fields:
            raise BadInput(f"{where}: unknown parameter {shown(name)}; {hint(name, fields)}")
        unit = fields[name].metadata["unit"]
        try:
            replaced[name] = quantity(value, unit) if isinstance(value, str) else value
            validated(dataclasses.replace(vehicle, **{name: replaced[name]}))  # type: ignore[type-var]
        except BadInput as error:
            raise BadInput(f"{where}: {name}: {error}") from None
        replaced[name] = float(replaced[name])
    return dataclasses.replace(vehicle, **replaced)  # type: ignore[type-var]


def from_file(vehicle: T, path: str | Path, table: str, known_tables: tuple[str, ...]) -> T:
    """Lay table `table` of a TOML file over `vehicle`; other known tables may be present, unknown ones not."""
    document = read_toml(path)
    for name, content in document.items():
        if name not in known_tables or not isinstance(content, dict):
            raise BadInput(
                f"{plain(path)}: unknown table or key {shown(name)} at the top; "
                f"accepted are the tables {listed(known_tables)}"
            )
    if table not in document:
        raise BadInput(f"{plain(path)} has no table [{table}], the vehicle of this problem")
    values, where = dict(document[table]), f"{plain(path)} [{table}]"
    readers: Mapping[str, tuple[str, Callable[[Any, str], Any]]] = getattr(vehicle, "tables", {})
    for key in [key for key in values if key in readers]:
        name, read = readers[key]
        vehicle = dataclasses.replace(vehicle, **{name: read(values.pop(key), where)})  # type: ignore[type-var]
    return override(vehicle, values, where=where)
