"""What to minimise over passive devices, on which vehicle, subject to what.

A problem cuts its vehicle open at the secondary suspension. What stays there whatever the device is its
:class:`Mounting`: an admittance beside the device and a bush in series with it,

    Y_port = Y_beside + 1/(1/Y_behind + 1/Y_device).

Constraints are named by the metric they limit; "no worse than the default" is the same vehicle's own figure with its
default suspension, recomputed for the vehicle at hand; `at_most` are numbers of the user's own. The objective may be a
:class:`Goal` made of several metrics, and may be the worst over several operating points.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.design.goal import Goal, weighted_sum
from posreal.errors import BadInput, hint, listed
from posreal.vehicle import Metric, Plant, PlanView, QuarterCar, SideView, close, from_file, gain, override
from posreal.vehicle.metrics import lateral_metrics, quarter_car_metrics, vertical_metrics
from posreal.vehicle.user_plant import UserPlant, user_metrics

Vehicle = PlanView | SideView | QuarterCar | UserPlant
VEHICLES: tuple[type[PlanView] | type[SideView] | type[QuarterCar], ...] = (PlanView, SideView, QuarterCar)


@dataclass(frozen=True)
class Mounting:
    """What the port holds besides the device: `beside` in parallel, `behind` in series with the device."""

    beside: Rational | None
    behind: Rational | None

    def port(self, device: Rational | None) -> Rational:
        """The admittance of the whole port, exactly; ``None`` is no device."""
        inner = Rational.zero() if device is None else device
        if self.behind is not None and not inner.is_zero():
            inner = self.behind + inner
        return inner if self.beside is None else self.beside | inner

    def device(self, port: Rational) -> Rational:
        """The device of a whole port, exactly: :meth:`port` backwards."""
        inner = port if self.beside is None else port.without(self.beside)
        if self.behind is None or inner.is_zero():
            return inner
        return inner.inverse().without(self.behind.inverse()).inverse()

    def response(self, Y: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Y_port and ∂Y_port/∂Y_device at the points `s`, for a device given by its values `Y` there."""
        if self.behind is None:
            inner, slope = Y, np.ones_like(Y)
        else:
            bush = np.asarray(self.behind(s))
            slope = (bush / (bush + Y)) ** 2
            inner = bush * Y / (bush + Y)
        return (inner if self.beside is None else np.asarray(self.beside(s)) + inner), slope


@dataclass(frozen=True)
class Constraint:
    """`metric` at least (`sense` ">=") or at most ("<=") `value`, in the metric's own unit."""

    metric: str
    sense: str
    value: float
    reason: str = ""

    def margin(self, metrics: Mapping[str, Metric]) -> float:
        """How far inside the constraint, in the metric's unit; negative outside."""
        slack = metrics[self.metric].value - self.value
        return slack if self.sense == ">=" else -slack

    def __str__(self) -> str:
        return f"{self.metric} {self.sense} {self.value:.6g}" + (f" ({self.reason})" if self.reason else "")


@dataclass(frozen=True)
class Range:
    """Bounds of a vehicle parameter that the problem leaves free."""

    lower: float
    upper: float


@dataclass(frozen=True)
class Problem:
    """One design problem; see :func:`problem` for the named ones.

    Attributes
    ----------
    name : str
    summary : str
        One sentence for tables.
    vehicle : PlanView, SideView, QuarterCar or UserPlant
    objective : str
        Name of the metric that is minimised.
    keep : tuple of str
        Metrics that may be no worse than with the vehicle's default suspension.
    free : mapping of vehicle parameter to Range
        Vehicle parameters that the designer may choose too.
    at_most : mapping of metric to float
        Upper limits on metrics, in their units. Besides the vehicle's metrics, ``inertance`` (kg, of the whole port
        at high frequency) and ``gain_OUTPUT`` (largest gain over all frequencies) may be limited and minimised.
    goal : Goal or None
        What the objective is made of, where it is not a metric of the vehicle.
    points : tuple of mappings of vehicle parameter to value
        Operating points besides the nominal one; the objective is then the worst over all of them.
    """

    name: str
    summary: str
    vehicle: Vehicle
    objective: str
    keep: tuple[str, ...] = ()
    free: Mapping[str, Range] = dataclasses.field(default_factory=dict)
    at_most: Mapping[str, float] = dataclasses.field(default_factory=dict)
    goal: Goal | None = None
    points: tuple[Mapping[str, float], ...] = ()

    # --- the vehicle around the device -----------------------------------------------------------------------

    def with_vehicle(self, values: Mapping[str, float]) -> Problem:
        """The same problem with some vehicle parameters re-tuned: reference and constraints stay the original's."""
        if not values:
            return self
        tuned = dataclasses.replace(self, vehicle=override(self.vehicle, values))
        tuned.__dict__["default_metrics"] = self.default_metrics
        return tuned

    @property
    def mounting(self) -> Mounting:
        """What the port holds besides the device."""
        match self.vehicle:
            case PlanView(Ksy=k) | QuarterCar(k=k):
                return Mounting(beside=Rational.spring(k), behind=None)
            case SideView() as side:
                return Mounting(beside=side.airspring(), behind=Rational.spring(side.bush))
            case UserPlant() as own:
                return Mounting(own.beside, own.behind)
        raise AssertionError(self.vehicle)

    @property
    def roles(self) -> dict[str, str]:
        """Elements of a layout that stand for a part of the vehicle: role → vehicle parameter."""
        match self.vehicle:
            case PlanView():
                return {"static spring": "Ksy"}
            case QuarterCar():
                return {"static spring": "k"}
            case SideView():
                return {"bush": "bush"}
            case UserPlant():
                return {}
        raise AssertionError(self.vehicle)

    @property
    def layout_mounting(self) -> Mounting:
        """The mounting of a layout, which brings its own static spring or bush: only an airspring stays beside."""
        if isinstance(self.vehicle, UserPlant):
            return Mounting(self.vehicle.beside, None)
        return Mounting(self.vehicle.airspring() if isinstance(self.vehicle, SideView) else None, None)

    def port(self, device: Rational | None, *, whole: bool = False) -> Rational:
        """Port admittance with `device` in its place, or with a `whole` strut, as a layout is."""
        return (self.layout_mounting if whole else self.mounting).port(device)

    @property
    def default_device(self) -> Rational | None:
        """What the vehicle comes with in the device's place."""
        return Rational.damper(self.vehicle.Csy) if isinstance(self.vehicle, PlanView) else None

    @property
    def default_port(self) -> Rational | None:
        """Port admittance of the vehicle's default suspension, the reference of improvements; None if it has none."""
        return None if isinstance(self.vehicle, QuarterCar | UserPlant) else self.port(self.default_device)

    # --- what counts -----------------------------------------------------------------------------------------

    def metrics(self, port: Rational) -> dict[str, Metric]:
        """Every metric of the vehicle with the admittance `port` in its secondary port.

        Raises
        ------
        Infeasible
            If the vehicle is not stable.
        """
        found = self._own_metrics(port)
        if not self.points:
            return found
        device = self.mounting.device(port)
        worst, where = found[self.base_objective], "the nominal point"
        for values in self.points:
            point = self.at_point(values)
            there = point._own_metrics(point.mounting.port(device))[self.base_objective]
            if there.value > worst.value:
                worst, where = there, ", ".join(f"{name} = {value:g}" for name, value in values.items())
        found[self.objective] = Metric(worst.value, worst.unit, f"at {where}")
        return found

    def _own_metrics(self, port: Rational) -> dict[str, Metric]:
        match self.vehicle:
            case PlanView() as plan:
                found = lateral_metrics(plan, port)
            case SideView() as side:
                found = vertical_metrics(side, port)
            case QuarterCar() as quarter:
                found = quarter_car_metrics(quarter, port)
            case UserPlant() as own:
                found = user_metrics(own, port)
        asked = {self.base_objective, *self.at_most} | {name for name, _ in (self.goal.parts if self.goal else ())}
        if "inertance" in asked:
            found["inertance"] = Metric(float(port.inertance), "kg")
        for name in sorted(asked):
            if name.startswith("gain_"):
                plant = self.plant
                loop = close(plant, {"secondary": state_space(port)})
                top, omega = gain.largest(loop, name.removeprefix("gain_"), gain.grid(plant))
                found[name] = Metric(top, "1", f"at {omega:.4g} rad/s")
        if self.goal is not None:
            found[self.goal.name] = self.goal.of(found)
        return found

    @property
    def plant(self) -> Plant:
        """The vehicle on its random track or road, cut open at the device."""
        match self.vehicle:
            case PlanView() as plan:
                return plan.random_track()
            case SideView() as side:
                return side.track()
            case QuarterCar() as quarter:
                return quarter.road()
            case UserPlant() as own:
                return own.plant
        raise AssertionError(self.vehicle)

    @property
    def base_objective(self) -> str:
        """The objective at one operating point."""
        return self.objective.removeprefix(_WORST_CASE) if self.points else self.objective

    def at_point(self, values: Mapping[str, float]) -> Problem:
        """The same objective at one of the operating points alone, without constraints."""
        vehicle = override(self.vehicle, values)
        return dataclasses.replace(
            self, vehicle=vehicle, objective=self.base_objective, points=(), keep=(), free={}, at_most={}
        )

    @cached_property
    def default_metrics(self) -> dict[str, Metric] | None:
        """Every metric with the default suspension."""
        return None if self.default_port is None else self.metrics(self.default_port)

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints with their values."""
        kept: tuple[Constraint, ...] = ()
        if self.keep and self.default_metrics is not None:
            kept = tuple(
                Constraint(name, ">=" if name == "Ldmp" else "<=", self.default_metrics[name].value, "the default's")
                for name in self.keep
            )
        return kept + tuple(Constraint(name, "<=", value, "a limit") for name, value in self.at_most.items())

    def violated(self, metrics: Mapping[str, Metric], *, tolerance: float = 1e-9) -> list[str]:
        """The constraints that `metrics` break by more than `tolerance` of their value, as sentences."""
        return [
            f"{constraint} is violated: {metrics[constraint.metric].value:.6g}"
            for constraint in self.constraints
            if constraint.margin(metrics) < -tolerance * abs(constraint.value)
        ]

    def improvement(self, metrics: Mapping[str, Metric], name: str | None = None) -> float | None:
        """Per cent by which a metric (the objective by default) is better than the default suspension's."""
        if self.default_metrics is None:
            return None
        name = name or self.objective
        return 100 * (1 - metrics[name].value / self.default_metrics[name].value)


_WORST_CASE = "worst-case "

_KPY, _CPY, _KSY = Range(2.4e6, 9.4e6), Range(2.4e3, 6e4), Range(1.2e5, 4.9e5)
"""Half to twice the default stiffnesses, a fifth to five times the damping: a re-tuning, not another vehicle."""


def _lateral(name: str, summary: str, objective: str, keep: tuple[str, ...], **free: Range) -> Problem:
    return Problem(name, summary, PlanView(), objective, keep, free)


_PROBLEMS: dict[str, Problem] = {
    entry.name: entry
    for entry in (
        _lateral("lateral-comfort", "least lateral body acceleration, damping kept", "Macc", ("Ldmp",)),
        _lateral(
            "lateral-comfort-primary",
            "least lateral body acceleration, damping kept, primary lateral suspension free",
            "Macc",
            ("Ldmp",),
            Kpy=_KPY,
            Cpy=_CPY,
        ),
        _lateral(
            "lateral-gauging",
            "least body displacement entering a curve, damping and comfort kept, static spring free",
            "max_yv",
            ("Ldmp", "Macc"),
            Ksy=_KSY,
        ),
        _lateral(
            "lateral-gauging-primary",
            "least body displacement entering a curve, damping and comfort kept, static and primary free",
            "max_yv",
            ("Ldmp", "Macc"),
            Kpy=_KPY,
            Cpy=_CPY,
            Ksy=_KSY,
        ),
        Problem(
            "vertical-comfort",
            "least vertical body acceleration over the trailing bogie",
            SideView(),
            "J1z_T",
        ),
        Problem(
            "quarter-car",
            "least body acceleration of a quarter-car, static stiffness kept",
            QuarterCar(),
            "J1",
        ),
    )
}


def problems() -> tuple[Problem, ...]:
    """Every named problem."""
    return tuple(_PROBLEMS.values())


def problem(
    name: str,
    *,
    position: str | None = None,
    objective: str | None = None,
    stiffness: float | None = None,
    vehicle_file: Any = None,
    vehicle: Mapping[str, Any] | None = None,
    limits: Mapping[str, float] | None = None,
    worst_case: Sequence[Mapping[str, Any]] = (),
) -> Problem:
    """A design problem by name.

    Parameters
    ----------
    name : str
        ``lateral-comfort``, ``lateral-comfort-primary``, ``lateral-gauging``, ``lateral-gauging-primary``,
        ``vertical-comfort`` or ``quarter-car``.
    position : {"L", "M", "T", "worst"}, optional
        Where ride is measured in ``vertical-comfort`` (T by default); ``worst`` minimises the worst of the three.
    objective : str, optional
        What is minimised in ``quarter-car`` (J1 by default): ``J1``, ``J3``, ``gain_acceleration`` or
        ``gain_tyre_force`` (the H∞ norm from road velocity), or a weighted sum such as ``J1 + 0.001*J3``.
    stiffness : float, optional
        Static stiffness of ``quarter-car``, N/m.
    vehicle_file : path, optional
        TOML file whose table ``[plan-view]``, ``[side-view]`` or ``[quarter-car]`` overrides parameters.
    vehicle : mapping, optional
        Parameters to override, numbers in SI units or text with a unit.
    limits : mapping of metric to number, optional
        Upper limits on metrics, in their units, such as ``{"deflection_rear": 34.0}``.
    worst_case : sequence of mappings, optional
        Operating points besides the nominal one, each as parameters to override; the worst over all is minimised.

    Raises
    ------
    BadInput
        For an unknown name, an option that the problem does not have, or a bad parameter.
    """
    if name not in _PROBLEMS:
        raise BadInput(f"unknown problem {name!r}; {hint(name, _PROBLEMS)}")
    chosen = _PROBLEMS[name]
    if position is not None:
        if not isinstance(chosen.vehicle, SideView) or position not in ("L", "M", "T", "worst"):
            raise BadInput(f"position {position!r} does not fit {name}; vertical-comfort takes L, M or T, or worst")
        if position == "worst":
            goal = Goal("worst", tuple((f"J1z_{point}", 1.0) for point in "LMT"))
            chosen = dataclasses.replace(chosen, objective=goal.name, goal=goal)
        else:
            chosen = dataclasses.replace(chosen, objective=f"J1z_{position}")
    if objective is not None:
        if not isinstance(chosen.vehicle, QuarterCar):
            raise BadInput(f"objective {objective!r} does not fit {name}; only quarter-car takes one")
        chosen = _minimising(chosen, objective)
    model: Vehicle = chosen.vehicle
    if vehicle_file is not None:
        model = from_file(model, vehicle_file, model.name, tuple(kind.name for kind in VEHICLES))
    if vehicle:
        model = override(model, vehicle)
    if stiffness is not None:
        if not isinstance(model, QuarterCar):
            raise BadInput(f"a static stiffness does not fit {name}; only quarter-car takes one")
        model = override(model, {"k": stiffness}, where="stiffness")
    chosen = dataclasses.replace(chosen, vehicle=model)
    if limits:
        chosen = limited(chosen, limits)
    return over_points(chosen, worst_case) if worst_case else chosen


def _minimising(chosen: Problem, objective: str) -> Problem:
    """The problem with another objective, a metric or a weighted sum."""
    known = ("J1", "J3", "gain_acceleration", "gain_tyre_force")
    if objective in known:
        return dataclasses.replace(chosen, objective=objective)
    goal = weighted_sum(objective) if "+" in objective else None
    if goal is None or not all(part in known for part, _ in goal.parts):
        raise BadInput(
            f"objective {objective!r} does not fit {chosen.name}; quarter-car takes J1 or J3, gain_acceleration or "
            "gain_tyre_force, or a weighted sum such as J1 + 0.001*J3"
        )
    return dataclasses.replace(chosen, objective=goal.name, goal=goal)


_LIMITED: dict[type, tuple[str, ...]] = {
    PlanView: ("Macc", "max_yv", "static_stiffness", "inertance"),
    SideView: (
        *(f"J1z_{point}" for point in "LMT"),
        *(f"deflection_{kind}{end}" for kind in ("", "rms_", "overall_") for end in ("front", "rear")),
        "static_stiffness",
        "inertance",
    ),
    QuarterCar: ("J1", "J3", "gain_acceleration", "gain_tyre_force", "static_stiffness", "inertance"),
}


def limited(problem: Problem, limits: Mapping[str, float]) -> Problem:
    """The problem with upper limits on metrics, in their units, on top of its own constraints.

    Raises
    ------
    BadInput
        For a metric that cannot be limited, or a limit that is not a number above 0.
    """
    if isinstance(problem.vehicle, UserPlant):
        outputs = problem.vehicle.plant.outputs
        known = (*(f"rms_{o}" for o in outputs), *(f"gain_{o}" for o in outputs), "static_stiffness", "inertance")
    else:
        known = _LIMITED[type(problem.vehicle)]
    for name, value in limits.items():
        if name not in known:
            raise BadInput(f"{name!r} cannot be limited in {problem.name}; {hint(name, known)}")
        if not (np.isfinite(value) and (value > 0 or (value == 0 and name == "inertance"))):
            raise BadInput(f"the limit of {name} is {value:g}; it must be finite and greater than 0")
    return dataclasses.replace(problem, at_most={**problem.at_most, **{n: float(v) for n, v in limits.items()}})


def over_points(problem: Problem, points: Sequence[Mapping[str, Any]]) -> Problem:
    """The problem whose objective is the worst over its nominal vehicle and several operating points.

    Constraints are those of the nominal vehicle; at the points the vehicle has to be stable.

    Raises
    ------
    BadInput
        For a parameter that the vehicle does not have, or a value out of range.
    """
    if isinstance(problem.vehicle, UserPlant):
        raise BadInput(f"{problem.name} has no parameters to vary; give a plant for each operating point")
    checked = []
    for point in points:
        changed = override(problem.vehicle, point, where="operating point")
        checked.append({name: float(getattr(changed, name)) for name in point})
        clash = set(point) & set(problem.free)
        if clash:
            raise BadInput(f"{listed(sorted(clash))} is free in {problem.name}, so no operating point can set it")
    objective = problem.objective if problem.points else _WORST_CASE + problem.objective
    return dataclasses.replace(problem, objective=objective, points=(*problem.points, *checked))
