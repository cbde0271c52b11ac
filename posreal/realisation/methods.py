"""The realisation methods by name: each makes a network of a positive-real admittance, or says why not."""

from __future__ import annotations

from collections.abc import Callable

from posreal.admittance import Rational
from posreal.network import Network
from posreal.realisation import biquadratic, bott_duffin, brune, cauer, foster, reza_pantell
from posreal.realisation.multiprecision import Long
from posreal.realisation.preamble import CycleMethod

Method = Callable[[Rational, Long], Network]

WITH_LEVERS = ("brune",)

METHODS: dict[str, Method] = {
    "foster-1": foster.series_form,
    "foster-2": foster.parallel_form,
    "cauer-1": cauer.from_infinity,
    "cauer-2": cauer.from_zero,
    "biquadratic": biquadratic.fewest,
    "brune": lambda y, arithmetic: CycleMethod(brune.cycle, arithmetic)(y),
    "reza-pantell": lambda y, arithmetic: CycleMethod(reza_pantell.cycle, arithmetic)(y),
    "bott-duffin": lambda y, arithmetic: CycleMethod(bott_duffin.cycle, arithmetic)(y),
}
