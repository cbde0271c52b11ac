"""One step of the matrix inequalities as a cvxpy problem: to read, to extend by one's own constraints, to solve.

    problem, unknowns = step_in_cvxpy(pr.problem("quarter-car"), "c=2000")
    extended = cvxpy.Problem(problem.objective, [*problem.constraints, unknowns["D"] <= 1])
    extended.solve(solver=cvxpy.CLARABEL)

The unknowns are those of the scaled device (:mod:`posreal.optimisation.scaling`): A, B, C, D in port-Hamiltonian
coordinates, the storage or observability matrix of each norm, and t, the bound on the objective in units of its value
at the device where the inequalities are linearised [PS2006].
"""

from __future__ import annotations

from typing import Any

from posreal.admittance.device import as_rational
from posreal.admittance.positive_real import require
from posreal.admittance.positive_real_lemma import port_hamiltonian
from posreal.errors import BadInput
from posreal.network.read_device import read_device
from posreal.numerics import sdp
from posreal.optimisation.scaling import reference
from posreal.specification.problem import Problem
from posreal.synthesis.lmi_starts import goals_of
from posreal.synthesis.path_following import program_at


def step_in_cvxpy(problem: Problem, device: Any, *, radius: float = 0.5) -> tuple[Any, dict[str, Any]]:
    """The semidefinite program of one step, linearised at a device.

    Parameters
    ----------
    problem : Problem
        Its objective and its limits are root mean squares or largest gains.
    device : Rational, Network, python-control system, or text
        In the device's place.
    radius : float
        Of the ball around the scaled device.

    Returns
    -------
    cvxpy.Problem, mapping of name to cvxpy.Variable

    Raises
    ------
    BadInput
        If the objective has no inequality, or the device no storage.
    """
    scale = reference(problem)
    Y = require(as_rational(read_device(device) if isinstance(device, str) else device))
    start = port_hamiltonian(scale.from_admittance(Y))
    if start is None:
        raise BadInput("the device is on the boundary of the positive-real ones, and no storage was found for it")
    value = problem.metrics(problem.port(Y))[problem.objective].value
    return sdp.in_cvxpy(program_at(goals_of(problem, scale), start, value=value, radius=radius))
