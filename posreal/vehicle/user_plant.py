"""A plant of the user's own, cut open where the device goes, with what stands beside and behind the device.

Its figures are, for each output, ``rms_OUTPUT`` over all frequencies (exact delays, see
:mod:`posreal.plant.h2_norm`), and ``gain_OUTPUT``, the H∞ norm, where it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.errors import Infeasible
from posreal.plant import h2_norm
from posreal.plant.plant import Plant, close
from posreal.vehicle.metrics import Metric

EDGE = 1e-14  # of the largest pole: a real part that rounding may have made


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
    loop = close(own.plant, {"secondary": state_space(port)})
    poles = loop.poles()
    growth, size = float(poles.real.max()), float(np.abs(poles).max())
    if abs(growth) <= EDGE * size:
        raise Infeasible(
            f"the plant is on the edge of stability with this device: beside a pole at {size:.3g} rad/s one has no "
            "damping; if the best device locks the port or leaves it open, add a limit or another output"
        )
    if growth >= 0:
        raise Infeasible(f"the plant is not stable with this device: a pole has real part {growth:.3g} 1/s")
    found = {f"rms_{output}": Metric(h2_norm.rms(loop, output), "1") for output in own.plant.outputs}
    return found | {"static_stiffness": Metric(float(port.static_stiffness), "N/m")}
