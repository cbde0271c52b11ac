"""A plant of the user's own, cut open where the device goes, with what stands beside and behind the device.

Its metrics are, for each output, ``rms_OUTPUT`` over all frequencies (delays exact), and ``gain_OUTPUT``, the H∞ norm,
where it is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle, Inertance, LargestGain, Metric, RootMeanSquare, StaticStiffness
from posreal.plant import hinf_norm
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.weighting import Weighting

_COLUMNS = 5  # outputs that have a column where designs stand side by side
_LOOKS = 500  # frequencies at which the ports are looked at
EDGE = 1e-14  # of the fastest pole: a mode that slow is a port that is locked or left open
_GROWS = 1e-9  # of the ports' size: what rounding may make of a passive one


@dataclass(frozen=True, eq=False)
class UserPlant:
    """A plant with one device group, ``secondary``.

    Attributes
    ----------
    shaken : Plant
        On its load, ``load``.
    beside, behind : Rational or None
        What stands in parallel and in series with the device whatever it is.
    title : str
        For tables.
    units : mapping of output to str
        In which its numbers are; "1" where it is not said.
    terminals : (str, str)
        What the device stands between.
    """

    name: ClassVar[str] = "plant"
    compared: ClassVar[tuple[str, ...]] = ()
    random: ClassVar[str] = "load"
    body: ClassVar[FlexibleBody | None] = None
    direction: ClassVar[Direction | None] = None
    irregularity: ClassVar[Track | None] = None
    weighting: ClassVar[Weighting | None] = None
    weighted: ClassVar[Mapping[str, str]] = {}
    comfort: ClassVar[tuple[str, ...]] = ()
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}
    pade_band: ClassVar[float | None] = None

    shaken: Plant
    beside: Rational | None = None
    behind: Rational | None = None
    title: str = "plant"
    units: Mapping[str, str] = field(default_factory=dict)
    terminals: tuple[str, str] = ("+", "-")

    @cached_property
    def metrics(self) -> Mapping[str, Metric]:
        """Of every output; the static stiffness and the inertance of the port."""
        outputs = self.shaken.outputs
        return {
            **{f"rms_{output}": RootMeanSquare("load", output, self.units.get(output, "1")) for output in outputs},
            "static_stiffness": StaticStiffness(),
            "inertance": Inertance(),
            **{f"gain_{output}": LargestGain("load", output) for output in outputs},
        }

    @property
    def headline(self) -> tuple[str, ...]:
        """Root mean squares and the static stiffness."""
        return (*(f"rms_{output}" for output in self.shaken.outputs), "static_stiffness")

    @property
    def columns(self) -> tuple[str, ...]:
        """The first few root mean squares."""
        return self.headline[:-1][:_COLUMNS]

    @property
    def ride(self) -> str:
        """That of the first output."""
        return self.headline[0]

    @property
    def passive(self) -> bool:
        """Whether the open plant is stable and its ports are passive, on a grid of its own frequencies."""
        return self._passive

    @cached_property
    def _passive(self) -> bool:
        return ports_are_passive(self.shaken)

    @property
    def places(self) -> Mapping[str, Place]:
        """The one place."""
        around = Mounting(self.beside, self.behind)
        return {"secondary": Place(around, beside_strut=self.beside, terminals=self.terminals)}

    @property
    def V(self) -> float:
        """It has no speed."""
        return math.nan

    def at(self, speed: float) -> UserPlant:
        """It has no speed.

        Raises
        ------
        BadInput
        """
        raise BadInput(f"{self.title} is a plant of the user's own, which has no speed")

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The plant on its one load."""
        return self.shaken

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Every mode that an output sees decays."""
        closed.on("load").require_stable("the plant", share=EDGE)


def ports_are_passive(plant: Plant) -> bool:
    """Whether an open plant is stable and takes energy out of its ports, on a grid of its own frequencies."""
    if np.linalg.eigvals(plant.A).real.max() > _GROWS:
        return False
    P = plant.responses(hinf_norm.grid(plant, _LOOKS), plant.outputs[0]).Pvf
    return bool(np.linalg.eigvalsh(P + P.conj().transpose(0, 2, 1)).min() >= -_GROWS * np.abs(P).max())
