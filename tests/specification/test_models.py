"""Models on a page of TOML: the built-in vehicles again, and structures solved by hand, one frequency at a time."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import posreal as pr
from posreal.admittance import state_space
from posreal.plant.plant import close
from posreal.specification.named import vehicle

MODELS = Path(__file__).parents[2] / "examples" / "models"
OMEGA = np.geomspace(0.3, 300, 60)
DEVICES = ("c=1500", "b=300 + c=3224", "k=20e3 | c=800 | b=12", "c=14700 | b=16270 + k=68930")


def response(problem, device, output, omega=OMEGA):
    """z/w of the closed problem, delays exact."""
    port = problem.port(pr.parse(device).admittance())
    plant = problem.plant
    return close(plant, {"secondary": state_space(port)}).response(omega, output)


def pair(name):
    """The built-in problem and the one from the page, and the outputs they share."""
    built_in = {"quarter_car": "quarter-car", "side_view": "vertical-comfort"}[name]
    return pr.problem(built_in), pr.problem(str(MODELS / f"{name}.toml"))


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("name", ["quarter_car", "side_view"])
def test_a_page_says_the_same_as_the_built_in_vehicle(name, device):
    ours, theirs = pair(name)
    for output in set(ours.plant.outputs) & set(theirs.plant.outputs):
        wanted = response(ours, device, output)
        assert np.abs(response(theirs, device, output) - wanted).max() <= 1e-12 * np.abs(wanted).max()
    a, b = pr.evaluate(ours, device).metrics, pr.evaluate(theirs, device).metrics
    shared = set(a) & set(b)
    assert len(shared) >= 3
    for metric in shared:
        assert b[metric].value == pytest.approx(a[metric].value, rel=1e-12)
        assert b[metric].unit == a[metric].unit


@pytest.mark.parametrize("name", ["quarter_car", "side_view"])
def test_open_ports_answer_the_same(name):
    ours, theirs = pair(name)
    output = "acceleration" if name == "quarter_car" else "acceleration_T"
    a, b = (one.plant.responses(OMEGA, output) for one in (ours, theirs))
    for part in ("Tzw", "Tzf", "Pvw", "Pvf"):
        wanted = getattr(a, part)
        # the port of a side is bounce and pitch here too, so that even its two loops are alike
        assert np.abs(getattr(b, part) - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize(
    ("name", "changed"),
    [("quarter_car", {"kt": 2e5, "V": 33.0}), ("side_view", {"Crz": 4e4, "V": 40.0, "bush": 8e6, "Kaz": 2e4})],
)
def test_parameters_change_what_hangs_on_them(name, changed):
    ours, theirs = (one.with_vehicle(changed) for one in pair(name))
    a, b = (pr.evaluate(one, "b=300 + c=9000").metrics for one in (ours, theirs))
    for metric in set(a) & set(b):
        assert b[metric].value == pytest.approx(a[metric].value, rel=1e-12)


def test_a_vehicle_from_a_page_is_one_like_others():
    theirs = pair("side_view")[1].vehicle
    assert pickle.loads(pickle.dumps(theirs)) == theirs
    assert hash(pickle.loads(pickle.dumps(theirs))) == hash(theirs)
    assert theirs != pr.problem(str(MODELS / "side_view.toml"), vehicle={"mv": "40 t"}).vehicle
    assert theirs.passive
    assert theirs.places["secondary"].default_label == "airspring only"


def test_searches_take_a_page_as_they_take_a_name():
    """The optimum and the proven bound of the built-in problem, from the page."""
    ours, theirs = pair("quarter_car")
    for layout in ("S2", "S3"):
        found = [pr.optimise(one, layout, starts=3).objective.value for one in (ours, theirs)]
        assert found[1] == pytest.approx(found[0], rel=1e-8)
    bounds = [pr.bound(one, L=12, omega0=20.0).value for one in (ours, theirs)]
    assert bounds[1] == pytest.approx(bounds[0], rel=1e-9)
    device = pr.synthesise(theirs, 1, starts=2)
    assert device.objective.value == pytest.approx(1.585094, rel=1e-5)
    device.check()
    assert pr.search(theirs, 2).best.objective.value == pytest.approx(1.585094, rel=1e-5)


def test_a_proof_about_a_page_needs_no_page(tmp_path):
    path = tmp_path / "proof.json"
    found = pr.bound(pair("quarter_car")[1], L=8, omega0=20.0)
    found.save(path)
    again = pr.load_bound(path)
    assert again.check() == pytest.approx(found.value, rel=1e-6)
    assert any("one of the file's own" in line for line in again.described())


# --- structures solved by hand, one frequency at a time -------------------------------------------------------------


def solved(M, C, K, force, omega):
    """q of (−ω² M + jω C + K) q = force(ω)."""
    return np.array([np.linalg.solve(-(w**2) * M + 1j * w * C + K, force(w)) for w in omega])


def test_half_car():
    m, J, a, b, mf, mr, kt, kf, kr, cf, V = 730, 1230, 1.01, 1.8, 40, 36, 176e3, 20e3, 18e3, 1300, 20.0
    c = 1450.0
    front, rear = np.array([1, a, -1, 0]), np.array([1, -b, 0, -1])
    M = np.diag([m, J, mf, mr]).astype(float)
    C = cf * np.outer(front, front) + c * np.outer(rear, rear)
    K = kf * np.outer(front, front) + kr * np.outer(rear, rear) + np.diag([0, 0, kt, kt])

    def road(w):
        """From the velocity of the road at the front axle, 1 at all frequencies."""
        y = 1 / (1j * w)
        return np.array([0, 0, kt * y, kt * y * np.exp(-1j * w * (a + b) / V)])

    q = solved(M, C, K, road, OMEGA)
    problem = pr.problem(str(MODELS / "half_car.toml"))
    s = 1j * OMEGA
    late = np.exp(-s * (a + b) / V) / s
    wanted = {
        "seat": s**2 * (q[:, 0] - 0.5 * q[:, 1]),
        "rattle": q @ rear,
        "tyre_force": kt * (q[:, 3] - late),
    }
    for output, z in wanted.items():
        assert response(problem, f"c={c}", output) == pytest.approx(z, rel=1e-9, abs=1e-12 * np.abs(z).max())
    poles = np.linalg.eigvals(
        np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    )
    least = 100 * (-poles.real / np.abs(poles)).min()
    assert pr.evaluate(problem, f"c={c}").metrics["damping"].value == pytest.approx(least, rel=1e-9)


def test_the_places_of_a_half_car():
    rear = pr.problem(str(MODELS / "half_car.toml:comfort"))
    for name in ("rear", "secondary"):
        assert pr.problem(str(MODELS / "half_car.toml"), at=name).vehicle == rear.vehicle
    front = pr.problem(str(MODELS / "half_car.toml"), at="front")
    a, b = pr.evaluate(front, "c=1300").metrics, pr.evaluate(rear, "c=1200").metrics
    for metric in ("comfort", "travel", "contact", "damping"):
        assert a[metric].value == pytest.approx(b[metric].value, rel=1e-9)
    contact = pr.problem(str(MODELS / "half_car.toml:contact"))
    assert (contact.objective, dict(contact.at_most)) == ("contact", {"comfort": 1.1})


def test_other_studies_leave_the_other_place_as_it_is():
    """Vehicles drawn within tolerances, whose other place holds its default."""
    problem = pr.problem(str(MODELS / "half_car.toml:contact"))
    drawn = pr.tolerance(problem, "c=1200", tolerance=0.1, draws=5, vehicle="0")
    nominal = pr.evaluate(problem, "c=1200").metrics["comfort"].value
    assert drawn.to_dict()["metrics"]["comfort"]["nominal"] == pytest.approx(nominal, rel=1e-9)


def test_a_static_stiffness_is_of_the_static_spring():
    assert pr.problem(str(MODELS / "quarter_car.toml"), stiffness=2e4).vehicle.k == 2e4
    with pytest.raises(pr.BadInput, match=r"static spring is k"):
        pr.problem(str(MODELS / "building.toml"), stiffness=2e4)


def test_a_lower_limit_on_damping_is_kept():
    """A limit of a metric that is better for being more is one from below."""
    page = str(MODELS / "half_car.toml:contact")
    free = pr.problem(page, objective="comfort")
    problem = pr.problem(page, objective="comfort", limits={"damping": 17.0})
    assert [c.sense for c in problem.constraints if c.metric == "damping"] == [">="]
    assert pr.search(free, 1).best.metrics["damping"].value < 17.0
    found = pr.search(problem, 1).best
    assert found.metrics["damping"].value == pytest.approx(17.0, rel=1e-3)  # it binds
    found.check()


def test_building_in_an_earthquake():
    n, m, k, zeta, w0, wg, zg = 5, 100e3, 150e6, 0.02, 11.0, 15.0, 0.6
    T = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    T[-1, -1] = 1.0
    c = 2 * zeta * k / w0
    brace = np.array([-1.0, 1, 0, 0, 0])
    C = c * T + 1e6 * np.outer(brace, brace)
    H = (2 * zg * wg * 1j * OMEGA + wg**2) / (-(OMEGA**2) + 2 * zg * wg * 1j * OMEGA + wg**2)
    relative = solved(m * np.eye(n), C, k * T, lambda w: -m * np.ones(n), OMEGA) * H[:, None]
    problem = pr.problem(str(MODELS / "building.toml"))
    wanted = {
        "roof": relative[:, -1],
        "drift": relative[:, 0],
        "top": -(OMEGA**2) * relative[:, -1] + H,
        "base": (k + 1j * OMEGA * c) * relative[:, 0],
    }
    for output, z in wanted.items():
        assert response(problem, "c=1e6", output) == pytest.approx(z, rel=1e-9)


def test_cable_with_a_damper():
    """The first mode's damping is close to x/L · κ'/(1 + κ'²), κ' = π² κ, κ = c/(m L ω₁) · x/L.

    Pacheco, Fujino and Sulekh, J. Struct. Eng. 119 (1993); Krenk, J. Appl. Mech. 67 (2000). The damper stands at
    x = L/20, and what is left out of the formula is of the order x/L.
    """
    problem = pr.problem(str(MODELS / "cable.toml"))
    T, L, mass, x = 2.5e6, 100.0, 60.0, 0.05
    first = np.pi / L * np.sqrt(T / mass)
    for kappa in (0.3, 1.0, 2.0):
        c = kappa / np.pi**2 * mass * L * first / x
        loop = close(problem.plant, {"secondary": state_space(pr.Rational.damper(c))})
        poles = loop.poles()
        lowest = poles[np.argmin(np.where(np.abs(poles.imag) > 1, np.abs(np.abs(poles) - first), np.inf))]
        assert -lowest.real / abs(lowest) == pytest.approx(x * kappa / (1 + kappa**2), rel=0.12)
    assert pr.evaluate(problem, "c=2e4").metrics["damping"].at.startswith("at 13 Hz")


def test_two_winds_add_as_strangers_do(tmp_path):
    """Their mean squares add: processes of their own."""
    problem = pr.problem(str(MODELS / "cable.toml"))
    assert problem.plant.processes == (0, 1)
    alone = []
    for other in ("wind1", "wind2"):
        lines = (MODELS / "cable.toml").read_text().splitlines()
        page = tmp_path / f"without_{other}.toml"
        page.write_text("\n".join(line for line in lines if not line.startswith(other)))
        alone.append(pr.evaluate(str(page), "c=4e4").metrics["midspan"].value)
    assert pr.evaluate(problem, "c=4e4").metrics["midspan"].value == pytest.approx(np.hypot(*alone), rel=1e-9)


@pytest.mark.parametrize("path", sorted(MODELS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_example_is_a_problem_with_parameters_that_say_what_they_are(path):
    model = vehicle(str(path))
    assert pr.problem(str(path)).metrics(pr.problem(str(path)).port(pr.Rational.damper(2e3)))
    assert all(one.meaning for one in model.model.parameters)
