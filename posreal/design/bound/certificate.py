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
from flint import arb, arb_mat

from posreal.design.bound.ports import Expansion
from posreal.design.bound.space import identity, matrix
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
        Balls of τ, Oᵢ, Wᵢ.
    C : (r m, q)
        Z = C Cᵀ, loop by loop.
    mu : (r (r − 1)/2, m)
        Multipliers of the equalities, for the pairs of loops in lexicographic order.

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
    Z = [[arb_mat([row[j * m : (j + 1) * m] for row in table[i * m : (i + 1) * m]]) for j in range(r)] for i in range(r)]
    M = [[arb(0)] * (r * m) for _ in range(r * m)]
    b = [arb(0)] * (r * m)
    c = sum((t * t for column in expansion.tau for t in column.entries()), arb(0))
    for i in range(r):
        along = Z[i][0]
        for j in range(1, r):
            along = along + Z[i][j]
        g = F * arb_mat(m * m, 1, (along * W[i].transpose()).entries())
        pull = g * arb(-2)
        for o, t in zip(expansion.O[i], expansion.tau, strict=True):
            pull = pull + o.transpose() * t
        b[i * m : (i + 1) * m] = pull.entries()
        for j in range(i, r):
            c -= (4 if i == j else 8) * Z[i][j].trace()
            left = arb_mat(m, m * m, (tall * (identity(m) - W[i] * W[j].transpose())).entries())  # Fₖ A
            right = arb_mat(m, m * m, _times_each(Z[i][j], F, m))
            part = left * right.transpose()
            for o, p in zip(expansion.O[i], expansion.O[j], strict=True):
                part = part + o.transpose() * p
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


def _times_each(Z: arb_mat, F: arb_mat, m: int) -> list[arb]:
    """Z Fⱼ for every j, flattened one after the other."""
    return [value for row in F.tolist() for value in (Z * arb_mat(m, m, row)).entries()]


def _place(M: Rows, part: Rows, row: int, column: int) -> None:
    """Write a block and its mirror image."""
    for k, line in enumerate(part):
        for l, value in enumerate(line):
            M[row + k][column + l] = value
            M[column + l][row + k] = value
