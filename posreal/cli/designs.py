"""Commands that put devices into vehicles: evaluate, optimise, synthesise."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from posreal.cli.options import (
    AnyValues,
    Ascii,
    AsJson,
    At,
    BandOnly,
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
    Robust,
    Seed,
    Speed,
    Standard,
    Starts,
    Stiffness,
    Sweep,
    TrackName,
    VehicleFile,
    VehicleTolerance,
    Wavelengths,
    WeightingName,
    Width,
    WorstCase,
    Write,
    job_count,
    made_robust,
    posed,
    refuse_both,
    words,
)
from posreal.cli.output import (
    check_paths,
    network_dict,
    print_design,
    print_json,
    print_network,
    progress,
    readable,
    write_network,
)
from posreal.errors import BadInput

if TYPE_CHECKING:
    from posreal.study.robust import RobustDesign

NETWORKS = ", every figure recomputed from the network below"


def evaluate(
    problem: ProblemName,
    device: DeviceWords,
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
    sweep: Sweep = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    at: At = None,
    ranges: Ranges = None,
    parts: Parts = None,
    three_ways: Annotated[
        bool, typer.Option("--three-ways", help="Ride by frequency, by covariance, and on a simulated track.")
    ] = False,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Print every metric of a device."""
    from posreal.optimisation.evaluate import read_design
    from posreal.specification.design import metrics_to_dict
    from posreal.study.cross_check import three_ways as ride
    from posreal.study.sweep import read_ranges
    from posreal.study.sweep import sweep as vary

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
    over = read_ranges(question, sweep or [])
    design = read_design(question, words(device))
    varied = vary(design, over) if over else None
    ways = ride(design, seed=seed) if three_ways else None
    if as_json:
        document: dict[str, Any] = {"problem": question.name, "device": design.to_dict()["device"]}
        document["metrics"] = metrics_to_dict(design.metrics)
        document |= {key: design.to_dict()[key] for key in ("constraints", "conditions", "cautions")}
        document["notes"] = list(design.found.get("notes", ()))
        document |= {key: design.to_dict()[key] for key in ("outside_usual", "elements", "ideal")}
        if varied is not None:
            document["sweep"] = varied.to_dict()
        if ways is not None:
            document["three_ways"] = ways.to_dict()
        print_json(document)
        return
    print_design(design, heading=f"{question.name}: {' '.join(device)}")
    for extra in (varied, ways):
        if extra is not None:
            print(f"\n{extra}")


def optimise(
    problem: ProblemName,
    layout: Annotated[list[str], typer.Argument(metavar="LAYOUT...", help="Layouts' names, or TOML files.")],
    any_values: AnyValues = False,
    ranges: Ranges = None,
    parts: Parts = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    robust: Robust = False,
    elements: ElementTolerance = None,
    of_vehicle: VehicleTolerance = None,
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
    sweep: Sweep = None,
    starts: Starts = 6,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Find the best element values of one or more layouts."""
    from posreal.optimisation.layout_values import optimise as search
    from posreal.specification.layout import layout as named
    from posreal.study.robust import beside
    from posreal.study.sweep import read_ranges
    from posreal.study.sweep import sweep as vary

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
        band_only=band_only,
        parts=parts,
    )
    over = read_ranges(question, sweep or [])
    asked = made_robust(question, robust, elements, of_vehicle)
    chosen = [named(name) for name in layout]
    for entry in chosen:
        entry.require(question)
    common: dict[str, Any] = {"seed": seed, "jobs": job_count(jobs)}
    with progress() as say:
        found = dict(common, any_values=any_values, starts=starts, progress=say)
        designs = [search(asked, entry, **found) for entry in chosen]
        worth: list[RobustDesign | None] = [None for _ in designs]
        if robust:
            drawn = [search(question, entry, **found) for entry in chosen]
            worth = [beside(*pair, progress=say, **common) for pair in zip(drawn, designs, strict=True)]
    swept = [vary(design, over) if over else None for design in designs]
    if as_json:
        rows = zip(designs, swept, worth, strict=True)
        print_json({"designs": [d.to_dict() | _extra(sweep=s, robust=w) for d, s, w in rows]})
        return
    for number, (entry, design, varied, kept) in enumerate(zip(chosen, designs, swept, worth, strict=True)):
        print(end="\n" if number else "")
        print_design(design, heading=f"{question.name}: {design.label}, {entry.network}", draw=True, ascii=ascii)
        print("" if kept is None else f"\n{kept}\n", end="")
        print("" if varied is None else f"\n{varied}\n", end="")


def synthesise(
    problem: ProblemName,
    order: Annotated[int, typer.Option(min=0, max=12, help="McMillan degree of the device.")],
    method: Annotated[str, typer.Option(help="auto, or bmi for the iterated SDPs alone.")] = "auto",
    realise: Annotated[bool, typer.Option(help="Realise the device as a network.")] = True,
    prune: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Part of the objective that leaving out elements may cost in all.")
    ] = 5e-4,
    spring: Annotated[
        bool, typer.Option("--spring", help="A free spring beside the device, on top of the order.")
    ] = False,
    inerter: Annotated[bool, typer.Option("--inerter", help="A free inerter beside it, likewise.")] = False,
    ranges: Ranges = None,
    parts: Parts = None,
    limit: Limit = None,
    worst_case: WorstCase = None,
    robust: Robust = False,
    elements: ElementTolerance = None,
    of_vehicle: VehicleTolerance = None,
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
    sweep: Sweep = None,
    starts: Annotated[int | None, typer.Option(min=1, max=10_000, help="Local searches.")] = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    write: Write = None,
    as_json: AsJson = False,
    ascii: Ascii = False,
    width: Width = 100,
) -> None:
    """Find the best positive-real admittance of an order, then its network."""
    from posreal.optimisation.evaluate import of_real_elements
    from posreal.study.robust import as_drawn, beside
    from posreal.study.strut import mounted, realised
    from posreal.study.sweep import read_ranges
    from posreal.study.sweep import sweep as vary
    from posreal.synthesis.synthesise import synthesise as search

    check_paths(write)
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
        parts=parts,
    )
    over = read_ranges(question, sweep or [])
    real, question = question.elements, replace(question, elements=None)
    if real is not None and not realise:
        raise BadInput("--parts is of a network's elements; leave out --no-realise")
    asked = made_robust(question, robust, elements, of_vehicle)
    if robust and not realise:
        raise BadInput("tolerances are of elements, so that --robust needs the network; leave out --no-realise")
    kept = None
    with progress() as say:
        design = search(
            asked,
            order,
            method=method,
            starts=starts,
            seed=seed,
            spring=spring,
            inerter=inerter,
            jobs=job_count(jobs),
            progress=say,
        )
        if realise:
            say("realising the admittance as a network")
            built, realisation = realised(design, prune=prune, progress=say)
        if robust:
            kept = beside(as_drawn(built), built, seed=seed, jobs=job_count(jobs), progress=say)
    written, ends = [], question.place.terminals
    if realise:
        strut = mounted(built.problem, realisation.network)
        written = write_network(realisation.network, write, strut=strut, terminals=ends)
    shown = built if realise else design
    bought = None if real is None else of_real_elements(shown, real)
    varied = vary(shown, over) if over else None
    if as_json:
        beyond = (*shown.outside, *shown.out_of_stroke)
        network = {"network": network_dict(realisation, ascii, width, ends, beyond=beyond)} if realise else {}
        extra = _extra(sweep=varied, robust=kept, real=bought)
        print_json({"design": shown.to_dict(), "synthesised": design.to_dict(), **network, **extra})
        return
    assert shown.device is not None
    print(f"Device in its place, Y(s) [N s/m], exactly positive real:\n  {readable(shown.device)}\n")
    heading = f"{question.name}: synthesised, order {order}" + (NETWORKS if realise else "")
    print_design(shown if bought is None else bought, heading=heading, usual=not realise)
    if realise:
        print("\nNetwork by ", end="")
        print_network(realisation, ascii, width, shown=strut, terminals=ends, beyond=shown.usual_sentence)
    print("" if kept is None else f"\n{kept}\n", end="")
    print("" if varied is None else f"\n{varied}\n", end="")
    print("\n".join(written), end="\n" if written else "")


def _extra(**parts: Any) -> dict[str, Any]:
    """What stands beside a design in JSON, where there is any."""
    return {name: part.to_dict() for name, part in parts.items() if part is not None}
