"""Designs that keep their constraints in every vehicle built within tolerances, beside those that do as drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from posreal.errors import Infeasible
from posreal.specification.design import Design
from posreal.study.prune import with_best_values
from posreal.study.tolerance import within
from posreal.study.tolerance_result import Share, Tolerance
from posreal.text_table import table

DRAWS = 200


@dataclass(frozen=True)
class RobustDesign:
    """A design that keeps its constraints at the corners of its tolerances, and what that is worth.

    Attributes
    ----------
    before : Tolerance
        Of the best design that keeps them as drawn: the same network or layout.
    after : Tolerance
        Of the design.
    """

    before: Tolerance
    after: Tolerance

    def __str__(self) -> str:
        problem = self.after.design.problem
        goal = self.before.spreads[problem.objective], self.after.spreads[problem.objective]
        rows = [[f"{problem.objective}, nominal [{goal[0].unit}]", *(f"{one.nominal:#.5g}" for one in goal)]]
        rows.append([f"{problem.objective}, 95 % of vehicles", *(_number(one.p95) for one in goal)])
        for name in self.after.yields:
            metric = name if name in self.after.spreads else name.split(" ", 1)[0]
            rows.append([f"{name}, worst", *(_number(one.spreads[metric].worst) for one in (self.before, self.after))])
            rows.append([f"{name}, kept by", *(_share(one.yields[name]) for one in (self.before, self.after))])
        draws, seed, said = self.after.draws, self.after.seed, str(problem.tolerances)
        corners = self.after.corners
        of = "every corner" if corners == self.after.of_corners else f"{corners} corners of {self.after.of_corners}"
        return "\n".join(
            [
                f"Robust within {said}; {draws} draws (seed {seed}) and {of} looked at:",
                table(["", "best as drawn", "robust"], rows, "lrr"),
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able: the tolerance studies of both."""
        return {"before": self.before.to_dict(), "after": self.after.to_dict()}


def _number(value: float | None) -> str:
    return "unstable" if value is None else f"{value:#.5g}"


def _share(one: Share) -> str:
    low, high = one.interval
    return f"{100 * one.fraction:.0f} % ({100 * low:.0f} … {100 * high:.0f} %)"


def beside(
    before: Design,
    after: Design,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[str], None] = lambda text: None,
) -> RobustDesign:
    """The spreads and yields of a design as drawn and of one that is robust, within the tolerances of the latter.

    Raises
    ------
    Infeasible
        If a corner that was looked at breaks a constraint after all.
    """
    tolerances = after.problem.tolerances
    assert tolerances is not None
    studies = [within(one, tolerances, draws=draws, seed=seed, jobs=jobs, progress=progress) for one in (before, after)]
    found = RobustDesign(*studies)
    for constraint in after.problem.constraints:
        if constraint.nominal:
            continue
        worst = found.after.spreads[constraint.metric].worst
        sign = 1 if constraint.sense == ">=" else -1
        if worst is None or sign * (worst - constraint.value) < -_MISSED * abs(constraint.value):
            raise Infeasible(f"{constraint} is violated within the tolerances: {_number(worst)}")
    return found


_MISSED = 1e-6  # of a limit: drawn values are rounded to six digits


def as_drawn(design: Design) -> Design:
    """The network of a robust design at the best values that keep the constraints as drawn.

    Raises
    ------
    Infeasible
        If no such values are found.
    """
    return _with_values(replace(design, problem=replace(design.problem, tolerances=None)))


def made_robust(design: Design) -> Design:
    """A network's design with the best values that keep the constraints at the corners of its problem's tolerances.

    Raises
    ------
    Infeasible
        If no such values are found.
    """
    return _with_values(design)


def _with_values(design: Design) -> Design:
    found = with_best_values(design)
    if found is None:
        within_them = " at the corners of the tolerances" if design.problem.tolerances else ""
        raise Infeasible(f"no values of {design.network} were found that keep the constraints{within_them}")
    return found
