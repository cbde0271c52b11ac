"""What the matrix inequalities are about, at a device: norms of the closed vehicle, and the damping of its poles.

A norm enters a semidefinite program as an upper bound on it that is affine in the device and in the norm's own X, made
from its inequality (:mod:`.lmi`) with the products XA and XB linearised at the current point. Bounds of that
kind may be minimised, limited, added up and compared, whichever norms they belong to: all that they share is the
device.

The plant's delays are Padé approximations and its band is the whole axis. The bound has the exact figure's value at
the current device, and an H2 bound its slope as well, so that an iteration comes to rest where the exact figure does
[AlexandrovLewis2001].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_continuous_lyapunov
from scipy.optimize import minimize_scalar

from posreal.admittance import PortHamiltonian
from posreal.numerics import sdp
from posreal.numerics.sdp import Affine, Shape, Unknowns
from posreal.optimisation.coordinates import resolvent
from posreal.optimisation.figure import PeakGain, PortFigure
from posreal.synthesis import lmi
from posreal.synthesis.generalised_plant import GeneralisedPlant, Loop

Real = np.ndarray

SEEN = 1e-7  # mean square of an output that sees every state, relative to z: X is conditioned like 1/SEEN
PEAKS = 4  # of a gain over frequency that may count
SMALL = 1e-10  # of trace X, beside γ: of all X that prove the largest gain, one that is not large


@dataclass(frozen=True)
class LinearisedNorm:
    """One norm of the closed vehicle: as the inequalities see it, and the exact figure that it is measured by.

    Attributes
    ----------
    plant : GeneralisedPlant
        w → z is what the norm is of.
    largest_gain : bool
        The H∞ norm; otherwise the H2 norm.
    figure : PortFigure or PeakGain
    """

    plant: GeneralisedPlant
    largest_gain: bool
    figure: PortFigure | PeakGain

    def at(self, device: PortHamiltonian, unknowns: Unknowns, name: str) -> NormBound:
        """The bound at a device whose entries are `unknowns`; `name` tells its own unknowns from other bounds'."""
        kind = HInfinityBound if self.largest_gain else H2Bound
        return kind(self, device, unknowns, name)

    def value(self, device: PortHamiltonian) -> float:
        """The exact figure."""
        return float(self.figure.values(device, {}).max())

    def slope(self, device: PortHamiltonian) -> dict[str, Real]:
        """Its derivative by A, B, C, D, k and b: dH = yᵀ dA x + yᵀ dB + dC x + dD + dk/s + s db."""
        figure = self.figure.tops(device, {}) if isinstance(self.figure, PeakGain) else self.figure
        form, s = device.state_space(), figure.s
        x, y = resolvent(form.A, form.B[:, 0], form.C[0], s) if form.order else (np.zeros((0, len(s))),) * 2
        Y, inner = figure.inside.ports(np.asarray(device(s)), {})
        z, dz = figure.port.closed(Y)
        _, a = figure.functional(z)
        g = figure.gain * figure.port.over_grid(a * dz["secondary"])[0] * inner
        parts = {"A": (y * g) @ x.T, "B": y @ g, "C": x @ g, "D": g.sum(), "k": (g / s).sum(), "b": (g * s).sum()}
        return {name: np.ravel(part.real) for name, part in parts.items()}


class NormBound(Protocol):
    """An upper bound on a norm near a device, affine in the unknowns under its own inequality and cones."""

    shapes: dict[str, Shape]
    inequality: Affine
    cones: list[Affine]
    of: tuple[str, ...]

    def __call__(self, u: Unknowns) -> Real:
        """The bound, one number for each of a batch of unknowns."""


@dataclass(frozen=True)
class LoopAt:
    """The closed loop as an affine function of the device's entries near one of them.

    It is affine in A, B, C, D and k; the current inerter is part of the plant, and a change db of it adds
    Bu db v̇ with v̇ = Cy (A x + B w) of the current loop. T takes the states to other coordinates.
    """

    plant: GeneralisedPlant
    b: float
    T: Real
    here: Loop

    @classmethod
    def of(cls, plant: GeneralisedPlant, unknowns: Unknowns) -> LoopAt:
        """At a device, in the plant's own coordinates."""
        b = float(np.sum(unknowns.get("b", 0.0)))
        plant = plant.with_inerter(b) if b else plant
        here = _closed(plant, unknowns)
        return cls(plant, b, np.eye(len(here.A)), here)

    def in_coordinates(self, T: Real) -> LoopAt:
        """The same with states T x."""
        return LoopAt(self.plant, self.b, T, _transformed(self.here, T))

    def __call__(self, u: Unknowns) -> Loop:
        """The loop with another device."""
        loop = _closed(self.plant, u)
        if "b" in u:
            p, more = len(self.plant.Cy), len(self.here.A) - len(self.plant.A)
            row = np.hstack([self.plant.Cy, np.zeros((p, more))]) @ np.linalg.inv(self.T)
            x, w = (u["b"] - self.b) * (row @ self.here.A @ self.T), (u["b"] - self.b) * (row @ self.here.B)
            Bu = np.vstack([self.plant.Bu, np.zeros((more, p))])
            Dzu = self.plant.Dzu
            loop = Loop(loop.A + Bu @ x, loop.B + Bu @ w, loop.C + Dzu @ x, loop.D + Dzu @ w)
        return _transformed(loop, self.T)


class H2Bound:
    """The H2 norm: trace BᵀXB over the H2 inequality, and to second order what linearising dropped.

    That is the form q(δ) = 2 trace (Y dA + B dBᵀ)ᵀ X₁(δ) + trace dBᵀX dB with A Y + Y Aᵀ + B Bᵀ = 0 and X₁ the first
    change of X in the step δ of the device. Its convex part stands in the bound, as q ≥ dᵀQd. Without it the iteration
    is steepest descent between inequalities and stalls; with it, it ends in a few Newton-like steps.
    """

    def __init__(self, norm: LinearisedNorm, device: PortHamiltonian, unknowns: Unknowns, name: str) -> None:
        loop = LoopAt.of(norm.plant, unknowns)
        self._loop = loop.in_coordinates(_observed(loop.here))
        here = self._loop.here
        self._X = solve_continuous_lyapunov(here.A.T, -here.C.T @ here.C)
        self._value, self._name, self._centre = norm.value(device), name, unknowns
        self._trace = float(np.trace(here.B.T @ self._X @ here.B))
        slope, convex = self._second_order
        exact = norm.slope(device)
        self._correction = 2 * self._value * np.concatenate([exact[part] for part in unknowns]) - slope
        names, X, q = tuple(unknowns), f"X{name}", f"q{name}"
        self.shapes = {X: Shape(len(here.A), len(here.A), symmetric=True), q: Shape(1, 1)}
        self.of: tuple[str, ...] = (*names, X, q)
        self.inequality = Affine((*names, X), self._h2)
        self.cones: list[Affine] = [
            Affine((*names, q), lambda u: _square_below(u[q][..., 0], _moved(u, self._centre) @ convex))
        ]

    def __call__(self, u: Unknowns) -> Real:
        """F + (trace + q + correction − F²)/2F: to the norm what the tangent is to the square root."""
        here, B = self._loop.here, self._loop(u).B
        N = lmi.linearised(u[f"X{self._name}"], B, self._X, here.B)
        trace = np.trace(here.B.T @ N + (B - here.B).swapaxes(-1, -2) @ self._X @ here.B, axis1=-2, axis2=-1)
        added = trace - self._trace + u[f"q{self._name}"][..., 0, 0] + _moved(u, self._centre) @ self._correction
        return np.asarray(self._value + added / (2 * self._value))

    def _h2(self, u: Unknowns) -> Real:
        loop = self._loop(u)
        M = lmi.linearised(u[f"X{self._name}"], loop.A, self._X, self._loop.here.A)
        return lmi.h2(M, loop.C)

    @property
    def _second_order(self) -> tuple[Real, Real]:
        """Slope of the trace by the device's entries, and a factor of the convex part of q."""
        here, X = self._loop.here, self._X
        loop = each_entry(self._loop, self._centre)
        dA, dB, dC = loop.A, loop.B, loop.C
        right = X @ dA + here.C.T @ dC
        X1 = _lyapunov_batch(here.A, right + right.transpose(0, 2, 1))
        Y = solve_continuous_lyapunov(here.A, -here.B @ here.B.T)
        slope = 2 * np.einsum("ab,iba->i", Y, right) + 2 * np.einsum("ac,iac->i", X @ here.B, dB)
        q = np.einsum("iab,jba->ij", Y @ X1, dA) + np.einsum("iac,jac->ij", X1 @ here.B, dB)
        return slope, _convex(q + q.T + np.einsum("iac,jac->ij", X @ dB, dB))


class HInfinityBound:
    """The H∞ norm: γ over the bounded-real inequality, and to second order the gain at each of its peaks.

    The X to linearise at is the one that proves the current norm, found from the same inequality with the device
    fixed. To first order in the device the inequality is exact; what linearising dropped tells peaks apart, so the gain
    σ at the largest of them, each with its slope and the convex part of its second derivative in the device (the peak's
    frequency moving), stays below γ as well.
    """

    def __init__(self, norm: LinearisedNorm, device: PortHamiltonian, unknowns: Unknowns, name: str) -> None:
        self._value, self._name = norm.value(device), name
        loop = LoopAt.of(norm.plant.amplified(1 / self._value), unknowns)
        self._loop = loop.in_coordinates(_observed(loop.here))
        size = len(self._loop.here.A)
        names, X, g = tuple(unknowns), f"X{name}", f"g{name}"
        self.shapes = {X: Shape(size, size, symmetric=True), g: Shape(1, 1)}
        self._X = np.eye(size)  # stands for nothing while the loop is fixed
        proof = sdp.minimise(
            self.shapes,
            Affine((X, g), lambda u: u[g][..., 0, 0] + SMALL * np.trace(u[X], axis1=-2, axis2=-1)),
            [Affine((X, g), lambda u: self._bounded_real({**u, **unknowns}))],
        )
        if proof.unknowns is None:
            raise LinAlgError("no proof of the norm")
        self._X, self._gamma = proof.unknowns[X], float(proof.unknowns[g].item())
        self.of: tuple[str, ...] = (g,)
        self.inequality = Affine((*names, X, g), self._bounded_real)
        change = each_entry(self._loop, unknowns)
        self.cones: list[Affine] = []
        for omega in peaks(self._loop.here):
            gain, slope, curvature = peak(self._loop.here, change, omega)
            below = partial(_peak_below, name=g, centre=unknowns, gain=gain, slope=slope, factor=_convex(curvature / 2))
            self.cones.append(Affine((*names, g), below))

    def __call__(self, u: Unknowns) -> Real:
        """γ, in units of the exact figure."""
        return np.asarray(self._value * u[f"g{self._name}"][..., 0, 0] / self._gamma)

    def _bounded_real(self, u: Unknowns) -> Real:
        loop, here, X = self._loop(u), self._loop.here, u[f"X{self._name}"]
        M = lmi.linearised(X, loop.A, self._X, here.A)
        N = lmi.linearised(X, loop.B, self._X, here.B)
        return lmi.bounded_real(M, N, loop.C, loop.D, u[f"g{self._name}"])


@dataclass(frozen=True)
class Sector:
    """A vehicle whose closed-loop poles must have at least a damping ratio (one speed of many)."""

    plant: GeneralisedPlant
    damping: float

    def at(self, unknowns: Unknowns, name: str) -> tuple[dict[str, Shape], list[Affine]]:
        """Its inequalities near a device, in coordinates where the current X is I, and their unknown."""
        loop = LoopAt.of(self.plant, unknowns)
        # In real modal coordinates A is block-diagonal and X = I satisfies the inequality.
        values, vectors = np.linalg.eig(loop.here.A)
        modes = np.hstack(
            [
                (v.real[:, None] if w.imag == 0 else np.column_stack([v.real, v.imag]))
                for w, v in zip(values, vectors.T, strict=True)
                if w.imag >= 0
            ]
        )
        loop = loop.in_coordinates(np.linalg.inv(modes))
        one, X = np.eye(len(loop.here.A)), f"X{name}"

        def sector(u: Unknowns) -> Real:
            return lmi.sector(lmi.linearised(u[X], loop(u).A, one, loop.here.A), self.damping)

        # It is homogeneous in X, so a large X would hide what linearising dropped.
        between: list[Callable[[Unknowns], Real]] = [lambda u: u[X] - one / 2, lambda u: 2 * one - u[X]]
        blocks = [Affine((*unknowns, X), sector), *(Affine((X,), block) for block in between)]
        return {X: Shape(len(one), len(one), symmetric=True)}, blocks


def stacked(u: Unknowns) -> Real:
    """Unknowns as one vector; leading axes kept."""
    return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in u.values()], axis=-1)


def _closed(plant: GeneralisedPlant, u: Unknowns) -> Loop:
    return plant.closed(u["A"], u["B"], u["C"], u["D"], u.get("k", 0.0))


def _observed(loop: Loop) -> Real:
    """T that takes the observability Gramian near I.

    The Gramian itself is singular to working precision (the output hardly sees a long chain of delays), so T comes
    from that of an output that sees every state a little.
    """
    seen = loop.C.T @ loop.C
    n = len(loop.A)
    return cholesky(solve_continuous_lyapunov(loop.A.T, -(seen + SEEN * np.trace(seen) / n * np.eye(n))))


def _transformed(loop: Loop, T: Real) -> Loop:
    inverse = np.linalg.inv(T)
    return Loop(T @ loop.A @ inverse, T @ loop.B, loop.C @ inverse, loop.D)


def each_entry(loop: LoopAt, device: Unknowns) -> Loop:
    """The change of the loop by a unit of each entry of the device."""
    sizes = [part.size for part in device.values()]
    probes = np.split(np.vstack([np.zeros(sum(sizes)), np.eye(sum(sizes))]), np.cumsum(sizes)[:-1], axis=1)
    at = loop({name: y.reshape(len(y), *part.shape) for (name, part), y in zip(device.items(), probes, strict=True)})
    dB = at.B[1:] - at.B[0] if at.B.ndim == 3 else np.zeros((sum(sizes), *at.B.shape))
    return Loop(at.A[1:] - at.A[0], dB, at.C[1:] - at.C[0], at.D)


def _moved(u: Unknowns, centre: Unknowns) -> Real:
    """The device's entries less those at `centre`."""
    return stacked({name: u[name] - part for name, part in centre.items()})


def _convex(form: Real) -> Real:
    """A factor R, R Rᵀ the positive part of a symmetric form."""
    values, vectors = np.linalg.eigh(form)
    kept = values > 1e-12 * max(values.max(), 1e-300)
    return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))


def _peak_below(u: Unknowns, name: str, centre: Unknowns, gain: float, slope: Real, factor: Real) -> Real:
    """γ ≥ σ + slopeᵀd + ‖factorᵀd‖² as a second-order cone."""
    d = _moved(u, centre)
    return _square_below(u[name][..., 0] - gain - (d @ slope)[..., None], d @ factor)


def peak(loop: Loop, change: Loop, omega: float) -> tuple[float, Real, Real]:
    """The gain at a peak over frequency, its slope and its second derivative in the device's entries, the peak moving.

    The gain is the largest eigenvalue of H = [[0, G*], [G, 0]], whose derivatives are [Lancaster1964]'s:

        λᵢ = v* Hᵢ v,   λᵢⱼ = v* Hᵢⱼ v + 2 Re v* Hᵢ (λ − H)⁺ Hⱼ v,   in all λᵢⱼ − λᵢω λⱼω / λωω.
    """
    A, B, C = loop.A, loop.B, loop.C
    dA, dB, dC = change.A, change.B, change.C
    R = np.linalg.inv(1j * omega * np.eye(len(A)) - A)
    RB, CR = R @ B, C @ R
    V, slow = dA @ RB + dB, -1j * R @ RB  # R V is the change of RB by the entries, slow that by ω
    across = (CR @ dA + dC)[:, None] @ (R @ V)[None]
    H, H_omega, H_twice = _hermitian(C @ RB + loop.D), _hermitian(C @ slow), _hermitian(-2j * CR @ slow)
    H_entry, H_entries = _hermitian(CR @ V + dC @ RB), _hermitian(across + across.swapaxes(0, 1))
    H_mixed = _hermitian(-1j * CR @ R @ V + (CR @ dA + dC) @ slow)
    values, vectors = np.linalg.eigh(H)
    v, rest = vectors[:, -1], vectors[:, :-1] / np.sqrt(values[-1] - values[:-1])  # rest rest* = (λ − H)⁺
    by_entry, by_omega = (H_entry @ v) @ rest.conj(), (H_omega @ v) @ rest.conj()
    curved = (v.conj() @ H_entries @ v + 2 * by_entry.conj() @ by_entry.T).real
    mixed = (v.conj() @ H_mixed @ v + 2 * by_entry.conj() @ by_omega).real
    turned = float((v.conj() @ H_twice @ v + 2 * np.vdot(by_omega, by_omega)).real)
    return float(values[-1]), (v.conj() @ H_entry @ v).real, np.asarray(curved - np.outer(mixed, mixed) / turned)


def _hermitian(G: Real) -> Real:
    """[[0, G*], [G, 0]]; leading axes broadcast."""
    q, m = G.shape[-2:]
    H = np.zeros((*G.shape[:-2], m + q, m + q), dtype=complex)
    H[..., m:, :m], H[..., :m, m:] = G, G.conj().swapaxes(-1, -2)
    return H


def peaks(loop: Loop) -> list[float]:
    """The largest local maxima of the gain over frequency."""
    own = np.abs(np.linalg.eigvals(loop.A))
    own = own[own > 0]
    grid = np.unique(np.concatenate([np.geomspace(own.min() / 10, own.max() * 10, 400), own]))

    def gain(omega: Real) -> Real:
        shifted = 1j * np.atleast_1d(omega)[:, None, None] * np.eye(len(loop.A)) - loop.A
        return np.asarray(np.linalg.norm(loop.C @ np.linalg.solve(shifted, loop.B) + loop.D, axis=(1, 2)))

    size = gain(grid)
    tops = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    return [
        float(minimize_scalar(lambda w: -gain(w)[0], bounds=(grid[i - 1], grid[i + 1]), method="bounded").x)
        for i in tops[np.argsort(-size[tops])][:PEAKS]
    ]


def _square_below(q: Real, d: Real) -> Real:
    """q ≥ ‖d‖² as a second-order cone: ‖(2d, q − 1)‖ ≤ q + 1."""
    return np.concatenate([q + 1, q - 1, 2 * d], axis=-1)


def _lyapunov_batch(A: Real, Q: Real) -> Real:
    """X with AᵀX + XA + Q = 0 for a batch of Q, by diagonalising A once."""
    values, T = np.linalg.eig(A)
    inverse = np.linalg.inv(T)
    X = -(T.T @ Q @ T) / (values[:, None] + values[None, :])
    return np.asarray((inverse.T @ X @ inverse).real)
