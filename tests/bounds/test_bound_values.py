"""The value form: the same inequality by values at points, checked by a plain program in 40 digits, and faster."""

from __future__ import annotations

import copy
import dataclasses
import json
import math

import mpmath
import numpy as np
import pytest
from flint import fmpq

from posreal.admittance import Rational, parse_rational, random_port_hamiltonian
from posreal.admittance.roots import precision
from posreal.admittance.state_space import state_space
from posreal.bounds import ascent, pick, shor_dual
from posreal.bounds.certificate import NotProven
from posreal.bounds.compute import bound
from posreal.bounds.figure import enclosed, figure
from posreal.bounds.file import from_dict, load_bound
from posreal.bounds.points import certify
from posreal.bounds.sampled import Sampled
from posreal.bounds.value_form import ValueCertificate, complex_rows, form, real_form
from posreal.bounds.values import enclosed_values, sampled_values
from posreal.bounds.windows import Windows
from posreal.errors import BadInput, Infeasible, PosrealError
from posreal.plant.plant import close
from posreal.specification.named import problem

QUARTER_CAR = problem("quarter-car")
SIDE = problem("vertical-comfort")
MIDDLE = problem("vertical-comfort", position="M")
PLAN = problem("lateral-comfort")
POINTS = (fmpq(5), (fmpq(20), fmpq(2, 5)), (fmpq(50), fmpq(1, 3)), fmpq(30))
ALL = [QUARTER_CAR, MIDDLE, SIDE, PLAN]
NAMES = {"ids": lambda p: f"{p.name}-{p.objective}" if hasattr(p, "objective") else f"{p}"}


def plain_points(points):
    """The points as mpmath's numbers."""
    found = []
    for point in points:
        if isinstance(point, tuple):
            omega, zeta = (mpmath.mpf(int(part.p)) / int(part.q) for part in point)
            s = omega * mpmath.mpc(zeta, mpmath.sqrt(1 - zeta**2))
            found += [s, mpmath.conj(s)]
        else:
            found.append(mpmath.mpc(mpmath.mpf(int(point.p)) / int(point.q)))
    return found


def plain_response(posed, device, s):
    """√(π S weight) z/w of the closed vehicle at one complex point, from its state space and nothing else."""
    about = figure(posed)
    loop = close(about.plant, {about.plant.groups[0]: state_space(posed.port(device))})
    A = mpmath.matrix(loop.A.tolist())
    x = mpmath.lu_solve(
        s * mpmath.eye(len(loop.A)) - A,
        mpmath.matrix(loop.B.tolist())
        * mpmath.matrix([mpmath.exp(-s * mpmath.mpf(float(delay))) for delay in loop.delays]),
    )
    found = []
    for name, weight in about.weights.items():
        j = loop.output(name)
        direct = sum(
            mpmath.mpf(d) * mpmath.exp(-s * mpmath.mpf(float(delay)))
            for d, delay in zip(loop.D[j], loop.delays, strict=True)
        )
        z = sum(mpmath.mpf(c) * value for c, value in zip(loop.C[j], x, strict=True)) + direct
        found.append(z * mpmath.sqrt(mpmath.pi * mpmath.mpf(loop.density) * int(weight.p) / int(weight.q)))
    return found


@pytest.mark.parametrize("posed", ALL, **NAMES)
def test_the_form_is_the_lagrangian_of_a_device(posed):
    # c + 2 Re b*x + x*Mx against ‖P_K z‖² − ⟨Z, Φ⟩, each from its definition in 40 digits, for a device with a spring
    about, device, c0 = figure(posed), parse_rational("9000 + 20*s + 40000/s"), 20000
    with mpmath.workdps(40):
        s = plain_points(POINTS)
        m, r = len(s), len(about.loops)
        n = [mpmath.sqrt(2 * at.real) for at in s]
        K = mpmath.matrix(m, m)
        for k in range(m):
            for l in range(m):
                K[k, l] = n[k] * n[l] / (s[k] + mpmath.conj(s[l]))
        sigma = [(9000 + 20 * at + 40000 / at - c0) / (9000 + 20 * at + 40000 / at + c0) for at in s]
        seen = sampled_values(about, POINTS, fmpq(c0))
        x = [[2 * v / (1 - mpmath.mpc(complex(w)) * v) for w, v in zip(row, sigma, strict=True)] for row in seen.w]
        squares = mpmath.mpf(0)
        outputs = [plain_response(posed, device, at) for at in s]
        for q in range(len(about.weights)):
            z = mpmath.matrix([nk * value[q] for nk, value in zip(n, outputs, strict=True)])
            squares += (z.H * mpmath.lu_solve(K, z))[0].real
            affine = seen.tau[q] + sum(
                o[q] * np.array([complex(v) for v in row]) for o, row in zip(seen.o, x, strict=True)
            )
            assert np.abs(affine - np.array([complex(v) for v in z])).max() < 1e-7 * np.abs(affine).max()
        rng = np.random.default_rng(5)
        half = rng.standard_normal((r * m, r * m)) + 1j * rng.standard_normal((r * m, r * m))
        Z = half @ half.conj().T
        a = [
            2 + mpmath.mpc(complex(w)) * v
            for row, line in zip(seen.w, x, strict=True)
            for w, v in zip(row, line, strict=True)
        ]
        flat = [v for row in x for v in row]
        inside = mpmath.mpf(0)
        for k in range(r * m):
            for l in range(r * m):
                Phi = (a[k] * mpmath.conj(a[l]) - flat[k] * mpmath.conj(flat[l])) * K[k % m, l % m]
                inside += (mpmath.conj(mpmath.mpc(complex(Z[k, l]))) * Phi).real
    assert inside >= 0
    mu = rng.standard_normal((r * (r - 1) // 2, m)) + 0j  # any: the equality holds
    c, b, M = form(seen, Z, mu)
    x = np.array([complex(v) for v in flat])
    lagrangian = c + 2 * (b.conj() @ x).real + (x.conj() @ M @ x).real
    size = abs(c) + float(inside)
    assert lagrangian == pytest.approx(float(squares - inside), abs=1e-9 * size)


@pytest.mark.parametrize("posed", [MIDDLE, PLAN], **NAMES)
def test_an_old_certificate_says_the_same_by_values(posed):
    # φ_j(s_k), the change of basis, from its definition
    points = (fmpq(30), (fmpq(8), fmpq(1, 2)), (fmpq(60), fmpq(2, 5)))
    old = certify(figure(posed), "lifted", points)
    seen = sampled_values(figure(posed), points, old.damper)
    a, pairs = 30.0, ((8.0, 0.5), (60.0, 0.4))
    s, columns = seen.s, []
    before = np.ones_like(s)
    columns.append(math.sqrt(2 * a) / (s + a) * before)
    before = before * (s - a) / (s + a)
    for omega, zeta in pairs:
        d = s**2 + 2 * zeta * omega * s + omega**2
        columns += [2 * math.sqrt(zeta * omega) * s / d * before, 2 * omega * math.sqrt(zeta * omega) / d * before]
        before = before * (s**2 - 2 * zeta * omega * s + omega**2) / d
    basis = np.array(columns).T
    assert np.abs(basis @ basis.conj().T - 1 / (s[:, None] + s.conj())).max() < 1e-12  # the kernel of K
    N = np.linalg.inv(seen.n[:, None] * basis)
    Z = N.conj().T @ (old.factor @ old.factor.T) @ N
    c, b, M = form(seen, Z, np.zeros((0, 5)))
    value = math.sqrt(c - (b.conj() @ np.linalg.solve(M, b)).real)
    assert value == pytest.approx(old.lower_bound(figure(posed)), rel=1e-8)
    factor = np.linalg.cholesky(real_form(Z, points, 1) + 1e-14 * np.abs(Z).max() * np.eye(5))
    again = complex_rows(factor, points, 1)
    assert np.allclose(again @ again.conj().T, Z, rtol=1e-6, atol=1e-9 * np.abs(Z).max())


def test_balls_hold_the_floats():
    for posed in ALL:
        with precision(128):
            balls = enclosed_values(figure(posed), POINTS, fmpq(20000))
        seen = sampled_values(figure(posed), POINTS, fmpq(20000))
        for name in ("s", "n", "tau", "o", "w", "K", "g"):
            middle = np.array([complex(value) for value in getattr(balls, name).ravel()])
            assert np.allclose(middle, getattr(seen, name).ravel(), rtol=1e-9, atol=1e-12 * np.abs(middle).max())
        assert np.allclose(np.linalg.inv(seen.K), seen.g.conj()[:, None] * seen.K.conj() * seen.g, rtol=1e-8)


@pytest.mark.parametrize("posed", [QUARTER_CAR, MIDDLE, PLAN], **NAMES)
def test_one_loop_has_its_certificate_in_closed_form(posed):
    seen = sampled_values(figure(posed), POINTS, fmpq(20000))
    for tolerance in (1e-1, 1e-3, 1e-5):
        found = pick.solve(seen, tolerance=tolerance)
        Z = found.inverse / found.t
        c, b, M = form(seen, Z, np.zeros((0, seen.size)))
        assert np.linalg.eigvalsh(M)[0] > 0
        value = c - (b.conj() @ np.linalg.solve(M, b)).real
        assert value == pytest.approx(found.value**2 - seen.size / found.t, rel=1e-4 * tolerance + 1e-7)


@pytest.mark.parametrize("posed", [MIDDLE, SIDE, PLAN], **NAMES)
def test_newton_has_the_derivatives_of_the_barrier(posed):
    seen = sampled_values(figure(posed), POINTS, fmpq(20000))
    w0 = seen.w[0] if len(seen.w) == 1 else np.zeros(seen.size)
    rng = np.random.default_rng(2)
    step = 0.05 * rng.standard_normal(seen.size)
    at = pick._complex(step, seen.mirror)

    def value(y):
        a = 2 + w0 * y
        return -np.linalg.slogdet(seen.K * (np.outer(a, a.conj()) - np.outer(y, y.conj())))[1]

    gradient, hessian, _ = pick._barrier(seen.K, w0, at, seen.mirror)
    for k in range(seen.size):
        e = 1e-5 * pick._complex(np.eye(seen.size)[k], seen.mirror)
        assert (value(at + e) - value(at - e)) / 2e-5 == pytest.approx(gradient[k], rel=1e-5, abs=1e-6)
        there, here = (pick._barrier(seen.K, w0, at + sign * e, seen.mirror)[0] for sign in (1, -1))
        assert np.allclose((there - here) / 2e-5, hessian[k], rtol=1e-4, atol=1e-4)


@pytest.fixture(scope="module")
def proven():
    return {posed.name + posed.objective: bound(posed, L=30) for posed in (QUARTER_CAR, MIDDLE, PLAN)}


@pytest.mark.parametrize("count", [60, pytest.param(1000, marks=pytest.mark.long)])
@pytest.mark.parametrize("posed", [QUARTER_CAR, MIDDLE, PLAN], **NAMES)
def test_no_random_passive_device_is_below(posed, count, proven):
    found, rng, tried = proven[posed.name + posed.objective], np.random.default_rng(11), 0
    scale, omega = (2600.0, 20) if posed is QUARTER_CAR else (20000.0, 10)
    for _ in range(count):
        drawn = random_port_hamiltonian(int(rng.integers(0, 5)), rng, 1.0).rational()
        device = drawn.time_scaled(fmpq(1, omega)).scaled(int(scale * 10 ** rng.uniform(-1, 1))) | Rational.damper(5)
        try:
            assert found.figure.measure(posed.port(device)) > found.value
            tried += 1
        except Infeasible:
            continue
    assert tried > count / 4


@pytest.mark.parametrize(("posed", "least"), [(QUARTER_CAR, 1.404), (MIDDLE, 0.775), (PLAN, 0.1425)], **NAMES)
def test_few_points_by_windows_prove_much(posed, least, proven):
    found = proven[posed.name + posed.objective]
    assert found.form == "value"
    assert found.value > least
    assert found.check() >= found.value


def test_the_multipliers_of_two_loops_count_as_the_formula_says():
    # two loops: the certificate of any device's own path point, M ≻ 0 or not, is a number that no device is below
    about = figure(SIDE)
    seen = sampled_values(about, POINTS, fmpq(20000))
    mu = np.array([[1.0, 0.5, 0.2, -0.1, 0.3, 0.4]]) * 1e-4
    factor = 1e-2 * np.eye(2 * seen.size)
    certificate = ValueCertificate(POINTS, fmpq(20000), factor, mu, np.zeros((0, 0)))
    wide = complex_rows(factor, POINTS, 2)
    c, b, M = form(seen, wide @ wide.conj().T, complex_rows(mu.T, POINTS, 1).T)
    expected = c - (b.conj() @ np.linalg.solve(M, b)).real
    if expected > 0 and np.linalg.eigvalsh(M)[0] > 0:
        assert certificate.lower_bound(about) == pytest.approx(math.sqrt(expected), rel=1e-8)
    else:
        assert certificate.lower_bound(about) == 0


def test_saved_and_forged(proven, tmp_path):
    found = proven[MIDDLE.name + MIDDLE.objective]
    found.save(tmp_path / "value.json")
    again = load_bound(tmp_path / "value.json")
    assert again.check() >= again.value == found.value
    assert "places from" in str(again)
    edits = [
        lambda d: d["bound"].update(value=d["bound"]["value"] * 1.001),
        lambda d: d["certificate"].update(damper="-1"),
        lambda d: d["certificate"]["points"].__setitem__(1, d["certificate"]["points"][0]),
        lambda d: d["certificate"]["points"].__setitem__(1, ["20", "1.5"]),
        lambda d: d["certificate"]["points"].__setitem__(1, ["-20", "0.5"]),
        lambda d: d["certificate"].update(form="plain"),
        lambda d: d["certificate"].update(functional=[[1.0]]),
        lambda d: d["certificate"].update(
            factor=[[1.5 * value for value in row] for row in d["certificate"]["factor"]]
        ),
        lambda d: (
            d["about"]["vehicle"].update(mv=d["about"]["vehicle"]["mv"] * 1.1)
            if "mv" in d["about"]["vehicle"]
            else d["about"]["vehicle"].update(g=9.9)
        ),
    ]
    for edit in edits:
        document = json.loads(json.dumps(found.to_dict()))
        edit(document)
        with pytest.raises(PosrealError):
            from_dict(copy.deepcopy(document)).check()


def test_any_multiplier_gives_a_bound_or_none(proven):
    found = proven[PLAN.name + PLAN.objective]
    for change in (lambda C: C / 2, lambda C: 1.2 * C, lambda C: 0 * C, lambda C: C[::-1]):
        other = dataclasses.replace(found.certificate, factor=change(found.certificate.factor))
        try:
            assert other.lower_bound(found.figure) <= found.value * (1 + 1e-8)
        except NotProven:
            continue


def test_the_points_fill_their_windows():
    knots = np.array([1.0, 10.0, 100.0])
    shape = Windows(knots, np.log([3.0, 1.0, 0.2]), math.log(0.5))
    for size in (60, 61):
        seen = sampled_values(figure(MIDDLE), shape.points(size), fmpq(20000))
        assert seen.size == size
        omega = np.geomspace(1e-4, 1e6, 200_000)
        delay = (2 * seen.s.real / np.abs(1j * omega[:, None] - seen.s) ** 2).sum(axis=1)
        assert np.trapezoid(delay, omega) == pytest.approx(math.pi * size, rel=1e-3)
        inner = np.array([delay[np.searchsorted(omega, at)] for at in (2.0, 10.0, 30.0)])
        wanted = np.exp(np.interp(np.log([2.0, 10.0, 30.0]), np.log(knots), np.log([3.0, 1.0, 0.2])))
        assert np.allclose(inner / inner[1], wanted / wanted[1], rtol=0.2)


def test_the_value_form_chooses_its_own_points():
    with pytest.raises(BadInput, match="leave omega0 out"):
        bound(MIDDLE, omega0=10, form="value", L=4)
    with pytest.raises(BadInput, match="mean squares"):
        bound(problem("quarter-car", objective="gain_acceleration"), form="value", L=4)
    with pytest.raises(BadInput, match="distinct"):
        enclosed_values(figure(MIDDLE), (fmpq(3), fmpq(3)), fmpq(1))


# --- several loops -------------------------------------------------------------------------------------------


SPREAD = ((fmpq(4), fmpq(1, 2)), (fmpq(9), fmpq(1, 2)), (fmpq(20), fmpq(2, 5)), (fmpq(50), fmpq(2, 5)), fmpq(30))


def test_the_climb_has_its_gradient():
    seen = sampled_values(figure(SIDE), SPREAD, fmpq(20000))
    m = seen.size
    rng = np.random.default_rng(4)
    turn = ascent._Turn(np.concatenate([seen.mirror, seen.mirror + m]))
    size = pick.solve(seen).value ** 2
    start = 0.3 * np.eye(2 * m) + 0.02 * rng.standard_normal((2 * m, 2 * m))
    posed = ascent._Point(seen, turn, ascent._Turn(seen.mirror), math.sqrt(size) * start, 0.01 * size)
    u = np.concatenate([np.eye(2 * m).ravel(), 0.1 * rng.standard_normal(m)])
    at = posed.evaluate(u, 0.1 * size)
    assert at is not None
    for _ in range(5):
        for step in (rng.standard_normal(len(u)), np.concatenate([np.zeros(4 * m * m), rng.standard_normal(m)])):
            ends = [posed.evaluate(u + sign * 1e-6 * step, 0.1 * size)[0] for sign in (1, -1)]
            assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(at[1] @ step, rel=1e-5, abs=1e-5 * size)


@pytest.mark.parametrize("posed", [SIDE, problem("vertical-comfort", position="L")], **NAMES)
def test_the_climb_reaches_the_semidefinite_program(posed):
    # the same points by the interior-point method of the lifted form, in another basis
    seen = sampled_values(figure(posed), SPREAD, fmpq(20000))
    climbed = ascent.climb(seen)
    with precision(256):
        data = Sampled.of(enclosed(figure(posed), SPREAD, fmpq(20000)))
    program = math.sqrt(shor_dual.solve(data, tolerance=1e-7).value)
    assert program * (1 - 3e-3) < climbed.value < program * (1 + 1e-5)
    assert climbed.value < climbed.reach


def test_two_loops_by_values(tmp_path):
    found = bound(SIDE, L=30)
    assert (found.form, len(found.certificate.multipliers)) == ("value", 1)
    assert found.value > 1.55
    assert found.check() >= found.value
    rng = np.random.default_rng(12)
    for _ in range(20):
        drawn = random_port_hamiltonian(int(rng.integers(0, 5)), rng, 1.0).rational()
        device = drawn.time_scaled(fmpq(1, 10)).scaled(int(20000 * 10 ** rng.uniform(-1, 1))) | Rational.damper(5)
        assert found.figure.measure(SIDE.port(device)) > found.value
    found.save(tmp_path / "two.json")
    assert load_bound(tmp_path / "two.json").check() >= found.value
    document = json.loads((tmp_path / "two.json").read_text())
    document["certificate"]["multipliers"][0][4] *= 1.5
    with pytest.raises(NotProven):
        from_dict(document).check()


@pytest.mark.long
def test_what_sixty_points_prove_of_two_loops():
    assert bound(SIDE).value > 1.81
    assert bound(problem("vertical-comfort", position="L")).value > 1.5448


@pytest.mark.long
def test_what_two_hundred_points_prove():
    assert bound(MIDDLE, effort=3).value > 0.7953
    assert bound(PLAN, effort=3).value > 0.14402
    assert bound(QUARTER_CAR).value > 1.4100
