"""What tolerances do to a design: spreads, yields, shares of the variance, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from posreal.specification.design import Design
from posreal.specification.variation import Variation
from posreal.study.tolerance_text import text

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Spread:
    """One metric over all draws; None where the vehicle is not stable there.

    Attributes
    ----------
    nominal, p5, p50, p95 : float or None
    worst : float or None
        Of all draws and corners, the largest of a metric of which less is better and the other way round.
    unit : str
    worst_at : mapping of part to value
    intervals : mapping of "p5" and "p95" to (float, float)
        Between which draws the percentile of all vehicles lies with 95 % confidence; of the objective and of what is
        limited.
    """

    nominal: float
    p5: float | None
    p50: float | None
    p95: float | None
    worst: float | None
    unit: str
    worst_at: Mapping[str, float]
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Share:
    """How many of so many draws: the fraction, and its interval of 95 % confidence [ClopperPearson1934]."""

    count: int
    draws: int

    @property
    def fraction(self) -> float:
        """The share."""
        return self.count / self.draws

    @property
    def interval(self) -> tuple[float, float]:
        """Exact binomial interval."""
        from scipy.special import betaincinv

        k, n, tail = self.count, self.draws, (1 - CONFIDENCE) / 2
        low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, tail))
        return low, 1.0 if k == n else float(betaincinv(k + 1, n - k, 1 - tail))


@dataclass(frozen=True)
class Tolerance:
    """What tolerances do to a design.

    Attributes
    ----------
    variation : Variation
        The design and what varies in it.
    draws, seed : int
    spreads : mapping of metric to Spread
    yields : mapping of constraint to Share
        Of the vehicles that keep it; a vehicle that is not stable keeps none.
    kept : Share or None
        Of the vehicles that keep every constraint.
    stable : Share
    better : Share or None
        Of the vehicles whose objective is better than that of the default suspension as drawn.
    shares : mapping of metric to mapping of part to float
        Of the variance that is the part's alone; empty where draws are too few for a fit.
    effects : mapping of metric to mapping of part to float
        What the metric changes by, in its unit, from the nominal value to the greatest, to first order.
    corners : int
        That were looked at, of `of_corners`.
    apart : float
        The largest relative difference between a figure computed one way and confirmed.
    """

    variation: Variation
    draws: int
    seed: int
    spreads: Mapping[str, Spread]
    yields: Mapping[str, Share]
    kept: Share | None
    stable: Share
    better: Share | None
    shares: Mapping[str, Mapping[str, float]]
    effects: Mapping[str, Mapping[str, float]]
    corners: int
    of_corners: int
    apart: float

    @property
    def design(self) -> Design:
        """With the network whose values vary."""
        return self.variation.design

    def __str__(self) -> str:
        return text(self)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able: ``metrics``, ``yield``, and what stands beside them."""
        counted = {"all": self.kept, "stable": self.stable, "better_than_default": self.better}
        return {
            "metrics": {
                name: {key: getattr(one, key) for key in ("nominal", "p5", "p50", "p95", "worst", "unit")}
                | {"worst_at": dict(one.worst_at)}
                | {f"{key}_interval": list(ends) for key, ends in one.intervals.items()}
                for name, one in self.spreads.items()
            },
            "yield": {name: one.fraction for name, one in self.yields.items()},
            "yield_interval": {name: list(one.interval) for name, one in self.yields.items()},
            "share": {
                name: {"fraction": one.fraction, "interval": list(one.interval)}
                for name, one in counted.items()
                if one is not None
            },
            "variance": {name: dict(one) for name, one in self.shares.items()},
            "effect": {name: dict(one) for name, one in self.effects.items()},
            "parts": [
                {key: getattr(part, key) for key in ("name", "nominal", "tolerance", "unit", "element")}
                for part in self.variation.parts
            ],
            "device": self.design.to_dict()["device"],
            "draws": self.draws,
            "seed": self.seed,
            "corners": {"looked_at": self.corners, "of": self.of_corners},
            "apart": self.apart,
        }
