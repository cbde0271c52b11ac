"""Certificates as JSON: written by `Bound.save`, read by `Bound.load`, believed only after `Bound.check`.

The document says which vehicle and figure are meant (a named problem with all its parameters, or the matrices of a
plant), what is claimed, and the certificate's numbers. Everything derived from these is written for the reader's
convenience and compared when it is read: a document that contradicts itself is refused.
"""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from flint import fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_fmpq, to_text
from posreal.design.bound.ports import SQUARES, SUM, Figure, figure
from posreal.design.bound.result import Best, Bound
from posreal.design.bound.ritz import Attained, HighOrder
from posreal.design.bound.search import LIFTED, PLAIN, VALUE, Certificate
from posreal.design.bound.space import Point, width
from posreal.design.bound.value_form import ValueCertificate
from posreal.design.bound.values import distinct
from posreal.design.mounting import Mounting
from posreal.design.named import problem, problems
from posreal.design.problem import Problem
from posreal.errors import BadDevice, BadInput, listed
from posreal.vehicle import QuarterCar
from posreal.vehicle.plant import Plant, ShapingFilter
from posreal.vehicle.user_plant import UserPlant

_FORMAT = "posreal bound 1"
_LARGEST_FILE = 20_000_000  # bytes
_LARGEST_FACTOR = {PLAIN: 300, LIFTED: 300, VALUE: 600}  # rows: what a check takes a minute for
_LARGEST_ORDER = 250  # states of a device
_HOW = "passive device of order {}, proven positive real exactly and measured by covariance"
_LARGEST_PLANT = 60  # states
_PLANT = ("A", "Bw", "Bf", "Cz", "Dzw", "Dzf", "Cd", "Cv", "delays")


def to_dict(bound: Bound) -> dict[str, Any]:
    """The bound as JSON-able data."""
    numbers = bound.certificate
    return {
        "format": _FORMAT,
        "bound": {"value": bound.value, "unit": bound.unit, "metric": bound.metric, "kind": bound.kind},
        "holds_for": bound.devices,
        "passive": bound.passive,
        "best": None
        if bound.best is None
        else {
            "label": bound.best.label,
            "value": bound.best.value,
            "unit": bound.unit,
            "port": None if bound.best.device is None else bound.best.device.to_dict(),
        },
        "gap_percent": bound.gap_percent,
        "reached": _attained_out(bound),
        "seconds": round(bound.seconds, 2),
        "about": _about_out(bound),
        "certificate": {
            "form": bound.form,
            "points": [_point_out(point) for point in numbers.points],
            "damper": to_text(numbers.damper),
            "factor": [row[: k + 1].tolist() for k, row in enumerate(numbers.factor)],
            "multipliers": numbers.multipliers.tolist(),
            "functional": numbers.functional.tolist(),
        },
    }


def save(bound: Bound, path: str | Path) -> None:
    """Write `to_dict` to a file."""
    try:
        Path(path).write_text(json.dumps(to_dict(bound), allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise BadInput(f"cannot write {path}: {error.strerror or error}") from None


def load(path: str | Path) -> Bound:
    """Read a certificate file.

    Raises
    ------
    BadInput
        If it cannot be read, is no certificate, or contradicts itself.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise BadInput(f"it is larger than {_LARGEST_FILE} bytes; a certificate is a few hundred kilobytes")
        return from_dict(json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_constant))
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror or error}") from None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise BadInput(f"{path} is not valid JSON: {error}") from None
    except (BadInput, BadDevice) as error:
        raise BadInput(f"{path}: {error}") from None


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
        raise BadInput(f"passive is {top['passive']!r}; accepted are true or false")
    if top["format"] != _FORMAT:
        raise BadInput(f"format is {top['format']!r}; this version reads {_FORMAT!r}")
    claim = _table(top["bound"], "bound", ("value", "unit", "metric", "kind"))
    numbers = _table(
        top["certificate"], "certificate", ("form", "points", "damper", "factor", "multipliers", "functional")
    )
    if numbers["form"] not in (PLAIN, LIFTED, VALUE):
        raise BadInput(f"form is {numbers['form']!r}; accepted are {PLAIN}, {LIFTED} or {VALUE}")
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
            raise BadInput(f"{name} is stated as {stated[name]!r}, and what the certificate is about has {value!r}")
    gap, said = found.gap_percent, top["gap_percent"]
    if (gap is None) != (said is None) or (gap is not None and abs(gap - _number(said, "gap_percent")) > 1e-6):
        raise BadInput(f"gap_percent is stated as {said!r}, and bound and best give {gap!r}")
    return found


# --- the vehicle ---------------------------------------------------------------------------------------------


def _about_out(bound: Bound) -> dict[str, Any]:
    subject = bound.problem
    own = subject is None or isinstance(subject.vehicle, UserPlant)
    return _plant_out(bound.figure) if subject is None or own else _problem_out(subject, bound.weights)


def _problem_out(subject: Problem, weights: tuple[tuple[str, float], ...]) -> dict[str, Any]:
    return {
        "problem": subject.name,
        "objective": subject.base_objective,
        "weights": dict(weights) if weights else None,
        "vehicle": dataclasses.asdict(subject.vehicle),
    }


def _plant_out(about: Figure) -> dict[str, Any]:
    plant, shaping = about.plant, about.plant.shaping
    around = {name: getattr(about.mounting, name) for name in ("beside", "behind")}
    return {
        "plant": {name: getattr(plant, name).tolist() for name in _PLANT}
        | {"outputs": list(plant.outputs), "groups": list(plant.groups), "density": float(plant.density)},
        "shaping": None if shaping is None else {name: getattr(shaping, name).tolist() for name in "ABCD"},
        "mounting": {name: None if part is None else part.to_dict() for name, part in around.items()},
        "weights": {name: to_text(weight) for name, weight in about.weights.items()},
        "metric": about.metric,
        "unit": about.unit,
        "combine": about.combine,
    }


def _about(data: Any) -> tuple[Figure, Problem | None, tuple[tuple[str, float], ...]]:
    if isinstance(data, dict) and "plant" in data:
        return _plant_in(data), None, ()
    table = _table(data, "about", ("problem", "objective", "weights", "vehicle"))
    if table["problem"] not in [entry.name for entry in problems()]:
        raise BadInput(f"problem is {table['problem']!r}; known are {listed(entry.name for entry in problems())}")
    posed = problem(table["problem"])
    if isinstance(posed.vehicle, UserPlant):
        raise BadInput(f"{posed.name} is a plant of one's own, and is stored as one")
    fields = tuple(field.name for field in dataclasses.fields(posed.vehicle))
    values = {name: _number(value, name) for name, value in _table(table["vehicle"], "vehicle", fields).items()}
    vehicle = type(posed.vehicle)(**values)
    if isinstance(vehicle, QuarterCar):  # its objective may be a sum or a gain
        posed = problem(posed.name, objective=str(table["objective"]))
    posed = dataclasses.replace(posed, objective=str(table["objective"]), vehicle=vehicle)
    if table["weights"] is None:
        return figure(posed), posed, ()
    if not isinstance(table["weights"], dict):
        raise BadInput("weights are a table of metric and number, or null")
    weights = {str(name): _number(value, f"weight of {name}") for name, value in table["weights"].items()}
    return figure(posed, weights), posed, tuple(weights.items())


def _plant_in(data: Any) -> Figure:
    table = _table(data, "about", ("plant", "shaping", "mounting", "weights", "metric", "unit", "combine"))
    parts = _table(table["plant"], "plant", (*_PLANT, "outputs", "groups", "density"))
    arrays = {name: _array(parts[name], name) for name in _PLANT}
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
    return Figure(plant, mounting, weights, str(table["metric"]), str(table["unit"]), str(table["combine"]))


# --- the numbers ---------------------------------------------------------------------------------------------


def _certificate(table: dict[str, Any], about: Figure) -> Certificate | ValueCertificate:
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


def _functional(data: Any, about: Figure, m: int) -> np.ndarray:
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


def _best(data: Any, about: Figure) -> Best | None:
    if data is None:
        return None
    table = _table(data, "best", ("label", "value", "unit", "port"))
    if table["unit"] != about.unit:
        raise BadInput(f"best is in {table['unit']!r}, and the bound in {about.unit!r}")
    device = None if table["port"] is None else Rational.from_dict(table["port"])
    return Best(str(table["label"]), _number(table["value"], "best"), device)


def _attained_out(bound: Bound) -> dict[str, Any] | None:
    if bound.attained is None:
        return None
    device = bound.attained.device
    return {
        "value": bound.attained.value,
        "unit": bound.unit,
        "how": _HOW.format(device.order),
        "gap_percent": bound.room_percent,
        "points": [_point_out(point) for point in device.points],
        "damper": to_text(device.damper),
        "coefficients": list(device.coefficients),
    }


def _attained(data: Any, about: Figure) -> Attained | None:
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
    if not abs(coefficients[0]) < 1 or table["how"] != _HOW.format(size):
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
            raise BadInput(f"{name} has an unknown entry {key!r}; accepted are {listed(keys)}")
    return data


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise BadInput(f"{name} is {value!r}, not a finite number")
    return float(value)


def _positive(value: Any, name: str) -> fmpq:
    if not isinstance(value, str) or len(value) > 100:
        raise BadInput(f"{name} is {value!r}, not a short exact number in quotes")
    number = to_fmpq(value)
    if number <= 0:
        raise BadInput(f"{name} is {value}; it must be above 0")
    return number


def _point(value: Any) -> Point:
    if isinstance(value, list) and len(value) == 2:
        return _positive(value[0], "a point's frequency"), _positive(value[1], "a point's damping ratio")
    return _positive(value, "a point")


def _point_out(point: Point) -> str | list[str]:
    return [to_text(value) for value in point] if isinstance(point, tuple) else to_text(point)


def _array(data: Any, name: str) -> np.ndarray:
    try:
        array = np.array(data, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is not an array of numbers") from None
    if not np.all(np.isfinite(array)):
        raise BadInput(f"{name} has entries that are not finite")
    return array


def _no_constant(text: str) -> Any:
    raise BadInput(f"{text} is not a number that a certificate may hold")
