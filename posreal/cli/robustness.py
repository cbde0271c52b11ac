"""Commands that ask what is left of a design in the vehicles that are built: tolerance."""

from __future__ import annotations

from typing import Annotated

import typer

from posreal.cli.options import (
    AsJson,
    At,
    CutOff,
    DeviceWords,
    ElementTolerance,
    Jobs,
    Limit,
    Objective,
    Position,
    ProblemName,
    Seed,
    Stiffness,
    VehicleFile,
    VehicleTolerance,
    WeightingName,
    WorstCase,
    job_count,
    posed,
    words,
)
from posreal.cli.output import print_json, progress


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
    weighting: WeightingName = None,
    cut_off: CutOff = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    at: At = None,
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
        problem, vehicle, position, objective, stiffness, limit, worst_case, at, weighting=weighting, cut_off=cut_off
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
