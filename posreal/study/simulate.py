"""A device in time: Coulomb friction, backlash and end stops in its elements, on one random track and onto a ramp.

The same seeded track shakes the vehicle as it comes, with the linear device and with the real one, so that what
friction and play cost is told far better than any figure by itself. Beside it stand the exact linear figure, by
frequency, and what statistical linearisation of the friction gives there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from posreal.errors import BadInput, listed, shown
from posreal.metric import Metric, Norm, PeakInTime, WeightedSum
from posreal.network import Network, Spring
from posreal.network.substitution import with_dampers_across
from posreal.optimisation.evaluate import evaluate
from posreal.plant.mounting import Copy
from posreal.plant.plant import Plant
from posreal.simulation import figures, track
from posreal.simulation.laws import STOP, ElementLaw
from posreal.simulation.statistical import equivalent_dampers
from posreal.simulation.stepper import History, beside, stepper
from posreal.specification.design import Design
from posreal.specification.mounted import BUSH, mounted
from posreal.specification.problem import Problem
from posreal.study.simulate_result import InMotion, InTime, Simulation
from posreal.study.tolerance import as_network

Real = np.ndarray
RECORDS, DURATION, STEP = 8, 60.0, 1e-3
WARM = 10.0  # s of every record that do not count: transients die out
STILL = 1e-9  # m/s: less than that is rounding
RAMP = 8.0  # s, of a curve or slope in which a peak counts
_MOST = 2e8  # numbers that a run may keep


def simulate(
    problem_or_design: Problem | Design,
    device: Any = None,
    *,
    friction: float | Mapping[str, float] = 0.0,
    backlash: float | Mapping[str, float] = 0.0,
    stop: float | Mapping[str, float] = math.inf,
    stop_stiffness: float = STOP,
    records: int = RECORDS,
    duration: float = DURATION,
    step: float = STEP,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Simulation:
    """Simulate a device whose elements rub, have play and end.

    Parameters
    ----------
    problem_or_design : Problem or Design
    device : as :func:`posreal.evaluate` takes it
        An admittance is realised as a network first.
    friction : float or mapping of element to float
        Coulomb friction, N; one number is of every inerter.
    backlash : float or mapping of spring to float
        Total play in series with a spring, m; one number is of the bush.
    stop : float or mapping of element to float
        Elongation either way at which an element ends, m; one number is of every inerter.
    stop_stiffness : float
        N/m.
    records, duration : so many records of random track, of so many seconds that count
    step : float
        s, at most.
    seed : int
    progress : function of str

    Returns
    -------
    Simulation

    Raises
    ------
    BadInput
        For an element that there is not, a play of what is no spring, or a number out of range.
    Infeasible
        If the vehicle is not stable.
    """
    _require_range(records=(records, 1, 1000), duration=(duration, 1.0, 1e4), step=(step, 1e-5, 1e-2))
    design = problem_or_design if isinstance(problem_or_design, Design) else evaluate(problem_or_design, device)
    design = as_network(design)
    if design.network is None:
        raise BadInput("there is no device to be simulated; give one with elements")
    strut = _strut(design)
    laws = _laws(strut, friction, backlash, stop, stop_stiffness)
    scene = _Scene(design.problem, records, duration, step, seed)
    progress("linear, on the random track and onto ramps")
    linear = scene.runs(strut, {})
    default = scene.runs(*scene.default, {}) if scene.default else None
    progress("with friction, backlash and stops")
    real = scene.runs(strut, laws) if laws else linear
    return _summary(design, strut, laws, scene, linear, real, default)


def _require_range(**given: tuple[float, float, float]) -> None:
    for name, (value, low, high) in given.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            raise BadInput(f"{name} is {shown(value)}; give from {low:g} to {high:g}")


def _strut(design: Design) -> Network:
    """The network between the terminals, the vehicle's own spring in it."""
    network, problem = design.network, design.problem
    assert network is not None
    if design.whole:
        return network
    behind = problem.mounting.behind
    if behind is None or "bush" in problem.roles:
        return mounted(problem, network)
    stiffness = behind.inverse().inertance  # of a spring, 1/k
    if behind.degree != 1 or not stiffness or behind.static_stiffness == 0:
        raise BadInput("what stands behind the device is no spring, and cannot be simulated")
    return Spring(1 / stiffness, BUSH) + network


def _laws(
    strut: Network,
    friction: float | Mapping[str, float],
    backlash: float | Mapping[str, float],
    stop: float | Mapping[str, float],
    stop_stiffness: float,
) -> dict[str, ElementLaw]:
    names, values = strut.names, strut.values()
    inerters = [name for name in names if name[0] == "b"]
    bush = [name for name in names if name == BUSH] or [name for name in names if name[0] == "k"][:1]

    def spread(what: str, given: float | Mapping[str, float], usual: list[str], none: float) -> dict[str, float]:
        if not isinstance(given, Mapping):
            if given != none and not usual:
                kind = "spring" if what == "backlash" else "inerter"
                raise BadInput(f"{what}: the device has no {kind}; name an element, one of {listed(names)}")
            given = dict.fromkeys(usual, given) if given != none else {}
        for name, value in given.items():
            if name not in names:
                raise BadInput(f"{what}: there is no element {shown(name)}; its elements are {listed(names)}")
            if what == "backlash" and name[0] != "k":
                raise BadInput(f"backlash: {name} is no spring; play is in series with a spring")
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= (none or 1e9):
                raise BadInput(f"{what} of {name} is {shown(value)}; give a number of at least 0")
        return {str(name): float(value) for name, value in given.items()}

    rubs = spread("friction", friction, inerters, 0.0)
    plays = spread("backlash", backlash, bush, 0.0)
    ends = spread("stop", stop, inerters, math.inf)
    found = {
        name: ElementLaw(
            rubs.get(name, 0.0), values[name], plays.get(name, 0.0), ends.get(name, math.inf), stop_stiffness
        )
        for name in names
    }
    for name, law in found.items():
        if law.stop <= law.backlash / 2:
            raise BadInput(f"the stop of {name} lies within its play; give one beyond {law.backlash / 2:g} m")
    return {name: law for name, law in found.items() if not law.nothing}


class _Scene:
    """A problem's vehicle on random track and on each of its ramps."""

    def __init__(self, problem: Problem, records: int, duration: float, step: float, seed: int) -> None:
        self.problem, self.records, self.duration, self.seed = problem, records, duration, seed
        vehicle = problem.vehicle
        self.metrics = {name: vehicle.metrics[name] for name in _shown(problem)}
        parts = [part for one in self.metrics.values() for part in _parts(one)]
        self.ramps = {(part.load, part.corners) for part in parts if isinstance(part, PeakInTime)}
        around = problem.layout_mounting.beside
        random = beside(vehicle.plant(vehicle.random), around)
        self.step = track.step_for(random, step)
        count = round((WARM + duration) / self.step)
        if count * records * (len(random.outputs) + 2 * len(random.delays) + 10) > _MOST:
            raise BadInput("so many records of such a duration in such steps do not fit; take fewer, or a longer step")
        self.warm = round(WARM / self.step)
        self.plants = {None: random} | {load: beside(vehicle.plant(load), around) for load, _ in self.ramps}
        self.shaken = track.random_track(random, self.step, count, records, seed)

    @property
    def copies(self) -> tuple[Copy, ...]:
        """How devices sit in the ports."""
        ports = len(self.plants[None].groups)
        alone = tuple(Copy(tuple(float(i == j) for i in range(ports))) for j in range(ports))
        return self.problem.place.copies or alone

    @property
    def default(self) -> tuple[Network | None] | None:
        """The strut of the default suspension, None where there is none; nothing where the vehicle has no default."""
        problem = self.problem.original
        if problem.default_port is None:
            return None
        if problem.default_device is None:
            return (None,)
        return (_strut(as_network(evaluate(problem, None))),)

    def runs(self, strut: Network | None, laws: Mapping[str, ElementLaw]) -> dict[Any, History]:
        """The random track under None, each ramp under its load and corners."""
        found: dict[Any, History] = {None: self._run(None, strut, laws, self.shaken)}
        for load, corners in self.ramps:
            w = track.ramps(self.plants[load], self.step, round(RAMP / self.step), corners)
            found[load, corners] = self._run(load, strut, laws, w)
        return found

    def _run(self, load: str | None, strut: Network | None, laws: Mapping[str, ElementLaw], w: Real) -> History:
        return stepper(self.plants[load], strut, self.copies, laws, self.step).run(w)

    def squares(self, norm: Norm, runs: Mapping[Any, History]) -> Real:
        """Mean square of every record, in the metric's unit squared."""
        run, plant = runs[None], self.plants[None]
        z = run.outputs[self.warm :, :, plant.output(norm.output)]
        factor = norm.factor(self.problem.vehicle) ** 2
        return factor * figures.mean_squares(z, run.step, norm.start, norm.stop)

    def value(self, metric: Metric, runs: Mapping[Any, History]) -> float:
        """A metric of a run."""
        if isinstance(metric, WeightedSum):
            return sum(weight * self.value(part, runs) for weight, part in metric.parts)
        if isinstance(metric, PeakInTime):
            plant = self.plants[metric.load]
            z = runs[metric.load, metric.corners].outputs[:, 0, plant.output(metric.output)]
            return metric.factor * float(np.abs(z).max())
        norm = metric.norm()
        assert norm is not None
        return math.sqrt(float(self.squares(norm, runs).mean()))


def _shown(problem: Problem) -> list[str]:
    """The metrics that are always shown, and the objective, as far as a run on the vehicle's loads has them."""
    vehicle = problem.vehicle
    names = dict.fromkeys([*vehicle.headline, problem.base_objective])
    known = {name: vehicle.metrics[name] for name in names if name in vehicle.metrics}
    return [name for name, one in known.items() if all(_simulated(part, problem) for part in _parts(one))]


def _parts(metric: Metric) -> list[Metric]:
    return [part for _, part in metric.parts] if isinstance(metric, WeightedSum) else [metric]


def _simulated(metric: Metric, problem: Problem) -> bool:
    if isinstance(metric, PeakInTime):
        return True
    norm, vehicle = metric.norm(), problem.vehicle
    if norm is None or norm.kind != "H2" or norm.load != vehicle.random:
        return False
    return norm.speed is None or norm.speed == vehicle.V


def _summary(
    design: Design,
    strut: Network,
    laws: Mapping[str, ElementLaw],
    scene: _Scene,
    linear: Mapping[Any, History],
    real: Mapping[Any, History],
    default: Mapping[Any, History] | None,
) -> Simulation:
    friction = {name: law.friction for name, law in laws.items() if law.friction}
    problem, dampers, statistical = design.problem, dict[str, float](), None
    if friction:
        plant: Plant = problem.vehicle.plant(problem.vehicle.random)
        dampers = equivalent_dampers(plant, problem.layout_mounting, strut, scene.copies, friction)
        if not any(law.backlash or math.isfinite(law.stop) for law in laws.values()):
            damped = with_dampers_across(strut, dampers).admittance()
            statistical = problem.metrics(problem.port(damped, whole=True))
    metrics = {}
    for name, metric in scene.metrics.items():
        norm, error = metric.norm(), None
        if norm is not None:
            error = figures.ratio(scene.squares(norm, real), scene.squares(norm, linear))[1]
        random = not any(isinstance(part, PeakInTime) for part in _parts(metric))
        metrics[name] = InTime(
            exact=design.metrics[name].value,
            linear=scene.value(metric, linear),
            real=scene.value(metric, real),
            default=None if default is None else scene.value(metric, default),
            error=None if error is None or math.isnan(error) else error,
            statistical=statistical[name].value if statistical is not None and random else None,
            unit=design.metrics[name].unit,
        )
    run, warm = real[None], scene.warm
    force = run.force[warm:]
    elements = {}
    each = len(laws)
    for j, (name, law) in enumerate((n, laws[n]) for n in strut.names if n in laws):
        held = np.abs(run.velocity[warm:, :, j::each]) <= STILL
        elements[name] = InMotion(
            law=law,
            stuck=float(held.mean(axis=(0, 1)).max()) if law.friction else 0.0,
            stroke=float(run.elongation[:, j::each].max()),
            velocity=float(np.sqrt((run.velocity[warm:, :, j::each] ** 2).mean(axis=(0, 1)).max())),
            damper=dampers.get(name),
        )
    worst = float(np.sqrt((force**2).mean(axis=(0, 1)).max())), float(np.abs(force).max())
    return Simulation(design, strut, metrics, elements, worst, scene.records, scene.duration, scene.step, scene.seed)
