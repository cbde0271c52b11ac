"""What a bound looks at, by its values at distinct points: the coordinates in which Pick's matrix is entry by entry.

Points s₁ … sₘ of the open right half plane, distinct and closed under conjugation, span with kₗ(s) = 1/(s + s̄ₗ) the
same K as the functions of `interpolation_space`, and ⟨f, kₗ⟩ = f(sₗ). With nₖ = √(2 Re sₖ),

    Kₖₗ = nₖ nₗ/(sₖ + s̄ₗ),    ‖P_K z‖² = ζ* K⁻¹ ζ,  ζₖ = nₖ z(sₖ),    K⁻¹ = D_ḡ K̄ D_g

the inverse of a matrix of Cauchy's, gₖ = Πⱼ (sₖ + s̄ⱼ)/Π_{j≠k} (sₖ − sⱼ)/nₖ² [Cauchy1841]. A multiplication is a
diagonal matrix here, so the products of `interpolation_space`'s triangular ones become products of entries. Points that
come close to each other make K ill conditioned, which costs digits and never truth; repeated ones need
`interpolation_space`.

The same lines evaluate floats (arrays of complex numbers, for the searches) and balls (arrays of acb, for proofs).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, fmpq

from posreal.admittance.exact import to_float, to_fmpq
from posreal.admittance.roots import value
from posreal.bounds.figure import SQUARES, BoundedFigure
from posreal.bounds.interpolation_space import Point, in_words, matrix
from posreal.errors import BadInput

Array = np.ndarray


@dataclass(frozen=True)
class Values:
    """τ, oᵢ and wᵢ of :mod:`.figure` at the points: complex floats, or acb balls in arrays of objects.

    Attributes
    ----------
    s : (m,)
        The points, a pair as two that follow each other, the upper first.
    n : (m,)
        √(2 Re s).
    tau : (outputs, m)
        n τ √(π S weight).
    o : (r, outputs, m)
        n oᵢ √(π S weight).
    w : (r, m)
    """

    s: Array
    n: Array
    tau: Array
    o: Array
    w: Array

    @property
    def size(self) -> int:
        """m, the dimension of K."""
        return len(self.s)

    @cached_property
    def mirror(self) -> Array:
        """Index of the conjugate of each point."""
        found, k = np.arange(self.size), 0
        while k < self.size:
            if (self.s[k].imag if isinstance(self.s[k], acb) else np.imag(self.s[k])) == 0:
                k += 1
                continue
            found[k], found[k + 1] = k + 1, k
            k += 2
        return found

    @cached_property
    def K(self) -> Array:
        """The Gram matrix of the normalised kernels."""
        return np.outer(self.n, self.n) / (self.s[:, None] + np.conjugate(self.s)[None, :])

    @cached_property
    def g(self) -> Array:
        """K⁻¹ = D_ḡ K̄ D_g."""
        m = self.size
        above, apart = self.s[:, None] + np.conjugate(self.s)[None, :], self.s[:, None] - self.s[None, :]
        apart[np.arange(m), np.arange(m)] = self.n**2  # which belongs below the product anyway
        return np.prod(above / apart, axis=1)


def distinct(points: Sequence[Point]) -> bool:
    """Whether the points are pairs of conjugate numbers and real ones, each there once: what the values need."""
    return len(set(points)) == len(points) and all(point[1] < 1 for point in points if isinstance(point, tuple))


def enclosed_values(figure: BoundedFigure, points: Sequence[Point], c0: fmpq) -> Values:
    """Balls at the precision in force.

    Raises
    ------
    BadInput
        If the points are not distinct, or one is a pole of the vehicle.
    """
    if not distinct(points) or not all(v > 0 for p in points for v in (p if isinstance(p, tuple) else (p,))):
        raise BadInput("values need distinct points of the open right half plane, pairs with damping ratios below 1")
    columns, s = [], []
    for point in points:
        if isinstance(point, tuple):
            omega, zeta = point
            at = acb(arb(omega * zeta), arb(omega) * arb(1 - zeta * zeta).sqrt())
        else:
            at = acb(arb(point))
        found = _at(figure, at, c0, point)
        both = isinstance(point, tuple)
        s += [at, at.conjugate()] if both else [at]
        columns += [found, [value.conjugate() for value in found]] if both else [found]
    table = np.array(columns, dtype=object).T
    return _values(figure, np.array(s, dtype=object), table)


def sampled_values(figure: BoundedFigure, points: Sequence[Point], c0: fmpq) -> Values:
    """Floats; all points in one go."""
    upper: list[complex] = []
    for point in points:
        omega, zeta = map(to_float, point) if isinstance(point, tuple) else (to_float(point), 1.0)
        upper.append(complex(omega * zeta, omega * (1 - zeta * zeta) ** 0.5))
    table = sampled_at(figure, np.array(upper), to_float(c0))
    pick = [k for k, at in enumerate(upper) for _ in range(2 if at.imag else 1)]
    lower = np.array([k > 0 and pick[k - 1] == j for k, j in enumerate(pick)])
    s = np.array(upper)[pick]
    return _values(figure, np.where(lower, s.conj(), s), np.where(lower, table[:, pick].conj(), table[:, pick]))


def sampled_at(figure: BoundedFigure, s: Array, c0: float) -> Array:
    """τ of every output, oᵢ of every loop and output, wᵢ of every loop, without any scaling, at complex floats."""
    plant, count = figure.plant, len(figure.rows)
    found = plant.responses_at(s, *figure.weights)
    around = figure.mounting
    driven = found.Tzw.reshape(count, -1)
    T = found.Tzf.reshape(count, len(s), -1)
    ports = [(found.Pvf[: len(s), p, p], found.Pvw[: len(s), p], list(T[:, :, p])) for p in figure.loops]
    beside = None if around.beside is None else np.asarray(around.beside(s))
    behind = None if around.behind is None else 1 / np.asarray(around.behind(s))
    return np.array(_loops(list(driven), ports, beside, behind, c0))


def _at(figure: BoundedFigure, s: acb, c0: fmpq, point: Point) -> list[acb]:
    """The same at one ball."""
    plant, rows, loops = figure.plant, figure.rows, figure.loops
    channels, count, n = plant.Bw.shape[1], len(rows), len(plant.A)
    unit = acb_mat(n, n, [s if i == j else acb(0) for i in range(n) for j in range(n)])
    try:
        x = (unit - acb_mat(matrix(plant.A))).solve(acb_mat(matrix(np.hstack([plant.Bw, plant.Bf[:, loops]]))))
    except ZeroDivisionError:
        raise BadInput(f"a point of the bound, {in_words([point])}, is a pole of the vehicle; choose another") from None
    out = (acb_mat(matrix(np.vstack([plant.Cz[rows], plant.Cv[loops]]))) * x).tolist()
    for i, row in enumerate(rows):
        direct = [*plant.Dzw[row], *plant.Dzf[row, loops]]
        out[i] = [entry + arb(float(more)) for entry, more in zip(out[i], direct, strict=True)]
    late = [(s * arb(-to_fmpq(float(seconds)))).exp() for seconds in plant.delays]
    if plant.shaping is not None:
        H = plant.shaping.rational
        h = len(H.A)
        inner = acb_mat(h, h, [s if i == j else acb(0) for i in range(h) for j in range(h)]) - acb_mat(matrix(H.A))
        shape = (acb_mat(matrix(H.C)) * inner.solve(acb_mat(matrix(H.B))))[0, 0] + arb(float(H.D[0, 0]))
        late = [shape * part for part in late]
    driven = [sum((late[c] * row[c] for c in range(channels)), acb(0)) for row in out]
    ports = [
        (-out[count + i][channels + i], driven[count + i], [out[r][channels + i] for r in range(count)])
        for i in range(len(loops))
    ]
    around = figure.mounting
    beside = None if around.beside is None else value(around.beside.n, s) / value(around.beside.d, s)
    behind = None if around.behind is None else value(around.behind.d, s) / value(around.behind.n, s)
    return _loops(driven[:count], ports, beside, behind, arb(c0))


def _loops(tau: list[Any], ports: list[tuple[Any, Any, list[Any]]], beside: Any, behind: Any, c0: Any) -> list[Any]:
    """τ, oᵢ, wᵢ from P, V, T of every port: the formulas of :mod:`.figure`, for arrays and balls alike."""
    o, w = [], []
    for mobility, velocity, felt in ports:
        P, V, T = mobility, velocity, felt
        if beside is not None:
            closed = 1 / (1 + beside * P)
            tau = [t + beside * closed * V * part for t, part in zip(tau, T, strict=True)]
            P, V, T = closed * P, closed * V, [closed * part for part in T]
        if behind is not None:
            P = P + behind
        h = 1 / (1 + c0 * P)
        tau = [t + c0 * h * V * part for t, part in zip(tau, T, strict=True)]
        o += [c0 * h * h * V * part for part in T]
        w.append(h * (1 - c0 * P))
    return [*tau, *o, *w]


def _values(figure: BoundedFigure, s: Array, table: Array) -> Values:
    """Scaled by n and the outputs' weights."""
    assert figure.combine == SQUARES
    count, r = len(figure.rows), len(figure.loops)
    weights = [figure.weights[figure.plant.outputs[row]] for row in figure.rows]
    if s.dtype == object:
        scale = arb.pi() * arb(float(figure.plant.density))
        gains = np.array([(scale * arb(weight)).sqrt() for weight in weights], dtype=object)
        n = np.array([(2 * at.real).sqrt() for at in s], dtype=object)
    else:
        gains = np.sqrt(np.pi * figure.plant.density * np.array([to_float(weight) for weight in weights]))
        n = np.sqrt(2 * s.real)
    scaled = gains[:, None] * n[None, :]
    o = table[count : count * (r + 1)].reshape(r, count, len(s))
    return Values(s, n, table[:count] * scaled, o * scaled[None], table[count * (r + 1) :])
