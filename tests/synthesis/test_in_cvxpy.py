"""One step of the inequalities in cvxpy's hand: the same optimum, the same unknowns, and constraints of one's own."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest

import posreal as pr
from posreal.errors import BadInput
from posreal.numerics import sdp
from posreal.synthesis.path_following import device_of


@pytest.mark.parametrize(
    ("options", "device"),
    [
        ({}, "c=2000"),
        ({}, "c=1500 | (c=800 + b=60)"),
        ({"objective": "gain_acceleration"}, "c=1500 + b=200"),
        ({"objective": "J1 + 0.002*J3"}, "c=1500 + b=200"),
        ({"limits": {"J3": 480.0}}, "c=3000 + b=300"),
    ],
)
def test_the_direct_way_and_cvxpy_agree(options, device, monkeypatch):
    given = []
    monkeypatch.setattr(sdp, "in_cvxpy", lambda program, made=sdp.in_cvxpy: given.append(program) or made(program))
    problem, unknowns = pr.step_in_cvxpy(pr.problem("quarter-car", **options), device)
    problem.solve(solver=cp.CLARABEL)
    assert problem.status == "optimal"
    (program,) = given
    direct = sdp.minimise(program.shapes, program.objective, program.inequalities, program.cones)
    t = float(direct.unknowns["t"].item())
    assert t < 1  # the step promises something
    assert problem.value == pytest.approx(t, rel=1e-5)
    for constraint in program.inequalities:  # what cvxpy found is feasible in the direct way's own functions
        F = constraint.function({name: unknowns[name].value[None] for name in constraint.of})[0]
        assert np.linalg.eigvalsh(np.atleast_2d(F)).min() > -1e-5 * max(1.0, np.abs(F).max())
    assert pr.check(device_of({name: v.value for name, v in unknowns.items()}).rational())


def test_a_constraint_of_ones_own():
    problem, unknowns = pr.step_in_cvxpy(pr.problem("quarter-car"), "c=2000")
    problem.solve(solver=cp.CLARABEL)
    free, limit = problem.value, 0.9 * float(unknowns["D"].value.item())
    held = cp.Problem(problem.objective, [*problem.constraints, unknowns["D"] <= limit])
    held.solve(solver=cp.CLARABEL)
    assert float(unknowns["D"].value.item()) <= limit * (1 + 1e-6)
    assert held.value >= free - 1e-7


def test_what_has_no_inequality_is_refused():
    with pytest.raises(BadInput, match="root mean square"):
        pr.step_in_cvxpy(pr.problem("lateral-gauging"), "c=2e4")
