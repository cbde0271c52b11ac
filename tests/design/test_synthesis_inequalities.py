"""Each matrix inequality says what it should: against Lyapunov, against exact arithmetic, against eigenvalues."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from posreal.admittance import Rational, check, random_port_hamiltonian
from posreal.design.named import problem
from posreal.design.synthesis import bmi, inequalities, semidefinite
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.criterion import Candidate, Criterion
from posreal.design.synthesis.damping import Damping
from posreal.design.synthesis.generalised_plant import generalised_plant
from posreal.design.synthesis.presented import rounded
from posreal.design.synthesis.scale import reference
from posreal.design.synthesis.semidefinite import Shape
from posreal.design.synthesis.storage import port_hamiltonian


@pytest.mark.parametrize("seed", range(4))
def test_h2_optimum_is_the_lyapunov_value(seed):
    quarter = problem("quarter-car")
    plant = generalised_plant(quarter, reference(quarter))
    form = random_port_hamiltonian(2, np.random.default_rng(seed)).state_space()
    A, C = plant.closed(form.A, form.B, form.C, form.D)
    B = np.vstack([plant.Bw, np.zeros((2, 1))])
    X = solve_continuous_lyapunov(A.T, -C.T @ C)
    n = len(A)
    outcome = semidefinite.minimise(
        {"X": Shape(n, n, symmetric=True)},
        lambda u: np.trace(B.T @ u["X"] @ B, axis1=-2, axis2=-1),
        [lambda u: inequalities.h2(u["X"] @ A, C)],
    )
    found = (B.T @ outcome.unknowns["X"] @ B).item()
    assert found == pytest.approx((B.T @ X @ B).item(), rel=1e-5)


@pytest.mark.parametrize("name", ["quarter-car", "vertical-comfort", "lateral-comfort"])
def test_generalised_plant_has_the_exact_figure(name):
    """Padé delays, balanced truncation and a whole-band norm: within a few per cent of the exact figure."""
    chosen = problem(name)
    scale = reference(chosen)
    plant, criterion = generalised_plant(chosen, scale), Criterion(chosen, scale)
    damper = Chart(0).device(np.array([1.1]))
    form = damper.state_space()
    A, C = plant.closed(form.A, form.B, form.C, form.D)
    X = solve_continuous_lyapunov(A.T, -C.T @ C)
    assert np.sqrt((plant.Bw.T @ X @ plant.Bw).item()) == pytest.approx(criterion.measure(Candidate(damper)), rel=0.04)


@pytest.mark.parametrize("seed", range(12))
def test_positive_real_inequality_agrees_with_the_exact_verdict(seed):
    rng = np.random.default_rng(seed)
    H = random_port_hamiltonian(int(rng.integers(1, 4)), rng).rational()
    margin = check(H).margin
    inside = H | Rational.damper(0.02)
    outside = inside.without(Rational.damper(margin + 0.04))
    assert check(inside)
    assert not check(outside)
    form = port_hamiltonian(inside)
    s = 1j * np.geomspace(0.01, 100, 50)
    assert form(s) == pytest.approx(inside(s), rel=1e-3, abs=1e-3)
    rejected = port_hamiltonian(outside)
    assert rejected is None or np.abs(rejected(s) - outside(s)).max() > 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_sector_inequality_agrees_with_the_poles(seed):
    A = np.random.default_rng(seed).standard_normal((5, 5)) - 2 * np.eye(5)
    poles, vectors = np.linalg.eig(A)
    least = (-poles.real / np.abs(poles)).min()
    X = np.real(np.linalg.inv(vectors @ vectors.conj().T))
    for damping, holds in ((least - 1e-3, True), (least + 1e-3, False)):
        assert (np.linalg.eigvalsh(inequalities.sector(X @ A, damping)).min() > 0) == holds


def test_one_step_has_the_optimum_that_cvxpy_finds():
    """Every inequality written out as [PS2006] prints it, in cvxpy, around the same device in the same ball.

    minimise trace BwᵀX Bw   subject to
    [[M + Mᵀ, Cclᵀ], [Ccl, −I]] ⪯ 0,            M = X0 Acl(K) + (X − X0) Acl0     (H2, X Acl linearised)
    [[Aᵀ + A, B − Cᵀ], [Bᵀ − C, −D − Dᵀ]] ⪯ 0                                     (PR at P = I)
    [[sin θ (N + Nᵀ), cos θ (Nᵀ − N)], [·, sin θ (N + Nᵀ)]] ⪯ 0,   N likewise with Xd   (damping ratio ≥ cos θ)
    ‖(K − K0)/size‖ ≤ r
    """
    quarter = problem("quarter-car")
    plant = generalised_plant(quarter, reference(quarter))
    form = random_port_hamiltonian(1, np.random.default_rng(4)).state_space()
    K0 = {"A": form.A, "B": form.B, "C": form.C, "D": form.D}
    A0, C0 = plant.closed(*K0.values())
    n, radius = len(A0), 0.1
    Bw = np.vstack([plant.Bw, np.zeros((1, 1))])
    X0 = solve_continuous_lyapunov(A0.T, -C0.T @ C0)
    poles, vectors = np.linalg.eig(A0)
    Xd0 = np.real(np.linalg.inv(vectors @ vectors.conj().T))
    zeta = 0.9 * (-poles.real / np.abs(poles)).min()

    def ours(u):
        return plant.closed(u["A"], u["B"], u["C"], u["D"])

    built = semidefinite.minimise(
        {**{name: Shape(1, 1) for name in K0}, "X": Shape(n, n, symmetric=True), "Xd": Shape(n, n, symmetric=True)},
        lambda u: np.trace(Bw.T @ u["X"] @ Bw, axis1=-2, axis2=-1),
        [
            lambda u: inequalities.h2(inequalities.linearised(u["X"], ours(u)[0], X0, A0), ours(u)[1]),
            lambda u: inequalities.positive_real(u["A"], u["B"], u["C"], u["D"]),
            lambda u: inequalities.sector(inequalities.linearised(u["Xd"], ours(u)[0], Xd0, A0), zeta),
        ],
        semidefinite.Ball(K0, radius, np.zeros((4, 4))),
    )
    found = (Bw.T @ built.unknowns["X"] @ Bw).item()

    A, B, C, D = (cp.Variable((1, 1)) for _ in range(4))
    X, Xd = cp.Variable((n, n), symmetric=True), cp.Variable((n, n), symmetric=True)
    Acl = cp.bmat([[plant.A + plant.Bu @ D @ plant.Cy, plant.Bu @ C], [B @ plant.Cy, A]])
    Ccl = cp.hstack([plant.Cz + plant.Dzu @ D @ plant.Cy, plant.Dzu @ C])
    M, N = X0 @ Acl + (X - X0) @ A0, Xd0 @ Acl + (Xd - Xd0) @ A0
    sin, cos = np.sqrt(1 - zeta**2), zeta
    blocks = [
        cp.bmat([[M + M.T, Ccl.T], [Ccl, -np.eye(1)]]),
        cp.bmat([[A.T + A, B - C.T], [B.T - C, -D - D.T]]),
        cp.bmat([[sin * (N + N.T), cos * (N.T - N)], [cos * (N - N.T), sin * (N + N.T)]]),
    ]
    sizes = {name: max(1.0, abs(value.item())) for name, value in K0.items()}
    step = cp.hstack([(v - K0[k])[0, 0] / sizes[k] for k, v in zip("ABCD", (A, B, C, D), strict=True)])
    below = [(block + block.T) / 2 << 0 for block in blocks]
    oracle = cp.Problem(cp.Minimize(cp.trace(Bw.T @ X @ Bw)), [*below, cp.norm(step) <= radius])
    assert oracle.solve(solver=cp.CLARABEL) == pytest.approx(found, rel=1e-6)
    assert found < (Bw.T @ X0 @ Bw).item()


def test_linearised_product_is_exact_to_first_order():
    rng = np.random.default_rng(0)
    X0, A0, dX, dA = rng.standard_normal((4, 3, 3))
    for h in (1e-2, 1e-3):
        error = (X0 + h * dX) @ (A0 + h * dA) - inequalities.linearised(X0 + h * dX, A0 + h * dA, X0, A0)
        assert error == pytest.approx(h**2 * dX @ dA, abs=1e-12)


@pytest.mark.parametrize("chart", [Chart(0), Chart(2), Chart(2, inerter=True), Chart(1, True, True)])
@pytest.mark.parametrize("name", ["quarter-car", "vertical-comfort", "lateral-comfort-primary"])
def test_slope_of_the_figure(chart, name):
    chosen = problem(name)
    criterion = Criterion(chosen, reference(chosen))
    rng = np.random.default_rng(1)
    theta, step = rng.standard_normal((2, chart.size))

    def figure(t: float) -> float:
        return criterion.value_and_slope(chart.values(theta + t * step, criterion.s))[0]

    Y, dY = chart.values_and_slopes(theta, criterion.s)
    _, g, _ = criterion.value_and_slope(Y)
    numeric = (figure(1e-6) - figure(-1e-6)) / 2e-6
    assert (dY @ g).real @ step == pytest.approx(numeric, rel=1e-4, abs=1e-7)


@pytest.mark.parametrize("chart", [Chart(2), Chart(1, True, True)])
@pytest.mark.parametrize("name", ["lateral-comfort", "lateral-comfort-primary"])
def test_slope_of_the_damping_ratios(chart, name):
    chosen = problem(name)
    damping = Damping(chosen.vehicle, reference(chosen), free=tuple(chosen.free), speeds=(3.0, 55.0))
    values = {"Kpy": 5e6, "Cpy": 1e4}
    theta, step = np.random.default_rng(2).standard_normal((2, chart.size))
    _, slope, by = damping.ratios_and_slopes(chart, theta, values)
    ahead, behind = (damping.ratios_and_slopes(chart, theta + h * step, values)[0] for h in (1e-6, -1e-6))
    assert step @ slope == pytest.approx((ahead - behind) / 2e-6, rel=1e-4, abs=1e-7)
    for parameter, h in (("Kpy", 50.0), ("Cpy", 0.1)) if chosen.free else ():
        ahead, behind = (
            damping.ratios_and_slopes(chart, theta, values | {parameter: values[parameter] + d})[0] for d in (h, -h)
        )
        assert by[parameter] == pytest.approx((ahead - behind) / (2 * h), rel=1e-3, abs=1e-12)


def test_chart_holds_a_device_of_lower_order():
    device = random_port_hamiltonian(1, np.random.default_rng(3))
    chart = Chart(3)
    s = 1j * np.geomspace(0.1, 10, 20)
    assert chart.values(chart.vector(device), s) == pytest.approx(device(s), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_rounding_keeps_positive_realness(seed):
    """Lossless but for one column of dissipation: the real part touches 0, the worst case for rounding."""
    rng = np.random.default_rng(seed)
    theta = rng.standard_normal(Chart(2).size)
    theta[-6:] = 0.0
    theta[-3:] = rng.standard_normal(3)
    exact = Chart(2).device(theta).rational()
    short, _ = rounded(exact.scaled(20000))
    assert check(short)
    s = 1j * np.geomspace(0.01, 100, 50)
    assert short(s) == pytest.approx(exact.scaled(20000)(s), rel=1e-8)


def test_a_bad_model_cannot_make_it_worse():
    """With a slope that points the wrong way no step is better, so none is taken."""
    quarter = problem("quarter-car")
    scale = reference(quarter)
    criterion = Criterion(quarter, scale)
    start = random_port_hamiltonian(1, np.random.default_rng(0))
    outcome = bmi.iterate(
        generalised_plant(quarter, scale),
        start,
        lambda device: criterion.measure(Candidate(device)),
        lambda device: -10 * criterion.slope(Candidate(device)),
        settings=bmi.Settings(iterations=10),
    )
    assert outcome.value <= criterion.measure(Candidate(start))
