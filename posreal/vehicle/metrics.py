"""The figures by which a suspension is judged, each from a vehicle and the admittance in its secondary port.

Lateral (plan view): ``J1y``, ``Macc``, ``Ldmp``, ``max_yv``. Vertical (side view): ``J1z_L``, ``J1z_M``, ``J1z_T`` and
the secondary deflections. Quarter-car: ``J1``, ``J3``. Definitions are those of [Jiang2012] and [PS2006].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from posreal.admittance import Rational
from posreal.admittance.state_space import StateSpace, state_space
from posreal.errors import Infeasible
from posreal.plant import h2_norm, quadrature, time_response
from posreal.plant.plant import ClosedLoop, PortResponses, Real, close
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


@dataclass(frozen=True)
class Metric:
    """A figure with its unit; `at` says where it is attained, if that is part of the answer."""

    value: float
    unit: str
    at: str = ""

    def __str__(self) -> str:
        text = f"{self.value:.6g} {self.unit}".strip()
        return f"{text} ({self.at})" if self.at else text


def _secondary(device: Rational, s: np.ndarray) -> dict[str, np.ndarray]:
    return {"secondary": np.asarray(device(s))}


# --- lateral -------------------------------------------------------------------------------------------------


@lru_cache(maxsize=256)
def _lateral_responses(vehicle: PlanView, paper: bool) -> tuple[quadrature.Quadrature, PortResponses]:
    # the paper's sum is a midpoint rule that starts at Δω/2
    rule = quadrature.lateral_sum() if paper else quadrature.gauss(vehicle.axle_delay, start=0.005, per_decade=8)
    return rule, vehicle.random_track().responses(rule.omega, "body_acceleration")


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
    return close(vehicle.random_track(), {"secondary": _as_state_space(device)})


def lateral_psd(vehicle: PlanView, device: Rational, omega: Real) -> Real:
    """Single-sided density of the body acceleration, (m/s²)²/(rad/s), at each `omega`."""
    plant = vehicle.random_track()
    z, _ = plant.responses(omega, "body_acceleration").closed(_secondary(device, 1j * omega))
    return np.asarray(np.abs(z) ** 2 * plant.density)


def lateral_poles(vehicle: PlanView, device: Rational | StateSpace, speeds: Real = SPEEDS) -> np.ndarray:
    """Poles of the closed vehicle (without the track filter), speeds × modes, rad/s."""
    inside = {"secondary": _as_state_space(device)}
    matrices = [close(vehicle.at(v).random_track(), inside, shaped=False).A for v in speeds]
    return np.linalg.eigvals(np.array(matrices)).astype(complex)


def least_damping(vehicle: PlanView, device: Rational | StateSpace, speeds: Real = SPEEDS) -> damping.LeastDamping:
    """Ldmp: the least damping ratio of all poles over `speeds` (m/s)."""
    return damping.least(lateral_poles(vehicle, device, speeds), speeds)


def worst_lateral_rms(vehicle: PlanView, device: Rational, speeds: Real = SPEEDS) -> tuple[float, float]:
    """Macc and the speed of it: the largest J1y over `speeds`, found by the Gauss rule and summed as in the paper."""
    coarse = [lateral_rms(vehicle.at(v), device, paper=False) for v in speeds]
    worst = float(speeds[int(np.argmax(coarse))])
    return lateral_rms(vehicle.at(worst), device), worst


def curve_response(vehicle: PlanView, device: Rational, time: Real) -> Real:
    """Lateral displacement of the body (m) when entering the curve at t = 0 (curvature and cant rise over 3 s)."""
    loop = close(vehicle.curve_entry(), {"secondary": _as_state_space(device)})
    return time_response.corner_response(loop, "body_displacement", list(CURVE), time)


def curve_peak(vehicle: PlanView, device: Rational | StateSpace, *, duration: float = 8.0) -> float:
    """Max(yv): the largest lateral displacement of the body (m) on entering the curve."""
    loop = close(vehicle.curve_entry(), {"secondary": _as_state_space(device)})
    corners = list(CURVE)
    return time_response.peak(
        lambda time: time_response.corner_response(loop, "body_displacement", corners, time), duration
    )[0]


def lateral_metrics(vehicle: PlanView, device: Rational) -> dict[str, Metric]:
    """Every lateral figure of a device in the secondary port."""
    mode = least_damping(vehicle, device)
    here = least_damping(vehicle, device, np.array([vehicle.V]))
    for found in (mode, here):
        if found.ratio <= 0:
            raise Infeasible(
                f"the vehicle is not stable with this device: at {found.speed:g} m/s a mode of {found.frequency:.3g} "
                f"Hz has damping ratio {found.ratio:.3g}"
            )
    worst, speed = worst_lateral_rms(vehicle, device)
    return {
        "Macc": Metric(worst, "m/s^2", f"at {speed:g} m/s"),
        "J1y": Metric(lateral_rms(vehicle, device), "m/s^2", f"at {vehicle.V:g} m/s"),
        "Ldmp": Metric(100 * mode.ratio, "%", f"at {mode.speed:g} m/s, {mode.frequency:.3g} Hz"),
        "max_yv": Metric(1e3 * curve_peak(vehicle, device), "mm"),
        "static_stiffness": Metric(float(device.static_stiffness), "N/m"),
    }


# --- vertical ------------------------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def _vertical_responses(vehicle: SideView, output: str, panels: int) -> tuple[quadrature.Quadrature, PortResponses]:
    rule = quadrature.gauss(vehicle.wheel_delays[-1], per_decade=panels)
    return rule, vehicle.track().responses(rule.omega, output)


def vertical_rms(vehicle: SideView, device: Rational, output: str) -> float:
    """√(½ ∫₀^{40π} |output/δ̇1|² Sδ dω): r.m.s. up to 20 Hz of a named output of :meth:`SideView.track`, SI units."""
    density = vehicle.track().density

    def mean_square(panels: int) -> float:
        rule, port = _vertical_responses(vehicle, output, panels)
        z, _ = port.closed(_secondary(device, 1j * rule.omega))
        return rule.rms(z, density) ** 2

    return math.sqrt(quadrature.refined(mean_square))


def vertical_ride(vehicle: SideView, device: Rational, position: str) -> float:
    """J1z at a body point ``"L"``, ``"M"`` or ``"T"``, in %g."""
    return 100 * vertical_rms(vehicle, device, f"acceleration_{position}") / vehicle.g


def vertical_ride_over_the_whole_band(vehicle: SideView, device: Rational, position: str) -> float:
    """J1z without its end at 20 Hz, in %g, by covariance: what a device does above counts too."""
    return 100 * h2_norm.rms(vertical_loop(vehicle, device), f"acceleration_{position}") / vehicle.g


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
    return _slope(vertical_loop(vehicle, device), end, time)


def _slope(loop: ClosedLoop, end: str, time: Real) -> Real:
    return time_response.corner_response(loop, f"deflection_{end}", list(SLOPE), time)


def vertical_metrics(vehicle: SideView, device: Rational) -> dict[str, Metric]:
    """Every vertical figure of a device in the secondary ports, airspring included.

    ``deflection_front`` and ``_rear`` are the peaks on the slope, ``deflection_rms_…`` the r.m.s. on random track up to
    20 Hz, ``deflection_overall_…`` the peak plus three times the r.m.s.: [Jiang2012] gives an overall maximum without
    saying how slope and random track are put together, and this way reproduces its ranges.
    """
    loop = vertical_loop(vehicle, device)
    growth = float(loop.poles().real.max())
    if growth >= 0:
        raise Infeasible(f"the vehicle is not stable with this device: a pole has real part {growth:.3g} 1/s")
    found = {f"J1z_{position}": Metric(vertical_ride(vehicle, device, position), "%g") for position in ("L", "M", "T")}
    for end in ("front", "rear"):
        top, _ = time_response.peak(lambda time, end=end: _slope(loop, end, time), 8.0)  # type: ignore[misc]
        spread = vertical_rms(vehicle, device, f"deflection_{end}")
        found[f"deflection_{end}"] = Metric(1e3 * top, "mm", "peak on the slope")
        found[f"deflection_rms_{end}"] = Metric(1e3 * spread, "mm", "r.m.s. on random track")
        found[f"deflection_overall_{end}"] = Metric(1e3 * (top + 3 * spread), "mm", "peak + 3 r.m.s.")
    found["static_stiffness"] = Metric(float(device.static_stiffness), "N/m")
    return found


# --- quarter-car ---------------------------------------------------------------------------------------------


def quarter_car_loop(vehicle: QuarterCar, device: Rational | StateSpace) -> ClosedLoop:
    """The closed quarter-car on the road, driven by the white road velocity."""
    return close(vehicle.road(), {"secondary": _as_state_space(device)})


def quarter_car_by_frequency(vehicle: QuarterCar, device: Rational, output: str) -> float:
    """R.m.s. of ``acceleration`` or ``tyre_force`` over all frequencies by quadrature, SI units."""
    plant = vehicle.road()

    def mean_square(panels: int) -> float:
        rule = quadrature.whole_line(math.sqrt(vehicle.kt / vehicle.mu), per_decade=panels)
        z, _ = plant.responses(rule.omega, output).closed(_secondary(device, 1j * rule.omega))
        return rule.rms(z, plant.density) ** 2

    return math.sqrt(quadrature.refined(mean_square))


def quarter_car_metrics(vehicle: QuarterCar, device: Rational) -> dict[str, Metric]:
    """J1 and J3 over the whole band, by covariance."""
    loop = quarter_car_loop(vehicle, device)
    return {
        "J1": Metric(h2_norm.rms(loop, "acceleration"), "m/s^2"),
        "J3": Metric(h2_norm.rms(loop, "tyre_force"), "N"),
        "static_stiffness": Metric(float(device.static_stiffness), "N/m"),
    }


def _as_state_space(device: Rational | StateSpace) -> StateSpace:
    return device if isinstance(device, StateSpace) else state_space(device)
