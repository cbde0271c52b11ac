"""A plant of the user's own, cut open where the device goes, with what stands beside and behind the device.

Its figures are, for each output, ``rms_OUTPUT`` over all frequencies (exact delays, see
:mod:`posreal.plant.figures`), and ``gain_OUTPUT``, the H∞ norm, where it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from posreal.admittance import Rational
from posreal.plant.figures import ClosedPlant
from posreal.plant.plant import Plant
from posreal.vehicle.metrics import Metric, metric


@dataclass(frozen=True, eq=False)
class UserPlant:
    """A plant with one device group, ``secondary``.

    Attributes
    ----------
    plant : Plant
    beside, behind : Rational or None
        What stands in parallel and in series with the device whatever it is.
    title : str
        For tables.
    """

    name: ClassVar[str] = "plant"

    plant: Plant
    beside: Rational | None = None
    behind: Rational | None = None
    title: str = "plant"


def user_metrics(own: UserPlant, port: Rational) -> dict[str, Metric]:
    """Root mean square of every output with the admittance `port` in place.

    Raises
    ------
    Infeasible
        If the closed plant is not stable.
    """
    loop = ClosedPlant(own.plant, {"secondary": port})
    loop.require_stable("the plant")
    found = {f"rms_{output}": metric(loop.rms(output), "1") for output in own.plant.outputs}
    return found | {"static_stiffness": Metric(float(port.static_stiffness), "N/m")}
