"""The named problems, and the variations that a user may ask for: other figures, limits, operating points."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, listed, shown
from posreal.metric import PeakInTime
from posreal.ranges import UsualRanges, ranges_from, read_ranges
from posreal.real_elements import RealElements, read_elements
from posreal.specification.conditions import cut, in_weighting, on_track, standard_weighting, with_body
from posreal.specification.constraint import Range
from posreal.specification.goal import Goal, weighted_sum
from posreal.specification.limits import limited
from posreal.specification.problem import WORST_CASE, Problem
from posreal.specification.problem_file import is_problem_file, read_problem
from posreal.vehicle import (
    PlanView,
    QuarterCar,
    SideView,
    Vehicle,
    from_file,
    override,
    parameters,
    whole_band_twin,
)
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.manchester import ManchesterCoach
from posreal.vehicle.seen_from import seen_from
from posreal.vehicle.track import PAPER, Track
from posreal.vehicle.weighting import Weighting

_MOST_SPEEDS = 30
VEHICLES: tuple[type[Vehicle], ...] = (PlanView, SideView, ManchesterCoach, QuarterCar)

_KPY, _CPY, _KSY = Range(2.4e6, 9.4e6), Range(2.4e3, 6e4), Range(1.2e5, 4.9e5)
"""Half to twice the default stiffnesses, a fifth to five times the damping: a re-tuning, not another vehicle."""


def _lateral(name: str, summary: str, objective: str, keep: tuple[str, ...], **free: Range) -> Problem:
    return Problem(name, summary, PlanView(), objective, keep, free)


_PROBLEMS: dict[str, Problem] = {
    entry.name: entry
    for entry in (
        _lateral("lateral-comfort", "least lateral body acceleration, damping kept", "Macc", ("Ldmp",)),
        _lateral(
            "lateral-comfort-primary",
            "least lateral body acceleration, damping kept, primary lateral suspension free",
            "Macc",
            ("Ldmp",),
            Kpy=_KPY,
            Cpy=_CPY,
        ),
        _lateral(
            "lateral-gauging",
            "least body displacement entering a curve, damping and comfort kept, static spring free",
            "max_yv",
            ("Ldmp", "Macc"),
            Ksy=_KSY,
        ),
        _lateral(
            "lateral-gauging-primary",
            "least body displacement entering a curve, damping and comfort kept, static and primary free",
            "max_yv",
            ("Ldmp", "Macc"),
            Kpy=_KPY,
            Cpy=_CPY,
            Ksy=_KSY,
        ),
        Problem(
            "vertical-comfort",
            "least vertical body acceleration over the trailing bogie",
            SideView(),
            "J1z_T",
        ),
        Problem(
            "manchester-comfort",
            "least vertical body acceleration over the trailing bogie of the Manchester coach, coil spring kept",
            ManchesterCoach(),
            "J1z_T",
        ),
        Problem(
            "quarter-car",
            "least body acceleration of a quarter-car, static stiffness kept",
            QuarterCar(),
            "J1",
        ),
    )
}


def problems() -> tuple[Problem, ...]:
    """Every named problem."""
    return tuple(_PROBLEMS.values())


def problem(
    name: str,
    *,
    position: str | None = None,
    objective: str | None = None,
    stiffness: float | None = None,
    vehicle_file: Any = None,
    vehicle: Mapping[str, Any] | str | Path | None = None,
    limits: Mapping[str, float] | None = None,
    worst_case: Sequence[Mapping[str, Any]] = (),
    at: str | None = None,
    track: str | Track | None = None,
    wavelengths: tuple[float, float] | None = None,
    speed: float | Sequence[float] | None = None,
    body: str | FlexibleBody | None = None,
    weighting: str | Weighting | None = None,
    standard: str | None = None,
    cut_off: float | None = None,
    ranges: Any = None,
    band_only: bool = False,
    elements: Any = None,
) -> Problem:
    """A design problem by name.

    Parameters
    ----------
    name : str
        ``lateral-comfort``, ``lateral-comfort-primary``, ``lateral-gauging``, ``lateral-gauging-primary``,
        ``vertical-comfort`` or ``quarter-car``; or a file with a model of one's own, ``mine.toml``, ``mine.toml:NAME``.
    position : {"L", "M", "T", "worst"}, optional
        Where ride is measured in ``vertical-comfort`` (T by default); ``worst`` minimises the worst of the three.
    objective : str, optional
        What is minimised, a metric of the vehicle or a weighted sum of some: in ``quarter-car`` ``J1``, ``J3``,
        ``gain_acceleration`` or ``gain_tyre_force`` (the H∞ norm from road velocity), or ``J1 + 0.001*J3``; in
        ``vertical-comfort`` ``whole-band``, the ride over all frequencies instead of up to 20 Hz.
    stiffness : float, optional
        Static stiffness of ``quarter-car``, N/m.
    vehicle_file : path, optional
        TOML file whose table ``[plan-view]``, ``[side-view]`` or ``[quarter-car]`` overrides parameters.
    vehicle : mapping or path, optional
        Parameters to override, numbers in SI units or text with a unit; or a file of them, as `vehicle_file`.
    limits : mapping of metric to number, optional
        Upper limits on metrics, in their units, such as ``{"deflection_rear": 34.0}``. ``inertance`` is lim Y/s of the
        port, not the sum of a network's inerters.
    worst_case : sequence of mappings, optional
        Operating points besides the nominal one, each as parameters to override; the worst over all is minimised, and
        constraints hold at each.
    at : str, optional
        Where the device goes, if not where the problem has it: ``primary`` in the plan view.
    track : str or Track, optional
        What the vehicle runs on: ``paper``, or a standard track such as ``erri-low``, ``fra-4``, ``aar-6``, ``china``.
    wavelengths : (float, float), optional
        All that counts of the track, the shortest and the longest in m.
    speed : float or sequence of float, optional
        m/s; of several the worst is minimised, as over operating points.
    body : str or FlexibleBody, optional
        ``rigid``, ``flexible`` (8.5 Hz, 1.5 %), or the first mode, its damping and the number of modes of a uniform
        beam, as in ``9 Hz,2%,2``.
    weighting : str, optional
        ``Wb`` (EN 12299), ``Wb-iso``, ``Wk``, ``Wd``, ``Wc``, ``We`` or ``none``: ride and comfort are
        then those of the weighted acceleration, over all frequencies: ``aw_T`` in place of ``J1z_T``, ``max_aw_y`` in
        place of ``Macc``.
    standard : {"en12299"}, optional
        The weighting that it takes for the vehicle's direction, with its indices beside: Wb, laterally Wd.
    cut_off : float, optional
        Frequency, Hz, at which ``J1z_…`` and ``aw_…`` end: 20 by default for the first, none for the second.
    ranges : path, mapping or UsualRanges, optional
        What can be bought, instead of the place's usual ranges: a TOML file or a mapping such as
        ``{"b": ("50 kg", "2 t")}``; see :mod:`posreal.ranges`.
    band_only : bool
        Whether a search may return a device that is worse than the default suspension over all frequencies, where the
        objective ends at 20 Hz.
    elements : "real", path, mapping or RealElements, optional
        What comes with the springs, dampers and inerters that are bought, which `evaluate`, `optimise` and `search`
        then take in place of ideal ones: what is usual, a TOML catalogue, or a mapping; see
        :mod:`posreal.real_elements`.

    Raises
    ------
    BadInput
        For an unknown name, an option that the problem does not have, or a bad parameter.
    """
    chosen = _of_file(name) if is_problem_file(name) else _named(name)
    chosen = dataclasses.replace(chosen, band_only=band_only)
    if position is not None:
        rides = {point: f"J1z_{point}" for point in "LMT"}
        fits = set(rides.values()) <= set(chosen.vehicle.metrics)
        if not fits or position not in (*rides, "worst"):
            raise BadInput(
                f"position {shown(position)} does not fit {name}; vertical-comfort takes L, M or T, or worst"
            )
        if position == "worst":
            goal = Goal("worst", tuple((name, 1.0) for name in rides.values()))
            chosen = dataclasses.replace(chosen, objective=goal.name, goal=goal)
        else:
            chosen = dataclasses.replace(chosen, objective=rides[position])
    if standard is not None:
        weighting = standard_weighting(chosen, standard, weighting)
    if weighting is not None:
        chosen = in_weighting(chosen, weighting)
    if cut_off is not None:
        chosen = cut(chosen, cut_off)
    if objective is not None:
        chosen = minimising(chosen, objective)
    model: Vehicle = chosen.vehicle
    if isinstance(vehicle, str | Path):
        if vehicle_file is not None:
            raise BadInput("vehicle and vehicle_file are both files of parameters; give one")
        vehicle_file, vehicle = vehicle, None
    if vehicle_file is not None:
        model = from_file(model, vehicle_file, model.name, (*(kind.name for kind in VEHICLES), model.name))
    if vehicle:
        model = override(model, vehicle)
    if stiffness is not None:
        if chosen.roles.get("static spring") != "k":
            raise BadInput(
                f"a static stiffness does not fit {name}; quarter-car takes one, and a model whose static spring is k"
            )
        model = override(model, {"k": stiffness}, where="stiffness")
    chosen = dataclasses.replace(chosen, vehicle=model)
    if body is not None:
        chosen = with_body(chosen, body)
        model = chosen.vehicle
    if speed is not None:
        if "V" not in parameters(model):
            raise BadInput(f"a speed does not fit {name}")
        speeds = [float(speed)] if isinstance(speed, int | float) else [float(one) for one in speed]
        if not 1 <= len(speeds) <= _MOST_SPEEDS:
            raise BadInput(f"{len(speeds)} speeds are too {'many' if speeds else 'few'}; give 1 to {_MOST_SPEEDS}")
        model = override(model, {"V": speeds[0]}, where="speed")
        worst_case = [*({"V": one} for one in speeds[1:]), *worst_case]
    chosen = dataclasses.replace(chosen, vehicle=model)
    if track is not None or wavelengths is not None:
        chosen = on_track(chosen, PAPER if track is None else track, wavelengths)
    if at is not None:
        if chosen.free:
            raise BadInput(f"{name} leaves {listed(chosen.free)} free, so its device stays where it is")
        there = seen_from(chosen.vehicle, at)
        named = chosen.name if there is chosen.vehicle else f"{chosen.name} at {at}"
        chosen = dataclasses.replace(chosen, name=named, vehicle=there)
    if ranges is not None:
        chosen = dataclasses.replace(chosen, ranges=_ranges(ranges, chosen.usual))
    if elements is not None:
        chosen = dataclasses.replace(chosen, elements=_elements(elements, chosen))
    if limits:
        chosen = limited(chosen, limits)
    return over_points(chosen, worst_case) if worst_case else chosen


def _named(name: str) -> Problem:
    if name not in _PROBLEMS:
        raise BadInput(f"unknown problem {shown(name)}; {hint(name, [*_PROBLEMS, 'a path ending in .toml'])}")
    return _PROBLEMS[name]


def _of_file(text: str) -> Problem:
    """The problem of a file of the user's; its errors name the line."""
    asked = read_problem(text)
    if isinstance(asked, Problem):
        return asked
    made = Problem(asked.name, asked.summary, asked.vehicle, asked.minimise, asked.keep)
    try:
        made = minimising(made, asked.minimise)
    except BadInput as error:
        raise asked.wrong("minimise", error) from None
    try:
        return limited(made, asked.limits)
    except BadInput as error:
        raise asked.wrong("limits", error) from None


def is_named(problem: Problem) -> bool:
    """Whether a name and values of parameters say all of a problem's vehicle: not of one from a file."""
    return problem.name in _PROBLEMS and bool(parameters(problem.vehicle))


def as_problem(given: Problem | str) -> Problem:
    """A problem, or the one of that name.

    Raises
    ------
    BadInput
        If it is neither.
    """
    if isinstance(given, Problem):
        return given
    if isinstance(given, str):
        return problem(given)
    raise BadInput(f"{shown(given)} is no problem; give a Problem, or the name of one: {listed(_PROBLEMS)}")


def vehicle(name: str, file: Any = None) -> Vehicle:
    """A vehicle by its own name or by that of a problem, with the parameters of a file laid over it.

    Raises
    ------
    BadInput
        For an unknown name, or a bad file.
    """
    models: dict[str, Vehicle] = {kind.name: kind() for kind in VEHICLES}
    if is_problem_file(name):
        model = _of_file(name).vehicle
    elif name in models:
        model = models[name]
    elif name in _PROBLEMS:
        model = _PROBLEMS[name].vehicle
    else:
        raise BadInput(f"unknown vehicle {shown(name)}; {hint(name, [*models, *_PROBLEMS, 'a path ending in .toml'])}")
    return model if file is None else from_file(model, file, model.name, (*models, model.name))


def _ranges(given: Any, usual: UsualRanges | None) -> UsualRanges:
    if isinstance(given, UsualRanges):
        return given
    return ranges_from(given, usual) if isinstance(given, Mapping) else read_ranges(given, usual)


def _elements(given: Any, problem: Problem) -> RealElements:
    if isinstance(given, RealElements):
        return given
    if given != "real":
        return read_elements(given)
    if problem.place.elements is None:
        raise BadInput(f"of {problem.name} no real elements are known; give a TOML catalogue")
    return problem.place.elements


def minimising(problem: Problem, objective: str) -> Problem:
    """The problem with another objective: a metric of the vehicle, or a weighted sum such as ``J1 + 0.001*J3``.

    ``whole-band`` is the twin of a ride to 20 Hz that does not end there.

    Raises
    ------
    BadInput
        Naming what the vehicle has.
    """
    metrics = problem.vehicle.metrics
    known = [name for name, one in metrics.items() if one.norm() is not None or isinstance(one, PeakInTime)]
    whole = whole_band_twin(problem.vehicle, problem.objective)
    if objective == "whole-band" and whole is not None:
        return dataclasses.replace(problem, objective=whole, goal=None)
    if objective == "whole-band" and problem.whole_band:
        return problem
    if objective in known:
        return dataclasses.replace(problem, objective=objective, goal=None)
    goal = weighted_sum(objective) if "+" in objective else None
    if goal is None or not all(part in known for part, _ in goal.parts):
        also = "" if whole is None else "whole-band, "
        raise BadInput(
            f"objective {shown(objective)} does not fit {problem.name}; it takes {also}{listed(known)}, or a weighted "
            f"sum such as {known[0]} + 0.001*{known[-1]}"
        )
    return dataclasses.replace(problem, objective=goal.name, goal=goal)


def over_points(problem: Problem, points: Sequence[Mapping[str, Any]]) -> Problem:
    """The problem whose objective is the worst over its nominal vehicle and several operating points.

    Constraints hold at each: a limit as the number that it is, "no worse than the default" as no worse than the default
    suspension in that point's vehicle.

    Raises
    ------
    BadInput
        For a parameter that the vehicle does not have, or a value out of range.
    """
    if not parameters(problem.vehicle):
        raise BadInput(f"{problem.name} is a plant of the user's own, which has no parameters to vary by name")
    checked = []
    for point in points:
        changed = override(problem.vehicle, point, where="operating point")
        checked.append({name: float(getattr(changed, name)) for name in point})
        clash = set(point) & set(problem.free)
        if clash:
            raise BadInput(f"{listed(sorted(clash))} is free in {problem.name}, so no operating point can set it")
    objective = problem.objective if problem.points else WORST_CASE + problem.objective
    return dataclasses.replace(problem, objective=objective, points=(*problem.points, *checked))
