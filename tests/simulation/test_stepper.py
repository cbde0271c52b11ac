"""A vehicle step by step: against the closed loop in other coordinates, and against an integration of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import posreal as pr
from posreal.admittance import state_space
from posreal.errors import BadInput
from posreal.network import parse
from posreal.plant.mounting import Copy
from posreal.plant.plant import close
from posreal.simulation.figures import mean_squares, ratio
from posreal.simulation.laws import ElementLaw
from posreal.simulation.statistical import LOCKED, equivalent_dampers, velocities
from posreal.simulation.stepper import beside, stepper
from posreal.simulation.strut import companion, element_velocities
from posreal.simulation.track import ramps, random_track, step_for

BRIDGE = "{1-2: k=2e5, 1-3: c=2e4, 2-3: b=3e2, 2-0: c=9e3, 3-0: k=7e5}"
LONG = "b=300+k=2e5+(c=1e4|b=50)+(k=3e5|c=2e3)"
S = 1j * np.array([0.3, 5.0, 40.0])


@pytest.mark.parametrize("text", ["c=2e4", "k=5e6+c=18e3+b=4e3", BRIDGE, LONG, "b=100|(c=1e4+b=20)"])
def test_powers_of_the_elements_add_up_to_that_of_the_network(text):
    """Tellegen: Y = Σ y a², with a the velocity of each element for one between the terminals."""
    network = parse(text)
    own = element_velocities(network, S)
    y = np.array([value * S ** ("kcb".index(name[0]) - 1) for name, value in network.values().items()])
    assert (y * own**2).sum(axis=0) == pytest.approx(network.admittance()(S), rel=1e-10)


@pytest.mark.parametrize("text", [BRIDGE, LONG])
def test_the_companion_model_is_the_network_at_a_real_point(text):
    """With e = u = 0 a step of h has the conductance Y(2/h), since the midpoint rule is s = (2/h)(z − 1)/(z + 1)."""
    network, h = parse(text), 2e-3
    one = companion(network, h)
    assert one.conductance == pytest.approx(float(network.admittance()(2 / h).real), rel=1e-10)
    assert one.terminal == pytest.approx(element_velocities(network, np.array([2 / h + 0j]))[:, 0].real, rel=1e-10)


VEHICLES = [
    ("vertical-comfort", "k=5e6 + c=17964.926+b=4114.8145"),
    ("vertical-comfort", BRIDGE),
    ("manchester-comfort", "k=5e6 + (c=2e4 | b=300)"),
    ("lateral-comfort", "k=2.45e5 | (c=2.1e4 + b=1.5e4)"),
    ("quarter-car", "k=6e4 | c=2e3 | b=40"),
]


@pytest.mark.parametrize(("name", "text"), VEHICLES)
def test_without_laws_it_is_the_closed_loop_by_the_same_rule(name, text):
    """The closed loop of the port's exact admittance, its own states, by the midpoint rule: the same in any states."""
    problem, network = pr.problem(name), parse(text)
    plant = problem.vehicle.plant(problem.vehicle.random)
    around = problem.layout_mounting
    h = step_for(plant, 2e-3)
    w = random_track(plant, h, 400, 2, seed=1)
    ports = len(plant.groups)
    copies = problem.place.copies or tuple(Copy(tuple(np.eye(ports)[j])) for j in range(ports))
    run = stepper(beside(plant, around.beside), network, copies, {}, h).run(w)
    loop = close(plant, {"secondary": state_space(around.port(network.admittance()))}, shaped=False)
    solve = np.linalg.inv(np.eye(len(loop.A)) - h / 2 * loop.A)
    x = np.zeros((2, len(loop.A)))
    for n in range(400):
        middle = (x + h / 2 * w[n] @ loop.B.T) @ solve.T
        z = middle @ loop.C.T + w[n] @ loop.D.T
        x = 2 * middle - x
        assert run.outputs[n] == pytest.approx(z, rel=1e-6, abs=1e-7 * np.abs(run.outputs).max())


@pytest.mark.parametrize("problem", [pr.problem(name) for name in ("vertical-comfort", "manchester-comfort")])
def test_devices_in_the_ports_add_up_to_one_in_each(problem):
    for place in problem.vehicle.places.values():
        total = sum(copy.count * np.outer(copy.rows, copy.rows) for copy in place.copies)
        assert total == pytest.approx(np.eye(len(total)), abs=1e-12)


def test_onto_the_slope_it_peaks_where_the_metric_says():
    """S5: 29.8336 and 34.4706 mm, by a multibody program 29.8337 and 34.4705; nothing: 29.8752 and 36.0212."""
    problem = pr.problem("vertical-comfort")
    plant = beside(problem.vehicle.plant("slope"), problem.place.beside_strut)
    h = step_for(plant, 1e-3)
    metric = problem.vehicle.metrics["deflection_rear"]
    for network, front, rear in ((parse("k=5e6 + c=17964.926+b=4114.8145"), 29.8336, 34.4706), (None, 29.875, 36.021)):
        run = stepper(plant, network, problem.place.copies, {}, h).run(ramps(plant, h, round(4 / h), metric.corners))
        peaks = 1e3 * np.abs(run.outputs[:, 0]).max(axis=0)
        assert peaks[plant.output("deflection_front")] == pytest.approx(front, abs=5e-4)
        assert peaks[plant.output("deflection_rear")] == pytest.approx(rear, abs=5e-4)


@pytest.mark.parametrize(
    "law",
    [
        ElementLaw(friction=300.0),
        ElementLaw(stiffness=2e5, backlash=2e-3),
        ElementLaw(friction=100.0, stop=3e-3),
        ElementLaw(50.0, 2e5, 2e-3, 4e-3, 1e6),
    ],
)
def test_the_force_of_a_law_is_in_its_graph(law):
    rng = np.random.default_rng(0)
    give, h = np.array([2e-6, 4e-7]), 2e-3
    free, e = 0.5 * rng.normal(size=(500, 2)), 4e-3 * rng.normal(size=(500, 2))
    found = law.force(free, e, give, h)
    v = free - give * found
    mean = e + h / 2 * v
    half = law.backlash / 2
    line = -law.stiffness * np.clip(mean, -half, half) + law.stop_stiffness * (
        mean - np.clip(mean, -law.stop, law.stop)
    )
    rub = found - line
    sliding = np.abs(v) > 1e-9
    assert rub[sliding] == pytest.approx(law.friction * np.sign(v[sliding]), rel=1e-6, abs=1e-6)
    assert np.all(np.abs(rub) <= law.friction * (1 + 1e-9) + 1e-6)


def quarter_car_by_itself(w, h, force_law, c, b):
    """The quarter-car with k | (c + b) written out, its inerter with a regularised law, by LSODA:
    positions zs, zu relative to the road, the inerter's velocity and elongation."""
    v = pr.problem("quarter-car").vehicle

    def rate(t, y):
        zs, zu, vs, vu, u, e = y
        road = w[min(int(t / h), len(w) - 1)]
        through = c * (vs - vu - u)  # of the damper, and so of the inerter
        return [
            vs - road,
            vu - road,
            -(v.k * (zs - zu) + through) / v.ms,
            (v.k * (zs - zu) + through - v.kt * zu) / v.mu,
            (through - force_law(u, e)) / b,
            u,
        ]

    times = h * (np.arange(len(w)) + 0.5)
    found = solve_ivp(rate, (0, h * len(w)), np.zeros(6), "LSODA", times, max_step=h / 2, rtol=1e-6, atol=1e-9)
    zs, zu, vs, vu, u, _ = found.y
    return -(v.k * (zs - zu) + c * (vs - vu - u)) / v.ms


@pytest.mark.parametrize(
    ("law", "regular"),
    [
        (ElementLaw(friction=300.0), lambda u, e: 300.0 * np.tanh(u / 5e-4)),
        (ElementLaw(stop=5e-3, stop_stiffness=2e5), lambda u, e: 2e5 * (e - np.clip(e, -5e-3, 5e-3))),
    ],
)
def test_friction_and_a_stop_against_an_integration_of_its_own(law, regular):
    c, b, h = 1500.0, 60.0, 1e-3
    problem = pr.problem("quarter-car")
    plant = problem.vehicle.plant("road")
    w = random_track(plant, h, 1200, 1, seed=5)
    w = np.repeat(w[::10], 10, axis=0)  # a coarser road, so that both see the same one
    network = parse(f"k=6e4 | (c={c} + b={b})")
    run = stepper(plant, network, (Copy((1.0,)),), {"b": law}, h).run(w)
    free = stepper(plant, network, (Copy((1.0,)),), {}, h).run(w).outputs[:, 0, 0]
    own, ours = quarter_car_by_itself(w[:, 0, 0], h, regular, c, b), run.outputs[:, 0, 0]
    size = math.sqrt(float((own**2).mean()))
    assert math.sqrt(float(((ours - own) ** 2).mean())) < 0.02 * size
    assert math.sqrt(float(((free - own) ** 2).mean())) > 0.08 * size


def test_friction_without_end_locks_and_play_without_end_lets_go():
    problem = pr.problem("vertical-comfort")
    plant = beside(problem.vehicle.plant("track"), problem.place.beside_strut)
    h = step_for(plant, 2e-3)
    w = random_track(plant, h, 1500, 2, seed=2)
    network, copies = parse("k=5e6 + c=17964.926+b=4114.8145"), problem.place.copies

    def outputs(strut, laws):
        return stepper(plant, strut, copies, laws, h).run(w).outputs

    locked, rigid = outputs(network, {"b": ElementLaw(friction=1e9)}), outputs(parse("k=5e6 + c=17964.926"), {})
    assert locked == pytest.approx(rigid, rel=1e-5, abs=1e-6 * np.abs(rigid).max())
    loose = outputs(network, {"k": ElementLaw(stiffness=5e6, backlash=10.0)})
    gone = outputs(None, {})
    assert loose == pytest.approx(gone, rel=1e-4, abs=1e-4 * np.abs(gone).max())
    assert np.array_equal(outputs(network, {"b": ElementLaw(friction=0.0)}), outputs(network, {})) or np.allclose(
        outputs(network, {"b": ElementLaw(friction=0.0)}), outputs(network, {}), rtol=1e-10
    )


def test_statistical_linearisation_is_its_own_fixed_point():
    problem = pr.problem("vertical-comfort")
    plant, network = problem.vehicle.plant("track"), parse("k=5e6 + c=17964.926+b=4114.8145")
    around, copies = problem.layout_mounting, problem.place.copies
    found = equivalent_dampers(plant, around, network, copies, {"b": 500.0})
    sigma = velocities(plant, around, network, copies, found)["b"]
    assert found["b"] == pytest.approx(math.sqrt(2 / math.pi) * 500.0 / sigma, rel=1e-5)
    stuck = equivalent_dampers(plant, around, network, copies, {"b": 1e6})
    assert stuck["b"] == pytest.approx(LOCKED, rel=1e-5)
    # the velocities themselves, of the linear vehicle in time
    h = step_for(plant, 2e-3)
    run = stepper(beside(plant, around.beside), network, copies, {"b": ElementLaw(friction=1e-9)}, h)
    v = run.run(random_track(plant, h, 20000, 8, seed=0)).velocity[4000:]
    own = velocities(plant, around, network, copies, {})["b"]
    assert math.sqrt(float((v**2).mean())) == pytest.approx(own, rel=0.06)


def test_figures_of_a_run():
    t = 1e-3 * np.arange(20000)
    z = np.stack([3 * np.sin(2 * np.pi * 5 * t), np.sin(2 * np.pi * 5 * t) + 7 * np.sin(2 * np.pi * 50 * t)], axis=1)
    assert mean_squares(z, 1e-3, 0.0, 40 * np.pi) == pytest.approx([4.5, 0.5], rel=1e-6)
    assert ratio(np.array([2.0, 4.0]), np.array([1.0, 2.0])) == (pytest.approx(math.sqrt(2)), pytest.approx(0.0))


def test_what_cannot_be_stepped_is_refused():
    with pytest.raises(BadInput, match="inerter beside the strut"):
        beside(pr.problem("quarter-car").plant, pr.Rational.inerter(3))
    levered = pr.Graph(((1, 2, parse("k=1")), (2, 0, parse("c=1"))), ((1, 0, 2, pr.Lever(-1.0)),))
    with pytest.raises(BadInput, match="levers"):
        companion(levered, 1e-3)
