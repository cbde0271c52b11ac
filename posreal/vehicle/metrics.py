"""The figures by which a suspension is judged, each from a vehicle and the admittance in its secondary port.

Lateral (plan view): ``J1y``, ``Macc``, ``Ldmp``, ``max_yv``. Vertical (side view): ``J1z_L``, ``J1z_M``, ``J1z_T`` and
the secondary deflections. Quarter-car: ``J1``, ``J3``. Definitions are those of [Jiang2012] and [PS2006].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize_scalar

from posreal.admittance import Rational
from posreal.admittance.state_space import StateSpace, state_space
from posreal.errors import Infeasible
from posreal.plant import exact_loop, quadrature, time_response
from posreal.plant.figures import ClosedPlant, Measured, settled
from posreal.plant.modes import modes
from posreal.plant.plant import ClosedLoop, Complex, Plant, PortResponses, Real, close
from posreal.vehicle import damping
from posreal.vehicle.plan_view import PlanView
from posreal.vehicle.quarter_car import QuarterCar
from posreal.vehicle.side_view import SideView

SPEEDS = np.arange(1.0, 56.0)
"""1, 2, … 55 m/s: the speeds of [Jiang2012]."""
CURVE = ((0.0, 1 / 3.0), (3.0, -1 / 3.0))
"""Corners (instant in s, change of rate in 1/s) of the way from the straight into the full curve, 3 s long."""
SLOPE = ((0.0, 0.4), (1.0, -0.4))
"""Corners of the track velocity when running onto the slope: 0.4 m/s² for 1 s."""


_GAUSS_SEES = 0.07  # damping ratio of a mode that 8 panels a decade see to a thousandth
_SUM_SEES = 0.1  # rad/s, distance from the axis of a mode that steps of 0.01 rad/s see to rounding
_BETWEEN = 1e-4  # of the least damping over the list of speeds: a lower one between them that is said
_SUM_OFF = 1e-3  # of the integral: a sum that is said to differ from it


@dataclass(frozen=True)
class Metric:
    """A figure with its unit; `at` says where it is attained, if that is part of the answer.

    `apart` is the relative difference of the two independent methods that agree on it (see
    :mod:`posreal.plant.figures`); it is below 5e-7, so that six digits may be printed.
    """

    value: float
    unit: str
    at: str = ""
    apart: float = field(default=0.0, compare=False)

    def __str__(self) -> str:
        text = f"{self.value:.6g} {self.unit}".strip()
        return f"{text} ({self.at})" if self.at else text


def metric(measured: Measured, unit: str, at: str = "", *, factor: float = 1.0) -> Metric:
    """A confirmed figure as a metric in `unit`, `factor` of it to the SI unit."""
    return Metric(factor * measured.value, unit, at, measured.apart)


def closed(plant: Plant, device: Rational) -> ClosedPlant:
    """The plant with `device` in its secondary port."""
    return ClosedPlant(plant, {"secondary": device})


def _secondary(device: Rational, s: np.ndarray) -> dict[str, np.ndarray]:
    return {"secondary": np.asarray(device(s))}


# --- lateral -------------------------------------------------------------------------------------------------


@lru_cache(maxsize=256)
def _track(vehicle: PlanView) -> Plant:
    return vehicle.random_track()


@lru_cache(maxsize=256)
def _lateral_responses(vehicle: PlanView, paper: bool) -> tuple[quadrature.Quadrature, PortResponses]:
    # the paper's sum is a midpoint rule that starts at Δω/2
    rule = quadrature.lateral_sum() if paper else quadrature.gauss(vehicle.axle_delay, start=0.005, per_decade=8)
    return rule, _track(vehicle).responses(rule.omega, "body_acceleration")


def lateral_rms(vehicle: PlanView, device: Rational, *, paper: bool = True) -> float:
    """J1y: r.m.s. lateral body acceleration (m/s²) on straight random track, by frequency up to 20 Hz.

    Parameters
    ----------
    vehicle : PlanView
    device : Rational
        What stands in the secondary port, spring included.
    paper : bool
        The sum of [Jiang2012] (12,566 points); otherwise a Gauss rule on the same band, some twenty times cheaper.
    """
    rule, port = _lateral_responses(vehicle, paper)
    z, _ = port.closed(_secondary(device, 1j * rule.omega))
    return rule.rms(z, 2 * math.pi * vehicle.Al * vehicle.V**2)


def lateral_loop(vehicle: PlanView, device: Rational | StateSpace) -> ClosedLoop:
    """The closed lateral vehicle on random track, driven by white noise (shaping filter included)."""
    return close(_track(vehicle), {"secondary": _as_state_space(device)})


def lateral_psd(vehicle: PlanView, device: Rational, omega: Real) -> Real:
    """Single-sided density of the body acceleration, (m/s²)²/(rad/s), at each `omega`."""
    plant = _track(vehicle)
    z, _ = plant.responses(omega, "body_acceleration").closed(_secondary(device, 1j * omega))
    return np.asarray(np.abs(z) ** 2 * plant.density)


def lateral_poles(vehicle: PlanView, device: Rational | StateSpace, speeds: Real = SPEEDS) -> np.ndarray:
    """Poles of the closed vehicle (without the track filter), speeds × modes, rad/s."""
    inside = {"secondary": _as_state_space(device)}
    matrices = [close(_track(vehicle.at(v)), inside, shaped=False).A for v in speeds]
    return np.linalg.eigvals(np.array(matrices)).astype(complex)


def least_damping(vehicle: PlanView, device: Rational | StateSpace, speeds: Real = SPEEDS) -> damping.LeastDamping:
    """Ldmp: the least damping ratio of all poles over `speeds` (m/s)."""
    return damping.least(lateral_poles(vehicle, device, speeds), speeds)


def _between(vehicle: PlanView, device: Rational, mode: damping.LeastDamping) -> damping.LeastDamping:
    """The least damping at the speeds beside that of `mode`, which the list of speeds passes over."""
    inside = state_space(device)
    low, high = max(mode.speed - 1, SPEEDS[0]), min(mode.speed + 1, SPEEDS[-1])
    ratio = lambda v: least_damping(vehicle, inside, np.array([v])).ratio  # noqa: E731
    found = minimize_scalar(ratio, bounds=(low, high), method="bounded", options={"xatol": 1e-3})
    return least_damping(vehicle, inside, np.array([found.x]))


def worst_lateral_rms(vehicle: PlanView, device: Rational, speeds: Real = SPEEDS) -> Metric:
    """Macc: the largest J1y over the range of `speeds`, with its speed.

    The speeds of the list are looked at first; about the largest the speed is refined within its neighbours. The figure
    at the speed found is the paper's sum, confirmed.
    """
    inside = state_space(device)

    def at(speed: float) -> float:
        return _quick_lateral_rms(vehicle.at(speed), device, inside)

    values = [at(v) for v in speeds]
    top = int(np.argmax(values))
    speed = float(speeds[top])
    low, high = float(speeds[max(top - 1, 0)]), float(speeds[min(top + 1, len(speeds) - 1)])
    if high > low and not (speed == high and at(speed - 1e-3 * (high - low)) < values[top]):
        found = minimize_scalar(lambda v: -at(v), bounds=(low, high), method="bounded", options={"xatol": 1e-5})
        if -found.fun > values[top] * (1 + 1e-9):
            speed = float(found.x)
    return summed_lateral_rms(vehicle.at(speed), device)


def summed_lateral_rms(vehicle: PlanView, device: Rational) -> Metric:
    """J1y at the vehicle's speed: the paper's sum, confirmed, with a word where its step passes over a resonance."""
    rule = quadrature.lateral_sum()
    loop = closed(_track(vehicle), device)
    measured = loop.summed_rms("body_acceleration", rule, lambda: lateral_rms(vehicle, device))
    at = f"at {vehicle.V:.6g} m/s"
    if _shortest_decay(loop.poles) < _SUM_SEES:
        integral = loop.band_rms(["body_acceleration"])["body_acceleration"].value
        if abs(integral - measured.value) > _SUM_OFF * integral:
            at += f"; the sum passes over a resonance in steps of 0.01 rad/s, the integral is {integral:.6g}"
    return metric(measured, "m/s^2", at)


def _quick_lateral_rms(vehicle: PlanView, device: Rational, inside: StateSpace) -> float:
    """J1y good enough to choose a speed by: by the Gauss rule, or by modes where one is too light for that."""
    plant = _track(vehicle)
    loop = close(plant, {"secondary": inside}, shaped=False)
    poles = loop.poles()
    if float(damping.ratios(poles[poles.imag > 0]).min(initial=1.0)) > _GAUSS_SEES:
        return lateral_rms(vehicle, device, paper=False)
    parts = modes(loop, plant.shaping)
    if _shortest_decay(poles) > _SUM_SEES:
        return math.sqrt(max(float(parts.mean_squares(0.0, quadrature.BAND)[0]), 0.0))
    rule = quadrature.lateral_sum()
    return math.sqrt(parts.summed(rule.omega, float(rule.weight[0]), "body_acceleration"))


def _shortest_decay(poles: Complex) -> float:
    """The least distance of an oscillating mode of the band from the axis, rad/s."""
    inside = poles[(poles.imag > 0) & (poles.imag < quadrature.BAND)]
    return float(np.abs(inside.real).min(initial=math.inf))


def curve_response(vehicle: PlanView, device: Rational, time: Real) -> Real:
    """Lateral displacement of the body (m) when entering the curve at t = 0 (curvature and cant rise over 3 s)."""
    loop = close(vehicle.curve_entry(), {"secondary": _as_state_space(device)})
    return time_response.corner_response(loop, "body_displacement", CURVE, time)


def curve_peak(vehicle: PlanView, device: Rational) -> Measured:
    """Max(yv): the largest lateral displacement of the body (m) on entering the curve."""
    return closed(vehicle.curve_entry(), device).peak("body_displacement", CURVE)[0]


def lateral_metrics(vehicle: PlanView, device: Rational) -> dict[str, Metric]:
    """Every lateral figure of a device in the secondary port."""
    mode = least_damping(vehicle, device)
    here = least_damping(vehicle, device, np.array([vehicle.V]))
    between = _between(vehicle, device, mode)
    for found in (mode, here, between):
        if found.ratio <= 0:
            raise Infeasible(
                f"the vehicle is not stable with this device: at {found.speed:g} m/s a mode of {found.frequency:.3g} "
                f"Hz has damping ratio {found.ratio:.3g}"
            )
    plant = _track(vehicle.at(mode.speed))
    ratio = settled(
        "the least damping ratio",
        (lambda: mode.ratio, lambda: exact_loop.least_damping(plant, {"secondary": device})),
    )
    at = f"at {mode.speed:g} m/s, {mode.frequency:.3g} Hz"
    if between.ratio < mode.ratio * (1 - _BETWEEN):
        at += f"; between the speeds it falls to {100 * between.ratio:.6g} at {between.speed:.6g} m/s"
    return {
        "Macc": worst_lateral_rms(vehicle, device),
        "J1y": summed_lateral_rms(vehicle, device),
        "Ldmp": metric(ratio, "%", at, factor=100),
        "max_yv": metric(curve_peak(vehicle, device), "mm", factor=1e3),
        "static_stiffness": Metric(float(device.static_stiffness), "N/m"),
    }


# --- vertical ------------------------------------------------------------------------------------------------


def vertical_rms(vehicle: SideView, device: Rational, output: str) -> float:
    """√(½ ∫₀^{40π} |output/δ̇1|² Sδ dω): r.m.s. up to 20 Hz of a named output of :meth:`SideView.track`, SI units."""
    return closed(vehicle.track(), device).band_rms([output])[output].value


def vertical_ride(vehicle: SideView, device: Rational, position: str) -> float:
    """J1z at a body point ``"L"``, ``"M"`` or ``"T"``, in %g."""
    return 100 * vertical_rms(vehicle, device, f"acceleration_{position}") / vehicle.g


def vertical_ride_over_the_whole_band(vehicle: SideView, device: Rational, position: str) -> Metric:
    """J1z without its end at 20 Hz, in %g: what a device does above counts too."""
    measured = closed(vehicle.track(), device).rms(f"acceleration_{position}")
    return metric(measured, "%g", factor=100 / vehicle.g)


def vertical_loop(vehicle: SideView, device: Rational | StateSpace) -> ClosedLoop:
    """The closed vertical vehicle on the track profile, driven by the white track velocity δ̇1."""
    return close(vehicle.track(), {"secondary": _as_state_space(device)})


def vertical_psd(vehicle: SideView, device: Rational, position: str, omega: Real) -> Real:
    """Single-sided density of the body acceleration at ``"L"``, ``"M"`` or ``"T"``, (m/s²)²/(rad/s)."""
    plant = vehicle.track()
    z, _ = plant.responses(omega, f"acceleration_{position}").closed(_secondary(device, 1j * omega))
    return np.asarray(np.abs(z) ** 2 * plant.density)


def slope_deflection(vehicle: SideView, device: Rational, end: str, time: Real) -> Real:
    """Deflection (m) of the ``"front"`` or ``"rear"`` secondary suspension when running onto a slope at t = 0.

    The track accelerates at 0.4 m/s² for 1 s and keeps its gradient from then on.
    """
    return time_response.corner_response(vertical_loop(vehicle, device), f"deflection_{end}", SLOPE, time)


def vertical_metrics(vehicle: SideView, device: Rational) -> dict[str, Metric]:
    """Every vertical figure of a device in the secondary ports, airspring included.

    ``deflection_front`` and ``_rear`` are the peaks on the slope, ``deflection_rms_…`` the r.m.s. on random track up to
    20 Hz, ``deflection_overall_…`` the peak plus three times the r.m.s.: [Jiang2012] gives an overall maximum without
    saying how slope and random track are put together, and this way reproduces its ranges.
    """
    plant = vehicle.track()
    loop = closed(plant, device)
    loop.require_stable()
    rms = loop.band_rms(plant.outputs)
    found = {
        f"J1z_{position}": metric(rms[f"acceleration_{position}"], "%g", factor=100 / vehicle.g) for position in "LMT"
    }
    for end in ("front", "rear"):
        top, spread = loop.peak(f"deflection_{end}", SLOPE)[0], rms[f"deflection_{end}"]
        found[f"deflection_{end}"] = metric(top, "mm", "peak on the slope", factor=1e3)
        found[f"deflection_rms_{end}"] = metric(spread, "mm", "r.m.s. on random track", factor=1e3)
        overall = Measured(top.value + 3 * spread.value, max(top.apart, spread.apart))
        found[f"deflection_overall_{end}"] = metric(overall, "mm", "peak + 3 r.m.s.", factor=1e3)
    found["static_stiffness"] = Metric(float(device.static_stiffness), "N/m")
    return found


# --- quarter-car ---------------------------------------------------------------------------------------------


def quarter_car_loop(vehicle: QuarterCar, device: Rational | StateSpace) -> ClosedLoop:
    """The closed quarter-car on the road, driven by the white road velocity."""
    return close(vehicle.road(), {"secondary": _as_state_space(device)})


def quarter_car_by_frequency(vehicle: QuarterCar, device: Rational, output: str) -> float:
    """R.m.s. of ``acceleration`` or ``tyre_force`` over all frequencies by quadrature, SI units."""
    return closed(vehicle.road(), device).rms_by_frequency(output)


def quarter_car_metrics(vehicle: QuarterCar, device: Rational) -> dict[str, Metric]:
    """J1 and J3 over the whole band."""
    loop = closed(vehicle.road(), device)
    loop.require_stable()
    return {
        "J1": metric(loop.rms("acceleration"), "m/s^2"),
        "J3": metric(loop.rms("tyre_force"), "N"),
        "static_stiffness": Metric(float(device.static_stiffness), "N/m"),
    }


def _as_state_space(device: Rational | StateSpace) -> StateSpace:
    return device if isinstance(device, StateSpace) else state_space(device)
