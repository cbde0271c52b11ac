"""Side view of a four-axle vehicle: the vertical model of [Jiang2012], 6 degrees of freedom.

q = (zv, θv, zb1, θb1, zb2, θb2): body, leading bogie, trailing bogie. G1 = 2 Kpz/s + 2 Cpz a wheelset.

    mv z̈v  = G2 s (zb1 + zb2 − 2 zv)
    Iv θ̈v  = lvx G2 s (zb1 − zb2 − 2 lvx θv)
    mb z̈bᵢ = G1 s (δ + δ' − 2 zbᵢ) − G2 s (zbᵢ − zv ∓ lvx θv)
    Ib θ̈bᵢ = lbx G1 s (δ − δ' − 2 lbx θbᵢ)

G2 is what stands in the two secondary ports: the airspring (Nishimura's linear model) and the device beside it.
The ports are taken as bounce, ((zb1 + zb2) − 2 zv)/√2, and pitch, ((zb1 − zb2) − 2 lvx θv)/√2: these do not feel
each other, so the vehicle is two scalar loops that share one device. The track velocity δ̇1 is white with
Sδ = 2π Av V; the other wheelsets follow after τᵢ = Lᵢ/V.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, Protocol

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.metric import (
    ClosedVehicle,
    FiveSecondPercentile,
    Inertance,
    LargestGain,
    MeanComfort,
    Metric,
    PeakInTime,
    RootMeanSquare,
    SperlingIndex,
    StaticStiffness,
    WeightedSum,
)
from posreal.plant.mounting import Copy, Mounting
from posreal.plant.plant import Plant, Real
from posreal.plant.quadrature import BAND
from posreal.plant.second_order import SecondOrder
from posreal.ranges import SECONDARY
from posreal.real_elements import RAIL
from posreal.vehicle.flexible_body import BodyMode, FlexibleBody, read_modes
from posreal.vehicle.parameters import parameter, validated
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track, driven_by_acceleration, shaken
from posreal.vehicle.vehicle import RAIL_BAND, WHOLE
from posreal.vehicle.weighting import SPERLING, WEIGHTED, Weighting, filtered, sperling

_TABLE4 = "Jiang2012, Table 4"
_HALF = math.sqrt(0.5)
SLOPE = ((0.0, 0.4), (1.0, -0.4))
"""Corners of the track velocity when running onto the slope: 0.4 m/s² for 1 s."""


def per_cent_g(vehicle: SideView) -> float:
    """%g in m/s²."""
    return 100 / vehicle.g


def millimetres(vehicle: SideView) -> float:
    """mm in m."""
    return 1e3


def _ride(point: str, stop: float) -> RootMeanSquare:
    return RootMeanSquare("track", f"acceleration_{point}", "%g", stop, per_cent_g)


PLACES = {"L": "over the leading bogie", "M": "in the middle", "T": "over the trailing bogie"}
"""Where the body's acceleration is an output."""
VERTICAL_SPERLING = 0.588


def _comfort(stop: float) -> dict[str, Metric]:
    """Of the weighted vertical acceleration: r.m.s. up to `stop`, rad/s, a95, N_MV, and Sperling's Wz."""
    percentiles = {point: FiveSecondPercentile(WEIGHTED, f"acceleration_{point}") for point in PLACES}
    rms = {
        point: RootMeanSquare(WEIGHTED, f"acceleration_{point}", "m/s^2", stop, also=("%g", per_cent_g))
        for point in PLACES
    }
    return {
        **{f"aw_{point}": metric for point, metric in rms.items()},
        **{f"a95_{point}": metric for point, metric in percentiles.items()},
        "NMV_z": MeanComfort(tuple((PLACES[point], metric) for point, metric in percentiles.items())),
        **{f"Wz_{point}": SperlingIndex(SPERLING, f"acceleration_{point}") for point in PLACES},
    }


def _velocity(end: str) -> RootMeanSquare:
    """Of the secondary suspension on random track, over all frequencies: what a damper there has to bear."""
    return RootMeanSquare("track", f"deflection_velocity_{end}", "mm/s", factor=millimetres, at="on random track")


def _deflections(end: str) -> dict[str, Metric]:
    """Of the secondary suspension: the peak on the slope, the r.m.s. on random track, and the two together.

    [Jiang2012] gives an overall maximum without saying how slope and random track are put together; the peak plus three
    times the r.m.s. reproduces its ranges.
    """
    peak = PeakInTime("slope", f"deflection_{end}", SLOPE, "mm", 1e3, "peak on the slope")
    rms = RootMeanSquare("track", f"deflection_{end}", "mm", BAND, millimetres, "r.m.s. on random track")
    return {
        f"deflection_{end}": peak,
        f"deflection_rms_{end}": rms,
        f"deflection_rms_{end}_whole": replace(rms, stop=math.inf),
        f"deflection_overall_{end}": WeightedSum(((1.0, peak), (3.0, rms)), "peak + 3 r.m.s."),
    }


@lru_cache
def vertical_metrics(cut_off: float | None = None) -> Mapping[str, Metric]:
    """The metrics of a side view, whose ride figures end at `cut_off` Hz, or where they usually do."""
    stop = math.inf if cut_off is None else 2 * math.pi * cut_off
    return {
        **{
            f"J1z_{point}{band}": _ride(point, end)
            for point in PLACES
            for band, end in (("", BAND if cut_off is None else stop), (WHOLE, math.inf))
        },
        **_deflections("front"),
        **_deflections("rear"),
        "static_stiffness": StaticStiffness(),
        "inertance": Inertance(),
        **{f"deflection_velocity_rms_{end}": _velocity(end) for end in ("front", "rear")},
        **{f"gain_acceleration_{point}": LargestGain("slope", f"acceleration_{point}") for point in PLACES},
        **_comfort(stop),
    }


@dataclass(frozen=True)
class SideView:
    """Parameters of the vertical model, defaults from [Jiang2012] Table 4."""

    name: ClassVar[str] = "side-view"

    mv: float = parameter(38000.0, "kg", "body mass", source=_TABLE4)
    mb: float = parameter(2500.0, "kg", "bogie mass", source=_TABLE4)
    Iv: float = parameter(2.31e6, "kg m^2", "body pitch inertia", source=_TABLE4)
    Ib: float = parameter(1500.0, "kg m^2", "bogie pitch inertia", source=_TABLE4)
    lvx: float = parameter(9.5, "m", "semi distance of the bogie centres", source=_TABLE4)
    lbx: float = parameter(1.25, "m", "semi wheelbase", source=_TABLE4)
    Kaz: float = parameter(0.0, "N/m", "airspring change-of-area stiffness", source=_TABLE4, may_be_zero=True)
    Ksz: float = parameter(1.016e6, "N/m", "airspring stiffness", source=_TABLE4)
    Krz: float = parameter(0.508e6, "N/m", "airspring reservoir stiffness", source=_TABLE4)
    Crz: float = parameter(64.11e3, "N*s/m", "airspring orifice damping", source=_TABLE4)
    Kpz: float = parameter(4.935e6, "N/m", "primary vertical stiffness", source=_TABLE4)
    Cpz: float = parameter(50.74e3, "N*s/m", "primary vertical damping", source=_TABLE4)
    bush: float = parameter(5e6, "N/m", "stiffness of the device's end bush", source="Jiang2012, section 4")
    g: float = parameter(9.8, "m/s^2", "gravity, the unit of %g", source=_TABLE4)
    Av: float = parameter(2.5e-7, "m", "vertical track roughness", source=_TABLE4)
    V: float = parameter(55.0, "m/s", "speed", source=_TABLE4)
    body: FlexibleBody | None = None
    irregularity: Track | None = None
    weighting: Weighting | None = None
    cut_off: float | None = None  # Hz

    weighted: ClassVar[Mapping[str, str]] = {
        f"J1z_{point}{band}": f"aw_{point}" for point in PLACES for band in ("", "_whole")
    }
    comfort: ClassVar[tuple[str, ...]] = tuple(_comfort(math.inf))
    headline: ClassVar[tuple[str, ...]] = (
        *(f"J1z_{point}{band}" for point in PLACES for band in ("", WHOLE)),
        *_deflections("front"),
        *_deflections("rear"),
        "static_stiffness",
    )
    columns: ClassVar[tuple[str, ...]] = ("J1z_L", "J1z_M", "J1z_T")
    compared: ClassVar[tuple[str, ...]] = columns
    ride: ClassVar[str] = "J1z_T"
    random: ClassVar[str] = "track"
    passive: ClassVar[bool] = True
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}
    pade_band: ClassVar[float | None] = RAIL_BAND
    tables: ClassVar[Mapping[str, tuple[str, Callable[[Any, str], Any]]]] = {"modes": ("body", read_modes)}
    direction: ClassVar[Direction | None] = "vertical"

    def __post_init__(self) -> None:
        validated(self)

    @property
    def metrics(self) -> Mapping[str, Metric]:
        """Everything that can be evaluated."""
        return vertical_metrics(self.cut_off)

    @property
    def places(self) -> Mapping[str, Place]:
        """The secondary vertical suspension: a device behind its bush, beside the airspring."""
        airspring = self.airspring()
        return {
            "secondary": Place(
                Mounting(beside=airspring, behind=Rational.spring(self.bush)),
                beside_strut=airspring,
                roles={"bush": "bush"},
                terminals=("body", "bogie"),
                has_default=True,
                default_label="airspring only",
                carried=self.mv / 2,
                copies=(Copy((_HALF, _HALF)), Copy((_HALF, -_HALF))),  # front and rear
                usual=SECONDARY,
                elements=RAIL,
                travels=("deflection_overall_front", "deflection_overall_rear"),
            )
        }

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on random ``track`` or running onto a ``slope``: the same plant; or the track, accelerations
        weighted."""
        return _plant(self, load)

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Every mode that an output sees decays."""
        closed.on("track").require_stable()

    def at(self, speed: float) -> SideView:
        """The same vehicle at another speed, m/s."""
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        return dataclasses.replace(self, V=float(speed))

    @property
    def wheel_delays(self) -> tuple[float, float, float, float]:
        """τ of the four wheelsets, seconds after the first."""
        return (0.0, 2 * self.lbx / self.V, 2 * self.lvx / self.V, 2 * (self.lvx + self.lbx) / self.V)

    def airspring(self) -> Rational:
        """Nishimura's airspring Kaz | (Ksz + (Krz | Crz)) as an admittance."""
        orifice = Rational.spring(self.Krz) | Rational.damper(self.Crz)
        spring = Rational.spring(self.Ksz) + orifice
        return spring if self.Kaz == 0 else Rational.spring(self.Kaz) | spring

    def second_order(self) -> SecondOrder:
        """M, C, K without the secondary suspension; ports bounce and pitch."""
        modes = self.bending()
        M = np.diag([self.mv, self.Iv, self.mb, self.Ib, self.mb, self.Ib, *(mode.mass for mode in modes)])
        K = np.diag([0.0] * 6 + [mode.mass * mode.omega**2 for mode in modes])
        C = self.bending_damping()
        for wheel in self.wheels():
            K += 2 * self.Kpz * np.outer(wheel, wheel)
            C += 2 * self.Cpz * np.outer(wheel, wheel)
        front = np.array([-1.0, -self.lvx, 1.0, 0.0, 0.0, 0.0, *(-mode.front for mode in modes)])
        rear = np.array([-1.0, self.lvx, 0.0, 0.0, 1.0, 0.0, *(-mode.rear for mode in modes)])
        E = np.column_stack([front + rear, front - rear]) / math.sqrt(2)
        names = ("zv", "thv", "zb1", "thb1", "zb2", "thb2", *(f"q{n}" for n in range(1, len(modes) + 1)))
        return SecondOrder(M, C, K, E, names)

    def bending(self) -> tuple[BodyMode, ...]:
        """The modes of the body; none where it is rigid."""
        return () if self.body is None else self.body.modes(self.mv, self.Iv, self.lvx)

    def bending_damping(self) -> np.ndarray:
        """C of the body's modes alone."""
        return np.diag([0.0] * 6 + [2 * mode.damping * mode.omega * mode.mass for mode in self.bending()])

    def wheels(self) -> np.ndarray:
        """Displacement of the bogie over each of the four wheelsets, as rows on q."""
        wheels = np.zeros((4, 6 + len(self.bending())))
        for i, (zb, arm) in enumerate(((2, self.lbx), (2, -self.lbx), (4, self.lbx), (4, -self.lbx))):
            wheels[i, zb], wheels[i, zb + 1] = 1.0, arm
        return wheels

    def track(self) -> Plant:
        """Plant on the track profile, w = δ̇1.

        Outputs: ``acceleration_L``, ``_M``, ``_T`` (m/s²) of the body over the leading bogie, in the middle and over
        the trailing bogie; ``deflection_front``, ``deflection_rear`` (m) of the secondary suspension, and their
        velocities, ``deflection_velocity_front`` and ``_rear`` (m/s). Both ports hold the device of group
        ``secondary``.
        """
        body, wheels = self.second_order(), self.wheels()
        Bw = body.track_velocity(2 * self.Kpz * wheels.T, 2 * self.Cpz * wheels.T)
        density = math.pi * self.Av * self.V
        at = (self.lvx, self.bending())
        return seen_from_the_side(body, at, body.free(), Bw, body.device_force(), self.wheel_delays, density)


def seen_from_the_side(
    body: SecondOrder,
    at: tuple[float, tuple[BodyMode, ...]],
    A: Real,
    Bw: Real,
    Bf: Real,
    delays: Sequence[float],
    density: float,
) -> Plant:
    """The outputs and ports of a side view, whatever follows its coordinates and their rates in the state.

    Parameters
    ----------
    body : SecondOrder
        Coordinates zv, thv, those of the bogies, and the body's modes q1, …; ports bounce and pitch.
    at : semi distance of the bogie centres, m, and the modes
    A (n, n), Bw (n, 4), Bf (n, 2)
    delays : of the four wheelsets, s
    density : of the track velocity, per rad/s
    """
    lvx, modes = at
    count = len(body.M)
    zeros, rest = np.zeros(count), np.zeros((2, len(A) - 2 * count))

    def point(arm: float, shape: Sequence[float]) -> Real:
        return body.row(zv=1, thv=arm, **{f"q{n}": value for n, value in enumerate(shape, 1)})

    front, rear = point(lvx, [mode.front for mode in modes]), point(-lvx, [mode.rear for mode in modes])
    points = [front, point(0.0, [mode.middle for mode in modes]), rear]
    acceleration = np.array([np.concatenate([zeros, row, rest[0]]) for row in points])
    deflection = np.array([body.row(zb1=1) - front, body.row(zb2=1) - rear])
    return Plant(
        A=A,
        Bw=Bw,
        Bf=Bf,
        Cz=np.vstack([acceleration @ A, np.hstack([np.kron(np.eye(2), deflection), np.zeros((4, rest.shape[1]))])]),
        Dzw=np.vstack([acceleration @ Bw, np.zeros((4, 4))]),
        Dzf=np.vstack([acceleration @ Bf, np.zeros((4, 2))]),
        Cd=np.hstack([body.E.T, np.zeros((2, count)), rest]),
        Cv=np.hstack([np.zeros((2, count)), body.E.T, rest]),
        delays=np.array(delays),
        outputs=(
            *(f"acceleration_{point}" for point in "LMT"),
            "deflection_front",
            "deflection_rear",
            "deflection_velocity_front",
            "deflection_velocity_rear",
        ),
        groups=("secondary", "secondary"),
        density=density,
    )


def from_acceleration(plant: Plant, count: int = 6) -> Plant:
    """A side view of so many coordinates driven by the acceleration of the profile in place of its velocity."""
    climbing = np.zeros_like(plant.Bw)
    climbing[count : 2 * count] = -plant.Bw[:count]  # q̃ stays and q̇ is the velocity of the profile, shape by shape
    return driven_by_acceleration(plant, climbing)


class SeenFromTheSide(Protocol):
    """What its load needs to know of a side view."""

    @property
    def V(self) -> float: ...

    @property
    def body(self) -> FlexibleBody | None: ...

    @property
    def irregularity(self) -> Track | None: ...

    @property
    def weighting(self) -> Weighting | None: ...

    def bending(self) -> tuple[BodyMode, ...]: ...


def on_load(vehicle: SeenFromTheSide, plant: Plant, load: str) -> Plant:
    """A side view on one of its loads, from the plant on the profile's white velocity of [Jiang2012].

    Without a track of its own it runs on that of the paper, and without a weighting it is weighted by Wb.
    """
    if load == "slope":
        return plant
    if vehicle.irregularity is not None:
        spectrum = vehicle.irregularity.spectrum("vertical")
        derivative = max(1, spectrum.fitted().law.least_derivative())
        driven = plant if derivative == 1 else from_acceleration(plant, 6 + len(vehicle.bending()))
        plant = shaken(driven, spectrum, vehicle.V, derivative)
    if load not in (WEIGHTED, SPERLING):
        return plant
    through = sperling(VERTICAL_SPERLING) if load == SPERLING else (vehicle.weighting or Weighting("Wb")).filter
    return filtered(plant, through, tuple(f"acceleration_{point}" for point in PLACES))


@lru_cache(maxsize=256)
def _plant(vehicle: SideView, load: str) -> Plant:
    return on_load(vehicle, vehicle.track(), load)
