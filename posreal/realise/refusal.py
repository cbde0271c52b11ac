"""The two ways in which a realisation method does not deliver."""

from __future__ import annotations

from posreal.errors import BadDevice, PosrealError


class DoesNotApply(BadDevice):
    """This method does not serve this device; the text says why, and what does."""


class Unproven(PosrealError):
    """A synthesised network does not have the admittance it was made for: a fault of the method."""

    exit_code = 1
