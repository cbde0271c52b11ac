"""Whatever the caller has, as the admittance it is."""

from __future__ import annotations

from numbers import Real
from typing import Any, TypeAlias

from flint import fmpq

from posreal.admittance.control_systems import is_control_system
from posreal.admittance.rational import Rational
from posreal.errors import BadDevice

Device: TypeAlias = Any


def as_rational(device: Device) -> Rational:
    """The exact admittance of a device given in any form.

    Parameters
    ----------
    device : object
        A `Rational`; text such as ``"(s^2 + s + 1)/(s^2 + s + 4)"``; a pair ``(numerator, denominator)`` of
        coefficient lists in ascending powers; what `Rational.to_dict` wrote; a number (a damper); a
        python-control system; or anything with a method ``admittance()`` (networks) or ``rational()``
        (state-space forms).

    Raises
    ------
    BadDevice
        If it is none of these.
    """
    if isinstance(device, Rational):
        return device
    if isinstance(device, str):
        return Rational.parse(device)
    if is_control_system(device):
        return Rational.from_control(device)
    for method in ("admittance", "rational"):
        if callable(getattr(device, method, None)):
            found = getattr(device, method)()
            if isinstance(found, Rational):
                return found
    if isinstance(device, dict):
        return Rational.from_dict(device)
    if isinstance(device, Real | fmpq):
        return Rational([device])  # type: ignore[list-item]
    if isinstance(device, list | tuple) and len(device) == 2 and all(hasattr(part, "__len__") for part in device):
        return Rational(*device)
    raise BadDevice(
        f"{type(device).__name__} is not a device; give a Rational, text in s, (numerator, denominator) "
        "lists in ascending powers (Rational.descending takes the other order), a network, or a python-control system."
    )
