"""python-control's systems in and out; exact on the way in, floats on the way out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq_poly

from posreal.admittance import exact
from posreal.errors import BadDevice

Polynomial: TypeAlias = fmpq_poly | Iterable[exact.Number]


def is_control_system(thing: object) -> bool:
    """Whether this comes from python-control, without importing it."""
    return type(thing).__module__.partition(".")[0] == "control"


def coefficients(system: Any) -> tuple[Polynomial, Polynomial]:
    """Numerator and denominator of a one-input one-output continuous-time system, its floats taken exactly.

    Parameters
    ----------
    system : control.TransferFunction or control.StateSpace
        Improper transfer functions are welcome; states that cannot be reached or seen drop out only
        where the matrices show it exactly.

    Raises
    ------
    BadDevice
        For another kind of system, more than one port, or a sampled one.
    """
    if not is_control_system(system) or not (hasattr(system, "num") or hasattr(system, "A")):
        raise BadDevice(f"{type(system).__name__} is not a control.TransferFunction or control.StateSpace.")
    if getattr(system, "dt", None) not in (None, 0):
        raise BadDevice(f"This system is sampled (dt = {system.dt}); a device is continuous-time, so use d2c first.")
    if (system.ninputs, system.noutputs) != (1, 1):
        raise BadDevice(f"A device has one port; this has {system.ninputs} inputs and {system.noutputs} outputs.")
    if hasattr(system, "A"):
        if np.asarray(system.A).size == 0:
            return [np.asarray(system.D).item()], [1]
        return exact.transfer_function(
            exact.matrix(system.A),
            exact.matrix(system.B),
            exact.matrix(system.C),
            exact.matrix(system.D)[0, 0],
        )
    return system.num[0][0][::-1], system.den[0][0][::-1]


def transfer_function(numerator: fmpq_poly, denominator: fmpq_poly) -> Any:
    """A ``control.TransferFunction`` of two polynomials.

    Raises
    ------
    BadDevice
        If a coefficient is beyond what a float holds.
    """
    from control import TransferFunction

    n, d = exact.floats(numerator.coeffs()) or [0.0], exact.floats(denominator.coeffs())
    if not np.all(np.isfinite([*n, *d])):
        raise BadDevice("A coefficient is too large for python-control's floats; scale the device first.")
    return TransferFunction(n[::-1], d[::-1])
