"""Figures 3, 4, 7, 8, 9 and 10 of [Jiang2012], from the designs of a reproduction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from posreal.errors import BadInput
from posreal.files import require_folder
from posreal.metric import ClosedVehicle, PeakInTime
from posreal.metric.damping_ratio import poles, ratios
from posreal.specification.design import Design
from posreal.study.drawing import save, sheet
from posreal.study.reproduce import Reproduction
from posreal.vehicle import parameters

_STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))


def _closed(design: Design) -> ClosedVehicle:
    return ClosedVehicle(design.problem.vehicle, {"secondary": design.port})


def _in_time(design: Design, metric: str, time: np.ndarray) -> np.ndarray:
    """The response whose peak a metric is, in the metric's unit."""
    peak = design.problem.vehicle.metrics[metric]
    assert isinstance(peak, PeakInTime)
    return peak.factor * _closed(design).on(peak.load).modes.ramp(time, peak.corners, peak.output)


def _lateral_label(design: Design) -> str:
    if not design.found:
        return "default"
    return f"{design.label}, {'primary too' if design.problem.name.endswith('primary') else 'secondary only'}"


def figure3(reproduction: Reproduction) -> Any:
    """(a) J1y and (b) least damping ratio against speed, for the schemes of Table 2."""
    figure, (left, right) = sheet(11, 4.2, 2)
    for row, style in zip(reproduction.tables[2], _STYLES, strict=False):
        design, closed = row.optimum, _closed(row.optimum)
        metrics: Any = design.problem.vehicle.metrics
        speeds = metrics["Ldmp"].speeds
        rms = [metrics["J1y"].estimate(closed.at(v)) for v in speeds]
        least = 100 * ratios(poles(closed, metrics["Ldmp"].load, speeds)).min(axis=1)
        left.plot(speeds, rms, linestyle=style, label=_lateral_label(design))
        right.plot(speeds, least, linestyle=style, label=_lateral_label(design))
    left.set(xlabel="speed V [m/s]", ylabel="J1y [m/s²]", title="(a) r.m.s. lateral acceleration")
    right.set(xlabel="speed V [m/s]", ylabel="least damping ratio [%]", title="(b) least damping ratio")
    floor = reproduction.lateral_default["Ldmp"].value
    right.axhline(floor, color="0.4", linewidth=0.8)
    right.annotate(
        f"default's least, {floor:.2f} %", (30, floor), xytext=(0, 4), textcoords="offset points", color="0.4"
    )
    left.legend(fontsize=8)
    return figure


def figure4(reproduction: Reproduction) -> Any:
    """Lateral displacement of the body on entering the curve, for the schemes of Table 3."""
    figure, (axis,) = sheet(7, 4.4)
    time = np.linspace(0, 8, 1601)
    for row, style in zip(reproduction.tables[3], _STYLES, strict=False):
        design = row.optimum
        yv = _in_time(design, "max_yv", time)
        axis.plot(time, yv, linestyle=style, label=f"{_lateral_label(design)}: {np.abs(yv).max():.1f} mm")
    axis.set(xlabel="time [s]", ylabel="yv [mm]", title="body displacement entering the curve, V = 55 m/s")
    axis.legend(fontsize=8)
    return figure


def _vertical(reproduction: Reproduction) -> list[tuple[str, Design]]:
    """Airspring only and S4, S5, S7 (S6 is S5)."""
    rows = [row.optimum for row in reproduction.tables[6] if row.layout.name != "S6"]
    bare = replace(rows[0], device=None, network=None)
    return [("airspring only", bare), *((row.label, row) for row in rows)]


def _densities(axis: Any, reproduction: Reproduction, position: str) -> None:
    hertz = np.geomspace(0.2, 20, 1200)
    for (label, design), style in zip(_vertical(reproduction), _STYLES, strict=False):
        density = _closed(design).on("track").density(f"acceleration_{position}", 2 * np.pi * hertz)
        axis.loglog(hertz, 2 * np.pi * density, linestyle=style, label=label)
    axis.set(xlabel="frequency [Hz]", ylabel="density [(m/s²)²/Hz]", ylim=(1e-7, None))


def figure7(reproduction: Reproduction) -> Any:
    """Power spectral density of the body acceleration over the trailing bogie."""
    figure, (axis,) = sheet(7, 4.4)
    _densities(axis, reproduction, "T")
    axis.set_title("vertical acceleration over the trailing bogie (T)")
    axis.legend(fontsize=8)
    return figure


def figure8(reproduction: Reproduction) -> Any:
    """Power spectral density of the body acceleration over the leading bogie and in the middle."""
    figure, axes = sheet(11, 4.2, 2)
    for axis, position, title in zip(axes, "LM", ("over the leading bogie (L)", "in the middle (M)"), strict=True):
        _densities(axis, reproduction, position)
        axis.set_title(f"vertical acceleration {title}")
    axes[0].legend(fontsize=8)
    return figure


def figure9(reproduction: Reproduction) -> Any:
    """J1z at L, M and T against the airspring's damping Crz, element values kept."""
    figure, axes = sheet(12, 4.2, 3)
    nominal = float(parameters(reproduction.tables[6][0].optimum.problem.vehicle)["Crz"])
    dampings = np.linspace(0.25, 2.0, 29) * nominal
    for (label, design), style in zip(_vertical(reproduction), _STYLES, strict=False):
        ride: dict[str, list[float]] = {"L": [], "M": [], "T": []}
        for damping in dampings:
            changed = design.problem.with_vehicle({"Crz": float(damping)})
            port = changed.port(design.device, whole=design.whole)
            closed = ClosedVehicle(changed.vehicle, {"secondary": port})
            for position, values in ride.items():
                values.append(closed.value(changed.vehicle.metrics[f"J1z_{position}"]).value)
        for axis, values in zip(axes, ride.values(), strict=True):
            axis.plot(dampings / 1e3, values, linestyle=style, label=label)
    for axis, position in zip(axes, "LMT", strict=True):
        axis.axvline(nominal / 1e3, color="0.6", linewidth=0.8)
        axis.set(xlabel="Crz [kN s/m]", ylabel="J1z [%g]", title=f"J1z({position})")
    axes[0].legend(fontsize=8)
    return figure


def figure10(reproduction: Reproduction) -> Any:
    """Deflection of the front and the rear secondary suspension when running onto a slope."""
    figure, axes = sheet(11, 4.2, 2)
    time = np.linspace(0, 5, 1001)
    for (label, design), style in zip(_vertical(reproduction), _STYLES, strict=False):
        for axis, end in zip(axes, ("front", "rear"), strict=True):
            deflection = _in_time(design, f"deflection_{end}", time)
            axis.plot(time, deflection, linestyle=style, label=f"{label}: {np.abs(deflection).max():.1f} mm")
    for axis, end in zip(axes, ("front", "rear"), strict=True):
        axis.set(xlabel="time [s]", ylabel="deflection [mm]", title=f"{end} secondary suspension, onto a slope")
        axis.legend(fontsize=8)
    return figure


FIGURES: dict[str, Callable[[Reproduction], Any]] = {
    "figure3.png": figure3,
    "figure4.png": figure4,
    "figure7.png": figure7,
    "figure8.png": figure8,
    "figure9.png": figure9,
    "figure10.png": figure10,
}


def writable(folder: str | Path) -> Path:
    """The folder, made if need be, once it is known that files can be written there.

    Raises
    ------
    BadInput
        Naming the folder and the reason.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot write figures to {folder}: {error.strerror or error}") from None
    require_folder(folder)
    return folder


def draw(reproduction: Reproduction, folder: str | Path) -> Sequence[Path]:
    """Write every figure as PNG to `folder`, each whole or not at all.

    Returns
    -------
    paths of the files
    """
    folder = writable(folder)
    return [save(make(reproduction), folder / name, dpi=130) for name, make in FIGURES.items()]
