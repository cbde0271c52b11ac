"""Structures with next to no damping of their own, held against equations written out by hand."""

from __future__ import annotations

import itertools
import math

import control
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov
from scipy.optimize import minimize, minimize_scalar

from posreal import problem_from_plant
from posreal.network import parse
from posreal.optimisation.layout_values import optimise
from posreal.optimisation.mean_square import graded, modes
from posreal.plant import quadrature
from posreal.specification.layout import ElementRule, Layout
from posreal.synthesis.synthesise import synthesise
from posreal.topology.search import search

M, K = 1000.0, 1.5e6


def layout(text, **rules):
    """A layout from a line."""
    return Layout("drawn", parse(text), "", "", rules, ())


def stiffness(count, *, tied=False):
    """Of a chain of floors on the ground, tied at its far end too or not."""
    matrix = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    matrix[-1, -1] -= not tied
    return K * matrix


def chain(count, *, tied=False, port=0, seen=-1, **asked):
    """White ground acceleration, the device from the ground to a floor, the displacement of another over the ground."""
    zero, unit = np.zeros((count, count)), np.eye(count)
    A = np.block([[zero, unit], [-stiffness(count, tied=tied) / M, zero]])
    B = np.hstack([np.zeros((2, count)), [-np.ones(count), -unit[port] / M]]).T
    C = np.vstack([np.append(unit[seen], np.zeros(count)), np.append(np.zeros(count), unit[port])])
    system = control.ss(A, B, C, np.zeros((2, 2)), inputs=["ground", "f"], outputs=["x", "v"])
    return problem_from_plant(system, disturbances="ground", force="f", performance="x", velocity="v", **asked)


def by_covariance(count, b, c, k):
    """R.m.s. of the top with b | (c + k) under the first floor: M ẍ = −K x − M 1 a − e₁ F, Ḟ = k (v − F/c)."""
    mass = M * np.eye(count)
    mass[0, 0] += b
    inverse = np.linalg.inv(mass)
    A = np.zeros((2 * count + 1,) * 2)
    A[:count, count:-1] = np.eye(count)
    A[count:-1, :count] = -inverse @ stiffness(count)
    A[count:-1, -1] = -inverse[:, 0]
    A[-1, count], A[-1, -1] = k, -k / c
    B = np.concatenate([np.zeros(count), -inverse @ (M * np.ones(count)), [0.0]])
    unit = np.concatenate([np.full(count, 1 / 40), np.ones(count), [1e5]])  # balanced, as F is large
    A, B = A * unit / unit[:, None], B / unit
    covariance = solve_continuous_lyapunov(A, -np.outer(B, B))
    return math.sqrt(math.pi * covariance[count - 1, count - 1]) * unit[count - 1]


@pytest.mark.parametrize(("count", "least"), [(2, 0.0120200023251), (3, 0.0272505455066)])
def test_storeys_without_damping_are_minimised_to_the_end(count, least):
    """The values are those of 40-digit arithmetic; the third mode of three storeys keeps 0.3 % of damping."""
    found = optimise(chain(count), layout("b | (c + k)"))
    assert found.objective.value == pytest.approx(least, rel=1e-9)
    values = np.array([found.parameters[name] for name in "bck"])
    assert by_covariance(count, *values) == pytest.approx(found.objective.value, rel=1e-7)
    moved = [
        by_covariance(count, *values * np.exp(0.02 * np.array(d))) for d in itertools.product((-1, 0, 1), repeat=3)
    ]
    assert min(moved) >= found.objective.value * (1 - 1e-7)


def test_a_search_finds_the_row_of_three():
    found = search(chain(3), 3, starts=6)
    assert [point.elements for point in found.front] == [1, 2, 3]
    assert found.best.objective.value == pytest.approx(0.0272505455066, rel=1e-8)
    assert str(found.front[-1].network.topology()) == "b | c + k"
    found.check()


@pytest.mark.parametrize("count", [4, 5])
def test_more_storeys(count):
    found = optimise(chain(count), layout("b | c"))
    b, c = (found.parameters[name] for name in "bc")
    values = [by_covariance(count, b * x, c * y, 1e9) for x in (0.98, 1, 1.02) for y in (0.98, 1, 1.02)]
    assert min(values) >= found.objective.value * (1 - 1e-4)  # the spring of 1 GN/m gives way a little
    assert by_covariance(count, b, c, 1e10) == pytest.approx(found.objective.value, rel=1e-4)


def test_a_cable_with_a_damper_near_its_end():
    """Eight masses between two fixed ends, a damper at the second, the displacement of one in the middle."""
    count, port, seen = 8, 1, 3
    found = optimise(chain(count, tied=True, port=port, seen=seen), layout("c"))

    def rms(log_c):
        D = np.zeros((count, count))
        D[port, port] = math.exp(log_c)
        A = np.block([[np.zeros((count, count)), np.eye(count)], [-stiffness(count, tied=True) / M, -D / M]])
        B = np.append(np.zeros(count), -np.ones(count))
        covariance = solve_continuous_lyapunov(A, -np.outer(B, B))
        return math.sqrt(math.pi * covariance[seen, seen])

    best = minimize_scalar(rms, bounds=(5, 16), method="bounded", options={"xatol": 1e-9})
    assert found.objective.value == pytest.approx(float(best.fun), rel=1e-6)


def test_synthesis_sees_the_light_mode():
    found = synthesise(chain(3), 1, inerter=True, starts=6)
    assert found.objective.value <= 0.0272505455066 * (1 + 1e-7)
    assert not any("the search saw" in note for note in found.found["notes"])


# --- the grid ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.2, 0.03, 1e-3, 1e-5, 1e-8])
def test_a_graded_rule_sees_a_resonance_of_any_width(ratio):
    for omega in (0.37, 12.0, 91.0):
        sigma = ratio * omega
        rule = graded(quadrature.whole_line(10.0), ((omega, sigma),))
        seen = float(rule.weight @ (1 / ((rule.omega - omega) ** 2 + sigma**2)))
        exact = (math.pi / 2 + math.atan(omega / sigma)) / sigma
        assert seen == pytest.approx(exact, rel=1e-8)
    assert graded(rule, ()) is rule


def test_modes_are_those_of_the_closed_loop():
    posed = chain(2)
    found = modes(posed, parse("c=1000").admittance())
    assert [round(omega / math.sqrt(K / M), 3) for omega, _ in found] == [0.618, 1.618]
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness(2) / M, np.diag([-1.0, 0.0])]])
    poles = sorted((p.imag, -p.real) for p in np.linalg.eigvals(A) if p.imag > 0)
    np.testing.assert_allclose(found, poles, rtol=1e-9)


# --- largest gains -------------------------------------------------------------------------------------------


def dense_peak(gain, low, high):
    """The largest of a gain, by a dense sum and a finer one about each of its maxima."""
    omega = np.geomspace(low, high, 4001)
    size = gain(omega)
    best = 0.0
    for i in np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1:
        near = omega[i - 1 : i + 2]
        for _ in range(5):
            near = np.linspace(near[0], near[-1], 41)
            top = int(np.clip(np.argmax(gain(near)), 1, 39))
            near = near[top - 1 : top + 2]
        best = max(best, float(gain(near).max()))
    return best


def test_a_tuned_inerter_damper_has_the_least_largest_gain():
    k0 = M * (2 * math.pi) ** 2
    system = control.ss(
        [[0, 1], [-k0 / M, 0]],
        [[0, 0], [1 / M, -1 / M]],
        np.eye(2),
        np.zeros((2, 2)),
        inputs=["F", "f"],
        outputs=["x", "v"],
    )
    posed = problem_from_plant(system, disturbances="F", force="f", performance="x", velocity="v", objective="gain")
    found = optimise(posed, layout("b + (k | c)", b=ElementRule(fixed=100.0)))

    def peak(theta):
        k, c = np.exp(theta)

        def gain(omega):
            s = 1j * omega
            return np.abs(1 / (M * s**2 + k0 + s / (1 / (100 * s) + 1 / (k / s + c))))

        return dense_peak(gain, 3.0, 12.0)

    at = np.log([found.parameters["k"], found.parameters["c"]])
    best = minimize(lambda x: 1e4 * peak(x), at, method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-11})
    assert found.objective.value == pytest.approx(1e-4 * float(best.fun), rel=1e-8)
    assert found.objective.value == pytest.approx(1.16244921772e-4, rel=1e-9)
    assert found.parameters["c"] == pytest.approx(211.8726, rel=1e-5)


@pytest.mark.parametrize("text", ["b | c", "b | (c + k)"])
def test_the_largest_gain_of_three_storeys(text):
    found = optimise(chain(3, objective="gain"), layout(text))
    names = [name for name in "bck" if name in found.parameters]

    def peak(theta):
        values = dict(zip(names, np.exp(theta), strict=True))

        def gain(omega):
            s = 1j * omega
            D = (stiffness(3) + M * np.multiply.outer(s**2, np.eye(3))).astype(complex)
            behind = 1 / values["c"] + s / values.get("k", math.inf)
            D[:, 0, 0] += s * (values["b"] * s + 1 / behind)
            return np.abs(np.linalg.solve(D, np.full((3, 1), -M))[:, -1, 0])

        return dense_peak(gain, 2.0, 300.0)

    at = np.log([found.parameters[name] for name in names])
    assert peak(at) == pytest.approx(found.objective.value, rel=1e-8)
    best = minimize(peak, at, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-13, "maxiter": 250})
    assert float(best.fun) >= found.objective.value * (1 - 1e-7)


def test_a_gain_is_not_hidden_below_the_grid():
    """A stiff damper holds one storey but for ever: slowly enough, it gives M/K whatever the damper."""
    found = optimise(chain(1, objective="gain"), layout("b | c"))
    assert found.objective.value == pytest.approx(M / K, rel=1e-4)
