"""What to minimise over passive devices, on which vehicle, subject to what.

A problem cuts its vehicle open at the secondary suspension; what stays there is its :class:`Mounting`. Constraints are
named by the metric they limit; "no worse than the default" is the same vehicle's own figure with its default
suspension, recomputed for the vehicle at hand; `at_most` are numbers of the user's own. The objective may be a
:class:`Goal` made of several metrics, and may be the worst over several operating points. Constraints then hold at each
of them: a limit is the same number everywhere, and "the default" is the default suspension in that point's vehicle.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from posreal.admittance import Rational
from posreal.errors import BadInput, Infeasible
from posreal.metric import Measured
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant
from posreal.ranges import UsualRanges
from posreal.real_elements import RealElements
from posreal.specification.constraint import ROUNDING, Constraint, Range
from posreal.specification.goal import Goal
from posreal.specification.tolerances import TOLERANCE, Tolerances, tolerances
from posreal.text_table import html
from posreal.vehicle import Place, Vehicle, gain_output, measure, override, parameters, whole_band_twin

_NOT_WORSE = 1e-6  # of a figure over all frequencies: worse by no more than that is not worse than the default
WORST_CASE = "worst-case "  # begins the objective's name where it is the worst over several operating points


@dataclass(frozen=True, repr=False)
class Problem:
    """One design problem; see :func:`problem` for the named ones.

    Attributes
    ----------
    name : str
    summary : str
        One sentence for tables.
    vehicle : Vehicle
    objective : str
        Name of the metric that is minimised.
    keep : tuple of str
        Metrics that may be no worse than with the vehicle's default suspension.
    free : mapping of vehicle parameter to Range
        Vehicle parameters that the designer may choose too.
    at_most : mapping of metric to float
        Limits on metrics, in their units: upper ones, and lower ones where more is better (a damping ratio). Besides
        the vehicle's metrics, ``gain_OUTPUT`` (largest gain over all frequencies) and ``J1z_T_whole`` (ride not ending
        at 20 Hz) may be limited and minimised, and ``inertance`` limited: lim Y/s of the whole port at high frequency
        (kg). That is not the sum of the inerters in a network of the device: one behind a spring or a damper does not
        show in it.
    goal : Goal or None
        What the objective is made of, where it is not a metric of the vehicle.
    points : tuple of mappings of vehicle parameter to value
        Operating points besides the nominal one; the objective is then the worst over all of them, and constraints
        hold at each.
    tolerances : Tolerances or None
        Where given, searches over element values keep the constraints at every corner of them (:meth:`robust`).
    ranges : UsualRanges or None
        The user's own, of what can be bought; None: the place's.
    reference : Vehicle or None
        The vehicle as it was before its parameters were re-tuned.
    band_only : bool
        Whether a design may be worse than the default suspension over all frequencies, where the objective ends at
        20 Hz. By default it may not: its ringing above is no gain.
    elements : RealElements or None
        What comes with the elements that are bought; None: they are ideal.
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
    reference: Vehicle | None = None
    tolerances: Tolerances | None = None
    ranges: UsualRanges | None = None
    band_only: bool = False
    elements: RealElements | None = None

    def robust(
        self,
        elements: float | str | Mapping[str, float] = TOLERANCE,
        vehicle: float | str | Mapping[str, float] | None = None,
    ) -> Problem:
        """The same problem, its constraints to hold in every vehicle that is built within tolerances.

        Parameters
        ----------
        elements, vehicle : as :func:`posreal.tolerance` takes them
        """
        return dataclasses.replace(self, tolerances=tolerances(elements, vehicle))

    def __repr__(self) -> str:
        return f"<Problem {self.name}: {self.summary}>"

    def __str__(self) -> str:
        """What is minimised, on which vehicle, subject to what."""
        return "\n".join([f"{self.name}: {self.summary}", *(f"  {name}: {text}" for name, text in self._described())])

    def _described(self) -> list[tuple[str, str]]:
        limits = [f"{name} no worse than the default's" for name in self.keep]
        bounds = {"<=": "at most", ">=": "at least"}
        limits += [
            f"{name} {bounds[self._sense(name)]} {value:g} {self.vehicle.metrics[name].unit}"
            for name, value in self.at_most.items()
        ]
        values = ", ".join(f"{name} = {value:g}" for name, value in parameters(self.vehicle).items())
        said = {
            "minimises": self.objective,
            "subject to": ", ".join(limits),
            "free": ", ".join(f"{name} {r.lower:g} … {r.upper:g}" for name, r in self.free.items()),
            "operating points": "; ".join(self.at_points),
            "vehicle": f"{self.vehicle.name}{f' ({values})' if values else ''}",
            "metrics": ", ".join(self.vehicle.metrics),
        }
        return [(name, text) for name, text in said.items() if text]

    def _repr_html_(self) -> str:
        return html([self.name, self.summary], self._described())

    # --- the vehicle around the device -----------------------------------------------------------------------

    def with_vehicle(self, values: Mapping[str, Any]) -> Problem:
        """The same problem with some vehicle parameters re-tuned: reference and constraints stay the original's."""
        if not values:
            return self
        vehicle, reference = override(self.vehicle, values), self.reference or self.vehicle
        tuned = dataclasses.replace(self, vehicle=vehicle, reference=None if vehicle == reference else reference)
        tuned.__dict__["original"] = self.original  # computed once, whatever is tried
        return tuned

    @cached_property
    def original(self) -> Problem:
        """The problem before its vehicle was re-tuned, to which the default's figures and the constraints belong."""
        if self.reference is None:
            return self
        return dataclasses.replace(self, vehicle=self.reference, reference=None)

    @cached_property
    def place(self) -> Place:
        """Where the device goes."""
        return self.vehicle.places["secondary"]

    @cached_property
    def mounting(self) -> Mounting:
        """What the port holds besides the device."""
        return self.place.around

    @property
    def usual(self) -> UsualRanges | None:
        """What can be bought for the place: the user's own ranges, or those that the vehicle knows of."""
        return self.ranges or self.place.usual

    @property
    def roles(self) -> Mapping[str, str]:
        """Elements of a layout that stand for a part of the vehicle: role → vehicle parameter."""
        return self.place.roles

    @cached_property
    def layout_mounting(self) -> Mounting:
        """The mounting of a layout, which brings its own static spring or bush: only an airspring stays beside."""
        return Mounting(self.place.beside_strut, None)

    def port(self, device: Rational | None, *, whole: bool = False) -> Rational:
        """Port admittance with `device` in its place, or with a `whole` strut, as a layout is."""
        return (self.layout_mounting if whole else self.mounting).port(device)

    def port_at(self, point: Problem, port: Rational, changed: Iterable[str]) -> Rational:
        """The admittance `port` with what the vehicle gives to it as it is at an operating point.

        Parameters
        ----------
        point : Problem
            The problem there.
        port : Rational
            At this problem's own vehicle.
        changed : names of the parameters in which the two differ

        Raises
        ------
        BadInput
            If a static spring or bush changes that is not a spring by itself in the strut.
        """
        device = self.mounting.device(port)
        for role, name in self.roles.items():
            if name in changed and not device.is_zero():
                # what is left at the end where the spring counts, in units of it; rounding may make it no less than 0
                spring = Fraction(getattr(self.vehicle, name))
                left = device.inverse().inertance * spring if role == "bush" else device.static_stiffness / spring
                if left < -ROUNDING:
                    raise BadInput(f"{name} cannot vary here: in this strut it is not the {role} alone")
        return point.mounting.port(device)

    @property
    def default_device(self) -> Rational | None:
        """What the vehicle comes with in the device's place."""
        return self.place.default

    @property
    def default_port(self) -> Rational | None:
        """Port admittance of the vehicle's default suspension, the reference of improvements; None if it has none."""
        return self.port(self.default_device) if self.place.has_default else None

    # --- what counts -----------------------------------------------------------------------------------------

    def metrics(self, port: Rational, *, confirmed: bool = True) -> dict[str, Measured]:
        """Every metric of the vehicle with the admittance `port` in its secondary port.

        Without `confirmed` each is computed one way only: a hundred times faster, and no figure to print.

        Raises
        ------
        Infeasible
            If the vehicle is not stable.
        """
        found = self._own_metrics(port, confirmed)
        if not self.points:
            return found
        worst, where = found[self.base_objective], "the nominal point"
        for (name, point), changed in zip(self.at_points.items(), self.points, strict=True):
            try:
                there = point._own_metrics(self.port_at(point, port, changed), confirmed)
            except Infeasible as error:
                raise Infeasible(f"at {name}: {error}") from None
            counting = dict.fromkeys((self.base_objective, *self.keep, *self.twins, *self.at_most))
            found |= {f"{metric} at {name}": there[metric] for metric in counting}
            if there[self.base_objective].value > worst.value:
                worst, where = there[self.base_objective], name
        place = f"at {where}" + (f", {worst.at}" if worst.at else "")
        found[self.objective] = Measured(worst.value, worst.unit, place)
        return found

    def _own_metrics(self, port: Rational, confirmed: bool) -> dict[str, Measured]:
        asked = {self.base_objective, *self.at_most} | {name for name, _ in (self.goal.parts if self.goal else ())}
        shown = [
            *(self.vehicle.comfort if self.vehicle.weighting is not None else ()),
            *sorted({*asked, *self.twins}),
        ]
        extra = [name for name in shown if name in self.vehicle.metrics and name not in self.vehicle.headline]
        found = measure(self.vehicle, {"secondary": port}, *extra, confirmed=confirmed)
        if self.goal is not None:
            found[self.goal.name] = self.goal.of(found)
        return found

    @property
    def columns(self) -> tuple[str, ...]:
        """Metrics that have a column where designs stand side by side; weighted where a weighting is asked for."""
        return self._in_weighting(self.vehicle.columns)

    @property
    def compared(self) -> tuple[str, ...]:
        """Those whose improvement has one."""
        return self._in_weighting(self.vehicle.compared)

    def _in_weighting(self, names: tuple[str, ...]) -> tuple[str, ...]:
        twins = {} if self.vehicle.weighting is None else self.vehicle.weighted
        return tuple(dict.fromkeys(twins.get(name, name) for name in names))

    @property
    def without_limits(self) -> Problem:
        """The problem with its own constraints only."""
        return dataclasses.replace(self, at_most={}) if self.at_most else self

    @cached_property
    def plant(self) -> Plant:
        """The vehicle on its random track or road, cut open at the device."""
        return self.vehicle.plant(self.vehicle.random)

    @property
    def base_objective(self) -> str:
        """The objective at one operating point."""
        return self.objective.removeprefix(WORST_CASE) if self.points else self.objective

    @property
    def whole_band(self) -> bool:
        """Whether the objective is over all frequencies, as bounds are, and does not end at 20 Hz."""
        parts = (self.base_objective,) if self.goal is None else tuple(name for name, _ in self.goal.parts)
        norms = [self.vehicle.metrics[name].norm() for name in parts]
        return all(norm is not None and math.isinf(norm.stop) for norm in norms)

    def gain_output(self, metric: str) -> str | None:
        """The output whose largest gain a metric is; None if it is none."""
        return gain_output(self.vehicle, metric)

    @cached_property
    def at_points(self) -> dict[str, Problem]:
        """The same problem at each of the operating points alone, by the point's name, such as ``Crz=40000``."""
        return {
            ",".join(f"{name}={value:g}" for name, value in values.items()): dataclasses.replace(
                self,
                vehicle=override(self.vehicle, values),
                reference=None if self.reference is None else override(self.reference, values),
                objective=self.base_objective,
                points=(),
            )
            for values in self.points
        }

    @cached_property
    def default_metrics(self) -> dict[str, Measured] | None:
        """Every metric of the reference vehicle with its default suspension.

        Raises
        ------
        Infeasible
            If the vehicle is not stable with it, at the nominal point or another.
        """
        if self.reference is not None:
            return self.original.default_metrics
        try:
            return None if self.default_port is None else self.metrics(self.default_port)
        except Infeasible as error:
            raise Infeasible(f"with the default suspension, {error}") from None

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints with their values: the nominal vehicle's, then those of each operating point."""
        if self.reference is not None:
            return self.original.constraints
        found: list[Constraint] = []
        if self.default_metrics is not None:
            found = [
                Constraint(name, self._sense(name), self.default_metrics[name].value, "the default's")
                for name in self.keep
            ]
            if not self.band_only:
                found += self._over_all_frequencies(self.default_metrics)
        found += [Constraint(name, self._sense(name), value, "a limit") for name, value in self.at_most.items()]
        for name, point in self.at_points.items():
            found += [
                dataclasses.replace(one, metric=f"{one.metric} at {name}", point=name) for one in point.constraints
            ]
        return tuple(found)

    def _sense(self, metric: str) -> str:
        return "<=" if self.vehicle.metrics[metric].better == "less" else ">="

    @property
    def twins(self) -> dict[str, float]:
        """Of each metric of the objective that ends at 20 Hz, the one over all frequencies, with its weight.

        There are none for a sum, of which no single one is to be kept.
        """
        if self.goal is not None and self.goal.kind != "worst":
            return {}
        parts = ((self.base_objective, 1.0),) if self.goal is None else self.goal.parts
        found = {whole_band_twin(self.vehicle, name): weight for name, weight in parts}
        return {name: weight for name, weight in found.items() if name is not None}

    def _over_all_frequencies(self, default: Mapping[str, Measured]) -> list[Constraint]:
        """That no design is worse than the default where the objective does not look."""
        if not self.twins or len(self.twins) < (1 if self.goal is None else len(self.goal.parts)):
            return []
        worst = (1 + _NOT_WORSE) * max(weight * default[name].value for name, weight in self.twins.items())
        return [
            Constraint(name, "<=", worst / weight, "the default's", nominal=True)
            for name, weight in self.twins.items()
            if name not in self.at_most
        ]

    @cached_property
    def in_its_band(self) -> Problem:
        """The problem that looks no further than its objective does; itself, where that is everywhere.

        A search solves this easier one first: what it finds is the best of both, if it keeps the figure over all
        frequencies too.
        """
        if self.band_only or not self.twins or self.default_port is None:
            return self
        easier = dataclasses.replace(self, band_only=True)
        if self.reference is None:
            easier.__dict__["default_metrics"] = self.default_metrics
        return easier

    def violated(self, metrics: Mapping[str, Measured], *, tolerance: float = ROUNDING) -> list[str]:
        """The constraints that `metrics` break by more than `tolerance` of their value, as sentences."""
        return [
            f"{constraint} is violated: {metrics[constraint.metric].value:.6g}"
            for constraint in self.constraints
            if constraint.margin(metrics) < -tolerance * abs(constraint.value)
        ]

    def improvement(self, metrics: Mapping[str, Measured], name: str | None = None) -> float | None:
        """Per cent by which a metric (the objective by default) is better than the default suspension's."""
        if self.default_metrics is None:
            return None
        name = name or self.objective
        return 100 * (1 - metrics[name].value / self.default_metrics[name].value)
