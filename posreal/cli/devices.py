"""``posreal check`` and ``posreal realise``: devices by themselves, outside any vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from posreal.cli.options import Ascii, AsJson, DeviceWords, Ranges, Seed, Width, Write, band, number, one_device
from posreal.cli.output import check_paths, network_dict, print_json, print_network, progress, readable, write_network
from posreal.errors import BadInput, Infeasible

if TYPE_CHECKING:
    from posreal.ranges import UsualRanges

Repair = Annotated[
    str | None,
    typer.Option(help="Repair a device that misses: parallel or series (smallest damper), or projection (SDP)."),
]


def check(device: DeviceWords, repair: Repair = None, as_json: AsJson = False) -> None:
    """Decide exactly whether a device is positive real; exit code 0 or 1."""
    from posreal.admittance import as_rational
    from posreal.admittance import check as judge

    admittance = as_rational(one_device(device))
    verdict = judge(admittance)
    if not as_json:  # before a repair, which may be refused
        print("\n  ".join([str(verdict), *verdict.facts()]))
    repaired = None
    if repair is not None:
        from posreal.realisation import nearest_positive_real

        repaired = nearest_positive_real(admittance, repair)
    if as_json:
        print_json(verdict.to_dict() | ({} if repaired is None else {"repair": repaired.to_dict()}))
    elif repaired is not None:
        print(f"{repaired}\n  {readable(repaired.device, 17)}")
    if not verdict:
        raise typer.Exit(1)


def realise(
    device: DeviceWords,
    method: Annotated[str, typer.Option(help="auto (fewest elements), all, or a method's name.")] = "auto",
    levers: Annotated[bool, typer.Option("--levers", help="Let auto use levers (Brune).")] = False,
    repair: Repair = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Let auto take a smaller network within this relative error over the band.")
    ] = None,
    over: Annotated[
        str | None, typer.Option("--band", metavar="LOW:HIGH", help="Band of the tolerance, rad/s.")
    ] = None,
    k_min: Annotated[str | None, typer.Option(help="Softest spring that can be built.")] = None,
    k_max: Annotated[str | None, typer.Option(help="Stiffest spring.")] = None,
    c_min: Annotated[str | None, typer.Option(help="Weakest damper.")] = None,
    c_max: Annotated[str | None, typer.Option(help="Strongest damper.")] = None,
    b_min: Annotated[str | None, typer.Option(help="Smallest inerter.")] = None,
    b_max: Annotated[str | None, typer.Option(help="Largest inerter.")] = None,
    of_problem: Annotated[
        str | None,
        typer.Option("--for", metavar="PROBLEM", help="Whose place it is for: what cannot be bought there is said."),
    ] = None,
    ranges: Ranges = None,
    seed: Seed = 0,
    write: Write = None,
    as_json: AsJson = False,
    ascii: Ascii = False,
    width: Width = 100,
) -> None:
    """Build a network for a device, and prove that it is the device."""
    from posreal.admittance import as_rational
    from posreal.network.usual import outside, sentence
    from posreal.realisation import Limits, nearest_positive_real, realise_all
    from posreal.realisation import realise as build

    check_paths(write)
    if tolerance is None and over is not None:
        raise BadInput("--band says where a --tolerance holds; give both")
    ends = {"k_min": k_min, "k_max": k_max, "c_min": c_min, "c_max": c_max, "b_min": b_min, "b_max": b_max}
    units = {"k": "N/m", "c": "N*s/m", "b": "kg"}
    given = {n: number(f"--{n.replace('_', '-')}", text, units[n[0]]) for n, text in ends.items() if text is not None}
    limits = Limits(**given) if given else None
    target = as_rational(one_device(device))
    usual = _usual(of_problem, ranges)
    changed: list[str] = []
    if repair is not None:
        mended = nearest_positive_real(target, repair)
        target, changed = mended.device, [str(mended)]
    if method == "all":
        refused = {"--write": write, "--tolerance": tolerance, "--levers": levers or None}
        for option, value in refused.items():
            if value is not None:
                raise BadInput(f"{option} goes with one network; --method all lists every one, those with levers too")
        with progress() as say:
            found = realise_all(target, progress=say)
        if limits is not None:
            found = [r for r in found if limits.broken_by(r.network) is None]
            if not found:
                raise Infeasible("No realisation found can be built within the limits; take wider ones.")
        if as_json:
            every = [network_dict(r, ascii, width, beyond=outside(r.network, usual)) for r in found]
            print_json({"networks": every, "notes": changed})
        else:
            print("\n".join([*changed, _listing(found)]))
        return
    where = band(over)
    with progress() as say:
        realisation = build(
            target, method, levers=levers, tolerance=tolerance, band=where, limits=limits, seed=seed, progress=say
        )
    written = write_network(realisation.network, write)
    beyond = outside(realisation.network, usual)
    if as_json:
        print_json({"network": network_dict(realisation, ascii, width, beyond=beyond), "notes": changed})
        return
    for line in changed:
        print(line)
    print_network(realisation, ascii, width, beyond=sentence(beyond, usual))
    print("\n".join(written), end="\n" if written else "")


def _usual(of_problem: str | None, ranges: Path | None) -> UsualRanges | None:
    """What can be bought for a problem's place, or for any here, or as a file says."""
    from posreal.ranges import WIDEST, read_ranges

    usual: UsualRanges | None = WIDEST
    if of_problem is not None:
        from posreal.specification.named import problem

        usual = problem(of_problem).usual
    return usual if ranges is None else read_ranges(ranges, usual)


def _listing(found: list[Any]) -> str:
    """All realisations: counts and the spread of values, which is what a builder looks at."""
    from posreal.text_table import table

    rows = [
        [
            r.method,
            *(str(n) for n in (len(r.network), r.springs, r.dampers, r.inerters, r.levers)),
            f"{r.spread:.3g}",
            f"{r.residual:.1e}",
            str(r.network) if len(str(r.network)) <= 60 else str(r.network)[:57] + "…",
        ]
        for r in found
    ]
    header = ["method", "elements", "springs", "dampers", "inerters", "levers", "spread", "residual", "network"]
    return table(header, rows, "lrrrrrrrl")
