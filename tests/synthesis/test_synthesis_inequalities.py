"""Each matrix inequality says what it should: against Lyapunov, against exact arithmetic, against eigenvalues."""

from __future__ import annotations

import control
import cvxpy as cp
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from posreal.admittance import (
    PortHamiltonian,
    Rational,
    StateSpace,
    check,
    random_port_hamiltonian,
    state_space,
)
from posreal.admittance.positive_real_lemma import port_hamiltonian, positive_real
from posreal.numerics import sdp
from posreal.numerics.sdp import Affine, Shape
from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Criterion
from posreal.optimisation.damping import Damping
from posreal.optimisation.problem_figures import figure_of
from posreal.optimisation.scaling import reference
from posreal.plant.plant import close
from posreal.specification.from_plant import problem_from_plant
from posreal.specification.named import problem
from posreal.synthesis import lmi, path_following
from posreal.synthesis.generalised_plant import generalised_plant
from posreal.synthesis.linearised import LinearisedNorm, LoopAt, each_entry, peak, peaks
from posreal.synthesis.rounding import presented


@pytest.mark.parametrize("seed", range(4))
def test_h2_optimum_is_the_lyapunov_value(seed):
    quarter = problem("quarter-car")
    plant = generalised_plant(quarter, reference(quarter))
    form = random_port_hamiltonian(2, np.random.default_rng(seed)).state_space()
    loop = plant.closed(form.A, form.B, form.C, form.D)
    A, B, C = loop.A, loop.B, loop.C
    X = solve_continuous_lyapunov(A.T, -C.T @ C)
    n = len(A)
    outcome = sdp.minimise(
        {"X": Shape(n, n, symmetric=True)},
        Affine(("X",), lambda u: np.trace(B.T @ u["X"] @ B, axis1=-2, axis2=-1)),
        [Affine(("X",), lambda u: lmi.h2(u["X"] @ A, C))],
    )
    found = (B.T @ outcome.unknowns["X"] @ B).item()
    assert found == pytest.approx((B.T @ X @ B).item(), rel=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_bounded_real_optimum_is_the_largest_gain(seed):
    """Two inputs, two outputs and a direct term, against the largest singular value on a fine grid."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((4, 4)) - 3 * np.eye(4)
    B, C, D = rng.standard_normal((4, 2)), rng.standard_normal((2, 4)), 0.3 * rng.standard_normal((2, 2))
    outcome = sdp.minimise(
        {"X": Shape(4, 4, symmetric=True), "gamma": Shape(1, 1)},
        Affine(("gamma",), lambda u: u["gamma"][..., 0, 0]),
        [
            Affine(("X", "gamma"), lambda u: lmi.bounded_real(u["X"] @ A, u["X"] @ B, C, D, u["gamma"])),
            Affine(("X",), lambda u: u["X"]),
        ],
    )
    s = 1j * np.append(np.geomspace(1e-3, 1e3, 4000), 0.0)
    G = C @ np.linalg.solve(s[:, None, None] * np.eye(4) - A, B) + D
    assert outcome.unknowns["gamma"].item() == pytest.approx(np.linalg.norm(G, 2, axis=(1, 2)).max(), rel=1e-4)


def closed(plant, device, spring=0.0):
    form = device.state_space()
    return plant.closed(form.A, form.B, form.C, form.D, spring)


def two_wheels():
    """A body over two masses, its delayed wheels one process and the wind another."""
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [np.array([[-3.0, 1.0], [1.0, -2.0]]), -0.05 * np.eye(2)]])
    B = np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0.5, 1.0, 0.2, -1.0], [1.0, 0.0, 0.3, 1.0]])
    C = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, -1.0]])
    return control.ss(A, B, C, np.zeros((3, 4)), inputs=["front", "rear", "wind", "f"], outputs=["x", "y", "v"])


@pytest.mark.parametrize(
    ("name", "metric", "tolerance"),
    [
        ("quarter-car", "J1", 1e-4),
        ("quarter-car", "gain_tyre_force", 1e-4),
        ("vertical-comfort", "J1z_T", 0.04),
        ("vertical-comfort", "deflection_rms_front", 0.04),
        ("lateral-comfort", "Macc", 0.04),
        ("vertical-comfort", "aw_T", 0.06),
        ("lateral-comfort", "max_aw_y", 0.04),
        ("user", "norm of rms_x, 2*rms_y", 0.01),
        ("user", "gain_x", 0.01),
    ],
)
def test_generalised_plant_has_the_exact_figure(name, metric, tolerance):
    """Padé delays, balanced truncation and a whole-band norm: within a few per cent of the exact figure."""
    if name == "user":
        several = metric.startswith("norm")
        chosen = problem_from_plant(
            two_wheels(),
            disturbances=[["front", "rear"], "wind"],
            delays={"rear": 0.8},
            density=1.0 if not several else {"front": 2.0, "wind": 0.5},
            force="f",
            velocity="v",
            performance=["x", "y"] if several else "x",
            weights={"y": 2.0} if several else None,
            objective="rms" if several else "gain",
        )
    else:
        chosen = problem(name)
        if metric.startswith("gain"):
            chosen = problem(name, objective=metric)
    scale = reference(chosen)
    device = Chart(0).device(np.array([1.1]))
    loop = closed(generalised_plant(chosen, scale, metric), device)
    exact = figure_of(chosen, metric, scale).values(device, {}).max()
    if metric.startswith("gain"):
        s = 1j * np.geomspace(1e-2, 1e2, 20000)
        G = loop.C @ np.linalg.solve(s[:, None, None] * np.eye(len(loop.A)) - loop.A, loop.B) + loop.D
        norm = np.linalg.norm(G, 2, axis=(1, 2)).max()
    else:
        X = solve_continuous_lyapunov(loop.A.T, -loop.C.T @ loop.C)
        norm = np.sqrt(np.trace(loop.B.T @ X @ loop.B))
    assert norm == pytest.approx(exact, rel=tolerance)


def test_spring_and_inerter_stand_beside_the_device():
    """The poles with k and b in the generalised plant are those of the vehicle closed around the whole device."""
    quarter = problem("quarter-car")
    scale = reference(quarter)
    inner = random_port_hamiltonian(2, np.random.default_rng(0))
    whole = PortHamiltonian(inner.J, inner.G, inner.L, 0.3, 0.2)
    loop = closed(generalised_plant(quarter, scale).with_inerter(0.2), inner, 0.3)
    port = quarter.mounting.port(scale.admittance(whole.rational()))
    poles = close(quarter.vehicle.road(), {"secondary": state_space(port)}).poles()
    assert np.sort_complex(np.linalg.eigvals(loop.A) * scale.omega) == pytest.approx(np.sort_complex(poles), rel=1e-6)


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
        assert (np.linalg.eigvalsh(lmi.sector(X @ A, damping)).min() > 0) == holds


def test_one_step_has_the_optimum_that_cvxpy_finds():
    """Every inequality written out as [PS2006] prints it, in cvxpy, around the same device in the same ball.

    minimise trace BwᵀX Bw + γ   subject to
    [[M + Mᵀ, Cclᵀ], [Ccl, −I]] ⪯ 0,            M = X0 Acl(K) + (X − X0) Acl0     (H2, X Acl linearised)
    [[N + Nᵀ, Y Bw, Eclᵀ], [BwᵀY, −γ, 0], [Ecl, 0, −γ]] ⪯ 0,   N likewise with Y  (H∞ of another output)
    [[Aᵀ + A, B − Cᵀ], [Bᵀ − C, −D − Dᵀ]] ⪯ 0                                     (PR at P = I)
    [[sin θ (S + Sᵀ), cos θ (Sᵀ − S)], [·, sin θ (S + Sᵀ)]] ⪯ 0,   S likewise with Xd   (damping ratio ≥ cos θ)
    ‖K − K0‖ ≤ r
    """
    quarter = problem("quarter-car")
    plant = generalised_plant(quarter, reference(quarter))
    other = generalised_plant(quarter, reference(quarter), "gain_tyre_force").amplified(1e-4)
    form = random_port_hamiltonian(1, np.random.default_rng(4)).state_space()
    K0 = {"A": form.A, "B": form.B, "C": form.C, "D": form.D}
    loop0, other0 = plant.closed(*K0.values()), other.closed(*K0.values())
    n, radius, gamma0 = len(loop0.A), 0.02, 1.5
    Bw, A0, C0 = loop0.B, loop0.A, loop0.C
    X0 = solve_continuous_lyapunov(A0.T, -C0.T @ C0)
    Y0 = solve_continuous_lyapunov(other0.A.T, -other0.C.T @ other0.C) / gamma0
    poles, vectors = np.linalg.eig(A0)
    Xd0 = np.real(np.linalg.inv(vectors @ vectors.conj().T))
    zeta = 0.9 * (-poles.real / np.abs(poles)).min()

    def ours(u, of=plant):
        return of.closed(u["A"], u["B"], u["C"], u["D"])

    def product(u, name, Z0, of=plant):
        return lmi.linearised(u[name], ours(u, of).A, Z0, of.closed(*K0.values()).A)

    device = tuple(K0)
    symmetric = dict.fromkeys(("X", "Y", "Xd"), Shape(n, n, symmetric=True))
    built = sdp.minimise(
        {**{name: Shape(1, 1) for name in K0}, **symmetric, "gamma": Shape(1, 1)},
        Affine(("X", "gamma"), lambda u: np.trace(Bw.T @ u["X"] @ Bw + u["gamma"], axis1=-2, axis2=-1)),
        [
            Affine((*device, "X"), lambda u: lmi.h2(product(u, "X", X0), ours(u).C)),
            Affine(
                (*device, "Y", "gamma"),
                lambda u: lmi.bounded_real(
                    product(u, "Y", Y0, other), u["Y"] @ other0.B, ours(u, other).C, other0.D, u["gamma"]
                ),
            ),
            Affine(device, lambda u: positive_real(u["A"], u["B"], u["C"], u["D"])),
            Affine((*device, "Xd"), lambda u: lmi.sector(product(u, "Xd", Xd0), zeta)),
        ],
        [
            Affine(
                device,
                lambda u: np.concatenate(
                    [np.full((len(u["A"]), 1), radius), *(u[k][:, :, 0] - K0[k][:, 0] for k in device)], axis=1
                ),
            )
        ],
    )
    found = (Bw.T @ built.unknowns["X"] @ Bw + built.unknowns["gamma"]).item()

    A, B, C, D = (cp.Variable((1, 1)) for _ in range(4))
    X, Y, Xd = (cp.Variable((n, n), symmetric=True) for _ in range(3))
    gamma = cp.Variable((1, 1))

    def Acl(p):
        return cp.bmat([[p.A + p.Bu @ D @ p.Cy, p.Bu @ C], [B @ p.Cy, A]])

    Ccl = cp.hstack([plant.Cz + plant.Dzu @ D @ plant.Cy, plant.Dzu @ C])
    Ecl = cp.hstack([other.Cz + other.Dzu @ D @ other.Cy, other.Dzu @ C])
    M, S = (Z0 @ Acl(plant) + (Z - Z0) @ A0 for Z, Z0 in ((X, X0), (Xd, Xd0)))
    N = Y0 @ Acl(other) + (Y - Y0) @ other0.A
    sin, cos = np.sqrt(1 - zeta**2), zeta
    blocks = [
        cp.bmat([[M + M.T, Ccl.T], [Ccl, -np.eye(1)]]),
        cp.bmat(
            [
                [N + N.T, Y @ other0.B, Ecl.T],
                [other0.B.T @ Y, -gamma, np.zeros((1, 1))],
                [Ecl, np.zeros((1, 1)), -gamma],
            ]
        ),
        cp.bmat([[A.T + A, B - C.T], [B.T - C, -D - D.T]]),
        cp.bmat([[sin * (S + S.T), cos * (S.T - S)], [cos * (S - S.T), sin * (S + S.T)]]),
    ]
    step = cp.hstack([(v - K0[k])[0, 0] for k, v in zip("ABCD", (A, B, C, D), strict=True)])
    below = [(block + block.T) / 2 << 0 for block in blocks]
    oracle = cp.Problem(cp.Minimize(cp.trace(Bw.T @ X @ Bw + gamma)), [*below, cp.norm(step) <= radius])
    assert oracle.solve(solver=cp.CLARABEL) == pytest.approx(found, rel=1e-6)


def test_linearised_product_is_exact_to_first_order():
    rng = np.random.default_rng(0)
    X0, A0, dX, dA = rng.standard_normal((4, 3, 3))
    for h in (1e-2, 1e-3):
        error = (X0 + h * dX) @ (A0 + h * dA) - lmi.linearised(X0 + h * dX, A0 + h * dA, X0, A0)
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
    short, note = presented(exact.scaled(20000), lambda Y: True)
    assert (note, check(short).positive_real) == ("", True)
    s = 1j * np.geomspace(0.01, 100, 50)
    assert short(s) == pytest.approx(exact.scaled(20000)(s), rel=1e-8)


def norm_of(chosen, metric):
    """The norm that a metric of a problem is."""
    scale = reference(chosen)
    return LinearisedNorm(
        generalised_plant(chosen, scale, metric), metric.startswith("gain_"), figure_of(chosen, metric, scale)
    )


def moved(entries, step):
    """A device's entries after a step."""
    values, i = {}, 0
    for name, part in entries.items():
        values[name] = part + step[i : i + part.size].reshape(part.shape)
        i += part.size
    return values


@pytest.mark.parametrize("name", ["quarter-car", "vertical-comfort"])
def test_a_bound_has_the_value_and_the_slope_of_the_figure(name):
    """The bound of an H2 norm at its own optimum over X and q: the exact figure to first order, with k and b too."""
    chosen = problem(name)
    norm, rng = norm_of(chosen, chosen.objective), np.random.default_rng(2)
    inner = random_port_hamiltonian(2, rng)
    beside = (0.3, 0.2) if name == "quarter-car" else (0.0, 0.0)
    device = PortHamiltonian(inner.J, inner.G, inner.L, *beside)
    form = device.state_space()
    entries = {"A": form.A, "B": form.B, "C": form.C, "D": form.D}
    if name == "quarter-car":
        entries |= {"k": np.array([[0.3]]), "b": np.array([[0.2]])}
    bound = norm.at(device, entries, "0")
    step = rng.standard_normal(sum(part.size for part in entries.values()))

    def least(h):
        there = {name: part[None] for name, part in moved(entries, h * step).items()}

        def at(part):
            def fixed(u):
                count = len(u[part.of[-1]])
                return part.function({**{k: np.repeat(v, count, axis=0) for k, v in there.items()}, **u})

            return Affine(part.of[-1:], fixed)

        objective = Affine(tuple(bound.shapes), lambda u: bound({**there, **u}))
        outcome = sdp.minimise(bound.shapes, objective, [at(bound.inequality)], [at(bound.cones[0])])
        return bound({**there, **{name: part[None] for name, part in outcome.unknowns.items()}}).item()

    def exact(h):
        there = moved(entries, h * step)
        beside = [float(np.sum(there.get(name, 0.0))) for name in ("k", "b")]
        return norm.value(StateSpace(there["A"], there["B"], there["C"], there["D"], *beside))

    assert least(0.0) == pytest.approx(exact(0.0), rel=1e-5)
    assert (least(1e-2) - least(-1e-2)) == pytest.approx(exact(1e-2) - exact(-1e-2), rel=2e-2)


def test_a_peak_has_its_slope_and_its_second_derivative():
    quarter = problem("quarter-car", objective="gain_acceleration")
    plant, rng = generalised_plant(quarter, reference(quarter)), np.random.default_rng(3)
    form = random_port_hamiltonian(2, rng, 1.0).state_space()
    entries = {"A": form.A, "B": form.B, "C": form.C, "D": form.D, "k": np.array([[0.2]])}
    loop = LoopAt.of(plant, entries)
    step = rng.standard_normal(sum(part.size for part in entries.values()))

    def gain(h):
        there = loop(moved(entries, h * step))
        omega = np.linspace(0.95, 1.05, 40001) * top
        values, vectors = np.linalg.eig(there.A)
        split = (there.C @ vectors)[0] * np.linalg.solve(vectors, there.B.astype(complex))[:, 0]
        return np.abs((split / (1j * omega[:, None] - values)).sum(axis=1)).max()

    top = peaks(loop.here)[0]
    value, slope, curvature = peak(loop.here, each_entry(loop, entries), top)
    h = 2e-3
    assert gain(0.0) == pytest.approx(value, rel=1e-8)
    assert (gain(h) - gain(-h)) / (2 * h) == pytest.approx(step @ slope, rel=1e-3)
    assert (gain(h) + gain(-h) - 2 * gain(0.0)) / h**2 == pytest.approx(step @ curvature @ step, rel=1e-2)


class Backwards(LinearisedNorm):
    """A norm that says that it falls where it rises."""

    def slope(self, device):
        return {name: -10 * part for name, part in super().slope(device).items()}


def test_a_bad_model_cannot_make_it_worse():
    """With a slope that points the wrong way no step is better, so none is taken."""
    quarter = problem("quarter-car")
    norm = norm_of(quarter, "J1")
    start = random_port_hamiltonian(1, np.random.default_rng(0))
    goals = path_following.Goals((((1.0, Backwards(norm.plant, False, norm.figure)),),))
    outcome = path_following.iterate(goals, start, norm.value, settings=path_following.Settings(iterations=10))
    assert outcome.value <= norm.value(start)
