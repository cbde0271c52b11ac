"""Figures of a closed loop from its modes, in closed form.

Channel i of the closed loop is zᵢ(s) = dᵢ + Σₖ ρᵢₖ/(s − λₖ). For its mean square on a band, with Δᵢⱼ = τᵢ − τⱼ,

    ∫ₐᵇ |Σᵢ e^{−jωτᵢ} zᵢ(jω)|² dω = Σᵢⱼ dᵢ dⱼ ∫ₐᵇ cos ωΔᵢⱼ dω + 2 Re Σᵢⱼₖ ρᵢₖ zⱼ(−λₖ) ∫ₐᵇ e^{−jωΔᵢⱼ}/(jω − λₖ) dω

because 1/((jω − λ)(−jω − μ)) = −(1/(jω − λ) + 1/(−jω − μ))/(λ + μ) splits every product of two modes. The last
integral is an exponential integral (a logarithm where Δᵢⱼ = 0). No grid is involved, so a resonance may be as sharp as
the eigenvalues are accurate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy.special import exp1, expi

from posreal.plant.plant import ClosedLoop, Complex, Real, channels
from posreal.plant.shaping_filter import ShapingFilter

Corners: TypeAlias = "Sequence[tuple[float, float]]"
"""(instant in s, change of slope) of an input made of ramps."""

_EPS, _EXACT = 1e-16, 1e-11  # rounding of a mode's part, and what of the largest response it may be
_RUN = 64  # samples of an even grid that share an exponential
_FAR = 40.0  # from where the asymptotic series of the exponential integral is good to rounding


@dataclass(frozen=True)
class Modes:
    """The outputs of a closed loop as sums over its modes.

    Attributes
    ----------
    poles : (n,) λₖ, rad/s
    residues : (q, m, n) ρᵢₖ of each output and channel
    direct : (q, m) dᵢ
    delays : (m,) τᵢ, s
    outputs : names of the q outputs
    processes : which channels each process drives
    weights : density of each process, per rad/s
    """

    poles: Complex
    residues: Complex
    direct: Real
    delays: Real
    outputs: tuple[str, ...]
    processes: tuple[tuple[int, ...], ...]
    weights: tuple[float, ...]

    def at(self, s: Complex) -> Complex:
        """z(s) of every output and channel without the channel's delay, (q, m, …)."""
        apart = 1.0 / np.subtract.outer(np.asarray(s), self.poles)
        return self.residues @ np.moveaxis(apart, -1, 0) + self.direct[..., None]

    def response(self, omega: Real, output: str) -> list[Complex]:
        """z/w of every process on the grid `omega`, delays exact."""
        late = np.exp(-1j * np.multiply.outer(self.delays, omega))
        z = self.at(1j * omega)[self.outputs.index(output)] * late
        return [z[list(driven)].sum(axis=0) for driven in self.processes]

    def mean_squares(self, start: float, stop: float) -> Real:
        """∫ Σ |z|² S dω from `start` to `stop` (rad/s) of every output."""
        mirrored = self.at(-self.poles)
        total = np.zeros(len(self.outputs))
        known: dict[float, Complex] = {}  # delays of wheels repeat, and exponential integrals are the work
        for weight, driven in zip(self.weights, self.processes, strict=True):
            for i in driven:
                for j in driven:
                    late = float(self.delays[i] - self.delays[j])
                    apart = round(late, 15)
                    if apart not in known:
                        known[apart] = _integral(self.poles, late, start, stop)
                    straight = self.direct[:, i] * self.direct[:, j] * _cosine(late, start, stop)
                    products = self.residues[:, i] * mirrored[:, j]
                    total += weight * (straight + 2 * (products @ known[apart]).real)
        return total

    def whole_mean_squares(self) -> Real:
        """∫ Σ |z|² S dω over all frequencies of every output that lets no white noise through.

        With g the impulse responses, ∫ gᵢ(t) gⱼ(t + Δ) dt = Σₖ ρⱼₖ e^{λₖΔ} zᵢ(−λₖ) for Δ = τᵢ − τⱼ ≥ 0.
        """
        mirrored = self.at(-self.poles)
        total = np.zeros(len(self.outputs))
        for weight, driven in zip(self.weights, self.processes, strict=True):
            for i in driven:
                for j in driven:
                    if (late := float(self.delays[i] - self.delays[j])) >= 0:
                        once = (self.residues[:, j] * mirrored[:, i]) @ np.exp(self.poles * late)
                        total += math.pi * weight * (once.real if late == 0 else 2 * once.real)
        return total

    def summed(self, omega: Real, step: float, output: str) -> float:
        """Σ |z|² S Δω over the points `omega`."""
        squares = zip(self.weights, self.response(omega, output), strict=True)
        return step * float(sum(weight * (np.abs(z) ** 2).sum() for weight, z in squares))

    def ramp(self, time: Real, corners: Corners, output: str) -> Real:
        """Response at every instant of `time` (s) to w(t) = Σ change · max(0, t − instant) in every channel.

        Between two instants at which a corner reaches a channel it is a line and the free decay of the modes, so one
        exponential of each mode serves all corners before; with modes so slow that line and decay cancel, each corner
        is summed by itself.
        """
        j = self.outputs.index(output)
        events = sorted(
            (instant + float(late), change, channel)
            for channel, late in enumerate(self.delays)
            for instant, change in corners
        )
        starts = np.array([at for at, _, _ in events])
        parts = self.residues[j] / np.where(self.poles == 0, 1.0, self.poles) ** 2
        total = np.zeros(len(time))
        decay, offset, slope, before = np.zeros(len(self.poles), complex), 0.0, 0.0, 0.0
        for i, (at, change, channel) in enumerate(events):
            decay = decay * np.exp(self.poles * (at - before)) + change * parts[channel]
            rate = change * (float(self.direct[j, channel]) - float((parts[channel] * self.poles).sum().real))
            offset, slope = offset - change * float(parts[channel].sum().real) - rate * at, slope + rate
            before = at
            here = (time > at) & (time <= (starts[i + 1] if i + 1 < len(events) else np.inf))
            total[here] = _waves(time[here] - at, self.poles, decay) + offset + slope * time[here]
        size = float(np.abs(parts).sum()) * max(abs(change) for _, change in corners)
        if np.all(self.poles != 0) and size * _EPS <= _EXACT * float(np.abs(total).max(initial=0.0)):
            return total
        return self._ramp_by_corners(time, corners, j)

    def _ramp_by_corners(self, time: Real, corners: Corners, j: int) -> Real:
        total = np.zeros(len(time))
        for channel, late in enumerate(self.delays):
            for instant, change in corners:
                after = time > instant + late
                t = time[after] - instant - late
                kernel = _twice_integrated(np.multiply.outer(t, self.poles)) * t[:, None] ** 2
                total[after] += change * ((kernel @ self.residues[j, channel]).real + self.direct[j, channel] * t)
        return total


def modes(loop: ClosedLoop, shaping: ShapingFilter | None = None) -> Modes:
    """The modes of a loop; a shaping filter before it adds its own poles once, not once a channel."""
    loop = loop.balanced()
    poles, vectors = np.linalg.eig(loop.A)
    poles, vectors = poles.astype(complex), vectors.astype(complex)
    residues = (loop.C @ vectors)[:, None, :] * np.linalg.solve(vectors, loop.B.astype(complex)).T
    weights = tuple(loop.density * share for share in loop.shares)
    driven = tuple(tuple(one) for one in channels(loop))
    plain = Modes(poles, residues, loop.D, loop.delays, loop.outputs, driven, weights)
    if shaping is None:
        return plain
    own, eigen = np.linalg.eig(shaping.A)
    own, eigen = own.astype(complex), eigen.astype(complex)
    parts = (shaping.C[0] @ eigen) * np.linalg.solve(eigen, shaping.B[:, 0].astype(complex))
    return replace(
        plain,
        poles=np.concatenate([poles, own]),
        residues=np.concatenate([residues * shaping(poles), parts * plain.at(own)], axis=-1),
        direct=loop.D * shaping.D[0, 0],
    )


def _waves(time: Real, poles: Complex, start: Complex) -> Real:
    """Re Σₖ startₖ exp(λₖ t) at every instant; on an even grid each exponential is one of a block and one inside it."""
    count = len(time)
    even = np.linspace(time[0], time[-1], count) if count > 2 * _RUN else time[:0]
    if not len(even) or np.abs(time - even).max() > 1e-15 * count * max(abs(time[0]), abs(time[-1])):
        return np.asarray((np.exp(np.multiply.outer(time, poles)) @ start).real)
    firsts = even[::_RUN]
    inside = np.exp(np.multiply.outer(even[:_RUN] - even[0], poles))
    return np.asarray((np.exp(np.multiply.outer(firsts, poles)) * start @ inside.T).real.ravel()[:count])


def shortest_decay(poles: Complex, stop: float) -> float:
    """The least distance from the axis of the oscillating modes up to `stop`, rad/s."""
    inside = poles[(poles.imag > 0) & (poles.imag < stop)]
    return float(np.abs(inside.real).min(initial=math.inf))


def _cosine(late: float, start: float, stop: float) -> float:
    """∫ cos ωΔ dω."""
    return stop - start if late == 0 else (math.sin(stop * late) - math.sin(start * late)) / late


def _integral(poles: Complex, late: float, start: float, stop: float) -> Complex:
    """∫ e^{−jωΔ}/(jω − λ) dω from `start` to `stop` for every pole λ in Re λ < 0."""
    if late == 0:
        return -1j * (np.log(1j * stop - poles) - np.log(1j * start - poles))
    ends = [np.exp(-1j * omega * late) * _scaled_exp1((1j * omega - poles) * late) for omega in (start, stop)]
    whole = -1j * (ends[0] - ends[1])
    if late < 0:
        # z = (jω − λ)Δ passes the cut of E₁ where ω passes Im λ; at its start a real pole lies on the cut
        passed = (start < poles.imag) & (poles.imag < stop)
        whole += np.where(passed, 2 * math.pi * np.exp(-poles * late), 0.0)
    return np.asarray(whole)


def _scaled_exp1(z: Complex) -> Complex:
    """e^z E₁(z), on the cut the value from below."""
    far = np.abs(z) > _FAR
    near = np.where(far, 1.0, z)
    on_cut = (near.imag == 0) & (near.real < 0)
    size = np.where(on_cut, -near.real, 1.0)
    value = np.exp(near) * np.where(on_cut, -expi(size) + 1j * math.pi, exp1(np.where(on_cut, 1.0, near)))
    term = series = 1.0 / np.where(far, z, _FAR)
    for n in range(1, round(_FAR)):
        term = -n * term / np.where(far, z, _FAR)
        series = series + term
    return np.asarray(np.where(far, series, value))


def _twice_integrated(x: Complex) -> Complex:
    """(eˣ − 1 − x)/x², by its series where x is small."""
    small = np.abs(x) < 0.5
    safe = np.where(small, 1.0, x)
    value = (np.exp(safe) - 1.0 - safe) / safe**2
    near = x[small]
    series, term = np.zeros_like(near), np.full_like(near, 0.5)
    for n in range(3, 18):
        series += term
        term *= near / n
    value[small] = series
    return np.asarray(value)
