"""The method of record: the bilinear matrix inequalities of [PS2006] by iterated semidefinite programs.

    minimise trace BwᵀXBw   over the device (A, B, C, D) and X,   subject to   H2, PR and sector inequalities

(:mod:`.inequalities`). The device is kept in coordinates where P = I, so its PR inequality is linear and
exact; only the products X·Acl are bilinear. They are linearised at the current point [HassibiHowBoyd1999]
within a ball around the device. What that drops is, to second order, the form

    q(δ) = 2 trace Y dA(δ)ᵀ X₁(δ),    A Y + Y Aᵀ + Bw Bwᵀ = 0,    X₁ the first change of X

in the step δ of the device; its convex part goes into the objective. Without it the iteration is steepest
descent between inequalities and stalls; with it, it ends in a few Newton-like steps. The plant's delays are
Padé approximations; a linear term makes the program's slope in the device the exact figure's, so that the
iteration comes to rest where the exact figure does [AlexandrovLewis2001].

The solver only proposes. The matrix that the PR inequality calls positive semidefinite is factored, which
makes the proposal positive real by construction, and `measure` recomputes the figure and the constraints with
exact delays: a proposal that is not better is not taken and the ball shrinks.

[AlexandrovLewis2001] N.M. Alexandrov, R.M. Lewis, An overview of first-order model management for engineering
optimization, Optimization and Engineering 2 (2001) 413–430.
[HassibiHowBoyd1999] A. Hassibi, J. How, S. Boyd, A path-following method for solving BMI problems in control, American
Control Conference (1999) 1385–1389.
[PS2006] C. Papageorgiou, M.C. Smith, Positive real synthesis using matrix inequalities for mechanical networks:
application to vehicle suspension, IEEE Transactions on Control Systems Technology 14 (2006) 423–435.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_continuous_lyapunov

from posreal.admittance import PortHamiltonian, StateSpace
from posreal.design.synthesis import inequalities, semidefinite
from posreal.design.synthesis.generalised_plant import GeneralisedPlant
from posreal.design.synthesis.semidefinite import Ball, Shape, Unknowns
from posreal.design.synthesis.storage import factored

Real = np.ndarray

DEVICE = ("A", "B", "C", "D")
OVERSTEP = 1e-5  # damping ratio asked for beyond the limit once a proposal has missed it
SEEN = 1e-7  # mean square of an output that sees every state, relative to z: X is conditioned like 1/SEEN


@dataclass(frozen=True)
class Sector:
    """A vehicle whose closed-loop poles must have at least a damping ratio (one speed of many)."""

    plant: GeneralisedPlant
    damping: float


@dataclass(frozen=True)
class Settings:
    """How far and how finely to iterate.

    Attributes
    ----------
    iterations : int
        Semidefinite programs solved at most.
    solver_iterations : int
        Interior-point iterations in each.
    radius, smallest_radius : float
        Of the ball around the scaled device, at first and when to stop.
    settled : float
        Relative gain of an accepted step that counts as none; two such steps in a row end the iteration.
    """

    iterations: int = 150
    solver_iterations: int = 60
    radius: float = 0.5
    smallest_radius: float = 1e-5
    settled: float = 1e-6


@dataclass(frozen=True)
class Outcome:
    """Where the iteration ended: the best device, its measured value, steps taken and steps refused."""

    device: PortHamiltonian
    value: float
    taken: int
    refused: int


def iterate(
    plant: GeneralisedPlant,
    start: PortHamiltonian,
    measure: Callable[[PortHamiltonian], float],
    slope: Callable[[PortHamiltonian], Real],
    *,
    sectors: Sequence[Sector] = (),
    settings: Settings | None = None,
    taken: Callable[[PortHamiltonian, float], None] = lambda device, value: None,
) -> Outcome:
    """Improve a device by iterated semidefinite programs.

    Parameters
    ----------
    plant : GeneralisedPlant
        Where the H2 norm is taken.
    start : PortHamiltonian
        Scaled device, without spring or inerter beside it (these belong to the plant).
    measure : function of a device
        The figure, recomputed independently; inf where a constraint is broken.
    slope : function of a device
        Derivative of the figure by the entries of (A, B, C, D), stacked.
    sectors : sequence of Sector
        Damping constraints.
    settings : Settings, optional
    taken : function of device and value
        Called after each accepted step.

    Returns
    -------
    Outcome
        Its value is never above that of `start`.
    """
    settings = settings or Settings()
    best, value, radius = start, measure(start), settings.radius
    steps = refused = quiet = 0
    extra = 0.0  # damping ratio asked for beyond the limit, where the linearised limit was overstepped
    again = False  # the last step was refused: the next one does not widen the ball at once
    for _ in range(settings.iterations):
        if radius < settings.smallest_radius or quiet == 2:
            break
        aimed = [replace(sector, damping=sector.damping + extra) for sector in sectors]
        proposal, promised = _step(plant, best, value * slope(best), aimed, radius, settings.solver_iterations)
        new = math.inf if proposal is None else measure(proposal)
        if not new < value:
            overstepped = proposal is not None and math.isinf(new)
            extra = max(2 * extra, OVERSTEP) if overstepped else extra
            radius, refused, again = radius / (2 if overstepped else 4), refused + 1, True
            continue
        extra /= 2
        trust = (value - new) / max(promised, 1e-300)
        quiet = quiet + 1 if value - new <= settings.settled * value else 0
        radius *= 1.0 if again else 2.0 if trust > 0.6 else 1.0 if trust > 0.25 else 0.5
        again = False
        assert proposal is not None
        best, value, steps = proposal, new, steps + 1
        taken(best, value)
    return Outcome(best, value, steps, refused)


def _step(
    plant: GeneralisedPlant,
    device: PortHamiltonian,
    half_slope: Real,
    sectors: Sequence[Sector],
    radius: float,
    solver_iterations: int,
) -> tuple[PortHamiltonian | None, float]:
    """One semidefinite program: a proposal, and the decrease of the figure that it promises.

    `half_slope` is half the derivative of the squared figure by the device's entries.
    """
    form = device.state_space()
    here: Unknowns = {"A": form.A, "B": form.B, "C": form.C, "D": form.D}
    try:
        point = _Point.at(plant, here)
        tangents = [_Tangent.at(sector, here) for sector in sectors]
        slope, curvature = point.second_order(here)
    except (LinAlgError, ValueError):
        return None, 0.0
    n, N = device.order, len(point.A)
    correction = 2 * half_slope - slope

    def objective(u: Unknowns) -> Real:
        return point.trace(u) + _stacked(u) @ correction

    shapes = {
        "A": Shape(n, n),
        "B": Shape(n, 1),
        "C": Shape(1, n),
        "D": Shape(1, 1),
        "X": Shape(N, N, symmetric=True),
        **{f"X{i}": Shape(len(t.A), len(t.A), symmetric=True) for i, t in enumerate(tangents)},
    }
    blocks: list[Callable[[Unknowns], Real]] = [point.h2, _positive_real]
    for i, tangent in enumerate(tangents):
        blocks += [partial(block, name=f"X{i}") for block in (tangent.sector, tangent.above, tangent.below)]
    outcome = semidefinite.minimise(
        shapes,
        objective,
        blocks,
        Ball({name: here[name] for name in DEVICE}, radius, curvature),
        iterations=solver_iterations,
    )
    if outcome.unknowns is None:
        return None, 0.0
    step = _stacked(outcome.unknowns) - _stacked(here)
    before = float(point.trace({"X": point.X}))
    after = float(point.trace(outcome.unknowns) + step @ correction + step @ curvature @ step)
    return _device(outcome.unknowns), math.sqrt(max(before, 0.0)) - math.sqrt(max(after, 0.0))


@dataclass(frozen=True)
class _Point:
    """The closed loop and its observability Gramian X at the current device, where X is near I.

    T takes the plant's coordinates there. X itself is singular to working precision (the output hardly sees a
    long chain of delays), so T comes from the Gramian of an output that sees every state a little.
    """

    plant: GeneralisedPlant
    T: Real
    A: Real
    B: Real
    C: Real
    X: Real

    @classmethod
    def at(cls, plant: GeneralisedPlant, device: Unknowns) -> _Point:
        A, C = plant.closed(*(device[name] for name in DEVICE))
        B = np.vstack([plant.Bw, np.zeros((len(A) - len(plant.A), plant.Bw.shape[1]))])
        seen = C.T @ C
        T = cholesky(solve_continuous_lyapunov(A.T, -(seen + SEEN * np.trace(seen) / len(A) * np.eye(len(A)))))
        A, C = T @ np.linalg.solve(T.T, A.T).T, np.linalg.solve(T.T, C.T).T
        return cls(plant, T, A, T @ B, C, solve_continuous_lyapunov(A.T, -C.T @ C))

    def closed(self, u: Unknowns) -> tuple[Real, Real]:
        """Acl and Ccl of other devices in these coordinates."""
        A, C = self.plant.closed(*(u[name] for name in DEVICE))
        inverse = np.linalg.inv(self.T)
        return self.T @ A @ inverse, C @ inverse

    def trace(self, u: Unknowns) -> Real:
        """trace BwᵀXBw."""
        return np.asarray(np.trace(self.B.T @ u["X"] @ self.B, axis1=-2, axis2=-1))

    def h2(self, u: Unknowns) -> Real:
        """The H2 inequality with X·Acl linearised here."""
        A, C = self.closed(u)
        return inequalities.h2(inequalities.linearised(u["X"], A, self.X, self.A), C)

    def second_order(self, device: Unknowns) -> tuple[Real, Real]:
        """Slope of the trace in the device, and the convex part of the form q of the module's text.

        With dA, dC the change of the closed loop by an entry of the device, the slope is
        2 trace Y (X dA + Cᵀ dC).
        """
        sizes = [device[name].size for name in DEVICE]
        probes = np.split(np.vstack([np.zeros(sum(sizes)), np.eye(sum(sizes))]), np.cumsum(sizes)[:-1], axis=1)
        A, C = self.closed(
            {name: probe.reshape(-1, *device[name].shape) for name, probe in zip(DEVICE, probes, strict=True)}
        )
        dA, dC = A[1:] - A[0], C[1:] - C[0]
        right = self.X @ dA + self.C.T @ dC
        X1 = _lyapunov_batch(self.A, right + right.transpose(0, 2, 1))
        Y = solve_continuous_lyapunov(self.A, -self.B @ self.B.T)
        q = np.einsum("iab,jba->ij", Y @ X1, dA)
        values, vectors = np.linalg.eigh(q + q.T)
        slope = 2 * np.einsum("ab,iba->i", Y, right)
        return slope, np.asarray((vectors * np.clip(values, 0.0, None)) @ vectors.T)


@dataclass(frozen=True)
class _Tangent:
    """A sector inequality at the current device, in coordinates where the current X is I."""

    plant: GeneralisedPlant
    damping: float
    A: Real
    T: Real

    @classmethod
    def at(cls, sector: Sector, device: Unknowns) -> _Tangent:
        A, _ = sector.plant.closed(*(device[name] for name in DEVICE))
        # In real modal coordinates A is block-diagonal and X = I satisfies the inequality.
        values, vectors = np.linalg.eig(A)
        T = np.hstack(
            [
                (v.real[:, None] if w.imag == 0 else np.column_stack([v.real, v.imag]))
                for w, v in zip(values, vectors.T, strict=True)
                if w.imag >= 0
            ]
        )
        return cls(sector.plant, sector.damping, np.linalg.solve(T, A @ T), T)

    def sector(self, u: Unknowns, name: str) -> Real:
        """The sector inequality with X·Acl linearised here."""
        A, _ = self.plant.closed(*(u[part] for part in DEVICE))
        A = np.linalg.solve(self.T, A @ self.T)
        eye = np.eye(len(self.A))
        return inequalities.sector(inequalities.linearised(u[name], A, eye, self.A), self.damping)

    def above(self, u: Unknowns, name: str) -> Real:
        """X ⪰ ½I."""
        return u[name] - np.eye(len(self.A)) / 2

    def below(self, u: Unknowns, name: str) -> Real:
        """X ⪯ 2I: the inequality is homogeneous in X, so a large X would hide what linearising dropped."""
        return 2 * np.eye(len(self.A)) - u[name]


def _device(u: Unknowns) -> PortHamiltonian:
    return factored(StateSpace(u["A"], u["B"], u["C"], u["D"]))


def _stacked(u: Unknowns) -> Real:
    """The device's entries as one vector; leading axes kept."""
    parts = [u[name] for name in DEVICE]
    return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)


def _positive_real(u: Unknowns) -> Real:
    return inequalities.positive_real(*(u[name] for name in DEVICE))


def _lyapunov_batch(A: Real, Q: Real) -> Real:
    """X with AᵀX + XA + Q = 0 for a batch of Q, by diagonalising A once."""
    values, T = np.linalg.eig(A)
    inverse = np.linalg.inv(T)
    X = -(T.T @ Q @ T) / (values[:, None] + values[None, :])
    return np.asarray((inverse.T @ X @ inverse).real)
