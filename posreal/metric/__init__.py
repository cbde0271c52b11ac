"""What a suspension is judged by: one kind of metric a file, each a functional of the closed vehicle's response."""

from posreal.metric.closed_vehicle import ClosedVehicle, Cut
from posreal.metric.comfort_index import FiveSecondPercentile, MeanComfort, SperlingIndex
from posreal.metric.damping_ratio import DampingRatio
from posreal.metric.largest_gain import LargestGain
from posreal.metric.measured import Measured
from posreal.metric.metric import Metric, Norm
from posreal.metric.over_speeds import LargestOverSpeeds
from posreal.metric.peak_in_time import PeakInTime
from posreal.metric.port_limit import Inertance, StaticStiffness
from posreal.metric.root_mean_square import RootMeanSquare, SummedRootMeanSquare
from posreal.metric.weighted_sum import WeightedSum

__all__ = [
    "ClosedVehicle",
    "Cut",
    "DampingRatio",
    "FiveSecondPercentile",
    "Inertance",
    "LargestGain",
    "LargestOverSpeeds",
    "MeanComfort",
    "Measured",
    "Metric",
    "Norm",
    "PeakInTime",
    "RootMeanSquare",
    "SperlingIndex",
    "StaticStiffness",
    "SummedRootMeanSquare",
    "WeightedSum",
]
