"""A design as it may be built: which values differ from the drawing, by how much, and the figures of one such vehicle.

An element of the network, the spring that the vehicle has at its place (the bush, the static spring) and the vehicle
parameters that stand in its ports (the primary suspension, where it is lateral) each have a nominal value and a
relative tolerance. What is drawn is written with six digits, so that it can be evaluated again by hand.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.errors import BadInput, Infeasible, hint, listed, plain, shown
from posreal.metric import ClosedVehicle, Measured
from posreal.network import Damper, Network
from posreal.realisation import realise
from posreal.specification.design import Design
from posreal.specification.problem import Problem
from posreal.units import quantity
from posreal.vehicle.shared_plants import on_plants_of

Real = np.ndarray
TOLERANCE = 0.2  # of a value, either way, where nothing is said: that of a catalogue's dampers and rubber springs
KINDS = {"k": "N/m", "c": "N s/m", "b": "kg"}
DIGITS = 6  # of a drawn value
_TOLERANCE = re.compile(r"(?:([A-Za-z]\w*)\s*=)?\s*([^=,]+)")


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


def variation(
    design: Design,
    tolerance: float | str | Mapping[str, float] = TOLERANCE,
    vehicle: float | str | Mapping[str, float] | None = None,
) -> Variation:
    """What varies when a design is built, and by how much.

    Parameters
    ----------
    design : Design
        A device that is no network yet is realised first.
    tolerance : float, text or mapping
        Of the elements: one for all, or by name or kind (``{"k": 0.1, "c1": 0.3}``, what is not named
        has 20 %); as text ``20%,k=10%,c1=30%``.
    vehicle : float, text, mapping or None
        Of vehicle parameters: one number for the spring at the device's place and those that stand in the vehicle's
        ports, or the parameters that vary and their tolerances. None: as the elements' 20 %.

    Raises
    ------
    BadInput
        For a name that nothing has, or a tolerance that is not from 0 to 1.
    """
    design = as_network(design)
    rest, named = read_tolerances(tolerance)
    elements = [] if design.network is None else _elements(design.network, TOLERANCE if rest is None else rest, named)
    suspension = _suspension(design)
    general, chosen = read_tolerances(TOLERANCE if vehicle is None else vehicle)
    if general is not None:
        chosen = {**dict.fromkeys(suspension, general), **chosen}
    known = _parameters(design.problem.vehicle)
    own = _of_the_strut(design)
    parts = list(elements)
    for name, share in chosen.items():
        if name not in known:
            raise BadInput(
                f"unknown vehicle parameter {shown(name)}; "
                + (hint(name, known) if known else "this vehicle has none that can vary")
            )
        if name in own:
            raise BadInput(f"{name} is the {own[name]} of this strut; give the tolerance of the strut's own element")
        value, unit = known[name]
        parts.append(Part(name, unit.replace("*", " "), value, share, element=False))
    return Variation(design, tuple(part for part in parts if part.tolerance and part.nominal))


def as_network(design: Design) -> Design:
    """The design with a network, which is what has tolerances; realised if it has none yet."""
    device = design.device
    if design.network is not None or device is None or device.is_zero():
        return design
    network = Damper(device(1.0).real) if device.degree == 0 else realise(device).network
    if design.whole:
        raise BadInput("a whole strut without a network has no elements; give a layout, a network or an admittance")
    return replace(design, network=network)


def _elements(network: Network, rest: float, named: Mapping[str, float]) -> list[Part]:
    values = network.values()
    unknown = [name for name in named if name not in values and name not in KINDS]
    if unknown:
        raise BadInput(f"there is no element {shown(unknown[0])}; its elements are {listed(values)}, kinds k, c, b")
    shares = {name: named.get(name, named.get(name[0], rest)) for name in values}
    return [Part(name, KINDS.get(name[0], "1"), values[name], shares[name], element=True) for name in values]


def _parameters(vehicle: Any) -> dict[str, tuple[float, str]]:
    """Value and unit of every parameter of a vehicle; a plant of the user's own has none."""
    fields = [field for field in dataclasses.fields(vehicle) if "unit" in field.metadata]
    return {field.name: (getattr(vehicle, field.name), field.metadata["unit"]) for field in fields}


def _of_the_strut(design: Design) -> dict[str, str]:
    """Vehicle parameters for which the strut brings an element of its own."""
    return {name: role for role, name in design.problem.roles.items()} if design.whole else {}


def _suspension(design: Design) -> list[str]:
    """Vehicle parameters that are parts of its suspension as the problem sees it: at the place, and in the ports."""
    problem = design.problem
    beyond = set(_of_the_strut(design)) | ({problem.roles.get("bush")} if design.device is None else set())
    known = _parameters(problem.vehicle)
    found = dict.fromkeys([*problem.roles.values(), *problem.vehicle.free])
    return [name for name in found if name not in beyond and name in known]


def read_tolerances(given: float | str | Mapping[str, float]) -> tuple[float | None, dict[str, float]]:
    """``20%,k=10%`` as the one for all others and those by name.

    Raises
    ------
    BadInput
        For what is no tolerance, or one that is not from 0 to 1.
    """
    if isinstance(given, Mapping):
        return None, {str(name): _share(value) for name, value in given.items()}
    if not isinstance(given, str):
        return _share(given), {}
    rest, named = None, dict[str, float]()
    for word in given.split(","):
        match = _TOLERANCE.fullmatch(word.strip())
        if match is None:
            raise BadInput(f"{shown(given)} is not a tolerance such as 20% or 20%,k=10%,c1=30%")
        try:
            share = _share(quantity(match[2].strip(), "1"))
        except BadInput:
            raise BadInput(
                f"{plain(word.strip(), 40)} is not a tolerance from 0 to below 100%, such as 20% or 0.2"
            ) from None
        if match[1] is None:
            rest = share
        else:
            named[match[1]] = share
    return rest, named


def _share(value: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < 1:
        raise BadInput(f"a tolerance is {shown(value)}; give one from 0 to below 1, such as 0.2 or 20%")
    return float(value)
