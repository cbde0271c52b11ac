"""Whatever a user calls a device, put into a problem's vehicle.

Accepted are a layout with values (``S3 c=2.1e4 b=1.53e4``), a network (``k=2e5 | (c=2e4 + b=300)``), an admittance
(``(s^2 + s + 1)/(s^2 + s + 4)``), a file that holds one of these or a device as JSON, and ``default`` for the
vehicle as it comes. A layout is the whole strut; a network or an admittance takes the device's place, beside the
static spring or behind the bush.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from typing import Any

from posreal.admittance import Rational
from posreal.admittance.device import as_rational
from posreal.admittance.parse import HEAD
from posreal.admittance.positive_real import require
from posreal.bounds.guard import guarded
from posreal.errors import BadDevice, BadInput, listed, shown
from posreal.files import read_json
from posreal.network import Network
from posreal.network.as_made import made
from posreal.network.read_device import is_file, read_device
from posreal.optimisation.caveats import caveats
from posreal.optimisation.layout_values import evaluate_layout
from posreal.real_elements import RealElements
from posreal.specification.as_made import Ideal, ideal_beside
from posreal.specification.design import Design
from posreal.specification.layout import layout
from posreal.specification.named import as_problem
from posreal.specification.problem import Problem
from posreal.units import engineering, exact_quantity
from posreal.vehicle import parameters

_ALIKE = 0.5, 2.0
"""Times the vehicle's own spring: a spring of the device that may be meant for the same."""
_ASSIGNMENT = re.compile(r"([A-Za-z]\w*)\s*=\s*([^=|+(){}]+)")


def evaluate(problem: Problem | str, device: Any, *, label: str | None = None) -> Design:
    """Put a device into the problem's vehicle and measure everything.

    Parameters
    ----------
    problem : Problem, or the name of one
    device : str, Network, Rational, python-control system, (numerator, denominator), or None
        In the device's place; text may also be a layout with values, a file, or ``default``.

    Raises
    ------
    BadDevice, BadInput
        If it cannot be read.
    NotPositiveReal
        With the witness, if no springs, dampers and inerters make it.
    Infeasible
        If the vehicle is not stable with it.
    """
    problem = as_problem(problem)
    if isinstance(device, str):
        return read_design(problem, device.split() if _is_layout(device) else [device])
    bought = device if isinstance(device, Network) else None
    if problem.elements is not None and bought is None and device is not None:
        raise BadInput("an admittance has no elements that could be real ones; give a network, such as realise makes")
    network = None if bought is None else made(bought, problem.elements)
    admittance = problem.default_device if device is None else require(as_rational(network or device))
    metrics = problem.metrics(problem.port(admittance))
    values = {} if bought is None else bought.values()
    ideal = None if bought is None else ideal_beside(problem, bought)
    name = label or ("default" if device is None else str(device))
    own = admittance if bought is None else bought.admittance()  # the ends of real elements come by themselves
    twice = [] if device is None or own is None else _twice(problem, own)
    found = {"notes": twice} if twice else {}
    return guarded(
        Design(name, problem, admittance, metrics, network=network, parameters=values, found=found, ideal=ideal)
    )


def of_real_elements(design: Design, elements: RealElements) -> Design:
    """A design with a network in the device's place, its elements those that are bought; ideal ones stand beside.

    Raises
    ------
    Infeasible
        If the vehicle is not stable with it.
    """
    assert design.network is not None
    assert not design.whole
    posed = dataclasses.replace(design.problem, elements=elements)
    network = made(design.network, elements)
    device = network.admittance()
    real = dataclasses.replace(
        design,
        problem=posed,
        network=network,
        device=device,
        metrics=posed.metrics(posed.port(device)),
        ideal=Ideal(design.network, design.metrics),
    )
    notes = [*design.found.get("notes", ()), *(f"of real elements: {said}" for said in caveats(real))]
    return guarded(dataclasses.replace(real, found={**design.found, "notes": notes}))


def _twice(problem: Problem, device: Rational) -> list[str]:
    """Sentences about a device that seems to bring the spring that its place holds already."""
    beside, behind = problem.mounting.beside, problem.mounting.behind
    said = []
    for stands, own, rest in (
        ("beside", _at_rest(device), 0.0 if beside is None else _at_rest(beside)),
        ("behind", _at_the_top(device), 0.0 if behind is None else _at_the_top(behind)),
    ):
        if rest > 0 and _ALIKE[0] < own / rest < _ALIKE[1]:
            said.append(
                f"the device's own spring of {engineering(own, 'N/m')} comes on top of what stands {stands} it, "
                f"{engineering(rest, 'N/m')} of the vehicle: a network or an admittance takes the device's place, only "
                "a layout is the whole strut"
            )
    return said


def _at_rest(device: Rational) -> float:
    return float(device.static_stiffness)


def _at_the_top(device: Rational) -> float:
    """The stiffness of a spring in series with everything else; 0 where there is none."""
    compliance = 0.0 if device.is_zero() else float(device.inverse().inertance)
    return 1 / compliance if compliance > 0 else 0.0


def read_design(problem: Problem, words: Sequence[str]) -> Design:
    """The design that the words of a command line describe.

    Parameters
    ----------
    problem : Problem
    words : sequence of str
        A device, followed by assignments to a layout's elements or to the vehicle's parameters.
    """
    if not words:
        raise BadInput("no device given; accepted are a layout with values, a network, an admittance in s, or a file")
    text, rest = words[0], words[1:]
    is_layout = _is_layout(text)
    chosen = layout(text) if is_layout else None
    elements: dict[str, str] = {}
    vehicle: dict[str, str] = {}
    known = list(parameters(problem.vehicle))
    for word in rest:
        match = _ASSIGNMENT.fullmatch(word.strip())
        if match is None:
            raise BadInput(f"{shown(word)} is not an assignment such as c=2.1e4; quote a device that has spaces in it")
        name, value = match.groups()
        if chosen is not None and name in chosen.network.names:
            elements[name] = value.strip()
        elif name in known:
            vehicle[name] = value.strip()
        elif not known and chosen is None:
            raise BadInput(f"{shown(word)} is no part of the device, and the plant of {problem.name} has no parameters")
        else:
            of_layout = f"the elements {listed(chosen.network.names)} of {chosen.name}, and " if chosen else ""
            raise BadInput(f"unknown parameter {shown(name)}; accepted are {of_layout}the vehicle's {listed(known)}")
    if chosen is None:
        device = read_device(text)
        return evaluate(problem.with_vehicle({**_chosen_in(text, problem), **vehicle}), device)
    tuned = problem.with_vehicle(vehicle)
    values = {name: _element_value(name, value) for name, value in elements.items()}
    given = {name: getattr(tuned.vehicle, name) for name in vehicle}
    return guarded(evaluate_layout(tuned, chosen, values, vehicle=given))


def _element_value(name: str, text: str) -> Any:
    unit = {"k": "N/m", "c": "N*s/m", "b": "kg"}[name[0]]
    try:
        value = exact_quantity(text, unit)
    except BadInput as error:
        raise BadDevice(f"{name}={text}: {error}") from None
    if value <= 0:
        raise BadDevice(f"{name} is {text}; an element's value must be finite and above 0, in {unit.replace('*', ' ')}")
    return value


def _is_layout(text: str) -> bool:
    first = text.split()[0] if text.split() else ""
    if HEAD.match(text) or text.lstrip().startswith(("tf(", "tf (")):
        return False
    return bool(re.fullmatch(r"[A-Za-z]\w*", first) and not re.fullmatch(r"[kcbs]\w*|default|none", first)) or (
        first.endswith(".toml")
    )


def _chosen_in(text: str, problem: Problem) -> dict[str, float]:
    """Vehicle parameters that the problem leaves free and a file of a synthesised design has values for."""
    if not (problem.free and is_file(text.strip())):
        return {}
    try:
        given = read_json(text.strip())["design"]["parameters"]
    except (BadInput, KeyError, TypeError):  # a file of another kind, which has been read as a device
        return {}
    return {name: given[name] for name in problem.free if isinstance(given, dict) and name in given}
