"""Linear objective, matrix inequalities and cones, all affine in the unknowns: straight into Clarabel.

    minimise f(y)   subject to   F_i(y) ⪰ 0,   ‖(v_j(y)₂, v_j(y)₃, …)‖ ≤ v_j(y)₁

Each f, F_i, v_j is a function that takes the unknowns by name; what it multiplies them with is found by evaluating it
at 0 and at the unit vectors of the unknowns that it depends on, all at once. No modelling layer stands between the
formula and the solver, so a step costs what the solver costs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

Real = np.ndarray
Unknowns = Mapping[str, Real]


@dataclass(frozen=True)
class Shape:
    """An unknown matrix: its shape and whether it is symmetric."""

    rows: int
    columns: int
    symmetric: bool = False

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return self.rows * (self.rows + 1) // 2 if self.symmetric else self.rows * self.columns

    def matrices(self, y: Real) -> Real:
        """The matrices of a batch (m, size) of vectors."""
        if not self.symmetric:
            return y.reshape(len(y), self.rows, self.columns)
        out = np.zeros((len(y), self.rows, self.rows))
        i, j = np.triu_indices(self.rows)
        out[:, i, j] = out[:, j, i] = y
        return out


@dataclass(frozen=True)
class Affine:
    """An affine function of the unknowns named in `of`, batched along the first axis.

    Its values are numbers (m,) for an objective, symmetric matrices (m, n, n) for F ⪰ 0, vectors (m, n) for a cone.
    """

    of: tuple[str, ...]
    function: Callable[[Unknowns], Real]

    def coefficients(self, shapes: Mapping[str, Shape]) -> tuple[Real, Real]:
        """Its value at 0, and what it adds at each unit vector of its unknowns."""
        own = {name: shapes[name] for name in self.of}
        size = sum(shape.size for shape in own.values())
        values = self.function(_split(own, np.vstack([np.zeros(size), np.eye(size)])))
        return values[0], values[1:] - values[0]


@dataclass(frozen=True)
class Program:
    """A semidefinite program of the module's formula; see :func:`minimise` for its parts."""

    shapes: Mapping[str, Shape]
    objective: Affine
    inequalities: Sequence[Affine]
    cones: Sequence[Affine] = ()


@dataclass(frozen=True)
class Solution:
    """What the solver returned, and how it called it; the unknowns are a proposal, never evidence."""

    unknowns: Unknowns | None
    status: str


def minimise(
    shapes: Mapping[str, Shape],
    objective: Affine,
    inequalities: Sequence[Affine],
    cones: Sequence[Affine] = (),
    *,
    iterations: int = 60,
) -> Solution:
    """Solve the semidefinite program of the module's formula.

    Parameters
    ----------
    shapes : mapping of name to Shape
    objective, inequalities, cones : Affine
        A number, symmetric matrices that must be ⪰ 0, and vectors whose first entry is no less than the norm of the
        others.
    iterations : int
        Of the interior-point method.
    """
    ends = np.cumsum([shape.size for shape in shapes.values()])
    place = {name: np.arange(end - shape.size, end) for (name, shape), end in zip(shapes.items(), ends, strict=True)}
    size = int(ends[-1])

    def across(part: Affine, slopes: Real) -> sparse.coo_matrix:
        """Slopes (own unknowns, m) as columns of the whole program."""
        columns = np.concatenate([place[name] for name in part.of])
        own, row = np.nonzero(slopes)
        return sparse.coo_matrix((slopes[own, row], (row, columns[own])), shape=(slopes.shape[1], size))

    rows, right, kinds = [], [], []
    for inequality in inequalities:
        F0, F = inequality.coefficients(shapes)
        rows.append(-across(inequality, _svec(F)))
        right.append(_svec(F0[None])[0])
        kinds.append(clarabel.PSDTriangleConeT(len(F0)))
    for cone in cones:
        v0, v = cone.coefficients(shapes)
        rows.append(-across(cone, v))
        right.append(v0)
        kinds.append(clarabel.SecondOrderConeT(len(v0)))
    _, slope = objective.coefficients(shapes)
    c = across(objective, slope[:, None]).toarray()[0]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = iterations
    settings.max_threads = 1
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((size, size)),
        c / max(float(np.abs(c).max()), 1e-300),
        sparse.vstack(rows, format="csc"),
        np.concatenate(right),
        kinds,
        settings,
    )
    solution = solver.solve()
    y = np.array(solution.x)
    found = bool(np.all(np.isfinite(y))) and "Infeasible" not in str(solution.status)  # y is then a certificate
    return Solution(
        {name: part[0] for name, part in _split(shapes, y[None, :]).items()} if found else None,
        str(solution.status),
    )


def in_cvxpy(program: Program) -> tuple[Any, dict[str, Any]]:
    """The program as a ``cvxpy.Problem`` and its variables by name, to be read, changed and solved by anyone.

    The same numbers as :func:`minimise` gives to the solver, in another hand.
    """
    import cvxpy as cp  # slow to import, and no search needs it

    variables = {
        name: cp.Variable((shape.rows, shape.columns), name=name, symmetric=shape.symmetric)
        for name, shape in program.shapes.items()
    }

    def stacked(part: Affine) -> Any:
        """The unknowns that a part depends on, as :meth:`Shape.matrices` takes them."""
        own = [(variables[name], program.shapes[name]) for name in part.of]
        each = [
            cp.hstack([v[i, j] for i, j in zip(*np.triu_indices(shape.rows), strict=True)])
            if shape.symmetric
            else cp.vec(v, order="C")
            for v, shape in own
        ]
        return cp.hstack(each)

    def expression(part: Affine) -> Any:
        """F(0) + Σ y F, flat."""
        base, slopes = part.coefficients(program.shapes)
        return np.ravel(base) + slopes.reshape(len(slopes), -1).T @ stacked(part)

    constraints = []
    for inequality in program.inequalities:
        n = len(inequality.coefficients(program.shapes)[0])
        F = cp.reshape(expression(inequality), (n, n), order="C")
        constraints.append((F + F.T) / 2 >> 0)
    for cone in program.cones:
        v = expression(cone)
        constraints.append(cp.SOC(v[0], v[1:]))
    return cp.Problem(cp.Minimize(cp.sum(expression(program.objective))), constraints), variables


def _split(shapes: Mapping[str, Shape], y: Real) -> dict[str, Real]:
    cuts = np.cumsum([shape.size for shape in shapes.values()])[:-1]
    parts = np.split(y, cuts, axis=1)
    return {name: shape.matrices(part) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


def _svec(F: Real) -> Real:
    """Upper triangle by columns, off-diagonal entries times √2: inner products are kept."""
    n = F.shape[-1]
    j, i = np.tril_indices(n)
    return np.asarray(F[:, i, j] * np.where(i == j, 1.0, math.sqrt(2.0)))
