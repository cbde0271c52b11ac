"""A bound as a JSON document, and in words: what the proof is a proof of.

Names of plants and outputs may come from a file: whatever is shown of them is escaped.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posreal.admittance.exact import to_float, to_text
from posreal.bounds.figure import PEAK, SQUARES, SUM, BoundedFigure
from posreal.bounds.interpolation_space import Point
from posreal.errors import plain
from posreal.files import write_whole
from posreal.specification.conditions import in_words
from posreal.specification.named import is_named, problem
from posreal.specification.problem import Problem
from posreal.vehicle import described as described_parameters
from posreal.vehicle import parameters

if TYPE_CHECKING:
    from posreal.bounds.result import Bound

FORMAT = "posreal bound 1"
HOW = "passive device of order {}, proven positive real exactly and measured by covariance"
PLANT = ("A", "Bw", "Bf", "Cz", "Dzw", "Dzf", "Cd", "Cv", "delays")


def to_dict(bound: Bound) -> dict[str, Any]:
    """The bound as JSON-able data."""
    numbers = bound.certificate
    return {
        "format": FORMAT,
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
    """Write `to_dict` to a file, whole or not at all."""
    write_whole(path, (json.dumps(to_dict(bound), allow_nan=False) + "\n").encode())


def _about_out(bound: Bound) -> dict[str, Any]:
    subject = bound.problem
    if subject is None or not _named(subject):
        return _plant_out(bound.figure)
    return _problem_out(subject, bound.weights)


def _named(subject: Problem) -> bool:
    """Whether names and parameters are enough to have the vehicle and its track again."""
    vehicle = subject.vehicle
    track, direction = vehicle.irregularity, vehicle.direction
    if vehicle.body is not None and vehicle.body.text is None:
        return False
    return is_named(subject) and (track is None or direction is None or track.stored(direction))


def _problem_out(subject: Problem, weights: tuple[tuple[str, float], ...]) -> dict[str, Any]:
    return {
        "problem": subject.name,
        "objective": subject.base_objective,
        "weights": dict(weights) if weights else None,
        "vehicle": parameters(subject.vehicle),
    } | {name: str(value) for name, value in _conditions(subject).items() if value is not None}


def _conditions(subject: Problem) -> dict[str, Any]:
    return {"weighting": subject.vehicle.weighting, "track": subject.vehicle.irregularity} | (
        {} if subject.vehicle.body is None else {"body": subject.vehicle.body.text}
    )


def _plant_out(about: BoundedFigure) -> dict[str, Any]:
    plant = about.plant
    shaping = None if plant.shaping is None else plant.shaping.rational
    around = {name: getattr(about.mounting, name) for name in ("beside", "behind")}
    return {
        "plant": {name: getattr(plant, name).tolist() for name in PLANT}
        | {"outputs": list(plant.outputs), "groups": list(plant.groups), "density": float(plant.density)},
        "shaping": None if shaping is None else {name: getattr(shaping, name).tolist() for name in "ABCD"},
        "mounting": {name: None if part is None else part.to_dict() for name, part in around.items()},
        "weights": {name: to_text(weight) for name, weight in about.weights.items()},
        "metric": about.metric,
        "unit": about.unit,
        "combine": about.combine,
    }


def _attained_out(bound: Bound) -> dict[str, Any] | None:
    if bound.attained is None:
        return None
    device = bound.attained.device
    return {
        "value": bound.attained.value,
        "unit": bound.unit,
        "how": HOW.format(device.order),
        "gap_percent": bound.room_percent,
        "points": [_point_out(point) for point in device.points],
        "damper": to_text(device.damper),
        "coefficients": list(device.coefficients),
    }


def _point_out(point: Point) -> str | list[str]:
    return [to_text(value) for value in point] if isinstance(point, tuple) else to_text(point)


# --- what a reader is told ------------------------------------------------------------------------------------

_COMBINED = {
    SQUARES: "the root of the sum of the mean squares of {} over all frequencies",
    SUM: "the sum of the root mean squares of {} over all frequencies",
    PEAK: "the largest gain to {} over all frequencies",
}


def described(bound: Bound) -> list[str]:
    """What was proven, of what, a line each: a file may hold another vehicle than its reader thinks of."""
    about, plant = bound.figure, bound.figure.plant
    parts = []
    for name, weight in about.weights.items():
        factor = to_float(weight) ** 0.5
        parts.append(plain(name, 40) if weight == 1 else f"{factor:.6g} × {plain(name, 40)}")
    said = [
        f"figure: {plain(about.metric, 80)} [{plain(about.unit, 20)}] is "
        + _COMBINED[about.combine].format(", ".join(parts))
    ]
    if bound.problem is not None and _named(bound.problem):
        said.append(_vehicle_in_words(bound.problem))
        said.append(f"conditions: {in_words(bound.problem, whole_band=True)}")
    else:
        states, ports = len(plant.A), len(plant.groups)
        said.append(
            f"plant: one of the file's own, {states} states, {ports} port{'s' if ports > 1 else ''}, outputs "
            f"{plain(', '.join(plant.outputs))}; its matrices are under about.plant"
        )
    around = [
        (where, part) for where, part in (("beside", about.mounting.beside), ("behind", about.mounting.behind)) if part
    ]
    said.append("in the port: the device" + "".join(f", {where} it {plain(part)}" for where, part in around))
    delays = sorted({float(delay) for delay in plant.delays})
    said.append(
        f"input: white noise of single-sided density {float(plant.density):.6g} per rad/s"
        + (", through a shaping filter" if plant.shaping is not None else "")
        + (f", reaching the inputs after {', '.join(f'{d:.6g}' for d in delays[:8])} s" if delays != [0.0] else "")
        if about.combine != PEAK
        else "input: any, of any frequency; a gain has no density"
    )
    return said


def _vehicle_in_words(subject: Problem) -> str:
    usual, here = problem(subject.name).vehicle, subject.vehicle
    changed = [
        f"{name} = {value:.6g} {unit.replace('*', ' ')}, not {getattr(usual, name):.6g}"
        for name, value, unit, _, _ in described_parameters(here)
        if value != getattr(usual, name)
    ]
    return f"vehicle: {here.name} of {subject.name}, " + ("with " + "; ".join(changed) if changed else "as it comes")
