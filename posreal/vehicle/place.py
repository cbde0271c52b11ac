"""A place of a vehicle, where a device goes: what stands there whatever the device is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from posreal.admittance import Rational
from posreal.plant.mounting import Copy, Mounting
from posreal.ranges import UsualRanges
from posreal.real_elements import RealElements


@dataclass(frozen=True)
class Place:
    """Where a device goes.

    Attributes
    ----------
    around : Mounting
        What stands beside and behind a device.
    beside_strut : Rational or None
        What stands beside a whole strut, which brings its own static spring or bush.
    roles : mapping of role to vehicle parameter
        The spring that is part of the strut: ``static spring``, beside the device, or ``bush``, behind it.
    terminals : (str, str)
        What the strut stands between, for diagrams.
    default : Rational or None
        The device that the vehicle comes with; None where it comes with none.
    has_default : bool
        Whether the vehicle is a suspension as it comes, to which others are compared.
    default_label : str
        What that is called in tables.
    carried : float
        Mass that rests on one port, kg; 0 where the plant knows of none.
    usual : UsualRanges or None
        What can be bought for it; None where nobody has said.
    elements : RealElements or None
        What comes with the elements that are bought for it; None where nobody has said.
    travels : tuple of str
        Metrics, in mm, of how far a device there moves to either side.
    copies : tuple of Copy
        How devices sit in its ports, where that is not one in each.
    """

    around: Mounting
    beside_strut: Rational | None = None
    roles: Mapping[str, str] = field(default_factory=dict)
    terminals: tuple[str, str] = ("+", "-")
    default: Rational | None = None
    has_default: bool = False
    default_label: str = "default"
    carried: float = 0.0
    usual: UsualRanges | None = None
    elements: RealElements | None = None
    travels: tuple[str, ...] = ()
    copies: tuple[Copy, ...] = ()
