"""Arguments and options that several commands share, and how their texts become values."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from posreal.errors import BadInput, plain, shown

if TYPE_CHECKING:
    from posreal.specification.problem import Problem

ProblemName = Annotated[
    str,
    typer.Argument(
        metavar="PROBLEM", help="A problem's name; see `posreal problems`. Or a TOML file with a model of one's own."
    ),
]
DeviceWords = Annotated[
    list[str],
    typer.Argument(
        metavar="DEVICE",
        help="A layout with values (S3 c=2.1e4 b=1.53e4), a network in quotes, an admittance in s (or in descending "
        "powers, tf([1 0],[1 2 3])), or a file; the coefficient lists of JSON are in ascending powers.",
    ),
]
VehicleFile = Annotated[
    Path | None, typer.Option("--vehicle", metavar="FILE", help="TOML file that overrides vehicle parameters.")
]
Position = Annotated[str | None, typer.Option(help="Where ride counts in vertical-comfort: L, M, T or worst.")]
Objective = Annotated[
    str | None,
    typer.Option(
        help="What quarter-car minimises: J1, J3, gain_acceleration, gain_tyre_force, or a sum such as "
        "'J1 + 0.001*J3'; whole-band for vertical-comfort, whose ride ends at 20 Hz otherwise."
    ),
]
Stiffness = Annotated[
    str | None, typer.Option(help="Static stiffness of quarter-car: a number in N/m, or with a unit.")
]
TrackName = Annotated[
    str | None,
    typer.Option(
        "--track",
        metavar="NAME",
        help="What the vehicle runs on: paper, erri-low, fra-4, … (`posreal track`), or FILE or FILE:column.",
    ),
]
Wavelengths = Annotated[
    str | None,
    typer.Option("--wavelengths", metavar="SHORT:LONG", help="All that counts of the track, m, such as 1:150."),
]
Speed = Annotated[
    str | None,
    typer.Option(
        "--speed",
        metavar="V",
        help="A number in m/s, with a unit such as 200 km/h, or FIRST:LAST:STEP: the worst counts.",
    ),
]
Standard = Annotated[
    str | None,
    typer.Option("--standard", metavar="NAME", help="en12299: its weighting, with a95, N_MV and class in words."),
]
Body = Annotated[
    str | None,
    typer.Option(
        "--body", metavar="TEXT", help="rigid, flexible (8.5 Hz, 1.5 %), or first mode, damping and modes: '9 Hz,2%,2'."
    ),
]
WeightingName = Annotated[
    str | None,
    typer.Option(
        "--weighting",
        metavar="NAME",
        help="Frequency weighting of the body's acceleration: Wb (EN 12299), Wb-iso, Wk, Wd, Wc, We or none.",
    ),
]
CutOff = Annotated[
    str | None,
    typer.Option(
        "--cut-off",
        metavar="HZ",
        help="Where ride figures end: 20 Hz as in the paper, or, weighted, nowhere, unless this says otherwise.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]
Ascii = Annotated[bool, typer.Option("--ascii", help="Draw with ASCII characters only.")]
Width = Annotated[int, typer.Option(min=40, max=1000, help="Columns that a diagram may take.")]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Seed of all random choices.")]
Jobs = Annotated[int, typer.Option(help="Processes that work side by side; -1 for all cores.")]
Starts = Annotated[int, typer.Option(min=1, max=10_000, help="Local searches.")]
Write = Annotated[
    list[Path] | None,
    typer.Option("--write", metavar="FILE", help="Write the network too: .png .svg .cir .tex .txt or .net."),
]

Limit = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="METRIC=VALUE",
        help="A metric that may not exceed a value, in its unit; inertance is that of the port, lim Y/s at high "
        "frequency, not the sum of the inerters in a network.",
    ),
]
WorstCase = Annotated[
    list[str] | None,
    typer.Option(
        "--worst-case",
        metavar="NAME=VALUE,…",
        help="Another operating point; the worst over all is minimised, and constraints hold at each.",
    ),
]

BandOnly = Annotated[
    bool,
    typer.Option(
        "--band-only",
        help="Allow a device that is worse than the default suspension over all frequencies, where the objective ends "
        "at 20 Hz.",
    ),
]

At = Annotated[str | None, typer.Option("--at", metavar="PLACE", help="Where the device goes, such as primary.")]
Sweep = Annotated[
    list[str] | None,
    typer.Option(
        "--sweep",
        metavar="NAME=FIRST:LAST:COUNT",
        help="Vary a vehicle parameter, such as V=10:55:10; given again, another one too, in all combinations.",
    ),
]
Ranges = Annotated[
    Path | None,
    typer.Option("--ranges", metavar="FILE", help="TOML file of what can be bought; see `posreal ranges`."),
]
Parts = Annotated[
    str | None,
    typer.Option(
        "--parts",
        "--elements",
        metavar="real|FILE",
        help="Real elements in place of ideal ones: inerters and dampers with their ends (real), or a TOML catalogue.",
    ),
]
AnyValues = Annotated[
    bool, typer.Option("--any-values", help="Let element values be any, not only those that can usually be bought.")
]

Robust = Annotated[
    bool, typer.Option("--robust", help="Keep the constraints in every vehicle that is built within tolerances.")
]
ElementTolerance = Annotated[
    str | None,
    typer.Option("--tolerance", metavar="TEXT", help="Of the elements: 20% (the default), or 20%,k=10%,c1=30%."),
]
VehicleTolerance = Annotated[
    str | None,
    typer.Option(
        "--vehicle-tolerance",
        metavar="TEXT",
        help="Of vehicle parameters: 10% of the spring at the device's place and of the suspension in the vehicle's "
        "ports (the default, 20%), or Kpy=10%,mv=30%; 0 for none.",
    ),
]

_MOST_JOBS = 1000
DEVICE_FIRST = {"ignore_unknown_options": True}
"""Settings of a command whose device may start with a minus sign; see :func:`words`."""


def posed(
    name: str,
    vehicle: Path | None = None,
    position: str | None = None,
    objective: str | None = None,
    stiffness: str | None = None,
    limit: list[str] | None = None,
    worst_case: list[str] | None = None,
    at: str | None = None,
    track: str | None = None,
    wavelengths: str | None = None,
    speed: str | None = None,
    body: str | None = None,
    weighting: str | None = None,
    standard: str | None = None,
    cut_off: str | None = None,
    ranges: Path | None = None,
    band_only: bool = False,
    parts: str | None = None,
) -> Problem:
    """The problem that the options describe."""
    from posreal.specification.named import problem
    from posreal.topology.options import read_limits

    k = None if stiffness is None else number("--stiffness", stiffness, "N/m")
    end = None if cut_off is None else _hertz(cut_off)
    return problem(
        name,
        position=position,
        objective=objective,
        stiffness=k,
        vehicle_file=vehicle,
        limits=read_limits(limit) if limit else None,
        worst_case=[_point(text) for text in worst_case or ()],
        at=at,
        track=track,
        wavelengths=None if wavelengths is None else read_wavelengths(wavelengths),
        body=body,
        speed=None if speed is None else read_speeds(speed),
        standard=standard,
        weighting=weighting,
        cut_off=end,
        ranges=ranges,
        band_only=band_only,
        elements=parts,
    )


def refuse_both(any_values: bool, ranges: Path | None) -> None:
    """Values cannot be any and within a file's ranges at once."""
    if any_values and ranges is not None:
        raise BadInput("--any-values takes values that --ranges leaves out; give one of the two")


def read_speeds(text: str) -> float | list[float]:
    """``200 km/h``, or ``30:70:5`` as 30, 35, … 70 m/s."""
    if ":" not in text:
        return number("--speed", text, "m/s")
    try:
        first, last, step = (float(part) for part in text.split(":"))
        count = round((last - first) / step) + 1
        if not (step > 0 and 2 <= count <= 1000 and math.isclose(first + (count - 1) * step, last)):
            raise ValueError
    except (ValueError, OverflowError, ZeroDivisionError):
        raise BadInput(f"--speed {shown(text)} is no range such as 30:70:5, first, last and step in m/s") from None
    return [first + k * step for k in range(count)]


def read_wavelengths(text: str) -> tuple[float, float]:
    """``1:150`` as two wavelengths in m."""
    try:
        short, long = (float(part) for part in text.split(":"))
    except ValueError:
        raise BadInput(f"--wavelengths {shown(text)} is not a band such as 1:150, two wavelengths in m") from None
    return short, long


def _hertz(text: str) -> float:
    """``20`` or ``20 Hz``; a unit counts 2π rad/s to the Hz."""
    try:
        return float(text)
    except ValueError:
        return number("--cut-off", text, "rad/s") / (2 * math.pi)


def made_robust(question: Problem, robust: bool, elements: str | None, vehicle: str | None) -> Problem:
    """The problem, with the tolerances within which its constraints hold if that is asked for."""
    if robust:
        return question.robust(**({} if elements is None else {"elements": elements}), vehicle=vehicle)
    if elements is not None or vehicle is not None:
        raise BadInput("tolerances go with --robust here; posreal tolerance shows the spread of a given device")
    return question


def _point(text: str) -> dict[str, float | str]:
    """``V=40,mv=42 t`` as vehicle parameters."""
    found: dict[str, float | str] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not (name and equals and value):
            raise BadInput(f"--worst-case {shown(text)} is not an operating point such as V=40 or V=40,mv=42000")
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = value
    return found


def number(option: str, text: str, unit: str) -> float:
    """The value of an option, with or without a unit."""
    from posreal.units import quantity

    try:
        return quantity(text, unit)
    except BadInput as error:
        raise BadInput(f"{option}: {error}") from None


def words(given: list[str]) -> list[str]:
    """The words of a device; a misspelt option is not one of them."""
    for word in given:
        if word.startswith("--"):
            raise BadInput(f"no such option {plain(word, 40)}; --help lists the options")
    return given


def one_device(given: list[str]) -> Any:
    """A device that stands by itself, outside any vehicle."""
    from posreal.network.read_device import read_device

    text = " ".join(words(given))
    device = read_device(text)
    if device is None:
        raise BadInput(f"{shown(text)} is no device by itself; give a network, an admittance in s, or a file")
    return device


def orders(text: str) -> list[int]:
    """``1,2,3`` as whole numbers."""
    try:
        found = [int(part) for part in text.split(",")]
    except ValueError:
        raise BadInput(f"--orders {shown(text)} is not a list of whole numbers such as 1,2,3") from None
    if not all(0 <= order <= 12 for order in found):
        raise BadInput(f"--orders {shown(text)}: orders are from 0 to 12")
    return found


def fraction(option: str, text: str) -> float:
    """``1%`` or ``0.01``."""
    try:
        value = float(text.strip().removesuffix("%")) / (100 if text.strip().endswith("%") else 1)
    except ValueError:
        value = -1.0
    if not 0 <= value < 1:
        raise BadInput(f"{option} {shown(text)} is not a fraction such as 1% or 0.01, from 0 to below 1")
    return value


def job_count(jobs: int) -> int:
    """A number of processes that joblib takes."""
    if jobs == 0 or not -1 <= jobs <= _MOST_JOBS:
        raise BadInput(
            f"--jobs {plain(jobs, 20)}: give the number of processes, up to {_MOST_JOBS}, or -1 for all cores"
        )
    return jobs


def band(text: str | None) -> tuple[float, float] | None:
    """``0.1:100`` as two frequencies in rad/s."""
    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(":"))
        if not 0 < low < high < float("inf"):
            raise ValueError
    except ValueError:
        raise BadInput(f"--band {shown(text)} is not a band such as 0.1:100, two frequencies in rad/s") from None
    return low, high
