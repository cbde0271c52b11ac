"""Quarter-car: the reference problem of [PS2006].

    ms z̈s = −F,   mu z̈u = F − kt (zu − zr),   F = (k/s + K)(żs − żu),   żr = w white

Ride figure J1 = 2π √(V κ) ‖z̈s/żr‖₂ and tyre load figure J3 = 2π √(V κ) ‖kt (zu − zr)/żr‖₂. With the norm
(1/2π ∫_{−∞}^{∞})^{1/2} this is a white track velocity of single-sided density Sδ = 4π V κ per rad/s: π Sδ ‖·‖₂² = J².
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
from posreal.metric import ClosedVehicle, Inertance, LargestGain, Metric, RootMeanSquare, StaticStiffness
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant
from posreal.plant.second_order import SecondOrder
from posreal.ranges import ROAD
from posreal.real_elements import ROAD as REAL_ROAD
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.parameters import parameter, validated
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.vehicle import RAIL_BAND
from posreal.vehicle.weighting import Weighting

_PS = "PS2006, section V"


@dataclass(frozen=True)
class QuarterCar:
    """Parameters of the quarter-car, defaults from [PS2006]."""

    name: ClassVar[str] = "quarter-car"

    ms: float = parameter(250.0, "kg", "sprung mass", source=_PS)
    mu: float = parameter(35.0, "kg", "unsprung mass", source=_PS)
    kt: float = parameter(150e3, "N/m", "tyre stiffness", source=_PS)
    k: float = parameter(60e3, "N/m", "static suspension stiffness", source=_PS)
    kappa: float = parameter(5e-7, "m", "road roughness κ, m³/cycle over m²", source=_PS)
    V: float = parameter(25.0, "m/s", "speed", source=_PS)

    metrics: ClassVar[Mapping[str, Metric]] = {
        "J1": RootMeanSquare("road", "acceleration", "m/s^2"),
        "J3": RootMeanSquare("road", "tyre_force", "N"),
        "static_stiffness": StaticStiffness(),
        "inertance": Inertance(),
        "gain_acceleration": LargestGain("road", "acceleration"),
        "gain_tyre_force": LargestGain("road", "tyre_force"),
    }
    headline: ClassVar[tuple[str, ...]] = ("J1", "J3", "static_stiffness")
    columns: ClassVar[tuple[str, ...]] = ("J1", "J3")
    compared: ClassVar[tuple[str, ...]] = ()
    ride: ClassVar[str] = "J1"
    random: ClassVar[str] = "road"
    body: ClassVar[FlexibleBody | None] = None
    direction: ClassVar[Direction | None] = None
    irregularity: ClassVar[Track | None] = None
    weighting: ClassVar[Weighting | None] = None
    weighted: ClassVar[Mapping[str, str]] = {}
    comfort: ClassVar[tuple[str, ...]] = ()
    passive: ClassVar[bool] = True
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}
    pade_band: ClassVar[float | None] = RAIL_BAND

    def __post_init__(self) -> None:
        validated(self)

    def at(self, speed: float) -> QuarterCar:
        """The same vehicle at another speed, m/s."""
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        return dataclasses.replace(self, V=float(speed))

    @property
    def places(self) -> Mapping[str, Place]:
        """The suspension: a device beside the static spring; the bare spring is no suspension to compare with."""
        return {
            "secondary": Place(
                Mounting(beside=Rational.spring(self.k), behind=None),
                roles={"static spring": "k"},
                terminals=("body", "wheel"),
                carried=self.ms,
                usual=ROAD,
                elements=REAL_ROAD,
            )
        }

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The vehicle on its random ``road``."""
        return _plant(self)

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Every mode that an output sees decays."""
        closed.on("road").require_stable()

    def second_order(self) -> SecondOrder:
        """q = (zs, zu); the port is (zs − zu)."""
        return SecondOrder(
            M=np.diag([self.ms, self.mu]),
            C=np.zeros((2, 2)),
            K=np.diag([0.0, self.kt]),
            E=np.array([[1.0], [-1.0]]),
            coordinates=("zs", "zu"),
        )

    def road(self) -> Plant:
        """Plant on the road, w = żr; outputs ``acceleration`` (m/s²) of the sprung mass and ``tyre_force`` (N)."""
        body = self.second_order()
        A, Bf = body.free(), body.device_force()
        Bw = body.track_velocity(np.array([[0.0], [self.kt]]), np.zeros((2, 1)))
        sprung = np.concatenate([np.zeros(2), body.row(zs=1)])
        tyre = np.concatenate([self.kt * body.row(zu=1), np.zeros(2)])
        return Plant(
            A=A,
            Bw=Bw,
            Bf=Bf,
            Cz=np.vstack([sprung @ A, tyre]),
            Dzw=np.zeros((2, 1)),
            Dzf=np.vstack([sprung @ Bf, np.zeros((1, 1))]),
            Cd=np.concatenate([body.E[:, 0], np.zeros(2)])[None, :],
            Cv=np.concatenate([np.zeros(2), body.E[:, 0]])[None, :],
            delays=np.zeros(1),
            outputs=("acceleration", "tyre_force"),
            groups=("secondary",),
            density=4 * math.pi * self.V * self.kappa,
        )


@lru_cache(maxsize=256)
def _plant(vehicle: QuarterCar) -> Plant:
    return vehicle.road()
