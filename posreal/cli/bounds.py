"""Commands about how far from the best possible: bound, check-bound."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from posreal.cli.options import (
    AsJson,
    Objective,
    Position,
    ProblemName,
    Seed,
    Stiffness,
    VehicleFile,
    orders,
    posed,
)
from posreal.cli.output import print_json, progress


def bound(
    problem: ProblemName,
    effort: Annotated[int, typer.Option(min=0, max=3, help="How many points to spend: seconds to minutes.")] = 1,
    truncation: Annotated[
        int | None, typer.Option("--points", min=1, max=201, help="Number of points instead.")
    ] = None,
    omega0: Annotated[str | None, typer.Option(help="Where the points lie, rad/s, such as 20 or 10,30.")] = None,
    beside: Annotated[
        str, typer.Option("--orders", help="Synthesise these orders to show beside it; '' for none.")
    ] = "2",
    device: Annotated[str | None, typer.Option(help="A device to show beside it instead.")] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the certificate as JSON.")] = None,
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Prove what no positive-real device can go below."""
    from posreal.design import read_design
    from posreal.design.bound import bound as search
    from posreal.design.bound import reached
    from posreal.errors import BadInput

    question = posed(problem, vehicle, position, objective, stiffness)
    try:
        places = None if omega0 is None else [float(part) for part in omega0.split(",")]
    except ValueError:
        raise BadInput(f"--omega0 {omega0!r} is not a list of frequencies such as 20 or 10,30") from None
    rows: tuple[Any, ...] = ()
    with progress() as say:
        found = search(question, effort=effort, L=truncation and truncation - 1, omega0=places, progress=say)
        if device is not None:
            found = found.beside(read_design(question, device.split()))
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
    for row in rows:
        print(f"  order {row.order} reaches {row.value:.6g} {found.unit}, {row.gap_percent:.3g} % above")


def check_bound(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A certificate that `bound --save` wrote.")],
    as_json: AsJson = False,
) -> None:
    """Prove a saved bound again from its certificate; exit code 0 or 1."""
    from posreal.design.bound import Bound

    found = Bound.load(file)
    proof = found.check()
    if as_json:
        print_json({"proven": proof, "bound": found.to_dict()["bound"], "gap_percent": found.gap_percent})
        return
    print(f"{found}\nproven again: {found.metric} ≥ {proof:.10g} {found.unit}")
