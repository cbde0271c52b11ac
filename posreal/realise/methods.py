"""The realisation methods by name: each takes a positive-real admittance and gives a network, or refuses with the reason."""

from __future__ import annotations

from collections.abc import Callable

from posreal.admittance import Rational
from posreal.network import Network
from posreal.realise import bott_duffin, brune, cauer, foster
from posreal.realise.long import Long
from posreal.realise.preamble import Synthesis

Method = Callable[[Rational, Long], Network]

METHODS: dict[str, Method] = {
    "foster-1": foster.series_form,
    "foster-2": foster.parallel_form,
    "cauer-1": cauer.from_infinity,
    "cauer-2": cauer.from_zero,
    "brune": lambda y, arithmetic: Synthesis(brune.cycle, arithmetic)(y),
    "bott-duffin": lambda y, arithmetic: Synthesis(bott_duffin.cycle, arithmetic)(y),
}
