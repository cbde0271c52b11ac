"""The vehicle as the matrix inequalities see it: everything but the device, scaled, delays by Padé, reduced.

    ẋ = A x + Bw w + Bu u,   z = Cz x + Dzw w + Dzu u,   y = Cy x = ḋ,   d = Cd x,   u = H y at every port

The static spring or airspring beside the device is part of A, an inerter beside it part of the masses. Where a bush
of stiffness kb stands behind the device, the bush's deflection e is a state, ė = v − u, and the device answers the bush
force y = kb e with a velocity u: H is then its *impedance*; otherwise y = v, u = f and H is its admittance. Either is
positive real if the other is.

Time is in 1/ω0 and the device in c0 (:class:`Scale`); w and z are such that the figure is the norm of w → z.
Delays are chains of Padé all-passes, each wheel's signal that of the one before, later. What the criterion cannot
feel (the bogies' pitch, most of a long chain) goes by balanced truncation with the damper c0 in place [Moore1981].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, solve_continuous_lyapunov, svd

from posreal.admittance import Rational, state_space
from posreal.errors import BadInput
from posreal.metric import Norm
from posreal.optimisation.mean_square import norm_of
from posreal.optimisation.scaling import Scale
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant, channels
from posreal.specification.problem import Problem
from posreal.vehicle import Vehicle

Real = np.ndarray

BAND = 4.0  # ω0, up to which Padé delays keep their phase where the vehicle does not say


@dataclass(frozen=True)
class Loop:
    """A closed vehicle ẋ = A x + B w, z = C x + D w; leading axes broadcast."""

    A: Real
    B: Real
    C: Real
    D: Real


@dataclass(frozen=True)
class GeneralisedPlant:
    """The matrices of the module's equations; `Bw` has one column a disturbance."""

    A: Real
    Bw: Real
    Bu: Real
    Cz: Real
    Dzw: Real
    Dzu: Real
    Cy: Real
    Cd: Real

    def closed(self, Ak: Real, Bk: Real, Ck: Real, Dk: Real, k: Real | float = 0.0) -> Loop:
        """The loop with the device and a spring k in every port, affine in both; leading axes broadcast.

            A = [[A + Bu (D Cy + k Cd), Bu C], [B Cy, A_k]],   C = [Cz + Dzu (D Cy + k Cd), Dzu C]

        with A_k, B, C, D the device's matrices repeated block-diagonally, one copy a port.
        """
        a, b, c, d = (_repeated(part, self.Bu.shape[1]) for part in (Ak, Bk, Ck, Dk))
        direct = d @ self.Cy + k * self.Cd
        upper = np.concatenate([self.A + self.Bu @ direct, self.Bu @ c], axis=-1)
        lower = np.concatenate([b @ self.Cy, a], axis=-1)
        C = np.concatenate([self.Cz + self.Dzu @ direct, self.Dzu @ c], axis=-1)
        B = np.vstack([self.Bw, np.zeros((a.shape[-1], self.Bw.shape[1]))])
        return Loop(np.concatenate([upper, lower], axis=-2), B, C, self.Dzw)

    def with_inerter(self, b: float) -> GeneralisedPlant:
        """The plant with an inerter beside the device at every port: b ẏ acts there besides u."""
        jerk = b * np.linalg.inv(np.eye(len(self.Cy)) - b * self.Cy @ self.Bu)
        of_x, of_w, of_u = jerk @ self.Cy @ self.A, jerk @ self.Cy @ self.Bw, jerk @ self.Cy @ self.Bu
        return GeneralisedPlant(
            self.A + self.Bu @ of_x,
            self.Bw + self.Bu @ of_w,
            self.Bu + self.Bu @ of_u,
            self.Cz + self.Dzu @ of_x,
            self.Dzw + self.Dzu @ of_w,
            self.Dzu + self.Dzu @ of_u,
            self.Cy,
            self.Cd,
        )

    def driven_by(self, A: Real, B: Real, C: Real, D: Real) -> GeneralisedPlant:
        """The same plant with w = filter of a new disturbance; the filter's states come last."""
        n = len(A)
        zero = np.zeros
        return GeneralisedPlant(
            np.block([[self.A, self.Bw @ C], [zero((n, len(self.A))), A]]),
            np.vstack([self.Bw @ D, B]),
            np.vstack([self.Bu, zero((n, self.Bu.shape[1]))]),
            np.hstack([self.Cz, self.Dzw @ C]),
            self.Dzw @ D,
            self.Dzu,
            np.hstack([self.Cy, zero((len(self.Cy), n))]),
            np.hstack([self.Cd, zero((len(self.Cd), n))]),
        )

    def scaled(self, scale: Scale, gain: Real | float) -> GeneralisedPlant:
        """In units of time 1/ω0 and device c0, with z multiplied by `gain`."""
        device = 1 / scale.damper if scale.impedance else scale.damper
        omega = scale.omega
        return GeneralisedPlant(
            self.A / omega,
            self.Bw / omega,
            self.Bu * device / omega,
            self.Cz,
            self.Dzw,
            self.Dzu * device,
            self.Cy,
            self.Cd * omega,
        ).amplified(gain)

    def amplified(self, gain: Real | float) -> GeneralisedPlant:
        """With z multiplied by `gain`, a number or one for each row (q, 1)."""
        return replace(self, Cz=self.Cz * gain, Dzw=self.Dzw * gain, Dzu=self.Dzu * gain)

    def reduced(self, tolerance: float) -> GeneralisedPlant:
        """Balanced truncation of (w, u) → (z, y), closed by u = y and opened again afterwards.

        Parameters
        ----------
        tolerance : float
            States with Hankel singular values below `tolerance` times the largest are dropped.
        """
        A = self.A + self.Bu @ self.Cy
        Cz = self.Cz + self.Dzu @ self.Cy
        if np.linalg.eigvals(A).real.max() >= -1e-9:  # a damper alone does not hold it: nothing to weigh states by
            return self
        # Inputs and outputs of different kinds count each by its own size in the closed vehicle.
        inputs = np.hstack([_unit(A, self.Bw), _unit(A, self.Bu)])
        outputs = np.hstack([_unit(A.T, Cz.T), _unit(A.T, self.Cy.T)])
        reach = _root(solve_continuous_lyapunov(A, -inputs @ inputs.T))
        view = _root(solve_continuous_lyapunov(A.T, -outputs @ outputs.T))
        U, sigma, Vt = svd(view.T @ reach)
        kept = sigma > tolerance * sigma[0]
        root = np.sqrt(sigma[kept])
        left = (U[:, kept] / root).T @ view.T
        right = reach @ (Vt[kept].T / root)
        Bu, Cy = left @ self.Bu, self.Cy @ right
        return GeneralisedPlant(
            left @ A @ right - Bu @ Cy,
            left @ self.Bw,
            Bu,
            Cz @ right - self.Dzu @ Cy,
            self.Dzw,
            self.Dzu,
            Cy,
            self.Cd @ right,
        )


def generalised_plant(
    problem: Problem, scale: Scale, metric: str | None = None, *, tolerance: float = 1e-5
) -> GeneralisedPlant:
    """The generalised plant of one figure of a problem, as a norm of w → z.

    Parameters
    ----------
    problem : Problem
    scale : Scale
    metric : str, optional
        A root mean square (the H2 norm) or ``gain_OUTPUT`` (the H∞ norm); the objective by default.
    tolerance : float
        Of the balanced truncation.

    Raises
    ------
    BadInput
        If the metric is no norm.
    """
    goal = problem.goal if metric in (None, problem.base_objective) else None
    parts = ((metric or problem.base_objective, 1.0),) if goal is None or goal.kind != "norm" else goal.parts
    norms = [_norm(problem, name) for name, _ in parts]
    plant = problem.vehicle.plant(norms[0].load).rational
    rows = [plant.output(norm.output) for norm in norms]
    size = np.array([w * norm.factor(problem.vehicle) for (_, w), norm in zip(parts, norms, strict=True)])
    opened = mounted(plant, rows, problem.mounting)
    band = problem.vehicle.pade_band or BAND * scale.omega
    opened = opened.driven_by(*delay_chains(plant, band))
    if plant.shaping is not None:
        H = plant.shaping.rational
        opened = opened.driven_by(H.A, H.B, H.C, H.D)
    if norms[0].kind == "H2":
        density = np.diag(np.sqrt(math.pi * scale.omega * plant.density * np.array(plant.shares)))
        opened = replace(opened, Bw=opened.Bw @ density, Dzw=opened.Dzw @ density)
    return opened.scaled(scale, size[:, None]).reduced(tolerance)


def _norm(problem: Problem, metric: str) -> Norm:
    try:
        return norm_of(problem.vehicle, metric, "H2", "H∞")
    except BadInput as error:
        raise BadInput(f"{error}, and the inequalities are about nothing else; use method='auto'") from None


def damped_plant(vehicle: Vehicle, mounting: Mounting, scale: Scale, *, tolerance: float = 1e-6) -> GeneralisedPlant:
    """The vehicle at its speed without track filter and delays, for the damping of its poles."""
    opened = mounted(vehicle.plant(vehicle.random), [0], mounting)
    return opened.scaled(scale, 1.0).reduced(tolerance)


def mounted(plant: Plant, outputs: Sequence[int], mounting: Mounting) -> GeneralisedPlant:
    """The vehicle in SI units with what stands beside and behind the device as part of it."""
    p, n = plant.Cv.shape
    Cz, Dzw, Dzf = plant.Cz[outputs], plant.Dzw[outputs], plant.Dzf[outputs]
    opened = GeneralisedPlant(plant.A, plant.Bw, plant.Bf, Cz, Dzw, Dzf, plant.Cv, plant.Cd)
    if mounting.beside is not None:
        beside = state_space(mounting.beside)
        loop = opened.with_inerter(beside.b).closed(beside.A, beside.B, beside.C, beside.D, beside.k)
        opened = _reopened(opened.with_inerter(beside.b), loop)
    if mounting.behind is None:
        return opened
    bush = mounting.behind
    if bush != Rational.spring(bush.static_stiffness):
        raise BadInput("the matrix inequalities take a spring behind the device and nothing else; use method='ph'")
    k, n = float(bush.static_stiffness), len(opened.A)
    return GeneralisedPlant(
        np.block([[opened.A, k * opened.Bu], [opened.Cy, np.zeros((p, p))]]),
        np.vstack([opened.Bw, np.zeros((p, opened.Bw.shape[1]))]),
        np.vstack([np.zeros((n, p)), -np.eye(p)]),
        np.hstack([opened.Cz, k * opened.Dzu]),
        opened.Dzw,
        np.zeros((len(outputs), p)),
        np.hstack([np.zeros((p, n)), k * np.eye(p)]),
        np.zeros((p, n + p)),  # nothing stands beside a device behind its bush
    )


def _reopened(plant: GeneralisedPlant, loop: Loop) -> GeneralisedPlant:
    """A plant whose ports are closed by what stands beside the device, open for the device."""
    p, more = len(plant.Cy), len(loop.A) - len(plant.A)
    return GeneralisedPlant(
        loop.A,
        loop.B,
        np.vstack([plant.Bu, np.zeros((more, p))]),
        loop.C,
        loop.D,
        plant.Dzu,
        np.hstack([plant.Cy, np.zeros((p, more))]),
        np.hstack([plant.Cd, np.zeros((p, more))]),
    )


def delay_chains(plant: Plant, band: float) -> tuple[Real, Real, Real, Real]:
    """Processes ↦ channels as a state space, a chain for each process; see :func:`delay_chain`."""
    driven = channels(plant)
    chains = [delay_chain(plant.delays[late], band) for late in driven]
    A, B = block_diag(*(chain[0] for chain in chains)), block_diag(*(chain[1] for chain in chains))
    C, D = block_diag(*(chain[2] for chain in chains)), block_diag(*(chain[3] for chain in chains))
    order = np.argsort(np.concatenate(driven))
    return A, B, C[order], D[order]


def delay_chain(delays: Real, band: float) -> tuple[Real, Real, Real, Real]:
    """w ↦ (w(t − τ₁), w(t − τ₂), …) as a state space: one chain of Padé sections that all channels share.

    Parameters
    ----------
    delays : (m,) seconds
    band : float
        Frequency, rad/s, up to which each section keeps its phase.
    """
    A, B = np.zeros((0, 0)), np.zeros((0, 1))
    C, D = np.zeros((1, 0)), np.ones((1, 1))  # the last tap
    taps: dict[int, tuple[Real, float]] = {}
    now = 0.0
    for channel in np.argsort(delays, kind="stable"):
        if delays[channel] > now:
            Ad, Bd, Cd, Dd = _pade(delays[channel] - now, band)
            A = np.block([[A, np.zeros((len(A), len(Ad)))], [Bd @ C, Ad]])
            B = np.vstack([B, Bd @ D])
            C, D = np.hstack([Dd @ C, Cd]), Dd @ D
            now = float(delays[channel])
        taps[int(channel)] = (C[0], float(D[0, 0]))
    rows_out = np.zeros((len(delays), len(A)))
    direct = np.zeros((len(delays), 1))
    for channel, (row, d) in taps.items():
        rows_out[channel, : len(row)], direct[channel, 0] = row, d
    return A, B, rows_out, direct


def _pade(delay: float, band: float) -> tuple[Real, Real, Real, Real]:
    """e^{−sτ} ≈ product of equal second-order Padé sections; each is good to a tenth of a radian for ωτ < 3."""
    sections = max(1, math.ceil(band * delay / 3.0))
    t = delay / sections
    # (1 − x/2 + x²/12)/(1 + x/2 + x²/12) with x = s t, as 1 − 12 t s/(s²t² + 6 s t + 12)
    rate = 1 / t
    A1 = rate * np.array([[0.0, math.sqrt(12.0)], [-math.sqrt(12.0), -6.0]])
    B1 = np.array([[0.0], [rate]])
    C1, D1 = np.array([[0.0, -12.0]]), np.ones((1, 1))
    A, B, C, D = A1, B1, C1, D1
    for _ in range(sections - 1):
        A = np.block([[A, np.zeros((len(A), 2))], [B1 @ C, A1]])
        B, C, D = np.vstack([B, B1 @ D]), np.hstack([D1 @ C, C1]), D1 @ D
    return A, B, C, D


def _repeated(block: Real, copies: int) -> Real:
    """Block-diagonal copies of the last two axes."""
    rows, columns = block.shape[-2:]
    out = np.zeros((*block.shape[:-2], copies * rows, copies * columns))
    for i in range(copies):
        out[..., i * rows : (i + 1) * rows, i * columns : (i + 1) * columns] = block
    return out


def _unit(A: Real, B: Real) -> Real:
    """B over the root-mean-square of the states it excites."""
    return B / math.sqrt(np.trace(solve_continuous_lyapunov(A, -B @ B.T)))


def _root(gramian: Real) -> Real:
    """A factor of a positive semidefinite matrix, rounding errors below zero cut off."""
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))
