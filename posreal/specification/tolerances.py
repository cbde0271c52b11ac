"""By how much the values of a vehicle that is built may differ from those on the drawing."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.units import quantity

if TYPE_CHECKING:
    from posreal.specification.problem import Problem

TOLERANCE = 0.2  # of a value, either way, where nothing is said: that of a catalogue's dampers and rubber springs
KINDS = {"k": "N/m", "c": "N s/m", "b": "kg"}
_TOLERANCE = re.compile(r"(?:([A-Za-z]\w*)\s*=)?\s*([^=,]+)")


@dataclass(frozen=True)
class Tolerances:
    """Relative tolerances of element values and vehicle parameters, to either side.

    Attributes
    ----------
    rest : float
        Of elements that are not named.
    named : tuple of (element or kind, tolerance)
    vehicle_rest : float or None
        Of the spring at the device's place and of what stands in the vehicle's other ports; None: only what is named.
    vehicle_named : tuple of (vehicle parameter, tolerance)
    """

    rest: float = TOLERANCE
    named: tuple[tuple[str, float], ...] = ()
    vehicle_rest: float | None = TOLERANCE
    vehicle_named: tuple[tuple[str, float], ...] = ()

    def of_elements(self, names: Sequence[str]) -> dict[str, float]:
        """Of the elements of a network by name.

        Raises
        ------
        BadInput
            If it names one that there is not.
        """
        named = dict(self.named)
        unknown = [name for name in named if name not in names and name not in KINDS]
        if unknown:
            there = f"its elements are {listed(names)}, kinds k, c, b" if names else "the device has none"
            raise BadInput(f"there is no element {shown(unknown[0])}; {there}")
        return {name: named.get(name, named.get(name[0], self.rest)) for name in names}

    def of_vehicle(self, problem: Problem, *, whole: bool, device: bool = True) -> dict[str, float]:
        """Of vehicle parameters by name.

        Parameters
        ----------
        problem : Problem
        whole : bool
            Whether the strut brings the spring at its place as an element of its own.
        device : bool
            Whether there is a device, and a bush behind it.

        Raises
        ------
        BadInput
            For a parameter that the vehicle does not have, or that the strut has in its place.
        """
        known, roles = vehicle_parameters(problem.vehicle), problem.roles
        own = {name: role for role, name in roles.items()} if whole else {}
        found: dict[str, float] = {}
        if self.vehicle_rest is not None:
            beyond = set(own) | (set() if device else {roles.get("bush")})
            inside = dict.fromkeys([*roles.values(), *problem.vehicle.free])
            found = {name: self.vehicle_rest for name in inside if name in known and name not in beyond}
        for name, share in self.vehicle_named:
            if name not in known:
                accepted = hint(name, known) if known else "this vehicle has none that can vary"
                raise BadInput(f"unknown vehicle parameter {shown(name)}; {accepted}")
            if name in own:
                raise BadInput(
                    f"{name} is the {own[name]} of this strut; give the tolerance of the strut's own element"
                )
            found[name] = share
        return found

    def __str__(self) -> str:
        words = [f"±{100 * self.rest:g} %", *(f"{name} ±{100 * share:g} %" for name, share in self.named)]
        if self.vehicle_rest not in (self.rest, None):
            words.append(f"of the vehicle's suspension ±{100 * (self.vehicle_rest or 0):g} %")
        return ", ".join([*words, *(f"{name} ±{100 * share:g} %" for name, share in self.vehicle_named)])


def tolerances(
    elements: float | str | Mapping[str, float] = TOLERANCE,
    vehicle: float | str | Mapping[str, float] | None = None,
) -> Tolerances:
    """Tolerances from numbers, text or mappings.

    Parameters
    ----------
    elements : float, text or mapping
        One for all, or by name or kind (``{"k": 0.1, "c1": 0.3}``, what is not named has 20 %); as text
        ``20%,k=10%,c1=30%``.
    vehicle : float, text, mapping or None
        Of vehicle parameters: one number for the spring at the device's place and those that stand in the vehicle's
        ports, or the parameters that vary and their tolerances. None: 20 % of the former.

    Raises
    ------
    BadInput
        For what is no tolerance, or one that is not from 0 to 1.
    """
    rest, named = read_tolerances(elements)
    general, chosen = read_tolerances(TOLERANCE if vehicle is None else vehicle)
    return Tolerances(TOLERANCE if rest is None else rest, tuple(named.items()), general, tuple(chosen.items()))


def vehicle_parameters(vehicle: Any) -> dict[str, tuple[float, str]]:
    """Value and unit of every parameter of a vehicle; a plant of the user's own has none."""
    fields = [field for field in dataclasses.fields(vehicle) if "unit" in field.metadata]
    return {field.name: (getattr(vehicle, field.name), field.metadata["unit"]) for field in fields}


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
