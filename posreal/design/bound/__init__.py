"""How far from the best possible: proven lower bounds over all positive-real devices."""

from posreal.design.bound.certificate import NotProven
from posreal.design.bound.compute import bound
from posreal.design.bound.ports import Figure, figure
from posreal.design.bound.reach import Reached, reached
from posreal.design.bound.result import BelowBound, Best, Bound

__all__ = ["BelowBound", "Best", "Bound", "Figure", "NotProven", "Reached", "bound", "figure", "reached"]
