"""Mean-square metrics as smooth functions of the device's values on a frequency grid.

J = √(S Σₖ wₖ |zₖ|²) with z = z(Y) from the port (:class:`posreal.plant.plant.PortResponses`), so

    dJ = Re Σₖ gₖ dYₖ,      gₖ = (S wₖ/J) z̄ₖ ∂zₖ/∂Yₖ

and any parametrisation of the device chains onto that by dY/dθ: element values, state-space matrices.

|z|² is as narrow about a pole −σ + jω of the closed loop as σ. A rule whose panels grow by a factor of three from σ on
either side of ω sees it to nine digits, however light it is; but the poles are the device's, so a search looks again
at the poles of what it has found, and goes on from there on a grid that is right for it (:func:`modes`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.errors import BadInput
from posreal.metric import Norm, PeakInTime
from posreal.plant import hinf_norm, quadrature
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant, PortResponses, close
from posreal.plant.sampled import SampledDensity
from posreal.specification.problem import Problem
from posreal.vehicle import Vehicle

Complex = np.ndarray
Modes = tuple[tuple[float, float], ...]
"""Frequency ω and decay rate σ of poles −σ ± jω, rad/s."""

SETTLED = 1e-8  # relative change of a figure on a grid made for its own closed loop that counts as none
NARROW = 0.02  # damping ratio of a mode that 48 panels a decade may not see
_LIGHT = 0.04  # damping ratio of a resonance that 12 panels a decade see to a thousandth of its mean square
_BROAD = 0.3  # damping ratio of a mode that any panel sees to rounding
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_PANELS = 12  # a decade of grids that are no coarse ones
_RIPPLE_COARSE = 10.0  # the same for a coarse grid: 1e-5
_FAR = 1000.0  # middle frequencies, beyond which a band limited in wavelengths is not followed
_RIPPLE = 100.0  # middle frequencies, to which delays are followed: beyond is 1e-6 of the side view's mean square


@dataclass(frozen=True)
class MeanSquare:
    """One mean-square metric of one vehicle.

    Attributes
    ----------
    rule : Quadrature
        The grid, `rule.omega` in rad/s.
    port : PortResponses
        The vehicle on that grid.
    scale : float
        J² = scale · Σ weight |z|², in the metric's unit squared.
    squares : tuple of float
        Share of each pair of an output and a process in the weight.
    """

    rule: quadrature.Quadrature
    port: PortResponses
    scale: float
    squares: tuple[float, ...] = (1.0,)

    @cached_property
    def weight(self) -> np.ndarray:
        """Of |z|² in every row of the port."""
        return np.outer(self.squares, self.rule.weight).ravel()

    @property
    def s(self) -> Complex:
        """The points jω."""
        return 1j * self.rule.omega

    def value_and_slopes(self, Y: Mapping[str, Complex]) -> tuple[float, dict[str, Complex]]:
        """J and, for each port group, g with dJ = Re Σ g dY, for admittances `Y` on the grid."""
        z, dz = self.port.closed(Y)
        J = math.sqrt(self.scale * float(self.weight @ np.abs(z) ** 2))
        back = (self.scale / J) * self.weight * z.conj()
        return J, {group: self.port.over_grid(back * slope) for group, slope in dz.items()}

    def of_device(self, Y: Complex, mounting: Mounting) -> tuple[float, Complex]:
        """J and dJ/dY for a device `Y` (values on the grid) in its mounting, with nothing else free."""
        port, inner = mounting.response(Y, self.s)
        J, slopes = self.value_and_slopes({"secondary": port})
        return J, slopes["secondary"] * inner


def opened(problem: Problem) -> bool:
    """Whether a free vehicle parameter stands in other ports than the device."""
    return any(problem.vehicle.free[name][0] != "secondary" for name in problem.free)


def modes(problem: Problem, port: Rational) -> Modes:
    """The modes of the vehicle closed with `port` that a grid may not see, at every operating point.

    Parameters
    ----------
    problem : Problem
        With the vehicle as designed.
    port : Rational
        The whole admittance in its port.
    """
    found = _modes(problem, port)
    for point, changed in zip(problem.at_points.values(), problem.points, strict=True):
        found |= _modes(point, problem.port_at(point, port, changed))
    return tuple(sorted(found))


def _modes(problem: Problem, port: Rational) -> set[tuple[float, float]]:
    poles = close(problem.plant, {"secondary": state_space(port)}, shaped=False).poles()
    poles = poles[(poles.imag > 0) & (-poles.real < _BROAD * np.abs(poles))]
    return {(float(p.imag), float(max(-p.real, 1e-9 * p.imag))) for p in poles}


def narrow(found: Modes) -> bool:
    """Whether a mode is so narrow that panels as wide as any may have missed it."""
    return any(sigma < NARROW * omega for omega, sigma in found)


def has_light_modes(problem: Problem) -> bool:
    """Whether the open plant's own modes are so light that a coarse grid may not see the closed one's."""
    return problem.place.carried == 0 and hinf_norm.least_damping(problem.plant) < NARROW


def beside(found: Modes) -> np.ndarray:
    """Frequencies at which modes are seen: ω ± σ 3ᵏ, to half of ω."""
    return np.unique(
        [
            omega + sign * sigma * 3.0**k
            for omega, sigma in found
            for k in range(max(1, math.ceil(math.log(0.5 * omega / sigma, 3))))
            for sign in (-1, 0, 1)
        ]
    )


def graded(rule: quadrature.Quadrature, found: Modes, corners: Sequence[float] = ()) -> quadrature.Quadrature:
    """A Gauss rule with its panels cut beside modes, and where an input's density has corners, rad/s."""
    if not found and not corners:
        return rule
    omega, weight = rule.omega.reshape(-1, len(_NODES)), rule.weight.reshape(-1, len(_NODES))
    inner = omega[:, 0] < omega[:, -1]  # not the panel that goes on to infinity, whose nodes descend
    half, middle = weight[inner].sum(axis=1) / 2, omega[inner].mean(axis=1)
    low, high = middle - half, float((middle + half)[-1])
    cuts = np.concatenate([beside(found), corners])
    edge = np.unique(np.concatenate([low, cuts[(cuts > low[0]) & (cuts < high)], [high]]))
    half, middle = np.diff(edge) / 2, (edge[1:] + edge[:-1]) / 2
    return quadrature.Quadrature(
        np.concatenate([(middle[:, None] + half[:, None] * _NODES).ravel(), omega[~inner].ravel()]),
        np.concatenate([(half[:, None] * _WEIGHTS).ravel(), weight[~inner].ravel()]),
    )


def mean_square(problem: Problem, *, primary_open: bool = False, panels: int = 12, light: Modes = ()) -> MeanSquare:
    """The problem's mean-square objective, or the vehicle's ride where the objective is a peak in time.

    Macc, the largest over all speeds, is taken at the highest. ``J1z_…`` to 20 Hz and ``Macc``/``J1y`` on the paper's
    band by a Gauss rule; the others, ``J1z_…_whole`` among them, on the whole axis. The norm of several figures of one
    vehicle is a mean square too.

    Parameters
    ----------
    problem : Problem
    primary_open : bool
        Leave the primary lateral suspension of the plan view open as port group ``primary``.
    panels : int
        Panels a decade of the Gauss rule; results are always re-measured by the metrics' own quadrature.
    light : Modes
        Of the closed loop, beside which panels are cut.

    Raises
    ------
    BadInput
        If the objective is no mean square.
    """
    name = problem.objective
    if problem.goal is None and (metric := problem.vehicle.metrics.get(name)) is not None and metric.norm() is None:
        name = problem.vehicle.ride
    norm = problem.goal is not None and problem.goal.kind == "norm"
    parts = problem.goal.parts if norm and problem.goal is not None else ((name, 1.0),)
    return _mean_square(problem.vehicle, tuple(parts), primary_open, panels, light)


@lru_cache(maxsize=128)
def _mean_square(
    vehicle: Vehicle, parts: tuple[tuple[str, float], ...], primary_open: bool, panels: int, light: Modes
) -> MeanSquare:
    norms = [norm_of(vehicle, name, "H2") for name, _ in parts]
    first = norms[0]
    there = vehicle if first.speed is None else vehicle.at(first.speed)
    plant = there.plant(first.load, opened=primary_open)
    if vehicle.places["secondary"].carried == 0:  # a structure, whose own light modes a device may leave light
        panels = round(panels * min(4.0, max(1.0, _LIGHT / hinf_norm.least_damping(plant))))
    rule = graded(search_rule(plant, first, panels), light, _corners(plant))
    port = plant.responses(rule.omega, *(norm.output for norm in norms))
    units = [weight * norm.factor(vehicle) for (_, weight), norm in zip(parts, norms, strict=True)]
    return MeanSquare(rule, port, plant.density, tuple(unit**2 * share for unit in units for share in plant.shares))


def _corners(plant: Plant) -> tuple[float, ...]:
    return plant.shaping.corners if isinstance(plant.shaping, SampledDensity) else ()


def norms(vehicle: Vehicle, kind: str) -> list[tuple[str, Norm]]:
    """The metrics of a vehicle that are system norms of a kind."""
    found = ((name, metric.norm()) for name, metric in vehicle.metrics.items())
    return [(name, norm) for name, norm in found if norm is not None and norm.kind == kind]


def norm_of(vehicle: Vehicle, name: str, *kinds: str) -> Norm:
    """The system norm that a metric is.

    Raises
    ------
    BadInput
        If it is none of `kinds`.
    """
    metric = vehicle.metrics.get(name)
    norm = None if metric is None else metric.norm()
    if norm is None or norm.kind not in kinds:
        words = {"H2": "a root mean square", "H∞": "a largest gain"}
        peak = " (a peak in time)" if isinstance(metric, PeakInTime) else ""
        wanted = " or ".join(words[kind] for kind in kinds)
        raise BadInput(f"{name}{peak} is not {wanted} of the {vehicle.name} vehicle")
    return norm


def search_rule(plant: Plant, norm: Norm, panels: int) -> quadrature.Quadrature:
    """The grid of a search for a root mean square: panels a decade up to where it ends, or over the whole axis."""
    latest, middle = float(plant.delays.max()), hinf_norm.middle(plant)
    start, stop = norm.start, norm.stop
    if isinstance(plant.shaping, SampledDensity) and plant.shaping.ends:
        start, stop = max(start, plant.shaping.start), min(stop, plant.shaping.stop, _FAR * middle)
    if not math.isinf(stop):
        return quadrature.gauss(latest, start=start, stop=stop, per_decade=panels)
    ripple = _RIPPLE if panels >= _PANELS else _RIPPLE_COARSE
    return quadrature.whole_line(middle, longest_delay=latest, ripple=ripple * middle, per_decade=panels)
