"""Comfort indices of a stationary random ride, without simulating it: from the density of the acceleration.

The r.m.s. over T = 5 s of an acceleration of variance σ² = ∫ S df and density S is, squared, about σ² χ²(ν)/ν with

    ν = 2 σ⁴ T/∫ S² df,     a95 = σ √(χ²₀.₉₅(ν)/ν),     N_MV = 6 a95

the 95th percentile and what it makes of mean comfort [EN12299]; one direction alone, so N_MV is the part of it. Ride
comfort after Sperling is Wz = (2 ∫ S B² df)^{1/6.67} from 0.5 to 30 Hz with S in (cm/s²)²/Hz [Sperling1956].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from scipy.special import gammaincinv

from posreal.metric.closed_vehicle import ClosedVehicle
from posreal.metric.measured import Measured

_TOP = 2 * math.pi * 1000.0  # rad/s, ten times where weightings end
_MEAN_COMFORT = ((1.5, "very comfortable"), (2.5, "comfortable"), (3.5, "medium"), (4.5, "uncomfortable"))
_WORST = "very uncomfortable"
_SPERLING = (
    (1.0, "not noticeable"),
    (2.0, "just noticeable"),
    (2.5, "clearly noticeable"),
    (3.0, "more pronounced but not unpleasant"),
    (3.25, "strong, irregular, but still tolerable"),
    (3.5, "very irregular"),
    (4.0, "extremely irregular, unpleasant"),
)
_HARMFUL = "extremely unpleasant; prolonged exposure harmful"


@dataclass(frozen=True)
class FiveSecondPercentile:
    """a95: what 95 of 100 r.m.s. values over five seconds stay below, of an output behind its weighting."""

    load: str
    output: str
    unit: str = "m/s^2"
    seconds: float = 5.0
    share: float = 0.95
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value."""
        plant = closed.on(self.load)
        plant.require_stable()
        sigma, spread = plant.rms(self.output), plant.squared_density(self.output, _TOP)
        freedom = sigma.value**4 * self.seconds / (math.pi * spread.value)  # ∫ S² df = 2π ∫ S² dω
        ratio = 2 * float(gammaincinv(freedom / 2, self.share)) / freedom
        said = f"of {self.seconds:g} s each, {freedom:.4g} degrees of freedom"
        return Measured(sigma.value * math.sqrt(ratio), self.unit, said, max(sigma.apart, spread.apart))

    def norm(self) -> None:
        """None: it is no system norm."""


@dataclass(frozen=True)
class MeanComfort:
    """The part of N_MV that one direction makes, 6 a95 of the worst of several places, and its class in words."""

    parts: tuple[tuple[str, FiveSecondPercentile], ...]
    unit: str = "1"
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value and its class."""
        found = [(closed.value(part), where) for where, part in self.parts]
        worst, where = max(found, key=lambda one: one[0].value)
        value = 6 * worst.value
        words = next((words for limit, words in _MEAN_COMFORT if value < limit), _WORST)
        return Measured(value, self.unit, f"{where}, {words}" if where else words, worst.apart)

    def norm(self) -> None:
        """None: it is no system norm."""


@dataclass(frozen=True)
class SperlingIndex:
    """Wz of an output that is already behind Sperling's weighting, and what passengers feel of it."""

    load: str
    output: str
    start: float = math.pi
    stop: float = 60 * math.pi
    unit: str = "1"
    better: Literal["less", "more"] = "less"

    def measure(self, closed: ClosedVehicle) -> Measured:
        """The value and its class."""
        plant = closed.on(self.load)
        plant.require_stable()
        rms = plant.band_rms(self.output, self.stop, start=self.start)
        value = (2 * (100 * rms.value) ** 2) ** (1 / 6.67)
        words = next((words for limit, words in _SPERLING if value < limit), _HARMFUL)
        return Measured(value, self.unit, words, rms.apart)

    def norm(self) -> None:
        """None: it is no system norm, though least where one is."""
