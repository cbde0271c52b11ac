"""The command that looks for networks: search."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from posreal.cli.options import (
    AnyValues,
    Ascii,
    AsJson,
    BandOnly,
    Body,
    CutOff,
    ElementTolerance,
    Jobs,
    Objective,
    Position,
    ProblemName,
    Ranges,
    Robust,
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
    made_robust,
    orders,
    posed,
    refuse_both,
)
from posreal.cli.output import print_json, progress
from posreal.errors import BadInput


def search(
    problem: ProblemName,
    elements: Annotated[int, typer.Option(min=1, max=7, help="The most elements, bush or static spring not counted.")],
    at_most: Annotated[
        str | None, typer.Option(help="The most of a kind, such as springs=2,inerters=1 or reactive=2.")
    ] = None,
    bounds: Annotated[
        list[str] | None,
        typer.Option(metavar="KIND=LEAST:GREATEST", help="Values allowed, such as 'k=10 kN/m:5 MN/m'."),
    ] = None,
    any_values: AnyValues = False,
    ranges: Ranges = None,
    parts: Annotated[
        str | None,
        typer.Option(metavar="real|FILE", help="Real elements in place of ideal ones: real, or a TOML catalogue."),
    ] = None,
    limit: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC=VALUE", help="A metric that may not exceed a value, in its unit."),
    ] = None,
    metric: Annotated[str | None, typer.Option(help="Trade the objective against this metric too.")] = None,
    to_orders: Annotated[
        str | None, typer.Option("--orders", help="Orders of synthesised devices to compare with, such as 1,2,3.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the front: .png, .svg or .pdf.")] = None,
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
    band_only: BandOnly = False,
    worst_case: WorstCase = None,
    robust: Robust = False,
    of_elements: ElementTolerance = None,
    of_vehicle: VehicleTolerance = None,
    starts: Annotated[int | None, typer.Option(min=1, max=1000, help="Random starts for each topology.")] = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    backend: Annotated[str | None, typer.Option(help="loky, threading or dask.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster.")] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Keep results here as they come, and go on from them.")
    ] = None,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Find the best networks of up to so many elements: what every further part buys."""
    from posreal.bounds.compute import bound as prove
    from posreal.files import require_writable
    from posreal.specification.conditions import stand_in
    from posreal.study.drawing import FORMATS
    from posreal.study.pareto import pareto
    from posreal.study.robust import as_drawn, beside
    from posreal.topology.options import read_at_most, read_bounds, read_limits
    from posreal.topology.search import search as find

    refuse_both(any_values, ranges)
    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        worst_case=worst_case,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
        ranges=ranges,
        band_only=band_only,
        parts=parts,
    )
    if parts is not None and robust:
        raise BadInput("--robust improves the values of ideal elements; leave out --parts")
    asked = made_robust(question, robust, of_elements, of_vehicle)
    if plot is not None:
        require_writable(plot, FORMATS)
    compared = [] if to_orders is None else orders(to_orders)
    with progress() as say:
        found = find(
            asked,
            elements,
            at_most=None if at_most is None else read_at_most(at_most),
            bounds=read_bounds(bounds or []),
            any_values=any_values,
            limits=read_limits(limit or []),
            metric=metric,
            starts=starts,
            seed=seed,
            jobs=job_count(jobs),
            backend=backend,
            scheduler=scheduler,
            checkpoint=checkpoint,
            progress=say,
        )
        floor = None
        if question.whole_band and not question.points and stand_in(question) is None:
            say("proving a bound")
            with suppress(BadInput):  # of a sum with a gain in it none is known
                floor = prove(question, effort=0, progress=say).value
        front = pareto(found, orders=compared, bound=floor, seed=seed, progress=say)
        best = found.best
        kept = beside(as_drawn(best), best, seed=seed, jobs=job_count(jobs), progress=say) if robust else None
    if plot is not None:
        front.draw(plot)
    if as_json:
        extra = {} if kept is None else {"robust": kept.to_dict()}
        print_json(front.to_dict() | {"plot": None if plot is None else str(plot)} | extra)
        return
    print(front.text(ascii=ascii))
    print("" if kept is None else f"\nThe best of them. {kept}\n", end="")
    if plot is not None:
        print(f"\nwrote {plot}")
