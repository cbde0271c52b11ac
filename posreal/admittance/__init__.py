"""What a device does: its admittance, and whether springs, dampers and inerters can do it."""

from posreal.admittance.device import Device, as_rational
from posreal.admittance.port_hamiltonian import PortHamiltonian, random_port_hamiltonian
from posreal.admittance.positive_real import Verdict, check, is_positive_real, is_regular, require
from posreal.admittance.rational import Rational, parse_rational
from posreal.admittance.state_space import StateSpace, state_space
from posreal.admittance.witness import AxisPole, NegativeReal, RightHalfPlanePole, Witness

__all__ = [
    "AxisPole",
    "Device",
    "NegativeReal",
    "PortHamiltonian",
    "Rational",
    "RightHalfPlanePole",
    "StateSpace",
    "Verdict",
    "Witness",
    "as_rational",
    "check",
    "is_positive_real",
    "is_regular",
    "parse_rational",
    "random_port_hamiltonian",
    "require",
    "state_space",
]
