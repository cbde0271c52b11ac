"""f = k·d + C x + D v + b·v̇,  ẋ = A x + B v,  ḋ = v: a device as matrices, spring and inerter split off.

The proper rest is realised in cascades: poles that lie close together form one group, groups stand in
parallel, and inside a group n/(q₁ q₂ …) = r₁/q₁ + r₂/(q₁ q₂) + … is a chain of sections of order one and two.
Poles stand on the diagonal, so spread over many decades or repeated they are as exact as floats allow; a
companion matrix would lose them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, arb, fmpq, fmpq_mat, fmpq_poly
from numpy.typing import ArrayLike, NDArray

from posreal.admittance import exact, roots
from posreal.admittance.rational import Rational, S
from posreal.errors import BadDevice

Matrix = NDArray[np.float64]

CLOSE = 0.2  # poles nearer than this, relative to their size, share a cascade
WORKING_PRECISION = 1024  # bits, for poles and residues before they are rounded to floats


@dataclass(frozen=True, eq=False)
class StateSpace:
    """A device in state space.

    Attributes
    ----------
    A, B, C, D : array, shapes (n, n), (n, 1), (1, n), (1, 1)
        The proper part.
    k, b : float
        Parallel spring (N/m) and inerter (kg).
    """

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    k: float = 0.0
    b: float = 0.0

    @property
    def order(self) -> int:
        """Number of states of the proper part."""
        return int(self.A.shape[0])

    def __call__(self, s: ArrayLike) -> Any:
        """Y(s) in floats, for a number or an array of any shape."""
        points = np.asarray(s, dtype=complex)
        shifted = points[..., None, None] * np.eye(self.order) - self.A
        inside = self.C @ np.linalg.solve(shifted, np.broadcast_to(self.B, (*shifted.shape[:-1], 1)))
        value = (inside + self.D)[..., 0, 0] + self.b * points
        if self.k:
            value = value + self.k / points
        return complex(value) if points.ndim == 0 else value

    def rational(self) -> Rational:
        """The admittance, exactly that of these floats."""
        return rational(self)


def rational(device: StateSpace) -> Rational:
    """The exact admittance of the matrices, by det(sI − A + BC) − det(sI − A) + D det(sI − A).

    Raises
    ------
    BadDevice
        If an entry is not finite or the shapes do not fit.
    """
    n = device.order
    if device.A.shape != (n, n) or device.B.shape != (n, 1) or device.C.shape != (1, n) or device.D.shape != (1, 1):
        raise BadDevice(
            f"State-space shapes {device.A.shape}, {device.B.shape}, {device.C.shape}, {device.D.shape} "
            "do not make a one-port; give A (n, n), B (n, 1), C (1, n) and D (1, 1)."
        )
    D, k, b = (exact.to_fmpq(value) for value in (device.D.item(), device.k, device.b))
    if n == 0:
        top, bottom = fmpq_poly([D]), fmpq_poly([1])
    else:
        A, B, C = exact.matrix(device.A), exact.matrix(device.B), exact.matrix(device.C)
        top, bottom = exact.transfer_function(A, B, C, D)
    proper = Rational(top, bottom)
    if b != 0:
        proper = proper | Rational([0, b])
    return proper | Rational([k], [0, 1]) if k != 0 else proper


def state_space(device: Rational) -> StateSpace:
    """A minimal, well-scaled state space of a device.

    Parameters
    ----------
    device : Rational
        At most simple poles at 0 and infinity.

    Raises
    ------
    BadDevice
        If there is a multiple pole at 0 or infinity, or the numbers exceed floats.
    """
    k, b = device.static_stiffness, device.inertance
    rest = device.without(Rational([k], [0, 1])).without(Rational([0, b]))
    D = rest.n[rest.d.degree()] / rest.d.leading_coefficient() if rest.n.degree() == rest.d.degree() else fmpq(0)
    strict = rest.n - D * rest.d
    blocks = []
    with roots.precision(WORKING_PRECISION):
        groups = _groups(rest.d)
        for factors, top in zip(groups, _split(strict, [_product(group) for group in groups]), strict=True):
            blocks.append(_cascade(factors, top))
    A, B, C = _parallel(blocks)
    matrices = StateSpace(A, B, C, np.array([[exact.to_float(D)]]), exact.to_float(k), exact.to_float(b))
    if not all(np.all(np.isfinite(part)) for part in (A, B, C, matrices.D, [matrices.k, matrices.b])):
        raise BadDevice("The device's numbers exceed what floats hold; scale it first.")
    return matrices


@dataclass(frozen=True)
class _Factor:
    """s − p, or (s − p)(s − p̄), rounded to rationals far finer than a float."""

    polynomial: fmpq_poly
    real: fmpq
    imag: fmpq
    size: fmpq


def _groups(d: fmpq_poly) -> list[list[_Factor]]:
    """The factors of d, those of nearby poles together."""
    found: list[tuple[complex, _Factor]] = []
    for root, power in roots.complex_roots(d):
        if root.imag < 0:
            continue
        found += [(complex(root), _factor(root))] * power
    groups: list[list[tuple[complex, _Factor]]] = []
    for p, factor in sorted(found, key=lambda pair: abs(pair[0])):
        near = [g for g in groups if any(abs(p - q) <= CLOSE * max(abs(p), abs(q)) for q, _ in g)]
        groups = [g for g in groups if g not in near] + [[*(pair for g in near for pair in g), (p, factor)]]
    return [[factor for _, factor in group] for group in groups]


def _factor(root: acb) -> _Factor:
    real = fmpq(0) if root.real.contains(0) else roots.midpoint(root.real)
    if root.imag == 0:
        return _Factor(S - real, real, fmpq(0), abs(real))
    imag = roots.midpoint(root.imag)
    size = roots.midpoint(arb(real * real + imag * imag).sqrt())
    return _Factor(S * S - 2 * real * S + (real * real + imag * imag), real, imag, size)


def _product(factors: list[_Factor]) -> fmpq_poly:
    total = fmpq_poly([1])
    for factor in factors:
        total *= factor.polynomial
    return total


def _split(top: fmpq_poly, bottoms: list[fmpq_poly]) -> list[fmpq_poly]:
    """Numerators t_i with top/∏ bottoms = Σ t_i/bottom_i: partial fractions by one exact linear system."""
    if len(bottoms) < 2:
        return [top] * len(bottoms)
    n = sum(bottom.degree() for bottom in bottoms)
    columns = []
    for i, bottom in enumerate(bottoms):
        others = fmpq_poly([1])
        for j, other in enumerate(bottoms):
            others = others * other if i != j else others
        columns += [others.left_shift(power) for power in range(bottom.degree())]
    system = fmpq_mat(n, n, [column[row] for row in range(n) for column in columns])
    solution = system.solve(fmpq_mat(n, 1, [top[row] for row in range(n)])).entries()
    parts, start = [], 0
    for bottom in bottoms:
        parts.append(fmpq_poly(solution[start : start + bottom.degree()]))
        start += bottom.degree()
    return parts


def _cascade(factors: list[_Factor], top: fmpq_poly) -> tuple[Matrix, Matrix, Matrix]:
    """top/(q₁ q₂ …) as a chain; each section is driven by what the one before passes on."""
    rests: list[fmpq_poly] = []
    for factor in reversed(factors):
        top, rest = divmod(top, factor.polynomial)
        rests.insert(0, rest)
    n = sum(factor.polynomial.degree() for factor in factors)
    A, B, C = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((1, n))
    at, gain, drive = 0, fmpq(1), -1
    for factor, rest in zip(factors, rests, strict=True):
        size = factor.size if factor.size != 0 else fmpq(1)
        if factor.polynomial.degree() == 1:  # x = size/(s − p) u
            A[at, at] = exact.to_float(factor.real)
            C[0, at] = exact.to_float(rest[0] / size / gain)
            last, through = at, size
        else:  # x₁ = size/q · u', x₂ = (s − σ)/q · u' with u' = size·u
            A[at, at] = A[at + 1, at + 1] = exact.to_float(factor.real)
            A[at, at + 1] = exact.to_float(size)
            A[at + 1, at] = exact.to_float(-factor.imag * factor.imag / size)
            C[0, at] = exact.to_float((rest[0] + rest[1] * factor.real) / size / size / gain)
            C[0, at + 1] = exact.to_float(rest[1] / size / gain)
            last, through = at, size * size
        entry = at + factor.polynomial.degree() - 1
        if drive < 0:
            B[entry, 0] = exact.to_float(size)
        else:
            A[entry, drive] = exact.to_float(size)
        drive, gain, at = last, gain * through, at + factor.polynomial.degree()
    scale = np.sqrt(np.max(np.abs(C)) / np.max(np.abs(B))) if np.any(C) else 1.0
    return A, B * scale, C / scale


def _parallel(blocks: list[tuple[Matrix, Matrix, Matrix]]) -> tuple[Matrix, Matrix, Matrix]:
    n = sum(len(A) for A, _, _ in blocks)
    A, B, C = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((1, n))
    at = 0
    for part, entry, out in blocks:
        here = slice(at, at + len(part))
        A[here, here], B[here], C[:, here] = part, entry, out
        at += len(part)
    return A, B, C
