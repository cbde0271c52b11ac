"""Where a topology's values may lie, and where its starts do."""

from __future__ import annotations

import math

import numpy as np

from posreal.network.topologies import Form, letters
from posreal.specification.problem import Problem
from posreal.topology.batch import Array
from posreal.topology.found import SearchSettings
from posreal.topology.ground import Units

DECADES = 6.0  # to either side of the vehicle's units: how far free values may run
SPREAD = 2.0  # decades to either side: where random starts lie


class Box:
    """Bounds of a topology's unknowns, and where its starts lie; all logarithms."""

    def __init__(self, problem: Problem, scale: Units, form: Form, settings: SearchSettings) -> None:
        kinds = letters(form)
        unit = np.log(scale.units(kinds))
        free = math.log(10.0) * DECADES
        spread = math.log(10.0) * SPREAD
        lower, upper = unit - free, unit + free
        for i, kind in enumerate(kinds):
            if kind in settings.bounds:
                lower[i], upper[i] = np.log(settings.bounds[kind])
        ranges = list(problem.free.values())
        self.lower = np.concatenate([lower, np.log([r.lower for r in ranges])])
        self.upper = np.concatenate([upper, np.log([r.upper for r in ranges])])
        # starts lie about the units, or at whatever part of the bounds is nearest to that
        self.low = np.concatenate([np.clip(unit - spread, lower, upper), self.lower[len(kinds) :]])
        self.high = np.concatenate([np.clip(unit + spread, lower, upper), self.upper[len(kinds) :]])

    def random(self, count: int, rng: np.random.Generator) -> Array:
        """Random starts."""
        return self.low + rng.uniform(size=(count, len(self.low))) * (self.high - self.low)
