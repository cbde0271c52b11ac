"""Figures of a closed vehicle that a search may minimise or limit, each with its exact slope in the device.

Every one is a functional of the response z(s) of an output on a grid, dF = Re Σ a dz, and the port gives dz/dY:

    root mean square     F² = S Σ w |z|²,                       a = S w z̄/F                  s = jω
    largest gain         F = max |z(jω)|,                        a = z̄/|z| at that ω          s = jω
    peak in time         F = maxₜ |y(t)|,  y(t) = e^{σt}/π ∫ Re(z W e^{jωt}) dω,   a = ± w W e^{st}   s = σ + jω

The last is the inverse Laplace transform on a line to the right of all poles, with W the transform of the input; the
trapezoidal rule of step Δ aliases y(t + 2π/Δ) in, smaller by e^{−2πσ/Δ} [AbateWhitt1992], so it is exact to that.
A maximum is given as its few largest local maxima, one number each: a search that lowers the first may raise the
second, and wants to know. Each is followed to its own place between the samples, where, being stationary, it has the
slope that it would have if that were held.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

from posreal.optimisation.coordinates import Coordinates
from posreal.optimisation.scaling import Scale
from posreal.plant.modes import Corners
from posreal.plant.mounting import Mounting
from posreal.plant.plant import PortResponses
from posreal.specification.problem import Problem

Real = np.ndarray
Complex = np.ndarray

SAMPLES = 1024  # of a period of the inverse transform
MAXIMA = 3  # local maxima that stand for a maximum
FAN, NARROWED = 9, 3  # points between a maximum's neighbours, and how often: to 1/64 of their distance


@dataclass(frozen=True)
class Slopes:
    """Numbers (m,), their slopes (size, m) in the vector of a chart, and (m,) in each free vehicle parameter."""

    values: Real
    by_theta: Real
    by: Mapping[str, Real]


class Figure(Protocol):
    """One or more numbers that depend on the device and on the free vehicle parameters.

    `resolution` is the relative change in which two values can be told apart: an optimiser asked for less goes on
    for ever.
    """

    @property
    def resolution(self) -> float: ...

    def slopes(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The numbers and their slopes at a point of a chart."""

    def values(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> Real:
        """The numbers for a scaled device."""


@dataclass(frozen=True)
class Inside:
    """What the ports hold on a grid: the device in its mounting, and the vehicle parameters that are free.

    With H the scaled device (:class:`Scale`), the secondary port holds Y_beside + c0 H, or Y_beside + 1/(s/kb + H/c0)
    behind a bush kb; a free static spring stands in Y_beside, and the groups of other free parameters
    hold what the vehicle says (:attr:`posreal.vehicle.Vehicle.free`). A whole
    strut brings its own spring and bush: beside it stands an airspring or nothing.
    """

    problem: Problem
    scale: Scale
    s: Complex

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The free vehicle parameters."""
        return tuple(self.problem.free)

    @cached_property
    def nominal(self) -> dict[str, float]:
        """The free parameters at the vehicle's own values."""
        return {name: float(getattr(self.problem.vehicle, name)) for name in self.names}

    @property
    def _mounting(self) -> Mounting:
        return self.problem.layout_mounting if self.scale.whole else self.problem.mounting

    @cached_property
    def _beside(self) -> Complex:
        beside = self._mounting.beside
        return np.zeros_like(self.s) if beside is None else np.asarray(beside(self.s))

    @cached_property
    def _give(self) -> Complex:
        """Mobility of the bush."""
        behind = self._mounting.behind
        return np.zeros_like(self.s) if behind is None else 1 / np.asarray(behind(self.s))

    def ports(self, H: Complex, parameters: Mapping[str, float] | None = None) -> tuple[dict[str, Complex], Complex]:
        """The admittance of each group of ports, and dY_secondary/dH."""
        values = {**self.nominal, **(parameters or {})}
        c0 = self.scale.damper
        if self.scale.impedance:
            inner = 1 / (self._give + H / c0)
            slope = -(inner**2) / c0
        else:
            inner, slope = c0 * H, np.full_like(H, c0)
        beside = self._beside
        for name in self.names:
            group, power = self.problem.vehicle.free[name]
            if group == "secondary":
                beside = beside + (values[name] - self.nominal[name]) * self.s**power
        found = {"secondary": beside + inner}
        for group in {self.problem.vehicle.free[name][0] for name in self.names} - {"secondary"}:
            found[group] = sum(
                (values.get(name, getattr(self.problem.vehicle, name)) * self.s**power)
                for name, (of, power) in self.problem.vehicle.free.items()
                if of == group
            )
        return found, slope

    def by_parameter(self, slopes: Mapping[str, Complex]) -> dict[str, Real]:
        """Slopes in the free parameters of figures with slopes dF = Re Σ g dY, g (…, N) for each group of ports."""
        shares = ((name, *self.problem.vehicle.free[name]) for name in self.names)
        return {name: np.asarray((slopes[group] * self.s**power).real.sum(axis=-1)) for name, group, power in shares}


class Functional(Protocol):
    """z on the grid to numbers (m,) and the a (m, N) of the module's text."""

    def __call__(self, z: Complex) -> tuple[Real, Complex]: ...


@dataclass(frozen=True)
class RootMeanSquareFunctional:
    """F² = Σ w |z|², density and unit in `weight`."""

    weight: Real

    def __call__(self, z: Complex) -> tuple[Real, Complex]:
        F = np.sqrt(self.weight @ np.abs(z) ** 2)
        return np.array([F]), (self.weight * z.conj() / F)[None, :]


@dataclass(frozen=True)
class Norms:
    """|z| at every frequency, the norm of z where several processes drive it.

    Attributes
    ----------
    processes : int
        z has all of the grid for each in turn.
    """

    processes: int = 1

    def __call__(self, z: Complex) -> tuple[Real, Complex]:
        each = z.reshape(self.processes, -1)
        size = np.linalg.norm(each, axis=0)
        a = np.zeros((len(size), *each.shape), dtype=complex)
        at = np.arange(len(size))
        a[at, :, at] = (each.conj() / np.maximum(size, 1e-300)).T
        return size, a.reshape(len(size), -1)


@dataclass(frozen=True)
class PeakInTimeFunctional:
    """The largest local maxima of |y(t)| on 0 … `stop` seconds.

    Attributes
    ----------
    s : (N,) points σ + jω, evenly spaced from ω = 0
    kernel : (N,) transform of the input times the weights of the trapezoidal rule, unit included
    stop : float, seconds
    """

    s: Complex
    kernel: Complex
    stop: float

    @cached_property
    def _instants(self) -> Real:
        period = 2 * np.pi / float(self.s[1].imag - self.s[0].imag)
        t = np.arange(SAMPLES) * (period / SAMPLES)
        return t[t <= self.stop]

    def __call__(self, z: Complex) -> tuple[Real, Complex]:
        t = self._instants
        sums = np.fft.ifft(self.kernel * z, SAMPLES)[: len(t)] * SAMPLES
        y = np.exp(self.s[0].real * t) * sums.real
        at = largest(np.abs(y))
        top = t[at]
        for _ in range(3):  # Newton on y' = 0, kept near its sample
            rows = np.exp(np.multiply.outer(top, self.s)) * self.kernel
            first, second = (rows @ (self.s * z)).real, (rows @ (self.s**2 * z)).real
            step = np.where(second == 0, 0.0, -first / np.where(second == 0, 1.0, second))
            inner = (at > 0) & (at < len(t) - 1)
            top = np.where(inner, np.clip(top + step, t[at] - 0.03, t[at] + 0.03), t[at])
        rows = np.exp(np.multiply.outer(top, self.s)) * self.kernel
        values = (rows @ z).real
        sign = np.sign(values)
        return np.abs(values), sign[:, None] * rows


def largest(size: Real) -> np.ndarray:
    """Indices of the largest local maxima, filled up with those of the smallest entries where there are fewer."""
    edge = np.concatenate([[-np.inf], size, [-np.inf]])
    tops = np.flatnonzero((edge[1:-1] >= edge[:-2]) & (edge[1:-1] > edge[2:]))
    tops = tops[np.argsort(-size[tops], kind="stable")][:MAXIMA]
    return np.concatenate([tops, np.argsort(size, kind="stable")[: MAXIMA - len(tops)]]).astype(int)


def laplace_line(stop: float, input_corners: Corners, unit: float) -> PeakInTimeFunctional:
    """The functional for an input made of ramps, w(t) = Σ change · max(0, t − instant).

    Parameters
    ----------
    stop : float
        Last instant, seconds, at which a peak counts.
    input_corners : tuple of (instant, change)
    unit : float
        Multiplies y.
    """
    period = 3 * stop  # aliasing period: e^{−σ·(period)} beside what counts
    sigma, step = 18.0 / period, 2 * np.pi / period
    omega = step * np.arange(round(150.0 / step))
    s = sigma + 1j * omega
    W = sum(change * np.exp(-s * instant) for instant, change in input_corners) / s**2
    weight = np.full(len(s), step / np.pi)
    weight[0] /= 2
    return PeakInTimeFunctional(s, unit * weight * W, stop)


@dataclass(frozen=True)
class PortFigure:
    """A functional of one output of a vehicle."""

    inside: Inside
    port: PortResponses
    functional: Functional
    gain: float = 1.0
    resolution: ClassVar[float] = 1e-11

    @property
    def s(self) -> Complex:
        """The grid in scaled time."""
        return self.inside.s / self.inside.scale.omega

    def response(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> Complex:
        """z on the grid for a scaled device."""
        return self.port.closed(self.inside.ports(np.asarray(device(self.s)), parameters)[0])[0]

    def values(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> Real:
        """The numbers for a scaled device."""
        return self.gain * self.functional(self.response(device, parameters))[0]

    def slopes(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The numbers and their slopes at a point of a chart."""
        H, dH = chart.values_and_slopes(theta, self.s)
        Y, inner = self.inside.ports(H, parameters)
        z, dz = self.port.closed(Y)
        F, a = self.functional(z)
        slopes = {group: self.gain * self.port.over_grid(a * slope) for group, slope in dz.items()}
        g = slopes["secondary"] * inner
        by_theta = dH.real @ g.real.T - dH.imag @ g.imag.T
        return Slopes(self.gain * F, by_theta, self.inside.by_parameter(slopes))


@dataclass(frozen=True)
class PeakGain:
    """The largest local maxima of the gain of an output over all frequencies, each where it is.

    Attributes
    ----------
    problem : Problem
    scale : Scale
    output, load : str
    omega : (N,) rad/s, where maxima are looked for; each is then narrowed down between its neighbours
    """

    problem: Problem
    scale: Scale
    output: str
    omega: Real
    load: str
    resolution: ClassVar[float] = 1e-8

    @cached_property
    def _everywhere(self) -> PortFigure:
        return self._at(self.omega)

    def _at(self, omega: Real) -> PortFigure:
        plant = self.problem.vehicle.plant(self.load)
        inside = Inside(self.problem, self.scale, 1j * omega)
        return PortFigure(inside, plant.responses(omega, self.output), Norms(len(plant.shares)))

    def tops(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> PortFigure:
        """The gains at the frequencies of the maxima, the largest first."""

        def sizes(figure: PortFigure) -> Real:
            z = figure.response(device, parameters).reshape(len(self.problem.plant.shares), -1)
            return np.asarray(np.linalg.norm(z, axis=0))

        size = sizes(self._everywhere)
        at = largest(size)
        beside = np.clip([at - 1, at + 1], 0, len(size) - 1)
        top = size[at] >= size[beside].max(axis=0)
        low, high = np.log(self.omega[np.where(top, beside, at)])
        for _ in range(NARROWED):
            trial = np.linspace(low, high, FAN)
            size = sizes(self._at(np.exp(trial.ravel()))).reshape(trial.shape)
            at, row = size.argmax(axis=0), np.arange(len(low))
            low, middle, high = (trial[np.clip(at + step, 0, FAN - 1), row] for step in (-1, 0, 1))
        # a parabola through the last three, where they are three
        f = np.array([size[np.clip(at + step, 0, FAN - 1), row] for step in (-1, 0, 1)])
        bend = f[0] - 2 * f[1] + f[2]
        inner = (at > 0) & (at < FAN - 1) & (bend < 0)
        shift = np.where(inner, (f[0] - f[2]) / np.where(inner, 2 * bend, 1.0), 0.0)
        return self._at(np.exp(middle + shift * (high - low) / 2)[np.argsort(-f[1], kind="stable")])

    def values(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> Real:
        """The numbers for a scaled device, the largest first."""
        return self.tops(device, parameters).values(device, parameters)

    def slopes(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The numbers and their slopes at a point of a chart, the largest first."""
        return self.tops(chart.device(theta), parameters).slopes(chart, theta, parameters)


@dataclass(frozen=True)
class WeightedFigures:
    """Σ weight · (each part's largest number but for the first part, whose numbers all count)."""

    parts: tuple[tuple[float, Figure], ...] = field(default=())

    @property
    def resolution(self) -> float:
        """That of its coarsest part."""
        return max(part.resolution for _, part in self.parts)

    def values(self, device: Callable[[Complex], Any], parameters: Mapping[str, float]) -> Real:
        """The numbers for a scaled device."""
        found = [weight * part.values(device, parameters) for weight, part in self.parts]
        return np.asarray(found[0] + sum(other[0] for other in found[1:]))

    def slopes(self, chart: Coordinates, theta: Real, parameters: Mapping[str, float]) -> Slopes:
        """The numbers and their slopes at a point of a chart."""
        found = [(w, part.slopes(chart, theta, parameters)) for w, part in self.parts]
        w, first = found[0]
        values, by_theta = w * first.values, w * first.by_theta
        by = {name: w * slope for name, slope in first.by.items()}
        for w, other in found[1:]:
            values = values + w * other.values[0]
            by_theta = by_theta + w * other.by_theta[:, :1]
            by = {name: slope + w * other.by[name][0] for name, slope in by.items()}
        return Slopes(values, by_theta, by)
