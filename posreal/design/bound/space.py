"""Functions of s where a bound looks at them: on the span of finitely many poles, enclosed in balls.

Let S + Sᵀ = v vᵀ. The entries of Φ(s) = (sI + S)⁻¹ v are then orthonormal in H2 of the right half plane; their span K is
orthogonal to an invariant subspace of every multiplication, so that with T_f = P_K f|_K

    T_f = f(S),    T_f T_g = T_{fg},    ‖T_f‖ ≤ sup |f|,    (⟨Φₖ, f⟩)ₖ = f(S) v  for f in H2 [Takenaka1925, Sarason1967].

S is block lower triangular, S_jk = vⱼ vₖᵀ below its diagonal blocks, which are

    a real point a > 0           [a],                      v = √(2a)
    a pair λ, λ̄ of points        [[0, |λ|], [−|λ|, p]],    v = (0, √(2p)),    p = 2 Re λ

and the points, the eigenvalues of S, are where functions are evaluated. All points equal and real: T_f is the Toeplitz
matrix of Taylor coefficients at that point. The first point is real, so Φ₁ = √(2a)/(s + a) has no zero, a function is
held by its column f = f(S) e₁, and f(S) = Σ fⱼ Fⱼ with Fⱼ = uⱼ(S), uⱼ = Φⱼ/Φ₁. For a state space the columns obey
S ⊗ X − A X = e₁ B; a delay is the matrix exponential of −τS.

Every float that goes in is the rational number it is, every operation rounds outwards: the true columns of *these*
functions lie in the balls that come out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import arb, arb_mat, ctx, fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_fmpq
from posreal.errors import BadInput

Array = np.ndarray


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Balls of so many bits inside the block."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def matrix(entries: Array) -> arb_mat:
    """An array of floats, each the rational it is."""
    rows, columns = np.shape(entries)
    return arb_mat(rows, columns, [arb(float(value)) for value in np.ravel(entries)])


def floats(balls: arb_mat) -> Array:
    """Midpoints."""
    return np.array([float(ball.mid()) for ball in balls.entries()]).reshape(balls.nrows(), balls.ncols())


Point = fmpq | tuple[fmpq, fmpq]
"""A real point a, or a conjugate pair as (|λ|, 2 Re λ); rad/s."""


@dataclass(frozen=True)
class Space:
    """K for some points, at the precision in force when its parts are first used.

    Attributes
    ----------
    points : tuple of Point
        The first one real.
    """

    points: tuple[Point, ...]

    def __post_init__(self) -> None:
        good = bool(self.points) and not isinstance(self.points[0], tuple)
        for point in self.points:
            if isinstance(point, tuple):
                good &= point[0] > 0 and 0 < point[1] < 2 * point[0]
            else:
                good &= bool(point > 0)
        if not good:
            raise BadInput("the points of a bound are in the open right half plane, the first of them real")

    @cached_property
    def size(self) -> int:
        """m, the dimension of K."""
        return sum(2 if isinstance(point, tuple) else 1 for point in self.points)

    @cached_property
    def v(self) -> list[arb]:
        """v with S + Sᵀ = v vᵀ."""
        found: list[arb] = []
        for point in self.points:
            found += [arb(0), arb(2 * point[1]).sqrt()] if isinstance(point, tuple) else [arb(2 * point).sqrt()]
        return found

    @cached_property
    def S(self) -> arb_mat:
        """T_s."""
        m, v = self.size, self.v
        table = [[v[j] * v[k] if k < j else arb(0) for k in range(m)] for j in range(m)]
        at = 0
        for point in self.points:
            if isinstance(point, tuple):
                r, p = arb(point[0]), arb(point[1])
                table[at][at], table[at][at + 1] = arb(0), r
                table[at + 1][at], table[at + 1][at + 1] = -r, p
                at += 2
            else:
                table[at][at] = arb(point)
                at += 1
        return arb_mat(table)

    @cached_property
    def one(self) -> arb_mat:
        """The column of the function 1, e₁."""
        return arb_mat(self.size, 1, [1] + [0] * (self.size - 1))

    @cached_property
    def basis(self) -> arb_mat:
        """Every Fⱼ, flattened row by row, as the columns of an (m², m) matrix."""
        m, unit = self.size, identity(self.size)
        first = arb(self.points[0])
        passed = (self.S + unit * first) / (2 * first).sqrt()  # 1/Φ₁, times the all-pass factors so far
        columns: list[list[arb]] = []
        known: dict[Point, tuple[list[arb_mat], arb_mat]] = {}
        for point in self.points:
            if point not in known:
                known[point] = self._section(point)
            entries, all_pass = known[point]
            columns += [(passed * entry).entries() for entry in entries]
            passed = passed * all_pass
        return arb_mat(m, m * m, [value for column in columns for value in column]).transpose()

    def _section(self, point: Point) -> tuple[list[arb_mat], arb_mat]:
        """(s + block)⁻¹ v and the all-pass factor of one point, as functions of S."""
        S, unit = self.S, identity(self.size)
        if isinstance(point, tuple):
            r, p = arb(point[0]), arb(point[1])
            square = S * S + unit * (r * r)
            inverse = (square + S * p).inv()
            gain = (2 * p).sqrt()
            return [inverse * (-r * gain), S * inverse * gain], (square - S * p) * inverse
        a = arb(point)
        inverse = (S + unit * a).inv()
        return [inverse * (2 * a).sqrt()], (S - unit * a) * inverse

    def operators(self, columns: Sequence[arb_mat]) -> list[arb_mat]:
        """T_f of each column f."""
        m, n = self.size, len(columns)
        stacked = arb_mat(n, m, [value for column in columns for value in column.entries()]).transpose()
        flat = (self.basis * stacked).transpose().entries()
        return [arb_mat(m, m, flat[i * m * m : (i + 1) * m * m]) for i in range(n)]

    def times(self, f: arb_mat, g: arb_mat) -> arb_mat:
        """The column of a product."""
        return self.operators([f])[0] * g

    def over(self, f: arb_mat, g: arb_mat) -> arb_mat:
        """The column of f/g."""
        try:
            return self.operators([g])[0].solve(f)
        except ZeroDivisionError:
            raise BadInput("a function of the vehicle has a pole at one of the bound's points; choose others") from None

    def rational(self, function: Rational) -> arb_mat:
        """n(s)/d(s), exact coefficients."""
        return self.over(self._polynomial(function.n.coeffs()), self._polynomial(function.d.coeffs()))

    def _polynomial(self, p: Sequence[fmpq]) -> arb_mat:
        total = self.one * arb(0)
        for c in reversed(p):
            total = self.S * total + self.one * arb(c)
        return total

    def delay(self, seconds: float) -> arb_mat:
        """e^{−sτ}."""
        if not seconds:
            return self.one
        return (self.S * arb(-to_fmpq(seconds))).exp() * self.one

    def state_space(self, A: Array, B: Array, C: Array, D: Array) -> list[list[arb_mat]]:
        """D + C (sI − A)⁻¹ B, each entry as a column."""
        n, inputs = B.shape
        out, through, dynamics = matrix(C), matrix(D), matrix(A)
        drive, felt = matrix(B), arb_mat(n, inputs)  # felt = Σ vₖ Xₖ over what came before
        inverses: dict[Point, arb_mat] = {}
        rows: list[arb_mat] = []
        at = 0
        for point in self.points:
            if point not in inverses:
                inverses[point] = _shifted_inverse(dynamics, point)
            if isinstance(point, tuple):
                # −A X₁ + r X₂ = 0,  −r X₁ + (p − A) X₂ = −v felt
                r = arb(point[0])
                first = inverses[point] * felt * (r * self.v[at + 1])
                found = [first, dynamics * first / r]
            else:
                found = [inverses[point] * (felt * (-self.v[at]) + drive if at == 0 else felt * (-self.v[at]))]
            for x in found:
                felt = felt + x * self.v[at]
                rows.append(out * x + through if at == 0 else out * x)
                at += 1
        return [
            [arb_mat(self.size, 1, [row[i, j] for row in rows]) for j in range(inputs)] for i in range(len(C))
        ]

    @cached_property
    def measure(self) -> arb_mat:
        """The column of 1/Φ₁: f times it is f(S) v, the coefficients (⟨Φₖ, f⟩)ₖ of f in H2."""
        first = arb(self.points[0])
        return (self.S * self.one + self.one * first) / (2 * first).sqrt()


def identity(n: int) -> arb_mat:
    """I of size n."""
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def _shifted_inverse(A: arb_mat, point: Point) -> arb_mat:
    """(a − A)⁻¹, or (A² − pA + |λ|²)⁻¹ for a pair."""
    unit = identity(A.nrows())
    try:
        if isinstance(point, tuple):
            r, p = arb(point[0]), arb(point[1])
            return (A * A - A * p + unit * (r * r)).inv()
        return (unit * arb(point) - A).inv()
    except ZeroDivisionError:
        raise BadInput(f"the point {point} rad/s is a pole of the vehicle; choose another") from None
