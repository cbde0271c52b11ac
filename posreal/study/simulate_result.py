"""What a simulation gives, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from posreal.network import Network
from posreal.simulation.laws import ElementLaw
from posreal.specification.design import Design
from posreal.study.simulate_text import text

LEAST_GAIN = 0.01  # of the default's figure: of less it says nothing what share is kept


@dataclass(frozen=True)
class InTime:
    """One metric of a run.

    Attributes
    ----------
    exact : float
        Of the linear device, by the metric itself.
    linear, real : float
        Of the linear device and of the real one, on the same track or ramp.
    default : float or None
        Of the default suspension, there.
    error : float or None
        Standard error of real/linear, from the spread over the records; None of a peak.
    statistical : float or None
        With the friction statistically linearised, by the metric itself; None without friction, or with play or stops.
    unit : str
    """

    exact: float
    linear: float
    real: float
    default: float | None
    error: float | None
    statistical: float | None
    unit: str

    @property
    def kept(self) -> float | None:
        """Share of the gain over the default suspension that the real device keeps; None below a gain of 1 %."""
        if self.default is None or not self.linear < (1 - LEAST_GAIN) * self.default:
            return None
        return (self.default - self.real) / (self.default - self.linear)


@dataclass(frozen=True)
class InMotion:
    """What an element with a law did on the random track, the worst of all devices and records.

    Attributes
    ----------
    law : ElementLaw
    stuck : float
        Share of the time in which friction held it.
    stroke : float
        m, the largest elongation from where it began.
    velocity : float
        m/s, r.m.s.
    damper : float or None
        N s/m, its friction statistically linearised.
    """

    law: ElementLaw
    stuck: float
    stroke: float
    velocity: float
    damper: float | None


@dataclass(frozen=True)
class Simulation:
    """A device in time; see the module.

    Attributes
    ----------
    design : Design
    strut : Network
        What was simulated, the vehicle's own spring or bush in it.
    metrics : mapping of metric to InTime
    elements : mapping of element to InMotion
    force : (float, float)
        N, r.m.s. and peak of a real strut on the random track.
    records, duration, step, seed
        So many records of so many seconds, in steps (s).
    """

    design: Design
    strut: Network
    metrics: Mapping[str, InTime]
    elements: Mapping[str, InMotion]
    force: tuple[float, float]
    records: int
    duration: float
    step: float
    seed: int

    def __str__(self) -> str:
        return text(self)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "metrics": {name: {**vars(one), "kept": one.kept} for name, one in self.metrics.items()},
            "elements": {
                name: {
                    "friction": one.law.friction,
                    "backlash": one.law.backlash,
                    "stop": None if math.isinf(one.law.stop) else one.law.stop,
                    "stuck": one.stuck,
                    "stroke": one.stroke,
                    "velocity_rms": one.velocity,
                    "equivalent_damper": one.damper,
                }
                for name, one in self.elements.items()
            },
            "force": {"rms": self.force[0], "peak": self.force[1], "unit": "N"},
            "strut": str(self.strut),
            "device": self.design.to_dict()["device"],
            "records": self.records,
            "duration": self.duration,
            "step": self.step,
            "seed": self.seed,
        }
