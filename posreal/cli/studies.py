"""Commands that put several designs side by side: compare, design, reproduce."""

from __future__ import annotations

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
    Jobs,
    Limit,
    Objective,
    Position,
    ProblemName,
    Ranges,
    Seed,
    Speed,
    Standard,
    Stiffness,
    TrackName,
    VehicleFile,
    Wavelengths,
    WeightingName,
    WorstCase,
    fraction,
    job_count,
    orders,
    posed,
    refuse_both,
)
from posreal.cli.output import (
    print_json,
    progress,
)


def compare(
    problem: ProblemName,
    to_orders: Annotated[
        str, typer.Option("--orders", help="Orders of the synthesised devices, such as 1,2,3.")
    ] = "1,2",
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the rows and the bound: .png, .svg or .pdf.")
    ] = None,
    ranges: Ranges = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
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
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Layouts and synthesised devices side by side, and the best network."""
    from posreal.files import require_writable
    from posreal.study.compare import compare as side_by_side
    from posreal.study.drawing import FORMATS

    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        limit,
        worst_case,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
        ranges=ranges,
        band_only=band_only,
    )
    if plot is not None:
        require_writable(plot, FORMATS)
    with progress() as say:
        comparison = side_by_side(question, orders=orders(to_orders), seed=seed, jobs=job_count(jobs), progress=say)
    if plot is not None:
        comparison.draw(plot)
    if as_json:
        print_json(comparison.to_dict() | {"plot": None if plot is None else str(plot)})
        return
    print(comparison.text(ascii=ascii))
    if plot is not None:
        print(f"\nwrote {plot}")


def design(
    problem: ProblemName,
    elements: Annotated[
        int, typer.Option(min=1, max=7, help="The most elements that are searched, bush or static spring not counted.")
    ] = 4,
    to_orders: Annotated[
        str, typer.Option("--orders", help="Orders of the synthesised devices beside, such as 1,2.")
    ] = "1,2",
    within: Annotated[
        str, typer.Option(help="What a smaller network may cost of the best figure found: 1% or 0.01.")
    ] = "1%",
    draws: Annotated[int, typer.Option(min=1, max=100_000, help="Vehicles that are drawn within tolerances.")] = 500,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="Write one page with everything on it, to hand on.")
    ] = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
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
    ranges: Ranges = None,
    any_values: AnyValues = False,
    parts: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="TOML catalogue of real elements, in place of the place's own."),
    ] = None,
    ideal: Annotated[bool, typer.Option("--ideal", help="Ideal elements in place of real ones.")] = False,
    band_only: BandOnly = False,
    seed: Seed = 0,
    jobs: Jobs = -1,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """The network to build, with what it reaches, what is possible, and what tolerances leave of it."""
    from posreal.files import require_writable
    from posreal.study.recommendation import design as recommend
    from posreal.study.report import SUFFIXES, save

    refuse_both(any_values, ranges)
    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        limit,
        worst_case,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
        ranges=ranges,
        parts=parts,
        band_only=band_only,
    )
    if report is not None:
        require_writable(report, SUFFIXES)
    with progress() as say:
        found = recommend(
            question,
            elements=elements,
            orders=orders(to_orders),
            within=fraction("--within", within),
            any_values=any_values,
            ideal=ideal,
            draws=draws,
            seed=seed,
            jobs=job_count(jobs),
            progress=say,
        )
    written = None if report is None else save(found, report)
    if as_json:
        print_json(found.to_dict() | {"report": None if written is None else str(written)})
        return
    print(found.text(ascii=ascii))
    if written is not None:
        print(f"\nwrote {written}")


def reproduce(
    figures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write Figures 3, 4, 7, 8, 9 and 10 as PNG.")
    ] = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: AsJson = False,
) -> None:
    """Every table and figure of [Jiang2012], published beside computed."""
    from posreal.study.figures import draw, writable
    from posreal.study.reproduce import reproduce as tables

    if figures is not None:
        writable(figures)
    with progress() as say:
        reproduction = tables(seed=seed, jobs=job_count(jobs), progress=say)
        written = [] if figures is None else [str(path) for path in draw(reproduction, figures)]
    if as_json:
        print_json(reproduction.to_dict() | {"figures": written})
        return
    print(reproduction)
    for path in written:
        print(f"wrote {path}")
