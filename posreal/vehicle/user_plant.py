"""A plant of the user's own, cut open where the device goes, with what stands beside and behind the device.

Its metrics are, for each output, ``rms_OUTPUT`` over all frequencies (delays exact), and ``gain_OUTPUT``, the H∞ norm,
where it is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from posreal.admittance import Rational
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle, Inertance, LargestGain, Metric, RootMeanSquare, StaticStiffness
from posreal.plant.plant import Plant


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
    """

    name: ClassVar[str] = "plant"

    shaken: Plant
    beside: Rational | None = None
    behind: Rational | None = None
    title: str = "plant"

    @cached_property
    def metrics(self) -> Mapping[str, Metric]:
        """Of every output; the static stiffness and the inertance of the port."""
        outputs = self.shaken.outputs
        return {
            **{f"rms_{output}": RootMeanSquare("load", output, "1") for output in outputs},
            "static_stiffness": StaticStiffness(),
            "inertance": Inertance(),
            **{f"gain_{output}": LargestGain("load", output) for output in outputs},
        }

    @property
    def headline(self) -> tuple[str, ...]:
        """Root mean squares and the static stiffness."""
        return (*(f"rms_{output}" for output in self.shaken.outputs), "static_stiffness")

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

    def plant(self, load: str) -> Plant:
        """The plant on its one load."""
        return self.shaken

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Every mode that an output sees decays."""
        closed.on("load").require_stable("the plant")
