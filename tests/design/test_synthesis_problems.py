"""Synthesis beyond one mean square: peaks, gains, sums, the worst of several, limits, freedoms, a user's own plant.

[DenHartog1956] J.P. Den Hartog, Mechanical Vibrations, 4th edition, McGraw-Hill (1956), section 3.3.
"""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import time

import control
import numpy as np
import pytest

from posreal.admittance import Rational, check
from posreal.design import synthesise as design
from posreal.design.named import limited, problem
from posreal.design.synthesis import synthesise
from posreal.design.synthesis.chart import Chart
from posreal.design.synthesis.measured import figure_of
from posreal.design.synthesis.scale import reference
from posreal.design.user_problem import problem_from_plant
from posreal.errors import BadInput, Infeasible
from posreal.vehicle import QuarterCar

FIGURES = [
    ("lateral-gauging-primary", ("max_yv", "Macc", "static_stiffness"), 1e-6),
    ("vertical-comfort", ("deflection_rear", "deflection_rms_front", "deflection_overall_rear", "J1z_L"), 1e-5),
    ("quarter-car", ("J1", "J3", "inertance", "static_stiffness"), 1e-2),
    ("quarter-car", ("gain_acceleration",), 1e-2),  # a search's grid; the metric refines the peak
]


@pytest.mark.parametrize(("name", "metrics", "tolerance"), FIGURES)
def test_every_figure_is_the_metric_and_has_its_slope(name, metrics, tolerance):
    posed = problem(name)
    if name == "quarter-car":
        posed = limited(posed, {"gain_acceleration": 1e9, "inertance": 1e9})
    scale = reference(posed)
    beside = not scale.impedance
    chart = Chart(2, spring=beside, inerter=beside)
    theta, step = np.random.default_rng(3).standard_normal((2, chart.size))
    device = chart.device(theta)
    parameters = {key: 1.1 * getattr(posed.vehicle, key) for key in posed.free}
    tuned = posed.with_vehicle(parameters)
    measured = tuned.metrics(tuned.mounting.port(scale.admittance(device.rational())))
    for metric in metrics:
        figure = figure_of(posed, metric, scale)
        values = figure.values(device, parameters)
        assert values.max() == pytest.approx(measured[metric].value, rel=tolerance)
        slopes = figure.slopes(chart, theta, parameters)
        ahead, behind = (figure.slopes(chart, theta + h * step, parameters).values for h in (1e-6, -1e-6))
        assert step @ slopes.by_theta == pytest.approx((ahead - behind) / 2e-6, rel=1e-4, abs=1e-6 * values.max())
        for key, value in parameters.items():
            h = 1e-5 * value
            up, down = (figure.values(device, parameters | {key: value + d}) for d in (h, -h))
            assert value * slopes.by[key] == pytest.approx(
                value * (up - down) / (2 * h), rel=1e-3, abs=1e-5 * values.max()
            )


def test_a_limit_on_another_metric_is_kept_and_costs():
    free = synthesise(problem("vertical-comfort"), 1, starts=2)
    held = problem("vertical-comfort", limits={"deflection_rear": 33.0})
    found = design(held, 1, starts=2)
    found.check()
    assert found.feasible
    assert free.metrics["deflection_rear"].value > 33.0 >= found.metrics["deflection_rear"].value * (1 - 1e-9)
    assert found.objective.value > free.value


def test_an_inertance_is_limited():
    posed = problem("quarter-car", limits={"inertance": 10.0})
    result = synthesise(posed, 1, starts=3, inerter=True)
    unlimited = synthesise(problem("quarter-car"), 1, starts=3, inerter=True)
    assert result.metrics["inertance"].value == pytest.approx(10.0, rel=1e-6)
    assert not posed.violated(result.metrics)
    assert unlimited.value == pytest.approx(1.549070, abs=2e-6)
    assert unlimited.value < result.value < 1.585094


@pytest.mark.parametrize(
    ("limits", "error", "says"),
    [
        ({"J3": 100.0}, Infeasible, "J3 <= 100"),
        ({"static_stiffness": 5e4}, BadInput, "without any device"),
        ({"deflection": 1.0}, BadInput, "cannot be limited"),
        ({"J3": -1.0}, BadInput, "greater than 0"),
        ({"J3": float("nan")}, BadInput, "finite"),
    ],
)
def test_limits_that_cannot_be_kept_are_refused(limits, error, says):
    with pytest.raises(error, match=says):
        synthesise(problem("quarter-car", limits=limits), 0, starts=1, method="ph")


def test_a_weighted_sum_is_between_its_parts():
    both = problem("quarter-car", objective="J1 + 0.002*J3")
    found = design(both, 1, starts=3)
    found.check()
    metrics = found.metrics
    assert found.objective.value == pytest.approx(metrics["J1"].value + 0.002 * metrics["J3"].value, rel=1e-12)
    alone = {name: synthesise(problem("quarter-car", objective=name), 1, starts=3) for name in ("J1", "J3")}
    assert found.objective.value >= alone["J1"].value + 0.002 * alone["J3"].value - 1e-9
    for other in alone.values():
        assert found.objective.value <= other.metrics["J1"].value + 0.002 * other.metrics["J3"].value + 1e-9


def test_the_worst_of_three_points_of_the_body():
    found = design(problem("vertical-comfort", position="worst"), 1, starts=2)
    found.check()
    values = [found.metrics[f"J1z_{point}"].value for point in "LMT"]
    assert found.objective.value == max(values)
    assert max(values) <= 1.9613


def test_the_worst_case_over_operating_points():
    points = [{"Crz": 40e3}, {"Crz": 90e3}]
    robust = design(problem("vertical-comfort", worst_case=points), 1, starts=2)
    robust.check()
    nominal = synthesise(problem("vertical-comfort"), 1, starts=2).device
    posed = robust.problem
    assert robust.objective.value <= posed.metrics(posed.port(nominal))[posed.objective].value * (1 + 1e-9)
    for point in points:
        there = problem("vertical-comfort", vehicle=point)
        assert there.metrics(there.port(robust.device))["J1z_T"].value <= robust.objective.value * (1 + 1e-9)


def test_the_largest_gain_is_no_more_than_any_dampers():
    posed = problem("quarter-car", objective="gain_acceleration")
    result = synthesise(posed, 0, starts=2)
    sizes = [
        posed.metrics(posed.port(Rational.damper(c)))["gain_acceleration"].value for c in np.geomspace(500, 2e4, 60)
    ]
    assert result.value <= min(sizes) * (1 + 1e-6)
    assert result.value == pytest.approx(min(sizes), rel=1e-2)


def test_curve_peak_with_damping_and_comfort_kept():
    gauging = problem("lateral-gauging")
    found = design(gauging, 1, starts=4)
    found.check()
    assert found.feasible
    assert found.objective.value < 74.2  # spring and damper with a series inerter: 74.23
    assert gauging.free["Ksy"].lower <= found.parameters["Ksy"] <= gauging.free["Ksy"].upper


def test_a_freedom_or_an_order_more_never_costs():
    """Every search begins where the smaller ones end, so this holds whatever the starts."""
    quarter = problem("quarter-car", stiffness=2e4)
    freedoms = [(False, False), (True, False), (False, True), (True, True)]
    value = {
        (order, *freedom): synthesise(quarter, order, starts=1, spring=freedom[0], inerter=freedom[1]).value
        for order in (0, 1)
        for freedom in freedoms
    }
    for (order, spring, inerter), J in value.items():
        for bigger in ((order + 1, spring, inerter), (order, True, inerter), (order, spring, True)):
            if bigger in value:
                assert value[bigger] <= J * (1 + 1e-9)


def test_jobs_do_not_change_the_device():
    one, two = (synthesise(problem("quarter-car"), 1, starts=3, method="ph", jobs=jobs) for jobs in (1, 2))
    assert one.device == two.device
    assert one.agreeing == two.agreeing


# --- a plant of the user's own ----------------------------------------------------------------------------------


def quarter_car_as_a_state_space():
    road = QuarterCar().road()
    inputs, outputs = np.hstack([road.Bw, road.Bf]), np.vstack([road.Cz, road.Cv])
    direct = np.vstack([np.hstack([road.Dzw, road.Dzf]), np.zeros((1, 2))])
    names = {"inputs": ["road", "f"], "outputs": ["acceleration", "tyre", "v"]}
    return control.ss(road.A, inputs, outputs, direct, **names), road.density


def test_a_plant_of_the_users_own_has_the_same_optimum():
    system, density = quarter_car_as_a_state_space()
    ports = {"disturbances": "road", "force": "f", "velocity": "v"}
    own = problem_from_plant(
        system, **ports, performance="acceleration", density=density, beside="k=60000", limits={"rms_tyre": 1e4}
    )
    result = synthesise(own, 1, starts=3)
    assert result.value == pytest.approx(1.585094, abs=2e-6)
    assert check(result.device)
    alone = problem_from_plant(system, **ports, performance="acceleration", density=density, beside="k=60000")
    assert synthesise(alone, 1, starts=1, method="bmi").value <= 1.585094 * 1.001


def vibration_absorber():
    """Unit mass on a unit spring, 1 % damped, shaken by F; an absorber of mass 0.05 hangs on the device."""
    A = np.array([[0, 1, 0, 0], [-1, -0.002, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0.0]])
    B = np.array([[0, 0], [1, -1], [0, 0], [0, 20.0]])
    C = np.array([[1, 0, 0, 0], [0, 1, 0, -1.0]])
    return control.ss(A, B, C, np.zeros((2, 2)), inputs=["F", "f"], outputs=["x", "v"])


@pytest.mark.parametrize("objective", ["rms", "gain"])
def test_a_vibration_absorber_against_a_search_by_hand(objective):
    """Spring and damper, free: what [DenHartog1956] tuned by fixed points, here against a grid of both."""
    posed = problem_from_plant(
        vibration_absorber(), disturbances="F", force="f", performance="x", velocity="v", objective=objective
    )
    result = synthesise(posed, 0, starts=3, spring=True)
    grid = [
        posed.metrics(Rational.spring(k) | Rational.damper(c))[posed.objective].value
        for k, c in itertools.product(np.linspace(0.035, 0.055, 9), np.linspace(0.005, 0.025, 9))
    ]
    assert result.value <= min(grid) * (1 + 1e-6)
    assert result.value >= min(grid) * 0.97
    assert check(result.device)


def test_a_delayed_disturbance_counts():
    """Two wheels on the same road, the second half a second later: less than coherent, more than nothing."""
    A, B = np.array([[0, 1], [-1, -0.1]]), np.array([[0, 0, 0], [1, 1, -1.0]])
    system = control.ss(
        A, B, np.array([[1, 0], [0, 1.0]]), np.zeros((2, 3)), inputs=["a", "b", "f"], outputs=["x", "v"]
    )
    common = {"disturbances": ["a", "b"], "force": "f", "performance": "x", "velocity": "v"}
    together, apart = (problem_from_plant(system, **common, delays={"b": late}) for late in (0.0, np.pi))
    damper = Rational.damper(0.05)
    J, less = (posed.metrics(posed.port(damper))["rms_x"].value for posed in (together, apart))
    assert less < 0.4 * J  # half a period late, the second undoes the first


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"force": "g"}, "no input 'g'; it has road"),
        ({"velocity": "u"}, "no output 'u'"),
        ({"performance": "v2"}, "no output"),
        ({"delays": {"f": 0.1}}, "no disturbance 'f'"),
        ({"delays": {"road": -1.0}}, "not negative"),
        ({"density": 0.0}, "greater than 0"),
        ({"force": "road"}, "both a disturbance and a force"),
        ({"velocity": "acceleration"}, "at once"),
        ({"objective": "peak"}, "rms or gain"),
        ({"behind": "c=5"}, "a spring or nothing"),
    ],
)
def test_a_plant_that_does_not_fit_is_refused(changes, says):
    system, _ = quarter_car_as_a_state_space()
    given = {"disturbances": "road", "force": "f", "performance": "acceleration", "velocity": "v"} | changes
    with pytest.raises(BadInput, match=says):
        problem_from_plant(system, **given)


def test_a_real_interrupt_returns_the_best_so_far():
    program = (
        "import sys\n"
        "from posreal.design.named import problem\n"
        "from posreal.design.synthesis import synthesise\n"
        "result = synthesise(problem('vertical-comfort'), 6, progress=lambda text: print(text, flush=True))\n"
        "print('VALUE', result.value, result.notes[0], flush=True)\n"
    )
    run = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=dict(os.environ))
    assert run.stdout is not None
    for line in run.stdout:
        if line.startswith("order 1"):
            break
    time.sleep(0.3)
    run.send_signal(signal.SIGINT)
    rest, _ = run.communicate(timeout=60)
    last = rest.splitlines()[-1].split(maxsplit=2)
    assert run.returncode == 0
    assert last[0] == "VALUE"
    assert float(last[1]) < 2.2
    assert last[2].startswith("interrupted")
