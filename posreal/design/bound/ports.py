"""What a bound is about: a mean-square figure of a vehicle, its ports, and all of it expanded at ω0.

Behind everything that stands in a port whatever the device is, one device of admittance Y sees

    z = τ w + Σᵢ oᵢ xᵢ w,   xᵢ = 2σ/(1 − wᵢ σ),   σ = (Y − c0)/(Y + c0),   wᵢ = (1 − c0 Pᵢ)/(1 + c0 Pᵢ)

σ and wᵢ are the reflections, against a damper c0, of the device and of port i of mobility Pᵢ (the sum over the ports
that hold the same device). With V the velocity of the port and T the sensitivity of z to its force, device taken out,

    τ = Tzw + Σᵢ c0 hᵢ Tᵢ Vᵢ,   oᵢ = c0 hᵢ² Tᵢ Vᵢ,   hᵢ = 1/(1 + c0 Pᵢ).

A spring or an airspring beside the device closes the open port first; what stands behind it adds its impedance to P.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_series, ctx, fmpq

from posreal.admittance import Rational, exact
from posreal.admittance.exact import to_fmpq
from posreal.design.bound import series
from posreal.design.bound.series import Series
from posreal.design.problem import Mounting, Problem
from posreal.errors import BadInput, listed
from posreal.vehicle import PlanView, QuarterCar, SideView
from posreal.vehicle.plant import Plant

WHOLE_BAND = "whole-band H2"


@dataclass(frozen=True)
class Figure:
    """J² = π S Σ weight ‖output/w‖₂², over the whole band, of one plant with one device in its ports.

    Attributes
    ----------
    plant : Plant
        Its matrices are taken as the exact rationals that their floats are.
    mounting : Mounting
        What stands beside and behind the device in every port.
    weights : mapping of output name to fmpq
        Weight of each output's mean square, unit conversion included.
    metric, unit, kind : str
        Name and unit of J, and which band it is about.
    """

    plant: Plant
    mounting: Mounting
    weights: Mapping[str, fmpq]
    metric: str
    unit: str
    kind: str = WHOLE_BAND

    def __post_init__(self) -> None:
        if len(set(self.plant.groups)) != 1:
            raise BadInput(
                f"a bound is over one device in all ports, and this plant has places for {listed(set(self.plant.groups))}"
            )
        unknown = set(self.weights) - set(self.plant.outputs)
        if unknown or not self.weights or any(weight < 0 for weight in self.weights.values()):
            raise BadInput(f"weights must be of the outputs {listed(self.plant.outputs)} and not negative")
        if not _decoupled(self.plant):
            raise BadInput(
                "the ports of this plant feel each other, so they are not scalar loops and no bound is known; "
                "give them as sums and differences that do not"
            )

    @property
    def rows(self) -> list[int]:
        """Indices of the outputs that count."""
        return [self.plant.output(name) for name in self.weights]

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


def figure(problem: Problem, weights: Mapping[str, float] | None = None) -> Figure:
    """The whole-band mean-square figure behind a problem's objective.

    Parameters
    ----------
    problem : Problem
    weights : mapping of metric name to float, optional
        J² = Σ weight · metric² in place of the problem's objective: ``{"J1": 1, "J3": 1e-7}``.

    Raises
    ------
    BadInput
        If no bound is known: a time-domain peak, vehicle parameters left free.
    """
    if problem.free:
        raise BadInput(
            f"{problem.name} leaves {listed(problem.free).replace(' or ', ' and ')} free, and the bound is for one vehicle; "
            f"fix them, or bound the problem without -primary for a given vehicle"
        )
    chosen = {problem.objective: 1.0} if weights is None else dict(weights)
    match problem.vehicle:
        case PlanView() as vehicle:
            plant, outputs = vehicle.random_track(), {"Macc": "body_acceleration"}
            unit, gain = "m/s^2", fmpq(1)
        case SideView() as vehicle:
            plant, outputs = vehicle.track(), {f"J1z_{p}": f"acceleration_{p}" for p in "LMT"}
            unit, gain = "%g", (100 / to_fmpq(vehicle.g)) ** 2
        case QuarterCar() as vehicle:
            plant, outputs = vehicle.road(), {"J1": "acceleration", "J3": "tyre_force"}
            unit, gain = {"J1": "m/s^2", "J3": "N"}.get("+".join(chosen), "1"), fmpq(1)
    unknown = [name for name in chosen if name not in outputs]
    if unknown:
        why = (
            "a peak in time, and only mean squares have a bound"
            if unknown[0] == "max_yv"
            else "not a mean-square figure of this vehicle"
        )
        raise BadInput(f"no valid bound on {unknown[0]} is known: it is {why}; mean squares here are {listed(outputs)}")
    metric = next(iter(chosen))
    if weights is not None:
        metric = "sqrt(" + " + ".join(f"{weight:.17g}*{name}^2" for name, weight in chosen.items()) + ")"
    scaled = {outputs[name]: gain * to_fmpq(weight) for name, weight in chosen.items()}
    return Figure(plant, problem.mounting, scaled, metric, unit)


@dataclass(frozen=True)
class Expansion:
    """Taylor coefficients at ω0: J² = Σₖ Σ_rows (τ + Σᵢ oᵢ xᵢ)ₖ² over all k, as series of ``ctx.cap`` terms.

    Attributes
    ----------
    tau : one series an output
    o : o[i][row], for each loop i
    w : w[i], reflection of each loop
    """

    tau: list[Series]
    o: list[list[Series]]
    w: list[Series]

    def floats(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(rows, m), (loops, rows, m) and (loops, m) midpoints."""
        return (
            np.array([series.midpoints(t) for t in self.tau]),
            np.array([[series.midpoints(o) for o in loop] for loop in self.o]),
            np.array([series.midpoints(w) for w in self.w]),
        )


def expand(figure: Figure, omega0: fmpq, c0: fmpq) -> Expansion:
    """The figure's expansion at ω0 against a damper c0, at the length and precision in force."""
    plant, rows, ports = figure.plant, figure.rows, range(len(figure.plant.groups))
    channels = plant.Bw.shape[1]
    responses = series.state_space(
        plant.A,
        np.hstack([plant.Bw, plant.Bf]),
        np.vstack([plant.Cz[rows], plant.Cv]),
        np.block(
            [
                [plant.Dzw[rows], plant.Dzf[rows]],
                [np.zeros((len(ports), channels + len(ports)))],
            ]
        ),
        omega0,
    )
    late = [series.delay(float(seconds), omega0) for seconds in plant.delays]
    if plant.shaping is not None:
        H = plant.shaping
        shape = series.state_space(H.A, H.B, H.C, H.D, omega0)[0][0]
        late = [shape * part for part in late]
    driven = [_sum(row[i] * late[i] for i in range(channels)) for row in responses]
    count = len(rows)
    around = figure.mounting
    one, c = series.constant(1), series.constant(c0)
    tau, o, w = driven[:count], [], []
    for p in ports:
        P, V = -responses[count + p][channels + p], driven[count + p]
        T = [responses[r][channels + p] for r in range(count)]
        if around.beside is not None:
            Y = series.rational(around.beside, omega0)
            closed = one / (one + Y * P)
            tau = [t + T[r] * V * Y * closed for r, t in enumerate(tau)]
            P, V, T = P * closed, V * closed, [t * closed for t in T]
        if around.behind is not None:
            P = P + one / series.rational(around.behind, omega0)
        h = one / (one + c * P)
        tau = [t + T[r] * V * c * h for r, t in enumerate(tau)]
        o.append([t * V * c * h * h for t in T])
        w.append((one - c * P) * h)
    # ∫|z|² dω/2π over the axis is the mean over the circle of |z √(2ω0)/(1 + ζ)|²
    isometry = one / arb_series([arb(1), arb(1)])
    scale = 2 * arb(omega0) * arb.pi() * arb(float(plant.density))
    gains = [(scale * arb(figure.weights[plant.outputs[r]])).sqrt() for r in rows]
    measure = [isometry * series.constant(gain) for gain in gains]
    return Expansion(
        [t * measure[r] for r, t in enumerate(tau)],
        [[part * measure[r] for r, part in enumerate(loop)] for loop in o],
        w,
    )


def enclosed(figure: Figure, omega0: fmpq, c0: fmpq, length: int, *, digits: int = 40) -> Expansion:
    """`expand` with the precision doubled until every coefficient is known to so many digits of the largest."""
    bits = 256
    while True:
        with series.expansion(length, bits):
            found = expand(figure, omega0, c0)
            if _fine([*found.tau, *(o for loop in found.o for o in loop), *found.w], digits):
                return found
        if bits > 1 << 15:
            raise BadInput(f"the vehicle cannot be expanded at ω0 = {omega0} rad/s; choose another point")
        bits *= 2


def _fine(parts: Sequence[Series], digits: int) -> bool:
    for part in parts:
        balls = series.coefficients(part)
        if not all(ball.is_finite() for ball in balls):
            return False
        largest = max(abs(float(ball)) for ball in balls)
        if max(float(ball.rad()) for ball in balls) > 10.0**-digits * largest:
            return False
    return True


def _sum(parts: object) -> Series:
    total = series.constant(0)
    for part in parts:  # type: ignore[attr-defined]
        total = total + part
    return total


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


__all__ = ["WHOLE_BAND", "Expansion", "Figure", "ctx", "enclosed", "expand", "figure"]
