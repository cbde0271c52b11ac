"""What is asked of a topology's values, and what was found."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from posreal.network.topologies import Form, key

NO_GAIN = 1e-5  # relative gain over a limit below which a network is that limit


@dataclass(frozen=True)
class SearchSettings:
    """What, besides the problem and the topology, decides what is found.

    Attributes
    ----------
    starts : int
        Random starts from which a topology is optimised, the best of 64.
    seed : int
    bounds : mapping of "k", "c", "b" to (lower, upper)
        In N/m, N s/m and kg; a kind that is missing is free.
    """

    starts: int
    seed: int = 0
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """The best values found for a topology.

    Attributes
    ----------
    form : Form
    objective : float
        In the metric's unit; infinite if no values were found that meet the constraints.
    values : tuple of float
        Of the elements in the form's order, then of the problem's free vehicle parameters, SI units.
    agreed, starts : int
        How many of the random starts led to the same figure within 0.1 %.
    """

    form: Form
    objective: float
    values: tuple[float, ...]
    agreed: int
    starts: int

    @property
    def feasible(self) -> bool:
        """Whether there is a point at all."""
        return math.isfinite(self.objective)


def generator(seed: int, form: Form) -> np.random.Generator:
    """The random numbers of a topology: the same whichever process draws them, and in whatever order."""
    digest = hashlib.sha256(key(form).encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "little")])
