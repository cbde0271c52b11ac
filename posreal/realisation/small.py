"""The fewest elements up to six, whatever the procedures lead to: every topology fitted at once, the best made exact.

    min over x = log θ of  Σ |log Y_network(s) − log Y(s)|²      by Levenberg and Marquardt's method [Marquardt1963]

at points s on the bisector of the right half plane, where no resonance is sharp and Y never vanishes, yet which
determine Y. T and U of the catalogue's networks are sums of products, so all topologies and all starts are one array.
What fits is made as exact as the arithmetic by Gauss and Newton's method on the coefficients of T d − U n = 0, in
rational numbers: where the device's data are exact, so is the network.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly
from numpy.typing import NDArray

from posreal.admittance import Rational
from posreal.admittance.exact import to_float, to_fmpq, to_fraction
from posreal.errors import BadDevice, DoesNotApply, Unproven
from posreal.network import Network
from posreal.network.topologies import letters, network
from posreal.realisation import biquadratic
from posreal.realisation.catalogue import LARGEST, Catalogue, Entry, behaviour, catalogue
from posreal.realisation.multiprecision import Long, shortened
from posreal.realisation.proof import branch_residual, corners

Array = NDArray[np.float64]
Points = NDArray[np.complex128]

POINTS = 14  # on the bisector
STARTS = 24  # of every topology
WIDTHS = 0.4, 1.4  # of their spread about the device's own size, in nepers of a narrow device
ROUNDS = (3, 6), (7, 3), (20, 1)  # steps, and how many starts are left after them
KEPT, LAST = 12, 150  # and of all these so many, each of another topology
PROMISING = 0.1  # misfit |log Y_network/Y| from which it may still converge,
CLOSE = 1e-5  # and with which it is made exact
WORKING_PRECISION = 1e-12  # residual at which a network is the device where its data are not exact
NEWTON = 60  # steps
DAMPING = fmpq(1, 10**30)  # relative, for networks whose values the device does not determine
LONGEST = 3.0  # a step's largest entry: e³ is far enough in one go


@dataclass
class Few:
    """A search for few elements: it remembers the devices for which there was nothing.

    Attributes
    ----------
    arithmetic : Long
    progress : function of str
        Called with a line for each size of each device.
    """

    arithmetic: Long
    progress: Callable[[str], None]

    largest: ClassVar[int] = LARGEST

    def __post_init__(self) -> None:
        self._without: dict[Rational, int] = {}

    def __call__(self, y: Rational, at_most: int) -> Network | None:
        """A network of at most so many elements (of six, if that is fewer) that is the device, or None."""
        at_most = min(at_most, LARGEST)
        if y.degree < 2:  # which the preamble settles
            return None
        first = max(y.degree, self._without.get(y, 0) + 1)
        if y.degree == 2 and first <= at_most:  # which a closed form settles up to five
            closed = self._closed(y)
            if closed is not None:
                return closed if len(closed) <= at_most else None
            first = max(first, 6)
        for size in range(first, at_most + 1):
            self.progress(f"degree {y.degree}: networks of {size} elements")
            for entry, values in candidates(y, size):
                found = self._exactly(y, entry, values)
                if found is not None:
                    return found
            self._without[y] = size
        return None

    def _closed(self, y: Rational) -> Network | None:
        try:
            return biquadratic.fewest(y, self.arithmetic)
        except DoesNotApply:
            return None

    def _exactly(self, y: Rational, entry: Entry, values: Array) -> Network | None:
        """The network made exact, if it is the device."""
        exact = refined(y, entry, [to_fmpq(float(value)) for value in values], self.arithmetic.bits)
        if exact is None:
            return None
        topology = network(entry.form)
        found = topology.with_values(dict(zip(topology.names, map(to_fraction, exact), strict=True)))
        try:
            return found if branch_residual(found, y) <= WORKING_PRECISION else None
        except (BadDevice, Unproven, ArithmeticError):  # a value out of the range of elements
            return None


def candidates(y: Rational, size: int) -> Iterator[tuple[Entry, Array]]:
    """Topologies with values with which they come close to a device, the closest first."""
    sought = catalogue(size, y.degree, behaviour(y))
    if not sought.entries:
        return
    omega = np.geomspace(corners(y)[0] * 10, corners(y)[1] / 10, POINTS)
    centre = float(np.exp(np.mean(np.log(omega))))
    s = omega * np.exp(0.25j * np.pi)
    wanted: Points = np.asarray(y(s), dtype=complex)
    strength = float(np.exp(np.mean(np.log(np.abs(wanted)))))
    fit = _Fit(sought, s / centre, wanted / strength)
    rng = np.random.default_rng(size)
    widths = (1 + np.log(omega[-1] / omega[0]) / 12) * np.linspace(*WIDTHS, STARTS)[:, None]
    theta = rng.normal(0, widths, (len(sought.entries), STARTS, size))
    for steps, kept in ROUNDS:
        theta, cost = fit.descended(theta, steps)
        best = np.argsort(cost, axis=1)[:, :kept]
        theta, cost = np.take_along_axis(theta, best[:, :, None], axis=1), np.take_along_axis(cost, best, axis=1)
    order = [i for i in np.argsort(cost.min(axis=1))[:KEPT] if cost[i].min() < POINTS * PROMISING**2]
    if not order:
        return
    fit = _Fit(sought.only(order), s / centre, wanted / strength)
    theta, cost = fit.descended(theta[order], LAST)
    for i in np.argsort(cost[:, 0]):
        if cost[i, 0] < POINTS * CLOSE**2:
            entry = fit.catalogue.entries[i]
            powers = np.array(["kcb".index(kind) - 1 for kind in letters(entry.form)])
            yield entry, strength * np.exp(theta[i, 0]) * centre ** -powers.astype(float)


class _Fit:
    """All topologies of a catalogue against a device at points s."""

    def __init__(self, sought: Catalogue, s: Points, wanted: Points) -> None:
        self.catalogue, self._log = sought, np.log(wanted)
        self._exponents = [exponents.transpose(0, 2, 1) for exponents in sought.exponents]  # (F, n, M)
        self._powers = [
            there[:, :, None] * s ** powers[:, :, None]
            for there, powers in zip(sought.there, sought.powers, strict=True)
        ]  # (F, M, N)

    def _misfit(self, theta: Array) -> tuple[Points, Points]:
        """log Y_network/Y (F, R, N) and its slopes (F, R, n, N) in θ (F, R, n)."""
        logs, slopes = [], []
        for exponents, powers in zip(self._exponents, self._powers, strict=True):
            products = np.exp(theta @ exponents)
            total = products @ powers
            logs.append(np.log(total))
            slopes.append((products[:, :, None, :] * exponents[:, None]) @ powers[:, None] / total[:, :, None])
        return logs[0] - logs[1] - self._log, slopes[0] - slopes[1]

    def descended(self, theta: Array, steps: int) -> tuple[Array, Array]:
        """θ after so many steps, and Σ |misfit|² (F, R)."""
        with np.errstate(all="ignore"):
            r, slope = self._misfit(theta)
            cost, mu = _squared(r), np.full(theta.shape[:2], 0.01)
            for _ in range(steps):
                curvature = (slope.conj() @ slope.swapaxes(2, 3)).real
                gradient = (slope.conj() @ r[..., None]).real
                steep = np.einsum("frii->fri", curvature)
                damping = mu[..., None] * (steep + 1e-3 * steep.max(axis=-1, keepdims=True)) + 1e-14
                step = -np.linalg.solve(curvature + damping[..., None] * np.eye(theta.shape[2]), gradient)[..., 0]
                step *= np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1e-300))
                r_new, slope_new = self._misfit(theta + step)
                new = _squared(r_new)
                better = new < cost
                theta = np.where(better[..., None], theta + step, theta)
                r = np.where(better[..., None], r_new, r)
                slope = np.where(better[..., None, None], slope_new, slope)
                cost, mu = np.where(better, new, cost), np.where(better, mu / 5, np.minimum(mu * 4, 1e6))
        return theta, cost


def _squared(r: Points) -> Array:
    return np.sum(np.abs(r) ** 2, axis=-1)


def refined(y: Rational, entry: Entry, values: list[fmpq], bits: int) -> list[fmpq] | None:
    """Values with T d = U n as nearly as the data have it; None if they run away or miss working precision."""
    residual = fmpq(1)
    for _ in range(NEWTON):
        trees, forests = entry.polynomials(values)
        rows = [t * y.d - u * y.n for t, u in zip(trees, forests, strict=True)]
        size = _sizes(trees[0]) * _sizes(y.d) + _sizes(forests[0]) * _sizes(y.n)
        weights = [1 / size[k] if size[k] else fmpq(0) for k in range(size.degree() + 1)]
        scaled = [[shortened(row[k] * w, bits) for k, w in enumerate(weights)] for row in rows]
        before, residual = residual, max(abs(c) for c in scaled[0])
        if residual == 0 or residual < fmpq(1, 2) ** (bits - 64):
            return values
        if before / 2 < residual and to_float(residual) <= WORKING_PRECISION:
            return values  # the data end here
        step = _step(scaled[1:], scaled[0])
        if step is None or max(abs(c) for c in step) > fmpq(1, 2):
            return None
        values = [shortened(v * (1 + c), bits) for v, c in zip(values, step, strict=True)]
    return values if to_float(residual) <= WORKING_PRECISION else None


def _step(slopes: list[list[fmpq]], residual: list[fmpq]) -> list[fmpq] | None:
    """The relative changes −(JᵀJ + λ diag)⁻¹ Jᵀr."""
    n = len(slopes)
    J = fmpq_mat(n, len(residual), [c for row in slopes for c in row])
    normal = (J * J.transpose()).tolist()
    largest = max(normal[i][i] for i in range(n))
    damped = [normal[i][j] + (DAMPING * largest if i == j else 0) for i in range(n) for j in range(n)]
    right = J * fmpq_mat(len(residual), 1, residual)
    try:
        return [-c for c in fmpq_mat(n, n, damped).solve(right).entries()]
    except ZeroDivisionError:
        return None


def _sizes(p: fmpq_poly) -> fmpq_poly:
    return fmpq_poly([abs(c) for c in p.coeffs()])
