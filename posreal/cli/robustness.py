"""Commands that ask what is left of a design when it is built: tolerance, simulate, preferred."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from posreal.cli.options import (
    AsJson,
    At,
    Body,
    CutOff,
    DeviceWords,
    ElementTolerance,
    Jobs,
    Limit,
    Objective,
    Parts,
    Position,
    ProblemName,
    Ranges,
    Seed,
    Speed,
    Standard,
    Stiffness,
    TrackName,
    VehicleFile,
    VehicleTolerance,
    Wavelengths,
    WeightingName,
    WorstCase,
    job_count,
    number,
    posed,
    words,
)
from posreal.cli.output import print_json, progress
from posreal.errors import BadInput, shown


def tolerance(
    problem: ProblemName,
    device: DeviceWords,
    elements: ElementTolerance = None,
    of_vehicle: VehicleTolerance = None,
    draws: Annotated[int, typer.Option(min=1, max=100_000, help="Vehicles that are drawn.")] = 500,
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    track: TrackName = None,
    wavelengths: Wavelengths = None,
    speed: Speed = None,
    body: Body = None,
    weighting: WeightingName = None,
    standard: Standard = None,
    cut_off: CutOff = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    at: At = None,
    parts: Parts = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    backend: Annotated[str | None, typer.Option(help="loky, threading or dask.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster.")] = None,
    as_json: AsJson = False,
) -> None:
    """Spread of every metric and yield of every constraint, with every value within its tolerance."""
    from posreal.optimisation.evaluate import read_design
    from posreal.specification.tolerances import TOLERANCE
    from posreal.study.tolerance import tolerance as study

    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        limit,
        worst_case,
        at,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
        parts=parts,
    )
    design = read_design(question, words(device))
    with progress() as say:
        found = study(
            design,
            tolerance=TOLERANCE if elements is None else elements,
            vehicle=of_vehicle,
            draws=draws,
            seed=seed,
            jobs=job_count(jobs),
            backend=backend,
            scheduler=scheduler,
            progress=say,
        )
    if as_json:
        print_json({"problem": question.name, **found.to_dict()})
        return
    print(f"{question.name}: {' '.join(device)}\n{found}")


def preferred(
    problem: ProblemName,
    device: DeviceWords,
    steps: Annotated[
        str,
        typer.Option(
            "--series", metavar="NAME|FILE", help="R5 to R40 or E3 to E24, or a TOML file of a maker's values."
        ),
    ] = "R20",
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    track: TrackName = None,
    wavelengths: Wavelengths = None,
    speed: Speed = None,
    body: Body = None,
    weighting: WeightingName = None,
    standard: Standard = None,
    cut_off: CutOff = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    at: At = None,
    ranges: Ranges = None,
    parts: Parts = None,
    as_json: AsJson = False,
) -> None:
    """The best listed values, of a series or a maker's, in place of those of a device."""
    from posreal.optimisation.evaluate import read_design
    from posreal.study.preferred import preferred as study

    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        limit,
        worst_case,
        at,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
        ranges=ranges,
        parts=parts,
    )
    design = read_design(question, words(device))
    with progress() as say:
        found = study(design, steps=steps, progress=say)
    if as_json:
        print_json({"problem": question.name, **found.to_dict()})
        return
    print(f"{question.name}: {' '.join(device)}\n\n{found}")


def simulate(
    problem: ProblemName,
    device: DeviceWords,
    friction: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Coulomb friction: 500 (N, every inerter) or b1=500,c1=200.")
    ] = None,
    backlash: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Total play: 0.3 (mm, in series with the bush) or k1=0.3.")
    ] = None,
    stop: Annotated[
        str | None, typer.Option(metavar="TEXT", help="End stops: 60 (mm either way, every inerter) or b1=60,c1=100.")
    ] = None,
    stop_stiffness: Annotated[str, typer.Option(metavar="VALUE", help="Of an end stop.")] = "10 MN/m",
    records: Annotated[int, typer.Option(min=1, max=1000, help="Records of random track.")] = 8,
    duration: Annotated[float, typer.Option(min=1.0, max=1e4, help="Seconds of each that count.")] = 60.0,
    step: Annotated[float, typer.Option(min=0.01, max=10.0, help="Time step at most, ms.")] = 1.0,
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    at: At = None,
    parts: Parts = None,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Simulate a device with friction, backlash and end stops in its elements, on random track and onto ramps."""
    from posreal.optimisation.evaluate import read_design
    from posreal.study.simulate import simulate as study

    question = posed(problem, vehicle, position, objective, stiffness, at=at, parts=parts)
    design = read_design(question, words(device))
    with progress() as say:
        found = study(
            design,
            friction=_of_elements("--friction", friction, "N", 1.0, 0.0),
            backlash=_of_elements("--backlash", backlash, "m", 1e-3, 0.0),
            stop=_of_elements("--stop", stop, "m", 1e-3, math.inf),
            stop_stiffness=number("--stop-stiffness", stop_stiffness, "N/m"),
            records=records,
            duration=duration,
            step=1e-3 * step,
            seed=seed,
            progress=say,
        )
    if as_json:
        print_json({"problem": question.name, **found.to_dict()})
        return
    print(f"{question.name}: {' '.join(device)}\n{found}")


def _of_elements(option: str, text: str | None, unit: str, plain: float, none: float) -> float | dict[str, float]:
    """``500`` or ``b1=500,c1=200 N``; a bare number counts `plain` of the unit."""
    if text is None:
        return none
    found: dict[str, float] = {}
    for word in text.split(","):
        name, equals, value = word.rpartition("=")
        try:
            size = plain * float(value)
        except ValueError:
            size = number(option, value.strip(), unit)
        if not math.isfinite(size):
            raise BadInput(f"{option} {shown(text)}: give a finite number")
        if not equals:
            if "," in text:
                raise BadInput(f"{option} {shown(text)}: give one number for all, or a name with each, such as b1=500")
            return size
        found[name.strip()] = size
    return found
