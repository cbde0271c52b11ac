"""The method of record: the bilinear matrix inequalities of [PS2006] by iterated semidefinite programs.

    minimise max Σ wᵢ Fᵢ   over the device (A, B, C, D) and one X for each norm Fᵢ,
    subject to   the H2 or H∞ inequality of every norm,  Fⱼ ≤ limits,  PR,  sectors,  k ≤ stiffness,  b ≤ inertance

(:mod:`.lmi`, :mod:`.linearised`). The device is kept in coordinates where P = I, so its PR inequality is
linear and exact; only the products X·Acl and X·Bcl are bilinear. They are linearised at the current point
[HassibiHowBoyd1999] within a ball around the device. A spring beside the device, k/s, is one more entry of Acl; an
inerter b·s is part of the masses, to first order in its change.

The solver only proposes. The matrix that the PR inequality calls positive semidefinite is factored, which
makes the proposal positive real by construction, and `measure` recomputes the figure and the constraints with
exact delays: a proposal that is not better is not taken and the ball shrinks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError

from posreal.admittance import PortHamiltonian, StateSpace
from posreal.admittance.positive_real_lemma import factored, positive_real
from posreal.numerics import sdp
from posreal.numerics.sdp import Affine, Shape, Unknowns
from posreal.synthesis.linearised import LinearisedNorm, NormBound, Sector, stacked

Real = np.ndarray

OVERSTEP = 1e-5  # of a damping ratio or a limit, asked for beyond it once a proposal has missed it


@dataclass(frozen=True)
class Goals:
    """What the inequalities are to achieve, in the scaled device's units.

    Attributes
    ----------
    objective : tuple of sums, each a tuple of (weight, Norm)
        The largest of the weighted sums is minimised: one sum of one norm, a weighted sum, or the worst of several.
    limits : tuple of (Norm, float)
        Upper limits.
    sectors : tuple of Sector
        Damping to be kept.
    stiffness, inertance : float
        The largest spring and inerter beside the device, where there may be one.
    """

    objective: tuple[tuple[tuple[float, LinearisedNorm], ...], ...]
    limits: tuple[tuple[LinearisedNorm, float], ...] = ()
    sectors: tuple[Sector, ...] = ()
    stiffness: float = math.inf
    inertance: float = math.inf


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
    """Where the iteration ended: the best device, its measured value, steps taken and refused, the ball's radius."""

    device: PortHamiltonian
    value: float
    taken: int
    refused: int
    radius: float


def iterate(
    goals: Goals,
    start: PortHamiltonian,
    measure: Callable[[PortHamiltonian], float],
    *,
    spring: bool = False,
    inerter: bool = False,
    settings: Settings | None = None,
    taken: Callable[[PortHamiltonian, float], None] = lambda device, value: None,
) -> Outcome:
    """Improve a device by iterated semidefinite programs.

    Parameters
    ----------
    goals : Goals
    start : PortHamiltonian
        Scaled device.
    measure : function of a device
        The objective, recomputed independently; inf where a constraint is broken.
    spring, inerter : bool
        Whether k and b beside the device may change.
    settings : Settings, optional
    taken : function of device and value
        Called after each accepted step.

    Returns
    -------
    Outcome
        Its value is never above that of `start`.
    """
    settings = settings or Settings()
    beside = ("k",) * spring + ("b",) * inerter
    best, value, radius = start, measure(start), settings.radius
    steps = refused = quiet = 0
    extra = 0.0  # asked for beyond the limits, where one of them was overstepped
    again = False  # the last step was refused: the next one does not widen the ball at once
    for _ in range(settings.iterations):
        if radius < settings.smallest_radius or quiet == 2:
            break
        proposal, promised = _step(goals, best, beside, value, radius, extra, settings.solver_iterations)
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
    return Outcome(best, value, steps, refused, radius)


def _step(
    goals: Goals,
    device: PortHamiltonian,
    beside: Sequence[str],
    value: float,
    radius: float,
    extra: float,
    solver_iterations: int,
) -> tuple[PortHamiltonian | None, float]:
    """One semidefinite program: a proposal, and the decrease of the objective `value` that it promises."""
    try:
        program = program_at(goals, device, beside, value, radius, extra)
    except (LinAlgError, ValueError):
        return None, 0.0
    outcome = sdp.minimise(
        program.shapes, program.objective, program.inequalities, program.cones, iterations=solver_iterations
    )
    if outcome.unknowns is None:
        return None, 0.0
    return device_of(outcome.unknowns), value * (1 - float(outcome.unknowns["t"].item()))


def program_at(
    goals: Goals,
    device: PortHamiltonian,
    beside: Sequence[str] = (),
    value: float = 1.0,
    radius: float = 0.5,
    extra: float = 0.0,
) -> sdp.Program:
    """The inequalities linearised at a device: A, B, C, D (and k, b `beside` it) within a ball, t the bound in `value`.

    Raises
    ------
    LinAlgError, ValueError
        If a Lyapunov or Riccati equation at the device has no solution.
    """
    form, n = device.state_space(), device.order
    here: dict[str, Real] = {"A": form.A, "B": form.B, "C": form.C, "D": form.D}
    shapes = {"A": Shape(n, n), "B": Shape(n, 1), "C": Shape(1, n), "D": Shape(1, 1)}
    blocks = [Affine(tuple(here), _positive_real)]
    for name, most, now in (("k", goals.stiffness, device.k), ("b", goals.inertance, device.b)):
        if name in beside:
            here[name], shapes[name] = np.array([[now]]), Shape(1, 1)
            blocks += _between(name, most)
    cones = [Affine(tuple(here), lambda u: _ball(u, here, radius))]
    shapes["t"] = Shape(1, 1)

    def bound(norm: LinearisedNorm, name: str) -> NormBound:
        found = norm.at(device, here, name)
        shapes.update(found.shapes)
        blocks.append(found.inequality)
        cones.extend(found.cones)
        return found

    for i, parts in enumerate(goals.objective):
        bounds = [(weight, bound(norm, f"{i}_{j}")) for j, (weight, norm) in enumerate(parts)]
        blocks.append(_sum_below(bounds, "t", value))
    for i, (norm, limit) in enumerate(goals.limits):
        blocks.append(_below(bound(norm, f"limit{i}"), limit, extra))
    for i, sector in enumerate(goals.sectors):
        more, inside = replace(sector, damping=sector.damping + extra).at(here, f"sector{i}")
        shapes.update(more)
        blocks.extend(inside)
    return sdp.Program(shapes, Affine(("t",), lambda u: u["t"][..., 0, 0]), blocks, cones)


def _sum_below(bounds: Sequence[tuple[float, NormBound]], name: str, unit: float) -> Affine:
    """Σ wᵢ Fᵢ ≤ t, in units of the current value."""
    of = tuple(dict.fromkeys([*(part for _, bound in bounds for part in bound.of), name]))
    return Affine(of, lambda u: u[name] - sum(w * bound(u)[..., None, None] for w, bound in bounds) / unit)


def _below(bound: NormBound, limit: float, extra: float) -> Affine:
    """F ≤ limit."""
    return Affine(bound.of, lambda u: (1 - extra) - bound(u)[..., None, None] / limit)


def _between(name: str, most: float) -> list[Affine]:
    """0 ≤ k ≤ most, or b."""
    below = [Affine((name,), lambda u: most - u[name])] if math.isfinite(most) else []
    return [Affine((name,), lambda u: u[name]), *below]


def _ball(u: Unknowns, centre: Unknowns, radius: float) -> Real:
    """‖d/size‖ ≤ radius for the device's entries less the current ones.

    The size of an entry is its value, 1 at least, so that one that wants to grow beyond all bounds grows by a factor a
    step, not by an amount.
    """
    middle = stacked(centre)
    d = (stacked({name: u[name] for name in centre}) - middle) / np.maximum(1.0, np.abs(middle))
    return np.concatenate([np.full((*d.shape[:-1], 1), radius), d], axis=-1)


def device_of(u: Unknowns) -> PortHamiltonian:
    """The device that the unknowns are, made passive to the last digit."""
    beside = [max(float(np.sum(u.get(name, 0.0))), 0.0) for name in ("k", "b")]
    return factored(StateSpace(u["A"], u["B"], u["C"], u["D"], *beside))


def _positive_real(u: Unknowns) -> Real:
    return positive_real(u["A"], u["B"], u["C"], u["D"])
