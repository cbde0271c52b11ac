"""A problem with upper limits on further metrics: the best comfort for no more than so much deflection."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property

from posreal.specification.constraint import Constraint
from posreal.specification.problem import Problem


@dataclass(frozen=True)
class RestrictedProblem(Problem):
    """A problem in which some metrics may not exceed given values, in the metrics' own units."""

    limits: tuple[tuple[str, float], ...] = ()

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The problem's own constraints and the limits."""
        if self.reference is not None:
            return self.original.constraints
        own: tuple[Constraint, ...] = Problem.constraints.func(self)  # type: ignore[attr-defined]
        return own + tuple(Constraint(name, "<=", value, "the limit given") for name, value in self.limits)


def restricted(problem: Problem, limits: Mapping[str, float]) -> RestrictedProblem:
    """The problem with metrics limited from above, and what it was limited by before."""
    own = {field.name: getattr(problem, field.name) for field in fields(Problem)}
    already = problem.limits if isinstance(problem, RestrictedProblem) else ()
    return RestrictedProblem(**own, limits=(*already, *limits.items()))


def unrestricted(problem: Problem) -> Problem:
    """The problem without the limits, with its own constraints only."""
    if not isinstance(problem, RestrictedProblem):
        return problem
    return Problem(**{field.name: getattr(problem, field.name) for field in fields(Problem)})
