"""The command line: parse, call, print.

Results go to standard output (with ``--json`` one JSON document and nothing else), progress to standard error.
Exit codes: 0 done, 1 the answer is no (not positive real, infeasible), 2 bad input.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from posreal import __version__
from posreal.errors import BadInput, PosrealError

app = typer.Typer(
    name="posreal",
    help="The best passive suspension device that can exist for a vehicle, and how to build it from springs, dampers "
    "and inerters.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

ProblemName = Annotated[str, typer.Argument(metavar="PROBLEM", help="A problem's name; see `posreal problems`.")]
DeviceWords = Annotated[
    list[str],
    typer.Argument(
        metavar="DEVICE",
        help="A layout with values (S3 c=2.1e4 b=1.53e4), a network in quotes, an admittance in s, or a file.",
    ),
]
VehicleFile = Annotated[
    Path | None,
    typer.Option("--vehicle", metavar="FILE", help="TOML file that overrides vehicle parameters."),
]
Position = Annotated[str | None, typer.Option(help="Where ride counts in vertical-comfort: L, M or T.")]
Objective = Annotated[str | None, typer.Option(help="What quarter-car minimises: J1 or J3.")]
Stiffness = Annotated[
    str | None, typer.Option(help="Static stiffness of quarter-car: a number in N/m, or with a unit.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]
Ascii = Annotated[bool, typer.Option("--ascii", help="Draw with ASCII characters only.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all random choices.")]
Jobs = Annotated[int, typer.Option(help="Processes that work side by side; -1 for all cores.")]
Starts = Annotated[int, typer.Option(min=1, max=10_000, help="Local searches.")]


def _version(asked: bool) -> None:
    if asked:
        print(f"posreal {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """What every command shares."""


@app.command()
def problems(as_json: AsJson = False) -> None:
    """List the design problems."""
    from posreal.design import problems as named
    from posreal.study.text import table

    entries = named()
    if as_json:
        _print_json(
            {
                "problems": [
                    {
                        "name": p.name,
                        "summary": p.summary,
                        "objective": p.objective,
                        "keep": list(p.keep),
                        "free": {name: [r.lower, r.upper] for name, r in p.free.items()},
                        "vehicle": p.vehicle.name,
                    }
                    for p in entries
                ]
            }
        )
        return
    rows = [[p.name, p.objective, ", ".join(p.keep) or "–", ", ".join(p.free) or "–", p.summary] for p in entries]
    print(table(["problem", "minimises", "keeps", "frees", ""], rows, "lllll"))


@app.command()
def layouts(
    name: Annotated[str | None, typer.Argument(help="A layout's name, or a TOML file.")] = None,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """List the fixed layouts, or draw one."""
    from posreal.design import layout, problem
    from posreal.design import layouts as shipped
    from posreal.network.diagram import diagram
    from posreal.study.text import table

    if name is None:
        entries = shipped()
        if as_json:
            _print_json({"layouts": [_layout_dict(entry) for entry in entries]})
        else:
            rows = [[e.name, str(e.network), e.description] for e in entries]
            print(table(["layout", "network", ""], rows, "lll"))
        return
    entry = layout(name)
    if as_json:
        _print_json(_layout_dict(entry))
        return
    print(f"{entry.name}: {entry.description}\n{entry.network}    [{entry.source}]\n")
    print(diagram(entry.network, ascii=ascii))
    for row in entry.published:
        posed = problem(row.problem)
        valued = entry.network.with_values(row.values)
        figures = ", ".join(f"{metric} = {value:g}" for metric, value in row.figures.items())
        tuned = "".join(f", {name} = {value:g}" for name, value in row.vehicle.items())
        print(
            f"\nTable {row.table}, {posed.name}: {figures} at {valued}{tuned}" + (f" ({row.note})" if row.note else "")
        )


_DEVICE_FIRST = {"ignore_unknown_options": True}  # so that a device may start with a minus sign


@app.command(context_settings=_DEVICE_FIRST)
def evaluate(
    problem: ProblemName,
    device: DeviceWords,
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    sweep: Annotated[
        str | None,
        typer.Option(metavar="NAME=FIRST:LAST:COUNT", help="Vary a vehicle parameter, such as V=10:55:10."),
    ] = None,
    three_ways: Annotated[
        bool, typer.Option("--three-ways", help="Ride by frequency, by covariance, and on a simulated track.")
    ] = False,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Print every metric of a device."""
    from posreal.design import metrics_to_dict, read_design
    from posreal.study.sweep import read_range
    from posreal.study.sweep import sweep as vary
    from posreal.study.three_ways import three_ways as ride

    posed = _posed(problem, vehicle, position, objective, stiffness)
    over = None if sweep is None else read_range(sweep)
    design = read_design(posed, _words(device))
    varied = None if over is None else vary(design, *over)
    ways = ride(design, seed=seed) if three_ways else None
    if as_json:
        document = {"problem": posed.name, "device": design.to_dict()["device"]}
        document["metrics"] = metrics_to_dict(design.metrics)
        if varied is not None:
            document["sweep"] = varied.to_dict()
        if ways is not None:
            document["three_ways"] = ways.to_dict()
        _print_json(document)
        return
    _print_design(design, heading=f"{posed.name}: {' '.join(device)}")
    for extra in (varied, ways):
        if extra is not None:
            print(f"\n{extra}")


@app.command()
def optimise(
    problem: ProblemName,
    layout: Annotated[list[str], typer.Argument(metavar="LAYOUT...", help="Layouts' names, or TOML files.")],
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    starts: Starts = 6,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: AsJson = False,
) -> None:
    """Find the best element values of one or more layouts."""
    from posreal.design import layout as named
    from posreal.design import optimise as search

    posed = _posed(problem, vehicle, position, objective, stiffness)
    chosen = [named(name) for name in layout]
    for entry in chosen:
        entry.require(posed)
    with _progress() as say:
        designs = [
            search(posed, entry, starts=starts, seed=seed, jobs=_job_count(jobs), progress=say) for entry in chosen
        ]
    if as_json:
        _print_json({"designs": [design.to_dict() for design in designs]})
        return
    for number, design in enumerate(designs):
        print(end="\n" if number else "")
        _print_design(design, heading=f"{posed.name}: {design.label}, {design.network.topology()}", draw=True)  # type: ignore[union-attr]


@app.command()
def synthesise(
    problem: ProblemName,
    order: Annotated[int, typer.Option(min=0, max=12, help="McMillan degree of the device.")],
    method: Annotated[str, typer.Option(help="auto, or bmi for the iterated SDPs alone.")] = "auto",
    realise: Annotated[bool, typer.Option(help="Realise the device as a network.")] = True,
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    starts: Annotated[int | None, typer.Option(min=1, max=10_000, help="Local searches.")] = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Find the best positive-real admittance of an order, then its network."""
    from posreal.design import synthesise as search
    from posreal.network.table import table as elements
    from posreal.study.strut import mounted, realised

    posed = _posed(problem, vehicle, position, objective, stiffness)
    with _progress() as say:
        design = search(posed, order, method=method, starts=starts, seed=seed, progress=say)
        if realise:
            say("realising the admittance as a network")
            built, realisation = realised(design)
    if as_json:
        network = {"network": _network_dict(realisation, ascii)} if realise else {}
        _print_json({"design": design.to_dict(), **network})
        return
    print(f"Device in its place, Y(s) [N s/m], exactly positive real:\n  {_short(design.device)}\n")
    _print_design(design, heading=f"{posed.name}: synthesised, order {design.order}")
    if realise:
        print(
            f"\nNetwork by {realisation.method}, {len(realisation.network)} elements; its admittance, recomputed from "
            f"its graph, differs from Y by {realisation.residual:.1e} relative."
        )
        for note in realisation.notes:
            print(f"  {note}")
        print()
        print(_diagram(mounted(posed, realisation.network), ascii))
        print()
        print(elements(realisation.network, digits=4))
        print()
        _print_design(built, heading="The network's own figures, recomputed from the network")


@app.command(context_settings=_DEVICE_FIRST)
def realise(
    device: DeviceWords,
    method: Annotated[str, typer.Option(help="auto, or a method's name.")] = "auto",
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Build a network for a device, and prove that it is the device."""
    from posreal.network.table import table as elements
    from posreal.realise import realise as build

    realisation = build(_one_device(device), method)
    if as_json:
        _print_json({"network": _network_dict(realisation, ascii)})
        return
    counts = realisation.network.counts
    print(
        f"{realisation.method}: {counts.total} elements ({counts.springs} springs, {counts.dampers} dampers, "
        f"{counts.inerters} inerters" + (f", {counts.levers} levers" if counts.levers else "") + ")"
    )
    for note in realisation.notes:
        print(note)
    print(f"\n{_diagram(realisation.network, ascii)}\n\n{elements(realisation.network, digits=4)}\n")
    print(f"{realisation.network}\n")
    print(f"relative residual of its admittance, recomputed from its graph: {realisation.residual:.1e}")


@app.command(context_settings=_DEVICE_FIRST)
def check(device: DeviceWords, as_json: AsJson = False) -> None:
    """Decide exactly whether a device is positive real; exit code 0 or 1."""
    from posreal.admittance import check as judge

    verdict = judge(_one_device(device))
    if as_json:
        _print_json(verdict.to_dict())
    else:
        print(verdict)
    if not verdict:
        raise typer.Exit(1)


@app.command()
def compare(
    problem: ProblemName,
    orders: Annotated[str, typer.Option(help="Orders of the synthesised devices, such as 1,2,3.")] = "1,2",
    vehicle: VehicleFile = None,
    position: Position = None,
    objective: Objective = None,
    stiffness: Stiffness = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: AsJson = False,
    ascii: Ascii = False,
) -> None:
    """Layouts and synthesised devices side by side, and the best network."""
    from posreal.study.compare import compare as side_by_side

    posed = _posed(problem, vehicle, position, objective, stiffness)
    with _progress() as say:
        comparison = side_by_side(posed, orders=_orders(orders), seed=seed, jobs=_job_count(jobs), progress=say)
    if as_json:
        _print_json(comparison.to_dict())
    else:
        print(comparison.text(ascii=ascii))


@app.command()
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
    with _progress() as say:
        reproduction = tables(seed=seed, jobs=_job_count(jobs), progress=say)
        written = [] if figures is None else [str(path) for path in draw(reproduction, figures)]
    if as_json:
        _print_json(reproduction.to_dict() | {"figures": written})
        return
    print(reproduction)
    for path in written:
        print(f"\nwrote {path}", end="")
    print(end="\n" if written else "")


# --- what the commands share ---------------------------------------------------------------------------------


def _posed(name: str, vehicle: Path | None, position: str | None, objective: str | None, stiffness: str | None) -> Any:
    from posreal.design import problem
    from posreal.units import quantity

    k = None
    if stiffness is not None:
        try:
            k = quantity(stiffness, "N/m")
        except BadInput as error:
            raise BadInput(f"--stiffness: {error}") from None
    return problem(name, position=position, objective=objective, stiffness=k, vehicle_file=vehicle)


def _words(words: list[str]) -> list[str]:
    for word in words:
        if word.startswith("--"):
            raise BadInput(f"no such option {word}; --help lists the options")
    return words


def _one_device(words: list[str]) -> Any:
    from posreal.design import read_device

    device = read_device(" ".join(_words(words)))
    if device is None:
        raise BadInput(f"{' '.join(words)!r} is no device by itself; give a network, an admittance in s, or a file")
    return device


def _orders(text: str) -> list[int]:
    try:
        orders = [int(part) for part in text.split(",")]
    except ValueError:
        raise BadInput(f"--orders {text!r} is not a list of whole numbers such as 1,2,3") from None
    if not all(0 <= order <= 12 for order in orders):
        raise BadInput(f"--orders {text!r}: orders are from 0 to 12")
    return orders


def _job_count(jobs: int) -> int:
    if jobs == 0 or jobs < -1:
        raise BadInput(f"--jobs {jobs}: give the number of processes, or -1 for all cores")
    return jobs


def _layout_dict(entry: Any) -> dict[str, Any]:
    return {
        "name": entry.name,
        "network": str(entry.network),
        "description": entry.description,
        "source": entry.source,
        "published": [
            {
                "table": r.table,
                "problem": r.problem,
                "values": r.values,
                "vehicle": r.vehicle,
                "figures": r.figures,
            }
            for r in entry.published
        ],
    }


def _network_dict(realisation: Any, ascii: bool) -> dict[str, Any]:
    return realisation.to_dict() | {"diagram": _diagram(realisation.network, ascii)}


def _diagram(network: Any, ascii: bool = False) -> str:
    from posreal.network.diagram import diagram

    return diagram(network, ascii=ascii)


def _short(device: Any, digits: int = 8) -> str:
    """An admittance with coefficients a person can read (the JSON has them exactly)."""

    def polynomial(coefficients: Any) -> str:
        terms = []
        for power in range(len(coefficients) - 1, -1, -1):
            if coefficients[power] != 0:
                variable = "" if power == 0 else " s" if power == 1 else f" s^{power}"
                terms.append(f"{float(coefficients[power]):.{digits}g}{variable}")
        return " + ".join(terms) or "0"

    return f"({polynomial(device.numerator)}) / ({polynomial(device.denominator)})"


def _print_design(design: Any, *, heading: str, draw: bool = False) -> None:
    from posreal.study.text import table
    from posreal.units import engineering

    print(heading)
    if draw:
        print(f"\n{_diagram(design.network)}")
        tuned = [
            f"{name} = {engineering(value, 'N/m' if name[0] == 'K' else 'N*s/m', 5)}"
            for name, value in design.parameters.items()
            if name not in design.network.names
        ]
        if tuned:
            print("  vehicle: " + ", ".join(tuned))
    rows = []
    for name, metric in design.metrics.items():
        gain = design.improvement(name) if name[0] in "JM" or name.startswith(("max", "deflection")) else None
        rows.append([name, f"{metric.value:#.6g}", metric.unit, "" if gain is None else f"{gain:+.2f} %", metric.at])
    print()
    print(table(["metric", "value", "unit", "better", ""], rows, "lrlrl"))
    for constraint in design.problem.constraints:
        held = constraint.margin(design.metrics) >= -1e-9 * abs(constraint.value)
        print(f"  {constraint}: {'holds' if held else 'VIOLATED'}")
    if design.found:
        print(
            "  found by: "
            + ", ".join(_finding(key, value) for key, value in design.found.items() if value not in ([], ()))
        )


def _finding(key: str, value: Any) -> str:
    parts = value if isinstance(value, list | tuple) else [value]
    text = "; ".join(f"{part:.7g}" if isinstance(part, float) else str(part) for part in parts)
    return text if key == "method" else f"{key.replace('_', ' ')} {text}"


def _print_json(document: Any) -> None:
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """A line of progress on standard error, if somebody is looking at it."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: None
        return
    with console.status("working") as status:
        yield lambda text: status.update(text)


def main() -> None:
    """Entry point of the ``posreal`` command."""
    try:
        app()
    except PosrealError as error:
        print(f"posreal: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("posreal: interrupted", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)


if __name__ == "__main__":
    main()
