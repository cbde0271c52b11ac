"""Linear objective, inequalities F(y) ⪰ 0 with F affine, and a ball: straight into Clarabel.

    minimise cᵀy + dᵀQd   subject to   F_i(y) ⪰ 0,   ‖d‖ ≤ radius,   d = some of the unknowns, less a centre

Each F_i is a function that takes the unknowns by name; what it multiplies them with is found by evaluating it at 0 and
at the unit vectors, all at once. No modelling layer stands between the formula and the solver, so a step costs what
the solver costs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

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
class Outcome:
    """What the solver returned, and how it called it; the unknowns are a proposal, never evidence."""

    unknowns: Unknowns | None
    status: str


@dataclass(frozen=True)
class Ball:
    """d = the unknowns named in `centre`, concatenated, less their values there: ‖d/size‖ ≤ radius, at the cost dᵀQd.

    The size of an entry is its value at the centre, 1 at least, so that one that wants to grow beyond all bounds grows
    by a factor a step, not by an amount.
    """

    centre: Unknowns
    radius: float
    Q: Real

    @property
    def sizes(self) -> Real:
        """One for each entry."""
        return np.maximum(1.0, np.abs(np.concatenate([np.ravel(part) for part in self.centre.values()])))


def minimise(
    shapes: Mapping[str, Shape],
    objective: Callable[[Unknowns], Real],
    inequalities: Sequence[Callable[[Unknowns], Real]],
    ball: Ball | None = None,
    *,
    iterations: int = 60,
) -> Outcome:
    """Solve the semidefinite program of the module's formula.

    Parameters
    ----------
    shapes : mapping of name to Shape
    objective, inequalities : functions of the unknowns (batched along the first axis)
        A number, and symmetric matrices that must be ⪰ 0; both affine.
    ball : Ball, optional
    iterations : int
        Of the interior-point method.
    """
    size = sum(shape.size for shape in shapes.values())
    probe = np.vstack([np.zeros(size), np.eye(size)])
    unknowns = _split(shapes, probe)
    rows, right, cones = [], [], []
    for inequality in inequalities:
        F = _svec(inequality(unknowns))
        rows.append(-(F[1:] - F[0]).T)
        right.append(F[0])
        cones.append(clarabel.PSDTriangleConeT(_order(F.shape[1])))
    value = objective(unknowns)
    c, quadratic = value[1:] - value[0], np.zeros((size, size))
    if ball is not None:
        d = np.hstack([unknowns[name].reshape(len(probe), -1) - centre.ravel() for name, centre in ball.centre.items()])
        inside = (d[1:] - d[0]).T
        rows.append(np.vstack([np.zeros((1, size)), -inside / ball.sizes[:, None]]))
        right.append(np.concatenate([[ball.radius], d[0] / ball.sizes]))
        cones.append(clarabel.SecondOrderConeT(len(inside) + 1))
        quadratic = 2 * inside.T @ ball.Q @ inside
        c = c + 2 * inside.T @ ball.Q @ d[0]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = iterations
    settings.max_threads = 1
    scale = max(float(np.abs(c).max()), 1e-300)
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(quadratic / scale)),
        c / scale,
        sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(right),
        cones,
        settings,
    )
    solution = solver.solve()
    y = np.array(solution.x)
    found = bool(np.all(np.isfinite(y))) and "Infeasible" not in str(solution.status)  # y is then a certificate
    return Outcome(
        {name: part[0] for name, part in _split(shapes, y[None, :]).items()} if found else None,
        str(solution.status),
    )


def _split(shapes: Mapping[str, Shape], y: Real) -> dict[str, Real]:
    cuts = np.cumsum([shape.size for shape in shapes.values()])[:-1]
    parts = np.split(y, cuts, axis=1)
    return {name: shape.matrices(part) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


def _svec(F: Real) -> Real:
    """Upper triangle by columns, off-diagonal entries times √2: inner products are kept."""
    n = F.shape[-1]
    j, i = np.tril_indices(n)
    return np.asarray(F[:, i, j] * np.where(i == j, 1.0, math.sqrt(2.0)))


def _order(size: int) -> int:
    return (math.isqrt(8 * size + 1) - 1) // 2
