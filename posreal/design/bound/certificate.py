"""A lower bound on J over all positive-real devices, from one matrix and a few numbers, evaluated in balls.

What is claimed [Pick1916]. Let Y be positive real, of any order, springs, inerters and delays of its own included, and
let the vehicle be stable with it. Then J² ≥ c − bᵀ M⁻¹ b whenever M ≻ 0, where C, μ and c0 > 0, ω0 > 0 are *any* numbers
and c, b, M follow from them by the formulas below. No solver, no convexity, and no passivity of the vehicle is used.

1. *Coordinates.* ζ = (ω0 − s)/(ω0 + s) maps the open right half plane onto the open disc. The device's reflection
   σ = (Y − c0)/(Y + c0) is a Schur function there, |σ| ≤ 1, if and only if Y is positive real. For a loop i whose port
   has mobility Pᵢ and reflection wᵢ = (1 − c0 Pᵢ)/(1 + c0 Pᵢ), take xᵢ = 2σ/(1 − wᵢσ), which is 2/(1 + wᵢ) times
   (Y − c0)/c0 over 1 + Pᵢ Y … the device force beyond that of c0: z = (τ + Σ oᵢ xᵢ) w, affine in the xᵢ.
2. *Where causality enters.* The vehicle with Y is stable, so z is analytic in Re s > 0 with J² its squared H2 norm, and
   each xᵢ is analytic at ω0. With the isometry √(2ω0)/(1 + ζ) in τ and oᵢ, J² = Σₖ |(τ + Σ oᵢ xᵢ)ₖ|², a sum over Taylor
   coefficients, and leaving out k > L only makes it smaller. Taylor coefficients at an *interior* point: a function with
   Re Y ≥ 0 on the axis alone may have a pole inside, or −k/s or −b s on the boundary, and the same numbers would bound
   nothing. The expansions of τ, oᵢ, wᵢ need only exist at ω0, so an open vehicle that is unstable is no obstacle.
3. *Positive realness, truncated.* |σ| ≤ 1 in the disc ⇔ every I − ΣΣᵀ ⪰ 0 with Σ = T_σ, the lower-triangular Toeplitz
   matrix of the first L + 1 coefficients [Schur1917]. With Xᵢ = T_{xᵢ}, Wᵢ = T_{wᵢ}: T of aᵢ = 2 + wᵢxᵢ = 2/(1 − wᵢσ) is
   2I + XᵢWᵢ, and σaᵢ = xᵢ, so for all loops of the same device at once (block i, j)

       Φᵢⱼ(x) = (2I + XᵢWᵢ)(2I + XⱼWⱼ)ᵀ − XᵢXⱼᵀ,    Φ = [aᵢ]ᵢ (I − ΣΣᵀ) [aⱼ]ⱼᵀ ⪰ 0.

   One loop: 4I + 2XW + 2(XW)ᵀ − X A Xᵀ ⪰ 0, A = I − WWᵀ; A ⪰ 0 if and only if the port is passive to this order, and
   then the set is convex. Nothing here needs it to be.
4. *One device.* xⱼ − xᵢ = ½(wⱼ − wᵢ) xᵢ xⱼ, coefficient by coefficient: the loops hold the same σ.
5. *Weak duality.* For Z = C Cᵀ ⪰ 0 and any μ, every device has

       J² ≥ ‖τ + Σ Oᵢxᵢ‖² − ⟨Z, Φ(x)⟩ − Σ_{i<j} Σₖ μᵏᵢⱼ (2xⱼ − 2xᵢ − (wⱼ − wᵢ)xᵢxⱼ)ₖ = c + 2bᵀx + xᵀMx ≥ c − bᵀM⁻¹b

   as the second term is ≤ 0 and the third is 0. Comparing coefficients, with S_k the k-step shift,

       c    = ‖τ‖² − 4 Σᵢⱼ tr Zᵢⱼ
       bᵢₖ  = (Oᵢᵀτ)ₖ − 2 Σⱼ ⟨Zᵢⱼ, S_k Wᵢ⟩ + Σ_{j>i} μᵏᵢⱼ − Σ_{j<i} μᵏⱼᵢ
       Mᵢₖ,ⱼₗ = (OᵢᵀOⱼ)ₖₗ + ⟨Zᵢⱼ, S_k (I − WᵢWⱼᵀ) S_lᵀ⟩ + ½ Σₙ μⁿᵢⱼ (wⱼ − wᵢ)_{n−k−l}     (last term for i < j)

   The best Z and μ are those of the Lagrange dual: of a convex program for one passive port, of Shor's relaxation
   otherwise [Shor1987]. A loop with w = 0, o = 0 (the reflection σ itself, x = 2σ) may be added; it can only help.

The formula is evaluated with python-flint's balls: coefficients enclosed (:mod:`series`), Z from the stored C exactly,
M ≻ 0 by positive pivots of its LDLᵀ factors, whose last pivot, with b and c bordering M, is c − bᵀM⁻¹b.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from flint import arb, arb_mat, arb_series, ctx

from posreal.design.bound import series
from posreal.design.bound.ports import Expansion
from posreal.errors import PosrealError

Array = np.ndarray
Rows = list[list[arb]]


class NotProven(PosrealError):
    """A certificate does not show what it claims."""

    exit_code = 1


def proven(expansion: Expansion, C: Array, mu: Array) -> arb:
    """A ball that contains c − bᵀ M⁻¹ b; its lower end is a lower bound on J².

    Parameters
    ----------
    expansion : Expansion
        Ball coefficients of τ, oᵢ, wᵢ; loops that the certificate adds have o = 0 and w = 0.
    C : (r m, q)
        Z = C Cᵀ, loop by loop.
    mu : (r (r − 1)/2, m)
        Multipliers of the equalities, for the pairs of loops in lexicographic order.

    Raises
    ------
    NotProven
        If M is not certainly positive definite, so that the formula shows nothing.
    """
    m, r = ctx.cap, len(expansion.w)
    tau = [series.coefficients(t) for t in expansion.tau]
    O = [[series.coefficients(o) for o in loop] for loop in expansion.o]
    w = [series.coefficients(loop) for loop in expansion.w]
    factor = series.matrix(C)
    Z = factor * factor.transpose()
    blocks = [[_block(Z, i * m, j * m, m) for j in range(r)] for i in range(r)]
    W = [_toeplitz(loop) for loop in w]
    M = [[arb(0)] * (r * m) for _ in range(r * m)]
    b = [arb(0)] * (r * m)
    c = sum((t * t for row in tau for t in row), arb(0))
    for i in range(r):
        rows_i = [_toeplitz(o) for o in O[i]]
        along = blocks[i][0]
        for j in range(1, r):
            along = along + blocks[i][j]
        g = _diagonal_sums((along * W[i].transpose()).tolist())
        for k in range(m):
            b[i * m + k] = -2 * g[k]
        for o, t in zip(rows_i, tau, strict=True):
            pull = (o.transpose() * arb_mat(m, 1, t)).entries()
            for k in range(m):
                b[i * m + k] += pull[k]
        for j in range(i, r):
            c -= (4 if i == j else 8) * blocks[i][j].trace()
            part = _correlation(blocks[i][j], _minus_identity(W[i] * W[j].transpose()))
            for o, p in zip(rows_i, [_toeplitz(q) for q in O[j]], strict=True):
                add = (o.transpose() * p).tolist()
                part = [[u + v for u, v in zip(*pair, strict=True)] for pair in zip(part, add, strict=True)]
            _place(M, part, i * m, j * m)
    for row, (i, j) in enumerate(combinations(range(r), 2)):
        weight = [arb(float(value)) for value in mu[row]]
        difference = arb_series(w[j]) - arb_series(w[i])
        # Σₙ μₙ d_{n − a}: a product with the reversed multipliers, read backwards
        product = arb_series(weight[::-1]) * difference
        hankel = [product[m - 1 - a] / 2 for a in range(m)]
        for k in range(m):
            b[i * m + k] += weight[k]
            b[j * m + k] -= weight[k]
            for l in range(m - k):
                M[i * m + k][j * m + l] += hankel[k + l]
                M[j * m + l][i * m + k] = M[i * m + k][j * m + l]
    return _last_pivot([[*row, value] for row, value in zip(M, b, strict=True)], b, c)


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


def _block(Z: arb_mat, row: int, column: int, m: int) -> arb_mat:
    table = Z.tolist()
    return arb_mat(m, m, [table[row + a][column + b] for a in range(m) for b in range(m)])


def _toeplitz(x: Sequence[arb]) -> arb_mat:
    m = len(x)
    return arb_mat(m, m, [x[a - b] if a >= b else arb(0) for a in range(m) for b in range(m)])


def _minus_identity(product: arb_mat) -> arb_mat:
    """I − product."""
    m = product.nrows()
    return arb_mat(m, m, [arb(int(a == b)) - product[a, b] for a in range(m) for b in range(m)])


def _diagonal_sums(table: Rows) -> list[arb]:
    m = len(table)
    return [sum((table[b + k][b] for b in range(m - k)), arb(0)) for k in range(m)]


def _correlation(Z: arb_mat, R: arb_mat) -> Rows:
    """H[j][k] = ⟨Z, Sⱼ R Sₖᵀ⟩."""
    m = Z.nrows()
    table, across = Z.tolist(), R.tolist()
    H = []
    for j in range(m):
        left = arb_mat(m, m - j, [table[j + a][b] for b in range(m) for a in range(m - j)])
        right = arb_mat(m - j, m, [value for row in across[: m - j] for value in row])
        H.append(_diagonal_sums((left * right).tolist()))
    return H


def _place(M: Rows, part: Rows, row: int, column: int) -> None:
    """Write a block and its mirror image."""
    for k, line in enumerate(part):
        for l, value in enumerate(line):
            M[row + k][column + l] = value
            M[column + l][row + k] = value
