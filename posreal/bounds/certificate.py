"""A lower bound on J over all positive-real devices, from one matrix and a few numbers, evaluated in balls.

**What is shown.** Let Y be positive real, of any order, springs, inerters and delays included, and let the vehicle be
stable with it. Then J² ≥ c − bᵀ M⁻¹ b whenever M ≻ 0, where C, μ, the damper c0 > 0 and the points of the open right
half plane are *any* numbers, and c, b, M follow from them by the formulas below. No solver is believed, no convexity is
used, and the vehicle's port need not be passive.

1. *Coordinates.* The device's reflection σ = (Y − c0)/(Y + c0) is analytic with |σ| ≤ 1 in the open right half plane if
   and only if Y is positive real (or σ ≡ 1: a rigid strut, a limit). In loop i, with port mobility Pᵢ and reflection
   wᵢ = (1 − c0 Pᵢ)/(1 + c0 Pᵢ), put xᵢ = 2σ/(1 − wᵢσ). By algebra (:mod:`.figure`), z = (τ + Σ oᵢxᵢ) w: affine in xᵢ.
2. *Where causality enters.* The vehicle is stable with Y, so z ∈ H2 of the open right half plane, J is its norm, and
   the xᵢ have no pole there. The projection on the span K of `interpolation_space` is no longer than z: J² ≥ ‖τ + Σ
   Oᵢxᵢ‖², with τ, xᵢ ∈ Rᵐ columns and Oᵢ = oᵢ(S) matrices. All are values at *interior* points, where the device's
   passivity is an inequality between analytic functions. Re Y ≥ 0 on the axis says less: −k/s and −b·s satisfy it, and
   with them J has no lower bound but 0. τ, oᵢ and wᵢ need to exist at the points only: an open vehicle may be unstable.
   Where every port is passive, |wᵢσ| < 1 in the half plane, no device gives xᵢ a pole there, and the bound is one over
   all of them (J is infinite where the vehicle rings for ever).
3. *Positive realness on K.* ‖T_f‖ ≤ sup|f| gives I − ΣΣᵀ ⪰ 0 for Σ = σ(S), and by Nevanlinna and Pick that is all
   that can be said from values at the points [Pick1916, Sarason1967]. With Xᵢ = xᵢ(S), Wᵢ = wᵢ(S), and
   aᵢ = 2 + wᵢxᵢ = 2/(1 − wᵢσ), σaᵢ = xᵢ, hence for all loops of the same device at once (block i, j)

       Φᵢⱼ(x) = (2I + XᵢWᵢ)(2I + XⱼWⱼ)ᵀ − XᵢXⱼᵀ,    Φ = [aᵢ(S)]ᵢ (I − ΣΣᵀ) [aⱼ(S)]ⱼᵀ ⪰ 0.

   One loop: 4I + 2XW + 2(XW)ᵀ − X A Xᵀ ⪰ 0 with A = I − WWᵀ. A ⪰ 0 where the port is passive, |w| ≤ 1; the set of x
   is then convex. For the bound itself the sign of A does not matter.
4. *One device.* xⱼ − xᵢ = ½(wⱼ − wᵢ) xᵢ xⱼ: the loops hold the same σ.
5. *Weak duality.* For Z = C Cᵀ ⪰ 0 and any μ, every such device has

       J² ≥ ‖τ + Σ Oᵢxᵢ‖² − ⟨Z, Φ(x)⟩ − Σ_{i<j} μᵢⱼᵀ(2xⱼ − 2xᵢ − (wⱼ − wᵢ)xᵢxⱼ) = c + 2bᵀx + xᵀMx ≥ c − bᵀM⁻¹b:

   ⟨Z, Φ⟩ ≥ 0, the bracket is 0, and a positive definite form is at least its minimum. With Xᵢ = Σₖ xᵢₖFₖ,

       c       = ‖τ‖² − 4 Σᵢⱼ tr Zᵢⱼ
       bᵢₖ     = (Oᵢᵀτ)ₖ − 2 Σⱼ ⟨Zᵢⱼ, FₖWᵢ⟩ + Σ_{j>i} μᵢⱼₖ − Σ_{j<i} μⱼᵢₖ
       Mᵢₖ,ⱼₗ   = (OᵢᵀOⱼ)ₖₗ + ⟨Zᵢⱼ, Fₖ(I − WᵢWⱼᵀ)Fₗᵀ⟩ + ½ (μᵢⱼᵀ (wⱼ − wᵢ)(S) Fₖ)ₗ    (last term: i < j; mirrored)

   The best Z and μ are the dual's: of a convex program for one passive port, of Shor's relaxation otherwise [Shor1987].
   More points enlarge K, and the best bound never falls. On all vehicles tried the relaxation loses nothing: a σ with
   I − ΣΣᵀ ⪰ 0 reaches the proven value at the same points (`device_at_points`), and only more or better points prove
   more.
6. *Sums and peaks.* Where J is a sum of norms or an H∞ norm, ⟨u, τ + Σ Oᵢxᵢ⟩ ≤ J stands for ‖τ + Σ Oᵢxᵢ‖²: unit
   vectors u_o, one an output; or u_l = ⟨P Qᵀ, F_l⟩ with ‖P‖² + ‖Q‖² = 2, since ‖z‖_∞ ≥ ‖T_z‖ ≥ ⟨P Qᵀ, T_z⟩ (the
   bounded-real form of Pick's condition). For the squares in c, b and M come c = ⟨u, τ⟩, bᵢ = ½ Oᵢᵀu and 0, and
   c − bᵀM⁻¹b bounds J itself. Whatever is stored is brought to norm 1 in balls.

Constraints beside J are left out, so that the bound holds with them too. A damping ratio demanded of the closed vehicle
would make xᵢ analytic in more than the half plane, but says nothing about Re Y there, and Φ ⪰ 0 gains nothing by it.

The formula is evaluated with python-flint's balls: columns enclosed (`interpolation_space`), Z from the stored C
exactly, M ≻ 0 by the positive pivots of Rᵀ M R, with R any float matrix (an approximate inverse Cholesky factor, so
that balls stay small; positive pivots show that it is invertible). The last pivot, with Rᵀb and c as border, is c −
bᵀM⁻¹b.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from flint import arb, arb_mat
from scipy.linalg import cholesky, solve_triangular

from posreal.bounds.figure import SQUARES, SUM, Expansion
from posreal.bounds.interpolation_space import floats, identity, matrix
from posreal.errors import PosrealError

Array = np.ndarray
Rows = list[list[arb]]


class NotProven(PosrealError):
    """A certificate does not show what it claims."""

    exit_code = 1


def proven(expansion: Expansion, C: Array, mu: Array, functional: Array | None = None, combine: str = SQUARES) -> arb:
    """A ball that contains c − bᵀ M⁻¹ b; its lower end is a lower bound on J² for squares, on J otherwise.

    Parameters
    ----------
    expansion : Expansion
        Balls of τ, Oᵢ, Wᵢ.
    C : (r m, q)
        Z = C Cᵀ, loop by loop.
    mu : (r (r − 1)/2, m)
        Multipliers of the equalities, for the pairs of loops in lexicographic order.
    functional : array, optional
        u (outputs, m) for a sum, P over Q (2m, q) for a peak.
    combine : {"squares", "sum", "peak"}

    Raises
    ------
    NotProven
        If M is not certainly positive definite, so that the formula shows nothing.
    """
    space, W = expansion.space, expansion.W
    m, r = space.size, len(W)
    F = space.basis.transpose()  # row j: Fⱼ flattened
    tall = arb_mat(m * m, m, F.entries())  # (j, a) × b
    factor = matrix(C)
    table = (factor * factor.transpose()).tolist()
    cuts = [slice(i * m, (i + 1) * m) for i in range(r)]
    Z = [[arb_mat([row[across] for row in table[down]]) for across in cuts] for down in cuts]
    M = [[arb(0)] * (r * m) for _ in range(r * m)]
    b = [arb(0)] * (r * m)
    squares = combine == SQUARES
    u = expansion.tau if squares else _directions(F, m, functional, combine)
    c = sum(((t.transpose() * part)[0, 0] for t, part in zip(expansion.tau, u, strict=True)), arb(0))
    for i in range(r):
        along = Z[i][0]
        for j in range(1, r):
            along = along + Z[i][j]
        g = F * arb_mat(m * m, 1, (along * W[i].transpose()).entries())
        pull = g * arb(-2)
        for o, part in zip(expansion.O[i], u, strict=True):
            pull = pull + o.transpose() * part * (1 if squares else arb(0.5))
        b[i * m : (i + 1) * m] = pull.entries()
        for j in range(i, r):
            c -= (4 if i == j else 8) * Z[i][j].trace()
            left = arb_mat(m, m * m, (tall * (identity(m) - W[i] * W[j].transpose())).entries())  # row k: Fₖ A
            right = arb_mat(m, m * m, _times_each(Z[i][j], F, m))  # row l: Z F_l
            part = left * right.transpose()
            for o, p in zip(expansion.O[i], expansion.O[j], strict=True):
                part = part + o.transpose() * p if squares else part
            _place(M, part.tolist(), i * m, j * m)
    for weight, (i, j) in zip(mu, combinations(range(r), 2), strict=True):
        multiplier = matrix(weight[:, None])
        # Σₖ μₖ (T_d F_a)_kb = (F_aᵀ T_dᵀ μ)_b
        turned = (W[j] - W[i]).transpose() * multiplier
        hankel = [(arb_mat(m, m, F_a).transpose() * turned).entries() for F_a in F.tolist()]
        for k in range(m):
            b[i * m + k] += multiplier[k, 0]
            b[j * m + k] -= multiplier[k, 0]
            for l in range(m):
                M[i * m + k][j * m + l] += hankel[k][l] / 2
                M[j * m + l][i * m + k] = M[i * m + k][j * m + l]
    return _least(arb_mat(M), arb_mat(r * m, 1, b), c)


def _directions(F: arb_mat, m: int, functional: Array | None, combine: str) -> list[arb_mat]:
    """The u of sums and peaks, of norm 1 whatever numbers are given."""
    if functional is None or not np.any(functional):
        raise NotProven("this certificate proves nothing: it holds no functional for its sum or peak")
    if combine == SUM:
        rows = [matrix(row[:, None]) for row in functional]
        return [row / (row.transpose() * row)[0, 0].sqrt() for row in rows]
    P, Q = matrix(functional[:m]), matrix(functional[m:])
    size = sum((value * value for part in (P, Q) for value in part.entries()), arb(0)) / 2
    return [F * arb_mat(m * m, 1, (P * Q.transpose()).entries()) / size]


def _least(M: arb_mat, b: arb_mat, c: arb) -> arb:
    """c − bᵀ M⁻¹ b, with M ≻ 0 shown: in coordinates R of an approximate Cholesky factor, Rᵀ M R is nearly I."""
    n = M.nrows()
    try:
        R = matrix(solve_triangular(cholesky(floats(M), lower=True), np.eye(n), lower=True).T)
    except (np.linalg.LinAlgError, ValueError):
        R = identity(n)
    inner, turned = (R.transpose() * M * R).tolist(), (R.transpose() * b).entries()
    return _last_pivot([[*row, value] for row, value in zip(inner, turned, strict=True)], turned, c)


def _last_pivot(bordered: Rows, b: Sequence[arb], c: arb) -> arb:
    """c − bᵀ M⁻¹ b by symmetric elimination of [[M, b], [bᵀ, c]]; every pivot of M has to be certainly positive."""
    rows = [*bordered, [*b, c]]
    n = len(rows)
    for k in range(n - 1):
        pivot = rows[k][k]
        if not pivot > 0:
            raise NotProven(
                f"this certificate proves nothing: pivot {k + 1} of its quadratic form is {float(pivot.mid()):.3g}, "
                "and all have to be positive; it was changed, or belongs to another vehicle"
            )
        for i in range(k + 1, n):
            ratio = rows[k][i] / pivot
            for j in range(i, n):
                rows[i][j] -= ratio * rows[k][j]
    return rows[n - 1][n - 1]


def _times_each(Z: arb_mat, F: arb_mat, m: int) -> list[arb]:
    """Z Fⱼ for every j, flattened one after the other."""
    return [value for row in F.tolist() for value in (Z * arb_mat(m, m, row)).entries()]


def _place(M: Rows, part: Rows, row: int, column: int) -> None:
    """Write a block and its mirror image."""
    for k, line in enumerate(part):
        for l, value in enumerate(line):
            M[row + k][column + l] = value
            M[column + l][row + k] = value
