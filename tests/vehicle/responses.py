"""Responses and single figures of the vehicles with one device in the secondary place, as the tests ask for them."""

from __future__ import annotations

import numpy as np

from posreal.admittance import Rational
from posreal.metric import ClosedVehicle, damping_ratio
from posreal.metric.damping_ratio import LeastDamping
from posreal.plant import quadrature
from posreal.plant.plant import Complex, Real
from posreal.vehicle import plan_view
from posreal.vehicle.plan_view import CURVE, PlanView
from posreal.vehicle.side_view import SLOPE, SideView

__all__ = [
    "CURVE",
    "SLOPE",
    "SPEEDS",
    "curve_response",
    "lateral_poles",
    "lateral_rms",
    "least_damping",
    "slope_deflection",
    "vertical_psd",
]

SPEEDS = np.array(plan_view.SPEEDS)
"""1, 2, … 55 m/s: the speeds of [Jiang2012]."""


def inside(vehicle: PlanView | SideView, device: Rational) -> ClosedVehicle:
    """The vehicle with `device` (whatever stands beside it included) in the secondary place."""
    return ClosedVehicle(vehicle, {"secondary": device})


def lateral_rms(vehicle: PlanView, device: Rational, *, paper: bool = True) -> float:
    """J1y: r.m.s. lateral body acceleration (m/s²) on straight random track up to 20 Hz, unconfirmed.

    Parameters
    ----------
    vehicle : PlanView
    device : Rational
        What stands in the secondary port, spring included.
    paper : bool
        The sum of [Jiang2012] (12,566 points); otherwise a Gauss rule on the same band, some twenty times cheaper.
    """
    rule = quadrature.lateral_sum() if paper else quadrature.gauss(vehicle.axle_delay, start=0.005, per_decade=8)
    return inside(vehicle, device).on("track").rms_on(rule, "body_acceleration")


def lateral_poles(vehicle: PlanView, device: Rational, speeds: Real = SPEEDS) -> Complex:
    """Poles of the closed vehicle (without the track filter), speeds × modes, rad/s."""
    return damping_ratio.poles(inside(vehicle, device), "track", speeds.tolist())


def least_damping(vehicle: PlanView, device: Rational, speeds: Real = SPEEDS) -> LeastDamping:
    """The least damped of all modes over `speeds`, m/s."""
    return damping_ratio.least_damping(inside(vehicle, device), "track", speeds.tolist())


def curve_response(vehicle: PlanView, device: Rational, time: Real) -> Real:
    """Lateral displacement of the body (m) when entering the curve at t = 0 (curvature and cant rise over 3 s)."""
    return inside(vehicle, device).on("curve").modes.ramp(time, CURVE, "body_displacement")


def vertical_psd(vehicle: SideView, device: Rational, position: str, omega: Real) -> Real:
    """Single-sided density of the body acceleration at ``"L"``, ``"M"`` or ``"T"``, (m/s²)²/(rad/s)."""
    return inside(vehicle, device).on("track").density(f"acceleration_{position}", omega)


def slope_deflection(vehicle: SideView, device: Rational, end: str, time: Real) -> Real:
    """Deflection (m) of the ``"front"`` or ``"rear"`` secondary suspension when running onto a slope at t = 0.

    The track accelerates at 0.4 m/s² for 1 s and keeps its gradient from then on.
    """
    return inside(vehicle, device).on("slope").modes.ramp(time, SLOPE, f"deflection_{end}")
