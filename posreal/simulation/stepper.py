"""A vehicle with its struts, step by step: linear but for the forces of the elements' laws.

The plant ẋ = A x + Bw w + Bf f and its struts (:mod:`.strut`) by one implicit midpoint rule of step h are

    y⁺ = Φ y + Γ w̄ + Λ λ,      z̄ = … ,      v̄ = C y + D w̄ − W λ

with y the plant's states and each element's elongation and velocity, λ the laws' forces and v̄ their elements'
velocities. W is symmetric and not negative, so that λ is found one law at a time (Gauss–Seidel), each exactly
(:mod:`.laws`), until nothing changes. Many records of track are stepped side by side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.errors import BadInput, Infeasible
from posreal.network import Network
from posreal.plant.mounting import Copy
from posreal.plant.plant import Plant
from posreal.simulation.laws import ElementLaw
from posreal.simulation.strut import Companion, companion

Real = np.ndarray
SWEEPS = 100
SETTLED = 1e-8  # of the largest force


@dataclass(frozen=True)
class History:
    """What a run gives, at the middle of every step.

    Attributes
    ----------
    step : s
    outputs : (N, R, outputs)
    force : (N, R, devices) N, of each strut
    law : (N, R, laws) N
    velocity : (N, R, laws) m/s, of the laws' elements
    elongation : (R, laws) m, the largest of the laws' elements
    """

    step: float
    outputs: Real
    force: Real
    law: Real
    velocity: Real
    elongation: Real


@dataclass(frozen=True)
class Stepper:
    """The matrices of the module's text; build it by :func:`stepper`.

    Attributes
    ----------
    step : s
    big : (states + channels, states + laws + outputs + devices)
        What states and w̄ give: the states, the laws' velocities, outputs and strut forces.
    by_law : (laws, the same columns)
        What the laws' forces add.
    give : (laws, laws)
        W.
    laws : of every device in turn
    elongations : column of each law's elongation among the states
    """

    step: float
    big: Real
    by_law: Real
    give: Real
    laws: tuple[ElementLaw, ...]
    elongations: tuple[int, ...]
    states: int
    outputs: int
    devices: int
    labels: tuple[tuple[int, str], ...] = field(default=())

    def run(self, w: Real) -> History:
        """Step through the channels' velocities `w` (N, R, channels), from rest.

        Raises
        ------
        Infeasible
            If the motion grows without bound, or the forces of the laws are not found.
        """
        steps, records, _ = w.shape
        ny, nl, nz, nd = self.states, len(self.laws), self.outputs, self.devices
        z, force = np.empty((steps, records, nz)), np.empty((steps, records, nd))
        law, velocity = np.zeros((steps, records, nl)), np.zeros((steps, records, nl))
        longest = np.zeros((records, nl))
        now = np.zeros((records, ny + w.shape[2]))
        forces = np.zeros((records, nl))
        for n in range(steps):
            now[:, ny:] = w[n]
            out = now @ self.big
            if nl:
                lengths = now[:, list(self.elongations)]
                forces = self._forces(out[:, ny : ny + nl], lengths, forces)
                out += forces @ self.by_law
                law[n], velocity[n] = forces, out[:, ny : ny + nl]
                np.maximum(longest, np.abs(lengths), out=longest)
            now[:, :ny] = out[:, :ny]
            z[n], force[n] = out[:, ny + nl : ny + nl + nz], out[:, ny + nl + nz :]
        if not np.all(np.isfinite(now)):
            raise Infeasible("the vehicle is not stable with this device: its motion grows without bound")
        return History(self.step, z, force, law, velocity, longest)

    @cached_property
    def _alike(self) -> list[tuple[ElementLaw, slice]]:
        """One element in every strut, together."""
        elements = dict.fromkeys(name for _, name in self.labels)
        each = max(len(elements), 1)
        return [(self.laws[j], slice(j, None, each)) for j in range(len(elements))]  # a strut's elements in turn

    def _forces(self, free: Real, lengths: Real, start: Real) -> Real:
        """λ: the same element of every strut at once, which hardly feel each other within a step, or one by one."""
        forces, own = start.copy(), np.diag(self.give)
        single = [(law, slice(j, j + 1)) for j, law in enumerate(self.laws)]
        for sweep in range(2 * SWEEPS):
            before = forces.copy()
            for law, at in self._alike if sweep < SWEEPS else single:
                alone = free[:, at] - forces @ self.give[:, at] + own[at] * forces[:, at]
                forces[:, at] = law.force(alone, lengths[:, at], own[at], self.step)
            if len(self.laws) == 1 or np.abs(forces - before).max() <= SETTLED * max(np.abs(forces).max(), 1e-300):
                return forces
        raise Infeasible("the forces of friction, play and stops do not settle; take a smaller step")


def beside(plant: Plant, admittance: Rational | None) -> Plant:
    """The plant with an admittance beside what will stand in every port.

    Raises
    ------
    BadInput
        If it has inertance, which acts on what stands beside it.
    """
    if admittance is None or admittance.is_zero():
        return plant
    form, ports, n = state_space(admittance), len(plant.groups), len(plant.A)
    if form.b:
        raise BadInput("an inerter beside the strut cannot be simulated as a part of the vehicle")
    each, total = form.order, n + ports * form.order
    A, force = np.zeros((total, total)), np.zeros((ports, total))
    A[:n, :n] = plant.A
    force[:, :n] = form.k * plant.Cd + float(form.D[0, 0]) * plant.Cv
    for p in range(ports):
        here = slice(n + p * each, n + (p + 1) * each)
        A[here, here], A[here, :n], force[p, here] = form.A, np.outer(form.B[:, 0], plant.Cv[p]), form.C[0]
    A[:n] += plant.Bf @ force
    rest = np.zeros((total - n, 1))

    def wider(rows: Real) -> Real:
        return np.hstack([rows, np.zeros((len(rows), total - n))])

    return replace(
        plant,
        A=A,
        Bw=np.vstack([plant.Bw, rest * np.zeros(plant.Bw.shape[1])]),
        Bf=np.vstack([plant.Bf, rest * np.zeros(ports)]),
        Cz=wider(plant.Cz) + plant.Dzf @ force,
        Cd=wider(plant.Cd),
        Cv=wider(plant.Cv),
    )


def stepper(
    plant: Plant, network: Network | None, copies: Sequence[Copy], laws: Mapping[str, ElementLaw], step: float
) -> Stepper:
    """A plant with a strut in each place, ready to be stepped.

    Parameters
    ----------
    plant : Plant
        What stands beside the struts in it.
    network : Network or None
        Of each strut.
    copies : how the struts sit in the ports
    laws : mapping of element to ElementLaw
        The same in every strut.
    step : float
        s.
    """
    n, m, h = len(plant.A), plant.Bw.shape[1], step
    one = companion(network, h) if network is not None else None
    count, E = (len(copies), len(one.names)) if one is not None else (0, 0)
    ny = n + 2 * count * E  # the plant's states; per device elongations, then velocities, of its elements
    T = np.array([copy.rows for copy in copies]).reshape(len(copies), -1).T[:, :count]  # (ports, devices)
    many = np.array([float(copy.count) for copy in copies])[:count]
    middle = np.linalg.inv(np.eye(n) - h / 2 * plant.A)

    # every quantity as a row on (y, w̄ | one force beside each element)
    def rows(size: int) -> Real:
        return np.zeros((size, ny + m + count * E))

    known = rows(count * E)  # r + λ
    if one is not None:
        for d in range(count):
            for j, (letter, value) in enumerate(zip(one.letters, one.values, strict=True)):
                i, elongation, speed = d * E + j, n + 2 * d * E + j, n + (2 * d + 1) * E + j
                if letter == "k":
                    known[i, elongation] = value
                elif letter == "b":
                    known[i, speed] = -2 * value / h
                known[i, ny + m + i] = 1.0
    state = rows(n)  # x̄ without port forces
    state[:, :n], state[:, ny : ny + m] = middle, h / 2 * middle @ plant.Bw
    port = h / 2 * middle @ plant.Bf @ (T * many)  # x̄ by the struts' forces, (n, devices)
    seen = T.T @ plant.Cv
    total, velocities = np.zeros((count, state.shape[1])), known[:0]
    if one is not None:
        N = np.kron(np.eye(count), one.terminal)
        K = np.linalg.inv(np.eye(count) - (seen @ port) * one.conductance)
        between = K @ (seen @ state + seen @ port @ N @ known)
        total = one.conductance * between + N @ known
        inner = np.kron(np.eye(count), one.inner)
        velocities = N.T @ between + inner @ known
    state = state + port @ total
    out = rows(ny)
    out[:n] = 2 * state
    out[:n, :n] -= np.eye(n)
    for d in range(count):
        e, u = slice(n + 2 * d * E, n + (2 * d + 1) * E), slice(n + (2 * d + 1) * E, n + (2 * d + 2) * E)
        own = velocities[d * E : (d + 1) * E]
        out[e], out[u] = h * own, 2 * own
        out[e, e] += np.eye(E)
        out[u, u] -= np.eye(E)
    z = plant.Cz @ state + plant.Dzf @ (T * many) @ total
    z[:, ny : ny + m] += plant.Dzw
    picked = [(d, j) for d in range(count) for j, name in enumerate(_names(one)) if name in laws]
    at = [d * E + j for d, j in picked]
    everything = np.vstack([out, velocities[at], z, total])
    columns = [ny + m + i for i in at]
    return Stepper(
        step=h,
        big=np.ascontiguousarray(everything[:, : ny + m].T),
        by_law=np.ascontiguousarray(everything[:, columns].T),
        give=-velocities[np.ix_(at, columns)],
        laws=tuple(laws[_names(one)[j]] for _, j in picked),
        elongations=tuple(n + 2 * d * E + j for d, j in picked),
        states=ny,
        outputs=len(plant.outputs),
        devices=count,
        labels=tuple((d, _names(one)[j]) for d, j in picked),
    )


def _names(one: Companion | None) -> tuple[str, ...]:
    return () if one is None else one.names
