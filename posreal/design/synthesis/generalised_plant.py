"""The vehicle as the matrix inequalities see it: everything but the device, scaled, delays by Padé, reduced.

    ẋ = A x + Bw w + Bu u,   z = Cz x + Dzu u,   y = Cy x,   u = H y at every port

The static spring or airspring beside the device is part of A. Where a bush of stiffness kb stands behind the device,
the bush's deflection e is a state, ė = v − u, and the device answers the bush force y = kb e with a velocity u: H is
then its *impedance*; otherwise y = v, u = f and H is its admittance. Either is positive real if the other is.

Time is in 1/ω0 and the device in c0 (:class:`Scale`); w and z are such that the figure J is the H2 norm of w → z.
Delays are chains of Padé all-passes, each wheel's signal that of the one before, later. What the criterion cannot
feel (the bogies' pitch, most of a long chain) goes by balanced truncation with the damper c0 in place [Moore1981].

[Moore1981] B.C. Moore, Principal component analysis in linear systems: controllability, observability, and model
reduction, IEEE Transactions on Automatic Control 26 (1981) 17–32.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, svd

from posreal.admittance import Rational, state_space
from posreal.design.mounting import Mounting
from posreal.design.problem import Problem
from posreal.design.synthesis.scale import Scale
from posreal.errors import BadInput
from posreal.vehicle import PlanView, QuarterCar, SideView, UserPlant
from posreal.vehicle.plant import Plant

Real = np.ndarray


@dataclass(frozen=True)
class GeneralisedPlant:
    """The matrices of the module's equations; `Bw` has one column a disturbance."""

    A: Real
    Bw: Real
    Bu: Real
    Cz: Real
    Dzu: Real
    Cy: Real

    def closed(self, Ak: Real, Bk: Real, Ck: Real, Dk: Real) -> tuple[Real, Real]:
        """Acl and Ccl with the device in every port, affine in the device; leading axes broadcast.

            Acl = [[A + Bu D Cy, Bu C], [B Cy, A_k]],   Ccl = [Cz + Dzu D Cy, Dzu C]

        with A_k, B, C, D the device's matrices repeated block-diagonally, one copy a port.
        """
        a, b, c, d = (_repeated(part, self.Bu.shape[1]) for part in (Ak, Bk, Ck, Dk))
        upper = np.concatenate([self.A + self.Bu @ d @ self.Cy, self.Bu @ c], axis=-1)
        lower = np.concatenate([b @ self.Cy, a], axis=-1)
        Ccl = np.concatenate([self.Cz + self.Dzu @ d @ self.Cy, self.Dzu @ c], axis=-1)
        return np.concatenate([upper, lower], axis=-2), Ccl

    def driven_by(self, A: Real, B: Real, C: Real, D: Real) -> GeneralisedPlant:
        """The same plant with w = filter of a new disturbance; the filter's states come last."""
        n = len(A)
        zero = np.zeros
        return GeneralisedPlant(
            np.block([[self.A, self.Bw @ C], [zero((n, len(self.A))), A]]),
            np.vstack([self.Bw @ D, B]),
            np.vstack([self.Bu, zero((n, self.Bu.shape[1]))]),
            np.hstack([self.Cz, zero((len(self.Cz), n))]),
            self.Dzu,
            np.hstack([self.Cy, zero((len(self.Cy), n))]),
        )

    def scaled(self, scale: Scale, gain: float) -> GeneralisedPlant:
        """In units of time 1/ω0 and device c0, with z multiplied by `gain`."""
        device = 1 / scale.damper if scale.impedance else scale.damper
        omega = scale.omega
        return GeneralisedPlant(
            self.A / omega,
            self.Bw / omega,
            self.Bu * device / omega,
            self.Cz * gain,
            self.Dzu * device * gain,
            self.Cy,
        )

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
            left @ A @ right - Bu @ Cy, left @ self.Bw, Bu, Cz @ right - self.Dzu @ Cy, self.Dzu, Cy
        )


def generalised_plant(
    problem: Problem, scale: Scale, *, band: float = 15.0, tolerance: float = 1e-5
) -> GeneralisedPlant:
    """The generalised plant of a problem's mean-square objective.

    Parameters
    ----------
    problem : Problem
    scale : Scale
    band : float
        Frequency, rad/s, up to which the Padé delays keep their phase.
    tolerance : float
        Of the balanced truncation.
    """
    plant, output, unit = _performance(problem)
    opened = mounted(plant, plant.output(output), problem.mounting)
    opened = opened.driven_by(*delay_chain(plant.delays, band))
    if plant.shaping is not None:
        H = plant.shaping
        opened = opened.driven_by(H.A, H.B, H.C, H.D)
    gain = unit * math.sqrt(math.pi * plant.density * scale.omega)
    return opened.scaled(scale, gain).reduced(tolerance)


def damped_plant(vehicle: PlanView, mounting: Mounting, scale: Scale, *, tolerance: float = 1e-6) -> GeneralisedPlant:
    """The vehicle at its speed without track filter and delays, for the damping of its poles."""
    opened = mounted(vehicle.random_track(), 0, mounting)
    return opened.scaled(scale, 1.0).reduced(tolerance)


def mounted(plant: Plant, output: int, mounting: Mounting) -> GeneralisedPlant:
    """The vehicle in SI units with what stands beside and behind the device as part of it."""
    p, n = plant.Cv.shape
    beside = state_space(Rational.zero() if mounting.beside is None else mounting.beside)
    m = beside.order
    # force of what stands beside: k d + C ξ + D v with one copy of ξ a port
    direct = beside.k * plant.Cd + beside.D[0, 0] * plant.Cv
    inner = np.kron(np.eye(p), beside.C)
    Dzf = plant.Dzf[output : output + 1]
    A = np.block(
        [
            [plant.A + plant.Bf @ direct, plant.Bf @ inner],
            [np.kron(np.eye(p), beside.B) @ plant.Cv, np.kron(np.eye(p), beside.A)],
        ]
    )
    Bw = np.vstack([plant.Bw, np.zeros((p * m, plant.Bw.shape[1]))])
    Bf = np.vstack([plant.Bf, np.zeros((p * m, p))])
    Cz = np.hstack([plant.Cz[output : output + 1] + Dzf @ direct, Dzf @ inner])
    Cv = np.hstack([plant.Cv, np.zeros((p, p * m))])
    if mounting.behind is None:
        return GeneralisedPlant(A, Bw, Bf, Cz, Dzf, Cv)
    bush = mounting.behind
    if bush != Rational.spring(bush.static_stiffness):
        raise BadInput("the matrix inequalities take a spring behind the device and nothing else; use method='ph'")
    k, n = float(bush.static_stiffness), len(A)
    return GeneralisedPlant(
        np.block([[A, k * Bf], [Cv, np.zeros((p, p))]]),
        np.vstack([Bw, np.zeros((p, Bw.shape[1]))]),
        np.vstack([np.zeros((n, p)), -np.eye(p)]),
        np.hstack([Cz, k * Dzf]),
        np.zeros((1, p)),
        np.hstack([np.zeros((p, n)), k * np.eye(p)]),
    )


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


def _performance(problem: Problem) -> tuple[Plant, str, float]:
    """The plant, the output and the unit of the objective: J = unit · r.m.s. of the output."""
    match problem.vehicle:
        case PlanView() as plan if problem.objective in ("Macc", "J1y"):
            return plan.random_track(), "body_acceleration", 1.0
        case SideView() as side if problem.objective.startswith("J1z_"):
            return side.track(), f"acceleration_{problem.objective[-1]}", 100 / side.g
        case QuarterCar() as quarter:
            return quarter.road(), "acceleration" if problem.objective == "J1" else "tyre_force", 1.0
        case UserPlant() as own if problem.objective.startswith("rms_"):
            return own.plant, problem.objective.removeprefix("rms_"), 1.0
    raise BadInput(f"{problem.objective} is not a mean-square figure, and the H2 inequality is about nothing else")


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
