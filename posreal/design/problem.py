"""What to minimise over passive devices, on which vehicle, subject to what.

A problem cuts its vehicle open at the secondary suspension. What stays there whatever the device is its
:class:`Mounting`: an admittance beside the device and a bush in series with it,

    Y_port = Y_beside + 1/(1/Y_behind + 1/Y_device).

Constraints are named by the metric they limit; "no worse than the default" is the same vehicle's own figure with its
default suspension, recomputed for the vehicle at hand.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput, hint
from posreal.vehicle import Metric, PlanView, QuarterCar, SideView, from_file, override
from posreal.vehicle.metrics import lateral_metrics, quarter_car_metrics, vertical_metrics

Vehicle = PlanView | SideView | QuarterCar
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
    vehicle : PlanView, SideView or QuarterCar
    objective : str
        Name of the metric that is minimised.
    keep : tuple of str
        Metrics that may be no worse than with the vehicle's default suspension.
    free : mapping of vehicle parameter to Range
        Vehicle parameters that the designer may choose too.
    """

    name: str
    summary: str
    vehicle: Vehicle
    objective: str
    keep: tuple[str, ...] = ()
    free: Mapping[str, Range] = dataclasses.field(default_factory=dict)

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
        raise AssertionError(self.vehicle)

    @property
    def layout_mounting(self) -> Mounting:
        """The mounting of a layout, which brings its own static spring or bush: only an airspring stays beside."""
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
        return None if isinstance(self.vehicle, QuarterCar) else self.port(self.default_device)

    # --- what counts -----------------------------------------------------------------------------------------

    def metrics(self, port: Rational) -> dict[str, Metric]:
        """Every metric of the vehicle with the admittance `port` in its secondary port.

        Raises
        ------
        Infeasible
            If the vehicle is not stable.
        """
        match self.vehicle:
            case PlanView() as plan:
                return lateral_metrics(plan, port)
            case SideView() as side:
                return vertical_metrics(side, port)
            case QuarterCar() as quarter:
                return quarter_car_metrics(quarter, port)
        raise AssertionError(self.vehicle)

    @cached_property
    def default_metrics(self) -> dict[str, Metric] | None:
        """Every metric with the default suspension."""
        return None if self.default_port is None else self.metrics(self.default_port)

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints with their values."""
        if not self.keep or self.default_metrics is None:
            return ()
        return tuple(
            Constraint(name, ">=" if name == "Ldmp" else "<=", self.default_metrics[name].value, "the default's")
            for name in self.keep
        )

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
) -> Problem:
    """A design problem by name.

    Parameters
    ----------
    name : str
        ``lateral-comfort``, ``lateral-comfort-primary``, ``lateral-gauging``, ``lateral-gauging-primary``,
        ``vertical-comfort`` or ``quarter-car``.
    position : {"L", "M", "T"}, optional
        Where ride is measured in ``vertical-comfort`` (T by default).
    objective : {"J1", "J3"}, optional
        What is minimised in ``quarter-car`` (J1 by default).
    stiffness : float, optional
        Static stiffness of ``quarter-car``, N/m.
    vehicle_file : path, optional
        TOML file whose table ``[plan-view]``, ``[side-view]`` or ``[quarter-car]`` overrides parameters.
    vehicle : mapping, optional
        Parameters to override, numbers in SI units or text with a unit.

    Raises
    ------
    BadInput
        For an unknown name, an option that the problem does not have, or a bad parameter.
    """
    if name not in _PROBLEMS:
        raise BadInput(f"unknown problem {name!r}; {hint(name, _PROBLEMS)}")
    chosen = _PROBLEMS[name]
    if position is not None:
        if not isinstance(chosen.vehicle, SideView) or position not in ("L", "M", "T"):
            raise BadInput(f"position {position!r} does not fit {name}; vertical-comfort takes L, M or T")
        chosen = dataclasses.replace(chosen, objective=f"J1z_{position}")
    if objective is not None:
        if not isinstance(chosen.vehicle, QuarterCar) or objective not in ("J1", "J3"):
            raise BadInput(f"objective {objective!r} does not fit {name}; quarter-car takes J1 or J3")
        chosen = dataclasses.replace(chosen, objective=objective)
    model: Vehicle = chosen.vehicle
    if vehicle_file is not None:
        model = from_file(model, vehicle_file, model.name, tuple(kind.name for kind in VEHICLES))
    if vehicle:
        model = override(model, vehicle)
    if stiffness is not None:
        if not isinstance(model, QuarterCar):
            raise BadInput(f"a static stiffness does not fit {name}; only quarter-car takes one")
        model = override(model, {"k": stiffness}, where="stiffness")
    return dataclasses.replace(chosen, vehicle=model)
