"""What a synthesis found, and the evidence that it was looked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from posreal.admittance import Rational
from posreal.metric import Measured


@dataclass(frozen=True)
class Step:
    """An accepted iterate: the method that reached it and the objective there, never above the step before."""

    method: str
    value: float

    def __str__(self) -> str:
        return f"{self.method}: {self.value:.6g}"


@dataclass(frozen=True)
class Synthesis:
    """The best positive-real device found for a problem.

    Attributes
    ----------
    device : Rational
        Exactly positive real; in its mounting place, behind the bush and beside the static spring.
    order : int
        The order that was asked for; the device's McMillan degree is at most that (plus a parallel spring and inerter,
        where they were allowed).
    metrics : mapping of name to Measured
        Recomputed from `device` on the vehicle with `parameters`.
    value : float
        The objective among them.
    parameters : mapping of vehicle parameter to value
        What the problem leaves free, SI units.
    history : tuple of Step
        Accepted iterates, best so far at each; the last one `method` reached by the matrix inequalities alone stands
        before the first that is not theirs.
    starts, agreeing : int
        Starts of the local searches, and how many ended within 0.1 % of the best.
    seconds : float
    seed : int
    method : str
    notes : tuple of str
        What the user should know: lifting, interruption, refused steps.
    """

    device: Rational
    order: int
    metrics: Mapping[str, Measured]
    value: float
    parameters: Mapping[str, float]
    history: tuple[Step, ...]
    starts: int
    agreeing: int
    seconds: float
    seed: int
    method: str
    notes: tuple[str, ...] = field(default=())

    def reached_by(self, method: str) -> float | None:
        """The objective that one method ("bmi", "ph", "start") reached last in the history; None if it took no step."""
        return next((step.value for step in reversed(self.history) if step.method == method), None)
