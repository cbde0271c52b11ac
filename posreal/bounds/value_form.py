"""The certificate of :mod:`certificate` by values at distinct points: the same inequality in O(m³) instead of O(m⁴).

At distinct points (`values`) every multiplication is diagonal, and Pick's condition for all loops of one device is

    Φ₍ᵢₖ₎₍ⱼₗ₎ = (aᵢₖ āⱼₗ − xᵢₖ x̄ⱼₗ) Kₖₗ ⪰ 0,    aᵢ = 2 + wᵢxᵢ.

With τ and oᵢ scaled as in :class:`Values`, Z ⪰ 0 Hermitian, R = Z ∘ K̄ entry by entry (K repeated for every pair of
loops), any μ, and sums over outputs understood, every positive-real device with which the vehicle is stable has

    J² ≥ ζ*K⁻¹ζ − ⟨Z, Φ⟩ − Re Σ_{i<j} Σₖ μ̄ₖ (2xⱼₖ − 2xᵢₖ − dₖ xᵢₖxⱼₖ) = c + 2 Re b*x + x*Mx ≥ c − b*M⁻¹b,   d = wⱼ − wᵢ,

    c   = τ*K⁻¹τ − 4·1ᵀR1
    bᵢ  = ōᵢ ∘ (K⁻¹τ) − 2 w̄ᵢ ∘ (R1)ᵢ + Σ_{j>i} μᵢⱼ − Σ_{j<i} μⱼᵢ
    Mᵢⱼ = ōᵢ ∘ K⁻¹ ∘ oⱼᵀ + Rᵢⱼ ∘ (1 − w̄ᵢwⱼᵀ) + the term of μ:  (Mᵢⱼ)_{k̄k} gains μ̄ₖdₖ/2, i < j, and its mirror

if M ≻ 0, k̄ being the place of s̄ₖ. Proof. ⟨Z, Φ⟩ = a*Ra − x*Rx ≥ 0 and the bracket vanishes, as one device has one σ;
expand, with xᵢₖxⱼₖ = x̄ᵢₖ̄ xⱼₖ because plant and device are real; a positive definite form is at least its minimum over
all of Cʳᵐ. ∎ What is used of the device: z ∈ H2, σ analytic with |σ| ≤ 1, and 1 − wᵢσ ≠ 0 at the points, which
stability gives. Neither a passive port, nor a rational Y, nor one without poles on the axis, nor a symmetric Z.

*The check*, in balls: τ, oᵢ, wᵢ by one solve a point; c, b, M by the formulas, from the stored floats. R_ a float
matrix, an approximate inverse of M's Cholesky factor: E = R_*M R_ − I with ‖E‖_F < 1 shows that R_ is invertible and
M ≻ 0, and

    b*M⁻¹b = −2 Re b*v − v*Mv + r*M⁻¹r,   r = b + Mv,   0 ≤ r*M⁻¹r ≤ ‖R_*r‖²/(1 − ‖E‖_F)

holds for any v; a float approximation of −M⁻¹b leaves next to nothing to the last term.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, fmpq
from scipy.linalg import cholesky, solve_triangular

from posreal.admittance.roots import precision
from posreal.bounds.certificate import NotProven
from posreal.bounds.figure import SQUARES, BoundedFigure
from posreal.bounds.interpolation_space import Point, width
from posreal.bounds.values import Values, distinct, enclosed_values
from posreal.errors import BadInput

Array = np.ndarray

_BITS = (128, 256, 512, 1024)
_FINE = 1e-12  # relative radius at which the balls are fine enough


@dataclass(frozen=True)
class ValueCertificate:
    """The numbers that prove a bound in the value form.

    Attributes
    ----------
    points : tuple of Point
        Distinct; a or (ω, ζ) with ζ < 1.
    damper : fmpq
        c0, N s/m.
    factor : (r m, p)
        Real. A pair's two rows p, q stand for p + iq and p − iq; Z = C C* of the complex rows.
    multipliers : (r (r − 1)/2, m)
        μ, in the same coordinates.
    functional : array
        Empty: mean squares only.
    """

    points: tuple[Point, ...]
    damper: fmpq
    factor: Array
    multipliers: Array
    functional: Array

    def lower_bound(self, figure: BoundedFigure) -> float:
        """J from below, rigorously: a float that is not above what the balls prove.

        Raises
        ------
        NotProven
            If the numbers prove nothing for this figure.
        """
        if figure.combine != SQUARES or not distinct(self.points):
            raise BadInput("the value form bounds mean squares, at distinct points")
        for bits in _BITS:
            with precision(bits):
                ball = self._proven(figure)
                if ball is not None and ball.rad() < _FINE * abs(ball.mid()):
                    low = ball.lower() if ball.lower() > 0 else arb(0)
                    return math.nextafter(float(low.sqrt().lower()), 0.0)
        if ball is None:
            raise NotProven("this certificate proves nothing: its quadratic form is not shown to be positive definite")
        return math.nextafter(float((ball.lower() if ball.lower() > 0 else arb(0)).sqrt().lower()), 0.0)

    def _proven(self, figure: BoundedFigure) -> arb | None:
        """A ball around a lower bound on J²; None where M ≻ 0 is not shown at the precision in force."""
        seen = enclosed_values(figure, self.points, self.damper)
        C = matrix_of(complex_rows(balls(self.factor), self.points, len(figure.loops)))
        mu = complex_rows(balls(self.multipliers).T, self.points, 1).T
        Z = array_of(C * C.conjugate().transpose())
        return least(*form(seen, Z, mu))


def form(seen: Values, Z: Array, mu: Array) -> tuple[Any, Array, Array]:
    """c, b (r m,) and M (r m, r m) of the module's formulas, in floats or balls as they come."""
    (r, m), conj = seen.w.shape, np.conjugate
    Kbar = conj(seen.K)
    pull = Kbar @ (seen.g * seen.tau).T  # (m, outputs)
    go = seen.g * seen.o
    c = (conj(seen.g * seen.tau).T * pull).sum()
    R = Z * np.tile(Kbar, (r, r))
    sums = R.sum(axis=1)
    c = c - 4 * sums.sum()
    w = seen.w.ravel()
    outer = sum(np.outer(conj(part), part) for part in np.swapaxes(go, 0, 1).reshape(-1, r * m))
    M = outer * np.tile(Kbar, (r, r)) + R * (1 - np.outer(conj(w), w))
    b = (conj(go) * pull.T).sum(axis=1).ravel() - 2 * conj(w) * sums
    k, bar = np.arange(m), seen.mirror
    for weight, (i, j) in zip(mu, combinations(range(r), 2), strict=True):
        b[i * m + k] = b[i * m + k] + weight
        b[j * m + k] = b[j * m + k] - weight
        half = conj(weight) * (seen.w[j] - seen.w[i]) / 2
        M[i * m + bar, j * m + k] = M[i * m + bar, j * m + k] + half
        M[j * m + k, i * m + bar] = M[j * m + k, i * m + bar] + conj(half)
    return c.real, b, M


def least(c: arb, b: Array, M: Array) -> arb | None:
    """A ball around a lower bound on c − b*M⁻¹b; None where M ≻ 0 is not shown."""
    middle = np.array([complex(entry) for entry in M.ravel()]).reshape(M.shape)
    try:
        root = solve_triangular(cholesky(middle, lower=True), np.eye(len(M)), lower=True).conj().T
    except (np.linalg.LinAlgError, ValueError):
        return None
    v = -root @ (root.conj().T @ np.array([complex(entry) for entry in b]))
    if not (np.all(np.isfinite(root)) and np.all(np.isfinite(v))):
        return None
    whole, R, at, pull = matrix_of(M), matrix_of(balls(root)), matrix_of(balls(v)[:, None]), matrix_of(b[:, None])
    turned = R.conjugate().transpose()
    near = turned * whole * R
    off = sum(
        (abs(entry - int(i == j)) ** 2 for i, row in enumerate(near.tolist()) for j, entry in enumerate(row)), arb(0)
    )
    off = off.sqrt()
    if not off < 1:
        return None
    felt = whole * at
    value = c + ((at.conjugate().transpose() * (pull * 2 + felt))[0, 0]).real
    left = sum((abs(entry) ** 2 for entry in (turned * (pull + felt)).entries()), arb(0)) / (1 - off)
    return value - left


def complex_rows(rows: Array, points: tuple[Point, ...], loops: int) -> Array:
    """Rows p, q of every pair turned into p + iq and p − iq, loop by loop."""
    i = acb(0, 1) if rows.dtype == object else 1j
    found, k = [], 0
    for _ in range(loops):
        for point in points:
            if width(point) == 2:
                found += [rows[k] + i * rows[k + 1], rows[k] - i * rows[k + 1]]
            else:
                found.append(rows[k] + i * 0)
            k += width(point)
    return np.array(found).reshape(rows.shape)


def real_form(Z: Array, points: tuple[Point, ...], loops: int) -> Array:
    """The real symmetric A of which Z = T A T*, T being `complex_rows`, for a conjugation symmetric Z in floats."""

    def back(rows: Array) -> Array:
        found, k = rows.astype(complex), 0
        for _ in range(loops):
            for point in points:
                if width(point) == 2:
                    found[k], found[k + 1] = (rows[k] + rows[k + 1]) / 2, (rows[k] - rows[k + 1]) / 2j
                k += width(point)
        return found

    A = back(back(Z).conj().T).real
    return np.asarray((A + A.T) / 2)


def real_rows(rows: Array, points: tuple[Point, ...]) -> Array:
    """`complex_rows` backwards for one loop, in floats."""
    found, k = rows.real.copy(), 0
    for point in points:
        if width(point) == 2:
            found[k + 1] = rows[k].imag
        k += width(point)
    return found


def balls(numbers: Array) -> Array:
    """Every float as the number it is."""
    flat = [acb(complex(value)) for value in np.ravel(numbers)]
    found = np.empty(len(flat), dtype=object)
    found[:] = flat
    return found.reshape(np.shape(numbers))


def matrix_of(entries: Array) -> acb_mat:
    """An array of balls as a matrix of flint's."""
    rows, columns = entries.shape
    return acb_mat(rows, columns, list(entries.ravel()))


def array_of(entries: acb_mat) -> Array:
    """And back."""
    found = np.empty(entries.nrows() * entries.ncols(), dtype=object)
    found[:] = entries.entries()
    return found.reshape(entries.nrows(), entries.ncols())
