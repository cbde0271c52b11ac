"""Side view of the passenger coach of the Manchester benchmarks, 6 degrees of freedom and 4 damper forces.

The same body and bogies as :mod:`.side_view`, on coil springs, with a stiffness in series with every damper:

    secondary, each side of a bogie      Ksz | (device + bush)
    primary, each axle box               Kpz | (Cpz + Kpz_end)

so that the force fᵢ of the two primary dampers of a wheelset is a state, ḟ = 2 Kpz_end (v − f/(2 Cpz)). A device stands
in the place of the secondary damper, one on each side: the two share the port of a bogie.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle, Metric
from posreal.plant.mounting import Copy, Mounting
from posreal.plant.plant import Plant
from posreal.plant.second_order import SecondOrder
from posreal.ranges import SECONDARY
from posreal.real_elements import RAIL
from posreal.vehicle.flexible_body import BodyMode, FlexibleBody, read_modes
from posreal.vehicle.parameters import parameter, validated
from posreal.vehicle.place import Place
from posreal.vehicle.side_view import SideView, on_load, seen_from_the_side, vertical_metrics
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.weighting import Weighting

_IWNICKI = "Iwnicki1998"


@dataclass(frozen=True)
class ManchesterCoach:
    """Parameters of the coach; the track and the speed are those of [Jiang2012]."""

    name: ClassVar[str] = "manchester"

    mv: float = parameter(32000.0, "kg", "body mass", source=_IWNICKI)
    mb: float = parameter(2615.0, "kg", "bogie mass", source=_IWNICKI)
    Iv: float = parameter(1.97e6, "kg m^2", "body pitch inertia", source=_IWNICKI)
    Ib: float = parameter(1476.0, "kg m^2", "bogie pitch inertia", source=_IWNICKI)
    lvx: float = parameter(9.5, "m", "semi distance of the bogie centres", source=_IWNICKI)
    lbx: float = parameter(1.28, "m", "semi wheelbase", source=_IWNICKI)
    Kpz: float = parameter(1.220e6, "N/m", "primary vertical stiffness of an axle box", source=_IWNICKI)
    Cpz: float = parameter(4e3, "N*s/m", "primary vertical damping of an axle box", source=_IWNICKI)
    Kpz_end: float = parameter(1e6, "N/m", "stiffness in series with a primary damper", source=_IWNICKI)
    Ksz: float = parameter(0.430e6, "N/m", "secondary vertical stiffness of a side", source=_IWNICKI)
    Csz: float = parameter(20e3, "N*s/m", "secondary vertical damping of a side", source=_IWNICKI)
    bush: float = parameter(6e6, "N/m", "stiffness in series with a secondary damper", source=_IWNICKI)
    g: float = parameter(9.8, "m/s^2", "gravity, the unit of %g", source="Jiang2012, Table 4")
    Av: float = parameter(2.5e-7, "m", "vertical track roughness", source="Jiang2012, Table 4")
    V: float = parameter(55.0, "m/s", "speed", source="Jiang2012, Table 4")
    body: FlexibleBody | None = None
    irregularity: Track | None = None
    weighting: Weighting | None = None
    cut_off: float | None = None  # Hz

    weighted: ClassVar[Mapping[str, str]] = SideView.weighted
    comfort: ClassVar[tuple[str, ...]] = SideView.comfort
    headline: ClassVar[tuple[str, ...]] = SideView.headline
    columns: ClassVar[tuple[str, ...]] = SideView.columns
    compared: ClassVar[tuple[str, ...]] = SideView.compared
    ride: ClassVar[str] = SideView.ride
    random: ClassVar[str] = SideView.random
    passive: ClassVar[bool] = True
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}
    pade_band: ClassVar[float | None] = SideView.pade_band
    tables: ClassVar[Mapping[str, tuple[str, Callable[[Any, str], Any]]]] = {"modes": ("body", read_modes)}
    direction: ClassVar[Direction | None] = SideView.direction

    def __post_init__(self) -> None:
        validated(self)

    @property
    def metrics(self) -> Mapping[str, Metric]:
        """Those of every side view."""
        return vertical_metrics(self.cut_off)

    @property
    def places(self) -> Mapping[str, Place]:
        """The secondary vertical suspension: a device behind its bush, beside the coil spring."""
        spring = Rational.spring(self.Ksz)
        return {
            "secondary": Place(
                Mounting(beside=spring, behind=Rational.spring(self.bush)),
                beside_strut=spring,
                roles={"bush": "bush"},
                terminals=("body", "bogie"),
                default=Rational.damper(self.Csz),
                has_default=True,
                default_label="default (k | (c + bush))",
                carried=self.mv / 4,
                copies=(Copy((0.5, 0.5), 2), Copy((0.5, -0.5), 2)),  # front and rear, on either side
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

    def at(self, speed: float) -> ManchesterCoach:
        """The same vehicle at another speed, m/s."""
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        return dataclasses.replace(self, V=float(speed))

    def track(self) -> Plant:
        """Plant on the track profile: the outputs of :meth:`.side_view.SideView.track`."""
        coach = self._on_springs()
        body, wheels = coach.second_order(), coach.wheels()
        sides = dataclasses.replace(
            body, C=coach.bending_damping(), E=math.sqrt(2) * body.E
        )  # two devices in each port
        A, Bw = self._with_damper_forces(sides, wheels)
        Bf = np.vstack([sides.device_force(), np.zeros((4, 2))])
        return seen_from_the_side(
            sides, (self.lvx, self.bending()), A, Bw, Bf, coach.wheel_delays, math.pi * self.Av * self.V
        )

    def bending(self) -> tuple[BodyMode, ...]:
        """The modes of the body; none where it is rigid."""
        return self._on_springs().bending()

    def _on_springs(self) -> SideView:
        """The side view of the same masses and springs."""
        same = ("mv", "mb", "Iv", "Ib", "lvx", "lbx", "Kpz", "V", "body")
        return SideView(**{name: getattr(self, name) for name in same})

    def _with_damper_forces(self, body: SecondOrder, wheels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A and Bw of x = (q̃, q̇, f): the dampers push the wheels apart from the bogies."""
        count = len(body.M)
        none, stiff = np.zeros((count, 4)), 2 * self.Kpz_end
        push = np.vstack([none, np.linalg.solve(body.M, wheels.T)])
        A = np.block(
            [[body.free(), push], [np.zeros((4, count)), -stiff * wheels, -self.Kpz_end / self.Cpz * np.eye(4)]]
        )
        Bw = np.vstack([body.track_velocity(2 * self.Kpz * wheels.T, 0 * wheels.T), stiff * np.eye(4)])
        return A, Bw


@lru_cache(maxsize=256)
def _plant(vehicle: ManchesterCoach, load: str) -> Plant:
    return on_load(vehicle, vehicle.track(), load)
