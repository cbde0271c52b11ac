"""Plan view of a two-axle bogie and half a body: the lateral model of [Jiang2012], 7 degrees of freedom.

q = (yw1, θw1, yw2, θw2, yg, θg, yv): leading and trailing wheelset, bogie frame, body.

    primary lateral   2 (Kpy + Cpy d/dt) on (ywᵢ − yg ∓ lwx θg)
    primary yaw       2 lx² (Kpx + Cpx d/dt) on (θwᵢ − θg)
    creep             lateral (2 f22/V) ẏwᵢ − 2 f22 θwᵢ,   yaw (2 f11 lwy²/V) θ̇wᵢ + (2 f11 λ lwy/r0)(ywᵢ − ytᵢ)
    secondary         2 Y on the relative velocity of (yg − yv)

The creep terms are not symmetric: the wheel–rail contact feeds energy in, and the bare port is not passive.

The track's lateral velocity is ẏt = H(s)·white with H ∝ 1/s at low frequency, so neither the track nor the
coordinates have a finite variance; the accelerations do. The equations are linear: differentiated twice, they hold
between ÿt = s H(s)·white (proper, no integrator) and q̈, and the body acceleration is the coordinate yv of that
system. The density of the white process is Sy = 2π Al V²: the paper prints 2π Al V, but only V² gives its figures
(0.2204 m/s² at 55 m/s), and a 1/f³ spatial spectrum, which H approximates, leads to V².
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.metric import (
    ClosedVehicle,
    DampingRatio,
    FiveSecondPercentile,
    Inertance,
    LargestOverSpeeds,
    MeanComfort,
    Metric,
    PeakInTime,
    RootMeanSquare,
    SperlingIndex,
    StaticStiffness,
    SummedRootMeanSquare,
)
from posreal.metric.damping_ratio import least_damping
from posreal.plant.mounting import Copy, Mounting
from posreal.plant.plant import Plant, Real
from posreal.plant.second_order import SecondOrder
from posreal.plant.shaping_filter import ShapingFilter
from posreal.ranges import PRIMARY, SECONDARY
from posreal.real_elements import RAIL
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.parameters import parameter, validated
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track, shaken
from posreal.vehicle.vehicle import RAIL_BAND, WHOLE
from posreal.vehicle.weighting import SPERLING, WEIGHTED, Weighting, filtered, sperling

_TABLE1 = "Jiang2012, Table 1"
SPEEDS = tuple(float(speed) for speed in range(1, 56))
"""1, 2, … 55 m/s: the speeds of [Jiang2012]."""
CURVE = ((0.0, 1 / 3.0), (3.0, -1 / 3.0))
"""Corners (instant in s, change of rate in 1/s) of the way from the straight into the full curve, 3 s long."""
_BODY = "body_acceleration"
_J1Y = SummedRootMeanSquare("track", _BODY, "m/s^2")
_J1Y_WHOLE = RootMeanSquare("track", _BODY, "m/s^2")
_LDMP = DampingRatio("track", SPEEDS)
LATERAL_SPERLING = 0.737


def _comfort(stop: float = math.inf) -> dict[str, Metric]:
    """Of the weighted lateral acceleration: r.m.s. up to `stop`, rad/s, a95, N_MV, and Sperling's Wz."""
    aw, a95 = RootMeanSquare(WEIGHTED, _BODY, "m/s^2", stop), FiveSecondPercentile(WEIGHTED, _BODY)
    return {
        "max_aw_y": LargestOverSpeeds(aw, SPEEDS),
        "aw_y": aw,
        "a95_y": a95,
        "NMV_y": MeanComfort((("", a95),)),
        "Wz_y": SperlingIndex(SPERLING, _BODY),
    }


@lru_cache
def _metrics(cut_off: float | None) -> Mapping[str, Metric]:
    return {
        "Macc": LargestOverSpeeds(_J1Y, SPEEDS),
        "Macc_whole": LargestOverSpeeds(_J1Y_WHOLE, SPEEDS),
        "J1y": _J1Y,
        "J1y_whole": _J1Y_WHOLE,
        "Ldmp": _LDMP,
        "max_yv": PeakInTime("curve", "body_displacement", CURVE, "mm", 1e3),
        "static_stiffness": StaticStiffness(),
        "inertance": Inertance(),
        **_comfort(math.inf if cut_off is None else 2 * math.pi * cut_off),
    }


@dataclass(frozen=True)
class PlanView:
    """Parameters of the lateral model, defaults from [Jiang2012] Table 1."""

    name: ClassVar[str] = "plan-view"

    mw: float = parameter(1376.0, "kg", "wheelset mass", source=_TABLE1)
    Iw: float = parameter(766.0, "kg m^2", "wheelset yaw inertia", source=_TABLE1)
    mg: float = parameter(3477.0, "kg", "bogie frame mass", source=_TABLE1)
    Ig: float = parameter(3200.0, "kg m^2", "bogie frame yaw inertia", source=_TABLE1)
    mv: float = parameter(17230.0, "kg", "half body mass", source=_TABLE1)
    r0: float = parameter(0.445, "m", "wheel radius", source=_TABLE1)
    conicity: float = parameter(0.3, "1", "wheel conicity λ", source=_TABLE1)
    f11: float = parameter(1e7, "N", "longitudinal creep coefficient", source=_TABLE1)
    f22: float = parameter(1e7, "N", "lateral creep coefficient", source=_TABLE1)
    lwx: float = parameter(1.225, "m", "semi wheelbase", source=_TABLE1)
    lwy: float = parameter(0.75, "m", "half gauge", source=_TABLE1)
    lx: float = parameter(1.2, "m", "half lateral spacing of the primary suspension", source=_TABLE1)
    Kpx: float = parameter(3.766e7, "N/m", "primary longitudinal stiffness", source=_TABLE1)
    Cpx: float = parameter(1.017e4, "N*s/m", "primary longitudinal damping", source=_TABLE1, may_be_zero=True)
    Kpy: float = parameter(4.71e6, "N/m", "primary lateral stiffness", source=_TABLE1)
    Cpy: float = parameter(1.2e4, "N*s/m", "primary lateral damping", source=_TABLE1, may_be_zero=True)
    Ksy: float = parameter(2.45e5, "N/m", "secondary lateral stiffness", source=_TABLE1)
    Csy: float = parameter(2e4, "N*s/m", "secondary lateral damping", source=_TABLE1)
    R: float = parameter(1000.0, "m", "curve radius R1 = R2", source=_TABLE1)
    cant: float = parameter(6 * math.pi / 180, "rad", "cant angle θc1 = θc2", source=_TABLE1, may_be_zero=True)
    g: float = parameter(9.8, "m/s^2", "gravity", source=_TABLE1)
    Al: float = parameter(1.886e-9, "m", "lateral track roughness", source=_TABLE1)
    V: float = parameter(55.0, "m/s", "speed", source=_TABLE1)
    irregularity: Track | None = None
    weighting: Weighting | None = None
    cut_off: float | None = None  # Hz, of the weighted figures

    weighted: ClassVar[Mapping[str, str]] = {
        name + band: to for name, to in (("Macc", "max_aw_y"), ("J1y", "aw_y")) for band in ("", WHOLE)
    }
    comfort: ClassVar[tuple[str, ...]] = tuple(_comfort())
    headline: ClassVar[tuple[str, ...]] = (
        "Macc",
        "Macc_whole",
        "J1y",
        "J1y_whole",
        "Ldmp",
        "max_yv",
        "static_stiffness",
    )
    columns: ClassVar[tuple[str, ...]] = ("Macc", "Ldmp", "max_yv")
    compared: ClassVar[tuple[str, ...]] = ()
    ride: ClassVar[str] = "Macc"
    random: ClassVar[str] = "track"
    passive: ClassVar[bool] = False  # the wheel–rail contact feeds energy in
    free: ClassVar[Mapping[str, tuple[str, int]]] = {
        "Ksy": ("secondary", -1),
        "Kpy": ("primary", -1),
        "Cpy": ("primary", 0),
    }
    pade_band: ClassVar[float | None] = RAIL_BAND
    body: ClassVar[FlexibleBody | None] = None
    direction: ClassVar[Direction | None] = "lateral"

    def __post_init__(self) -> None:
        validated(self)

    @property
    def metrics(self) -> Mapping[str, Metric]:
        """Everything that can be evaluated."""
        return _metrics(self.cut_off)

    @property
    def places(self) -> Mapping[str, Place]:
        """The secondary and the primary lateral suspension: a device beside the spring, in place of the damper."""
        spring = Rational.spring(self.Ksy)
        return {
            "secondary": Place(
                Mounting(beside=spring, behind=None),
                roles={"static spring": "Ksy"},
                terminals=("body", "bogie"),
                default=Rational.damper(self.Csy),
                has_default=True,
                default_label="default (k | c)",
                carried=self.mv / 2,
                copies=(Copy((math.sqrt(0.5),), 2),),
                usual=SECONDARY,
                elements=RAIL,
            ),
            "primary": Place(
                Mounting(beside=Rational.spring(self.Kpy), behind=None),
                roles={"static spring": "Kpy"},
                terminals=("bogie", "axle box"),
                default=Rational.damper(self.Cpy) if self.Cpy else None,
                has_default=True,
                default_label="default (k | c)",
                carried=self.mg / 4,
                copies=(Copy((math.sqrt(0.5), 0.0), 2), Copy((0.0, math.sqrt(0.5)), 2)),
                usual=PRIMARY,
                elements=RAIL,
            ),
        }

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on random ``track`` or entering a ``curve``; `opened`: the primary suspension as ports too."""
        return _plant(self, load, opened)

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Stable at every speed of the list, and at its own."""
        for speeds in (SPEEDS, (self.V,)):
            least_damping(closed, "track", speeds).require_positive()

    def at(self, speed: float) -> PlanView:
        """The same vehicle at another speed, m/s."""
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        return dataclasses.replace(self, V=float(speed))

    @property
    def axle_delay(self) -> float:
        """Td = 2 lwx/V, seconds from the leading to the trailing wheelset."""
        return 2 * self.lwx / self.V

    def second_order(self, *, primary_open: bool = False) -> SecondOrder:
        """M, C, K without the secondary suspension; its port is (yg − yv), two devices in parallel.

        With `primary_open` the primary lateral springs and dampers are left out too, and their places (leading and
        trailing) are the second and third port: what varies with Kpy and Cpy is then a device like any other.
        """
        M = np.diag([self.mw, self.Iw, self.mw, self.Iw, self.mg, self.Ig, self.mv])
        C, K = np.zeros((7, 7)), np.zeros((7, 7))
        # Two devices share each port: they see the same relative displacement d and push with 2 Y. With √2 in E
        # this is one symmetric port, whose displacement is √2 d.
        secondary = np.zeros(7)
        secondary[[4, 6]] = math.sqrt(2), -math.sqrt(2)
        ports = [secondary]
        for yw, thw, arm in ((0, 1, self.lwx), (2, 3, -self.lwx)):
            lateral = np.zeros(7)
            lateral[[yw, 4, 5]] = np.array([1.0, -1.0, -arm]) * math.sqrt(2)
            if primary_open:
                ports.append(lateral)
            else:
                K += self.Kpy * np.outer(lateral, lateral)
                C += self.Cpy * np.outer(lateral, lateral)
            yaw = np.zeros(7)
            yaw[[thw, 5]] = 1.0, -1.0
            K += 2 * self.lx**2 * self.Kpx * np.outer(yaw, yaw)
            C += 2 * self.lx**2 * self.Cpx * np.outer(yaw, yaw)
            C[yw, yw] += 2 * self.f22 / self.V
            K[yw, thw] -= 2 * self.f22
            C[thw, thw] += 2 * self.f11 * self.lwy**2 / self.V
            K[thw, yw] += self._conicity_stiffness
        return SecondOrder(M, C, K, np.column_stack(ports), ("yw1", "thw1", "yw2", "thw2", "yg", "thg", "yv"))

    @property
    def _conicity_stiffness(self) -> float:
        return 2 * self.f11 * self.conicity * self.lwy / self.r0

    def random_track(self, *, primary_open: bool = False) -> Plant:
        """Plant on straight random track: one output, ``body_acceleration`` (m/s²).

        Port group ``secondary``, and with `primary_open` also ``primary``, which holds Kpy/s + Cpy at both wheelsets.
        """
        N0 = np.zeros((7, 2))
        N0[1, 0] = N0[3, 1] = self._conicity_stiffness
        plant = self._plant(
            self.second_order(primary_open=primary_open),
            N0,
            "body_acceleration",
            shaping=_track_acceleration(),
            density=2 * math.pi * self.Al * self.V**2,
        )
        alignment = None if self.irregularity is None else self.irregularity.lateral
        return plant if alignment is None else shaken(plant, alignment, self.V, 2)

    def curve_entry(self, *, primary_open: bool = False) -> Plant:
        """Plant entering the curve: w rises from 0 on the straight to 1 in the full curve; ``body_displacement`` (m).

        Channel 0 is the part of the forces that follows the leading wheelset's curvature and cant, channel 1 the
        trailing one's, late by Td; bogie and body feel the mean of both.
        """
        lateral = self.V**2 / self.R - self.g * self.cant
        F = np.zeros((7, 2))
        for channel, (yw, thw) in enumerate(((0, 1), (2, 3))):
            F[yw, channel] = self.mw * lateral
            F[thw, channel] = 2 * self.f11 * self.lwy**2 / self.R
            F[4, channel] = self.mg * lateral / 2
            F[6, channel] = self.mv * lateral / 2
        return self._plant(self.second_order(primary_open=primary_open), F, "body_displacement")

    def _plant(
        self,
        body: SecondOrder,
        force: Real,
        output: str,
        shaping: ShapingFilter | None = None,
        density: float = 1.0,
    ) -> Plant:
        """Forces from the leading and the trailing wheelset's track in, the body's lateral coordinate out."""
        ports, zeros = body.E.T, np.zeros_like(body.E.T)
        return Plant(
            A=body.free(),
            Bw=body.applied_force(force),
            Bf=body.device_force(),
            Cz=np.concatenate([body.row(yv=1), np.zeros(7)])[None, :],
            Dzw=np.zeros((1, 2)),
            Dzf=np.zeros((1, len(ports))),
            Cd=np.hstack([ports, zeros]),
            Cv=np.hstack([zeros, ports]),
            delays=np.array([0.0, self.axle_delay]),
            outputs=(output,),
            groups=("secondary", "primary", "primary")[: len(ports)],
            shaping=shaping,
            density=density,
        )


@lru_cache(maxsize=256)
def _plant(vehicle: PlanView, load: str, opened: bool) -> Plant:
    if load == "curve":
        return vehicle.curve_entry(primary_open=opened)
    track = vehicle.random_track(primary_open=opened)
    if load not in (WEIGHTED, SPERLING):
        return track
    through = sperling(LATERAL_SPERLING) if load == SPERLING else (vehicle.weighting or Weighting("Wd")).filter
    return filtered(track, through, track.outputs)


def lateral_track_filter(s: np.ndarray) -> np.ndarray:
    """H(s) = (21.69 s² + 105.6 s + 14.42)/(s³ + 30.64 s² + 24.07 s): track velocity from white noise [Jiang2012]."""
    return (21.69 * s**2 + 105.6 * s + 14.42) / (s**3 + 30.64 * s**2 + 24.07 * s)


def _track_acceleration() -> ShapingFilter:
    """s H(s) = 21.69 + (c₁ s + c₀)/(s² + 30.64 s + 24.07): H without its integrator."""
    a1, a0, b2, b1, b0 = 30.64, 24.07, 21.69, 105.6, 14.42
    A: Real = np.array([[0.0, 1.0], [-a0, -a1]])
    return ShapingFilter(A, np.array([[0.0], [1.0]]), np.array([[b0 - b2 * a0, b1 - b2 * a1]]), np.array([[b2]]))
