"""The best values of a maker's list for a network that has been designed.

Rounding each value to the nearest that is listed is not the best that the list has: what one element loses another
makes up for. Of all combinations of the nearest listed values to either side the objective is computed; the best that
keeps the constraints as the metrics measure them is taken, and where nothing is constrained single values are moved on
by a step, up to four from where they were designed, for as long as that helps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any

from posreal.errors import BadInput, Infeasible, PosrealError
from posreal.network import Network
from posreal.network.as_made import made
from posreal.network.preferred_numbers import read_steps
from posreal.optimisation.caveats import reported
from posreal.optimisation.element_search import ElementSearch
from posreal.optimisation.evaluate import evaluate
from posreal.specification.as_made import ideal_beside
from posreal.specification.design import Design
from posreal.specification.layout import ElementRule, Layout, layout
from posreal.specification.mounted import BUSH, STATIC, mounted
from posreal.specification.problem import Problem
from posreal.specification.usual import own_springs
from posreal.study.tolerance import as_network
from posreal.text_table import table
from posreal.units import engineering

_TRIALS = 2048  # combinations whose objective is computed
_FARTHEST = 4  # steps to either side
_MEASURED = 64  # combinations, the most promising, whose constraints are measured
_UNITS = {"k": "N/m", "c": "N*s/m", "b": "kg"}

Values = tuple[Fraction, ...]


@dataclass(frozen=True)
class Preferred:
    """A design and the best of it that a list of values has.

    Attributes
    ----------
    given : Design
    design : Design
        With listed values.
    changed : mapping of element to (value as designed, listed value)
        SI units.
    steps : str
        What was listed: a series, a file.
    """

    given: Design
    design: Design
    changed: Mapping[str, tuple[float, float]]
    steps: str

    @property
    def cost_percent(self) -> float:
        """By how much the objective is worse than as designed, %."""
        return 100 * (self.design.objective.value / self.given.objective.value - 1)

    def __str__(self) -> str:
        """The values before and after, and what they cost."""
        rows = [
            [
                name,
                engineering(before, _UNITS[name[0]], 4),
                engineering(after, _UNITS[name[0]], 6),
                f"{100 * (after / before - 1):+.1f} %",
            ]
            for name, (before, after) in self.changed.items()
        ]
        name, before, after = self.design.problem.objective, self.given.objective, self.design.objective
        return "\n".join(
            [
                table(["element", "as designed", self.steps, "change"], rows, "lrrr"),
                "",
                f"  {name} {after.value:.6g} {after.unit} in place of {before.value:.6g}: {self.cost_percent:+.2g} %",
                *(f"  {c}: {c.verdict(self.design.metrics)}" for c in self.design.problem.constraints),
                *(f"  note: {note}" for note in self.design.found.get("notes", ())),
                *(f"  {said}" for said in [self.design.usual_sentence] if said),
                f"  {self.design.bought}",
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "steps": self.steps,
            "design": self.design.to_dict(),
            "given": self.given.to_dict(),
            "changed": {name: list(pair) for name, pair in self.changed.items()},
            "cost_percent": self.cost_percent,
        }


def preferred(
    problem_or_design: Problem | Design | str,
    device: Any = None,
    *,
    steps: Any = "R20",
    progress: Callable[[str], None] = lambda text: None,
) -> Preferred:
    """The best listed values beside those of a device.

    Parameters
    ----------
    problem_or_design : Problem, the name of one, or Design
        A problem with a `device`, or a design.
    device : as :func:`posreal.evaluate` takes it
        An admittance is realised as a network first.
    steps : str, path or mapping
        A series, ``R5`` … ``R40`` or ``E3`` … ``E24``, of every kind of element; or what a maker lists, by kind: see
        :mod:`posreal.network.preferred_numbers`.
    progress : function of str

    Raises
    ------
    BadInput
        For a series or a list that cannot be used, or a device without elements.
    Infeasible
        If no combination of listed values nearby keeps the constraints.
    """
    known = read_steps(steps)
    design = problem_or_design if isinstance(problem_or_design, Design) else evaluate(problem_or_design, device)
    design = as_network(design)
    network = design.bought
    if network is None:
        raise BadInput("the device has no elements whose values could be listed ones")
    settled, values = _settled(design, network), network.values()
    names = [name for name in values if name[0] in known and name not in settled]
    if not names:
        raise BadInput("of the kinds of elements of the device none is listed")
    reach = max(1, min(_FARTHEST, math.floor(_TRIALS ** (1 / len(names)) / 2)))
    near = [known[name[0]].around(values[name], reach) for name in names]
    if math.prod(len(each) for each in near) > _TRIALS:  # so many elements that only the nearest can be a start
        near = [[_nearest(each, values[name])] for name, each in zip(names, near, strict=True)]
    trial = _Trial(design, network, names)
    progress(f"{math.prod(len(each) for each in near)} combinations of listed values")
    order = sorted(product(*near), key=trial.value)
    if not design.problem.constraints:
        allowed = [known[name[0]].around(values[name], _FARTHEST) for name in names]
        order = [trial.descended(order[0], allowed), *order]
    for chosen in order[:_MEASURED]:
        found = trial.measured(chosen)
        if found is not None and found.feasible:
            changed = {name: (values[name], float(value)) for name, value in zip(names, chosen, strict=True)}
            called = steps if isinstance(steps, str) and not steps.endswith(".toml") else "listed"
            return Preferred(design, reported(found), changed, called)
    kept = "; ".join(str(constraint) for constraint in design.problem.constraints) or "the vehicle stable"
    raise Infeasible(
        f"no listed values near those of the device were found that keep {kept}; take a finer series, or a design with "
        "more room"
    )


def _nearest(listed: list[Fraction], value: float) -> Fraction:
    """The nearest by ratio."""
    return min(listed, key=lambda one: abs(math.log(one / value)))


def _settled(design: Design, network: Network) -> set[str]:
    """Elements of a whole strut that are the vehicle's own, or that its layout fixes."""
    if not design.whole:
        return set()
    own = own_springs(design.problem).values()
    found = {name for name, value in network.values().items() if name[0] == "k" and value in own}
    with suppress(BadInput):  # a layout of the user's own, of which the values alone are known
        rules = layout(design.label).rules
        found |= {name for name, rule in rules.items() if rule.role is not None or rule.fixed is not None}
    return found


def _moved(chosen: Values, allowed: Sequence[Sequence[Fraction]]) -> Iterator[Values]:
    """The values with one of them a step further or back."""
    for i, listed in enumerate(allowed):
        here = listed.index(chosen[i])
        for there in (here - 1, here + 1):
            if 0 <= there < len(listed):
                yield (*chosen[:i], listed[there], *chosen[i + 1 :])


class _Trial:
    """A design's network with other values of some elements."""

    def __init__(self, design: Design, network: Network, names: list[str]) -> None:
        self.design, self.network, self.names = design, network, names
        self.problem = replace(design.problem, free={}, tolerances=None)
        strut = network if design.whole else mounted(self.problem, network)
        rules = {name: self._rule(name, float(value)) for name, value in strut.exact_values().items()}
        self.layout = Layout(design.label, strut.topology(), "", "", rules, ())
        self.search = ElementSearch(self.problem, self.layout)
        self._known: dict[Values, float] = {}

    def _rule(self, name: str, value: float) -> ElementRule:
        if name in (BUSH, STATIC) and not self.design.whole:
            return ElementRule(fixed="bush" if name == BUSH else "static spring")
        if name not in self.names:
            return ElementRule(fixed=value)
        return ElementRule(bounds=(value * 1e-3, value * 1e3))

    def value(self, chosen: Values) -> float:
        """The objective as the search's own figures see it."""
        if chosen not in self._known:
            named = dict(zip(self.names, map(float, chosen), strict=True))
            value = self.search.value(self.search.point(named, {}))
            self._known[chosen] = value if math.isfinite(value) else math.inf
        return self._known[chosen]

    def descended(self, chosen: Values, allowed: Sequence[Sequence[Fraction]]) -> Values:
        """Where single steps lead that each make the objective less, each value among those allowed."""
        while True:
            better = min(_moved(chosen, allowed), key=self.value, default=chosen)
            if not self.value(better) < self.value(chosen):
                return chosen
            chosen = better

    def measured(self, chosen: Values) -> Design | None:
        """The design with these values, by the problem's own metrics; None if the vehicle is not stable."""
        design, whole = self.design, self.design.whole
        bought = self.network.with_values(dict(zip(self.names, chosen, strict=True)))
        keep = [name for name in bought.names if name not in self.names] if whole else []
        network = made(bought, design.problem.elements, keep=keep)
        device = network.admittance()
        try:
            metrics = design.problem.metrics(design.problem.port(device, whole=whole))
        except PosrealError:
            return None
        vehicle = {name: value for name, value in design.parameters.items() if name not in self.network.names}
        return replace(
            design,
            device=device,
            network=network,
            metrics=metrics,
            parameters=bought.values() | vehicle,
            ideal=ideal_beside(design.problem, bought, whole=whole),
            found={"method": "listed values"},
        )
