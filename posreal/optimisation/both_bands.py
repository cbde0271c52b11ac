"""A search for an objective that ends at 20 Hz: the easier question first.

A design may be no worse than the default suspension over all frequencies either (:attr:`.Problem.in_its_band`). Mostly
the best one in the objective's own band keeps that by itself, and is then the best of both; only where it does not, the
search is made again with that as a constraint.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from posreal.errors import Infeasible
from posreal.specification.design import Design
from posreal.specification.problem import Problem


def in_both_bands(problem: Problem, find: Callable[[Problem], Design]) -> Design:
    """What `find` finds for a problem.

    Raises
    ------
    Infeasible
        If `find` raises it, or finds nothing that is no worse than the default over all frequencies.
    """
    easier = problem.in_its_band
    design = find(easier)
    if easier is problem:
        return design
    design = of_both_bands(design)
    if design.feasible or not replace(design, problem=easier).feasible:
        return design
    try:
        return find(problem)
    except Infeasible as error:
        raise Infeasible(
            f"{error}; --band-only allows a design that is worse than the default suspension over all frequencies"
        ) from None


def of_both_bands(design: Design) -> Design:
    """A design found in the objective's own band, judged by the figure over all frequencies too."""
    return replace(design, problem=replace(design.problem, band_only=False))
