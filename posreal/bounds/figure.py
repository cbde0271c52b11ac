"""What a bound is about: a mean-square figure of a vehicle and the loops that its device closes.

Behind everything that stands in a port whatever the device is, one device of admittance Y sees

    z = (τ + Σᵢ oᵢ xᵢ) w,   xᵢ = 2σ/(1 − wᵢ σ),   σ = (Y − c0)/(Y + c0),   wᵢ = (1 − c0 Pᵢ)/(1 + c0 Pᵢ)

σ and wᵢ are the reflections, against a damper c0, of the device and of port i of mobility Pᵢ (the sum over the ports
that hold the same device). With V the velocity of the port and T the sensitivity of z to its force, device taken out,

    τ = Tzw + Σᵢ c0 hᵢ Tᵢ Vᵢ,   oᵢ = c0 hᵢ² Tᵢ Vᵢ,   hᵢ = 1/(1 + c0 Pᵢ).

A spring or an airspring Y_b beside the device closes the open port first, z and the port's P, V, T with it; what stands
behind the device adds its impedance to P.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import arb, arb_mat, fmpq

from posreal.admittance import Rational, exact
from posreal.admittance.exact import to_fmpq
from posreal.admittance.roots import precision
from posreal.admittance.state_space import StateSpace
from posreal.bounds.interpolation_space import Point, Space, identity
from posreal.errors import BadInput, Infeasible, listed
from posreal.plant import h2_norm, hinf_norm
from posreal.plant.figures import ClosedPlant
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant, close
from posreal.specification.problem import Problem

SQUARES, SUM, PEAK = "squares", "sum", "peak"
KINDS = {SQUARES: "whole-band H2", SUM: "whole-band H2", PEAK: "H-infinity"}


@dataclass(frozen=True)
class BoundedFigure:
    """One number J about one plant with one device in its ports, over all frequencies.

        squares   J = √(π S Σ weight ‖output/w‖₂²)
        sum       J = Σ √(π S weight) ‖output/w‖₂
        peak      J = √weight ‖output/w‖_∞, one output

    Attributes
    ----------
    plant : Plant
        Its matrices are taken as the exact rationals that their floats are.
    mounting : Mounting
        What stands beside and behind the device in every port.
    weights : mapping of output name to fmpq
        Weight of each output's mean square (squared gain), unit conversion included.
    metric, unit : str
        Name and unit of J.
    combine : {"squares", "sum", "peak"}
    """

    plant: Plant
    mounting: Mounting
    weights: Mapping[str, fmpq]
    metric: str
    unit: str
    combine: str = SQUARES

    def __post_init__(self) -> None:
        if len(set(self.plant.groups)) != 1:
            places = listed(sorted(set(self.plant.groups))).replace(" or ", " and ")
            raise BadInput(f"a bound is over one device in all ports, and this plant has places for {places}")
        if len(self.plant.shares) > 1:
            raise BadInput(
                "a bound is known for one white process only; give them one at a time, each bounds the whole"
            )
        unknown = set(self.weights) - set(self.plant.outputs)
        if unknown or not self.weights or any(weight < 0 for weight in self.weights.values()):
            raise BadInput(f"weights must be of the outputs {listed(self.plant.outputs)} and not negative")
        if self.combine not in KINDS or (self.combine == PEAK and len(self.weights) > 1):
            raise BadInput(f"outputs are combined as {listed(KINDS)}, and peak takes one of them")
        if not _decoupled(self.plant):
            raise BadInput(
                "the ports of this plant feel each other, so they are not scalar loops and no bound is known; "
                "give them as sums and differences that do not"
            )

    @property
    def kind(self) -> str:
        """Norm and band; figures of another kind are not comparable."""
        return KINDS[self.combine]

    @property
    def rows(self) -> list[int]:
        """Indices of the outputs that count."""
        return [self.plant.output(name) for name in self.weights]

    @cached_property
    def loops(self) -> list[int]:
        """Ports whose force some output feels; the device's motion in the others does not matter."""
        ports = [p for p in range(len(self.plant.groups)) if not _unfelt(self.plant, self.rows, p)]
        if not ports:
            raise BadInput("no output of this figure feels the device, so there is nothing to bound")
        return ports

    def measure(self, port: Rational | StateSpace) -> float:
        """J with an admittance in every port over all frequencies, or the largest gain, confirmed.

        Raises
        ------
        Infeasible
            If the vehicle is not stable with it.
        """
        if isinstance(port, StateSpace):
            return self._measure_matrices(port)
        closed = ClosedPlant(self.plant, {self.plant.groups[0]: port})
        closed.require_stable()
        gains = {name: math.sqrt(exact.to_float(weight)) for name, weight in self.weights.items()}
        if self.combine == PEAK:
            ((name, factor),) = gains.items()
            return factor * closed.largest_gain(name)[0].value
        parts = [factor * closed.rms(name).value for name, factor in gains.items()]
        return sum(parts) if self.combine == SUM else math.hypot(*parts)

    def _measure_matrices(self, port: StateSpace) -> float:
        """The same for a device of so many states that only matrices serve: by covariance."""
        loop = close(self.plant, {self.plant.groups[0]: port})
        growth = float(loop.poles().real.max())
        if growth >= 0:
            raise Infeasible(f"the vehicle is not stable with this device: a pole has real part {growth:.3g} 1/s")
        if self.combine == PEAK:
            ((name, weight),) = self.weights.items()
            return math.sqrt(exact.to_float(weight)) * hinf_norm.largest(loop, name, hinf_norm.grid(self.plant))[0]
        squares = [exact.to_float(weight) * h2_norm.mean_square(loop, name) for name, weight in self.weights.items()]
        return sum(map(math.sqrt, squares)) if self.combine == SUM else math.sqrt(sum(squares))

    def mobility(self, port: int) -> Rational:
        """P that the device sees at a port, exactly."""
        plant = self.plant
        n, d = exact.transfer_function(
            exact.matrix(plant.A),
            exact.matrix(-plant.Bf[:, port : port + 1]),
            exact.matrix(plant.Cv[port : port + 1]),
            fmpq(0),
        )
        P, around = Rational(n, d), self.mounting
        if around.beside is not None:
            P = P.inverse().without(around.beside.scaled(-1)).inverse()
        return P if around.behind is None else P.without(around.behind.inverse().scaled(-1))


def figure(problem: Problem, weights: Mapping[str, float] | None = None) -> BoundedFigure:
    """The figure over all frequencies behind a problem's objective.

    Parameters
    ----------
    problem : Problem
        Its objective may be a mean square, a weighted sum of such, or a largest gain. Of several operating points the
        nominal one is taken: the worst over all is no smaller.
    weights : mapping of metric name to float, optional
        J² = Σ weight · metric² in place of the problem's objective: ``{"J1": 1, "J3": 1e-6}``.

    Raises
    ------
    BadInput
        If no bound is known: a time-domain peak, vehicle parameters left free.
    """
    known = _outputs(problem)
    mounting, base = problem.mounting, problem.base_objective
    gain = problem.gain_output(base)
    if weights is None and problem.goal is None and gain is None:
        _known(base, known)
    if problem.free:
        raise BadInput(
            f"{problem.name} leaves {listed(problem.free).replace(' or ', ' and ')} free, and a bound is known for "
            "a given vehicle only; bound the problem without free parameters for a vehicle with chosen ones"
        )
    parts = tuple(weights) if weights is not None else (base,) if problem.goal is None else dict(problem.goal.parts)
    plant = _shaken(problem, tuple(parts))
    if weights is not None:
        squares = {_known(name, known)[0]: known[name][2] * to_fmpq(value) for name, value in weights.items()}
        name = "sqrt(" + " + ".join(f"{value:g}*{name}^2" for name, value in weights.items()) + ")"
        units = {known[name][1] for name in weights}
        return BoundedFigure(plant, mounting, squares, name, units.pop() if len(weights) == 1 else "1")
    if problem.goal is not None:
        if problem.goal.kind == "worst" or any(problem.gain_output(part) for part in parts):
            names = listed(parts)
            whose = "is a bound on the worst" if problem.goal.kind == "worst" else "times its weight is one on the sum"
            raise BadInput(f"{base} has no bound of its own; bound one of its parts, {names}: each {whose}")
        squares = {_known(part, known)[0]: known[part][2] * to_fmpq(value) ** 2 for part, value in problem.goal.parts}
        units = {known[part][1] for part in parts}
        combine = SQUARES if problem.goal.kind == "norm" else SUM
        return BoundedFigure(plant, mounting, squares, base, units.pop() if len(units) == 1 else "1", combine)
    if gain is not None:
        return BoundedFigure(plant, mounting, {gain: fmpq(1)}, base, "1", PEAK)
    output, unit, scale = _known(base, known)
    return BoundedFigure(plant, mounting, {output: scale}, base, unit)


def _shaken(problem: Problem, names: Sequence[str]) -> Plant:
    """The vehicle on the one load that some of its metrics are about."""
    norms = [metric.norm() for name, metric in problem.vehicle.metrics.items() if name in names]
    loads = {norm.load for norm in norms if norm is not None}
    if len(loads) > 1:
        raise BadInput(
            f"{listed(names).replace(' or ', ' and ')} are of different inputs, {listed(sorted(loads))}, and a bound "
            "is of one; bound them one at a time"
        )
    return (problem.vehicle.plant(loads.pop()) if loads else problem.plant).rational


def _outputs(problem: Problem) -> dict[str, tuple[str, str, fmpq]]:
    """Mean-square metrics of a vehicle: output, unit, and squared conversion to that unit."""
    vehicle = problem.vehicle
    norms = {name: (metric.norm(), metric.unit) for name, metric in vehicle.metrics.items()}
    return {
        name: (norm.output, unit, to_fmpq(norm.factor(vehicle)) ** 2)
        for name, (norm, unit) in norms.items()
        if norm is not None and norm.kind == "H2"
    }


def _known(name: str, known: Mapping[str, tuple[str, str, fmpq]]) -> tuple[str, str, fmpq]:
    if name not in known:
        why = (
            "a peak in time, and only mean squares and gains have a bound"
            if name == "max_yv"
            else "not a mean-square figure of this vehicle"
        )
        raise BadInput(f"no valid bound on {name} is known: it is {why}; mean squares here are {listed(known)}")
    return known[name]


@dataclass(frozen=True)
class Expansion:
    """Everything on the points' space: τ + Σᵢ Oᵢ xᵢ are the coefficients of z there, or its column for a peak.

    Attributes
    ----------
    space : Space
    tau : one column (m, 1) an output
    O : O[i][row], operators (m, m), for each loop i
    W : operators (m, m), T of each loop's reflection
    """

    space: Space
    tau: list[arb_mat]
    O: list[list[arb_mat]]
    W: list[arb_mat]


def expand(figure: BoundedFigure, points: Sequence[Point], c0: fmpq) -> Expansion:
    """The figure on the space of some points against a damper c0, at the precision in force."""
    space = Space(tuple(points))
    plant, rows, ports = figure.plant, figure.rows, figure.loops
    channels, count = plant.Bw.shape[1], len(rows)
    direct = np.zeros((count + len(ports), channels + len(ports)))
    direct[:count, :channels] = plant.Dzw[rows]
    direct[:count, channels:] = plant.Dzf[np.ix_(rows, ports)]
    responses = space.state_space(
        plant.A,
        np.hstack([plant.Bw, plant.Bf[:, ports]]),
        np.vstack([plant.Cz[rows], plant.Cv[ports]]),
        direct,
    )
    late = [space.delay(float(seconds)) for seconds in plant.delays]
    if plant.shaping is not None:
        H = plant.shaping.rational
        shape = space.operator(space.state_space(H.A, H.B, H.C, H.D)[0][0])
        late = [shape * part for part in late]
    through = space.operators(late)
    driven = [_sum(through[i] * row[i] for i in range(channels)) for row in responses]
    around = figure.mounting
    one, c = space.one, arb(c0)
    beside = None if around.beside is None else space.rational(around.beside)
    behind = None if around.behind is None else space.rational(around.behind.inverse())
    tau, o, w = driven[:count], [], []
    for i in range(len(ports)):
        P, V = -responses[count + i][channels + i], driven[count + i]
        T = [responses[r][channels + i] for r in range(count)]
        if beside is not None:
            closed = space.operator(space.over(one, one + space.operator(beside) * P))
            pushed = space.operator(closed * (space.operator(beside) * V))  # force of what stands beside
            tau = [t + pushed * T[r] for r, t in enumerate(tau)]
            P, V, T = closed * P, closed * V, [closed * t for t in T]
        if behind is not None:
            P = P + behind
        h = space.operator(space.over(one, one + P * c))
        moved = space.operator(V)
        through_port = [moved * t for t in T]
        tau = [t + h * through_port[r] * c for r, t in enumerate(tau)]
        o.append([h * (h * t) * c for t in through_port])
        w.append(h * (one - P * c))
    scale = arb(1) if figure.combine == PEAK else arb.pi() * arb(float(plant.density))
    gains = [(scale * arb(figure.weights[plant.outputs[r]])).sqrt() for r in rows]
    measure = identity(space.size) if figure.combine == PEAK else space.operator(space.measure)
    return Expansion(
        space,
        [measure * t * gain for t, gain in zip(tau, gains, strict=True)],
        [
            [T * gain for T, gain in zip(space.operators([measure * part for part in loop]), gains, strict=True)]
            for loop in o
        ],
        space.operators(w),
    )


def enclosed(figure: BoundedFigure, points: Sequence[Point], c0: fmpq, *, digits: int = 30) -> Expansion:
    """`expand` with the precision doubled until all is known to so many digits of the largest."""
    bits = 256
    while bits <= 1 << 14:
        with precision(bits):
            found = expand(figure, points, c0)
            if _fine([*found.tau, *(o for loop in found.O for o in loop), *found.W, found.space.basis], digits):
                return found
        bits *= 2
    raise BadInput("the vehicle cannot be evaluated at these points; choose others")


def _fine(parts: Sequence[arb_mat], digits: int) -> bool:
    for part in parts:
        balls = part.entries()
        if not all(ball.is_finite() for ball in balls):
            return False
        largest = max(float(ball.abs_upper()) for ball in balls)
        if max(float(ball.rad()) for ball in balls) > 10.0**-digits * largest:
            return False
    return True


def _sum(parts: Iterable[arb_mat]) -> arb_mat:
    total, *rest = parts
    for part in rest:
        total = total + part
    return total


def _unfelt(plant: Plant, rows: Sequence[int], port: int) -> bool:
    """Whether no output in `rows` feels a force at the port, exactly."""
    if np.any(plant.Dzf[rows, port]):
        return False
    A, x, out = exact.matrix(plant.A), exact.matrix(plant.Bf[:, port : port + 1]), exact.matrix(plant.Cz[rows])
    for _ in range(len(plant.A)):
        if any(value != 0 for value in (out * x).entries()):
            return False
        x = A * x
    return True


def _decoupled(plant: Plant) -> bool:
    """Whether Cvᵢ Aᵏ Bfⱼ = 0 for i ≠ j and every k, exactly: no port feels another's force."""
    count = len(plant.groups)
    if count == 1:
        return True
    A, x, out = exact.matrix(plant.A), exact.matrix(plant.Bf), exact.matrix(plant.Cv)
    for _ in range(len(plant.A)):
        seen = out * x
        if any(seen[i, j] != 0 for i in range(count) for j in range(count) if i != j):
            return False
        x = A * x
    return True
