"""From an admittance to a network, one algorithm a file, each result proven from its graph."""

from posreal.realise.methods import METHODS
from posreal.realise.proof import Proof, Unproven, prove
from posreal.realise.realisation import Realisation, realise, realise_all

__all__ = ["METHODS", "Proof", "Realisation", "Unproven", "prove", "realise", "realise_all"]
