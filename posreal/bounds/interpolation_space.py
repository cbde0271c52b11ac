"""Functions of s where a bound looks at them: on the span of a few damped exponentials, enclosed in balls.

A point is a number a > 0, or a pair of natural frequency ω and damping ratio ζ that stands for the two roots of
d(s) = s² − 2ζωs + ω². In sequence, repetitions welcome, points give the Takenaka–Malmquist and Kautz functions

    √(2a)/(s + a) B(s),    and for a pair    2√(ζω) s/d(−s) B(s),  2ω√(ζω)/d(−s) B(s),

B being the product of (s − a)/(s + a) and d(s)/d(−s) over the points before. They are orthonormal in H2 of the open
right half plane [Takenaka1925, Kautz1954]. Their span K is orthogonal to a subspace that every multiplication maps into
itself, so that with T_f = P_K f|_K [Sarason1967]

    T_f T_g = T_{fg},    ‖T_f‖ ≤ sup |f|,    T_f = f(S),    (⟨φₖ, f⟩)ₖ = f(S) v  for f in H2

where S = T_s is block lower triangular with S + Sᵀ = v vᵀ. Its diagonal blocks and the parts of v beside them are

    a,  √(2a),    and for a pair    [[2ζω, ω], [−ω, 0]],  [2√(ζω), 0]ᵀ.

The points, the eigenvalues of S, are where functions are evaluated. All equal to ω0: T_f is the Toeplitz matrix of the
Taylor coefficients of f in (s − ω0)/(s + ω0). A function is held by its column f(S) e₁, and T_f = Σ fⱼ Fⱼ with
Fⱼ = uⱼ(S), uⱼ = φⱼ/φ₁; the column of 1/φ₁ is v. For a state space the columns obey S ⊗ X − A X = e₁ B; a delay is the
exponential of −τS.

Every float that goes in is the rational number it is, every operation rounds outwards: the true columns of *these*
functions lie in the balls that come out.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import arb, arb_mat, fmpq

from posreal.admittance import Rational
from posreal.admittance.exact import to_float, to_fmpq
from posreal.errors import BadInput

Array = np.ndarray
_MOST_NAMED = 6
Point = fmpq | tuple[fmpq, fmpq]
"""a, or (ω, ζ)."""


def width(point: Point) -> int:
    """How many functions a point adds to the span."""
    return 2 if isinstance(point, tuple) else 1


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
    points : tuple of Point
        a or (ω, ζ); frequencies in rad/s.
    """

    points: tuple[Point, ...]

    def __post_init__(self) -> None:
        values = [value for point in self.points for value in (point if isinstance(point, tuple) else (point,))]
        if not values or any(value <= 0 for value in values):
            raise BadInput(
                "the points of a bound lie in the open right half plane: give frequencies and damping ratios above 0"
            )

    @property
    def size(self) -> int:
        """m, the dimension of K."""
        return sum(width(point) for point in self.points)

    @cached_property
    def v(self) -> list[arb]:
        """v with S + Sᵀ = v vᵀ."""
        found: list[arb] = []
        for point in self.points:
            if isinstance(point, tuple):
                found += [arb(4 * point[0] * point[1]).sqrt(), arb(0)]
            else:
                found.append(arb(2 * point).sqrt())
        return found

    @cached_property
    def S(self) -> arb_mat:
        """T_s."""
        v, m = self.v, range(self.size)
        rows = [[v[j] * v[k] if k < j else arb(0) for k in m] for j in m]
        row = 0
        for point in self.points:
            if isinstance(point, tuple):
                omega, zeta = point
                rows[row][row], rows[row][row + 1] = arb(2 * zeta * omega), arb(omega)
                rows[row + 1][row] = arb(-omega)
            else:
                rows[row][row] = arb(point)
            row += width(point)
        return arb_mat(rows)

    @cached_property
    def one(self) -> arb_mat:
        """The column of the function 1, e₁."""
        return arb_mat(self.size, 1, [1] + [0] * (self.size - 1))

    @cached_property
    def measure(self) -> arb_mat:
        """The column of 1/φ₁: f times it is f(S) v, the coefficients (⟨φₖ, f⟩)ₖ of f in H2."""
        return arb_mat(self.size, 1, self.v)

    @cached_property
    def basis(self) -> arb_mat:
        """Every Fⱼ, flattened row by row, as the columns of an (m², m) matrix."""
        m = self.size
        shares = {point: self._shares(point) for point in set(self.points)}
        (first, *_), _ = shares[self.points[0]]
        before = first.inv()  # B/φ₁
        rows: list[arb] = []
        for point in self.points:
            functions, through = shares[point]
            for function in functions:
                rows += (before * function).entries()
            before = before * through
        return arb_mat(m, m * m, rows).transpose()

    def _shares(self, point: Point) -> tuple[list[arb_mat], arb_mat]:
        """A point's own functions (those with B = 1) and its factor of B, at S."""
        S, unit = self.S, identity(self.size)
        if not isinstance(point, tuple):
            inverse = (S + unit * arb(point)).inv()
            return [inverse * arb(2 * point).sqrt()], (S - unit * arb(point)) * inverse
        omega, zeta = point
        even, odd = S * S + unit * arb(omega * omega), S * arb(2 * zeta * omega)
        inverse, length = (even + odd).inv(), arb(4 * omega * zeta).sqrt()
        return [S * inverse * length, inverse * (length * arb(omega))], (even - odd) * inverse

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
        inverses: dict[Point, arb_mat] = {}
        felt = arb_mat(len(A), B.shape[1])  # Σ vⱼ Xⱼ over the points before
        rows: list[arb_mat] = []
        for point in self.points:
            k = len(rows)
            pull = felt * -self.v[k] if rows else matrix(B)
            if point not in inverses:
                inverses[point] = _inverse(dynamics, unit, point)
            if isinstance(point, tuple):
                # (2ζω − A) X + ω X' = pull,  −ω X − A X' = 0
                omega, zeta = arb(point[0]), arb(point[1])
                x = inverses[point] * (dynamics * -pull)
                other = (pull + dynamics * x) / omega - x * (2 * zeta)
            else:
                x = inverses[point] * pull  # (a − A) X = pull
            felt = felt + x * self.v[k]
            rows.append(out * x if k else out * x + through)
            if isinstance(point, tuple):
                rows.append(out * other)
        return [[arb_mat(self.size, 1, [row[i, j] for row in rows]) for j in range(B.shape[1])] for i in range(len(C))]


def _inverse(A: arb_mat, unit: arb_mat, point: Point) -> arb_mat:
    """(a − A)⁻¹, or d(A)⁻¹ for a pair."""
    try:
        if isinstance(point, tuple):
            omega, zeta = point
            return (A * A - A * arb(2 * zeta * omega) + unit * arb(omega * omega)).inv()
        return (unit * arb(point) - A).inv()
    except ZeroDivisionError:
        raise BadInput(f"a point of the bound, {in_words([point])}, is a pole of the vehicle; choose another") from None


def in_words(points: Iterable[Point]) -> str:
    """The distinct points in words, from low to high, or between where they lie if they are many."""
    found = {(to_float(p[0]), to_float(p[1])) if isinstance(p, tuple) else (to_float(p), 0.0) for p in points}
    if len(found) > _MOST_NAMED:
        return f"{len(found)} places from {min(found)[0]:.3g} to {max(found)[0]:.3g} rad/s"
    return " and ".join(f"{a:g} rad/s damped {zeta:g}" if zeta else f"{a:g} rad/s" for a, zeta in sorted(found))
