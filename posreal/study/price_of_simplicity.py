"""The price of simplicity: what devices of each order reach, beside what no device of any order can go below.

Synthesis minimises the problem's own metric. Where that ends at 20 Hz, a device may ring above for nothing, so the
side view's figure is minimised over the whole band instead, as the bound is. The plan view keeps its own problem, whose
damping constraint belongs to it; its devices are measured over the whole band, and the gap is then an upper limit.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from posreal.bounds.result import Bound
from posreal.errors import BadInput
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.synthesis.synthesise import synthesise
from posreal.vehicle import whole_band_twin


@dataclass(frozen=True)
class Reached:
    """One order.

    Attributes
    ----------
    order : int
    design : Design
    value : float
        The design's figure of the bound's kind, in its unit.
    gap_percent : float
        By how much the bound is below it.
    """

    order: int
    design: Design
    value: float
    gap_percent: float


def reached(
    bound: Bound,
    orders: Sequence[int] = (1, 2, 4, 8),
    *,
    starts: int | None = None,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> tuple[Reached, ...]:
    """Synthesise devices of some orders, each starting from the one before, and measure them against the bound.

    Raises
    ------
    BadInput
        If the bound is about a plant without a problem to synthesise for.
    BelowBound
        If a design is below the bound, which is an error in the program.
    """
    if bound.problem is None:
        raise BadInput("a bound on a bare figure has no problem to synthesise for; bound a problem")
    found: list[Reached] = []
    warm: list[Any] = []
    posed = _over_the_whole_band(bound.problem)
    for order in orders:
        design = synthesise(posed, order, starts=starts, seed=seed, warm=warm, progress=progress)
        warm.append(design.device)
        best = bound.beside(design).best
        assert best is not None
        found.append(Reached(order, design, best.value, 100 * (1 - bound.value / best.value)))
    return tuple(found)


def _over_the_whole_band(problem: Problem) -> Problem:
    """The problem with the bound's own figure, where a ride of the side view ends at 20 Hz; else as it is."""
    twin = whole_band_twin(problem.vehicle, problem.objective)
    return problem if twin is None else dataclasses.replace(problem, objective=twin)
