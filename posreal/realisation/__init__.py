"""From an admittance to a network, one algorithm a file, each result proven from its graph."""

from posreal.errors import DoesNotApply, Unproven
from posreal.realisation.fit import Limits
from posreal.realisation.methods import METHODS
from posreal.realisation.nearest import Repair, nearest_positive_real
from posreal.realisation.proof import Proof, prove
from posreal.realisation.realisation import Realisation, realise, realise_all

__all__ = [
    "METHODS",
    "DoesNotApply",
    "Limits",
    "Proof",
    "Realisation",
    "Repair",
    "Unproven",
    "nearest_positive_real",
    "prove",
    "realise",
    "realise_all",
]
