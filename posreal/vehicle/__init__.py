"""What a device rides in: vehicles cut open at a port, tracks, and the figures by which a suspension is judged."""

from posreal.plant.plant import ClosedLoop, Plant, PortResponses, close
from posreal.vehicle.parameters import described, from_file, override, parameters
from posreal.vehicle.place import Place
from posreal.vehicle.plan_view import PlanView
from posreal.vehicle.quarter_car import QuarterCar
from posreal.vehicle.side_view import SideView
from posreal.vehicle.user_plant import UserPlant
from posreal.vehicle.vehicle import Vehicle, gain_output, measure, whole_band_twin

__all__ = [
    "ClosedLoop",
    "Place",
    "PlanView",
    "Plant",
    "PortResponses",
    "QuarterCar",
    "SideView",
    "UserPlant",
    "Vehicle",
    "close",
    "described",
    "from_file",
    "gain_output",
    "measure",
    "override",
    "parameters",
    "whole_band_twin",
]
