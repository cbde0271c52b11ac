"""What stands between a white process and a vehicle's input: a rational filter of one input and one output.

A filter of an output may stand here as well: for one output z = W(s) G(s) e^{−sτ} w, and W, G's scalar entries and the
delays commute. So what is weighted behind the vehicle is the same, figure by figure, as what is shaped before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False)
class ShapingFilter:
    """w = H(s)·(white process), as the state space (A, B, C, D) of a single-input single-output H."""

    A: Real
    B: Real
    C: Real
    D: Real

    def __call__(self, s: Complex) -> Complex:
        """H at complex `s`, shape preserved."""
        s = np.asarray(s, dtype=complex)
        n = len(self.A)
        x = np.linalg.solve(s[..., None, None] * np.eye(n) - self.A, np.broadcast_to(self.B, (*s.shape, n, 1)))
        return (self.C @ x)[..., 0, 0] + self.D[0, 0]

    @property
    def filter(self) -> ShapingFilter:
        """The part of an excitation that is a filter: this is all of it."""
        return self

    @property
    def rational(self) -> ShapingFilter:
        """A filter that has the density, or comes near it: this has it."""
        return self

    def then(self, after: ShapingFilter) -> ShapingFilter:
        """The product of the two: what comes out of this one goes into `after`."""
        n, m = len(self.A), len(after.A)
        return ShapingFilter(
            np.block([[self.A, np.zeros((n, m))], [after.B @ self.C, after.A]]),
            np.vstack([self.B, after.B @ self.D]),
            np.hstack([after.D @ self.C, after.C]),
            after.D @ self.D,
        )


def section(numerator: Sequence[float], denominator: Sequence[float]) -> ShapingFilter:
    """(c₁ s + c₀)/(s + a₀) + d or (c₁ s + c₀)/(s² + a₁ s + a₀) + d in coordinates of a size.

    Parameters
    ----------
    numerator : (c₀, c₁, …, d)
        As many numbers as the denominator has, the last of them d: what is left of the filter at infinity.
    denominator : (a₀, …, 1)
        Ascending powers of s, degree 1 or 2.

    Returns
    -------
    ShapingFilter
        Whose transfer function is exactly that of the floats given: no coefficient is rounded on the way.
    """
    *strict, direct = map(float, numerator)
    *low, one = map(float, denominator)
    assert one == 1
    assert len(strict) == len(low) <= 2
    if len(low) == 1:
        return ShapingFilter(np.array([[-low[0]]]), np.ones((1, 1)), np.array([strict]), np.array([[direct]]))
    unit = 2.0 ** round(np.log2(max(abs(low[0]), 1e-300)) / 2)  # a power of two, by which nothing rounds
    A = np.array([[0.0, unit], [-low[0] / unit, -low[1]]])
    return ShapingFilter(A, np.array([[0.0], [1.0]]), np.array([[strict[0] / unit, strict[1]]]), np.array([[direct]]))


def cascade(filters: Sequence[ShapingFilter]) -> ShapingFilter:
    """Their product, the first before the others."""
    return reduce(ShapingFilter.then, filters)
