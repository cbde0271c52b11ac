"""Every figure is confirmed by a second method; here both are held against programs that share nothing with either.

Right values stand beside their source: closed forms, a dense sum of 2 million points, or mpmath-like quadrature over
the equations of motion solved one frequency at a time (`tests.vehicle.naive`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import control
import numpy as np
import pytest
from flint import acb, arb
from scipy.integrate import quad
from scipy.linalg import expm

import posreal as pr
from posreal.admittance import Rational, roots
from posreal.errors import Infeasible, Unsettled
from posreal.plant import exact_loop, modes, quadrature
from posreal.plant.figures import ClosedPlant, settled
from posreal.plant.plant import Plant
from tests.vehicle import naive


def device(text: str) -> Rational:
    return pr.parse(text).admittance()


def closed(problem: pr.Problem, text: str) -> ClosedPlant:
    return ClosedPlant(problem.plant, {"secondary": problem.port(device(text))})


# --- right values ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("c=1090 | ((k=228500 | c=11.22) + b=21.3)", {"J1z_T": 2.400134, "J1z_L": 1.93437}),
        ("k=7648 + b=34.6", {"J1z_L": 1.91628, "J1z_M": 1.24096, "J1z_T": 2.30525}),
    ],
)
def test_a_resonance_between_the_panels_is_seen(text, right):
    """Ride with a light side branch, by a dense sum of 2·10⁶ points."""
    found = pr.evaluate(pr.problem("vertical-comfort"), text).metrics
    for name, value in right.items():
        assert found[name].value == pytest.approx(value, rel=3e-6)


@pytest.mark.parametrize("c", [5.271e-9, 1e-9, 1e-3, 2615.34, 4.288e9])
def test_next_to_no_damping_and_next_to_locked_have_the_closed_form(c):
    """[PS2006]: J1² = 4π²Vκ (kt c/(2 ms²) + k²(ms + mu)/(2 c ms²)) for k | c."""
    car = pr.QuarterCar()
    square = car.kt * c / (2 * car.ms**2) + car.k**2 * (car.ms + car.mu) / (2 * c * car.ms**2)
    found = pr.evaluate(pr.problem("quarter-car"), f"c={c!r}").metrics["J1"]
    assert found.value == pytest.approx(2 * math.pi * math.sqrt(car.V * car.kappa * square), rel=1e-11)


@pytest.mark.parametrize("text", ["k=1", "1811000/s", "s"])
def test_no_damping_at_all_is_a_sentence(text):
    with pytest.raises(Infeasible, match="edge of stability"):
        pr.evaluate(pr.problem("quarter-car"), text)


def weighted_car(seed: int | None = None) -> pr.Problem:
    """Quarter-car whose acceleration passes an ISO 2631 Wk filter in companion form, entries up to 1e13."""
    ms, mu, k, kt = 250.0, 35.0, 20e3, 150e3
    A = np.array([[0, 0, 1, -1], [0, 0, 0, 1], [-k / ms, 0, 0, 0], [k / mu, -kt / mu, 0, 0]])
    B = np.array([[0, 0], [-1, 0], [0, -1 / ms], [0, 1 / mu]])
    car = control.ss(
        A, B, [[-k / ms, 0, 0, 0], [0, 0, 1, -1]], [[0, -1 / ms], [0, 0]], inputs=["road", "f"], outputs=["a", "v"]
    )
    w1, w2, w3, w5, w6 = (2 * math.pi * f for f in (0.4, 100.0, 12.5, 2.37, 3.35))
    s = control.tf("s")
    high = s**2 / (s**2 + math.sqrt(2) * w1 * s + w1**2)
    low = w2**2 / (s**2 + math.sqrt(2) * w2 * s + w2**2)
    turn = (s / w3 + 1) / ((s / w3) ** 2 + s / (0.63 * w3) + 1)
    step = (s**2 + w5 / 0.91 * s + w5**2) / (s**2 + w6 / 0.91 * s + w6**2)
    H = control.tf(high * low * turn * step)
    n = len(H.den[0][0]) - 1
    den, num = H.den[0][0], np.concatenate([np.zeros(n + 1 - len(H.num[0][0])), H.num[0][0]])
    companion = np.vstack([-den[1:] / den[0], np.eye(n)[:-1]])
    F = control.ss(companion, np.eye(n)[:, :1], (num[1:] / den[0])[None, :], [[0]], inputs=["a"], outputs=["aw"])
    whole = control.interconnect([car, F], inputs=["road", "f"], outputs=["aw", "v"])
    if seed is not None:
        transform = np.diag(2.0 ** np.random.default_rng(seed).integers(-30, 30, len(whole.A)))
        back = np.linalg.inv(transform)
        whole = control.ss(
            transform @ whole.A @ back, transform @ whole.B, whole.C @ back, whole.D,
            inputs=["road", "f"], outputs=["aw", "v"],
        )  # fmt: skip
    return pr.problem_from_plant(
        whole, disturbances="road", force="f", velocity="v", performance="aw", density=4 * math.pi * 25 * 5e-7
    )


@pytest.mark.parametrize(("c", "right"), [(1500.0, 0.923348443945), (531.125640794298, 0.743642664029)])
def test_a_weighted_plant_in_raw_and_in_scaled_coordinates(c, right):
    """Right values by 30-digit arithmetic."""
    raw = weighted_car()
    assert pr.evaluate(raw, f"c={c!r}").metrics["rms_aw"].value == pytest.approx(right, rel=1e-9)
    assert pr.evaluate(weighted_car(3), f"c={c!r}").metrics["rms_aw"].value == pytest.approx(right, rel=1e-9)


def test_the_worst_speed_is_found_for_a_light_mode():
    # at 30 m/s the paper's sum is 0.674116, which an independent program gives
    top = "18640.76309*s^2 + 25359275397/442000*s + 667937605/221"
    text = f"({top})/(s^2 + 76309/35360000*s + 573337/3536)"
    problem = pr.problem("lateral-comfort")
    found = pr.evaluate(problem, text).metrics["Macc"]
    at_30 = pr.evaluate(pr.problem("lateral-comfort", vehicle={"V": 30}), text).metrics["J1y"]
    assert at_30.value == pytest.approx(0.674116, rel=2e-6)
    assert found.value >= at_30.value
    assert "the integral is" in found.at


# --- drawn resonances against other arithmetic ----------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_a_resonance_of_any_sharpness_has_its_ride(seed):
    """J1z against adaptive quadrature of the equations of motion, told where the resonance is."""
    rng = np.random.default_rng(seed)
    problem = pr.problem("vertical-comfort")
    frequency, Q, mass = 10 ** rng.uniform(-1, 1.3), 10 ** rng.uniform(0, 6), 10 ** rng.uniform(0.5, 3)
    w = 2 * math.pi * frequency
    text = f"c={10 ** rng.uniform(2, 4)!r} | (b={mass!r} + (k={mass * w * w!r} | c={mass * w / Q!r}))"
    loop = closed(problem, text)
    port, vehicle = problem.mounting.behind + device(text), problem.vehicle
    breaks = np.concatenate([p.imag + np.outer([-1, 1], [0, *10.0 ** np.arange(0, 7, 0.5)]).ravel() * p.real
                             for p in loop.poles if p.imag > 0])  # fmt: skip
    edges = np.unique(np.concatenate([[0, quadrature.BAND], breaks[(breaks > 0) & (breaks < quadrature.BAND)]]))

    def density(omega: float) -> float:
        return vehicle.track().density * abs(naive.vertical(vehicle, port, omega)["acceleration_T"]) ** 2

    nodes, weights = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for a, b in pairwise(edges):
        for low, high in pairwise(np.linspace(a, b, 2 + int((b - a) / 8))):
            points = (low + high) / 2 + (high - low) / 2 * nodes
            total += (high - low) / 2 * sum(h * density(x) for h, x in zip(weights, points, strict=True))
    right = 100 * math.sqrt(total) / vehicle.g
    assert pr.evaluate(problem, text).metrics["J1z_T"].value == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("problem", ["vertical-comfort", "lateral-comfort", "quarter-car"])
@pytest.mark.parametrize("seed", range(4))
def test_port_modes_and_exact_polynomials_are_one_figure(problem, seed):
    rng = np.random.default_rng(seed + 100)
    posed = pr.problem(problem)
    w, mass = 2 * math.pi * 10 ** rng.uniform(-1, 2), 10 ** rng.uniform(0, 3)
    text = f"c={10 ** rng.uniform(3.5, 4.5)!r} | (b={mass!r} + (k={mass * w * w!r} | c={mass * w * 1e-3!r}))"
    loop = closed(posed, text)
    for output in posed.plant.outputs:
        measured = loop.band_rms(output)
        exactly = math.sqrt(loop.transfer(output).band_mean_square(0.0, quadrature.BAND))
        assert measured.value == pytest.approx(exactly, rel=1e-9)
    name = posed.plant.outputs[0]
    transfer = loop.transfer(name)
    assert transfer.mean_square() == pytest.approx(transfer.mean_square_by_residues(), rel=1e-11)
    if not posed.plant.delays.any():
        assert loop.rms_by_frequency(name) == pytest.approx(loop.rms(name).value, rel=1e-9)


def test_exponential_integrals_against_balls():
    """∫ e^{−jωΔ}/(jω − λ) dω in floats, by rigorous quadrature; both signs of Δ, poles on both sides and real ones."""
    rng = np.random.default_rng(5)
    poles = -(10 ** rng.uniform(-3, 2, 40)) + 1j * rng.uniform(-150, 150, 40)
    poles[::5] = poles[::5].real
    for late in (0.0, 0.045, -0.045, 2.4, -2.4):
        found = modes._integral(poles, late, 0.0, 100.0)
        for pole, ours in zip(poles, found, strict=True):
            with roots.precision(120):
                right = acb(0)
                for a, b in pairwise(np.linspace(0, 100, 21).tolist()):
                    right += acb.integral(
                        lambda w, _, at=pole, late=late: (-acb(0, 1) * w * arb(late)).exp() / (acb(0, 1) * w - acb(at)),
                        acb(a),
                        acb(b),
                    )
            assert abs(ours - complex(right)) < 1e-11 * (1 + abs(complex(right)))


# --- stability, hidden modes, gains, peaks --------------------------------------------------------------------------


def with_hidden_mode(real: float, *, seen: bool) -> ClosedPlant:
    """A mass on a spring, and an oscillator that pushes nothing; `seen` couples it to the output."""
    A = np.array([[0, 1, 0, 0], [-4, 0, 0, 0], [0, 0, real, 3], [0, 0, -3, real]], dtype=float)
    plant = Plant(
        A=A, Bw=np.array([[0], [1], [0], [1]], float), Bf=np.array([[0], [-1], [0], [0]], float),
        Cz=np.array([[1, 0, 0, float(seen)]]), Dzw=np.zeros((1, 1)), Dzf=np.zeros((1, 1)),
        Cd=np.array([[1.0, 0, 0, 0]]), Cv=np.array([[0, 1.0, 0, 0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    return ClosedPlant(plant, {"secondary": Rational.damper(1)})


def test_a_hidden_undamped_mode_changes_nothing():
    loop = with_hidden_mode(0.0, seen=False)
    loop.require_stable()
    # ẍ + ẋ + 4x = w of density 1 per rad/s: var x = π/(2·1·4)
    assert loop.rms("z").value == pytest.approx(math.sqrt(math.pi / 8), rel=1e-12)
    with pytest.raises(Infeasible, match="edge of stability"):
        with_hidden_mode(0.0, seen=True).require_stable()
    with pytest.raises(Infeasible, match="not stable"):
        with_hidden_mode(0.1, seen=True).require_stable()


def test_white_noise_that_passes_straight_through_is_infinite():
    problem = pr.problem("vertical-comfort", vehicle={"Cpz": "50 kN s/m"})
    loop = ClosedPlant(problem.plant, {"secondary": problem.vehicle.airspring() | device("c=2e4 | b=300")})
    assert math.isinf(loop.rms("acceleration_T").value)
    assert math.isfinite(loop.band_rms("acceleration_T").value)


@pytest.mark.parametrize("seed", range(4))
def test_the_largest_gain_is_that_of_a_dense_scan(seed):
    rng = np.random.default_rng(seed)
    problem = pr.problem("quarter-car", objective="gain_acceleration")
    w, mass = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(0, 2)
    damper, light = 10 ** rng.uniform(2, 4), mass * w * 10 ** rng.uniform(-5, 0)
    text = f"c={damper!r} | (b={mass!r} + (k={mass * w * w!r} | c={light!r}))"
    loop = closed(problem, text)
    measured, omega = loop.largest_gain("acceleration")
    grid = np.unique(np.concatenate([np.geomspace(1e-2, 1e5, 200_000), *(
        p.imag + abs(p.real) * np.linspace(-30, 30, 60_001) for p in loop.poles if p.imag > 0)]))  # fmt: skip
    grid = grid[grid > 0]
    port = problem.port(device(text))
    z, _ = problem.plant.responses(grid, "acceleration").closed({"secondary": port(1j * grid)})
    dense = float(np.abs(z).max())
    assert measured.value == pytest.approx(dense, rel=1e-6)
    assert measured.value >= dense * (1 - 1e-12)
    assert abs(loop.transfer("acceleration").gain(omega) / measured.value - 1) < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_the_largest_gain_in_coordinates_that_floats_lose_digits_in(seed):
    """A state transformation by powers of two is exact: the gain stays, whatever floats make of it."""
    rng = np.random.default_rng(seed)
    problem = pr.problem("quarter-car", objective="gain_acceleration")
    right = closed(problem, "c=1500 | b=30").largest_gain("acceleration")
    plant = problem.plant
    T = 2.0 ** rng.integers(-40, 41, len(plant.A))
    turned = replace(
        plant, A=plant.A * T / T[:, None], Bw=plant.Bw / T[:, None], Bf=plant.Bf / T[:, None],
        Cz=plant.Cz * T, Cd=plant.Cd * T, Cv=plant.Cv * T,
    )  # fmt: skip
    loop = ClosedPlant(turned, {"secondary": problem.port(device("c=1500 | b=30"))})
    measured, _ = loop.largest_gain("acceleration")
    assert measured.value == pytest.approx(right[0].value, rel=1e-9)
    transfer = loop.transfer("acceleration")
    value, at = transfer.largest_gain()
    assert (value, at) == pytest.approx((right[0].value, right[1]), rel=1e-7)
    near, _ = transfer.largest_gain_on(np.array([0.5, 1.1, 2.0]) * at)
    assert near == pytest.approx(value, rel=1e-12)


def test_a_gain_that_grows_towards_its_limit():
    """A mass whose acceleration follows the force on it at high frequency, overdamped: |z/w| < 1, and 1 is the norm."""
    plant = Plant(
        A=np.array([[0.0, 1.0], [-4.0, -1.0]]), Bw=np.array([[0.0], [1.0]]), Bf=np.array([[0.0], [-1.0]]),
        Cz=np.array([[-4.0, -1.0]]), Dzw=np.ones((1, 1)), Dzf=-np.ones((1, 1)),
        Cd=np.array([[1.0, 0.0]]), Cv=np.array([[0.0, 1.0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    loop = ClosedPlant(plant, {"secondary": Rational.damper(100)})
    measured, omega = loop.largest_gain("z")
    assert measured.value == pytest.approx(1.0, rel=1e-9)
    assert math.isinf(omega)
    assert loop.transfer("z").largest_gain() == (1.0, math.inf)


def test_a_gain_that_is_largest_at_rest():
    """A mass on a spring, overdamped: the gain falls from its static value, which no point of a grid has."""
    plant = Plant(
        A=np.array([[0.0, 1.0], [-1.0, 0.0]]), Bw=np.array([[0.0], [1.0]]), Bf=np.array([[0.0], [-1.0]]),
        Cz=np.array([[1.0, 0.0]]), Dzw=np.zeros((1, 1)), Dzf=np.zeros((1, 1)),
        Cd=np.array([[1.0, 0.0]]), Cv=np.array([[0.0, 1.0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    measured, _ = ClosedPlant(plant, {"secondary": Rational.damper(200)}).largest_gain("z")
    assert measured.value == pytest.approx(1.0, rel=1e-9)


def test_the_instant_of_a_peak_is_found_beside_a_pole_that_takes_all_digits():
    """A damper of 1e-8 N s/m behind the bush puts a pole at −4e14 rad/s; the peak is that of next to no damper."""
    vehicle = pr.problem("vertical-comfort").vehicle
    metric = vehicle.metrics["deflection_front"]
    problem = pr.problem("vertical-comfort")

    def peak(c: str) -> float:
        plant = vehicle.plant("slope")
        return (
            ClosedPlant(plant, {"secondary": problem.port(device(c))}).peak("deflection_front", metric.corners)[0].value
        )

    assert 1e3 * peak("c=1.16596e-8") == pytest.approx(29.8750319, rel=1e-8)
    assert peak("c=1.16596e-8") == pytest.approx(peak("c=1e-3"), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_peak_is_that_of_a_finely_stepped_simulation(seed):
    """Every sample by the matrix exponential of state and ramp together, 2 ms apart, to 30 s."""
    rng = np.random.default_rng(seed)
    w, mass = 2 * math.pi * 10 ** rng.uniform(-0.5, 1.5), 10 ** rng.uniform(1, 3)
    text = f"c={10 ** rng.uniform(3, 4.3)!r} | (b={mass!r} + (k={mass * w * w!r} | c={mass * w * 1e-2!r}))"
    problem = pr.problem("vertical-comfort")
    loop = closed(problem, text)
    step, count = problem.vehicle.wheel_delays[1] / 23, 15_000
    n, m = loop.loop.B.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = loop.loop.A * step, loop.loop.B * step
    block[n : n + m, n + m :] = np.eye(m)
    jump = expm(block)
    ahead, held, ramped = jump[:n, :n], jump[:n, n : n + m], jump[:n, n + m :]
    time = step * np.arange(count)
    inputs = np.clip(0.4 * (time[:, None] - np.array(problem.vehicle.wheel_delays)), 0.0, 0.4)
    j = loop.loop.output("deflection_rear")
    x, z = np.zeros(n), np.empty(count)
    for i in range(count - 1):
        z[i] = loop.loop.C[j] @ x + loop.loop.D[j] @ inputs[i]
        x = ahead @ x + held @ inputs[i] + ramped @ (inputs[i + 1] - inputs[i])
    measured, _ = loop.peak("deflection_rear", ((0.0, 0.4), (1.0, -0.4)))
    assert measured.value == pytest.approx(np.abs(z[:-1]).max(), rel=2e-4)
    assert measured.value >= np.abs(z[:-1]).max() * (1 - 1e-5)


def test_a_slow_train_is_waited_for():
    """At 1 m/s the rear bogie reaches the slope after 19 s: the peak there comes after any fixed window of 8 s."""
    problem = pr.problem("vertical-comfort", vehicle={"V": 1})
    loop = closed(problem, "c=20000")
    _, instant = loop.peak("deflection_rear", ((0.0, 0.4), (1.0, -0.4)))
    assert instant > 19


def test_a_limit_that_is_never_reached_is_the_peak():
    """An overdamped mass pushed by a ramp that ends: the displacement creeps up to its static value."""
    plant = Plant(
        A=np.array([[0.0, 1.0], [-1.0, 0.0]]), Bw=np.array([[0.0], [1.0]]), Bf=np.array([[0.0], [-1.0]]),
        Cz=np.array([[1.0, 0.0]]), Dzw=np.zeros((1, 1)), Dzf=np.zeros((1, 1)),
        Cd=np.array([[1.0, 0.0]]), Cv=np.array([[0.0, 1.0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    loop = ClosedPlant(plant, {"secondary": Rational.damper(4)})
    measured, instant = loop.peak("z", ((0.0, 1.0), (1.0, -1.0)))
    assert measured.value == pytest.approx(1.0, rel=2e-9)
    assert instant > 20


def test_two_methods_that_disagree_give_no_number():
    assert settled("x", (lambda: 1.0, lambda: 2.0, lambda: 2.0 + 1e-7)).value == pytest.approx(2.0)
    with pytest.raises(Unsettled, match="x cannot be told"):
        settled("x", (lambda: 1.0, lambda: 2.0, lambda: math.sqrt(-1.0)))


def test_least_damping_by_isolated_roots():
    """A pole pair −ζω ± jω√(1 − ζ²) with ζ of 1e-9 keeps all its digits."""
    zeta = 2.0**-30
    plant = Plant(
        A=np.array([[0.0, 1.0], [-1.0, 0.0]]), Bw=np.array([[0.0], [1.0]]), Bf=np.array([[0.0], [-1.0]]),
        Cz=np.array([[1.0, 0.0]]), Dzw=np.zeros((1, 1)), Dzf=np.zeros((1, 1)),
        Cd=np.array([[1.0, 0.0]]), Cv=np.array([[0.0, 1.0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    assert exact_loop.least_damping(plant, {"secondary": Rational.damper(2 * zeta)}) == pytest.approx(zeta, rel=1e-14)


def test_a_band_that_ends_inside_a_resonance():
    """∫₀¹ of 1/|1 − ω² + 2jζω|² with ζ = 1e-4: half of the peak, by scipy's quadrature told where it is."""
    plant = Plant(
        A=np.array([[0.0, 1.0], [-1.0, 0.0]]), Bw=np.array([[0.0], [1.0]]), Bf=np.array([[0.0], [-1.0]]),
        Cz=np.array([[1.0, 0.0]]), Dzw=np.zeros((1, 1)), Dzf=np.zeros((1, 1)),
        Cd=np.array([[1.0, 0.0]]), Cv=np.array([[0.0, 1.0]]),
        delays=np.zeros(1), outputs=("z",), groups=("secondary",),
    )  # fmt: skip
    loop = ClosedPlant(plant, {"secondary": Rational.damper(2e-4)})
    squared = lambda w: 1 / ((1 - w * w) ** 2 + (2e-4 * w) ** 2)  # noqa: E731
    right = sum(quad(squared, a, b, epsrel=1e-12)[0] for a, b in ((0, 0.9), (0.9, 0.999), (0.999, 0.9999), (0.9999, 1)))
    assert loop.band_rms("z", 1.0).value == pytest.approx(math.sqrt(right), rel=1e-9)
