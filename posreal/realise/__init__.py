"""From an admittance to a network, one algorithm a file, each result proven from its graph."""

from posreal.realise.fit import Limits
from posreal.realise.methods import METHODS
from posreal.realise.nearest import Repair, nearest_positive_real
from posreal.realise.proof import Proof, prove
from posreal.realise.realisation import Realisation, realise, realise_all
from posreal.realise.refusal import DoesNotApply, Unproven

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
