"""Functions of s where a bound looks at them: on the span of a few damped exponentials, enclosed in balls.

For points a₁ … a_m > 0, rad/s, repetitions welcome, the Takenaka–Malmquist functions

    φₖ(s) = √(2aₖ)/(s + aₖ) ∏_{l<k} (s − a_l)/(s + a_l)

are orthonormal in H2 of the open right half plane [Takenaka1925]. Their span K is orthogonal to a subspace that every
multiplication maps into itself, so that with T_f = P_K f|_K [Sarason1967]

    T_f T_g = T_{fg},    ‖T_f‖ ≤ sup |f|,    T_f = f(S),    (⟨φₖ, f⟩)ₖ = f(S) v  for f in H2

where S = T_s is lower triangular with S + Sᵀ = v vᵀ:

    S_kk = aₖ,    S_jk = 2√(aⱼaₖ) for j > k,    vₖ = √(2aₖ).

The points, the eigenvalues of S, are where functions are evaluated. All equal to ω0: T_f is the Toeplitz matrix of the
Taylor coefficients of f in (s − ω0)/(s + ω0). A function is held by its column f(S) e₁, and T_f = Σ fⱼ Fⱼ with
Fⱼ = uⱼ(S), uⱼ = φⱼ/φ₁. For a state space the columns obey S ⊗ X − A X = e₁ B; a delay is the exponential of −τS.

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


def identity(n: int) -> arb_mat:
    """I of size n."""
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def floats(balls: arb_mat) -> Array:
    """Midpoints."""
    return np.array([float(ball.mid()) for ball in balls.entries()]).reshape(balls.nrows(), balls.ncols())


@dataclass(frozen=True)
class Space:
    """K for some points, at the precision in force when its parts are first used.

    Attributes
    ----------
    points : tuple of fmpq
        a₁ … a_m, rad/s.
    """

    points: tuple[fmpq, ...]

    def __post_init__(self) -> None:
        if not self.points or any(point <= 0 for point in self.points):
            raise BadInput("the points of a bound lie in the open right half plane: give frequencies above 0 rad/s")

    @property
    def size(self) -> int:
        """m, the dimension of K."""
        return len(self.points)

    @cached_property
    def v(self) -> list[arb]:
        """v with S + Sᵀ = v vᵀ."""
        return [arb(2 * point).sqrt() for point in self.points]

    @cached_property
    def S(self) -> arb_mat:
        """T_s."""
        v, a = self.v, [arb(point) for point in self.points]
        m = range(self.size)
        return arb_mat([[a[j] if j == k else v[j] * v[k] if k < j else arb(0) for k in m] for j in m])

    @cached_property
    def one(self) -> arb_mat:
        """The column of the function 1, e₁."""
        return arb_mat(self.size, 1, [1] + [0] * (self.size - 1))

    @cached_property
    def measure(self) -> arb_mat:
        """The column of 1/φ₁: f times it is f(S) v, the coefficients (⟨φₖ, f⟩)ₖ of f in H2."""
        return (self.S * self.one + self.one * arb(self.points[0])) / self.v[0]

    @cached_property
    def basis(self) -> arb_mat:
        """Every Fⱼ, flattened row by row, as the columns of an (m², m) matrix."""
        m, unit = self.size, identity(self.size)
        rows = [unit.entries()]
        current = unit
        steps: dict[tuple[fmpq, fmpq], arb_mat] = {}
        for a, b in zip(self.points[:-1], self.points[1:], strict=True):
            if (a, b) not in steps:  # φ_b/φ_a = √(b/a) (s − a)/(s + b)
                steps[a, b] = (self.S - unit * arb(a)) * (self.S + unit * arb(b)).inv() * (arb(b) / arb(a)).sqrt()
            current = current * steps[a, b]
            rows.append(current.entries())
        return arb_mat(m, m * m, [value for row in rows for value in row]).transpose()

    # --- functions, each as its column -----------------------------------------------------------------------

    def operators(self, columns: Sequence[arb_mat]) -> list[arb_mat]:
        """T_f of each column f."""
        m, n = self.size, len(columns)
        stacked = arb_mat(n, m, [value for column in columns for value in column.entries()]).transpose()
        flat = (self.basis * stacked).transpose().entries()
        return [arb_mat(m, m, flat[i * m * m : (i + 1) * m * m]) for i in range(n)]

    def operator(self, column: arb_mat) -> arb_mat:
        """T_f of one column."""
        return self.operators([column])[0]

    def over(self, f: arb_mat, g: arb_mat) -> arb_mat:
        """The column of f/g."""
        try:
            return self.operator(g).solve(f)
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
        return (self.S * arb(-to_fmpq(seconds))).exp() * self.one if seconds else self.one

    def state_space(self, A: Array, B: Array, C: Array, D: Array) -> list[list[arb_mat]]:
        """D + C (sI − A)⁻¹ B, each entry as a column.

        Raises
        ------
        BadInput
            If a point is an eigenvalue of A.
        """
        out, through, dynamics, unit = matrix(C), matrix(D), matrix(A), identity(len(A))
        inverses: dict[fmpq, arb_mat] = {}
        felt = arb_mat(len(A), B.shape[1])  # Σ vⱼ Xⱼ over the points before
        rows: list[arb_mat] = []
        for k, a in enumerate(self.points):
            # (aₖ − A) Xₖ = δ_{k1} B − vₖ Σ_{j<k} vⱼ Xⱼ
            if a not in inverses:
                try:
                    inverses[a] = (unit * arb(a) - dynamics).inv()
                except ZeroDivisionError:
                    raise BadInput(f"the point {a} rad/s is a pole of the vehicle; choose another") from None
            x = inverses[a] * (matrix(B) if k == 0 else felt * -self.v[k])
            felt = felt + x * self.v[k]
            rows.append(out * x + through if k == 0 else out * x)
        return [[arb_mat(self.size, 1, [row[i, j] for row in rows]) for j in range(B.shape[1])] for i in range(len(C))]
