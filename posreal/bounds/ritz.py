"""The other side: a passive device of high order, close to the best, that proves by its existence what can be reached.

    minimise J(σ) = ‖τ + Σ oᵢ 2σ/(1 − wᵢσ)‖   over σ = c₀ + Σ cₖ φₖ(s)/max|φₖ|,   |σ| < 1 on the axis

φₖ the Takenaka–Malmquist and Kautz functions of `interpolation_space` at some points, so that every |σ| < 1 is a
passive device of as many states [Ritz1909]. J is a sum over a fine grid of frequencies, the inequality a barrier −log(1
− |σ|²) on it, and Gauss–Newton steps end the search: seconds. Only a guide so far. σ is then drawn in a little, its
coefficients are rounded to short decimals, and of the exact rational function Y = c0 (1 + σ)/(1 − σ) that they give,
passivity is decided exactly (:mod:`positive_real`) and J measured by covariance, like that of any other device: between
the frequencies of a grid anything may happen, also a vehicle that is not stable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import fmpq, fmpq_poly
from scipy.linalg import cho_factor, cho_solve

from posreal.admittance import Rational
from posreal.admittance.exact import to_float, to_fmpq
from posreal.admittance.positive_real import require
from posreal.admittance.state_space import StateSpace
from posreal.bounds.figure import BoundedFigure
from posreal.bounds.interpolation_space import Point, Space, floats, width
from posreal.bounds.values import sampled_at
from posreal.bounds.windows import Windows
from posreal.errors import PosrealError

Array = np.ndarray

_GRID, _FINER = 24, 20  # frequencies for every dimension; and how many times that for a look between them
_BEYOND = 30.0  # how far the grid reaches above and below the points
_FIRST, _LAST, _GROWTH = 1e-1, 1e-5, 5.0  # weight of the barrier relative to J² and its factor from stage to stage
_STEPS = 30  # Gauss–Newton steps a stage, at most
_RIDGE = 1e-13  # relative to the Hessian's diagonal
_ROOM = (1e-5, 1e-4, 1e-3, 1e-2)  # how far below 1 the largest |σ| of the finer grid is drawn
_DIGITS = 12


@dataclass(frozen=True)
class Basis:
    """1 and the functions of some points, each at most about 1 on the axis.

    Attributes
    ----------
    points : tuple of Point
    sizes : (N,)
        max |φₖ| on the axis, nearly.
    """

    points: tuple[Point, ...]
    sizes: Array

    @classmethod
    def of(cls, points: Sequence[Point], omega: Array) -> Basis:
        """Scaled by the largest values on a grid."""
        bare = cls(tuple(points), np.ones(sum(map(width, points))))
        return cls(bare.points, np.abs(bare.values(omega)[1:]).max(axis=1))

    def values(self, omega: Array) -> Array:
        """(N + 1, len(omega)) complex."""
        s, rows, before = 1j * omega, [np.ones(len(omega), dtype=complex)], np.ones(len(omega), dtype=complex)
        for point in self.points:
            if isinstance(point, tuple):
                w, zeta = map(to_float, point)
                below = s**2 + 2 * zeta * w * s + w**2
                rows += [w * s / below * before, w**2 / below * before]
                before = before * (s**2 - 2 * zeta * w * s + w**2) / below
            else:
                a = to_float(point)
                rows.append(a / (s + a) * before)
                before = before * (s - a) / (s + a)
        return np.array(rows) / np.concatenate([[1.0], self.sizes])[:, None]

    def rational(self, c: Sequence[fmpq]) -> tuple[fmpq_poly, fmpq_poly]:
        """Numerator and denominator of Σ cₖ φₖ, exactly, with the sizes left out."""
        s = fmpq_poly([0, 1])
        factors = []
        for point in self.points:
            if isinstance(point, tuple):
                w, zeta = point
                factors.append((s * s + 2 * zeta * w * s + w * w, s * s - 2 * zeta * w * s + w * w))
            else:
                factors.append((s + point, s - point))
        # from the last function to the first: n/d of what a point and those after it give
        n, d, k = fmpq_poly([0]), fmpq_poly([1]), len(c)
        for point, (below, mirrored) in zip(reversed(self.points), reversed(factors), strict=True):
            k -= width(point)
            own = (c[k] * s + c[k + 1] * point[0]) * point[0] if isinstance(point, tuple) else c[k] * point * (s**0)
            n, d = own * d + mirrored * n, below * d
        return n + c[0] * d, d


@dataclass(frozen=True)
class HighOrder:
    """A passive device by the coefficients of its reflection; every number is the rational it is.

    Attributes
    ----------
    points : tuple of Point
        Poles of σ, mirrored: a or (ω, ζ).
    damper : fmpq
        c0, N s/m.
    coefficients : (N + 1,)
        Of 1 and of a/(s + a) B, or ω s/d(−s) B and ω²/d(−s) B for a pair.
    """

    points: tuple[Point, ...]
    damper: fmpq
    coefficients: tuple[float, ...]

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.coefficients) - 1

    def admittance(self) -> Rational:
        """Y = c0 (1 + σ)/(1 − σ), exactly."""
        n, d = Basis(self.points, np.ones(self.order)).rational([to_fmpq(value) for value in self.coefficients])
        return Rational((d + n) * self.damper, d - n)

    def state_space(self) -> StateSpace:
        """The same in floats: φ = (s + S)⁻¹ v with S + Sᵀ = v vᵀ, so that nothing is large."""
        space = Space(self.points)
        S, v = floats(space.S), np.array([float(value.mid()) for value in space.v])
        scale, row = np.empty(self.order), 0
        for point in self.points:
            size = width(point)
            scale[row : row + size] = to_float(point[0] if isinstance(point, tuple) else point) / v[row]
            row += size
        C, D, c0 = np.array(self.coefficients[1:]) * scale, self.coefficients[0], to_float(self.damper)
        A = -S + np.outer(v, C) / (1 - D)
        return StateSpace(
            A, v[:, None] / (1 - D), 2 * c0 / (1 - D) * C[None, :], np.array([[c0 * (1 + D) / (1 - D)]]), 0.0, 0.0
        )

    def measure(self, figure: BoundedFigure) -> float:
        """J with it, by covariance, after passivity was decided exactly.

        Raises
        ------
        NotPositiveReal, Infeasible
            If it is not passive, or the vehicle is not stable with it.
        """
        require(self.admittance())
        return figure.measure(figure.mounting.around(self.state_space()))


@dataclass(frozen=True)
class Attained:
    """A device and its J, in the unit of the figure."""

    device: HighOrder
    value: float


def best_device(figure: BoundedFigure, shapes: Sequence[Windows], size: int, c0: fmpq) -> Attained | None:
    """A device of order `size`, nearly the best with poles by the best of some windows; None where all fail."""
    found: list[tuple[float, tuple[Point, ...], Array]] = []
    for shape in shapes:
        points = shape.points(size)
        omega = _frequencies(points, _GRID)
        basis = Basis.of(points, omega)
        try:
            c, value = _minimise(figure, basis.values(omega), omega, to_float(c0))
        except np.linalg.LinAlgError:
            continue
        found.append((value, points, c / np.concatenate([[1.0], basis.sizes])))
    for _, points, c in sorted(found, key=lambda entry: entry[0]):
        bare = Basis(points, np.ones(size))
        largest = max(
            np.abs(c @ bare.values(part)).max() for part in np.array_split(_frequencies(points, _GRID * _FINER), 40)
        )
        for room in _ROOM:
            drawn = c * min(1.0, (1 - room) / largest)
            device = HighOrder(points, c0, tuple(float(f"{value:.{_DIGITS}g}") for value in drawn))
            try:
                return Attained(device, device.measure(figure))
            except PosrealError:
                continue
    return None


def _frequencies(points: Sequence[Point], each: int) -> Array:
    sizes = [to_float(p[0] if isinstance(p, tuple) else p) for p in points]
    return np.geomspace(min(sizes) / _BEYOND, max(sizes) * _BEYOND, each * sum(map(width, points)))


def _minimise(figure: BoundedFigure, basis: Array, omega: Array, c0: float) -> tuple[Array, float]:
    """The coefficients, from σ = 0, and J² on the grid."""
    rows, r = len(figure.rows), len(figure.loops)
    table = sampled_at(figure, 1j * omega, c0)
    steps = np.gradient(np.log(omega)) * omega  # trapezoidal in log ω
    weights = [to_float(figure.weights[figure.plant.outputs[row]]) for row in figure.rows]
    gain = np.sqrt(np.array(weights)[:, None] * figure.plant.density * steps)
    tau, o, w = table[:rows] * gain, table[rows : rows * (r + 1)].reshape(r, rows, -1) * gain, table[rows * (r + 1) :]

    def residual(c: Array) -> tuple[Array, Array, Array]:
        sigma = c @ basis
        a = 1 / (1 - w * sigma)
        z = tau + 2 * np.einsum("rog,rg->og", o, sigma * a)
        return sigma, z, 2 * np.einsum("rog,rg->og", o, a * a)

    spread = np.gradient(np.log(omega)) / np.log(omega[-1] / omega[0])
    c = np.zeros(len(basis))
    level = float(np.sum(np.abs(residual(c)[1]) ** 2))
    barrier = _FIRST
    while barrier > _LAST:
        for _ in range(_STEPS):
            sigma, z, slope = residual(c)
            room = 1 - np.abs(sigma) ** 2
            force = barrier * level * spread / room
            J = (slope[:, None, :] * basis[None]).transpose(0, 2, 1).reshape(-1, len(c))
            inward = (np.conj(sigma) * basis).real
            gradient = 2 * (J.conj().T @ z.ravel()).real + 2 * inward @ force
            hessian = 2 * (J.conj().T @ J).real + 4 * (inward * (force / room)) @ inward.T
            hessian += 2 * ((basis.conj() * force) @ basis.T).real
            hessian[np.diag_indices(len(c))] *= 1 + _RIDGE
            step = -np.asarray(cho_solve(cho_factor(hessian, lower=True), gradient))
            fall = float(-gradient @ step)

            def value(c: Array, barrier: float = barrier) -> float:
                sigma, z, _ = residual(c)
                room = 1 - np.abs(sigma) ** 2
                if np.any(room <= 0):
                    return math.inf
                return float(np.sum(np.abs(z) ** 2) - barrier * level * np.sum(spread * np.log(room)))

            now, length = value(c), 1.0
            while length > 1e-8 and not value(c + length * step) <= now - 0.1 * length * fall:
                length /= 2
            if length <= 1e-8:
                break
            c = c + length * step
            if fall < 1e-6 * now:
                break
        barrier /= _GROWTH
    return c, float(np.sum(np.abs(residual(c)[1]) ** 2))
