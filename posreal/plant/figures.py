"""The figures of a closed plant, each computed by two methods that share nothing but the plant.

| figure | first | second | where they disagree |
|---|---|---|---|
| r.m.s. on a band | port map, quadrature placed by the poles | closed form by modes | exact polynomials: residues |
| sum over a grid | port map | modes | exact polynomials |
| r.m.s. over all frequencies | Lyapunov equation | exact polynomials: residues | the same: correlations |
| largest gain | state space, refined | port map on the placed grid | exact polynomials: refined; stationary points |
| peak in time | modes | exact polynomials: residues | their modes; companion exponential |

A figure is returned with the relative difference of the two methods that agree on it. Where no two agree to
`AGREED`, the answer is a sentence and no number. A closed plant that is not `confirmed` goes the first way only: for
thousands of draws of which those that are shown are confirmed afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from posreal.admittance import Rational, exact, state_space
from posreal.admittance.state_space import StateSpace
from posreal.errors import Infeasible, Unsettled
from posreal.plant import exact_loop, h2_norm, hinf_norm, quadrature, time_response
from posreal.plant.modes import Corners, Modes, modes
from posreal.plant.plant import ClosedLoop, Complex, Plant, Real, close
from posreal.plant.sampled import SampledDensity
from posreal.plant.shaping_filter import ShapingFilter

AGREED = 5e-7
"""Relative difference of two methods at which the six digits that are printed are settled."""
_SURE = 1e-9  # of the fastest pole: a real part that rounding has not made
_BEYOND = 1e4  # times the highest pole's frequency: where a gain is its limit to the digits printed
_MOST_POINTS = 400_000  # of a placed grid, some seconds


@dataclass(frozen=True)
class Settled:
    """A figure in SI units, and how far apart the two methods are that agree on it, relative to it; infinitely far if
    only one was asked."""

    value: float
    apart: float = 0.0

    def __mul__(self, factor: float) -> Settled:
        """In another unit."""
        return Settled(self.value * factor, self.apart)


def settled(name: str, ways: Sequence[Callable[[], float]]) -> Settled:
    """The figure on which two of the `ways` agree; later ways are only gone where the earlier ones disagree.

    The last way that agrees is the one whose value is taken: the ways are in the order of their cost and accuracy.

    Raises
    ------
    Unsettled
        If no two agree to `AGREED`.
    """
    found: list[float] = []
    for way in ways:
        try:
            value = way()
        except (ArithmeticError, ValueError, Unsettled):  # of rounding: a mean square that came out negative, say
            continue
        if not math.isfinite(value):
            continue
        for other in found:
            apart = abs(value - other) / max(abs(value), 1e-300) if value != other else 0.0
            if apart <= AGREED:
                return Settled(value, apart)
        found.append(value)
    values = " and ".join(f"{value:.6g}" for value in found[-2:]) or "nothing"
    raise Unsettled(f"{name} cannot be told: independent methods give {values}; the device is too near to undamped")


def unconfirmed(name: str, ways: Sequence[Callable[[], float]]) -> Settled:
    """The figure by the first of the `ways` that gives a number."""
    for way in ways:
        with suppress(ArithmeticError, ValueError, Unsettled):
            if math.isfinite(value := way()):
                return Settled(value, math.inf)
    raise Unsettled(f"{name} cannot be told")


@lru_cache(maxsize=64)
def _matrices(device: Rational) -> StateSpace:
    """The device at every speed and load case."""
    return state_space(device)


class ClosedPlant:
    """A plant with devices in its ports, and its figures.

    Parameters
    ----------
    plant : Plant
    devices : mapping of group name to Rational
        The admittance in every port, whatever stands beside and behind the device included.
    confirmed : bool
        Whether every figure is confirmed by a second method.
    """

    def __init__(self, plant: Plant, devices: Mapping[str, Rational], *, confirmed: bool = True) -> None:
        self.plant, self.devices, self.confirmed = plant, dict(devices), confirmed
        self.settled = settled if confirmed else unconfirmed
        self._transfers: dict[str, exact_loop.Transfer] = {}
        self._rms: dict[str, Settled] = {}
        self._by_modes: dict[tuple[float, float], dict[str, float]] = {}
        self._by_port: dict[tuple[float, float], dict[str, float]] = {}

    @property
    def _inside(self) -> dict[str, StateSpace]:
        return {name: _matrices(device) for name, device in self.devices.items()}

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop without the shaping filter."""
        return close(self.plant, self._inside, shaped=False).balanced()

    def shaped_loop(self) -> ClosedLoop:
        """The closed loop driven by white noise, shaping filter included."""
        return close(self.plant, self._inside)

    @cached_property
    def modes(self) -> Modes:
        """Every output as a sum over modes, shaping filter included; of a sampled density the root of it is not."""
        return modes(self.loop, self._filter)

    @cached_property
    def poles(self) -> Complex:
        """Of the loop and of the shaping filter, rad/s."""
        own = self.loop.poles()
        return own if self._filter is None else np.concatenate([own, np.linalg.eigvals(self._filter.A)])

    @property
    def _filter(self) -> ShapingFilter | None:
        return None if self.plant.shaping is None else self.plant.shaping.filter

    @property
    def _sampled(self) -> SampledDensity | None:
        return self.plant.shaping if isinstance(self.plant.shaping, SampledDensity) else None

    def transfer(self, output: str) -> exact_loop.Transfer:
        """The exact transfer functions to `output`."""
        if output not in self._transfers:
            self._transfers[output] = exact_loop.transfer(self.plant, self.devices, output)
        return self._transfers[output]

    def require_stable(self, what: str = "the vehicle", *, share: float = 0.0) -> None:
        """Do nothing if every mode that an output sees decays; what floats cannot tell is decided exactly.

        Parameters
        ----------
        what : str
            In the sentence.
        share : float
            Of the fastest pole: a mode that decays no faster counts as one that does not.

        Raises
        ------
        Infeasible
            Otherwise.
        """
        poles = self.loop.poles()
        growth, size = float(poles.real.max(initial=-1.0)), float(np.abs(poles).max(initial=1.0))
        if growth < -_SURE * size:
            return
        if growth > _SURE * size:
            raise Infeasible(f"{what} is not stable with this device: a pole has real part {growth:.3g} 1/s")
        if not all(self.transfer(output).decays(share) for output in self.plant.outputs):
            raise Infeasible(
                f"{what} is on the edge of stability with this device, or beyond: beside a pole at {size:.3g} rad/s "
                "one has no damping; if the best device locks the port or leaves it open, add a limit or another output"
            )

    # --- root mean squares --------------------------------------------------------------------------------------

    def band_rms(self, output: str, stop: float = quadrature.BAND, *, start: float = 0.0) -> Settled:
        """Root mean square from `start` to `stop`, rad/s."""
        if self._sampled is not None:
            return self._sampled_rms(self._sampled, output, start, stop)
        return self.settled(
            f"the r.m.s. of {output}",
            (
                lambda: math.sqrt(self.band_mean_square_by_modes(output, stop, start=start)),
                lambda: math.sqrt(self._on_placed_grid(output, stop, start)),
                lambda: math.sqrt(self._exactly_on_placed_grid(output, stop, start)),
                lambda: math.sqrt(self.transfer(output).band_mean_square(start, stop)),
            ),
        )

    def band_mean_square_by_modes(self, output: str, stop: float, start: float = 0.0) -> float:
        """Mean square from `start` to `stop` (rad/s) in closed form, unconfirmed; by a rule of a sampled density."""
        if self._sampled is not None:
            start, stop = max(start, self._sampled.start), min(stop, self._sampled.stop)
            return self._by_modes_on(self._placed(self.poles, stop, start), output) if start < stop else 0.0
        if (start, stop) not in self._by_modes:
            squares = self.modes.mean_squares(start, stop).tolist()
            self._by_modes[start, stop] = dict(zip(self.modes.outputs, squares, strict=True))
        return self._by_modes[start, stop][output]

    def rms_on(self, rule: quadrature.Quadrature, output: str) -> float:
        """Root mean square by the port map on a rule that many devices share, unconfirmed."""
        z, _ = self.plant.kept_responses(rule, output).closed(self._admittances(rule.omega))
        return math.sqrt(self._mean_squares(z, rule, 1)[0])

    def _by_modes_on(self, rule: quadrature.Quadrature, output: str, power: int = 1) -> float:
        """∫ Sᵖ dω of an output's density by the modes on a rule."""
        parts = zip(self.modes.weights, self.modes.response(rule.omega, output), strict=True)
        density = sum((weight * np.abs(z) ** 2 for weight, z in parts), np.zeros(len(rule.omega)))
        if self._sampled is not None:
            density = density * self._sampled.squares(rule.omega)
        return float(rule.weight @ density**power)

    def _sampled_rms(self, sampled: SampledDensity, output: str, start: float, stop: float) -> Settled:
        """Root mean square on a band: by modes and by the port map on other panels, or exactly at the points."""
        low, high = max(start, sampled.start), min(stop, sampled.stop)
        if low >= high:
            return Settled(0.0)

        def exactly() -> float:
            rule = self._placed(self.poles, high, low)
            weight = rule.weight * sampled.squares(rule.omega)
            return math.sqrt(self.transfer(output).weighted_sum(rule.omega, weight))

        return self.settled(
            f"the r.m.s. of {output}",
            (
                lambda: math.sqrt(self._by_modes_on(self._placed(self.poles, high, low, clear=2.5), output)),
                lambda: math.sqrt(self._on_placed_grid(output, high, low)),
                exactly,
            ),
        )

    def _placed(
        self, poles: Complex, stop: float, start: float = 0.0, clear: float = quadrature.CLEAR
    ) -> quadrature.Quadrature:
        delay = float(self.plant.delays.max(initial=0.0))
        if stop * delay > _MOST_POINTS:
            raise Unsettled(f"a delay of {delay:g} s ripples too often up to {stop:g} rad/s to be followed")
        corners = () if self._sampled is None else self._sampled.corners
        return quadrature.placed(poles, delay, start, stop, corners, clear)

    def _on_placed_grid(self, output: str, stop: float, start: float = 0.0) -> float:
        """Mean square by the port map; all outputs at once, since the grid's responses are the work."""
        if (start, stop) not in self._by_port:
            rule, outputs = self._placed(self.poles, stop, start), self.plant.outputs
            z, _ = self.plant.responses(rule.omega, *outputs).closed(self._admittances(rule.omega))
            self._by_port[start, stop] = dict(zip(outputs, self._mean_squares(z, rule, len(outputs)), strict=True))
        return self._by_port[start, stop][output]

    def _mean_squares(self, z: Complex, rule: quadrature.Quadrature, outputs: int) -> list[float]:
        """Of responses that have all of the grid for each output and process in turn."""
        squares = (np.abs(z) ** 2).reshape(outputs, len(self.plant.shares), -1) @ rule.weight
        found: list[float] = (self.plant.density * squares @ np.array(self.plant.shares)).tolist()
        return found

    def _exactly_on_placed_grid(self, output: str, stop: float, start: float) -> float:
        transfer = self.transfer(output)
        poles = np.array([complex(pole.real.mid(), pole.imag.mid()) for pole in transfer.poles()])
        rule = self._placed(poles, stop, start)
        return transfer.weighted_sum(rule.omega, rule.weight)

    def rms(self, output: str) -> Settled:
        """Root mean square over all frequencies; infinite where white noise passes straight through."""
        if output not in self._rms:
            self._rms[output] = self._root_mean_square(output)
        return self._rms[output]

    def _root_mean_square(self, output: str) -> Settled:
        if self._sampled is not None:
            return self._sampled_rms(self._sampled, output, 0.0, math.inf)
        if self._passes_noise(output):
            return Settled(math.inf)

        def by_covariance() -> float:
            return math.sqrt(h2_norm.mean_square(self.shaped_loop(), output))

        def by_modes() -> float:
            squares = self.modes.whole_mean_squares().tolist()
            return math.sqrt(squares[self.modes.outputs.index(output)])

        return self.settled(
            f"the r.m.s. of {output}",
            (
                by_covariance if self.confirmed else by_modes,
                lambda: math.sqrt(self.transfer(output).mean_square_by_residues()),
                lambda: math.sqrt(self.transfer(output).mean_square()),
            ),
        )

    def _passes_noise(self, output: str) -> bool:
        """Whether white noise passes straight through, decided exactly where the figure is to be confirmed."""
        if self.confirmed:
            return not self.transfer(output).strictly_proper
        shaping = self.plant.shaping
        through = shaping is None or bool(shaping.rational.D[0, 0])
        return through and bool(self.loop.D[self.loop.output(output)].any())

    def rms_by_frequency(self, output: str) -> float:
        """The same by quadrature on the whole axis, for a plant without delays."""
        top = 2 * float(np.abs(self.poles).max(initial=1.0))
        rule = quadrature.beyond(self.poles, top)
        z, _ = self.plant.responses(rule.omega, output).closed(self._admittances(rule.omega))
        return math.sqrt(self._on_placed_grid(output, top) + self._mean_squares(z, rule, 1)[0])

    def summed_rms(self, output: str, rule: quadrature.Quadrature) -> Settled:
        """√(Σ |z|² S Δω) over an even grid."""
        return self.settled(
            f"the sum for {output}",
            (
                lambda: self.rms_on(rule, output),
                lambda: math.sqrt(self._by_modes_on(rule, output)),
                lambda: math.sqrt(self.transfer(output).weighted_sum(rule.omega, self._sampled_weight(rule))),
            ),
        )

    def _sampled_weight(self, rule: quadrature.Quadrature) -> Real:
        return rule.weight if self._sampled is None else rule.weight * self._sampled.squares(rule.omega)

    def density(self, output: str, omega: Real) -> Real:
        """Single-sided spectral density of an output at each `omega` (rad/s), per rad/s."""
        z, _ = self.plant.responses(omega, output).closed(self._admittances(omega))
        squares = (np.abs(z) ** 2).reshape(len(self.plant.shares), -1)
        return np.asarray(self.plant.density * np.array(self.plant.shares) @ squares)

    def squared_density(self, output: str, top: float) -> Settled:
        """∫ S(ω)² dω of an output's density S per rad/s up to `top` (rad/s), beyond which nothing is left of it."""

        def by_port(stop: float) -> float:
            low, high = ends(stop)
            rule = self._placed(self.poles, high, low)
            return float(rule.weight @ self.density(output, rule.omega) ** 2)

        def by_modes() -> float:
            low, high = ends(2 * top)
            return self._by_modes_on(self._placed(self.poles, high, low, clear=2.5), output, power=2)

        def ends(stop: float) -> tuple[float, float]:
            return (0.0, stop) if self._sampled is None else (self._sampled.start, min(stop, self._sampled.stop))

        return self.settled(f"the spread of {output}", (by_modes, lambda: by_port(top), lambda: by_port(4 * top)))

    # --- gains and peaks -----------------------------------------------------------------------------------------

    def largest_gain(self, output: str) -> tuple[Settled, float]:
        """The largest gain over all frequencies (of several processes, singular value) and its frequency, rad/s."""
        name = f"the largest gain to {output}"
        grid = np.concatenate([self._gain_grid(self.poles), hinf_norm.grid(self.plant)])
        value, omega = hinf_norm.largest(self.loop, output, grid)

        def by_port() -> float:
            at = np.append(grid, min(omega, _BEYOND * float(grid.max())))
            z, _ = self.plant.responses(at, output).closed(self._admittances(at))
            return float(np.linalg.norm(z.reshape(-1, len(at)), axis=0).max())

        try:
            return self.settled(name, (lambda: value, lambda: self.transfer(output).largest_gain()[0], by_port)), omega
        except Unsettled:
            transfer = self.transfer(output)
            poles = np.array([complex(pole.real.mid(), pole.imag.mid()) for pole in transfer.poles()])
            seen, at = transfer.largest_gain_on(np.unique(np.abs(poles)))
            measured = settled(name, (lambda: value, lambda: seen, lambda: transfer.largest_gain()[0]))
            return measured, at

    def _gain_grid(self, poles: Complex) -> Real:
        return self._placed(poles, 10 * float(np.abs(poles).max(initial=1.0))).omega

    def _admittances(self, omega: Real) -> dict[str, Complex]:
        return {name: np.asarray(device(1j * omega)) for name, device in self.devices.items()}

    def peak(self, output: str, corners: Corners) -> tuple[Settled, float]:
        """The largest |z(t)| after an input made of ramps, and its instant in s (infinite: the limit)."""

        def confirmed(of: Modes, second: Callable[[float], float]) -> tuple[Settled, float]:
            value, instant = time_response.peak(of, output, corners)
            if math.isinf(instant):
                ways = (lambda: value, lambda: self._limit(output, corners))
                return self.settled(f"the limit of {output}", ways), instant
            return self.settled(f"the peak of {output}", (lambda: value, lambda: abs(second(instant)))), instant

        try:
            return confirmed(self.modes, lambda instant: self.transfer(output).ramp(instant, corners))
        except Unsettled:  # modes so far apart that floats lose them, and the instant with them
            transfer = self.transfer(output)
            return confirmed(transfer.modes(output), lambda instant: transfer.ramp_by_exponential(instant, corners))

    def _limit(self, output: str, corners: Corners) -> float:
        z = self.transfer(output)
        static = sum(exact.to_float(top[0] / z.denominator[0]) for driven in z.numerators for top, _ in driven)
        return abs(static * sum(change * instant for instant, change in corners))
