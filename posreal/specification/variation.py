"""A design as it may be built: which values differ from the drawing, by how much, and the figures of one such vehicle.

An element of the network, the spring that the vehicle has at its place (the bush, the static spring) and the vehicle
parameters that stand in its ports (the primary suspension, where it is lateral) each have a nominal value and a
relative tolerance. What is drawn is written with six digits, so that it can be evaluated again by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from posreal.admittance import Rational
from posreal.errors import Infeasible
from posreal.metric import ClosedVehicle, Measured
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.specification.tolerances import KINDS, Tolerances, vehicle_parameters
from posreal.vehicle.shared_plants import on_plants_of

Real = np.ndarray
DIGITS = 6  # of a drawn value


@dataclass(frozen=True)
class Part:
    """A value that differs from vehicle to vehicle: an element of the network, or a parameter of the vehicle.

    Attributes
    ----------
    name : str
    unit : str
    nominal : float
    tolerance : float
        Relative, to either side.
    element : bool
        Whether it is an element of the network.
    """

    name: str
    unit: str
    nominal: float
    tolerance: float
    element: bool

    @property
    def lower(self) -> float:
        """The least value."""
        return self.nominal * (1 - self.tolerance)

    @property
    def upper(self) -> float:
        """The greatest value."""
        return self.nominal * (1 + self.tolerance)


@dataclass(frozen=True)
class Variation:
    """A design whose values vary within tolerances.

    Attributes
    ----------
    design : Design
        With the network that is built in its device's place.
    parts : tuple of Part
        What varies.
    """

    design: Design
    parts: tuple[Part, ...]

    def values(self, where: Real) -> dict[str, float]:
        """The parts' values at `where` in −1 … 1, rounded to what is written."""
        return {
            part.name: float(f"{part.nominal * (1 + part.tolerance * at):.{DIGITS}g}") if at else part.nominal
            for part, at in zip(self.parts, where.tolist(), strict=True)
        }

    def built(self, values: Mapping[str, float]) -> tuple[Problem, Rational]:
        """The problem with its vehicle so built, and the admittance of its port."""
        design, elements = self.design, {part.name for part in self.parts if part.element}
        problem = design.problem.with_vehicle({n: value for n, value in values.items() if n not in elements})
        network, own = design.network, design.problem.vehicle
        if problem.vehicle != own and self._shares_plants:
            problem = replace(problem, vehicle=on_plants_of(own, problem.vehicle))
        if network is None:
            return problem, problem.port(design.device, whole=design.whole)
        inner = network.with_values({name: value for name, value in values.items() if name in elements})
        return problem, problem.port(inner.admittance(), whole=design.whole)

    @property
    def _shares_plants(self) -> bool:
        """Whether vehicles differ in nothing but what stands in their ports."""
        problem = self.design.problem
        inside = {*problem.roles.values(), *problem.vehicle.free}
        return not problem.points and all(part.element or part.name in inside for part in self.parts)

    def measured(self, points: Real, names: Sequence[str]) -> Real:
        """Metrics of several vehicles, computed one way only, (points, names); NaN in a row that is not stable.

        Parameters
        ----------
        points : (N, parts) in −1 … 1
        names : metrics
        """
        found = np.full((len(points), len(names)), np.nan)
        for row, at in zip(found, points, strict=True):
            problem, port = self.built(self.values(at))
            try:
                metrics = problem.metrics(port, confirmed=False)
            except Infeasible:
                continue
            row[:] = [metrics[name].value for name in names]
        return found

    def confirmed(self, at: Real, names: Sequence[str]) -> list[float]:
        """Metrics of one vehicle, each by two methods.

        Raises
        ------
        Infeasible
            If the vehicle is not stable, or the methods do not agree.
        """
        problem, port = self.built(self.values(at))
        return [_confirmed(problem, port, name).value for name in names]


def _confirmed(problem: Problem, port: Rational, name: str) -> Measured:
    """One metric, at the nominal or another operating point."""
    for (point, there), changed in zip(problem.at_points.items(), problem.points, strict=True):
        base = name.removesuffix(f" at {point}")
        if base != name and base in there.vehicle.metrics:
            port = problem.port_at(there, port, changed)
            return ClosedVehicle(there.vehicle, {"secondary": port}).value(there.vehicle.metrics[base])
    if name in problem.vehicle.metrics:
        return ClosedVehicle(problem.vehicle, {"secondary": port}).value(problem.vehicle.metrics[name])
    return problem.metrics(port)[name]


def variation(design: Design, tolerances: Tolerances) -> Variation:
    """What varies when a design is built, and by how much.

    Parameters
    ----------
    design : Design
        With a network, where it has a device.
    tolerances : Tolerances

    Raises
    ------
    BadInput
        For a name that nothing has.
    """
    values = {} if design.network is None else design.network.values()
    shares = tolerances.of_elements(tuple(values))
    parts = [Part(name, KINDS.get(name[0], "1"), values[name], share, element=True) for name, share in shares.items()]
    known = vehicle_parameters(design.problem.vehicle)
    of_vehicle = tolerances.of_vehicle(design.problem, whole=design.whole, device=design.device is not None)
    for name, share in of_vehicle.items():
        value, unit = known[name]
        parts.append(Part(name, unit.replace("*", " "), value, share, element=False))
    return Variation(design, tuple(part for part in parts if part.tolerance and part.nominal))
