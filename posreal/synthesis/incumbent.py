"""The best candidate so far, and what happened on the way to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from joblib import Parallel, delayed

from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate
from posreal.optimisation.nonlinear_program import Judge
from posreal.synthesis.result import Step

AGREED = 1.001  # a start that lands within that factor of the best agrees with it

Found = tuple[float, Chart, Candidate]
Task = tuple[Chart, Candidate, int, float]
"""Chart, start, iterations and tolerance of a local search."""


@dataclass
class Incumbent:
    """State of a synthesis: everything that is found is offered to it.

    Attributes
    ----------
    judge : Judge
    jobs : int
        Local searches that run side by side; what is found does not depend on it.
    progress : function of str
    first : a plain damper, the default one where the vehicle has one
    best, value : the best candidate and its measure
    history : accepted candidates
    landed : where the local searches of the order that was asked for ended
    """

    judge: Judge
    jobs: int
    progress: Callable[[str], None]
    first: Candidate = field(init=False)
    best: Candidate = field(init=False)
    value: float = math.inf
    history: list[Step] = field(default_factory=list)
    landed: list[float] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.first = self.best = Candidate(
            self.judge.default, self.judge.nominal
        )  # there is always a device to start from
        self.offer("start", self.best, self.judge.measure(self.best))

    def offer(self, method: str, candidate: Candidate, value: float) -> None:
        """Take a candidate that was measured if it is better than the best so far."""
        if value < self.value:
            self.best, self.value = candidate, value
            self.history.append(Step(method, value))

    def regrid(self, judge: Judge) -> None:
        """Measure by another judge's grids from now on, the best so far first."""
        if judge.light == self.judge.light:
            return
        self.judge = judge
        self.value = self.judge.measure(self.best)
        last = self.history[-1:] if math.isfinite(self.value) else []
        self.history = [step for step in self.history if step.value > self.value]
        self.history += [Step(step.method, self.value) for step in last]

    def improve(self, method: str, tasks: Sequence[Task]) -> Iterator[Found]:
        """Run local searches, in this process or in several, and offer what they find, in order."""
        if self.jobs == 1 or len(tasks) == 1:
            outcomes: Iterator[tuple[float, Candidate]] = (self.judge.improved(*task) for task in tasks)
        else:
            run = Parallel(n_jobs=self.jobs, return_as="generator")
            outcomes = run(delayed(self.judge.improved)(*task) for task in tasks)
        for (chart, _, _, _), (value, candidate) in zip(tasks, outcomes, strict=True):
            self.offer(method, candidate, value)
            yield value, chart, candidate

    def note(self, text: str) -> None:
        """Say something in the result and on the way."""
        self.notes.append(text)
        self.progress(text)

    @property
    def agreeing(self) -> int:
        """Starts that ended near the best."""
        return sum(value <= self.value * AGREED for value in self.landed)
