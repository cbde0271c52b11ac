"""Commands about how far from the best possible: bound, check-bound."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from posreal.cli.options import (
    AsJson,
    Body,
    CutOff,
    Objective,
    Position,
    ProblemName,
    Seed,
    Speed,
    Standard,
    Stiffness,
    TrackName,
    VehicleFile,
    Wavelengths,
    WeightingName,
    orders,
    posed,
)
from posreal.cli.output import print_json, progress
from posreal.errors import BadInput, plain, shown


def bound(
    problem: ProblemName,
    effort: Annotated[int, typer.Option(min=0, max=3, help="How many points to spend: seconds to minutes.")] = 1,
    truncation: Annotated[
        int | None, typer.Option("--points", min=1, max=201, help="Dimension instead: one a point, two a pair.")
    ] = None,
    omega0: Annotated[
        str | None, typer.Option(help="Where the points lie, rad/s, such as 20 or 10,30; a pair is FREQUENCY:DAMPING.")
    ] = None,
    beside: Annotated[
        str,
        typer.Option(
            "--orders",
            help="The price of simplicity: synthesise these orders to show beside it, such as 1,2,4,8 (high orders "
            "take minutes); '' for none.",
        ),
    ] = "1,2",
    device: Annotated[str | None, typer.Option(help="A device to show beside it instead.")] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the certificate as JSON.")] = None,
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
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Prove what no positive-real device can go below."""
    from posreal.bounds.compute import bound as search
    from posreal.bounds.guard import held
    from posreal.files import require_writable
    from posreal.optimisation.evaluate import evaluate
    from posreal.specification.conditions import conditions, in_words
    from posreal.study.price_of_simplicity import reached

    question = posed(
        problem,
        vehicle,
        position,
        objective,
        stiffness,
        track=track,
        wavelengths=wavelengths,
        speed=speed,
        body=body,
        weighting=weighting,
        standard=standard,
        cut_off=cut_off,
    )
    if save is not None:
        require_writable(save)
    design = None if device is None else evaluate(question, device)
    if design is not None and (design.problem.vehicle != question.vehicle or held(design) != question.mounting):
        raise BadInput(
            f"--device {plain(device, 60)} changes the vehicle, or brings a static spring or bush of its own, and the "
            "bound is over the devices of the vehicle as given; use --vehicle or --stiffness"
        )
    places = None if omega0 is None else [_place(part) for part in omega0.split(",")]
    rows: tuple[Any, ...] = ()
    with progress() as say:
        found = search(
            question, effort=effort, L=truncation and truncation - 1, omega0=places, both_sides=True, progress=say
        )
        if design is not None:
            found = found.beside(design)
        elif beside.strip():
            rows = reached(found, orders(beside), seed=seed, progress=say)
            found = found.beside(min(rows, key=lambda row: row.value).design)
    if save is not None:
        found.save(save)
    if as_json:
        per_order = [{"order": r.order, "value": r.value, "gap_percent": r.gap_percent} for r in rows]
        print_json(found.to_dict() | ({"orders": per_order} if rows else {}))
        return
    print(f"{question.name}: {found}")
    words, band = in_words(question, whole_band=True), conditions(question).get("band")
    print(f"  {words}\n" if words else "", end="")
    if band is not None and band[1] is not None:
        print(
            f"  {found.metric} ends at {band[1]:g} Hz elsewhere and is smaller there; all figures here are over the "
            "whole band"
        )
    for row in rows:
        line = f"  order {row.order} reaches {row.value:.6g} {found.unit}, the bound is {row.gap_percent:.3g} % below"
        if found.attained is not None:
            above = 100 * (row.value / found.attained.value - 1)
            line += f"; {above:.2g} % above what order {found.attained.device.order} reaches" if above > 0 else ""
        print(line)


def _place(text: str) -> float | tuple[float, float]:
    """20, or 50:0.4 for a pair."""

    try:
        frequency, *damping = map(float, text.split(":"))
    except ValueError:
        frequency, damping = math.nan, []
    if not 1e-6 <= frequency <= 1e9 or len(damping) > 1 or not all(1e-6 <= one <= 1e6 for one in damping):
        raise BadInput(
            f"--omega0 {shown(text)} is not a frequency such as 20, from 1e-6 to 1e9 rad/s, or a pair such as 50:0.4"
        )
    return (frequency, damping[0]) if damping else frequency


def check_bound(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A certificate that `bound --save` wrote.")],
    as_json: AsJson = False,
) -> None:
    """Prove a saved bound again from its certificate; exit code 0 or 1."""

    from posreal.bounds.file import load_bound

    found = load_bound(file)
    proof = found.check()
    if as_json:
        document = found.to_dict()
        claim = {"proven": proof, "bound": document["bound"], "gap_percent": found.gap_percent}
        print_json(claim | {"holds_for": document["holds_for"], "about": found.described()})
        return
    print("\n  ".join([str(found), *found.described()]))
    print(f"proven again: {plain(found.metric, 80)} ≥ {proof:.10g} {plain(found.unit, 20)}")
