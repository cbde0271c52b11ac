"""Certificates read from JSON: written by `Bound.save`, read by `load_bound`, believed only after `Bound.check`.

The document says which vehicle and figure are meant (a named problem with all its parameters, or the matrices of a
plant), what is claimed, and the certificate's numbers. Everything derived from these is written for the reader's
convenience and compared when it is read: a document that contradicts itself is refused.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from flint import fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_fmpq
from posreal.bounds.document import FORMAT, HOW, PLANT
from posreal.bounds.figure import SQUARES, SUM, BoundedFigure, figure
from posreal.bounds.interpolation_space import Point, width
from posreal.bounds.points import LIFTED, PLAIN, VALUE, Certificate
from posreal.bounds.result import Best, Bound
from posreal.bounds.ritz import Attained, HighOrder
from posreal.bounds.value_form import ValueCertificate
from posreal.bounds.values import distinct
from posreal.errors import BadInput, listed, plain, shown
from posreal.files import read_json
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant
from posreal.plant.shaping_filter import ShapingFilter
from posreal.specification.named import minimising, problem, problems
from posreal.specification.problem import Problem
from posreal.vehicle import override, parameters

_LARGEST_FILE = 20_000_000  # bytes
_LARGEST = 1e100  # of a number: products of three are numbers that a float holds
_LARGEST_FACTOR = {PLAIN: 300, LIFTED: 300, VALUE: 600}  # rows: what a check takes a minute for
_LARGEST_ORDER = 250  # states of a device
_LARGEST_PLANT = 60  # states


def load_bound(path: str | Path) -> Bound:
    """Read a certificate file.

    Raises
    ------
    BadInput
        If it cannot be read, is no certificate, or contradicts itself.
    """
    document = read_json(path, _LARGEST_FILE)
    try:
        return from_dict(document)
    except BadInput as error:
        raise BadInput(f"{plain(path)}: {error}") from None


def from_dict(document: Any) -> Bound:
    """The bound that `to_dict` wrote.

    Raises
    ------
    BadInput
        If the document is not one, or contradicts itself.
    """
    reached = None
    if isinstance(document, dict):  # what the command line says of single orders is no part of the claim
        document = {key: value for key, value in document.items() if key != "orders"}
        reached = document.pop("reached", None)
    top = _table(
        document,
        "the certificate",
        ("format", "bound", "holds_for", "passive", "best", "gap_percent", "seconds", "about", "certificate"),
    )
    if not isinstance(top["passive"], bool):
        raise BadInput(f"passive is {shown(top['passive'])}; accepted are true or false")
    if top["format"] != FORMAT:
        raise BadInput(f"format is {shown(top['format'])}; this version reads {shown(FORMAT)}")
    claim = _table(top["bound"], "bound", ("value", "unit", "metric", "kind"))
    numbers = _table(
        top["certificate"], "certificate", ("form", "points", "damper", "factor", "multipliers", "functional")
    )
    if numbers["form"] not in (PLAIN, LIFTED, VALUE):
        raise BadInput(f"form is {shown(numbers['form'])}; accepted are {PLAIN}, {LIFTED} or {VALUE}")
    about, named, weights = _about(top["about"])
    found = Bound(
        _number(claim["value"], "the bound's value"),
        about,
        _certificate(numbers, about),
        numbers["form"],
        top["passive"] is True,
        named,
        weights,
        _best(top["best"], about),
        _number(top["seconds"], "seconds"),
        _attained(reached, about),
    )
    room = found.room_percent
    if reached is not None and room is not None and abs(room - _number(reached["gap_percent"], "gap_percent")) > 1e-6:
        raise BadInput(f"the gap to what is reached is {room:.7g} %, not {reached['gap_percent']!r}")
    stated = {"unit": claim["unit"], "metric": claim["metric"], "kind": claim["kind"], "holds_for": top["holds_for"]}
    derived = {"unit": found.unit, "metric": found.metric, "kind": found.kind, "holds_for": found.devices}
    for name, value in derived.items():
        if stated[name] != value:
            raise BadInput(
                f"{name} is stated as {shown(stated[name])}, and what the certificate is about has {shown(value)}"
            )
    gap, said = found.gap_percent, top["gap_percent"]
    if (gap is None) != (said is None) or (gap is not None and abs(gap - _number(said, "gap_percent")) > 1e-6):
        raise BadInput(f"gap_percent is stated as {shown(said)}, and bound and best give {shown(gap)}")
    return found


# --- the vehicle ---------------------------------------------------------------------------------------------


def _about(data: Any) -> tuple[BoundedFigure, Problem | None, tuple[tuple[str, float], ...]]:
    if isinstance(data, dict) and "plant" in data:
        return _plant_in(data), None, ()
    told, under = data, {}
    if isinstance(data, dict):
        under = {key: str(data[key]) for key in ("weighting", "track", "body") if key in data}
        told = {key: value for key, value in data.items() if key not in under}
    table = _table(told, "about", ("problem", "objective", "weights", "vehicle"))
    if table["problem"] not in [entry.name for entry in problems()]:
        raise BadInput(f"problem is {shown(table['problem'])}; known are {listed(entry.name for entry in problems())}")
    posed = problem(
        table["problem"], weighting=under.get("weighting"), track=under.get("track"), body=under.get("body")
    )
    if not parameters(posed.vehicle):
        raise BadInput(f"{posed.name} is a plant of one's own, and is stored as one")
    fields = tuple(parameters(posed.vehicle))
    values = {name: _number(value, name) for name, value in _table(table["vehicle"], "vehicle", fields).items()}
    vehicle = override(posed.vehicle, values, where="vehicle")
    posed = dataclasses.replace(minimising(posed, str(table["objective"])), vehicle=vehicle)
    if table["weights"] is None:
        return figure(posed), posed, ()
    if not isinstance(table["weights"], dict):
        raise BadInput("weights are a table of metric and number, or null")
    weights = {str(name): _number(value, f"weight of {name}") for name, value in table["weights"].items()}
    return figure(posed, weights), posed, tuple(weights.items())


def _plant_in(data: Any) -> BoundedFigure:
    table = _table(data, "about", ("plant", "shaping", "mounting", "weights", "metric", "unit", "combine"))
    parts = _table(table["plant"], "plant", (*PLANT, "outputs", "groups", "density"))
    arrays = {name: _array(parts[name], name) for name in PLANT}
    shaping = None
    if table["shaping"] is not None:
        inner = _table(table["shaping"], "shaping", tuple("ABCD"))
        shaping = ShapingFilter(**{name: _array(inner[name], f"shaping {name}") for name in "ABCD"})
    around = _table(table["mounting"], "mounting", ("beside", "behind"))
    mounting = Mounting(**{name: None if part is None else Rational.from_dict(part) for name, part in around.items()})
    if not isinstance(table["weights"], dict):
        raise BadInput("weights are a table of output and number")
    if not isinstance(parts["outputs"], list) or not isinstance(parts["groups"], list):
        raise BadInput("outputs and groups of a plant are lists of names")
    outputs, groups = tuple(map(str, parts["outputs"])), tuple(map(str, parts["groups"]))
    n, m, q, p = (len(part) for part in (arrays["A"], arrays["delays"], outputs, groups))
    shapes: dict[str, tuple[int, ...]] = {
        "A": (n, n),
        "Bw": (n, m),
        "Bf": (n, p),
        "Cz": (q, n),
        "Dzw": (q, m),
        "Dzf": (q, p),
    }
    shapes |= {"Cd": (p, n), "Cv": (p, n), "delays": (m,)}
    for name, shape in shapes.items():
        if arrays[name].shape != shape or 0 in shape:
            raise BadInput(f"{name} of the plant has shape {arrays[name].shape}, and the others need {shape}")
    if shaping is not None:
        h = len(shaping.A)
        if [getattr(shaping, name).shape for name in "ABCD"] != [(h, h), (h, 1), (1, h), (1, 1)]:
            raise BadInput("the matrices of the plant's shaping filter do not fit together")
    if n > _LARGEST_PLANT or np.any(arrays["delays"] < 0):
        raise BadInput(f"a plant has at most {_LARGEST_PLANT} states, and delays not below 0")
    density = _number(parts["density"], "density")
    if density <= 0:
        raise BadInput(f"density is {density:g}; it must be above 0")
    weights = {str(name): to_fmpq(value) for name, value in table["weights"].items()}
    plant = Plant(
        **arrays, outputs=outputs, groups=groups, shaping=shaping, density=density, processes=(), shares=(1.0,)
    )
    return BoundedFigure(plant, mounting, weights, str(table["metric"]), str(table["unit"]), str(table["combine"]))


# --- the numbers ---------------------------------------------------------------------------------------------


def _certificate(table: dict[str, Any], about: BoundedFigure) -> Certificate | ValueCertificate:
    loops = len(about.loops)
    if not isinstance(table["points"], list) or not table["points"]:
        raise BadInput("points are a list of frequencies, rad/s, and of pairs of natural frequency and damping ratio")
    points = tuple(_point(point) for point in table["points"])
    m = sum(map(width, points))
    size, pairs = loops * m, loops * (loops - 1) // 2
    most = _LARGEST_FACTOR[table["form"]]
    if size > most:
        raise BadInput(f"a space of {m} dimensions and {loops} loops are more than {most} together")
    if table["form"] == VALUE and (about.combine != SQUARES or not distinct(points)):
        raise BadInput("the value form is for mean squares, and for distinct points with damping ratios below 1")
    rows, multipliers = table["factor"], table["multipliers"]
    if not all(isinstance(x, list) and len(x) == n for x, n in ((rows, size), (multipliers, pairs))):
        raise BadInput(f"{loops} loops and {m} dimensions need {size} rows in factor and {pairs} in multipliers")
    columns = len(rows[-1]) if isinstance(rows[-1], list) else 0
    if not 0 < columns <= size:
        raise BadInput(f"the last row of factor needs 1 to {size} numbers")
    factor, mu = np.zeros((size, columns)), np.zeros((pairs, m))
    functional = _functional(table["functional"], about, m)
    for target, given, name in [
        *((factor[k, : k + 1], row, f"row {k + 1} of factor") for k, row in enumerate(rows)),
        *((mu[k], row, f"row {k + 1} of multipliers") for k, row in enumerate(multipliers)),
    ]:
        if not isinstance(given, list) or len(given) != len(target):
            raise BadInput(f"{name} needs {len(target)} numbers")
        target[:] = [_number(value, name) for value in given]
    made = ValueCertificate if table["form"] == VALUE else Certificate
    return made(points, _positive(table["damper"], "damper"), factor, mu, functional)


def _functional(data: Any, about: BoundedFigure, m: int) -> np.ndarray:
    """The multiplier of the objective, in the shape that its kind needs."""
    if about.combine == SQUARES:
        if data != []:
            raise BadInput("functional is for sums and peaks; a mean square has an empty one")
        return np.zeros((0, 0))
    array = _array(data, "functional")
    good = array.shape == (len(about.weights), m) if about.combine == SUM else array.shape == (2 * m, 2 * m)
    if not good:
        raise BadInput(f"functional has shape {array.shape}, which does not fit {m} dimensions")
    return array


def _best(data: Any, about: BoundedFigure) -> Best | None:
    if data is None:
        return None
    table = _table(data, "best", ("label", "value", "unit", "port"))
    if table["unit"] != about.unit:
        raise BadInput(f"best is in {shown(table['unit'])}, and the bound in {shown(about.unit)}")
    device = None if table["port"] is None else Rational.from_dict(table["port"])
    return Best(str(table["label"]), _number(table["value"], "best"), device)


def _attained(data: Any, about: BoundedFigure) -> Attained | None:
    if data is None:
        return None
    table = _table(data, "reached", ("value", "unit", "how", "gap_percent", "points", "damper", "coefficients"))
    if table["unit"] != about.unit:
        raise BadInput(f"reached is in {table['unit']!r}, and the bound in {about.unit!r}")
    if not isinstance(table["points"], list) or not isinstance(table["coefficients"], list):
        raise BadInput("points and coefficients of what is reached are lists")
    points = tuple(_point(point) for point in table["points"])
    size = sum(map(width, points))
    if not 0 < size <= _LARGEST_ORDER or len(table["coefficients"]) != size + 1:
        raise BadInput(f"a device of order {size} needs {size + 1} coefficients, and at most {_LARGEST_ORDER} poles")
    coefficients = tuple(_number(value, "a coefficient") for value in table["coefficients"])
    if not abs(coefficients[0]) < 1 or table["how"] != HOW.format(size):
        raise BadInput("what is stated to be reached does not describe its own device")
    device = HighOrder(points, _positive(table["damper"], "damper"), coefficients)
    value = _number(table["value"], "what is reached")
    if value <= 0:
        raise BadInput(f"reached is {value:g}; it must be above 0")
    return Attained(device, value)


def _table(data: Any, name: str, keys: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise BadInput(f"{name} is not a table with {listed(keys).replace(' or ', ' and ')}")
    for key in keys:
        if key not in data:
            raise BadInput(f"{name} lacks {key}")
    for key in data:
        if key not in keys:
            raise BadInput(f"{name} has an unknown entry {shown(key)}; accepted are {listed(keys)}")
    return data


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _LARGEST:
        raise BadInput(f"{name} is {shown(value)}, not a number of at most {_LARGEST:g}")
    return float(value)


def _positive(value: Any, name: str) -> fmpq:
    if not isinstance(value, str) or len(value) > 100:
        raise BadInput(f"{name} is {shown(value)}, not a short exact number in quotes")
    number = to_fmpq(value)
    if number <= 0:
        raise BadInput(f"{name} is {value}; it must be above 0")
    return number


def _point(value: Any) -> Point:
    if isinstance(value, list) and len(value) == 2:
        return _positive(value[0], "a point's frequency"), _positive(value[1], "a point's damping ratio")
    return _positive(value, "a point")


def _array(data: Any, name: str) -> np.ndarray:
    try:
        array = np.array(data, dtype=float)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise BadInput(f"{name} is not an array of numbers") from None
    if not np.all(np.abs(array) <= _LARGEST):
        raise BadInput(f"{name} has entries that are no numbers of at most {_LARGEST:g}")
    return array
