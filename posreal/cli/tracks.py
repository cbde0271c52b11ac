"""``posreal track``: what there is, or one track in numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from posreal.cli.options import AsJson, Speed, number
from posreal.cli.output import print_json


def track(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME|FILE", help="A standard track, such as erri-low, or FILE or FILE:column."),
    ] = None,
    wavelengths: Annotated[
        str | None, typer.Option(metavar="SHORT:LONG", help="What counts of it, such as 1:150, in m.")
    ] = None,
    speed: Speed = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw it beside standard spectra: .png, .svg or .pdf.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the standard tracks, or show one: r.m.s. by band, and what of it matters at a speed."""
    from posreal.cli.options import read_wavelengths
    from posreal.files import require_writable
    from posreal.study.drawing import FORMATS
    from posreal.study.track_report import BANDS, track_report
    from posreal.text_table import table
    from posreal.vehicle.track import Track, paper, standard

    if name is None:
        reports = [track_report(one) for one in (paper(), *standard().values())]
        if as_json:
            print_json({"tracks": [report.to_dict() for report in reports]})
            return
        rows = [
            [
                report.track.name,
                "profile" if row.direction == "vertical" else "alignment",
                *(f"{value:#.4g}" for value in row.rms),
                "{:g}–{:g} m".format(*report.track.spectrum(row.direction).band),
                report.track.source,
            ]
            for report in reports
            for row in report.rows
        ]
        header = ["track", "", *(f"{low:g}–{high:g} m [mm]" for low, high in BANDS), "stated", "source"]
        print(table(header, rows, "llrrrll"))
        return
    if plot is not None:
        require_writable(plot, FORMATS)
    chosen = Track.read(name)
    if wavelengths is not None:
        chosen = chosen.between(*read_wavelengths(wavelengths))
    report = track_report(chosen, speed=None if speed is None else number("--speed", speed, "m/s"))
    if plot is not None:
        report.draw(plot)
    if as_json:
        print_json(report.to_dict() | {"plot": None if plot is None else str(plot)})
        return
    print(report)
    if plot is not None:
        print(f"\nwrote {plot}")
