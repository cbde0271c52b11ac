"""A vehicle cut open where the devices go, and closed again around them.

    ẋ = A x + Σᵢ Bwᵢ w(t − τᵢ) + Bf f
    z = Cz x + Σᵢ Dzwᵢ w(t − τᵢ) + Dzf f
    d = Cd x,   v = ḋ = Cv x,   fₚ = Y vₚ at every port p

One scalar process w reaches the vehicle through several channels, each late by its own delay (front and
rear wheels on the same track). Other plants are shaken by several processes that know nothing of each other (ground
and wind), each through channels of its own; their mean squares add. At port p the device Y sees the relative
displacement dₚ and velocity vₚ and answers with the force fₚ. Several ports may hold copies of the same device;
`groups` names the device at each port. In the frequency domain (:class:`PortResponses`) this is a linear-fractional
map in Y.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

from posreal.admittance.state_space import StateSpace
from posreal.errors import BadInput
from posreal.plant.sampled import SampledDensity
from posreal.plant.shaping_filter import ShapingFilter

if TYPE_CHECKING:
    from posreal.plant.quadrature import Quadrature

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True)
class Plant:
    """A linear vehicle with ports for devices; see the module's equations.

    Attributes
    ----------
    A : (n, n), Bw : (n, m), Bf : (n, p), Cz : (q, n), Dzw : (q, m), Dzf : (q, p), Cd, Cv : (p, n)
        The matrices of the module's equations, SI units.
    delays : (m,)
        Delay τᵢ of each disturbance channel, seconds.
    outputs : tuple of str
        Name of each entry of z.
    groups : tuple of str
        Which device stands at each port.
    shaping : ShapingFilter, SampledDensity or None
        What makes w out of a white process; None where w itself is white. A sampled density goes by frequency only.
    density : float
        Single-sided spectral density of the white process, per rad/s.
    processes : tuple of int
        Which process drives each channel, counted from 0; empty where one drives all.
    shares : tuple of float
        Density of each process, in units of `density`.
    """

    A: Real
    Bw: Real
    Bf: Real
    Cz: Real
    Dzw: Real
    Dzf: Real
    Cd: Real
    Cv: Real
    delays: Real
    outputs: tuple[str, ...]
    groups: tuple[str, ...]
    shaping: ShapingFilter | SampledDensity | None = None
    density: float = 1.0
    processes: tuple[int, ...] = ()
    shares: tuple[float, ...] = (1.0,)
    _kept: dict[Any, PortResponses] = field(default_factory=dict, init=False, repr=False, compare=False)

    def output(self, name: str) -> int:
        """Index of output `name` in z."""
        return self.outputs.index(name)

    @property
    def rational(self) -> Plant:
        """The same plant with a filter in place of a sampled density, for what needs one; see there how near it is."""
        if not isinstance(self.shaping, SampledDensity):
            return self
        near = self.shaping.rational
        if len(near.A):
            return replace(self, shaping=near)
        return replace(self, shaping=None, density=self.density * float(near.D[0, 0]) ** 2)

    def kept_responses(self, rule: Quadrature, output: str) -> PortResponses:
        """Responses on a rule's grid, computed once: for rules that every device is measured on."""
        if (rule, output) not in self._kept:
            self._kept[rule, output] = self.responses(rule.omega, output)
        return self._kept[rule, output]

    def responses(self, omega: Real, *outputs: str) -> PortResponses:
        """Responses of outputs and of all ports on the grid `omega` (rad/s), delays and shaping exact.

        Several outputs or processes follow each other: all of the grid for the first output and the first process.
        """
        return self.responses_at(1j * np.asarray(omega), *outputs)

    def responses_at(self, s: Complex, *outputs: str) -> PortResponses:
        """The same at any complex points `s` (N,), such as a line to the right of the poles."""
        n, count = len(self.A), len(self.shares)
        late = np.exp(-np.multiply.outer(s, self.delays))
        if self.shaping is not None:
            late *= self.shaping(s)[:, None]
        forcing = np.empty((len(s), n, count + len(self.groups)), dtype=complex)
        for i, driven in enumerate(channels(self)):
            forcing[:, :, i] = late[:, driven] @ self.Bw[:, driven].T
        forcing[:, :, count:] = self.Bf
        x = np.linalg.solve(s[:, None, None] * np.eye(n) - self.A, forcing)
        v = self.Cv @ x
        Tzw, Tzf, Pvw = [], [], []
        for j in map(self.output, outputs):
            z = self.Cz[j] @ x
            for i, driven in enumerate(channels(self)):
                Tzw.append(z[:, i] + late[:, driven] @ self.Dzw[j, driven])
                Tzf.append(z[:, count:] + self.Dzf[j])
                Pvw.append(v[:, :, i])
        return PortResponses(
            omega=s.imag,
            Tzw=np.concatenate(Tzw),
            Tzf=np.concatenate(Tzf),
            Pvw=np.concatenate(Pvw),
            Pvf=np.tile(-v[:, :, count:], (len(Tzw), 1, 1)),
            groups=self.groups,
        )


@dataclass(frozen=True)
class PortResponses:
    """z = Tzw w + Tzf f and v = Pvw w − Pvf f on a frequency grid, one disturbance w, one output z.

    Of r pairs of an output and a process each has its own grid's worth of rows, M = r N in all.

    Attributes
    ----------
    omega : (N,) rad/s
    Tzw : (M,), Tzf : (M, p), Pvw : (M, p), Pvf : (M, p, p)
    groups : which device stands at each of the p ports
    """

    omega: Real
    Tzw: Complex
    Tzf: Complex
    Pvw: Complex
    Pvf: Complex
    groups: tuple[str, ...]
    _decoupled: bool = field(init=False)

    def __post_init__(self) -> None:
        size = np.abs(self.Pvf)
        off = size.copy()
        ports = np.arange(size.shape[1])
        off[:, ports, ports] = 0.0
        # Ports that do not feel each other (bounce and pitch of a symmetric vehicle) need no matrix inverse.
        object.__setattr__(self, "_decoupled", bool(np.all(off.max(axis=(1, 2)) <= 1e-9 * size.max(axis=(1, 2)))))

    def closed(self, Y: Mapping[str, Complex]) -> tuple[Complex, dict[str, Complex]]:
        """Close the ports with devices and differentiate.

        Parameters
        ----------
        Y : mapping of group name to (N,) complex admittance on the grid

        Returns
        -------
        z : (M,) complex, response of the output to w
        dz : mapping of group name to (M,) complex, ∂z/∂Y: with V = (I + Pvf Y)⁻¹ Pvw the velocities and
            t = Tzf (I + Y Pvf)⁻¹ the force sensitivities of the closed vehicle, ∂z/∂Y is Σ tₚ Vₚ over the
            ports that hold the device
        """
        pairs = len(self.Tzw) // len(self.omega)
        y: Complex = np.stack([np.tile(Y[group], pairs) for group in self.groups], axis=1)
        if self._decoupled:
            ports = np.arange(len(self.groups))
            inverse = 1.0 / (1.0 + self.Pvf[:, ports, ports] * y)
            v: Complex = inverse * self.Pvw
            t: Complex = inverse * self.Tzf
        else:
            loop = np.eye(y.shape[1]) + self.Pvf * y[:, None, :]
            v = np.linalg.solve(loop, self.Pvw[:, :, None])[:, :, 0]
            back = np.eye(y.shape[1]) + y[:, :, None] * self.Pvf
            t = np.linalg.solve(np.swapaxes(back, 1, 2), self.Tzf[:, :, None])[:, :, 0]
        z = self.Tzw + np.sum(self.Tzf * y * v, axis=1)
        dz: dict[str, Complex] = {}
        for port, group in enumerate(self.groups):
            dz[group] = dz.get(group, 0.0) + t[:, port] * v[:, port]
        return z, dz

    def over_grid(self, rows: Complex) -> Complex:
        """What belongs to the same frequency added up: (…, M) to (…, N)."""
        return rows.reshape(*rows.shape[:-1], -1, len(self.omega)).sum(axis=-2)


@dataclass(frozen=True)
class ClosedLoop:
    """ẋ = A x + Σᵢ Bᵢ w(t − τᵢ), z = C x + Σᵢ Dᵢ w(t − τᵢ): a vehicle with its devices in place."""

    A: Real
    B: Real
    C: Real
    D: Real
    delays: Real
    outputs: tuple[str, ...]
    density: float = 1.0
    processes: tuple[int, ...] = ()
    shares: tuple[float, ...] = (1.0,)

    def poles(self) -> Complex:
        """Eigenvalues of A, rad/s."""
        return np.linalg.eigvals(self.A).astype(complex)

    def balanced(self) -> ClosedLoop:
        """The same loop in coordinates in which A is balanced (by powers of 2, so that nothing rounds)."""
        if not len(self.A):
            return self
        A, (scale, _) = matrix_balance(self.A, permute=False, separate=True)
        return replace(self, A=A, B=self.B / scale[:, None], C=self.C * scale)

    def output(self, name: str) -> int:
        """Index of output `name` in z."""
        return self.outputs.index(name)

    def response(self, omega: Real, output: str, process: int = 0) -> Complex:
        """z/w on the grid by a matrix solve per frequency, delays exact (the slow, plain way)."""
        j, n = self.output(output), len(self.A)
        s = 1j * omega
        driven = channels(self)[process]
        late = np.exp(-np.multiply.outer(s, self.delays[driven]))
        x = np.linalg.solve(s[:, None, None] * np.eye(n) - self.A, (late @ self.B[:, driven].T)[:, :, None])
        return (self.C[j] @ x)[:, 0] + late @ self.D[j, driven]


def absorbed(plant: Plant, devices: Mapping[str, StateSpace], *, group: str) -> Plant:
    """The plant with the devices of all other groups in place; its own ports are called `group` from then on.

    Parameters
    ----------
    plant : Plant
    devices : mapping of group name to StateSpace
        Of every group but one; without inertance, which would act on what the others answer.
    group : str
    """
    inner = [p for p, name in enumerate(plant.groups) if name in devices]
    rest = [p for p, name in enumerate(plant.groups) if name not in devices]
    parts = [devices[plant.groups[p]] for p in inner]
    if any(part.b for part in parts):
        raise BadInput("a device with inertance cannot be absorbed in a plant")
    n, orders = len(plant.A), [part.order for part in parts]
    total = n + sum(orders)
    force, A = np.zeros((len(inner), total)), np.zeros((total, total))
    A[:n, :n] = plant.A
    at = n
    for row, (p, part) in enumerate(zip(inner, parts, strict=True)):
        here = slice(at, at := at + part.order)
        force[row, :n] = part.k * plant.Cd[p] + float(part.D[0, 0]) * plant.Cv[p]
        force[row, here] = part.C[0]
        A[here, here] = part.A
        A[here, :n] = np.outer(part.B[:, 0], plant.Cv[p])
    A[:n] += plant.Bf[:, inner] @ force

    def wider(rows: Real) -> Real:
        return np.hstack([rows, np.zeros((len(rows), total - n))])

    return replace(
        plant,
        A=A,
        Bw=np.vstack([plant.Bw, np.zeros((total - n, plant.Bw.shape[1]))]),
        Bf=np.vstack([plant.Bf[:, rest], np.zeros((total - n, len(rest)))]),
        Cz=wider(plant.Cz) + plant.Dzf[:, inner] @ force,
        Dzf=plant.Dzf[:, rest],
        Cd=wider(plant.Cd[rest]),
        Cv=wider(plant.Cv[rest]),
        groups=(group,) * len(rest),
    )


def channels(plant: Plant | ClosedLoop) -> list[list[int]]:
    """For each process, the channels that it drives."""
    processes = plant.processes or (0,) * len(plant.delays)
    return [[i for i, one in enumerate(processes) if one == process] for process in range(len(plant.shares))]


def close(plant: Plant, devices: Mapping[str, StateSpace], *, shaped: bool = True) -> ClosedLoop:
    """Put a device into every port and eliminate the port forces.

    A device is f = k d + C_k ξ + D_k v + b v̇, ξ̇ = A_k ξ + B_k v. Its spring k acts on the displacement that the
    plant already has as a state, so no copy of that state (and no spurious pole at 0) arises; its inertance b
    acts on v̇ = Cv ẋ, which gives the linear equation (I − b Cv Bf) f = … at each instant.

    Parameters
    ----------
    plant : Plant
    devices : mapping of group name to StateSpace
    shaped : bool
        Whether the shaping filter's states are put in front, so that the input is the white process itself.

    Returns
    -------
    ClosedLoop
        With states ordered as (vehicle, device at port 0, device at port 1, …, shaping filter), without those that
        nothing reads: the displacement of a port, say, if no spring stands in it, which drifts and is nobody's concern.
    """
    n, m = plant.Bw.shape
    kept = [devices[group] for group in plant.groups]
    orders = [len(device.A) for device in kept]
    starts = n + np.concatenate(([0], np.cumsum(orders)))
    total = int(starts[-1])
    k = np.array([device.k for device in kept])
    b = np.array([device.b for device in kept])
    D = np.array([device.D for device in kept], dtype=float).reshape(-1)

    # port forces as a linear map of the whole state and of w, before the inerters' algebraic loop is solved
    Fx: Real = np.zeros((len(kept), total))
    Fx[:, :n] = k[:, None] * plant.Cd + D[:, None] * plant.Cv + b[:, None] * (plant.Cv @ plant.A)
    for p, device in enumerate(kept):
        Fx[p, starts[p] : starts[p + 1]] = np.reshape(device.C, -1)
    Fw: Real = b[:, None] * (plant.Cv @ plant.Bw)
    loop = np.eye(len(kept)) - b[:, None] * (plant.Cv @ plant.Bf)
    Fx, Fw = np.linalg.solve(loop, Fx), np.linalg.solve(loop, Fw)

    A = np.zeros((total, total))
    A[:n, :n] = plant.A
    A[:n] += plant.Bf @ Fx
    for p, device in enumerate(kept):
        rows = slice(starts[p], starts[p + 1])
        A[rows, rows] = device.A
        A[rows, :n] = np.outer(np.reshape(device.B, -1), plant.Cv[p])
    B = np.zeros((total, m))
    B[:n] = plant.Bw + plant.Bf @ Fw
    C = np.zeros((len(plant.outputs), total))
    C[:, :n] = plant.Cz
    C += plant.Dzf @ Fx
    Dw = plant.Dzw + plant.Dzf @ Fw
    while not np.all(read := A.any(axis=0) | C.any(axis=0)):
        A, B, C = A[np.ix_(read, read)], B[read], C[:, read]
    about = (plant.delays, plant.outputs, plant.density, plant.processes, plant.shares)
    loop_closed = ClosedLoop(A, B, C, Dw, *about)
    if plant.shaping is None or not shaped:
        return loop_closed
    return _shaped(loop_closed, plant.shaping.rational)


def _shaped(loop: ClosedLoop, H: ShapingFilter) -> ClosedLoop:
    """Put one copy of the shaping filter before each delay-free channel (delays commute with the filter)."""
    n, m = loop.B.shape
    h = len(H.A)
    A = np.zeros((n + m * h, n + m * h))
    B = np.zeros((n + m * h, m))
    C = np.zeros((len(loop.outputs), n + m * h))
    A[:n, :n], C[:, :n] = loop.A, loop.C
    for i in range(m):
        rows = slice(n + i * h, n + (i + 1) * h)
        A[rows, rows] = H.A
        A[:n, rows] = np.outer(loop.B[:, i], H.C[0])
        B[rows, i] = H.B[:, 0]
        C[:, rows] = np.outer(loop.D[:, i], H.C[0])
    B[:n] = loop.B * H.D[0, 0]
    about = (loop.delays, loop.outputs, loop.density, loop.processes, loop.shares)
    return ClosedLoop(A, B, C, loop.D * H.D[0, 0], *about)
