"""Under what a problem's figures hold: the track, the speed, the weighting, and the band.

A statement such as "S5 is 12 % better" is true of one track, one speed and one weighting, and of others it may be
false; so they stand in the title of every table and in every JSON document.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from posreal.errors import BadInput, listed, shown
from posreal.metric import ClosedVehicle, Norm
from posreal.plant.sampled import SampledDensity
from posreal.specification.problem import Problem
from posreal.vehicle import parameters
from posreal.vehicle.flexible_body import BEAM_ENDS, FlexibleBody, read_body
from posreal.vehicle.track import PAPER, Track, paper
from posreal.vehicle.weighting import Weighting

_LOWEST_CUT, _HIGHEST_CUT = 0.1, 1000.0  # Hz
_LOST = 1.0  # % of the ride that missing wavelengths may cost unsaid
_ENOUGH = 100.0  # Hz, from where a weighted figure is over all frequencies: weightings end there by themselves


def in_weighting(problem: Problem, name: str | Weighting) -> Problem:
    """The problem with its ride figures weighted: objective, what is kept, and the columns of tables.

    Raises
    ------
    BadInput
        For an unknown weighting, or a vehicle without a body whose acceleration is weighted.
    """
    if name == "none":
        return problem
    chosen = Weighting(name) if isinstance(name, str) else name
    if not problem.vehicle.weighted:
        raise BadInput(
            f"a weighting does not fit {problem.name}; it is of the body's acceleration in a rail vehicle, as in "
            "vertical-comfort or lateral-comfort"
        )
    vehicle = dataclasses.replace(problem.vehicle, weighting=chosen)  # type: ignore[type-var]
    twins = vehicle.weighted
    goal = problem.goal
    if goal is not None:
        goal = dataclasses.replace(goal, parts=tuple((twins.get(part, part), weight) for part, weight in goal.parts))
    return dataclasses.replace(
        problem,
        vehicle=vehicle,
        objective=twins.get(problem.objective, problem.objective) if goal is None else goal.name,
        keep=tuple(twins.get(kept, kept) for kept in problem.keep),
        goal=goal,
    )


def standard_weighting(problem: Problem, standard: str, weighting: str | Weighting | None) -> str:
    """The weighting of a standard for the direction in which a problem's vehicle is shaken.

    Raises
    ------
    BadInput
        For a standard that is not known, or one that comes with another weighting.
    """
    if standard.lower().replace(" ", "") != "en12299":
        raise BadInput(f"no standard is called {shown(standard)}; accepted is en12299")
    if weighting is not None:
        raise BadInput(f"{standard} brings its own weighting; leave out {weighting}")
    return "Wd" if problem.vehicle.direction == "lateral" else "Wb"


def cut(problem: Problem, hertz: float) -> Problem:
    """The problem with its ride figures ending at a frequency.

    Raises
    ------
    BadInput
        For a frequency that is none, or a vehicle whose figures end nowhere else.
    """
    if not _LOWEST_CUT <= hertz <= _HIGHEST_CUT:
        raise BadInput(f"the cut-off is {hertz:g} Hz; give from {_LOWEST_CUT:g} to {_HIGHEST_CUT:g} Hz")
    if not problem.vehicle.weighted:
        raise BadInput(f"a cut-off does not fit {problem.name}; it is where a rail vehicle's ride figure ends")
    vehicle = dataclasses.replace(problem.vehicle, cut_off=float(hertz))  # type: ignore[type-var]
    names = [problem.objective] if problem.goal is None else [name for name, _ in problem.goal.parts]
    rides = [name for name in (*names, *problem.keep) if name in vehicle.weighted]
    other = dataclasses.replace(vehicle, cut_off=2 * hertz)  # type: ignore[type-var]
    fixed = [name for name in rides if vehicle.metrics[name] == other.metrics[name]]
    if fixed:
        raise BadInput(
            f"a cut-off does not fit {problem.name}: {listed(fixed)} ends at 20 Hz, as the sum of [Jiang2012] does; "
            "with a weighting it does fit"
        )
    return dataclasses.replace(problem, vehicle=vehicle)


def on_track(problem: Problem, track: str | Track, wavelengths: tuple[float, float] | None = None) -> Problem:
    """The problem on another track, or on some wavelengths, m, of one.

    Raises
    ------
    BadInput
        For an unknown track, one without what shakes this vehicle, or wavelengths that leave nothing.
    """
    direction = problem.vehicle.direction
    if direction is None:
        raise BadInput(f"a track does not fit {problem.name}; it is what a rail vehicle runs on")
    chosen = Track.read(track) if isinstance(track, str) else track
    if chosen.name == PAPER and wavelengths is None:
        return problem
    if chosen.name == PAPER and direction == "vertical":
        chosen = paper(float(parameters(problem.vehicle)["Av"]))
    if wavelengths is not None:
        chosen = chosen.between(*wavelengths)
    if not (direction == "lateral" and chosen.lateral_of_the_paper and wavelengths is None):
        chosen.spectrum(direction)
    vehicle = dataclasses.replace(problem.vehicle, irregularity=chosen)  # type: ignore[type-var]
    return dataclasses.replace(problem, vehicle=vehicle)


def with_body(problem: Problem, body: str | FlexibleBody) -> Problem:
    """The problem with a body that bends: ``flexible``, ``8.5 Hz,1.5%,2``, or a :class:`FlexibleBody`.

    Raises
    ------
    BadInput
        For a body that is none, or a vehicle whose body does not bend where it is shaken.
    """
    chosen = read_body(body) if isinstance(body, str) else body
    if problem.vehicle.direction != "vertical":
        raise BadInput(f"a flexible body does not fit {problem.name}; it is of a vehicle seen from the side")
    return dataclasses.replace(problem, vehicle=dataclasses.replace(problem.vehicle, body=chosen))  # type: ignore[type-var]


def conditions(problem: Problem) -> dict[str, Any]:
    """Track, speed (m/s), weighting and band (Hz) of a problem's figures; empty for a plant of one's own.

    Where the objective is the largest over a range of speeds, the speed is the highest, and ``speeds`` says so.
    """
    vehicle = problem.vehicle
    if not parameters(vehicle):
        return {}
    norms = _norms(problem)
    speeds = {norm.speed for norm in norms if norm.speed is not None}
    ends = {norm.stop / (2 * math.pi) for norm in norms}
    found: dict[str, Any] = {}
    if vehicle.direction is not None:
        found["track"] = PAPER if vehicle.irregularity is None else vehicle.irregularity.name
    if speeds or vehicle.V > 0:  # a structure has none
        found["speed"] = max(speeds, default=vehicle.V)
    if speeds:
        found["speeds"] = "up to"
    others = [dict(point) for point in problem.points]
    if others:
        found["also_at"] = others
    if vehicle.direction == "vertical":
        found["body"] = "rigid" if vehicle.body is None else str(vehicle.body)
    found["weighting"] = "none" if vehicle.weighting is None else vehicle.weighting.name
    if ends:
        (end,) = ends if len(ends) == 1 else (math.nan,)
        found["band"] = [0.0, None if math.isinf(end) else end] if not math.isnan(end) else None
    return found


def in_words(problem: Problem, *, whole_band: bool = False) -> str:
    """The same as a line for a title; `whole_band`: of what a bound says, which never ends."""
    found = conditions(problem)
    if not found:
        return ""
    track, said = found.get("track"), []
    if track is not None:
        near = "the filter near " if whole_band and stand_in(problem) is not None else ""
        said.append("on the paper's track" if track == PAPER else f"on {near}{track}")
    if "speed" in found:
        said.append(f"at{' speeds up to' if found.get('speeds') else ''} {found['speed']:.6g} m/s")
        said = [(", " if "," in said[0] else " ").join(said)]
    if found.get("also_at"):
        count = 1 + len(found["also_at"])
        over = sorted({*(point["V"] for point in found["also_at"] if "V" in point), found.get("speed", math.nan)})
        only = all(set(point) == {"V"} for point in found["also_at"])
        said.append(
            f"worst of {count} speeds from {over[0]:g} to {over[-1]:g} m/s" if only else f"worst of {count} points"
        )
    said += [f"body {found['body']}"] if found.get("body", "rigid") != "rigid" else []
    weighting = found["weighting"]
    said.append("unweighted" if weighting == "none" else f"weighted by {weighting}")
    band = found.get("band")
    if whole_band:
        band = [0.0, None]
    if band is not None:
        said.append("over all frequencies" if band[1] is None else f"up to {band[1]:.6g} Hz")
    return ", ".join(said)


def cautions(problem: Problem) -> list[str]:
    """What has to be known before a figure is believed."""
    found = []
    for norm in _norms(problem):
        end = norm.stop / (2 * math.pi)
        if problem.vehicle.weighting is not None and norm.load != problem.vehicle.random and end < _ENOUGH:
            found.append(
                f"the weighted figure is cut at {end:.6g} Hz: a search then lets a device ring just above, where "
                f"{problem.vehicle.weighting} still counts; leave --cut-off out"
            )
            break
    body = problem.vehicle.body
    if body is not None and not body.measured and body.highest > BEAM_ENDS:
        found.append(
            f"the body's highest mode is at {body.highest:.3g} Hz, and above {BEAM_ENDS:g} Hz a coach is no uniform "
            "beam: take fewer modes, or measured ones"
        )
    return [*found, *_of_missing_wavelengths(problem), *_of_a_fit(problem)]


def _of_missing_wavelengths(problem: Problem) -> list[str]:
    """What of the ride is lost where a track ends at wavelengths that matter at the speed."""
    vehicle, port = problem.vehicle, problem.default_port
    track, direction = vehicle.irregularity, vehicle.direction
    if track is None or direction is None or port is None or (direction == "lateral" and track.lateral_of_the_paper):
        return []
    spectrum = track.spectrum(direction)
    names = [name for name, norm in _named_norms(problem) if norm.load != "slope"]
    if not spectrum.ends or not names:
        return []
    whole = Track(f"{track}, and on", spectrum.extended, spectrum.extended, "")
    values = [
        vehicle.metrics[names[0]].measure(ClosedVehicle(one, {"secondary": port}, confirmed=False)).value
        for one in (vehicle, dataclasses.replace(vehicle, irregularity=whole))  # type: ignore[type-var]
    ]
    lost = 100 * (1 - values[0] / values[1])
    if lost < _LOST:
        return []
    (short, long), speed = spectrum.band, conditions(problem)["speed"]
    return [
        f"the track has {short:.4g} to {long:.4g} m and nothing else, which at {speed:.6g} m/s are "
        f"{speed / long:.3g} to {speed / short:.3g} Hz: if its spectrum went on beyond, {names[0]} of the default "
        f"suspension would be {100 * (values[1] / values[0] - 1):.3g} % larger"
    ]


def stand_in(problem: Problem) -> SampledDensity | None:
    """The density of a track that no filter has, where inequalities and bounds are about a filter near it."""
    vehicle = problem.vehicle
    shaping = vehicle.plant(vehicle.random).shaping if vehicle.irregularity is not None else None
    return shaping if isinstance(shaping, SampledDensity) else None


def _of_a_fit(problem: Problem) -> list[str]:
    vehicle, shaping = problem.vehicle, stand_in(problem)
    if shaping is None:
        return []
    how = (
        f"a filter whose density is {shaping.rms_db:.2g} dB r.m.s. from it and {shaping.max_db:.2g} dB at most"
        if shaping.rms_db > 0
        else "the filter that does not end there"
    )
    return [
        f"no filter has exactly the density of {vehicle.irregularity}: figures here are of itself, but matrix "
        f"inequalities and bounds take {how}"
    ]


def _norms(problem: Problem) -> list[Norm]:
    """Of the mean squares that the objective is made of."""
    return [norm for _, norm in _named_norms(problem)]


def _named_norms(problem: Problem) -> list[tuple[str, Norm]]:
    names = [problem.base_objective] if problem.goal is None else [name for name, _ in problem.goal.parts]
    norms = [(name, problem.vehicle.metrics[name].norm()) for name in names]
    return [(name, norm) for name, norm in norms if norm is not None and norm.kind == "H2"]
