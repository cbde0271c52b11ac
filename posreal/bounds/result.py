"""A bound: what no positive-real device can go below, with the numbers that prove it and the best design beside it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posreal.admittance import Rational
from posreal.admittance.positive_real import require
from posreal.bounds import document
from posreal.bounds.certificate import NotProven
from posreal.bounds.figure import BoundedFigure
from posreal.bounds.interpolation_space import in_words
from posreal.bounds.points import Certificate, passive
from posreal.bounds.ritz import Attained
from posreal.bounds.value_form import ValueCertificate
from posreal.errors import PosrealError, Unsettled, plain, shown
from posreal.specification.design import Design
from posreal.specification.problem import Problem

_ROUNDING = 1e-9
"""Relative: what a figure computed in floats may be off by, and what a claim leaves below its proof for another
machine's rounding of the vehicle's matrices."""


_MEASURED = 1e-5
"""Relative: what a covariance with a hundred states may differ by from one machine to another."""


class BelowBound(AssertionError):
    """A design below a proven bound: one of the two is computed wrongly, so nothing should be reported."""


@dataclass(frozen=True)
class Best:
    """The best design known, in the very figure that is bounded.

    Attributes
    ----------
    label : str
    value : float
        Whole-band figure, in the bound's unit.
    device : Rational or None
        What stands in the port, everything beside and behind the device included; None for a bare number.
    """

    label: str
    value: float
    device: Rational | None


@dataclass(frozen=True, repr=False)
class Bound:
    """No positive-real device makes the figure smaller than `value`.

    Attributes
    ----------
    value : float
        Lower bound on J.
    figure : Figure
        What J is: vehicle, outputs, unit, band.
    certificate : Certificate or ValueCertificate
    form : {"plain", "lifted", "value"}
        Which search found the certificate.
    passive : bool
        Whether every port is passive; otherwise the bound is over the devices with which the vehicle is stable.
    problem : Problem or None
        The named problem whose objective it is; None for a plant of the user's.
    weights : tuple of (metric, weight)
        Of a weighted sum of squares; empty for the problem's own objective.
    best : Best or None
    seconds : float
    attained : Attained or None
        A passive device of high order, close to the best: how much higher the bound could be at most.
    """

    value: float
    figure: BoundedFigure
    certificate: Certificate | ValueCertificate
    form: str
    passive: bool
    problem: Problem | None = None
    weights: tuple[tuple[str, float], ...] = ()
    best: Best | None = None
    seconds: float = 0.0
    attained: Attained | None = None

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return self.figure.unit

    @property
    def metric(self) -> str:
        """Name of J."""
        return self.figure.metric

    @property
    def kind(self) -> str:
        """Which band J is over; figures of another kind are not comparable."""
        return self.figure.kind

    @property
    def gap_percent(self) -> float | None:
        """By how many per cent the bound is below the best design known."""
        return None if self.best is None or self.best.value == 0 else 100 * (1 - self.value / self.best.value)

    @property
    def room_percent(self) -> float | None:
        """By how many per cent the bound is below what a passive device is known to reach."""
        return None if self.attained is None else 100 * (1 - self.value / self.attained.value)

    @property
    def devices(self) -> str:
        """Over which devices the bound holds."""
        suffix = "" if self.passive else " with which the vehicle is stable"
        return f"every positive-real device of any order{suffix}"

    def check(self) -> float:
        """Prove the bound again from its certificate alone, in ball arithmetic; no solver.

        Returns
        -------
        float
            What the certificate proves, at least `value`.

        Raises
        ------
        NotProven
            If it proves less than is claimed, or nothing; or the design beside it does not have the stated figure.
        """
        proof = self.certificate.lower_bound(self.figure)
        if not 0 <= self.value <= proof:
            raise NotProven(
                f"the claim is {self.metric} ≥ {self.value:.12g} {self.unit}, and the certificate proves {proof:.12g} "
                "for this vehicle: the file was changed, or belongs to another vehicle"
            )
        if self.passive != passive(self.figure):
            raise NotProven("the ports are stated to be passive and are not, or the other way round")
        if self.best is not None and self.best.device is not None:
            value = self._measured(require(self.best.device))
            if abs(value - self.best.value) > 1e-6 * value:
                raise NotProven(
                    f"the design {shown(self.best.label)} has {self.metric} = {value:.10g} {self.unit} ({self.kind}), "
                    f"not {self.best.value:.10g} as stated"
                )
        if self.attained is not None:
            self._check_attained(self.attained)
        if self.best is not None and self.best.value < self.value * (1 - _ROUNDING):
            raise NotProven(f"the design {shown(self.best.label)} is stated to be below the bound, which cannot be")
        return proof

    def _check_attained(self, attained: Attained) -> None:
        """Passivity of the device of high order exactly, and its figure by covariance."""
        try:
            value = attained.device.measure(self.figure)
        except PosrealError as error:
            raise NotProven(f"the device stated to reach {attained.value:.7g} {self.unit} does not: {error}") from None
        if abs(value - attained.value) > _MEASURED * value or attained.value < self.value * (1 - _ROUNDING):
            raise NotProven(
                f"a device is stated to reach {attained.value:.10g} {self.unit}, and it has {value:.10g}, where the "
                f"bound is {self.value:.10g}"
            )

    def beside(self, best: Design | Rational | float | None, *, label: str = "") -> Bound:
        """The same bound with a design beside it, measured in the bound's own figure.

        Parameters
        ----------
        best : Design, Rational (a port admittance), float (a figure of the bound's kind and unit) or None

        Raises
        ------
        BelowBound
            If it is below the bound: that is an error in the program, not a discovery.
        """
        if best is None:
            return dataclasses.replace(self, best=None)
        if isinstance(best, Design):
            found = Best(label or best.label, self._measured(best.port), best.port)
        elif isinstance(best, Rational):
            found = Best(label or "given device", self._measured(best), best)
        else:
            found = Best(label or "given figure", float(best), None)
        if not found.value >= self.value * (1 - _ROUNDING):
            raise BelowBound(
                f"{found.label} has {self.metric} = {found.value:.10g} {self.unit} ({self.kind}), below the proven "
                f"bound {self.value:.10g}; either the figure is wrong or it is of another kind"
            )
        return dataclasses.replace(self, best=found)

    def _measured(self, port: Rational) -> float:
        try:
            return self.figure.measure(port)
        except ArithmeticError as error:
            raise Unsettled(f"{plain(self.metric, 80)} of a device cannot be computed here: {error}") from None

    def require_not_below(self, design: Design) -> None:
        """Raise `BelowBound` if a design of the same problem is below the bound."""
        self.beside(design)

    def __repr__(self) -> str:
        return f"<Bound on {self.metric}: {self.value:.6g} {self.unit}>"

    def __str__(self) -> str:
        unit = plain(self.unit, 20)
        lines = [
            f"{plain(self.metric, 80)} ≥ {self.value:.7g} {unit} for {self.devices}  ({self.kind})",
            f"  proof: {len(self.certificate.points)} points at {in_words(self.certificate.points)}, {self.form} form; "
            "checked in ball arithmetic, no solver involved",
        ]
        if self.attained is not None:
            lines.append(
                f"  reached: {self.attained.value:.7g} {self.unit} by a passive device of order "
                f"{self.attained.device.order}, so the best possible lies in [{self.value:.5g}, "
                f"{self.attained.value:.5g}] {self.unit}, {self.room_percent:.2g} %"
            )
        if self.best is not None:
            lines.append(
                f"  best known: {self.best.value:.7g} {unit} ({plain(self.best.label, 80)}, same figure); "
                f"gap {self.gap_percent:.3g} %"
            )
        return "\n".join(lines)

    def described(self) -> list[str]:
        """What the figure is, of which vehicle or plant, on which track: what the proof is a proof of."""
        return document.described(self)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able; the document is itself a certificate that `load_bound` reads."""
        return document.to_dict(self)

    def save(self, path: str | Path) -> None:
        """Write the certificate as JSON, whole or not at all."""
        document.save(self, path)


__all__ = ["BelowBound", "Best", "Bound"]
