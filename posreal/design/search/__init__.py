"""Networks as the unknown: every topology of up to N springs, dampers and inerters, each at its best values."""

from posreal.design.search.options import read_at_most, read_bounds, read_limits
from posreal.design.search.restrict import restricted, unrestricted
from posreal.design.search.result import FrontPoint, RunnerUp, Search, Tally
from posreal.design.search.run import search

__all__ = [
    "FrontPoint",
    "RunnerUp",
    "Search",
    "Tally",
    "read_at_most",
    "read_bounds",
    "read_limits",
    "restricted",
    "search",
    "unrestricted",
]
