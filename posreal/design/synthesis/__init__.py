"""The best positive-real device of any order for a problem, and what it is evidence of."""

from posreal.design.synthesis.bmi import Settings
from posreal.design.synthesis.combination import synthesise
from posreal.design.synthesis.result import Step, Synthesis

__all__ = ["Settings", "Step", "Synthesis", "synthesise"]
